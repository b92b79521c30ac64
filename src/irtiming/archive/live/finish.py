"""From a recording in progress to a finished file: last words in it, checked as the reader does, on the disk, under its name."""

from pathlib import Path

import h5py
import numpy as np

from irtiming.archive import layout
from irtiming.archive.contents import checked, read_contents
from irtiming.archive.finding import refuse
from irtiming.archive.frame_status import with_untimed
from irtiming.archive.hdf5_file import opened
from irtiming.archive.live.growing_file import EXCHANGES, set_ending
from irtiming.archive.nexus import bring_to_disk
from irtiming.archive.whole_file import place_of
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Ticks


def conclude(file: h5py.File, *, ending: str, frame_number: Ticks | None = None) -> None:
    """Write what is known at the end into an open file; only what has its place there already is altered.

    Parameters
    ----------
    file
        A recording in progress.
    ending
        `layout.COMPLETE`, or why it ended early.
    frame_number
        Index of the trigger of each frame, shape (n_frame,), where it is not what the file says.

    Raises
    ------
    Complaint
        If ``frame_number`` cannot be right.
    """
    if ending != layout.COMPLETE:
        set_ending(file, ending)  # first: on a full disk the rest may fail
    numbers = file[layout.FRAME_NUMBER.path]
    if frame_number is not None:
        _require_numbers(frame_number, n_frames=len(numbers))
        if len(numbers):
            numbers[:] = frame_number
    column = file[layout.FRAME_STATUS.path]
    n_triggers = len(file[layout.CAMERA_TRIGGER.path])
    _forget_unread_clocks(file)
    if len(column) and layout.FRAME_EVENT.path not in file:
        column[:] = with_untimed(column[()].astype(np.int64), numbers[()], n_triggers=n_triggers)
    file.flush()
    if ending == layout.COMPLETE:
        set_ending(file, ending)


def _forget_unread_clocks(file: h5py.File) -> None:
    """A clock that was never read, or not to the end, leaves columns of one length; those without entries say nothing."""
    for fields in EXCHANGES.values():
        if fields[0].path not in file:
            continue
        n_whole = min(len(file[field.path]) for field in fields)
        for field in fields:
            if len(file[field.path]) > n_whole:
                file[field.path].resize(n_whole, axis=0)


def require_free_name(path: Path) -> None:
    """Refuse a name that is taken.

    Raises
    ------
    ArchiveError
        If there is a file, a folder or whatever else of this name, or it is ``-``.
    """
    place_of(path)
    if path.exists():
        raise ArchiveError(f"{path}: exists already; choose another name")


def give_name(finished: Path, path: Path) -> None:
    """Check a closed file as the reader does, whatever its ending says, bring it to the disk, and rename it.

    Raises
    ------
    Complaint
        If the reader would refuse it.
    ArchiveError
        If there is a file of that name.
    OSError
        If it cannot be brought to the disk or renamed.
    """
    with opened(finished) as file:
        checked(file, read_contents(file) | {layout.ENDING: None})
    bring_to_disk(finished)
    require_free_name(path)
    finished.replace(path)


def _require_numbers(frame_number: Ticks, *, n_frames: int) -> None:
    steps = np.diff(frame_number)
    if len(frame_number) != n_frames or (steps.size and int(steps.min()) < 1) or (n_frames and frame_number[0] < 0):
        raise refuse(
            layout.FRAME_NUMBER.path,
            f"got {len(frame_number)} corrected numbers for {n_frames} frames",
            code="corrected-number-count",
            cure="give one per frame, rising, from 0",
        )
