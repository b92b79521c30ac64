"""Profile likelihood of one parameter, from what its deviance is at some values: which values, and where it reaches 1."""

from collections.abc import Callable

import numpy as np

from irtiming.records.arrays import Array
from irtiming.records.joint_fit import Profile

_POINTS = (-2.0, -1.0, 1.0, 2.0)  # standard uncertainties


def profile(name: str, *, value: float, u: float, lost: Callable[[float], float], is_positive: bool = False) -> Profile:
    """Deviance at one and two standard uncertainties to either side, and the ends of the interval at which it is 1.

    Parameters
    ----------
    name
        Of the parameter.
    value, u
        Its estimate and standard uncertainty, s.
    lost
        Twice the logarithm of the likelihood that is lost where the parameter is held at a value; nan where nothing settles.
    is_positive
        Whether values of zero and below cannot be.
    """
    tried = np.array([value + k * u for k in _POINTS])
    if is_positive:
        tried = tried[tried > 0]
    deviation = np.array([lost(float(t)) for t in tried])
    tried, deviation = tried[np.isfinite(deviation)], np.maximum(deviation[np.isfinite(deviation)], 0.0)
    order = np.argsort(np.append(tried, value))
    values, deviation = np.append(tried, value)[order], np.append(deviation, 0.0)[order]
    lower, upper = _crossings(values, deviation, value)
    return Profile(
        name=name, unit="s", value=value, standard_uncertainty=u, values=values, deviation=deviation, lower=lower,
        upper=upper,
    )  # fmt: skip


def _crossings(values: Array, deviation: Array, value: float) -> tuple[float | None, float | None]:
    """Where the deviation is 1: its square root, with a sign, is nearly a straight line."""
    signed = np.sign(values - value) * np.sqrt(deviation)
    low = float(np.interp(-1.0, signed, values)) if signed[0] <= -1 else None
    high = float(np.interp(1.0, signed, values)) if signed[-1] >= 1 else None
    return low, high
