"""The search for the numbers of the contrast image: bounded least squares, with slopes that spare what a number leaves alone."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from irtiming.estimate.sector_image import APART, NUMBERS, Sharp
from irtiming.inference import in_threads
from irtiming.physics import lens
from irtiming.records.arrays import Array

Numbers: TypeAlias = Mapping[str, float]
Change: TypeAlias = Callable[[Numbers, Sequence[Sharp]], Array]
"""What residuals differ by at other numbers, from their sharp images; shape (m,)."""

_SHARPEST_PX, _MOST_BLURRED_PX = 0.25, 8.0
_MOST_ELLIPTIC = 0.6
_MOST_CORRELATED = 0.85  # of a blur that is 3.5 times as wide along one diagonal as along the other
_LEAST_GROWTH, _MOST_GROWTH = -0.6, 15.0
_LEAST_GLARE, _MOST_GLARE = -0.1, 0.5  # less than none makes up for a blur that ends sooner than a Gaussian
_NARROWEST_GLARE_PX, _WIDEST_GLARE_PX = 2.0, 40.0
_MOST_EVALUATIONS = 30
_INWARD = 1e-3  # of a number's scale: how far from its limits a search begins, for none begins upon them
_FIRST_STEP = 10.0  # of its scale: how far a number may go at once
_STEP = 1e-4  # of a number's scale: over which a slope is taken
_AGREES = (1, 2, 4)  # how a search ends whose last step gained what the slopes foretold
_MISSED = 0.3  # of a step's change: slopes that foretell it worse are taken anew
_SLIGHT = 0.3  # of the gain that ends a search: less that was missed, a sum of squares, does no harm
FIRST, BETWEEN, LAST = 100.0, 1.0, 0.1
"""Gains below which a search ends, of a sum of squares that are 1 on average: the first search is but a start for another."""
SCALES: Mapping[str, float] = dict.fromkeys(NUMBERS, 1.0) | {
    "bisector_rad": 0.05,
    "opening_angle_rad": 0.05,
    "blur_px": 0.5,
    "blur_ellipticity": 0.2,
    "blur_correlation": 0.2,
    "blur_growth": 0.3,
    "glare": 0.02,
    "glare_px": 3.0,
    "distortion": 0.02,
    "keystone_row": 2e-3,
    "keystone_column": 2e-3,
    "log_focal_length": 0.5,
    "lens_row_px": 3.0,
    "lens_column_px": 3.0,
    "row_delay_s": 1e-5,
    "turn_rad": 0.02,
    "ring_inner_px": 2.0,
    "ring_outer_px": 2.0,
    "plate_reflection": 0.3,
}
"""Of each number, roughly: by so much it is likely to move; see `scale`."""
LIMITS: Mapping[str, tuple[float, float]] = {
    "inner_radius_px": (0.0, np.inf),
    "ring_inner_px": (0.0, np.inf),
    "blur_px": (_SHARPEST_PX, _MOST_BLURRED_PX),
    "blur_ellipticity": (-_MOST_ELLIPTIC, _MOST_ELLIPTIC),
    "blur_correlation": (-_MOST_CORRELATED, _MOST_CORRELATED),
    "blur_growth": (_LEAST_GROWTH, _MOST_GROWTH),
    "glare": (_LEAST_GLARE, _MOST_GLARE),
    "glare_px": (_NARROWEST_GLARE_PX, _WIDEST_GLARE_PX),
    "distortion": (lens.LOWEST, lens.HIGHEST),
    "keystone_row": (-0.3, 0.3),
    "keystone_column": (-0.3, 0.3),
    "plate_reflection": (0.0, 1.0),
}
"""Least and most of numbers that have such."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """Residuals at some numbers, shape (m,), and what they ``change`` by beside them, to first order."""

    residual: Array
    change: Change


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Misfit:
    """What is to be made small: residuals ``at`` some numbers, from the sharp images that belong to them."""

    at: Callable[[Numbers, Sequence[Sharp]], Place]
    sharp: Callable[[Numbers], Sequence[Sharp]]


@final
@dataclass(kw_only=True, eq=False)
class Slopes:
    """Those of a search's residuals to ``names``, shape (m, n), left for one that begins near its end; none at first."""

    matrix: Array | None = None
    names: tuple[str, ...] = ()


def scale(name: str) -> float:
    """By how much a number is likely to move, roughly."""
    return SCALES["turn_rad" if name.startswith("turn_") else name]


