"""All fields of a file, checked against each other: what the reader makes a recording of."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import h5py

from irtiming.archive import consistency, layout
from irtiming.archive.fields import near_misses, read_field, read_temperature
from irtiming.archive.finding import Complaint
from irtiming.archive.frame_status import leave_out
from irtiming.archive.hdf5_file import damage_at
from irtiming.records.camera_frame import SIMULATED_VENDOR
from irtiming.records.finding import Finding

if TYPE_CHECKING:
    from irtiming.archive.consistency import Contents
    from irtiming.archive.layout import Field
    from irtiming.records.arrays import Ticks


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Checked:
    """What a sound file says of its whole frames.

    ``stored_shape`` is that of all frames, whole or not; ``kept`` are the indices of the whole ones, None: all of them.
    ``temperatures`` are those of the reference stacks, K. ``findings`` are warnings: they do not stop an analysis.
    ``is_simulated``: the truth of a simulation stands beside the data, or the camera says that it is the simulated one.
    """

    contents: "Contents"
    stored_shape: tuple[int, int, int]
    kept: "Ticks | None"
    temperatures: "dict[Field, float | None]"
    findings: tuple[Finding, ...]
    is_simulated: bool


def read_contents(file: h5py.File) -> "Contents":
    """Value of every field, None where an optional one is absent.

    Raises
    ------
    Complaint
        If a field is not as in the layout.
    """
    return {field: read_field(file, field) for field in layout.FIELDS}


def checked(file: h5py.File, contents: "Contents") -> Checked:
    """The contents of a file, with every check that needs more than one field.

    Raises
    ------
    Complaint
        The first error that is found.
    """
    both = (layout.REFERENCE_LOW, layout.REFERENCE_HIGH)
    temperatures = {field: read_temperature(file, field) if contents[field] else None for field in both}
    whole, kept, findings = leave_out(contents)
    findings += [
        *near_misses(file),
        *consistency.check(whole),
        *consistency.check_temperatures(temperatures),
    ]
    for finding in findings:
        if finding.severity == "error":
            raise Complaint(finding)
    return Checked(
        contents=whole,
        stored_shape=contents[layout.FRAMES],
        kept=kept,
        temperatures=temperatures,
        findings=tuple(finding for finding in findings if finding.severity in ("warning", "doubt")),
        is_simulated=_is_simulated(file, contents),
    )


def _is_simulated(file: h5py.File, contents: "Contents") -> bool:
    """What says so is written by this program alone."""
    with damage_at(layout.TRUTH):
        return layout.TRUTH in file or contents[layout.CAMERA_VENDOR] == SIMULATED_VENDOR
