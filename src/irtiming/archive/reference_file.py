"""Non-uniformity references by themselves: frames of the bare blackbody, before they join the recordings that they serve."""

from pathlib import Path

import numpy as np

from irtiming.archive import layout
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.archive.hdf5_output import whole_hdf5
from irtiming.archive.nexus import create_stack, set_temperature
from irtiming.archive.npz_file import read_arrays
from irtiming.archive.reader import nonuniformity_of, read
from irtiming.archive.whole_file import whole_file
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Pixels
from irtiming.records.recording import NonuniformityReference

_NAMES = ("low", "high", "low_temperature_k", "high_temperature_k")


def write_reference(reference: NonuniformityReference, path: str | Path) -> None:
    """Write raw frames and temperatures as ``.npz``, whole or not at all; nothing is overwritten.

    Raises
    ------
    ArchiveError
        If the file exists or cannot be written, or the reference has no raw frames.
    """
    target = Path(path)
    if target.exists():
        raise ArchiveError(f"{target}: exists already; move it away to record the references again")
    low, high = _raw(reference, target)
    with whole_file(target) as part, part.open("wb") as file:
        np.savez(
            file,
            low=low,
            high=high,
            low_temperature_k=np.float64(reference.low_temperature_k or np.nan),
            high_temperature_k=np.float64(reference.high_temperature_k or np.nan),
        )


def read_reference(path: str | Path) -> NonuniformityReference:
    """References that `write_reference` wrote, or those in a recording.

    Raises
    ------
    ArchiveError
        If the file cannot be read or holds none.
    """
    source = Path(path)
    if source.suffix != ".npz":
        found = read(source).nonuniformity
        if found is None:
            raise ArchiveError(f"{source}: holds no non-uniformity reference; name a recording that does")
        return found
    arrays = read_arrays(source, _NAMES)
    low, high, *both_k = (arrays.get(name, np.empty(0)) for name in _NAMES)
    if not all(frames.dtype == np.uint16 and frames.ndim == 3 and frames.size for frames in (low, high)):
        raise ArchiveError(f"{source}: 'low' and 'high' must be frames, uint16 (frame, row, column); record them again")
    if low.shape[1:] != high.shape[1:] or not all(one.size == 1 and one.dtype.kind == "f" for one in both_k):
        raise ArchiveError(
            f"{source}: holds stacks of two sizes, or temperatures that are no numbers; record them again"
        )
    low_k, high_k = (float(one.reshape(())) for one in both_k)
    return nonuniformity_of(ArrayFrames(low), ArrayFrames(high), low_k=low_k, high_k=high_k)


def add_reference(reference: NonuniformityReference, path: str | Path) -> None:
    """Put references into a finished recording that has none; the file is whole before and after, whatever happens between.

    Raises
    ------
    ArchiveError
        If the recording cannot be read or written, or has references already.
    """
    target = Path(path)
    low, high = _raw(reference, target)
    with whole_hdf5(target, copy_of=target) as file:
        if layout.REFERENCE in file:
            raise ArchiveError(f"{target}: has non-uniformity references already; nothing was added")
        for field, frames, temperature_k in (
            (layout.REFERENCE_LOW, low, reference.low_temperature_k),
            (layout.REFERENCE_HIGH, high, reference.high_temperature_k),
        ):
            dataset = create_stack(file, field, size=(frames.shape[1], frames.shape[2]))
            dataset.resize(len(frames), axis=0)
            dataset[:] = frames
            set_temperature(file, field, temperature_k=temperature_k)


def _raw(reference: NonuniformityReference, path: Path) -> tuple[Pixels, Pixels]:
    if reference.low_frames is None or reference.high_frames is None:
        raise ArchiveError(f"{path}: a reference without its raw frames cannot be stored; record it again")
    low, high = (stack.pick(list(range(stack.shape[0]))) for stack in (reference.low_frames, reference.high_frames))
    return low, high
