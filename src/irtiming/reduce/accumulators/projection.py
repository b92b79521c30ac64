"""Projection of every pixel of the region of interest on a wave over the frames: amplitude and phase of its swing."""

from typing import final

import numpy as np

from irtiming.records.arrays import Array, ComplexArray, Pixels, Ticks
from irtiming.reduce import kernels


@final
class Projection:
    """Sum over the kept frames of a wave, less its mean in each stretch, times the pixel's value.

    So the offsets of a stretch have no part in it. ``total`` (roi rows, roi columns) is complex, raw DN; ``level`` (roi rows, roi
    columns) the sum of the values themselves.

    Parameters
    ----------
    wave
        Shape (n_frame,); value of the wave in each frame.
    shape
        Of the region of interest: rows and columns.
    """

    def __init__(self, wave: ComplexArray, *, shape: tuple[int, int]) -> None:
        self._wave = wave
        self._sums = np.zeros((3, *shape))
        self.total = np.zeros(shape, complex)
        self.level: Array = np.zeros(shape)
        self._kept: list[Ticks] = []

    @property
    def frame_weight(self) -> ComplexArray:
        """Twice the mean over the kept frames, in the order of the recording: weight of each, shape (n,)."""
        n = sum(index.size for index in self._kept)
        parts = [2 / n * self._wave[index] for index in self._kept]
        return np.concatenate([part - part.mean() for part in parts])

    def add(self, index: Ticks, frames: Pixels) -> None:
        """Project some frames of the region of interest, shape (frame, row, column)."""
        wave = self._wave[index]
        kernels.add_projection(frames, np.ascontiguousarray(wave.real), np.ascontiguousarray(wave.imag), self._sums)

    def keep(self, index: Ticks) -> None:
        """Take the mean of the wave off the stretch, and add it to the others."""
        self.total += self._sums[0] + 1j * self._sums[1] - self._wave[index].mean() * self._sums[2]
        self.level += self._sums[2]
        self._kept.append(index)
        self.drop()

    def drop(self) -> None:
        """Forget the stretch."""
        self._sums[:] = 0
