"""A folder with one file for each frame, or for some frames each: all of one size, in the order of the numbers in their names.

With one frame in each file these numbers are what the camera counted: a file that is missing is a frame that is missing.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from irtiming.archive.frames.bounds import MOST_FRAMES, require_size
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames, FrameSource, FrameValues, Read
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Ticks, read_only

_SUFFIXES = (".tif", ".tiff", ".png", ".pgm", ".npy", ".fff", ".irb", ".fits", ".hcc", ".seq", ".ptw")
_MOST_DIGITS = 18  # of a number of 64 bits
_SAME = ("integration_time_s", "camera", "frame_period_s")


def _files(path: Path) -> list[Path]:
    """Those that can be frames, by the numbers in their names: frame2 stands before frame10."""
    found = [one for one in path.iterdir() if one.suffix.lower() in _SUFFIXES and one.is_file()]
    kinds = {one.suffix.lower() for one in found}
    if len(kinds) > 1:
        raise ArchiveError(f"holds files of {', '.join(sorted(kinds))}; keep those of one kind", where=str(path))
    return sorted(found, key=lambda one: _order(one.name))


def _parts(name: str) -> list[str]:
    """What stands between numbers, and the numbers in every second place."""
    return re.split(r"([0-9]+)", name)


def _order(name: str) -> list[tuple[int, str]]:
    """What stands between numbers as text, numbers by their size: those of more digits are larger."""
    return [(len(part.lstrip("0")), part.lstrip("0")) if k % 2 else (0, part) for k, part in enumerate(_parts(name))]


def _numbers(path: Path, files: list[Path]) -> Ticks | None:
    """Number of each file, shape (n_file,), where one number counts them; None where none changes between names, or several do.

    It counts them where half of the steps or more are by one: a time in the name goes up by more.
    """
    parts = [_parts(one.name) for one in files]
    if len({len(one) for one in parts}) > 1:
        return None
    changing = [place for place, words in enumerate(zip(*parts, strict=True)) if len(set(words)) > 1]
    if len(changing) != 1 or changing[0] % 2 == 0 or max(len(one[changing[0]]) for one in parts) > _MOST_DIGITS:
        return None
    found = np.array([int(one[changing[0]]) for one in parts], dtype=np.int64)
    steps = np.diff(found)
    if steps.min() < 1:
        at = int(np.argmin(steps))
        raise ArchiveError(
            f"has two files with one number, {files[at].name} and {files[at + 1].name}; take one of them away",
            where=str(path),
        )
    return read_only(found) if 2 * np.count_nonzero(steps == 1) >= steps.size else None


def _open(path: Path) -> FrameSource:
    from irtiming.archive.frames.opening import open_frames

    files = _files(path)
    if not files:
        raise ArchiveError(
            f"is a folder without files of frames ({', '.join(_SUFFIXES)}); name another", where=str(path)
        )
    if len(files) > MOST_FRAMES:
        raise ArchiveError(f"has {len(files)} files; there may be {MOST_FRAMES}", where=str(path))
    each = [open_frames(one).facts for one in files]
    for one, facts in zip(files, each, strict=True):
        if (*facts.shape[1:], facts.dtype) != (*each[0].shape[1:], each[0].dtype):
            says = f"frames of {facts.rows} x {facts.columns} pixels of {facts.dtype}"
            first = f"{each[0].rows} x {each[0].columns} of {each[0].dtype}"
            raise ArchiveError(f"has {says}, {files[0].name} {first}; keep files of one size", where=str(one))
    begins = np.cumsum([0, *(facts.frames for facts in each)])
    facts = _of_all(each, n_frames=int(begins[-1]))
    if facts.frame_id is None and facts.frames == len(files):
        facts = replace(facts, frame_id=_numbers(path, files))
    require_size(path, frames=facts.frames, rows=facts.rows, columns=facts.columns, dtype=facts.dtype)

    @contextmanager
    def reading() -> Iterator[Read]:
        def read(first: int, count: int) -> FrameValues:
            block = np.empty((count, facts.rows, facts.columns), facts.dtype)
            done = 0
            while done < count:
                place = int(np.searchsorted(begins, first + done, side="right")) - 1
                inside = first + done - int(begins[place])
                n = min(count - done, each[place].frames - inside)
                block[done : done + n] = open_frames(files[place]).pick(list(range(inside, inside + n)))
                done += n
            return block

        yield read

    return Frames(path, facts, reading)


def _of_all(each: list[FrameFacts], *, n_frames: int) -> FrameFacts:
    """What holds for all files: times one after the other, and of the rest what all say alike."""
    first = each[0]
    changed: dict[str, Any] = {
        name: None for name in _SAME if any(getattr(e, name) != getattr(first, name) for e in each)
    }
    for name in ("times_s", "trigger_times_s", "frame_id"):
        found = [getattr(facts, name) for facts in each]
        changed[name] = None if any(one is None for one in found) else read_only(np.concatenate(found))
    if changed["times_s"] is None or any(facts.time_scale != first.time_scale for facts in each):
        changed |= {"times_s": None, "time_scale": "", "time_step_s": None}
    return replace(first, format=f"a folder of {len(each)} files, each {first.format}", frames=n_frames, **changed)


READER = FrameReader(
    title="a folder of pictures", takes=lambda path, _: path.is_dir(), open=_open, beside=lambda path: path.iterdir()
)
