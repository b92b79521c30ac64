r"""Whether the camera averages over time where little changes: a noise filter that knows moving pixels from still ones.

Where the wheel stands before a pixel, or leaves it open, for two frames, such a filter averages them, and their noise is much the
same; where an edge passes between them it lets the pixel through. A filter that takes the same share of the frame before of all
pixels gives both pairs of frames the same correlation, and without a filter neither pair has any: so what tells is the difference

.. math:: \rho_\mathrm{still} - \max(0, \rho_\mathrm{changed}, \rho_\mathrm{apart})

where the last is that of still pixels in frames far apart, which share a level that sways, but no filter's memory.

The noise of a pixel is what it shows beside the mean of its left and right neighbours, less what that is on average at the same
level. Only frames count in which the neighbours are at one of their two levels: no edge is near then. After a change a tenth of
the way may be left, which is the trail of a lag, or a share of the frame before that is too small to be found here.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.physics import robust
from irtiming.records.arrays import Array, Mask, Pixels, Ticks
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording

_STRETCHES, _LENGTH = 4, 60  # of frames that follow each other
_MOST_BYTES = 2**26
_LIVELY, _LIVELIEST = 0.6, 0.995  # of the swing of the liveliest pixels
_MOST_PIXELS = 1500
_ENDS = (0.05, 0.95)  # quantiles of a pixel's values: a swing apart
_NEAR = 0.1  # of the way from one level to the other: a filter that leaves more is not found here
_SETTLED, _WILD = 2.0, 4.0  # times the scatter: as near to a level as its noise is, and no noise any more
_FEWEST = 300  # pairs of either kind, over all pixels
_RARE = 0.02  # of all pairs: where fewer are still, an edge has only just left those pixels, or is about to reach them
_FAR = 12  # frames: a filter that keeps nine tenths of the frame before has forgotten most by then
_APART = 0.35  # levels that sway faster than that, and pixels of unlike gains, make as much as half of it


@final
@dataclass(frozen=True, kw_only=True)
class Correlation:
    """Of the noise of a pixel in two frames that follow each other: where it stays at its level, and where it changes it.

    ``apart`` is that where it stays, of frames that are a dozen apart; 0 where too few pairs of those tell.
    """

    still: float
    changed: float
    apart: float

    @property
    def by_filter(self) -> float:
        """What only a filter makes that knows still pixels."""
        return self.still - max(0.0, self.changed, self.apart)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _AtLevel:
    """Whether a pixel is near a level, or at it to its noise, and its noise there over the usual, shapes (n_frame, n_pixel)."""

    near: Mask
    settled: Mask
    noise: Array


def findings(recording: Recording) -> tuple[Finding, ...]:
    """A doubt where pixels that do not change share their noise from frame to frame, and those that do change do not.

    Parameters
    ----------
    recording
        Some stretches of its frames are read.
    """
    found = correlation(_stretches(recording))
    if found is None or found.by_filter < _APART:
        return ()
    return (
        Finding(
            code="filter-follows-motion",
            severity="doubt",
            recording=recording.name,
            what=f"{found.still:.0%} of the noise of a pixel is that of the frame before where the pixel does not change, "
            f"{max(0.0, found.changed):.0%} where it does: a noise filter in the camera averages frames where little changes; "
            "it delays what changes little and not what changes much: delays and time constant may be off by more than stated",
            cure="switch the camera's noise filters off (temporal, 3D, motion-adaptive, recursive), and record again",
        ),
    )


def _stretches(recording: Recording) -> list[Pixels]:
    """Frames that follow each other, shapes (n, row, column), all over the recording, without any that repeats the one before."""
    n_frames, n_rows, n_columns = recording.frames.shape
    length = min(_LENGTH, n_frames // _STRETCHES, _MOST_BYTES // (2 * n_rows * n_columns * _STRETCHES))
    starts = np.linspace(0, n_frames - length, _STRETCHES).astype(int).tolist() if length > 1 else []
    read = [recording.frames.pick(list(range(start, start + length))) for start in starts]
    return [one[np.append(True, np.any(one[1:] != one[:-1], axis=(1, 2)))] for one in read]


def correlation(stretches: list[Pixels]) -> Correlation | None:
    """Of the noise in frames that follow each other; None where too few pairs of them tell.

    Parameters
    ----------
    stretches
        Shapes (n, row, column); frames within each follow each other.
    """
    if not stretches:
        return None
    frames = np.concatenate(stretches)
    row, column = _inner(frames)
    beside: Array = 0.5 * (frames[:, row, column - 1].astype(np.float64) + frames[:, row, column + 1])
    ends = np.quantile(beside, _ENDS, axis=0) if row.size else np.zeros((2, 0))
    is_high, swing = beside > ends.mean(axis=0), np.ptp(ends, axis=0)
    near = [np.abs(beside - _median(beside, one)) <= _NEAR * swing for one in (~is_high, is_high)]
    told = np.all([one.any(axis=0) for one in near], axis=0)
    own = (frames[:, row, column] - beside)[:, told]
    at_low, at_high = (_at_level(own, beside[:, told], near=one[:, told]) for one in near)
    number = np.repeat(np.arange(len(stretches)), [len(one) for one in stretches])[:, None]
    follows = number[1:] == number[:-1]
    noise = np.where(at_low.near, at_low.noise, at_high.noise)
    changed = (at_low.near[1:] & at_high.settled[:-1]) | (at_high.near[1:] & at_low.settled[:-1])
    pairs = [follows & kind for kind in (_still(at_low, at_high, later=1), changed)]
    n_still, n_changed = (int(one.sum()) for one in pairs)
    if min(n_still, n_changed) < _FEWEST or n_still < _RARE * int(follows.sum()) * noise.shape[1]:
        return None
    shared = [_correlation(noise[1:][one], noise[:-1][one]) for one in pairs]
    far = (number[_FAR:] == number[:-_FAR]) & _still(at_low, at_high, later=_FAR)
    apart = _correlation(noise[_FAR:][far], noise[:-_FAR][far]) if far.sum() >= _FEWEST else 0.0
    return Correlation(still=shared[0], changed=shared[1], apart=apart)


def _still(low: _AtLevel, high: _AtLevel, *, later: int) -> Mask:
    """Whether a pixel is at the level at which it was so many frames before, shape (n_frame - later, n_pixel)."""
    both = [one.settled[later:] & one.settled[:-later] for one in (low, high)]
    return np.asarray(both[0] | both[1])


def _inner(frames: Pixels) -> tuple[Ticks, Ticks]:
    """Rows and columns of pixels of the opening whose left and right neighbours are of it as well, by how much they swing."""
    swing = frames[:: len(frames) // _LENGTH + 1].std(axis=0, dtype=np.float32)
    lively = swing >= _LIVELY * np.quantile(swing, _LIVELIEST)
    row, column = np.nonzero(lively[:, :-2] & lively[:, 1:-1] & lively[:, 2:])
    every = row.size // _MOST_PIXELS + 1
    return row[::every], column[::every] + 1


def _at_level(own: Array, beside: Array, *, near: Mask) -> _AtLevel:
    """Where pixels are at the level that their neighbours, ``beside``, are ``near``; all of shape (n_frame, n_pixel)."""
    off = np.abs(beside - _median(beside, near))
    settled = near & (off <= _SETTLED * robust.OF_NORMAL * _median(off, near))
    noise = own - np.sum(own, axis=0, where=settled) / settled.sum(axis=0)
    usual = robust.spread(noise[settled]) if settled.any() else 0.0
    usual = usual or 1.0
    tame = np.abs(noise) < _WILD * usual
    return _AtLevel(near=near & tame, settled=settled & tame, noise=noise / usual)


def _median(values: Array, among: Mask) -> Array:
    """Of the values of each pixel in some frames, shape (n_pixel,); of the lower half where they are even, nan without any."""
    ordered, n = np.sort(np.where(among, values, np.inf), axis=0), among.sum(axis=0)
    found = np.take_along_axis(ordered, np.maximum(n - 1, 0)[None] // 2, axis=0)[0]
    return np.where(n > 0, found, np.nan)


def _correlation(now: Array, then: Array) -> float:
    """Of two noises about zero, shapes (n,); 0 where there is none."""
    power = float(now @ now) * float(then @ then)
    return float(now @ then) / power**0.5 if power > 0 else 0.0
