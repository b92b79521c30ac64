"""Relative delays of several runs of one nominal delay, combined to one, as in Table 1 of Schatz 2023."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array
from irtiming.records.estimate import EDGE_DELAYS
from irtiming.records.result import RelativeDelay, Result

PAPER_TABLE_1 = (
    (0.025, 0.024998, 1.123e-6, -1.745e-6),
    (0.050, 0.049999, 1.277e-6, -0.652e-6),
    (0.075, 0.075003, 1.083e-6, 3.000e-6),
    (0.100, 0.099998, 1.137e-6, -2.021e-6),
)
"""Nominal, measured, uncertainty and deviation, s: Table 1, IRcam Equus 327k L, 20 runs each."""


@final
@dataclass(frozen=True, kw_only=True)
class CombinedDelay:
    """Mean over the runs of one nominal delay at one wheel speed, s; ``scatter_s`` is the runs' standard deviation.

    ``deviation_s`` and ``u_deviation_s`` are measured minus nominal in the generator's own time, where its clock cancels.
    """

    nominal_s: float
    rotation_speed_hz: float
    n_runs: int
    value_s: float
    standard_uncertainty_s: float
    scatter_s: float | None
    deviation_s: float
    u_deviation_s: float


def combined(analysis: Analysis, result: Result) -> list[CombinedDelay]:
    """One entry per nominal delay and wheel speed, without the reference itself, sorted; none where there is no result.

    Parameters
    ----------
    analysis
        For the noise of each recording.
    result
        One of its two; each relative delay names its file.

    Notes
    -----
    A run's relative delay is its own delay minus the mean of the reference runs. The frames' noise is independent from
    run to run and known from each fit: it averages over the runs of one nominal delay, and over the reference runs,
    which all entries share. Whatever else stands in a run's uncertainty (angle errors between wheel speeds) counts as
    common to its group and does not average. Published values of one nominal delay are already means over its runs.
    """
    noise, speed_hz = {}, {}
    for recording, fit in zip(analysis.recordings, analysis.fits, strict=True):
        file = recording.file
        noise[file] = float(fit.estimate.pick(*EDGE_DELAYS).covariance.mean())
        speed_hz[file] = recording.rotation_speed_hz
    groups: dict[tuple[float, float], list[RelativeDelay]] = {}
    for delay in result.relative_delays:
        groups.setdefault((speed_hz[delay.file], round(delay.nominal_s, 9)), []).append(delay)
    reference = [noise[delay.file] for (_, nominal), group in groups.items() if nominal == 0 for delay in group]
    reference_noise = sum(reference) / max(len(reference), 1) ** 2
    rows = []
    for (speed, nominal), group in sorted(groups.items(), key=lambda entry: entry[0]):
        if nominal == 0:
            continue
        values = np.array([delay.value_s for delay in group])
        own = result.method != "published"
        found = _mean_uncertainty(group, np.array([noise[delay.file] for delay in group]), reference_noise)
        clock = float(np.sqrt(max(0.0, group[0].standard_uncertainty_s ** 2 - group[0].deviation[1] ** 2)))
        u = found if own else group[0].deviation[1]
        rows.append(
            CombinedDelay(
                nominal_s=nominal,
                rotation_speed_hz=speed,
                n_runs=len(group),
                value_s=float(values.mean()),
                standard_uncertainty_s=float(np.hypot(u, clock)),
                scatter_s=float(values.std(ddof=1)) if own and len(group) > 1 else None,
                deviation_s=float(np.mean([delay.deviation[0] for delay in group])),
                u_deviation_s=u,
            )
        )
    return rows


def _mean_uncertainty(delays: list[RelativeDelay], noise: Array, reference_noise: float) -> float:
    """Standard uncertainty of the mean deviation of runs, s: noise averages, the reference's noise and the common rest do not.

    Where the fits' own noise exceeds what a relative delay states, because part of it cancels between recordings, it is
    scaled down to that: a single run keeps its stated uncertainty.
    """
    total = np.array([delay.deviation[1] ** 2 for delay in delays])
    scale = min(1.0, float(np.mean(total)) / max(float(np.mean(noise)) + reference_noise, 1e-60))
    common = max(0.0, float(np.mean(total)) - scale * (float(np.mean(noise)) + reference_noise))
    return float(np.sqrt(scale * (noise.sum() / noise.size**2 + reference_noise) + common))
