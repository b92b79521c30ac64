"""Every table of a rolling camera's report as plain text cells, for the page and the terminal alike."""

from collections.abc import Iterable

import numpy as np

from irtiming.records.rolling_result import Bound, RollingContribution, RollingResult
from irtiming.records.row_timing import RowTimingFit
from irtiming.report import budget as budget_of
from irtiming.report import rolling_noise, row_curves
from irtiming.report.drift_figures import frame_time_s
from irtiming.report.evidence import RollingEvidence
from irtiming.report.rounding import fixed, signed, significant, time_text, time_unit, uncertainty_text
from irtiming.report.tables import RELATIVE_SIGN, SIGN, Table

MS, US = 1e-3, 1e-6
NAMES = ("trigger_delay", "time_constant", "row_delay")
_SYMBOLS = {"trigger_delay": "t_delay", "time_constant": "τ", "row_delay": "t_row"}
_NO_SHARE = 1e-8
METHOD_NAMES = {"row-sum": "row sums", "published": "as published (Schatz 2023)"}
EVENTS = {
    "trigger_delay": "reading of image row 0 (y = 0); row y is read at trigger_delay + y · row_delay",
    "time_constant": "63 % response of a pixel to a step of the scene",
    "row_delay": "from the reading of one image row to that of the row below it",
}
"""What happens at the end of the time that a parameter tells."""

SIGNS = {
    "trigger_delay": SIGN,
    "time_constant": "never negative",
    "row_delay": "positive: rows are read from the top down; negative: from the bottom up",
}

RELATIVE_EVENT = "reading of image row 0, counted from that of the smallest set delay"


def parameters(evidence: RollingEvidence) -> Table:
    """The parameters of the chosen method: value, standard uncertainty u, expanded uncertainty U, event and sign."""
    result = evidence.result
    rows = []
    for name, value, u in entries(result):
        expanded = budget_of.expanded_text(u, budget_of.of_rolling(result, name).degrees_of_freedom)
        rows.append((name, time_text(value, u), *expanded, EVENTS[name], SIGNS[name]))
    rows += [
        (bound.name, bound_text(bound), "–", "–", EVENTS[bound.name], SIGNS[bound.name]) for bound in result.bounds
    ]
    return Table(
        title="Timing of the camera",
        columns=("parameter", "value ± u", "U = k u", "k", "what it is", "sign"),
        align="lrrrll",
        rows=tuple(rows),
        note="Delays count from the trigger edge. The delay set in the trigger generator is taken off. u is the standard "
        f"uncertainty (k = 1); value ± U holds the true one with {budget_of.COVERAGE_PERCENT} % probability. "
        f"Method: {METHOD_NAMES[result.method]}.",
    )


def entries(result: RollingResult) -> Iterable[tuple[str, float, float]]:
    """Name, value and standard uncertainty of each determined parameter, s."""
    estimate = result.estimate
    for name, value, u in zip(estimate.names, estimate.values, estimate.standard_uncertainties, strict=True):
        yield name, float(value), float(u)


def bound_text(bound: Bound) -> str:
    """What is known of a parameter that is not determined, in words."""
    if bound.lower_s is not None and bound.upper_s is not None:
        return f"{_short(bound.lower_s)} … {_short(bound.upper_s)}"
    if bound.upper_s is not None:
        return f"below {_short(bound.upper_s)}"
    return "not determined" if bound.lower_s is None else f"above {_short(bound.lower_s)}"


def _short(value_s: float) -> str:
    factor, unit = time_unit(value_s)
    return f"{value_s / factor:.3g} {unit}".replace("-", "−")


