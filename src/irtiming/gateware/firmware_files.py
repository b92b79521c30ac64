"""The firmware that makes a trigger generator of an RP2040 or RP2350: MicroPython files, handed out as they are."""

from pathlib import Path

from irtiming.errors import GatewareError

_SOURCE = Path(__file__).parent / "microcontroller"
_KINDS = (".md", ".pio", ".py")


def firmware_files() -> dict[str, str]:
    """Text of each file by its name, README first."""
    found = sorted(path for path in _SOURCE.iterdir() if path.suffix in _KINDS)
    return {path.name: path.read_text(encoding="utf-8") for path in found}


def write_firmware(folder: Path) -> tuple[Path, ...]:
    """Put all files of the firmware into a folder, which is made if it is not there.

    Parameters
    ----------
    folder
        Files of other names in it are left alone.

    Returns
    -------
    What is there now.

    Raises
    ------
    GatewareError
        If a file of the same name says something else (somebody's pins, perhaps), or the folder cannot be written to.
    """
    texts = firmware_files()
    for name, text in texts.items():
        there = folder / name
        if there.exists() and (there.is_dir() or there.read_bytes() != text.encode()):
            raise GatewareError(
                f"{there}: is there and differs; it may hold your pins: name a new folder, or move it away"
            )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (folder / name).write_bytes(text.encode())
    except OSError as error:
        raise GatewareError(
            f"{folder}: the firmware cannot be written there ({error.strerror or error}); name another folder"
        ) from error
    return tuple(folder / name for name in texts)
