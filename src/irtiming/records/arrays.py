"""The array types that records hold, and how they are frozen."""

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
"""Real numbers, SI units; shape and unit stand in the docstring that uses it."""

ComplexArray: TypeAlias = npt.NDArray[np.complexfloating[Any, Any]]
"""Amplitude and phase of a harmonic of the wheel angle."""

Ticks: TypeAlias = npt.NDArray[np.int64]
"""Values of one free-running, unwrapped clock counter."""

Pixels: TypeAlias = npt.NDArray[np.uint16]
"""Raw detector values; shape (frame, row, column) or (row, column)."""

Mask: TypeAlias = npt.NDArray[np.bool_]
"""True for the pixels or frames that count."""


def read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """View of the same memory, any shape, that cannot be written through."""
    view = array.view()
    view.flags.writeable = False
    return view