def both_methods(evidence: RollingEvidence) -> Table:
    """The same parameters by row sums and by the published procedure, side by side."""
    ours = {name: (value, u) for name, value, u in entries(evidence.best)}
    theirs = {name: (value, u) for name, value, u in entries(evidence.as_published)}
    bounds = {
        bound.name: bound_text(bound) for result in (evidence.best, evidence.as_published) for bound in result.bounds
    }
    rows = []
    for name in NAMES:
        if name not in ours or name not in theirs:
            texts = [time_text(*found[name]) if name in found else bounds.get(name, "–") for found in (ours, theirs)]
            rows.append((name, *texts, "–"))
            continue
        (value, u), (other, u_other) = ours[name], theirs[name]
        difference = f"{signed(other - value, float(np.hypot(u, u_other)), unit_s=US)} µs"
        rows.append((name, time_text(value, u), time_text(other, u_other), difference))
    return Table(
        title="Both methods",
        columns=("parameter", "row sums", "as published", "published − row sums"),
        align="lrrr",
        rows=tuple(rows),
        note=f"Trigger delay: {EVENTS['trigger_delay']}; {SIGN}. "
        "Row sums: an exact model of all rows at once, with the blurred edges of mask and light, learned slots and one "
        "delay per wheel edge. As published: binary mask, equal slots, simulated rows, a straight line over the rows and a "
        "parabola over the time constant; its u holds the scatter of these two only. The paper’s camera: τ 4.819 ms, "
        "t_delay 3.872 ms, t_row 38.76 µs.",
    )


def noise(evidence: RollingEvidence) -> Table:
    """How well noise alone lets trigger delay and time constant be told apart."""
    found = rolling_noise.noise(evidence.row_fits)
    rows = [(name, uncertainty_text(float(u))) for name, u in zip(NAMES, found.u_s, strict=True)]
    rows.append(("trigger_delay − time_constant", uncertainty_text(found.u_difference_s)))
    rows.append(("trigger_delay + time_constant", uncertainty_text(found.u_sum_s)))
    return Table(
        title="What the noise of the frames allows",
        columns=("quantity", "u from noise alone"),
        align="lr",
        rows=tuple(rows),
        note="Of the mean over all recordings and wheel edges; the budget adds the rig’s angles and the opening’s shape.",
    )


def noise_sentence(evidence: RollingEvidence) -> str:
    """What the correlation of trigger delay and time constant means."""
    found = rolling_noise.noise(evidence.row_fits)
    ratio = float(found.correlation[0, 1])
    better, u_better = ("difference", found.u_difference_s) if ratio > 0 else ("sum", found.u_sum_s)
    worse = float(found.u_s[:2].max())
    return (
        f"Noise correlates trigger delay and time constant by {fixed(ratio, 3)}: a lag of τ shows each long slope as it was "
        "τ ago, which a reading later by the same time makes up for; only the rounding of the corners tells one from the "
        f"other. So their {better} is known to {uncertainty_text(u_better)} from noise, each alone to "
        f"{uncertainty_text(worse)} or better."
    )


def correlation(evidence: RollingEvidence) -> Table:
    """Correlation of the parameters with all parts of their uncertainty."""
    estimate = evidence.result.estimate
    rows = tuple(
        (name, *(fixed(float(value), 3) for value in row))
        for name, row in zip(estimate.names, estimate.correlation, strict=True)
    )
    return Table(
        title="Correlation of the parameters",
        columns=("", *estimate.names),
        align="l" + "r" * len(estimate.names),
        rows=rows,
        note="With all parts of the budget. Noise alone correlates trigger delay and time constant by "
        f"{fixed(float(rolling_noise.noise(evidence.row_fits).correlation[0, 1]), 3)}; angles of the rig move the trigger delay "
        "alone: where they are its largest part, little is left of that.",
    )


def budget(evidence: RollingEvidence) -> Table:
    """Uncertainty budget of all three parameters, the largest part of the trigger delay first."""
    found = [budget_of.of_rolling(evidence.result, name) for name in NAMES]
    parts = sorted(evidence.result.budget, key=lambda part: -part.trigger_delay_s)
    rows = [
        (
            part.source,
            part.kind,
            budget_of.freedom_text(part.degrees_of_freedom),
            *(
                _cell(size, budget_of.share(whole, part.source))
                for size, whole in zip(_sizes(part), found, strict=True)
            ),
        )
        for part in parts
    ]
    rows.append(
        (
            "all together (root of the sum of squares)",
            "",
            "",
            *(_micro(whole.standard_uncertainty_s) for whole in found),
        )
    )
    freedoms = [budget_of.freedom_text(whole.degrees_of_freedom) for whole in found]
    rows.append(("ν, all together", "", "", *freedoms))
    return Table(
        title="Uncertainty budget",
        columns=(
            "source", "type", "ν", "trigger delay: u (µs)", "time constant: u (µs)", "row delay: u (µs)",
        ),
        align="lcrrrr",
        rows=tuple(rows),
        note="In brackets the share of u². Type A: from the scatter of this measurement; type B: from rig.toml. Angle errors "
        "become times by division through the wheel’s angular frequency and do not touch time constant and row delay. ν, degrees "
        "of freedom: how well u itself is known; those of the sums by Welch and Satterthwaite.",
    )  # fmt: skip


