"""Prediction and outcome side by side: whether the estimation tells as much as the recordings hold."""

from irtiming.records.prediction import Prediction
from irtiming.report.combination import combined
from irtiming.report.evidence import Evidence, RollingEvidence
from irtiming.report.rounding import uncertainty_text
from irtiming.report.tables import Table

_NOTE = (
    "Predicted: from the Fisher information of the model, with the noise of the frames as found, taken as white, and the rig's "
    "angle errors; no estimate takes part in it. A ratio of 1: all that the recordings hold was used. Above 1: residuals "
    "hang together, runs scatter more than their noise, or the recordings show something that noise and rig do not explain."
)


def compared(evidence: Evidence) -> tuple[Table, ...]:
    """The table for a photon camera, by pixel sums; none where nothing was predicted."""
    found = evidence.prediction
    if found is None:
        return ()
    estimate = evidence.best.estimate
    rows = _parameters(found, dict(zip(estimate.names, estimate.standard_uncertainties.tolist(), strict=True)))
    stated = {
        (round(row.nominal_s, 9), row.rotation_speed_hz): row.standard_uncertainty_s
        for row in combined(evidence, evidence.best)
    }
    several = len({speed for _, speed in stated}) > 1
    for each in found.relative_delays:
        at = f" at {each.rotation_speed_hz:g} Hz" if several else ""
        rows.append(
            _row(
                f"relative delay of {1e3 * each.nominal_s:g} ms{at}",
                each.standard_uncertainty_s,
                stated.get((round(each.nominal_s, 9), each.rotation_speed_hz)),
                limit="",
            )
        )
    return (_table(rows),)


def compared_rolling(evidence: RollingEvidence) -> tuple[Table, ...]:
    """The table for a rolling camera, by row sums; none where nothing was predicted."""
    found = evidence.prediction
    if found is None:
        return ()
    estimate = evidence.best.estimate
    return (
        _table(_parameters(found, dict(zip(estimate.names, estimate.standard_uncertainties.tolist(), strict=True)))),
    )


def _parameters(found: Prediction, stated: dict[str, float]) -> list[tuple[str, ...]]:
    return [
        _row(each.name, each.standard_uncertainty_s, stated.get(each.name), limit=each.largest_part.source)
        for each in found.uncertainties
    ]


def _row(name: str, predicted_s: float, stated_s: float | None, *, limit: str) -> tuple[str, ...]:
    ratio = "–" if stated_s is None or predicted_s <= 0 else f"{stated_s / predicted_s:.2f}"
    return name, uncertainty_text(predicted_s), "–" if stated_s is None else uncertainty_text(stated_s), ratio, limit


def _table(rows: list[tuple[str, ...]]) -> Table:
    return Table(
        title="Prediction and outcome",
        columns=("parameter", "u predicted", "u stated", "stated / predicted", "largest part of the prediction"),
        align="lrrrl",
        rows=tuple(rows),
        note=_NOTE,
    )
