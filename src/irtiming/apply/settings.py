r"""Results at several settings of one camera, and from them the timing at a setting between, by generalised least squares.

.. math:: y_i = a + b\,x_i, \qquad \hat y(x) = w^T y, \quad w^T = (1, x)\,(X^T V^{-1} X)^{-1} X^T V^{-1}

x is the integration time, or where all results have the same one the time between frames. Each number of the timing has its own
line. V holds what each measurement has of its own, on its diagonal, and what all share, everywhere: errors of rig.toml (type B),
which are taken to be the same in all of them. So the shared part does not become smaller by many results.

Whether a straight line holds is judged by chi-squared where there are three results or more. Beyond the settings measured nothing
is said.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from scipy.special import chdtrc

from irtiming.apply.camera_timing import CameraTiming, Conditions
from irtiming.apply.conditions import SAME, require, same_window
from irtiming.errors import ConditionError
from irtiming.inference.weighted_line import line_weights
from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate
from irtiming.units import counted, readable_time

Axis = Literal["integration time", "time between frames"]

_DOUBTFUL, _REFUSED = 0.05, 1e-4
"""Probability of a chi-squared as large: below the first what u has of each result's own grows by the ratio of Birge.

Below the second it is no line.
"""


def between(cameras: Sequence[CameraTiming], wanted: Conditions, *, where: str) -> tuple[CameraTiming, tuple[str, ...]]:
    """The camera's timing at a setting between those that were measured.

    Parameters
    ----------
    cameras
        Of results of one camera, two or more, that differ in integration time or frame rate alone.
    wanted
        What is said of the frames.
    where
        Their file.

    Returns
    -------
    The timing, and what is to be said of it. At a setting that was measured it is that result's.

    Raises
    ------
    ConditionError
        If the results are of different cameras, the frames do not tell their setting, it is beyond those measured, or no straight
        line goes through them.
    """
    axis = _axis(cameras)
    for one in cameras[1:]:
        _require_same(cameras[0], one)
    x = np.array([_setting(one.conditions, axis) for one in cameras], dtype=np.float64)
    at = _setting(wanted, axis)
    if not np.all(np.isfinite(x)) or not np.isfinite(at):
        raise ConditionError(
            f"the {axis} is not stated by {'the frames' if np.all(np.isfinite(x)) else 'each result'}, and results are "
            "interpolated over it; give the one result of this setting alone",
            where=where,
        )
    here = np.flatnonzero(np.abs(x - at) <= SAME * x)
    if here.size:
        return cameras[int(here[0])], ()
    if not x.min() < at < x.max():
        raise ConditionError(
            f"its {axis} is {_time(at)}, the results were measured from {_time(float(x.min()))} to {_time(float(x.max()))}, "
            "and hold between these alone: measure the camera as it is set",
            where=where,
        )
    estimate, remarks = _on_lines(cameras, x, at, axis=axis, where=where)
    first = cameras[0].conditions
    is_window = axis == "integration time"
    conditions = replace(first, integration_time_s=at) if is_window else replace(first, frame_period_s=at)
    unsure = tuple(dict.fromkeys(words for one in cameras for words in one.not_in_uncertainty))
    found = replace(
        cameras[0], conditions=conditions, estimate=estimate, two_constants=None, not_in_uncertainty=unsure
    )  # fmt: skip
    return found, remarks


def _axis(cameras: Sequence[CameraTiming]) -> Axis:
    """What the results differ in."""
    first = cameras[0].conditions
    same = all(same_window(first, one.conditions) for one in cameras)
    return "integration time" if first.camera_type == "photon" and not same else "time between frames"


def _setting(one: Conditions, axis: Axis) -> float:
    value = one.integration_time_s if axis == "integration time" else one.frame_period_s
    return np.nan if value is None else value


def _require_same(first: CameraTiming, other: CameraTiming) -> None:
    """The same camera and the same numbers; the integration time may differ."""
    alike = replace(other.conditions, integration_time_s=first.conditions.integration_time_s)
    require(first.conditions, alike, where="series")
    if other.event != first.event or other.estimate.names != first.estimate.names:
        raise ConditionError(
            f"a result has {', '.join(other.estimate.names)} counted from the {other.event}, another "
            f"{', '.join(first.estimate.names)} from the {first.event}; all must have the same, analysed alike",
            where="series",
        )


def _on_lines(
    cameras: Sequence[CameraTiming], x: Array, at: float, *, axis: Axis, where: str
) -> tuple[Estimate, tuple[str, ...]]:
    """Each number on its line, with the covariance of all of them."""
    names = cameras[0].estimate.names
    values = np.array([one.estimate.values for one in cameras])
    u = np.array([np.sqrt(np.diag(one.estimate.covariance)) for one in cameras])
    shared = np.minimum(np.array([one.shared_u or np.zeros(len(names)) for one in cameras]), u)
    own = np.sqrt(np.maximum(u**2 - shared**2, 1e-12 * u**2 + 1e-30))
    weights, ratios = np.zeros_like(values), np.ones(len(names))
    for k, name in enumerate(names):
        covariance = np.diag(own[:, k] ** 2) + np.outer(shared[:, k], shared[:, k])
        weights[:, k], chi_squared = line_weights(x, values[:, k], covariance=covariance, at=at)
        ratios[k] = _birge(chi_squared, x.size - 2, name=name, axis=axis, where=where)
    alike = np.mean([_correlations(one) for one in cameras], axis=0)
    together = np.einsum("ip,iq,ip,iq->pq", weights, weights, own, own)
    common = np.sum(weights * shared, axis=0)
    covariance = alike * (together * np.outer(ratios, ratios) + np.outer(common, common))
    estimate = Estimate(
        names=names, units=cameras[0].estimate.units, values=np.sum(weights * values, axis=0), covariance=covariance
    )
    return estimate, tuple(_said(cameras, x, at, axis=axis, ratios=dict(zip(names, ratios.tolist(), strict=True))))


def _birge(chi_squared: float, freedom: int, *, name: str, axis: Axis, where: str) -> float:
    if freedom < 1:
        return 1.0
    p_value = float(chdtrc(freedom, chi_squared))
    if p_value < _REFUSED:
        raise ConditionError(
            f"{name} is no straight line over the {axis}: chi-squared is {chi_squared:.3g} for "
            f"{counted(freedom, 'degree')} of freedom; give results nearer to its setting, or measure it there",
            where=where,
        )
    return float(np.sqrt(chi_squared / freedom)) if p_value < _DOUBTFUL else 1.0


def _correlations(camera: CameraTiming) -> Array:
    u = np.sqrt(np.diag(camera.estimate.covariance))
    scale = np.where(u > 0, u, 1.0)
    found = np.asarray(camera.estimate.covariance / np.outer(scale, scale))
    np.fill_diagonal(found, 1.0)
    return found


def _said(
    cameras: Sequence[CameraTiming], x: Array, at: float, *, axis: Axis, ratios: dict[str, float]
) -> Sequence[str]:
    places = ", ".join(_time(float(one)) for one in np.sort(x))
    lines = [f"interpolated to the {axis} of {_time(at)} by straight lines through {len(cameras)} results, at {places}"]
    if x.size < 3:
        lines.append("whether a straight line holds was not tested: that takes three results")
    wide = ", ".join(f"{name} {ratio:.2g}" for name, ratio in ratios.items() if ratio > 1)
    if wide:
        lines.append(
            f"results lie further from their line than their u says; what u has of their own was multiplied: {wide}"
        )
    return lines


def _time(seconds: float) -> str:
    return readable_time(float(f"{seconds:.6g}"))
