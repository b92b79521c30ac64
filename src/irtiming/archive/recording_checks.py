"""The checks of `verify` that need no file, for a recording that is about to be analysed."""

from dataclasses import replace
from typing import TYPE_CHECKING

from irtiming.archive import layout
from irtiming.archive.line_checks import check_lines
from irtiming.archive.tick_checks import check_ticks
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording

if TYPE_CHECKING:
    from irtiming.archive.consistency import Contents


def check_stamps(contents: "Contents") -> list[Finding]:
    """All that ticks and lines say against each other; fields that are None are left out."""
    return [*check_ticks(contents), *check_lines(contents)]


def check_recording(recording: Recording) -> tuple[Finding, ...]:
    """Doubts that timestamps, lines and frame numbers raise about each other, each with the recording's name.

    What `verify` calls an error is a doubt here: what is analysed in spite of it gives a number that may be wrong. Its warnings
    are left to the reduction, which says what it made of lost frames and edges.

    Parameters
    ----------
    recording
        Its frames are not read.
    """
    contents: Contents = {
        field: getattr(recording, field.attribute)
        for field in layout.FIELDS
        if hasattr(recording, field.attribute or " ")
    }
    contents[layout.FRAMES] = recording.frames.shape
    return tuple(
        replace(one, recording=recording.name, severity="doubt")
        for one in check_stamps(contents)
        if one.severity in ("error", "doubt")
    )
