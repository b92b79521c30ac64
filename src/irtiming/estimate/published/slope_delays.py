"""Relative and absolute trigger delay exactly as published (Schatz 2023, 3.1.4 and 3.1.5): the baseline."""

import numpy as np

from irtiming.physics.wheel import TURN, slope_centres_rad
from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate, PublishedFit
from irtiming.records.finding import Finding
from irtiming.records.result import Contribution, RelativeDelay, Result
from irtiming.records.wheel_geometry import WheelModel

_FALLING, _RISING = [0, 2], [1, 3]


def relative_delays(fits: list[PublishedFit]) -> tuple[RelativeDelay, ...]:
    """Mean shift of the four slopes against the measurement with the smallest delay set, over the angular velocity.

    Measurements are compared with those at the same rotation speed only.

    Returns
    -------
    One entry per recording; runs of one nominal delay were averaged and share their values.

    Notes
    -----
    A larger delay shifts the curve to smaller angles: the same state of the wheel appears in frames triggered earlier.
    """
    entries = []
    for fit in fits:
        same_speed = [other for other in fits if other.data.rotation_speed_hz == fit.data.rotation_speed_hz]
        reference = min(same_speed, key=lambda other: other.data.trigger_delay_time_set_s)
        nominal = fit.data.trigger_delay_time_set_s - reference.data.trigger_delay_time_set_s
        expected = fit.angular_frequency_rad_per_s * nominal
        shift = _centres(reference) - _centres(fit)
        shift = expected + np.mod(shift - expected + np.pi, TURN) - np.pi
        u = np.sqrt(np.sum(_u_centres(fit) ** 2 + _u_centres(reference) ** 2)) / 4
        entries += [
            RelativeDelay(
                file=file,
                nominal_s=nominal,
                value_s=float(shift.mean()) / fit.angular_frequency_rad_per_s if fit is not reference else 0.0,
                standard_uncertainty_s=float(u) / fit.angular_frequency_rad_per_s if fit is not reference else 0.0,
            )
            for file in fit.data.files
        ]
    return tuple(entries)


def estimate(fits: list[PublishedFit], model: WheelModel, *, integration_time_s: float | None) -> Result:
    """Trigger delays from the lines through the slopes.

    Parameters
    ----------
    fits
        One per nominal delay.
    model
        Slopes without any delay.
    integration_time_s
        To tell the start of integration from its middle; None leaves the start out.

    Returns
    -------
    The slopes give the *middle* of the integration window: ``exposure_midpoint_delay``. The paper prints that number as
    t_delay although its eq. (1) defines t_delay as the start; here ``trigger_delay`` and its falling and rising variants
    are the start, half the integration time earlier.
    """
    delay, u_delay = edge_delays(fits, model)
    weights = np.zeros((4, delay.size))
    flat = np.arange(delay.size).reshape(delay.shape)
    for row, edges in enumerate(([0, 1, 2, 3], [0, 1, 2, 3], _FALLING, _RISING)):
        weights[row, flat[:, edges].ravel()] = 1 / flat[:, edges].size
    start = np.array([0.0, 1.0, 1.0, 1.0]) * (integration_time_s or 0.0) / 2
    names = ("exposure_midpoint_delay", "trigger_delay", "trigger_delay_falling", "trigger_delay_rising")
    keep = [0, 1, 2, 3] if integration_time_s is not None else [0]
    covariance = weights @ np.diag(u_delay.ravel() ** 2) @ weights.T
    return Result(
        method="published",
        estimate=Estimate(
            names=tuple(names[k] for k in keep),
            units=("s",) * len(keep),
            values=(weights @ delay.ravel() - start)[keep],
            covariance=covariance[np.ix_(keep, keep)],
        ),
        relative_delays=relative_delays(fits),
        budget=(
            Contribution(
                source="scatter of the lines",
                kind="A",
                standard_uncertainty={names[k]: float(np.sqrt(covariance[k, k])) for k in keep},
            ),
        ),
        edge_delay_s=delay.mean(axis=0) - start[1],
        u_edge_delay_s=np.sqrt(np.mean(u_delay**2, axis=0) / len(fits)),
        findings=(
            Finding(
                code="published-uncertainty-partial",
                severity="warning",
                what="published method: the stated uncertainties hold the scatter of the line fits only, not those of mask, "
                "gates, edges, slots, latencies and clock",
            ),
        ),
    )


def edge_delays(fits: list[PublishedFit], model: WheelModel) -> tuple[Array, Array]:
    """Delay from trigger to the middle of the window by slope, set delay taken off; with its u, each (n_fit, 4), s."""
    delays, us = [], []
    for fit in fits:
        expected = fit.angular_frequency_rad_per_s * fit.data.trigger_delay_time_set_s
        shift = slope_centres_rad(model) - _centres(fit) - expected
        shift = np.mod(shift + np.pi, TURN) - np.pi
        delays.append(shift / fit.angular_frequency_rad_per_s)
        us.append(_u_centres(fit) / fit.angular_frequency_rad_per_s)
    return np.array(delays), np.array(us)


def _centres(fit: PublishedFit) -> Array:
    return np.array([line.centre_rad for line in fit.lines])


def _u_centres(fit: PublishedFit) -> Array:
    return np.array([line.u_centre_rad for line in fit.lines])
