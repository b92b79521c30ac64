"""Uncertainties of a rolling camera's timing as figures: their parts, the wheel edges apart, and the relative delays."""

import numpy as np
from matplotlib.figure import Figure

from irtiming.report import sheet
from irtiming.report.evidence import RollingEvidence
from irtiming.report.rounding import uncertainty_text

US = 1e-6
_NAMES = ("trigger delay", "time constant", "row delay")


def budget(evidence: RollingEvidence) -> Figure:
    """Contributions to the standard uncertainties of all three, the largest of the trigger delay first, and their sums."""
    parts = sorted(evidence.result.budget, key=lambda part: part.trigger_delay_s)
    sizes = np.array([(part.trigger_delay_s, part.time_constant_s, part.row_delay_s) for part in parts])
    sizes = np.concatenate([sizes, np.sqrt(np.sum(sizes**2, axis=0))[None]])
    hues = [sheet.RED if part.kind == "B" else sheet.BLUE for part in parts] + [sheet.INK]
    names = [f"{part.source} ({part.kind})" for part in parts] + ["all together"]
    with sheet.style():
        drawn = sheet.figure(height_in=0.9 + 0.3 * len(sizes))
        for k, axes in enumerate(drawn.subplots(1, 3, sharey=True)):
            axes.barh(range(len(sizes)), sizes[:, k] / US, color=hues, alpha=0.75, height=0.62)
            largest = float(sizes[:, k].max()) / US
            for row, size in enumerate(sizes[:, k]):
                text = uncertainty_text(float(size)) if size > 1e-4 * sizes[-1, k] else "0"
                axes.annotate(text, (size / US, row), xytext=(4, 0), textcoords="offset points", va="center")
            axes.set_yticks(range(len(sizes)), names)
            axes.set_xlim(0, 1.35 * max(largest, 1e-12))
            axes.set_title(_NAMES[k])
            axes.set_xlabel("standard uncertainty (µs)")
            axes.grid(visible=False, axis="y")
    return drawn


def by_edge(evidence: RollingEvidence) -> Figure:
    """Delay of row 0 as seen from each wheel edge, about the mean of all, recording by recording."""
    mean = float(np.mean([fit.edge_delay_s for fit in evidence.row_fits]))
    n = len(evidence.row_fits)
    hues = sheet.colours([fit.trigger_delay_time_set_s for fit in evidence.row_fits])
    with sheet.style():
        drawn = sheet.figure(height_in=2.7)
        axes = drawn.add_subplot()
        for k, (fit, hue) in enumerate(zip(evidence.row_fits, hues, strict=True)):
            axes.errorbar(
                np.arange(4) + (0.5 * (k + 0.5) / n - 0.25), (fit.edge_delay_s - mean) / US,
                yerr=fit.estimate.standard_uncertainties[:4] / US, fmt="o", color=hue, markersize=4, elinewidth=1,
                capsize=2, label=f"{fit.name}" if n <= 8 else None,
            )  # fmt: skip
        sheet.zero_line(axes)
        axes.set_xticks(range(4), [f"edge {k}\n{'un' if k % 2 else ''}covers" for k in range(4)])
        axes.set_xlim(-0.5, 3.5)
        axes.grid(visible=False, axis="x")
        axes.set_xlabel("wheel edge (1)")
        axes.set_ylabel(f"delay − {mean / US:.1f} µs (µs)")
        if n <= 8:
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return drawn


def relative(evidence: RollingEvidence) -> Figure:
    """Relative delays of all recordings by both methods: measured minus nominal."""
    with sheet.style():
        drawn = sheet.figure(height_in=2.9)
        panels = drawn.subplots(1, 2)
        for axes, result, hue, name in zip(
            panels, (evidence.best, evidence.as_published), (sheet.BLUE, sheet.ORANGE), ("Row sums", "As published"),
            strict=True,
        ):  # fmt: skip
            entries = result.relative_delays
            sheet.zero_line(axes)
            axes.errorbar(
                [1e3 * entry.nominal_s for entry in entries],
                [(entry.value_s - entry.nominal_s) / US for entry in entries],
                yerr=[entry.standard_uncertainty_s / US for entry in entries], fmt="o", color=hue, markersize=4.5,
                capsize=3,
            )  # fmt: skip
            axes.set_title(name)
            axes.set_xlabel("nominal relative delay (ms)")
            axes.set_ylabel("measured − nominal (µs)")
            axes.margins(x=0.15)
    return drawn