def searched(
    misfit: Misfit, start: Numbers, *, free: Sequence[str], gain: float, slopes: Slopes | None = None
) -> OptimizeResult:
    """Where a search from one place ends; a whole one, also where slopes of others led it nowhere.

    Parameters
    ----------
    misfit
        Of all numbers.
    start
        Where to begin; what is not ``free`` stays there.
    free
        Names of the numbers that are searched for, in the order of the result's.
    gain
        Below which it ends: `FIRST`, `BETWEEN` or `LAST`.
    slopes
        With which the search begins, and which are brought up to date; taken anew where they foretell steps badly. Those of
        numbers that the search before did not have are added.
    """
    n_kept = None if slopes is None or slopes.matrix is None else len(slopes.matrix)
    found = _search(misfit, start, free=free, gain=gain, slopes=slopes)
    if slopes is not None and n_kept == found.fun.size and found.status not in _AGREES:
        slopes.matrix = None
        found = _search(misfit, start, free=free, gain=gain, slopes=slopes)
    return found


def _search(
    misfit: Misfit, start: Numbers, *, free: Sequence[str], gain: float, slopes: Slopes | None
) -> OptimizeResult:
    scales = np.array([scale(name) for name in free])
    low, high = np.array([LIMITS.get(name, (-np.inf, np.inf)) for name in free]).T
    course = _Course(
        misfit=misfit, start=start, free=free, step=_STEP * scales, high=high, kept=slopes or Slopes(), gain=gain
    )
    begin = np.clip([start[name] for name in free], low + _INWARD * scales, high - _INWARD * scales)
    origin = begin - _FIRST_STEP * scales  # a first step is bounded by the distance from there

    def residuals(off: Array) -> Array:
        return course.residuals(origin + off)

    def slopes_there(off: Array) -> Array:
        return course.slopes(origin + off)

    first = residuals(begin - origin)
    found = least_squares(
        residuals,
        begin - origin,
        jac=slopes_there,
        x_scale=scales,
        bounds=(low - origin, high - origin),
        max_nfev=_MOST_EVALUATIONS,
        ftol=gain / first.size,
    )
    found.x += origin
    found["gained"] = float(first @ first) - 2 * found.cost
    return found


@dataclass(kw_only=True, eq=False)
class _Course:
    """Residuals and their slopes along a search; those of the last place are kept, for slopes are asked for where it stands.

    Slopes are ``kept`` from place to place, each step making them foretell itself (Broyden 1965), as long as they nearly did.
    """

    misfit: Misfit
    start: Numbers
    free: Sequence[str]
    step: Array
    high: Array
    kept: Slopes
    gain: float
    before: tuple[Array, Array] | None = None
    at: Array | None = None

    def residuals(self, at: Array) -> Array:
        if self.at is None or not np.array_equal(at, self.at):
            self.at, numbers = at.copy(), self._numbers(at)
            self.known = self.misfit.sharp(numbers)
            self.place = self.misfit.at(numbers, self.known)
        return self.place.residual

    def slopes(self, at: Array) -> Array:
        """Shape (m, n_free)."""
        residual = self.residuals(at)
        found = self._updated(self._kept(at), at)
        self.kept.matrix = self._differences(at, self.free) if found is None else found
        self.kept.names = tuple(self.free)
        self.before = at.copy(), residual
        return self.kept.matrix

    def _kept(self, at: Array) -> Array | None:
        """Those from the place before, with those that are not among them taken here; None where there are none."""
        slopes = self.kept.matrix
        if slopes is None or len(slopes) != self.place.residual.size or not set(self.kept.names) <= set(self.free):
            return None
        added = [name for name in self.free if name not in self.kept.names]
        if added:
            slopes = np.hstack([slopes, self._differences(at, added)])
        names = (*self.kept.names, *added)
        return slopes[:, [names.index(name) for name in self.free]]

    def _updated(self, slopes: Array | None, at: Array) -> Array | None:
        """Slopes that foretell the step to where it stands, as the ones before did nearly; None where they did not.

        As they were after a step that matters less than what a search ends with.
        """
        if slopes is None or self.before is None:
            return slopes
        step, change = at - self.before[0], self.place.residual - self.before[1]
        missed = change - slopes @ step
        if not np.linalg.norm(missed) <= _MISSED * np.linalg.norm(change):
            return slopes if missed @ missed <= _SLIGHT * self.gain else None
        weighted = step / self.step**2
        return np.asarray(slopes + np.multiply.outer(missed, weighted / (weighted @ step)))

    def _differences(self, at: Array, names: Sequence[str]) -> Array:
        return np.stack(in_threads.mapped(lambda name: self._difference(at, name), names), axis=1)

    def _difference(self, at: Array, name: str) -> Array:
        k = self.free.index(name)
        step = self.step[k] if at[k] + self.step[k] <= self.high[k] else -self.step[k]
        moved = {**self._numbers(at), name: float(at[k] + step)}
        known = self.known if name in APART else self.misfit.sharp(moved)
        return self.place.change(moved, known) / step

    def _numbers(self, at: Array) -> dict[str, float]:
        return {**self.start, **dict(zip(self.free, map(float, at), strict=True))}
