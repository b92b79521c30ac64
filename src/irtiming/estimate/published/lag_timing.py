"""The published fits of all nominal delays as one result (Schatz 2023, 3.2.4): the baseline."""

from collections.abc import Sequence

import numpy as np

from irtiming.records.estimate import Estimate
from irtiming.records.finding import Finding
from irtiming.records.lag_estimate import LagTiming, PublishedLagFit
from irtiming.records.result import Contribution, RelativeDelay, Result

NAMES = ("trigger_delay", "time_constant", "row_delay")


def estimate(fits: Sequence[PublishedLagFit]) -> Result:
    """Means over the nominal delays and wheel speeds; the paper has a single one.

    Parameters
    ----------
    fits
        One per nominal delay and wheel speed.
    """
    values = np.array([_three(fit.timing) for fit in fits])
    u = np.array([_three(fit.u_timing) for fit in fits])
    covariance = np.diag(np.mean(u**2, axis=0) / len(fits))
    scatter = np.sqrt(np.diag(covariance))
    return Result(
        method="published",
        estimate=Estimate(names=NAMES, units=("s",) * len(NAMES), values=values.mean(axis=0), covariance=covariance),
        relative_delays=_relative(fits),
        budget=(
            Contribution(
                source="scatter of the line and of the parabola",
                kind="A",
                standard_uncertainty=dict(zip(NAMES, scatter.tolist(), strict=True)),
            ),
        ),
        edge_delay_s=np.full(4, np.nan),
        u_edge_delay_s=np.full(4, np.nan),
        findings=(
            *dict.fromkeys(one for fit in fits for one in fit.findings),
            Finding(
                code="published-lag-uncertainty-partial",
                severity="warning",
                what="published method: the stated uncertainties hold the scatter of the line and of the parabola only, not "
                "those of mask, gates, edges, slots, blur, latencies and clock",
            ),
        ),
    )


def _three(timing: LagTiming) -> tuple[float, float, float]:
    return timing.trigger_delay_s, timing.time_constant_s, timing.row_delay_s


def _relative(fits: Sequence[PublishedLagFit]) -> tuple[RelativeDelay, ...]:
    """Delay of each recording minus that of the smallest set delay at its wheel speed; runs of one delay share a fit."""
    entries = []
    for fit in fits:
        same = [other for other in fits if other.data.rotation_speed_hz == fit.data.rotation_speed_hz]
        reference = min(same, key=lambda other: other.data.trigger_delay_time_set_s)
        nominal = fit.data.trigger_delay_time_set_s - reference.data.trigger_delay_time_set_s
        apart = fit.timing.trigger_delay_s - reference.timing.trigger_delay_s
        u = float(np.hypot(fit.u_timing.trigger_delay_s, reference.u_timing.trigger_delay_s))
        entries += [
            RelativeDelay(
                file=file,
                nominal_s=nominal,
                value_s=nominal + apart,
                standard_uncertainty_s=0.0 if fit is reference else u,
            )
            for file in fit.data.files
        ]
    return tuple(entries)
