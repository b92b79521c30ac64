"""Waves over the wheel angle times the value of every pixel of the opening: what maps of the timing are made of."""

from typing import final

import numpy as np

from irtiming.inference.one_thread import one_thread
from irtiming.physics import wheel_waves
from irtiming.records.arrays import Array, Mask, Pixels, Ticks
from irtiming.records.pixel_waves import PixelWaves
from irtiming.records.reduced import Opening
from irtiming.reduce import device_memory, kernels
from irtiming.reduce.nonuniformity import Correction
from irtiming.reduce.wheel import nominal_angles
from irtiming.reduce.wheel.frame_angles import FrameAngles

_TOGETHER = 128
"""Frames that are held until they are multiplied: many sums in memory are then touched once for all of them."""


@final
class WavesOfPixels:
    """Sums over the kept frames of waves, less their mean in each stretch, times the value of each pixel.

    Parameters
    ----------
    wheel_angle_rad
        Shape (n_frame,); nan where unknown.
    opening
        Whose summed pixels are taken: in each row all between the first and the last of them.
    n_angles
        Nominal wheel angles per turn, or frames if these are fewer.
    """

    def __init__(self, wheel_angle_rad: Array, opening: Opening, *, n_angles: int) -> None:
        self._angle, self._opening = wheel_angle_rad, opening
        self._signal, self._quiet = wheel_waves.signal_orders(n_angles), wheel_waves.quiet_orders(n_angles)
        known = np.isfinite(wheel_angle_rad)
        every = wheel_waves.waves(
            np.where(known, wheel_angle_rad, 0.0), self._orders, segment=np.zeros(wheel_angle_rad.size, int)
        )
        self._waves = np.concatenate([every, np.ones((1, known.size))]).astype(np.float32)
        self._spans, summed = _spans(opening), opening.summed
        self._row_px = np.concatenate([np.full(end - first, row) for row, first, end in self._spans])
        self._column_px = np.concatenate([np.arange(first, end) for _, first, end in self._spans])
        self._wanted: Mask = summed[self._row_px, self._column_px]
        self._spans[:, 0] -= opening.roi[0]
        self._spans[:, 1:] -= opening.roi[2]
        self._held: Pixels | None = None
        self._of_held: list[Ticks] = []
        self._base: np.ndarray | None = None
        self._sums: np.ndarray | None = None
        self._total = np.zeros((len(self._waves) - 1, self._row_px.size))
        self._kept: list[Ticks] = []

    @property
    def _orders(self) -> Ticks:
        return np.concatenate([self._signal, self._quiet])

    def add(self, index: Ticks, frames: Pixels) -> None:
        """Take frames of the region of interest in, shape (frame, roi rows, roi columns)."""
        if self._held is None:
            self._held = device_memory.zeros((_TOGETHER, self._row_px.size), "uint16", beside=frames)
        done = 0
        while done < index.size:
            n_held = sum(one.size for one in self._of_held)
            more = min(index.size - done, _TOGETHER - n_held)
            kernels.gather(frames[done : done + more, ...], self._spans, self._held[n_held : n_held + more, :])
            self._of_held.append(index[done : done + more])
            done += more
            if n_held + more == _TOGETHER:
                self._multiply()

    def keep(self, index: Ticks) -> None:
        """Take the means of the waves off the stretch, and add it to the others."""
        self._multiply()
        means = self._waves[:-1, index].mean(axis=1, dtype=float)
        sums = device_memory.to_host(self._sums)
        self._total += sums[:-1] - np.multiply.outer(means, sums[-1])
        self._kept.append(index)
        self.drop()

    def drop(self) -> None:
        """Forget the stretch."""
        self._of_held = []
        self._sums = None

    def found(self, *, correct: Correction, drift_dn: Array) -> PixelWaves:
        """The sums of corrected values.

        Parameters
        ----------
        correct
            Of the whole image.
        drift_dn
            Shape (n,); level that is taken off all pixels of each kept frame, corrected DN.
        """
        index = np.concatenate(self._kept)
        segment = np.concatenate([np.full(one.size, k) for k, one in enumerate(self._kept)])
        made = wheel_waves.waves(self._angle[index], self._orders, segment=segment)
        rows, columns = self._row_px[self._wanted], self._column_px[self._wanted]
        raw = self._total[:, self._wanted] * correct.gain[rows, columns]
        return PixelWaves(
            signal_orders=self._signal,
            quiet_orders=self._quiet,
            wheel_angle_rad=self._angle[index],
            segment=segment,
            row_px=rows,
            column_px=columns,
            sums_dn=raw - (made @ drift_dn)[:, None],
        )

    def _multiply(self) -> None:
        if not self._of_held or self._held is None:
            return
        index = np.concatenate(self._of_held)
        held = self._held[: index.size, :]
        if self._base is None:  # sums of small numbers stay exact
            self._base = device_memory.single_precision(held[0, :])
        if self._sums is None:
            self._sums = device_memory.zeros((len(self._waves), self._row_px.size), "float32", beside=held)
        with one_thread():
            kernels.add_waves(held, np.ascontiguousarray(self._waves[:, index]), self._base, self._sums)
        self._of_held = []


def of(angles: FrameAngles, opening: Opening) -> WavesOfPixels:
    """Accumulator for the summed pixels of an opening.

    Parameters
    ----------
    angles, opening
        Of the recording; the opening as it is summed.
    """
    n_angles = min(nominal_angles.samples_per_turn(angles.recording), angles.angle_rad.size)
    return WavesOfPixels(angles.angle_rad, opening, n_angles=n_angles)


def _spans(opening: Opening) -> Ticks:
    """Row, first and end column of the summed pixels of each row that has any, shape (span, 3)."""
    columns = np.arange(opening.summed.shape[1])
    rows = np.flatnonzero(opening.summed.any(axis=1))
    return np.array([(row, *_ends(columns[opening.summed[row]])) for row in rows.tolist()])


def _ends(columns: Ticks) -> tuple[int, int]:
    return int(columns[0]), int(columns[-1]) + 1
