"""Numbers put into a rig.toml that a person wrote: its other lines and comments stay as they are."""

import math
import re
from collections.abc import Mapping
from pathlib import Path

from irtiming.archive.rig_file import read_rig
from irtiming.archive.whole_file import whole_file
from irtiming.errors import ArchiveError, IrTimingError
from irtiming.records.rig import Clock, Latency

_HEADING = re.compile(r"^\s*\[")


def clock_lines(clock: Clock) -> dict[str, str]:
    """Keys of the section ``clock`` and their values as TOML."""
    e = clock.relative_error
    return {"relative_error": f"{e.value:.6e}", "relative_error_u": f"{e.standard_uncertainty:.2e}"}


def latency_lines(latency: Latency) -> dict[str, str]:
    """Keys of the section ``latency`` and their values as TOML, microseconds; of those that are known."""
    found = {}
    for name in ("application_gate", "control_gate", "trigger"):
        number = getattr(latency, f"{name}_s")
        if number is not None:
            found[f"{name}_us"] = f"{1e6 * number.value:.4f}"
            found[f"{name}_u_us"] = f"{1e6 * number.standard_uncertainty:.4f}"
    if latency.gates_common_u_s:  # never above what it is a part of
        found["gates_common_u_us"] = f"{math.floor(1e10 * latency.gates_common_u_s) / 1e4:.4f}"
    return found


def section_text(section: str, numbers: Mapping[str, str]) -> str:
    """A section of rig.toml, to be pasted into it."""
    return "\n".join([f"[{section}]", *(f"{key} = {value}" for key, value in numbers.items())])


def update(path: str | Path, section: str, *, numbers: Mapping[str, str]) -> None:
    """Put numbers into a section of rig.toml; a key that is there gets its new value, its comment stays.

    Parameters
    ----------
    path
        Must be a rig.toml that can be read.
    section
        Made at the end of the file where it is not there yet.
    numbers
        Keys and their values as TOML.

    Raises
    ------
    IrTimingError
        If the file cannot be read or written, or is written in a way that this does not understand: it is left as it is then.
    """
    read_rig(path)
    target = Path(path)
    lines = target.read_text(encoding="utf-8").splitlines()
    heading = re.compile(rf"^\s*\[\s*{re.escape(section)}\s*\]\s*(#.*)?$")
    begins = next((index for index, line in enumerate(lines) if heading.match(line)), None)
    if begins is None:
        lines += ([""] if lines and lines[-1].strip() else []) + section_text(section, numbers).splitlines()
    else:
        ends = next((k for k in range(begins + 1, len(lines)) if _HEADING.match(lines[k])), len(lines))
        lines[begins + 1 : ends] = _with(lines[begins + 1 : ends], numbers)
    with whole_file(target) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
        try:
            read_rig(part)
        except IrTimingError as error:
            said = str(error).removeprefix(f"{part}: ")
            raise ArchiveError(f"cannot be changed ({said}); paste the lines yourself", where=str(target)) from error


def _with(lines: list[str], numbers: Mapping[str, str]) -> list[str]:
    """Lines of one section with numbers in the place of theirs, new ones behind the last that is not empty."""
    left = dict(numbers)
    changed = []
    for line in lines:
        match = re.match(r"^(\s*)([\w-]+)(\s*=\s*)([^#]*?)(\s*#.*)?$", line)
        if match is not None and match[2] in left:
            line = f"{match[1]}{match[2]}{match[3]}{left.pop(match[2])}{match[5] or ''}"
        changed.append(line)
    end = max((index + 1 for index, line in enumerate(changed) if line.strip()), default=0)
    changed[end:end] = [f"{key} = {value}" for key, value in left.items()]
    return changed
