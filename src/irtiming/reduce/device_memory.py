"""In which memory frames are summed: this machine's, or that of a GPU where CuPy finds one.

Who handles frames asks for what they do here; so accumulators are the same for both.
"""

from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Any, Literal

import numpy as np
from array_api_compat import array_namespace

from irtiming.errors import ReductionError
from irtiming.records.arrays import Mask, Pixels
from irtiming.records.choices import Processor


def mover(processor: Processor) -> Callable[[Pixels], Pixels]:
    """What brings frames (frame, row, column) to where they are summed.

    Parameters
    ----------
    processor
        Automatic takes a GPU where there is one.

    Raises
    ------
    ReductionError
        If a GPU is wanted and there is none.
    """
    found = None if processor == "cpu" else gpu()
    if processor == "gpu" and found is None:
        raise ReductionError(
            "a GPU is wanted, and CuPy finds none here: pip install 'irtiming[gpu]' on a machine that has one, or leave "
            "{processor} out",
            "processor",
        )
    return (lambda frames: frames) if found is None else found.asarray


def gpu() -> ModuleType | None:
    """CuPy, where it is installed and finds a GPU."""
    try:
        cupy = import_module("cupy")
        is_there = cupy.cuda.runtime.getDeviceCount() > 0
    except (ImportError, RuntimeError):  # as CuPy's own errors are where there is no driver
        return None
    return cupy if is_there else None


def gpu_name() -> str | None:
    """What the GPU calls itself; None where there is none."""
    cupy = gpu()
    return None if cupy is None else str(cupy.cuda.runtime.getDeviceProperties(0)["name"].decode())


def to_host(values: Any) -> Any:
    """The same values in this machine's memory."""
    return values.get() if hasattr(values, "get") else np.asarray(values)


def taken(frames: Pixels, which: Mask) -> Pixels:
    """Some of the frames, shape (n, row, column); ``which`` is true for each of them, shape (frame,)."""
    xp = array_namespace(frames)
    return xp.take(frames, xp.asarray(np.flatnonzero(which)), axis=0)


def joined(first: Pixels, second: Pixels) -> Pixels:
    """Frames of both, shape (frame, row, column)."""
    return array_namespace(first).concat([first, second])


def copied(frames: Pixels) -> Pixels:
    """The same frames, of any shape, in memory of their own."""
    return array_namespace(frames).asarray(frames, copy=True)


def contiguous(frames: Pixels) -> Pixels:
    """The same frames (frame, row, column), one after the other in memory; on a GPU any order will do."""
    return np.ascontiguousarray(frames) if isinstance(frames, np.ndarray) else frames


def zeros(shape: tuple[int, ...], kind: Literal["uint16", "float32", "float64"], *, beside: Pixels) -> Any:
    """Zeros of a shape, in the memory that some frames are in."""
    xp = array_namespace(beside)
    return xp.zeros(shape, dtype=getattr(xp, kind))


def single_precision(values: Pixels) -> np.ndarray:
    """The same values, of any shape, as float32, where they are."""
    xp = array_namespace(values)
    return xp.astype(values, xp.float32)
