"""Delays that scatter from frame to frame: how much, and how much more of it there is than single pixels' noise would make.

A frame that begins later by j shows every row of it later: it leaves -j s, s being the change of the row's light per second of
later exposure. Weighed by the noise sigma of the rows, x = sum s r / sigma^2 has the variance c A + j^2 A^2 with A = sum s^2 /
sigma^2, c being 1 where sigma is right. Frames that are neighbours along the wheel angle show nearly the same; their differences
are rid of what the model misses there.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.estimate import frame_residuals, harmonic_data
from irtiming.estimate.harmonic_data import packed
from irtiming.records.arrays import Array
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.finding import Finding
from irtiming.records.reduced import ReducedRecording
from irtiming.records.result import DelayScatter
from irtiming.records.row_timing import RowTimingFit

_OVERLAP = 1.5  # variance of a mean square of differences of neighbours, over that of as many independent ones
_ROUNDS = 20


def scatter(reduced: ReducedRecording, fit: EdgeDelayFit | RowTimingFit) -> DelayScatter:
    """Of the delay in one recording.

    Parameters
    ----------
    reduced, fit
        The recording, and its fit.
    """
    frames = frame_residuals.of_fit(reduced, fit)
    if not np.any(frames.residual):  # of frames that are made up
        return DelayScatter(variance_s2=0.0, u_s2=0.0)
    moved = _moved(frames.angle_rad, frames.residual, frames.slope, noise=frames.noise)
    square, columns = moved.x**2 / moved.a, np.stack([np.ones(moved.a.size), moved.a], axis=1)
    expected = np.full(square.size, square.mean())
    for _ in range(_ROUNDS):  # the variance of a square is twice its square
        weighted = columns / expected[:, None]
        covariance = np.linalg.inv(weighted.T @ weighted)
        found = covariance @ (weighted.T @ (square / expected))
        expected = np.maximum(columns @ found, 0.1 * expected)
    return DelayScatter(variance_s2=float(found[1]), u_s2=float(np.sqrt(2 * _OVERLAP * covariance[1, 1])))


def excess(found: DelayScatter, fit: RowTimingFit, *, noise: Array) -> float:
    """Variance with which whole frames are moved, over what noise of single pixels makes of it.

    1 where the delay scatters by no more than chance.

    Parameters
    ----------
    found, fit
        Of a recording.
    noise
        Of the pixels in each row's opening fraction, shape (n_row,).
    """
    if not found.is_sure:
        return 1.0
    order = 1j * np.arange(fit.harmonics.shape[1])
    waves = harmonic_data.basis(fit.wheel_angle_rad, n_harmonics=order.size - 1)
    slope = (packed(order * fit.harmonics) @ waves).T * fit.angular_frequency_rad_per_s
    a = np.sum((slope / noise) ** 2, axis=1)
    return 1 + found.variance_s2 * float(np.sum(a**2) / np.sum(a))


def of_all(recordings: Sequence[ReducedRecording], fits: Sequence[EdgeDelayFit | RowTimingFit]) -> DelayScatter:
    """Of the delay in all recordings, each by what it says.

    Parameters
    ----------
    recordings, fits
        One fit per recording.
    """
    found = [scatter(one, fit) for one, fit in zip(recordings, fits, strict=True)]
    weight = np.array([one.u_s2**-2 for one in found])
    mean_s2 = weight @ [one.variance_s2 for one in found] / weight.sum()
    return DelayScatter(variance_s2=float(mean_s2), u_s2=float(weight.sum() ** -0.5))


def findings(found: DelayScatter) -> tuple[Finding, ...]:
    """A warning where the delay scatters from frame to frame by more than chance."""
    if not found.is_sure:
        return ()
    return (
        Finding(
            code="delay-scatters",
            severity="warning",
            what=f"the delay scatters from frame to frame with a standard deviation of {1e6 * found.standard_deviation_s:.3g} µs "
            f"(u = {1e6 * found.u_s:.2g} µs); the result is that of the mean frame",
            cure="a single frame is exposed earlier or later by as much; see whether the camera waits for a clock of its own, or "
            "whether software makes its triggers",
        ),
    )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Moved:
    """What says of each pair of neighbours along the angle that they are moved against each other, shapes (n - 1,)."""

    x: Array
    a: Array


def _moved(angle: Array, residual: Array, slope: Array, *, noise: Array) -> _Moved:
    order = np.argsort(angle)
    apart = np.diff(residual[order], axis=0) / np.sqrt(2)
    rise = (slope[order][1:] + slope[order][:-1]) / 2
    a = np.sum((rise / noise) ** 2, axis=1)
    return _Moved(x=np.sum(rise * apart / noise**2, axis=1), a=np.maximum(a, np.finfo(float).tiny))
