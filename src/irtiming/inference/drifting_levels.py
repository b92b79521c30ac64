r"""Levels that drift and jump while something else goes on: how many numbers they need, as the data say.

Values follow :math:`y_n = \mathrm{offset}(t_n) + \mathrm{gain}(t_n) F_n + \sum_j a_j S_{jn}` with known shapes F and S.

Offset and gain are smooth curves over the time (`physics.smooth_curve`), and may jump where a camera corrects itself. Of
straight lines and splines of 1, 2, 4.. intervals, each with the jumps that it needs, the Bayesian information criterion takes the
best: a further number must lower :math:`n \ln D` by :math:`\ln n`, a jump by three times that, its place being a number too.
Huber weights keep single frames from bending a curve.

The best curve by such a criterion is as far from the truth as its noise: what is left of the drift goes into whatever looks like
it, and no covariance has it. Where the curves are not the result, but stand beside one, they are made finer than the best: with
half the interval a cubic spline comes sixteen times as near, and the noise of the further numbers is in the covariance.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.inference import orthonormal
from irtiming.physics import robust, smooth_curve
from irtiming.physics.covariance import generalised_inverse
from irtiming.records.arrays import Array

NONE = -1
"""Intervals of a gain that does not drift."""

_INTERVALS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)  # of a spline
_TURNS = 3  # offset and gain by turns
_MOST_JUMPS = 12
_LEAST_STRETCH = 10  # frames between two jumps
_ROUNDS = 4
_HUBER = 1.5
_FLAT = 1e-12  # of the largest: axes of the normal matrix along which values say nothing
_ROUNDING = 1e-9  # of the range of values: less than this is no scatter
_MOST_SHARE = 8  # frames per number, at least


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Levels:
    """How levels change over the frames.

    Parameters
    ----------
    drift, gain
        Shapes (n, k) and (n, l); what is added, and what multiplies F, beside a constant; columns of mean zero.
    n_offset, n_gain
        Intervals of their splines, 0 for a straight line, NONE for no curve.
    jumps
        First frames after a jump.
    offset_change, relative_gain
        Shape (n,); the offset less its mean, and the gain over its mean, as fitted.
    contrast
        The gain's mean.
    design, weight
        Shapes (n, m) and (n,); what was fitted, columns of constants, F, offset, gain and shapes, and Huber weights at the end.
    u_value
        Standard deviation of a value, over the contrast.
    criterion
        Bayesian information criterion, less is better; the constant of proportionality is that of the values.
    """

    drift: Array
    gain: Array
    n_offset: int
    n_gain: int
    jumps: tuple[int, ...]
    offset_change: Array
    relative_gain: Array
    contrast: float
    design: Array
    weight: Array
    u_value: float
    criterion: float

    @property
    def n_numbers(self) -> int:
        """Beside a constant offset and a constant gain."""
        return self.drift.shape[1] + self.gain.shape[1]

    @property
    def covariance(self) -> Array:
        """Of the numbers of offset and gain, over the contrast, shape (k + l, k + l)."""
        normal = np.einsum("ij,i,ik->jk", self.design, self.weight, self.design)
        own = slice(2, 2 + self.n_numbers)
        return np.asarray(generalised_inverse(normal)[own, own] * self.u_value**2)


def choose(
    values: Array, moving: Array, *, shapes: Array, place: Array, shortest: int = 60, beside: bool = False
) -> Levels:
    """Levels that explain the values with as few numbers as the criterion wants.

    Parameters
    ----------
    values, moving
        Shape (n,); y and F.
    shapes
        Shape (n, j); S.
    place
        Shape (n,); time from 0 to 1, ascending.
    shortest
        Frames per interval of a spline, at least.
    beside
        Whether the curves stand beside the result: then they are finer than the criterion wants, unless it wants none but a
        straight line of the offset.
    """
    fixed = _Fixed(values=values, moving=moving, shapes=shapes, place=place)
    most = values.size // shortest
    ladder = (0, *(n for n in _INTERVALS if n <= most))
    smooth = fixed.levels(0, NONE, with_jumps=False)
    n_offset, n_gain = 0, NONE
    for _ in range(_TURNS):
        before = (n_offset, n_gain)
        tried = {n: fixed.levels(n, n_gain, with_jumps=False) for n in ladder}
        n_offset = min(ladder, key=lambda n: tried[n].criterion)
        tried = {n: fixed.levels(n_offset, n, with_jumps=False) for n in (NONE, *ladder)}
        n_gain = min(tried, key=lambda n: tried[n].criterion)
        smooth = tried[n_gain]
        if (n_offset, n_gain) == before:
            break
    stiff = {(min(n, n_offset), min(n, n_gain)) for n in (0, 1, 4)} | {(n_offset, n_gain), (0, NONE)}
    jumping = [fixed.levels(*one) for one in sorted(stiff)]
    best = min([smooth, *jumping], key=lambda one: one.criterion)
    if not beside or best.n_numbers == 1:
        return best
    finest = 2 * values.size // shortest
    return fixed.fitted(_finer(best.n_offset, finest), _finer(best.n_gain, finest), jumps=best.jumps)


def _finer(n_intervals: int, finest: int) -> int:
    """Twice as many, two for a straight line, and a straight line for none."""
    return 0 if n_intervals == NONE else min(2 * max(1, n_intervals), finest)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Fixed:
    """What does not change from one choice to the next."""

    values: Array
    moving: Array
    shapes: Array
    place: Array

    def levels(self, n_offset: int, n_gain: int, *, with_jumps: bool = True) -> Levels:
        found = self.fitted(n_offset, n_gain, jumps=())
        while with_jumps and len(found.jumps) < _MOST_JUMPS:
            at = self._likeliest_jump(found)
            if at is None:
                break
            more = self.fitted(n_offset, n_gain, jumps=(*found.jumps, at))
            if more.criterion >= found.criterion:
                break
            found = more
        return found

    def _curve(self, n_intervals: int) -> Array:
        if n_intervals == NONE:
            return np.zeros((self.place.size, 0))
        return _centred(smooth_curve.columns(self.place, n_intervals))

    def _design(self, drift: Array, gain: Array) -> Array:
        ones = np.ones((self.values.size, 1))
        moving = self.moving[:, None]
        return np.concatenate([ones, moving, drift, gain * moving, self.shapes], axis=1)

    def fitted(self, n_offset: int, n_gain: int, *, jumps: tuple[int, ...]) -> Levels:
        n = self.values.size
        steps = (np.arange(n)[:, None] >= np.array(jumps, dtype=int)).astype(float)
        drift, gain = (np.concatenate([self._curve(one), _centred(steps)], axis=1) for one in (n_offset, n_gain))
        design = self._design(drift, gain)
        weight: Array = np.ones(n)
        amounts: Array = np.zeros(design.shape[1])
        deviance = np.inf
        least = _ROUNDING * float(np.ptp(self.values))
        for _ in range(_ROUNDS):
            weighted = design.T * weight
            amounts = np.asarray(np.linalg.lstsq(weighted @ design, weighted @ self.values, rcond=_FLAT)[0])
            size = np.abs(self.values - design @ amounts)
            limit = max(_HUBER * robust.OF_NORMAL * float(np.median(size)), least)
            deviance = float(np.sum(robust.huber_loss(size, limit)))
            weight = robust.huber_weight(size, limit)
        size_of_model = design.shape[1] + len(jumps)
        criterion = n * np.log(max(deviance / n, least**2)) + size_of_model * np.log(n)
        if size_of_model > n // _MOST_SHARE:
            criterion = np.inf
        n_drift = 2 + drift.shape[1]
        return Levels(
            drift=drift,
            gain=gain,
            n_offset=n_offset,
            n_gain=n_gain,
            jumps=jumps,
            offset_change=drift @ amounts[2:n_drift],
            relative_gain=1 + gain @ amounts[n_drift : n_drift + gain.shape[1]] / amounts[1],
            contrast=float(amounts[1]),
            design=design,
            weight=weight,
            u_value=float(np.sqrt(deviance / max(n - size_of_model, 1)) / abs(amounts[1])),
            criterion=float(criterion),
        )

    def _likeliest_jump(self, found: Levels) -> int | None:
        """Where a step of offset or gain would lower the deviance most, all else at its best; first frame after it."""
        root = np.sqrt(found.weight)
        basis = orthonormal.of(self._design(found.drift, found.gain) * root[:, None]).columns
        rest = self.values * root
        rest = rest - basis @ (basis.T @ rest)
        best: Array = np.zeros(rest.size)
        for column in (root, root * self.moving):
            along = np.cumsum((column * rest)[::-1])[::-1]
            later = np.cumsum((column[:, None] * basis)[::-1], axis=0)[::-1]
            own = np.cumsum((column**2)[::-1])[::-1]
            free = own - np.sum(later**2, axis=1)
            best = np.maximum(best, np.where(free > 1e-6 * own.max(), along**2 / np.maximum(free, 1e-300), 0.0))
        near = np.zeros(rest.size, bool)
        for at in (0, rest.size, *found.jumps):
            near[max(0, at - _LEAST_STRETCH) : at + _LEAST_STRETCH] = True
        best[near] = 0.0
        return int(np.argmax(best)) if best.any() else None


def _centred(columns: Array) -> Array:
    return np.asarray(columns - columns.mean(axis=0))
