"""Projection of every pixel of the region of interest on a wave over the frames: amplitude and phase of its swing."""

from typing import final

import numpy as np

from irtiming.records.arrays import Array, ComplexArray, Mask, Pixels, Ticks
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
    follows
        Shape (n_frame,), true for a frame that was triggered next after the one before; None where it does not matter.
    """

    def __init__(self, wave: ComplexArray, *, shape: tuple[int, int], follows: Mask | None = None) -> None:
        self._wave = wave
        self.pairs = None if follows is None else PairProjection(wave, shape=shape, follows=follows)
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
        if self.pairs is not None:
            self.pairs.add(index, frames)

    def keep(self, index: Ticks) -> None:
        """Take the mean of the wave off the stretch, and add it to the others."""
        if self.pairs is not None:
            self.pairs.keep(index, self._sums)
        self.total += self._sums[0] + 1j * self._sums[1] - self._wave[index].mean() * self._sums[2]
        self.level += self._sums[2]
        self._kept.append(index)
        self.drop()

    def drop(self) -> None:
        """Forget the stretch."""
        self._sums[:] = 0
        if self.pairs is not None:
            self.pairs.drop()


@final
class PairProjection:
    """The same of the frames that followed the one before in a stretch, and of the ones before in their places.

    ``now`` and ``before`` (roi rows, roi columns) are complex, raw DN: sums of one wave, less its mean over these frames in each
    stretch, times the value of a frame, or of the frame before it.

    Parameters
    ----------
    wave, shape, follows
        As of `Projection`.
    """

    def __init__(self, wave: ComplexArray, *, shape: tuple[int, int], follows: Mask) -> None:
        self._wave, self._follows = wave, follows
        self._lone, self._early = np.zeros((3, *shape)), np.zeros((3, *shape))
        self._last: tuple[int, Pixels] | None = None
        self._parts: list[tuple[Ticks, Mask]] = []
        self.now, self.before = np.zeros(shape, complex), np.zeros(shape, complex)

    @property
    def frame_weight(self) -> ComplexArray:
        """Twice the mean over these frames; 0 for a kept frame that did not follow, shape (n,) of kept frames."""
        n = sum(int(follow.sum()) for _, follow in self._parts)
        return np.concatenate([2 / n * self._centred(index, follow) for index, follow in self._parts])

    def add(self, index: Ticks, frames: Pixels) -> None:
        """Take frames in, after those before in the stretch."""
        follow = self._following(index, None if self._last is None else self._last[0])
        if not follow.all():
            self._project(frames[~follow], index[~follow], into=self._lone)
        if self._last is not None and follow[0]:
            self._project(self._last[1][None], index[:1], into=self._early)
        later = follow[1:]
        if later.any():
            self._project(frames[:-1] if later.all() else frames[:-1][later], index[1:][later], into=self._early)
        self._last = int(index[-1]), frames[-1].copy()

    def keep(self, index: Ticks, every: Array) -> None:
        """Add the stretch to the others; ``every`` (3, roi rows, roi columns) are its sums over all of its frames."""
        follow = self._following(index, None)
        mean = self._wave[index][follow].mean() if follow.any() else 0.0
        now = every - self._lone
        self.now += now[0] + 1j * now[1] - mean * now[2]
        self.before += self._early[0] + 1j * self._early[1] - mean * self._early[2]
        self._parts.append((index, follow))

    def drop(self) -> None:
        """Forget the stretch."""
        self._lone[:], self._early[:], self._last = 0, 0, None

    def _following(self, index: Ticks, last: int | None) -> Mask:
        """Which frames followed the one before, ``last`` being before the first."""
        before = np.concatenate([[-2 if last is None else last], index[:-1]])
        return np.asarray(self._follows[index] & (index - before == 1))

    def _centred(self, index: Ticks, follow: Mask) -> ComplexArray:
        wave = self._wave[index]
        return np.where(follow, wave - (wave[follow].mean() if follow.any() else 0.0), 0.0)

    def _project(self, frames: Pixels, index: Ticks, *, into: Array) -> None:
        wave = self._wave[index]
        kernels.add_projection(frames, np.ascontiguousarray(wave.real), np.ascontiguousarray(wave.imag), into)
