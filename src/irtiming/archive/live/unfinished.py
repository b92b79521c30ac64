"""A recording whose file is not finished: what is in it, and whether it is still being written."""

import os
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from irtiming.archive import layout
from irtiming.archive.fields import as_text
from irtiming.archive.finding import Complaint, refuse
from irtiming.archive.hdf5_file import damage_at, opened
from irtiming.errors import ArchiveError
from irtiming.records.finding import Finding
from irtiming.units import readable_time

NOT_FINISHED = "not finished"
"""What a file says of its ending until it has one."""


def part_of(path: str | Path) -> Path:
    """Name of a recording until it is finished."""
    return Path(f"{path}{layout.PART}")


def unfinished(path: str | Path) -> Finding:
    """Error that says what is in a file that is not finished, and how to finish it; it never raises."""
    part = Path(path)
    try:
        is_in_use = is_claimed(part)
        with opened(part, is_growing=True) as file:
            what = f"is not finished: it has {summary(file)}"
            if is_in_use:
                return refuse(
                    "",
                    f"{what} so far",
                    code="unfinished-in-use",
                    cure="a program is at work on it; wait until it has finished",
                ).finding
            if frames_there(file) == 0:
                return refuse("", what, code="unfinished-without-frames", cure="delete it and record again").finding
    except Complaint as complaint:
        if not part.exists():
            return complaint.finding
        cure = "it was made in one go and cannot be recovered; delete it and make it again"
        return refuse(
            "", f"is not finished and {complaint.finding.what}", code="unfinished-unrecoverable", cure=cure
        ).finding
    return refuse(
        "",
        what,
        code="unfinished",
        cure=f"the program that wrote it was stopped; irtiming recover {shlex.quote(str(part))}",
    ).finding


def summary(file: h5py.File) -> str:
    """Frames, triggers and how much time is in an unfinished file.

    Raises
    ------
    Complaint
        If it cannot be read.
    """
    n_frames = frames_there(file)
    with damage_at(layout.CAMERA_TRIGGER.path):
        triggers = file[layout.CAMERA_TRIGGER.path]
        n_triggers = len(triggers)
        counts = f"{n_frames} frames for {n_triggers} triggers"
        if n_triggers < 2:
            return counts
        past_s = int(triggers[-1] - triggers[0]) / float(file[layout.CLOCK_FREQUENCY.path][()])
    return f"{counts}, the last {readable_time(past_s)} after the first"


def frames_there(file: h5py.File) -> int:
    """Frames of an unfinished file of which everything is there: pixels, number, times and status.

    Raises
    ------
    Complaint
        If it is no file of a recording in progress.
    """
    columns = (layout.FRAME_STATUS, *layout.PER_FRAME, layout.FRAMES)
    with damage_at(layout.FRAME_STATUS.path):
        return min(len(file[field.path]) for field in columns)


def ending_of(file: h5py.File) -> str:
    """What an unfinished file says of its ending; `NOT_FINISHED` if its writer was killed.

    Raises
    ------
    Complaint
        If it is no file of a recording in progress.
    """
    with damage_at(layout.ENDING.path):
        return as_text(file[layout.ENDING.path][()]) or NOT_FINISHED


@contextmanager
def claimed(part: Path) -> Iterator[None]:
    """Show other processes that this one writes the file; the claim goes with the process, however that ends.

    Raises
    ------
    ArchiveError
        If it cannot be claimed.
    """
    descriptor = os.open(part, os.O_RDONLY)
    try:
        if not _lock(descriptor, is_shared=True):
            raise ArchiveError(f"{part}: another program uses it; wait until it has finished")
        yield
    finally:
        os.close(descriptor)


def is_claimed(part: Path) -> bool:
    """Whether a process that still runs writes the file, or reads it at this moment."""
    try:
        descriptor = os.open(part, os.O_RDONLY)
    except OSError:
        return False  # whoever opens it next will say why
    try:
        return not _lock(descriptor, is_shared=False)
    finally:
        os.close(descriptor)


def _lock(descriptor: int, *, is_shared: bool) -> bool:
    from fcntl import LOCK_EX, LOCK_NB, LOCK_SH, flock

    try:
        flock(descriptor, LOCK_NB | (LOCK_SH if is_shared else LOCK_EX))
    except BlockingIOError:
        return False
    return True
