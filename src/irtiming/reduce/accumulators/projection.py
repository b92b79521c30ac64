"""Projection of every pixel of the region of interest on a wave over the frames: amplitude and phase of its swing."""

from typing import final

import numpy as np

from irtiming.records.arrays import Array, ComplexArray, Mask, Pixels, Ticks
from irtiming.reduce import device_memory, kernels


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
        self._sums: Array | None = None
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
        self._sums = _projected(frames, self._wave[index], self._sums)
        if self.pairs is not None:
            self.pairs.add(index, frames)

    def keep(self, index: Ticks) -> None:
        """Take the mean of the wave off the stretch, and add it to the others."""
        sums = device_memory.to_host(self._sums)
        if self.pairs is not None:
            self.pairs.keep(index, sums)
        self.total += sums[0] + 1j * sums[1] - self._wave[index].mean() * sums[2]
        self.level += sums[2]
        self._kept.append(index)
        self.drop()

    def drop(self) -> None:
        """Forget the stretch."""
        self._sums = None
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
        self._lone: Array | None = None
        self._early: Array | None = None
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
            self._lone = _projected(device_memory.taken(frames, ~follow), self._wave[index[~follow]], self._lone)
        if self._last is not None and follow[0]:
            self._early = _projected(self._last[1][None, ...], self._wave[index[:1]], self._early)
        later = follow[1:]
        if later.any():
            before = frames[:-1, ...] if later.all() else device_memory.taken(frames[:-1, ...], later)
            self._early = _projected(before, self._wave[index[1:][later]], self._early)
        self._last = int(index[-1]), device_memory.copied(frames[-1, ...])

    def keep(self, index: Ticks, every: Array) -> None:
        """Add the stretch to the others; ``every`` (3, roi rows, roi columns) are its sums over all of its frames."""
        follow = self._following(index, None)
        mean = self._wave[index][follow].mean() if follow.any() else 0.0
        now = every if self._lone is None else every - device_memory.to_host(self._lone)
        early = np.zeros_like(every) if self._early is None else device_memory.to_host(self._early)
        self.now += now[0] + 1j * now[1] - mean * now[2]
        self.before += early[0] + 1j * early[1] - mean * early[2]
        self._parts.append((index, follow))

    def drop(self) -> None:
        """Forget the stretch."""
        self._lone = self._early = self._last = None

    def _following(self, index: Ticks, last: int | None) -> Mask:
        """Which frames followed the one before, ``last`` being before the first."""
        before = np.concatenate([[-2 if last is None else last], index[:-1]])
        return np.asarray(self._follows[index] & (index - before == 1))

    def _centred(self, index: Ticks, follow: Mask) -> ComplexArray:
        wave = self._wave[index]
        return np.where(follow, wave - (wave[follow].mean() if follow.any() else 0.0), 0.0)


def _projected(frames: Pixels, wave: ComplexArray, sums: Array | None) -> Array:
    """Sums so far, where the frames are, and theirs, shape (3, roi rows, roi columns); ``wave`` (frame,)."""
    if sums is None:
        sums = device_memory.zeros((3, *frames.shape[1:]), "float64", beside=frames)
    kernels.add_projection(frames, np.ascontiguousarray(wave.real), np.ascontiguousarray(wave.imag), sums)
    return sums