def _sizes(part: RollingContribution) -> tuple[float, float, float]:
    return part.trigger_delay_s, part.time_constant_s, part.row_delay_s


def largest_part(evidence: RollingEvidence, name: str) -> tuple[RollingContribution, float] | None:
    """The budget line that weighs most in a parameter, and its standard uncertainty there, s; None with fewer than two."""
    parts = evidence.result.budget
    if len(parts) < 2:
        return None
    largest = max(parts, key=lambda part: _sizes(part)[NAMES.index(name)])
    return largest, _sizes(largest)[NAMES.index(name)]


def _cell(size_s: float, share: float) -> str:
    return "0" if share < _NO_SHARE else f"{_micro(size_s)} ({budget_of.share_text(share)})"


def _micro(value_s: float) -> str:
    return "–" if not np.isfinite(value_s) or value_s <= 0 else significant(value_s / US)


def relative_delays(evidence: RollingEvidence) -> Table:
    """Relative delay of every recording by both methods, µs from nominal; no rows with a single set delay."""
    rows = []
    several = len({round(entry.nominal_s, 9) for entry in evidence.best.relative_delays}) > 1
    ours = evidence.best.relative_delays
    theirs = evidence.as_published.relative_delays or (None,) * len(ours)
    for best, published in zip(ours, theirs, strict=True):
        cells = []
        for delay in (best, published):
            if delay is None:
                cells += ["–", "–"]
                continue
            u = delay.standard_uncertainty_s
            cells += [signed(delay.value_s - delay.nominal_s, u, unit_s=US) if u > 0 else "reference", _micro(u)]
        rows.append((best.file, f"{best.nominal_s / MS:g}", *cells))
    return Table(
        title="Relative delays, recording by recording",
        columns=(
            "recording", "nominal (ms)", "row sums: deviation (µs)", "u (µs)",
            "published: deviation (µs)", "published: u (µs)",
        ),
        align="lrrrrr",
        rows=tuple(rows) if several else (),
        note="Deviation is measured minus nominal; the trigger generator sets delays to a tick of its clock. Row sums: time "
        f"constant and row delay are taken as one for all recordings. Relative delay: {RELATIVE_EVENT}; {RELATIVE_SIGN}.",
    )  # fmt: skip


def fits(evidence: RollingEvidence) -> Table:
    """Quality of each fit."""
    rows = []
    for recording, fit in zip(evidence.recordings, evidence.row_fits, strict=True):
        whole = row_curves.whole(fit).residual
        rows.append(
            (
                fit.name,
                f"{recording.frame_index.size} of {recording.n_frames}",
                f"{fit.row_px.size} ({fit.row_px[0]} … {fit.row_px[-1]})",
                significant(1e3 * float(np.sqrt(np.mean(whole**2)))),
                significant(1e3 * float(np.median(fit.noise))),
                f"{fit.widening**0.5:.2f}",
                _parameter(fit, "time_constant", MS),
                _parameter(fit, "row_delay", US),
            )
        )
    return Table(
        title="Fits, recording by recording",
        columns=(
            "recording", "frames used", "rows", "rms residual, whole opening (10⁻³)", "median row (10⁻³)",
            "widening of u", "time constant (ms)", "row delay (µs)",
        ),
        align="lrrrrrrr",
        rows=tuple(rows),
        note="Residuals in 10⁻³ of the step from covered to open. Widening: factor on the uncertainties because residuals are "
        "correlated; 1 when they are white.",
    )  # fmt: skip


