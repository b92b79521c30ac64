"""Profile likelihood of every parameter that is reported: how far its covariance can be trusted, and that it left its start."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from irtiming.estimate.joint import Joint, Measurand, at_point, residuals
from irtiming.estimate.shared_numbers import SharedNumber
from irtiming.estimate.timing import Timing
from irtiming.inference import optimiser
from irtiming.inference.optimiser import Linearised, Minimum, Model
from irtiming.records.arrays import Array
from irtiming.records.result import Profile

_GAIN = 1e-7  # of the deviance: along a valley with a bent floor a search gains little for long, and a profile needs no more
_ENOUGH = 1e-2  # of a deviance that is 1 at one standard uncertainty: the end of an interval to half a hundredth of it
_POINTS = (-2.0, -1.0, 1.0, 2.0)  # standard uncertainties


def profiles(timing: Timing) -> tuple[Profile, ...]:
    """Of all parameters that are one sum of shared numbers, on the exact likelihood of all recordings.

    Parameters
    ----------
    timing
        What was found.

    Notes
    -----
    A delay of falling slopes alone is profiled in the likelihood that rising slopes say nothing in.
    """
    exact = replace(timing.found.joint, models=timing.exact)
    found, made = {}, []
    for one in timing.found.profiled:
        if one.forgotten not in found:
            found[one.forgotten] = _minimum(exact, one.forgotten)
        u = timing.found.result.estimate.u(one.name)
        made.append(profile(one, found[one.forgotten], u=u))
    return tuple(made)


def _minimum(exact: Joint, forgotten: tuple[str, ...]) -> Joint:
    """The minimum of the exact likelihood where the delays of some edges are each recording's own."""
    n = len(exact.models)
    own = [
        SharedNumber(name=f"{edge} of recording {k}", effects=[{edge: 1.0} if j == k else {} for j in range(n)])
        for edge in forgotten
        for k in range(n)
    ]
    shared = [*(replace(one, start=exact.found.values[one.name]) for one in exact.shared), *own]
    found = optimiser.minimise(residuals(exact.models, shared), start={one.name: one.start for one in shared})
    return at_point(exact.models, shared, found=found)


def profile(one: Measurand, at: Joint, *, u: float) -> Profile:
    """Deviance at one and two standard uncertainties to either side, and the ends of the interval at which it is 1.

    Parameters
    ----------
    one
        What is profiled.
    at
        The minimum.
    u
        Its standard uncertainty.
    """
    whole = at.combined()
    row = whole.row(one.weights)
    best = float(row @ at.values)
    along = whole.covariance @ row / float(row @ whole.covariance @ row)
    tried = best + u * np.array([k for k in _POINTS if one.name != "integration_time" or best + k * u > 0])
    deviation = np.array(
        [_lost(one, at, value=float(value), start=at.values + along * (value - best)) for value in tried]
    )
    order = np.argsort(np.append(tried, best))
    values, deviation = np.append(tried, best)[order], np.append(np.maximum(deviation, 0.0), 0.0)[order]
    lower, upper = _crossings(values, deviation, best)
    return Profile(
        name=one.name,
        unit=one.unit,
        value=best + one.offset,
        standard_uncertainty=u,
        values=values + one.offset,
        deviation=deviation,
        lower=None if lower is None else lower + one.offset,
        upper=None if upper is None else upper + one.offset,
    )


def _lost(one: Measurand, at: Joint, *, value: float, start: Array) -> float:
    """Twice the logarithm of the likelihood lost where the sum is held at a value and all else is at its best."""
    names = at.names
    pivot = max(one.weights, key=lambda name: abs(one.weights[name]))
    others = {name: weight / one.weights[pivot] for name, weight in one.weights.items() if name != pivot}
    model = residuals(at.models, at.shared)
    begin = {name: float(x) for name, x in zip(names, start, strict=True) if name != pivot}
    held = _held(model, names, pivot=pivot, others=others, value=value / one.weights[pivot])
    found: Minimum = optimiser.minimise(held, start=begin, gain=_GAIN, enough=_ENOUGH)
    return found.at.deviance - at.found.at.deviance


def _held(model: Model, names: tuple[str, ...], *, pivot: str, others: Mapping[str, float], value: float) -> Model:
    """The model where one number follows from the others, so that a sum of them keeps its value."""
    at_pivot = names.index(pivot)
    free = [k for k in range(len(names)) if k != at_pivot]
    follows = np.array([-others.get(names[k], 0.0) for k in free])

    def at(numbers: Mapping[str, float]) -> Linearised:
        rest = value - sum(weight * numbers[name] for name, weight in others.items())
        there = model({name: rest if name == pivot else numbers[name] for name in names})
        jacobian = there.jacobian[:, free] + np.outer(there.jacobian[:, at_pivot], follows)
        return Linearised(residual=there.residual, jacobian=jacobian)

    return at


def _crossings(values: Array, deviation: Array, value: float) -> tuple[float | None, float | None]:
    """Where the deviation is 1: its square root, with a sign, is nearly a straight line."""
    signed = np.sign(values - value) * np.sqrt(deviation)
    low = float(np.interp(-1.0, signed, values)) if signed[0] <= -1 else None
    high = float(np.interp(1.0, signed, values)) if signed[-1] >= 1 else None
    return low, high
