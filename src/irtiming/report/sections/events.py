"""Events of a camera that runs free: how they scatter, and how their clock is related to the counter."""

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.reduced import ReducedRecording
from irtiming.report.blocks import Section, Table, micro
from irtiming.report.language import decimal, t
from irtiming.report.result_of_inputs import JITTER_QUANTILES

_TITLES = {
    "strobe": "Strobe of the camera",
    "stamp": "Time stamps of the frames",
    "arrival": "Arrival of the frames",
}
_NOTES = {
    "strobe": "Each delay counts from the frame's own strobe edge, wherever the grid has it.",
    "stamp": "A delay counts from the grid: half of the stamps come later.",
    "arrival": "A delay counts from the grid: half of the frames arrive later. Quantiles: of the latency less its median.",
}


def section(analysis: Analysis) -> Section | None:
    """Jitter and clock of each recording; None where the camera was triggered."""
    events = analysis.recordings[0].events
    if events is None:
        return None
    table = Table(
        title=t("Events of the frames about their regular grid"),
        columns=(t("recording"), t("period (ms)"), t("s (µs)"), *(decimal(f"{100 * q:g} % (µs)") for q in JITTER_QUANTILES),
                 t("u of grid (µs)"), t("u of clock (µs)"), t("clock (ppm)")),
        align="l" + "r" * (5 + len(JITTER_QUANTILES)),
        rows=tuple(_row(one) for one in analysis.recordings),
        note=t(_NOTES[events.kind]),
    )  # fmt: skip
    return Section(title=t(_TITLES[events.kind]), blocks=(table,))


def _row(one: ReducedRecording) -> tuple[str, ...]:
    found = one.events
    if found is None:
        return (one.name, *("–",) * (5 + len(JITTER_QUANTILES)))
    rate = found.relative_rate
    return (
        one.name,
        decimal(f"{1e3 * found.period_s:.6f}"),
        micro(float(found.deviation_s.std(ddof=1))),
        *(decimal(f"{1e6 * np.quantile(found.deviation_s, share):.2f}") for share in JITTER_QUANTILES),
        micro(found.u_grid_s),
        micro(found.u_clock_s),
        "–" if rate is None else decimal(f"{1e6 * rate:+.2f}"),
    )
