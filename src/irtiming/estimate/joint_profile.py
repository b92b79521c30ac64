"""Profile likelihood of every parameter that the joint fit reports: how far the covariance can be trusted."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import joint_fit, profile_of
from irtiming.estimate.joint_fit import T_MIDDLE, WINDOW, Problem, Solution
from irtiming.records.estimate import Estimate
from irtiming.records.joint_fit import Profile

_FORGOTTEN = {"trigger_delay_falling": (1, 3), "trigger_delay_rising": (0, 2)}


def profiles(
    given: Problem, found: Solution, *, estimate: Estimate, integration_time_s: float | None
) -> tuple[Profile, ...]:
    """Profiles of the parameters of the estimate.

    Parameters
    ----------
    given, found
        The joint fit.
    estimate
        What is reported.
    integration_time_s
        None where the window's length is the fitted one.

    Notes
    -----
    A delay of falling slopes alone is profiled in the likelihood that rising slopes say nothing in. Where the
    integration time is not stated, trigger_delay is the middle less half the fitted window: its profile is the middle's.
    """
    made = []
    stated_half_s = 0.0 if integration_time_s is None else integration_time_s / 2
    for name, value, u in zip(estimate.names, estimate.values, estimate.standard_uncertainties, strict=True):
        if integration_time_s is None and name.startswith("trigger_delay"):
            continue
        place = WINDOW if name == "integration_time" else T_MIDDLE
        shift = stated_half_s if name.startswith("trigger_delay") else 0.0
        at = _without(given, found, _FORGOTTEN.get(name, ()))
        made.append(
            profile_of.profile(
                name,
                value=float(value),
                u=float(u),
                lost=_lost(*at, place=place, shift=shift),
                is_positive=name == "integration_time",
            )
        )
    return tuple(made)


def _without(given: Problem, found: Solution, forgotten: tuple[int, ...]) -> tuple[Problem, Solution]:
    """The same with the slopes of some edges left out."""
    if not forgotten:
        return replace(given, own=found.own), found
    given = given.without(forgotten, found.own)
    found = joint_fit.solve(given, found.shared)
    return replace(given, own=found.own), found


def _lost(given: Problem, found: Solution, *, place: int, shift: float) -> Callable[[float], float]:
    """Deviance over the value of one parameter, which is the shared number less ``shift``."""
    return lambda value: _deviance(given, found, place=place, value=value + shift)


def _deviance(given: Problem, found: Solution, *, place: int, value: float) -> float:
    """Twice the logarithm of the likelihood lost where one number is held and all others are at their best."""
    start = found.shared.copy()
    start[place] = value
    covariance = joint_fit.covariance(given, found)
    others = np.setdiff1d(np.arange(9), [place])
    start[others] += covariance[others, place] / covariance[place, place] * (value - found.shared[place])
    start[WINDOW] = max(start[WINDOW], 0.0)
    try:
        return joint_fit.solve(given, start, fixed=(place,)).deviance - found.deviance
    except EstimationError:  # so far away that no fit settles
        return float("nan")
