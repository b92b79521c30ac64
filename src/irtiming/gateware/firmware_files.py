"""The firmware that makes a trigger generator of an RP2040 or RP2350: MicroPython files, handed out as they are."""

from pathlib import Path

_SOURCE = Path(__file__).parent / "microcontroller"
_KINDS = (".md", ".pio", ".py")


def firmware_files() -> dict[str, str]:
    """Text of each file by its name, README first."""
    found = sorted(path for path in _SOURCE.iterdir() if path.suffix in _KINDS)
    return {path.name: path.read_text(encoding="utf-8") for path in found}
