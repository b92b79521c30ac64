"""A finished recording of one that was interrupted: everything that is in the file but what was half written."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np

from irtiming.archive import frame_status, layout
from irtiming.archive.finding import Complaint, archive_error, refuse
from irtiming.archive.hdf5_bounds import require_few_objects
from irtiming.archive.hdf5_file import H5_ERRORS, opened, reason_of
from irtiming.archive.hdf5_output import writing
from irtiming.archive.json_file import require_place
from irtiming.archive.live.finish import conclude, give_name, require_free_name
from irtiming.archive.live.unfinished import NOT_FINISHED, ending_of, frames_there, is_claimed, summary, unfinished
from irtiming.archive.nexus import bring_to_disk, create_stack
from irtiming.errors import ArchiveError


def recover(
    part: str | Path,
    path: str | Path | None = None,
    *,
    keep: bool = False,
    trust: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Make a finished recording of an interrupted one.

    Every frame is read, and one that cannot be is marked as damaged. Nothing is altered in the interrupted file; it
    is removed when the new one is on the disk.

    Parameters
    ----------
    part
        File whose name ends in ``.part``.
    path
        File to make; if None, the same name without ``.part``.
    keep
        Leave the interrupted file there.
    trust
        Take each frame as that of the trigger that it was given when it came: somebody knows that none was missed.
    progress
        Called with frames looked at and all frames.

    Returns
    -------
    The finished file.

    Raises
    ------
    ArchiveError
        If the interrupted file is still being written, cannot be read, or has too little in it for a recording; or the new
        one exists already or cannot be written.
    """
    source = Path(part)
    if path is None and not str(source).endswith(layout.PART):
        raise ArchiveError(f"{source}: is not called NAME{layout.SUFFIX}{layout.PART}; say which file to make (--out)")
    target = source.with_suffix("") if path is None else Path(path)
    require_place(target, "recording", besides=[source], is_text=False)
    require_free_name(target)
    made = target.with_name(f"{target.name}.recovering")
    if is_claimed(source):
        raise archive_error(source, unfinished(source))
    try:
        _make(made, source, trust=trust, progress=progress)
        give_name(made, target)
    except Complaint as complaint:
        raise complaint.as_error(source) from complaint
    except H5_ERRORS as error:
        what = (
            f"cannot be made of {source} ({reason_of(error)}): that is damaged beyond its frames, or the disk is full"
        )
        raise ArchiveError(f"{target}: {what}; copy it anew, or name another disk with --out") from error
    finally:
        made.unlink(missing_ok=True)
    if not keep:
        source.unlink()
    return target


def _make(path: Path, source: Path, *, trust: bool, progress: Callable[[int, int], None] | None) -> None:
    """The finished file under another name."""
    with opened(source, is_growing=True) as file:
        if frames_there(file) == 0:
            raise refuse("", f"has {summary(file)}", code="nothing-to-recover", cure="delete it and record again")
        ending = ending_of(file)
        require_few_objects(file)
        _copy(file, path)
    with writing(path, "r+") as (file, _):
        _mend(file, progress=progress)
        _cut_short(file)
        _forget_unconfirmed(file, ending=ending)
        conclude(file, ending=_last_word(ending, trust=trust))


def _last_word(ending: str, *, trust: bool) -> str:
    """What the file said itself, unless its writer was killed: then a person may know better, also later."""
    if ending not in (NOT_FINISHED, layout.UNPROVEN):
        return ending
    return layout.KILLED if trust else layout.UNPROVEN


def _copy(file: h5py.File, path: Path) -> None:
    """All that is in the file, with the entries of the last frame that are not all there cut off."""
    n_frames = frames_there(file)
    with writing(path) as (copy, _):
        copy.attrs.update(file.attrs)
        try:
            file.copy(layout.ENTRY, copy)
        except H5_ERRORS:  # frames are missing together with the index that would lead to them
            if layout.ENTRY in copy:
                del copy[layout.ENTRY]
            _copy_frame_by_frame(file, copy)
        for field in (layout.FRAMES, layout.FRAME_STATUS, *layout.PER_FRAME):
            copy[field.path].resize(n_frames, axis=0)
    bring_to_disk(path)


def _copy_frame_by_frame(file: h5py.File, copy: h5py.File) -> None:
    """The same where frames cannot be copied as they lie: those that can be read, and all else."""
    frames = file[layout.FRAMES.path]
    made = create_stack(copy, layout.FRAMES, size=frames.shape[1:], dtype=frames.dtype.str)
    made.resize(len(frames), axis=0)
    made.attrs.update(frames.attrs)
    pixels = np.empty((1, *frames.shape[1:]), frames.dtype)
    for index in range(len(frames)):
        with suppress(*H5_ERRORS):
            frames.read_direct(pixels, np.s_[index : index + 1])
            made[index] = pixels[0]
    _copy_group(file[layout.ENTRY], copy.require_group(layout.ENTRY), there={_place(frames): made})


def _copy_group(source: h5py.Group, target: h5py.Group, *, there: dict[int, h5py.HLObject]) -> None:
    """What is in a group, objects that are ``there`` by their place in the file linked, as they may be there under two names."""
    target.attrs.update(source.attrs)
    for name, one in source.items():
        place = _place(one)
        if place in there:
            if name not in target:
                target[name] = there[place]
        elif isinstance(one, h5py.Group):
            there[place] = target.require_group(name)
            _copy_group(one, target[name], there=there)
        else:
            source.copy(name, target)
            there[place] = target[name]


def _place(one: h5py.HLObject) -> int:
    return int(h5py.h5o.get_info(one.id).addr)


def _mend(file: h5py.File, *, progress: Callable[[int, int], None] | None) -> None:
    """Mark each frame that cannot be read, and put a zero frame in its place."""
    frames, status = file[layout.FRAMES.path], file[layout.FRAME_STATUS.path]
    n_frames = len(frames)
    pixels = np.empty((1, *frames.shape[1:]), np.uint16)
    n_stored = frames.id.get_num_chunks()
    for index in range(n_frames):
        try:
            frames.read_direct(pixels, np.s_[index : index + 1])
            is_there = n_stored == n_frames or frames.id.get_chunk_info_by_coord((index, 0, 0)).byte_offset is not None
        except H5_ERRORS:
            is_there = False
        if not is_there:
            frames[index] = np.zeros(frames.shape[1:], np.uint16)
            status[index] = frame_status.DAMAGED
        if progress is not None:
            progress(index + 1, n_frames)


def _cut_short(file: h5py.File) -> None:
    """Ticks end where the file does: what is not there of a stream is read as zeros, to which no counter goes back."""
    for field in layout.FIELDS:
        if field.kind == "ticks" and field.path in file:
            stream = file[field.path]
            if stream.maxshape[0] is None and len(stream) and not stream[-1]:
                stream.resize(int(np.max(np.flatnonzero(stream[()]), initial=-1)) + 1, axis=0)


def _forget_unconfirmed(file: h5py.File, *, ending: str) -> None:
    """An empty list of losses is the trigger generator's word at the end of a run; a killed program never heard it."""
    if ending == NOT_FINISHED and len(file[layout.LOST_AFTER.path]) == 0:
        del file[layout.LOST_AFTER.path]
