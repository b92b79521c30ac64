"""Frames that are looked at before the single pass: some hundred, all over the recording."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, Mask, Pixels
from irtiming.records.recording import Recording
from irtiming.reduce import kernels

_SCOUTS = 240
_SCOUT_BYTES = 2**27
_FEWEST = 24
_ALIVE_SHARE = 0.5
_COARSE = 3  # every third pixel tells whether a frame is blank
_RIM_PX = 2  # of the image: the opening does not reach it


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Scouts:
    """Frames that were looked at, in the order of the recording.

    ``raw`` (frame, row, column); shapes (frame,): ``wheel_angle_rad``; ``place`` in the recording from 0 to 1; ``common_dn``, a
    level that all pixels share.
    """

    raw: Pixels
    wheel_angle_rad: Array
    place: Array
    common_dn: Array

    def level(self, area: Mask) -> Array:
        """Mean level of the pixels in the area over the common level, shape (frame,), DN."""
        return mean_within(self.raw, area) - self.common_dn


def indices(shape: tuple[int, int, int]) -> list[int]:
    """Frames to look at: one of each of many equal parts of the recording, drawn at random.

    Any rule could fall in step with some wheel. ``shape`` is the number of frames, rows and columns; 240 frames or 128 MB at
    most.
    """
    n, n_frames = _number(shape), shape[0]
    place = np.arange(n) + np.random.default_rng(0).random(n)
    return [int(i) for i in place * n_frames / n] if n < n_frames else list(range(n_frames))


def look(recording: Recording, wheel_angle_rad: Array) -> Scouts:
    """Look at frames all over the recording, without blank ones and without those of unknown wheel angle.

    The common level is the median of the image's rim.

    Parameters
    ----------
    recording
        Some of its frames are read.
    wheel_angle_rad
        Shape (n_frame,); nan where unknown.

    Raises
    ------
    ReductionError
        If most frames have no known angle or are blank.
    """
    n_frames = recording.frames.shape[0]
    drawn = np.array(indices(recording.frames.shape))
    picked = drawn[np.isfinite(wheel_angle_rad[drawn])]
    if picked.size < max(_FEWEST, _ALIVE_SHARE * drawn.size):
        raise ReductionError(
            f"{recording.name}: {picked.size} of {drawn.size} frames looked at were triggered while control slots were recorded, "
            "at least half must be; triggers and slots must be values of the same counter over the same time"
        )
    raw = recording.frames.pick([int(i) for i in picked])
    alive = np.array([frame.min() < frame.max() for frame in raw[:, ::_COARSE, ::_COARSE]])
    if alive.mean() < _ALIVE_SHARE:
        raise ReductionError(
            f"{recording.name}: {np.sum(~alive)} of {alive.size} frames looked at are blank (all pixels alike), at most half may "
            "be; check the camera's window and transfer"
        )
    if not alive.all():
        raw, picked = raw[alive], picked[alive]
    rim = np.ones(raw.shape[1:], bool)
    rim[_RIM_PX:-_RIM_PX, _RIM_PX:-_RIM_PX] = False
    common = np.median(raw.reshape(len(raw), -1)[:, np.flatnonzero(rim)], axis=1).astype(float)
    return Scouts(raw=raw, wheel_angle_rad=wheel_angle_rad[picked], place=picked / n_frames, common_dn=common)


def mean_within(frames: Pixels, area: Mask) -> Array:
    """Mean of the pixels in the area, shape (frame,), DN."""
    bits = np.where(area, 0xFFFF, 0).astype(np.uint16)
    return np.asarray(kernels.sum_within(frames, bits).sum(axis=1) / max(int(area.sum()), 1))


def _number(shape: tuple[int, int, int]) -> int:
    n_frames, n_rows, n_columns = shape
    return min(n_frames, max(_FEWEST, min(_SCOUTS, _SCOUT_BYTES // (2 * n_rows * n_columns))))
