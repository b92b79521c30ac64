"""The delays: per wheel edge, the budget of their uncertainty, and the relative delays beside the paper's Table 1."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irtiming.records.estimate import DelayResult
from irtiming.report import sheet
from irtiming.report.combination import PAPER_TABLE_1, combined
from irtiming.report.evidence import Evidence
from irtiming.report.rounding import uncertainty_text

US = 1e-6
_EDGE_NAMES = tuple(f"edge {edge}\n{what}" for edge, what in enumerate(("covers\n(falling)", "uncovers\n(rising)") * 2))


def by_edge(evidence: Evidence) -> Figure:
    """Delay as seen from each wheel edge by both methods, and the pixel sums' about their mean, recording by recording."""
    with sheet.style():
        drawn = sheet.figure(height_in=3.3)
        left, right = drawn.subplots(1, 2)
        for result, shift, colour, marker, label in (
            (evidence.best, -0.1, sheet.BLUE, "o", "pixel sums"),
            (evidence.as_published, 0.1, sheet.ORANGE, "s", "as published"),
        ):
            left.errorbar(
                np.arange(4) + shift, result.edge_delay_s / US, yerr=result.u_edge_delay_s / US, fmt=marker,
                color=colour, markersize=5, capsize=3, label=label,
            )  # fmt: skip
        left.set_title("Both methods")
        left.set_ylabel(f"delay of the {_event(evidence)} (µs)")
        left.legend(loc="best")
        mean = float(evidence.best.edge_delay_s.mean())
        n = len(evidence.edge_fits)
        hues = sheet.colours([(one.trigger_delay_time_set_s, one.rotation_speed_hz) for one in evidence.recordings])
        for k, (fit, hue) in enumerate(zip(evidence.edge_fits, hues, strict=True)):
            right.errorbar(
                np.arange(4) + (0.5 * (k + 0.5) / n - 0.25), (fit.edge_delay_s - mean) / US,
                yerr=np.sqrt(np.diag(fit.covariance_s2)) / US, fmt=".", color=hue, markersize=5, elinewidth=0.9,
            )  # fmt: skip
        sheet.zero_line(right)
        right.set_title("Pixel sums, single recordings")
        right.set_ylabel(f"delay − {mean / US:.2f} µs (µs)")
        for axes in (left, right):
            axes.set_xticks(range(4), _EDGE_NAMES)
            axes.set_xlim(-0.5, 3.5)
            axes.set_xlabel("wheel edge (1)")
            axes.grid(visible=False, axis="x")
    return drawn


def _event(evidence: Evidence) -> str:
    return "start of integration" if "trigger_delay" in evidence.best.estimate.names else "middle of integration"


def budget(evidence: Evidence) -> Figure:
    """Contributions to the standard uncertainty of the delay, largest first, and their sum in quadrature."""
    parts = sorted(evidence.result.budget, key=lambda part: part.standard_uncertainty_s)
    total = float(np.sqrt(sum(part.standard_uncertainty_s**2 for part in parts)))
    names = [f"{part.source} ({part.kind})" for part in parts] + ["all together"]
    sizes = [part.standard_uncertainty_s for part in parts] + [total]
    with sheet.style():
        drawn = sheet.figure(height_in=0.9 + 0.3 * len(sizes))
        axes = drawn.add_subplot()
        hues = [sheet.RED if part.kind == "B" else sheet.BLUE for part in parts] + [sheet.INK]
        axes.barh(range(len(sizes)), np.array(sizes) / US, color=hues, alpha=0.75, height=0.62)
        for row, size in enumerate(sizes):
            axes.annotate(
                uncertainty_text(size), (size / US, row), xytext=(4, 0), textcoords="offset points", va="center"
            )
        axes.set_yticks(range(len(sizes)), names)
        axes.set_xlim(0, 1.15 * max(*sizes, 1e-12) / US)
        axes.set_xlabel("standard uncertainty of the trigger delay (µs)")
        axes.grid(visible=False, axis="y")
    return drawn


def relative(evidence: Evidence) -> Figure:
    """Relative delays: measured minus nominal, by both methods, beside what the paper printed for its camera."""
    with sheet.style():
        drawn = sheet.figure(height_in=3.2)
        axes = drawn.add_subplot()
        sheet.zero_line(axes)
        paper = np.array([(nominal, deviation, u) for nominal, _, u, deviation in PAPER_TABLE_1])
        axes.errorbar(
            1e3 * paper[:, 0], paper[:, 1] / US, yerr=paper[:, 2] / US, fmt="D", color=sheet.FAINT, markersize=4.5,
            capsize=3, label="Schatz 2023, Table 1 (another camera)",
        )  # fmt: skip
        _deviations(axes, evidence, evidence.as_published, sheet.ORANGE)
        _deviations(axes, evidence, evidence.best, sheet.BLUE)
        axes.set_xlabel("nominal relative delay (ms)")
        axes.set_ylabel("measured − nominal (µs)")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.17), ncols=3)
    return drawn


def _deviations(axes: Axes, evidence: Evidence, result: DelayResult, colour: str) -> None:
    rows = combined(evidence, result)
    ours = result.method == "pixel-sum"
    shift = -1.0 if ours else 1.0
    axes.errorbar(
        [1e3 * row.nominal_s + shift for row in rows], [row.deviation_s / US for row in rows],
        yerr=[row.standard_uncertainty_s / US for row in rows], fmt="o" if ours else "s", color=colour, markersize=5,
        capsize=3, label="pixel sums" if ours else "as published",
    )  # fmt: skip
