"""What there is so far of a recording that is being written, also by another process."""

import time
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from irtiming.archive import layout, reader
from irtiming.archive.contents import Checked, checked
from irtiming.archive.fields import read_field
from irtiming.archive.finding import Complaint, refuse
from irtiming.archive.hdf5_file import opened
from irtiming.archive.live.unfinished import NOT_FINISHED, frames_there, part_of
from irtiming.errors import ArchiveError
from irtiming.records.recording import Recording

if TYPE_CHECKING:
    from irtiming.archive.consistency import Contents

_TRIES = 4
_PAUSE_S = 0.05


def read_so_far(path: str | Path) -> Recording:
    """Recording as far as it is in a file that is being written, or was when its writer was killed.

    Later frames do not show: a recording that has been read stays as it is. What it says of its ``ending`` is empty while
    it has none, and it has no checksum. Frames are left out as `reader.read` does, and so are the last ones, of whose
    triggers there is no timestamp yet.

    Parameters
    ----------
    path
        Name that the finished file will have, or that with ``.part``. A finished recording is read as it is.

    Returns
    -------
    The recording; ``frames`` opens the file anew for each pass, also when it has been finished meanwhile.

    Raises
    ------
    ArchiveError
        If there is no such file, or it has no whole frame or no turn of the wheel yet.
    """
    part = Path(path) if str(path).endswith(layout.PART) else part_of(path)
    for left in reversed(range(_TRIES)):
        if not part.exists():
            return reader.read(part.with_suffix(""))
        try:
            with opened(part, is_growing=True) as file:
                found = _so_far(file)
            return reader.recording_of(part, found, is_growing=True)
        except (Complaint, ArchiveError) as error:
            if left == 0:
                raise error.as_error(part) if isinstance(error, Complaint) else error from error
            time.sleep(_PAUSE_S)  # the writer was in the middle of something
    raise ArchiveError(f"{part}: cannot be read")


def _so_far(file: h5py.File) -> Checked:
    """Checked contents of the frames that are there with their triggers."""
    contents: Contents = {}
    n_frames = frames_there(file)  # first: what a frame needs is in the file before the frame is counted
    for field in layout.FIELDS:
        contents[field] = None if field is layout.FRAMES else read_field(file, field)
    event = contents[layout.FRAME_EVENT] or "trigger"
    edges = layout.CAMERA_INPUT if event == "strobe" else layout.CAMERA_TRIGGER
    is_edge = event in ("strobe", "trigger")
    n_timed = (
        int(np.searchsorted(contents[layout.FRAME_NUMBER][:n_frames], contents[edges].size)) if is_edge else n_frames
    )
    if n_timed == 0:
        raise refuse(
            "",
            "has no frame with a timestamp of its trigger yet",
            code="no-timed-frame-yet",
            cure="wait for the first ones",
        )
    for field in (layout.FRAME_STATUS, *layout.PER_FRAME):
        contents[field] = contents[field][:n_timed]
    contents[layout.FRAMES] = (n_timed, *file[layout.FRAMES.path].shape[1:])
    if contents[layout.ENDING] == NOT_FINISHED:
        contents[layout.ENDING] = None
    return checked(file, contents)