def _parameter(fit: RowTimingFit, name: str, unit_s: float) -> str:
    value_s, u = fit.estimate.value(name), fit.estimate.u(name)
    text = time_text(value_s / unit_s, u / unit_s)
    return text.rsplit(" ", 1)[0] if text.endswith(" s") else f"{value_s / unit_s:.6g} ± {significant(u / unit_s)}"


def searches(evidence: RollingEvidence) -> Table:
    """Where each fit began and where it ended: a fit that stays at its start has found nothing."""
    rows = []
    for fit in evidence.row_fits:
        ends = fit.timing | {"edge_delay_0": float(fit.edge_delay_s.mean())}
        names = ("edge_delay_0", "time_constant", "row_delay")
        moves = [f"{time_text(fit.start[name])} → {time_text(ends[name])}" for name in names]
        rows.append((f"row sums, {fit.name}", *moves, f"{fit.n_steps} steps"))
    joint = evidence.likelihood
    moves = [f"{time_text(start)} → {time_text(end)}" for start, end in zip(joint.start, joint.values, strict=True)]
    rows.append(("row sums, one likelihood", *(str(move) for move in moves), f"{joint.n_steps} steps"))
    for published in evidence.published_fits:
        begun, found = published.initial_timing, published.timing
        pairs = (
            (begun.trigger_delay_s, found.trigger_delay_s),
            (begun.time_constant_s, found.time_constant_s),
            (begun.row_delay_s, found.row_delay_s),
        )
        moves = [f"{time_text(start)} → {time_text(end)}" for start, end in pairs]
        name = f"published, {published.data.names[0]}"
        rows.append((name, *moves, f"{published.n_simulations} simulations"))
    return Table(
        title="Start and end of each search",
        columns=("fit", "trigger delay", "time constant", "row delay", "work"),
        align="lrrrr",
        rows=tuple(rows),
        note="Row sums and contrast image are fitted in rounds: a later round begins where the one before ended. One likelihood: "
        "of all recordings together, begun at the numbers of one of them; the result is its parabola. Trigger delay: "
        f"reading of image row 0; {SIGN}.",
    )


def shutter_events(evidence: RollingEvidence) -> Table:
    """When the camera corrected itself."""
    rows = []
    for recording in evidence.recordings:
        for event in recording.shutter_events:
            start, end = frame_time_s(recording, np.array([event.first_frame, event.end_frame], float))
            frames = f"{event.first_frame} … {event.end_frame - 1}"
            what = "shutter closed" if event.kind == "closed" else "frame repeated"
            rows.append((recording.name, what, frames, fixed(float(start), 2), fixed(float(end - start), 2)))
    return Table(
        title="Corrections by the camera itself",
        columns=("recording", "what", "frames", "after the first kept frame (s)", "for (s)"),
        align="llrrr",
        rows=tuple(rows),
        note="These frames and those around them are left out; each stretch between them has its own level.",
    )


def beside_the_truth(evidence: RollingEvidence, truth_s: dict[str, float]) -> Table:
    """Both methods beside the true values of a simulated camera, and how many standard uncertainties they are off."""
    found = [
        {name: (value, u) for name, value, u in entries(result)} for result in (evidence.best, evidence.as_published)
    ]
    rows = []
    for name in NAMES:
        factor, unit = time_unit(truth_s[name])
        cells = [f"{truth_s[name] / factor:.5g} {unit}"]
        for ours in found:
            if name not in ours:
                cells += ["not determined", "–"]
                continue
            value, u = ours[name]
            cells += [time_text(value, u), f"{(value - truth_s[name]) / u:+.1f}".replace("-", "−")]
        rows.append((_SYMBOLS[name], *cells))
    return Table(
        title="Timing of the simulated microbolometer camera",
        columns=("", "true", "row sums", "off/u", "as published", "off/u"),
        align="lrrrrr",
        rows=tuple(rows),
        note=f"t_delay: reading of image row 0; {SIGN}.",
    )
