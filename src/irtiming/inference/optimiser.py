r"""Trust-region least squares over named parameters: the one optimiser of every fit.

The sum of squares |r(p)|^2 of residuals in units of their standard deviations (the deviance) is minimised by SciPy's reflective
trust region (Branch, Coleman and Li, SIAM J. Sci. Comput. 21, 1999). A step that gains nothing only shrinks the region, so a
corner of the model ends no search: whatever is reached last is a minimum within rounding, and how far it is from one is given by
the Newton decrement, in standard uncertainties. Where a minimum lies in a kink, no derivative vanishes there; then what a further
step truly gains is the measure.

Parameters that enter linearly are eliminated from the residuals beforehand (`variable_projection`).
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np
from scipy.optimize import least_squares

from irtiming.errors import EstimationError
from irtiming.records.arrays import Array

_GAIN = 1e-4  # of the mean of a squared residual: what a hundredth of a standard uncertainty changes the deviance by
_STEP = 1e-10  # of the parameters in units of the trust region
_MOST_EVALUATIONS = 200
_IN_A_ROW = 3  # evaluations
_SETTLED = 0.1  # standard uncertainties that a further Newton step would move
_PARTS = (1.0, 0.5, 0.25, 0.1)  # of such a step, that are tried where it is longer


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Linearised:
    """Residuals (m,) at a point, in units of their standard deviations, and their derivatives (m, n) to the parameters."""

    residual: Array
    jacobian: Array

    @property
    def deviance(self) -> float:
        """Sum of squares."""
        return float(self.residual @ self.residual)

    @property
    def normal(self) -> Array:
        """Normal equations' matrix, shape (n, n): the inverse covariance."""
        return np.asarray(self.jacobian.T @ self.jacobian)

    @property
    def gradient(self) -> Array:
        """Direction in which the deviance falls, shape (n,): half its gradient with the sign turned."""
        return np.asarray(-self.jacobian.T @ self.residual)


Model: TypeAlias = Callable[[Mapping[str, float]], Linearised]
"""Residuals and derivatives at named numbers; the derivatives in the order in which the numbers stand there."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Minimum:
    """Where a search ended.

    Parameters
    ----------
    start, values
        Named numbers, in the same order.
    free
        Names of those that were searched; the others stayed at their start.
    at
        Residuals and derivatives there; columns in the order of ``values``.
    n_steps
        Evaluations of the model on the way.
    decrement
        Length of a further Newton step, in standard uncertainties, as far as one lowers the deviance.
    """

    start: dict[str, float]
    values: dict[str, float]
    free: tuple[str, ...]
    at: Linearised
    n_steps: int
    decrement: float

    @property
    def is_settled(self) -> bool:
        """Whether the point is a minimum to a small part of a standard uncertainty."""
        return self.decrement < _SETTLED


def minimise(
    model: Model,
    *,
    start: Mapping[str, float],
    held: Collection[str] = (),
    gain: float | None = None,
    enough: float = 0.0,
) -> Minimum:
    """Least squares in the numbers that are not held.

    Parameters
    ----------
    model
        Residuals over their standard deviations, with derivatives to all numbers of ``start``.
    start
        Where the search begins, by name.
    held
        Names of those that keep their start value.
    gain
        Share of the deviance: the search ends where a step gains less; by default what a hundredth of a standard uncertainty
        is worth.
    enough
        Deviance: the search also ends where three evaluations in a row gained less together; 0: it does not.

    Raises
    ------
    EstimationError
        If the model gives no finite residuals at the start.
    """
    names = tuple(start)
    free = tuple(name for name in names if name not in held)
    columns = [names.index(name) for name in free]
    remembered = _Remembered(model, dict(start), free, enough=enough)
    begin = np.array([start[name] for name in free], dtype=np.float64)
    if not np.all(np.isfinite(remembered.at(begin).residual)):
        raise EstimationError(
            f"the model gives no finite residuals at the start value ({_text(start)}); check rig.toml against the recording"
        )
    if not free:
        return Minimum(
            start=dict(start), values=dict(start), free=(), at=remembered.at(begin), n_steps=1, decrement=0.0
        )
    least = _GAIN / remembered.at(begin).residual.size if gain is None else gain
    best = _searched(remembered, begin, gain=least)
    at = remembered.at(best)
    return Minimum(
        start=dict(start),
        values=remembered.named(best),
        free=free,
        at=at,
        n_steps=len(remembered.deviances),
        decrement=_decrement(remembered, best, at=at, columns=columns),
    )


def _searched(remembered: "_Remembered", begin: Array, *, gain: float) -> Array:
    """Free numbers at the least deviance, shape (n_free,)."""
    try:
        return np.asarray(
            least_squares(
                remembered.residual,
                begin,
                jac=remembered.jacobian,
                method="trf",
                x_scale="jac",
                ftol=gain,
                xtol=_STEP,
                gtol=None,
                max_nfev=_MOST_EVALUATIONS,
            ).x
        )
    except _EnoughError:
        return remembered.best


class _EnoughError(Exception):
    """The search has found all that was asked for."""


@final
class _Remembered:
    """The model at named numbers, the last point kept: residuals and derivatives are asked for one after the other.

    ``deviances`` are those of the search, ``best`` where the least of them was.
    """

    def __init__(self, model: Model, all_numbers: dict[str, float], free: tuple[str, ...], *, enough: float) -> None:
        self._model, self._all, self._free, self._enough = model, all_numbers, free, enough
        self.deviances: list[float] = []
        self.best = np.array([all_numbers[name] for name in free])
        self._key: bytes = b""
        self._last: Linearised | None = None

    def named(self, free_values: Array) -> dict[str, float]:
        return self._all | dict(zip(self._free, (float(value) for value in free_values), strict=True))

    def residual(self, free_values: Array) -> Array:
        there = self.at(free_values)
        if there.deviance < min(self.deviances, default=np.inf):
            self.best = np.array(free_values, float)
        self.deviances.append(there.deviance)
        if self._enough and min(self.deviances[:-_IN_A_ROW], default=np.inf) - min(self.deviances) < self._enough:
            raise _EnoughError
        return there.residual

    def jacobian(self, free_values: Array) -> Array:
        """Derivatives to the free numbers."""
        return self.at(free_values).jacobian[:, [list(self._all).index(name) for name in self._free]]

    def at(self, free_values: Array) -> Linearised:
        key = np.asarray(free_values, float).tobytes()
        if self._last is None or key != self._key:
            self._key, self._last = key, self._model(self.named(free_values))
        return self._last


def _decrement(remembered: _Remembered, best: Array, *, at: Linearised, columns: list[int]) -> float:
    """What a further Newton step moves, as far as it, or a part of it, lowers the deviance; all of it where none can be told."""
    step = _newton_step(at, columns)
    length = float(np.linalg.norm(at.jacobian[:, columns] @ step))
    if length < _SETTLED:
        return length
    further = [remembered.at(best + part * step).deviance for part in _PARTS]
    gains = [at.deviance - one for one in further if np.isfinite(one)]
    return min(length, max(0.0, *gains) ** 0.5) if gains else length


def _newton_step(at: Linearised, columns: list[int]) -> Array:
    """Of the free numbers, along directions that the data tell; shape (n_free,)."""
    scale = np.linalg.norm(at.jacobian[:, columns], axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    step, *_ = np.linalg.lstsq(at.jacobian[:, columns] / scale, -at.residual, rcond=1e-10)
    return np.asarray(step / scale)


def _text(numbers: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {value:.6g}" for name, value in numbers.items())
