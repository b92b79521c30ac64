"""Frames that are looked at before the single pass: some hundred, all over the recording."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics import robust
from irtiming.records.arrays import Array, Mask, Pixels
from irtiming.records.recording import Recording
from irtiming.reduce import kernels, row_bands
from irtiming.reduce.nonuniformity import Correction, corrected
from irtiming.reduce.opening import dead_rows

_MOST = 240
_MOST_BYTES = 2**27
_FEWEST = 24
_ALIVE_SHARE = 0.5
_COARSE = 3  # every third pixel tells whether a frame is blank
_RIM_PX = 2  # of the image: the opening does not reach it
_ODD = 8.0  # standard deviations of a band's level
_LEAST_ODD = 0.5  # of the standard deviation of a frame's values


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SampleFrames:
    """Frames that were looked at, in the order of the recording.

    ``raw`` (frame, row, column) as recorded, ``values`` the same corrected for non-uniformity, in whole DN, dead rows from those
    beside them; shapes (frame,):
    ``wheel_angle_rad``; ``place`` in the recording from 0 to 1; ``common_dn``, a level that all pixels share.
    """

    raw: Pixels
    values: Pixels
    wheel_angle_rad: Array
    place: Array
    common_dn: Array

    def level(self, area: Mask) -> Array:
        """Mean level of the pixels in the area over the common level, shape (frame,), DN."""
        return mean_within(self.values, area) - self.common_dn

    @property
    def is_whole(self) -> Mask:
        """Frames of which no band of rows shows something else beside the opening, shape (frame,).

        A shutter may be closed while a part of the rows is read, and rows get lost.
        """
        n_rows = self.values.shape[1]
        beside = np.concatenate([self.values[:, :, :_RIM_PX], self.values[:, :, -_RIM_PX:]], axis=2).mean(axis=2)
        starts = row_bands.starts(n_rows)
        level = np.add.reduceat(beside, starts, axis=1) / np.diff([*starts, n_rows]) - self.common_dn[:, None]
        off = np.abs(level - np.median(level, axis=0))
        usual = robust.OF_NORMAL * np.median(off, axis=0)
        least = _LEAST_ODD * float(np.median([frame.std() for frame in self.values]))  # one by one: it takes floats
        return np.asarray(np.all(off <= np.maximum(_ODD * usual, least), axis=1))


def indices(shape: tuple[int, int, int]) -> list[int]:
    """Frames to look at: one of each of many equal parts of the recording, drawn at random.

    Any rule could fall in step with some wheel. ``shape`` is the number of frames, rows and columns; 240 frames or 128 MB at
    most.
    """
    n, n_frames = _number(shape), shape[0]
    place = np.arange(n) + np.random.default_rng(0).random(n)
    return [int(i) for i in place * n_frames / n] if n < n_frames else list(range(n_frames))


def look(recording: Recording, wheel_angle_rad: Array, *, correct: Correction) -> SampleFrames:
    """Look at frames all over the recording, without blank ones and without those of unknown wheel angle.

    The common level is the median of the image's rim.

    Parameters
    ----------
    recording, correct
        Some of its frames are read, and corrected.
    wheel_angle_rad
        Shape (n_frame,); nan where unknown.

    Raises
    ------
    ReductionError
        If most frames have no known angle or are blank, or all are equal.
    """
    n_frames = recording.frames.shape[0]
    drawn = np.array(indices(recording.frames.shape))
    picked = drawn[np.isfinite(wheel_angle_rad[drawn])]
    if picked.size < max(_FEWEST, _ALIVE_SHARE * drawn.size):
        raise ReductionError(
            f"{recording.name}: {picked.size} of {drawn.size} sample frames were triggered while control slots were recorded, "
            "at least half must be; triggers and slots must be values of the same counter over the same time"
        )
    raw = recording.frames.pick([int(i) for i in picked])
    alive = np.array([frame.min() < frame.max() for frame in raw[:, ::_COARSE, ::_COARSE]])
    if alive.mean() < _ALIVE_SHARE:
        raise ReductionError(
            f"{recording.name}: {np.sum(~alive)} of {alive.size} sample frames are blank (all pixels alike), at most half may "
            "be; check the camera's window and transfer"
        )
    if not alive.all():
        raw, picked = raw[alive], picked[alive]
    if all(np.array_equal(frame, raw[0]) for frame in raw[1:]):  # the second one ends this, but for a frozen camera
        raise ReductionError(
            f"{recording.name}: all {len(raw)} sample frames are equal, pixel by pixel: camera or transfer sent one frame again "
            "and again; check the trigger and that the camera is live, and record again"
        )
    rim = np.ones(raw.shape[1:], bool)
    rim[_RIM_PX:-_RIM_PX, _RIM_PX:-_RIM_PX] = False
    dead = dead_rows.of(correct.bad)
    values = raw if correct.is_none else np.array([_in_whole_dn(frame, correct) for frame in raw])
    values = dead_rows.filled(values, dead)
    common = np.median(values.reshape(len(raw), -1)[:, np.flatnonzero(rim)], axis=1).astype(float)
    return SampleFrames(
        raw=raw, values=values, wheel_angle_rad=wheel_angle_rad[picked], place=picked / n_frames, common_dn=common
    )


def _in_whole_dn(frame: Pixels, correct: Correction) -> Pixels:
    return np.clip(np.rint(corrected(frame, correct)), 0, np.iinfo(np.uint16).max).astype(np.uint16)


def noise_dn(frames: Pixels, still: Mask) -> float:
    """Noise of one pixel from frame to frame, from differences of neighbours over time, DN; 0 where none is still.

    Parameters
    ----------
    frames
        Shape (frame, row, column).
    still
        Pixels that do not follow the wheel, shape (row, column).
    """
    spread = np.diff(frames[:, ::4].astype(np.float32), axis=2).std(axis=0)[still[::4, 1:]]
    return float(np.median(spread)) / np.sqrt(2) if spread.size else 0.0


def mean_within(frames: Pixels, area: Mask) -> Array:
    """Mean of the pixels in the area, shape (frame,), DN."""
    bits = np.where(area, 0xFFFF, 0).astype(np.uint16)
    return np.asarray(kernels.sum_within(frames, bits).sum(axis=1) / max(int(area.sum()), 1))


def _number(shape: tuple[int, int, int]) -> int:
    n_frames, n_rows, n_columns = shape
    return min(n_frames, max(_FEWEST, min(_MOST, _MOST_BYTES // (2 * n_rows * n_columns))))
