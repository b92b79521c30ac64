"""Which frames of a file are whole: the others are left out, as lost frames are."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from irtiming.archive import layout
from irtiming.archive.finding import error_at, warning_at
from irtiming.records.arrays import read_only
from irtiming.records.finding import Finding

if TYPE_CHECKING:
    from irtiming.archive.consistency import Contents
    from irtiming.records.arrays import Ticks

WHOLE, DAMAGED, BLANK, UNTIMED = range(4)
"""Values of the status; a higher one, of a later program, counts as not whole."""

_WORDS = {DAMAGED: "damaged", BLANK: "blank", UNTIMED: "without a timestamp of their trigger"}


def leave_out(contents: "Contents") -> tuple["Contents", "Ticks | None", list[Finding]]:
    """The same contents without the frames that are not whole.

    Parameters
    ----------
    contents
        As the fields say it, frames of any status among them; fields that are None are left out.

    Returns
    -------
    Contents of the whole frames; their indices in the file, shape (n_whole,), or None if all are whole; what is to be said of
    the others.
    """
    shape, status = contents.get(layout.FRAMES), contents.get(layout.FRAME_STATUS)
    findings = list(_lengths(contents))
    if shape is None or status is None or status.size != shape[0]:
        return contents, None, findings
    kept = np.flatnonzero(status == WHOLE)
    if kept.size == status.size:
        return contents, None, findings
    counts = [f"{n} {word}" for value, word in _WORDS.items() if (n := int(np.count_nonzero(status == value)))]
    if unknown := int(np.count_nonzero(status > UNTIMED)):
        counts.append(f"{unknown} of unknown status")
    what = f"lists among {status.size} frames {', '.join(counts)}"
    if kept.size == 0:
        cure = "check the camera and its link, and record again"
        return contents, None, [*findings, error_at(layout.FRAME_STATUS.path, what, code="no-whole-frame", cure=cure)]
    findings.append(
        warning_at(
            layout.FRAME_STATUS.path,
            what,
            code="frames-left-out",
            cure="they are left out; check the link to the camera",
        )
    )
    left = contents | {layout.FRAMES: (kept.size, *shape[1:])}
    if left.get(layout.FRAME_NUMBER) is None:
        left[layout.FRAME_NUMBER] = np.arange(shape[0], dtype=np.int64)
    for field in layout.PER_FRAME:
        column = left.get(field)
        if column is not None and len(column) == shape[0]:
            left[field] = read_only(column[kept])
    return left, read_only(kept), findings


def with_untimed(status: "Ticks", frame_number: "Ticks", *, n_triggers: int) -> "Ticks":
    """Status of each frame, where whole frames for whose trigger there is no timestamp are marked; shapes (n_frame,)."""
    return np.where((status == WHOLE) & (frame_number >= n_triggers), UNTIMED, status)


def _lengths(contents: "Contents") -> Iterator[Finding]:
    shape = contents.get(layout.FRAMES)
    for field in (layout.FRAME_STATUS, *layout.PER_FRAME):
        column = contents.get(field)
        if shape is None or column is None or field is layout.FRAME_NUMBER:
            continue
        if len(column) != shape[0]:
            what = f"has {len(column)} entries for {shape[0]} frames"
            yield error_at(field.path, what, code="per-frame-length", cure="write one per frame")
