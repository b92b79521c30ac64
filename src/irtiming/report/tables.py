"""Every table of the report as plain text cells, for the page and the terminal alike."""

import platform
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import metadata
from itertools import zip_longest
from typing import TypeVar, final

import numpy as np

from irtiming.records.estimate import DelayResult
from irtiming.records.reduced import ReducedRecording
from irtiming.report import budget as budget_of
from irtiming.report.combination import PAPER_TABLE_1, combined
from irtiming.report.evidence import Evidence
from irtiming.report.rounding import fixed, in_unit, signed, significant, time_text

MS, US = 1e-3, 1e-6
_T = TypeVar("_T")
REFERENCE_EVENTS = {
    "trigger_delay": "start of integration",
    "exposure_midpoint_delay": "middle of integration",
    "trigger_delay_falling": "start of integration, falling slopes only",
    "trigger_delay_rising": "start of integration, rising slopes only",
    "integration_time": "length of the integration window",
}
"""What happens at the time that a parameter tells; delays count from the trigger edge, positive after it."""

SIGN = "positive: after the trigger edge that the camera accepts"
RELATIVE_EVENT = "integration, counted from that of the smallest set delay"
RELATIVE_SIGN = "positive: later"
RELATIVE_NOTE = f"Relative delay: {RELATIVE_EVENT}; {RELATIVE_SIGN}."
METHOD_NAMES = {"pixel-sum": "pixel sums", "published": "as published (Schatz 2023)"}


@final
@dataclass(frozen=True, kw_only=True)
class Table:
    """Title, head and rows of cells; ``align`` has one letter per column, l, c or r; ``note`` stands below."""

    title: str
    columns: tuple[str, ...]
    align: str
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def __post_init__(self) -> None:
        widths = {len(self.columns), len(self.align), *(len(row) for row in self.rows)}
        if len(widths) != 1:
            raise ValueError(
                f"table '{self.title}' has rows of {sorted(widths)} cells; all must have as many as its head"
            )


def parameters(evidence: Evidence) -> Table:
    """The delays of the chosen method: value, standard uncertainty u and expanded uncertainty U, with event and sign."""
    rows = []
    for name, value, u in _entries(evidence.result):
        expanded = budget_of.expanded_text(u, budget_of.degrees_of_freedom(evidence.result, name))
        rows.append((name, time_text(value, u), *expanded, REFERENCE_EVENTS.get(name, "")))
    split = budget_of.falling_minus_rising(evidence.result)
    if split is not None:
        expanded = budget_of.expanded_text(split.standard_uncertainty_s, split.degrees_of_freedom)
        rows.append(
            ("falling − rising", time_text(split.value_s, split.standard_uncertainty_s), *expanded, "0 expected")
        )
    return Table(
        title="Delays of the camera",
        columns=("parameter", "value ± u", "U = k u", "k", "event"),
        align="lrrrl",
        rows=tuple(rows),
        note=f"Delays: time from the trigger edge to the event, {SIGN}. The delay set in the trigger generator is taken off. "
        f"u is the standard uncertainty (k = 1); value ± U holds the true one with {budget_of.COVERAGE_PERCENT} % probability. "
        f"Method: {METHOD_NAMES[evidence.result.method]}.",
    )


def _entries(result: DelayResult) -> Iterable[tuple[str, float, float]]:
    estimate = result.estimate
    for name, value, u in zip(estimate.names, estimate.values, estimate.standard_uncertainties, strict=True):
        yield name, float(value), float(u)


def relative_delays(evidence: Evidence, result: DelayResult | None = None) -> Table:
    """Table 1: relative delays per nominal delay, beside those that the paper printed for its camera."""
    chosen = result or evidence.result
    paper = {round(nominal, 9): entry for nominal, *entry in PAPER_TABLE_1}
    rows = []
    ours = combined(evidence, chosen)
    several = len({row.rotation_speed_hz for row in ours}) > 1
    for row in ours:
        measured, u_paper, deviation = paper.pop(row.nominal_s, (None, None, None))
        speed = f" at {row.rotation_speed_hz:g} Hz" if several else ""
        rows.append(
            (
                f"{row.nominal_s / MS:g}{speed}",
                str(row.n_runs),
                in_unit(row.value_s, row.standard_uncertainty_s, unit_s=MS),
                _micro(row.standard_uncertainty_s),
                signed(row.deviation_s, row.standard_uncertainty_s, unit_s=US),
                "–" if row.scatter_s is None else _micro(row.scatter_s),
                *_paper_cells(measured, u_paper, deviation),
            )
        )
    rows += [(f"{nominal / MS:g}", "–", "–", "–", "–", "–", *_paper_cells(*entry)) for nominal, entry in paper.items()]
    return Table(
        title=f"Relative trigger delays, {METHOD_NAMES[chosen.method]}",
        columns=(
            "nominal (ms)", "runs", "measured (ms)", "u (µs)", "deviation (µs)", "scatter of runs (µs)",
            "paper: measured (ms)", "paper: u (µs)", "paper: deviation (µs)",
        ),
        align="rrrrrrrrr",
        rows=tuple(rows),
        note="Ours: this camera. Paper: Schatz 2023, Table 1, IRcam Equus 327k L, 20 runs each. u is the standard "
        "uncertainty of the mean over the runs; noise averages over runs, what they have in common does not. Scatter is "
        f"the standard deviation of single runs. {RELATIVE_NOTE}",
    )  # fmt: skip


def _micro(value_s: float) -> str:
    return "–" if value_s <= 0 else significant(value_s / US)


def _paper_cells(measured: float | None, u: float | None, deviation: float | None) -> tuple[str, str, str]:
    """As printed, to the last digit."""
    if measured is None or u is None or deviation is None:
        return "–", "–", "–"
    return (
        f"{measured / MS:.3f}",
        f"{u / US:.3f}",
        fixed(deviation / US, 3),
    )


def beside_the_paper(evidence: Evidence) -> Table:
    """Table 1 in short: deviation from the nominal delay, the paper's, and ours by both methods."""
    paper = {round(nominal, 9): (u, deviation) for nominal, _, u, deviation in PAPER_TABLE_1}
    rows = []
    both = combined(evidence, evidence.best), combined(evidence, evidence.as_published)
    for best, published in zip_longest(*both):
        u_paper, deviation = paper.get(best.nominal_s, (None, None))
        cells = [
            "–" if row is None
            else f"{signed(row.deviation_s, row.standard_uncertainty_s, unit_s=US)} ± {_micro(row.standard_uncertainty_s)}"
            for row in (published, best)
        ]  # fmt: skip
        printed = "–" if u_paper is None or deviation is None else f"{deviation / US:+.3f} ± {u_paper / US:.3f}"
        rows.append((f"{best.nominal_s / MS:g}", printed.replace("-", "−"), *cells))
    return Table(
        title="Relative trigger delays: deviation from nominal in µs (Table 1)",
        columns=("nominal (ms)", "the paper's camera", "here, as published", "here, pixel sums"),
        align="rrrr",
        rows=tuple(rows),
        note=RELATIVE_NOTE,
    )


def relative_delays_by_file(evidence: Evidence) -> Table:
    """Relative delay of every recording by both methods, µs from nominal."""
    rows = []
    for best, published in zip_longest(evidence.best.relative_delays, evidence.as_published.relative_delays):
        cells = []
        for delay in (best, published):
            if delay is None:
                cells += ["–", "–"]
                continue
            u = delay.standard_uncertainty_s
            deviation = delay.value_s - delay.nominal_s
            cells += [signed(deviation, u, unit_s=US) if u > 0 else "reference", _micro(u)]
        rows.append((best.file, f"{best.nominal_s / MS:g}", *cells))
    return Table(
        title="Relative delays, recording by recording",
        columns=(
            "recording", "nominal (ms)", "pixel sums: deviation (µs)", "u (µs)",
            "published: deviation (µs)", "published: u (µs)",
        ),
        align="lrrrrr",
        rows=tuple(rows),
        note="Deviation is measured minus nominal. The published method averages the runs of one nominal delay, which "
        f"share their value. {RELATIVE_NOTE}",
    )  # fmt: skip


def both_methods(evidence: Evidence) -> Table:
    """The same delays by pixel sums and by the published procedure, side by side."""
    published = {name: (value, u) for name, value, u in _entries(evidence.as_published)}
    rows: list[tuple[str, ...]] = []
    for name, value, u in _entries(evidence.best):
        other, u_other = published.get(name, (float("nan"), 0.0))
        rows.append(
            (
                name,
                time_text(value, u),
                time_text(other, u_other) if np.isfinite(other) else "–",
                f"{signed(other - value, u_other or u, unit_s=US)} µs" if np.isfinite(other) else "–",
                REFERENCE_EVENTS.get(name, ""),
            )
        )
    splits = [budget_of.falling_minus_rising(result) for result in (evidence.best, evidence.as_published)]
    texts = [time_text(split.value_s, split.standard_uncertainty_s) for split in splits if split is not None]
    if len(texts) == len(splits):
        rows.append(("falling − rising", *texts, "", "0 expected"))
    return Table(
        title="Both methods",
        columns=("parameter", "pixel sums", "as published", "published − pixel sums", "event"),
        align="lrrrl",
        rows=tuple(rows),
        note=f"Delays: {SIGN}. "
        "As published: threshold counts, equal slots, straight lines; its u holds the scatter of the lines only. The "
        "paper's camera: falling 567.74 ± 2.06 µs, rising 488.91 ± 2.77 µs, “cause not apparent”; what its slopes "
        "give is the middle of integration.",
    )


def budget(evidence: Evidence) -> Table:
    """Uncertainty budget of the trigger delay by the chosen method, largest first."""
    found = budget_of.of_delay(evidence.result)
    rows = [
        (
            line.part.source,
            line.part.kind,
            _micro(line.part.standard_uncertainty_s),
            budget_of.freedom_text(line.part.degrees_of_freedom),
            budget_of.share_text(line.share),
        )
        for line in found.lines
    ]
    total = "100%" if found.standard_uncertainty_s > 0 else "–"
    freedom = budget_of.freedom_text(found.degrees_of_freedom)
    rows.append(("all together (root of the sum of squares)", "", _micro(found.standard_uncertainty_s), freedom, total))
    return Table(
        title="Uncertainty budget of the trigger delay",
        columns=("source", "type", "u (µs)", "ν", "share of u²"),
        align="lcrrr",
        rows=tuple(rows),
        note="Type A: from the scatter of this measurement; type B: from rig.toml. Angle errors become times by division "
        "through the wheel's angular frequency. Angles common to all recordings of one wheel speed drop out of the "
        "relative delays. ν, degrees of freedom: how well u itself is known; all together by Welch and Satterthwaite: "
        f"k = {budget_of.coverage_factor(found.degrees_of_freedom):.2f}.",
    )


def choices(evidence: Evidence) -> Table:
    """Every choice of the analysis, its value, and whether it was made automatically or by a person."""
    chosen, recordings, fits = evidence.choices, evidence.recordings, evidence.edge_fits
    rows = [
        ("method", METHOD_NAMES[chosen.method], "default" if chosen.method == "pixel-sum" else "by you"),
        ("region of interest", _common(recordings, _roi_text), _maker(chosen.roi is not None)),
        ("threshold", _common(recordings, _threshold_text), _maker(chosen.threshold_dn is not None)),
        ("threshold level between the peaks", f"{chosen.threshold_level:.0%}", _maker(chosen.threshold_level != 0.5)),
        (
            "border of the summed region",
            _common(recordings, lambda r: f"{r.opening.border_px} px"),
            _maker(chosen.border_px is not None),
        ),
        ("margin of the plateaus", f"{chosen.plateau_margin:.0%} of their width", _maker(chosen.plateau_margin != 0.15)),
        ("dead pixels replaced", _common(recordings, lambda r: str(r.opening.n_bad_pixels)), "automatic"),
        ("axle in the image (row, column)", _common(recordings, _axle_text), "automatic"),
        ("camera roll, from the mask's image", _roll_text(evidence), "automatic"),
        ("reference edge", chosen.reference_edge, _maker(chosen.reference_edge != "automatic")),
        ("cutout edges from", evidence.geometry.edges_from, "automatic"),
        ("control slots", "learned from their timestamps (published method: equal)", "automatic"),
        *((f"plateaus, {_delay_text(fit.data.trigger_delay_time_set_s)}", _plateaus(fit.data.plateaus), "automatic")
          for fit in evidence.published_fits),
        (
            "lines fitted between fractions",
            f"{chosen.slope_limits[0]:g} and {chosen.slope_limits[1]:g}",
            _maker(chosen.slope_limits != (0.05, 0.95)),
        ),
        *((
            f"start of the search, {fit.name}",
            f"{time_text(fit.start_delay_s)}; the fit left it by "
            f"{time_text(float(fit.edge_delay_s.mean()) - fit.start_delay_s)}",
            "automatic",
        ) for fit in fits[:1]),
        ("largest distance of any fit from its start", time_text(_largest_way(evidence)), "automatic"),
        ("opening angle, fitted", _common(fits, lambda f: f"{np.degrees(f.opening_angle_rad):.3f}°"), "fitted"),
        ("frames left out", str(sum(fit.n_dropped for fit in fits)), "automatic"),
    ]  # fmt: skip
    return Table(
        title="Choices",
        columns=("what", "value", "chosen"),
        align="lll",
        rows=tuple((str(a), b, c) for a, b, c in rows),
    )


def _common(items: Iterable[_T], text: Callable[[_T], str]) -> str:
    """What the items have in common, or the first and how many others there are."""
    texts = list(dict.fromkeys(text(item) for item in items))
    return texts[0] if len(texts) == 1 else f"{texts[0]} … {texts[-1]} ({len(texts)} different)"


def _maker(by_person: bool) -> str:
    return "by you" if by_person else "automatic"


def _roi_text(recording: ReducedRecording) -> str:
    row0, row1, column0, column1 = recording.opening.roi
    return f"rows {row0}–{row1 - 1}, columns {column0}–{column1 - 1}"


def _threshold_text(recording: ReducedRecording) -> str:
    found = recording.opening.histogram
    if found is None:
        return "none"
    return f"{found.threshold_dn:.0f} DN, peaks at {found.plate_dn:.0f} and {found.blackbody_dn:.0f} DN"


def _axle_text(recording: ReducedRecording) -> str:
    view = recording.axle
    return "not found" if view is None else f"({view.row_px:.1f}, {view.column_px:.1f}) px"


def _roll_text(evidence: Evidence) -> str:
    roll = evidence.geometry.camera_roll_rad
    return "not found" if roll is None else f"{np.degrees(roll):+.3f}°"


def _delay_text(delay_s: float) -> str:
    return f"{delay_s / MS:g} ms set"


def _plateaus(plateaus: Iterable[tuple[float, float, int]]) -> str:
    return ", ".join(f"{np.degrees(a):.1f}–{np.degrees(b):.1f}° ({level})" for a, b, level in plateaus)


def _largest_way(evidence: Evidence) -> float:
    ways = [float(fit.edge_delay_s.mean()) - fit.start_delay_s for fit in evidence.edge_fits]
    return max(ways, key=abs)


def inputs(evidence: Evidence) -> Table:
    """Every file that was read, with what it says and its checksum."""
    rows = [
        (
            recording.source or recording.name,
            str(recording.n_frames),
            f"{recording.trigger_delay_time_set_s / MS:g}",
            "–" if recording.integration_time_s is None else f"{recording.integration_time_s / US:g}",
            f"{recording.rotation_speed_hz:g}",
            recording.sha256,
        )
        for recording in evidence.recordings
    ]
    rows.append((evidence.rig.source or "rig", "–", "–", "–", "–", evidence.rig.sha256))
    return Table(
        title="Inputs",
        columns=("file", "frames", "delay set (ms)", "integration (µs)", "wheel (Hz)", "sha256"),
        align="lrrrrl",
        rows=tuple(rows),
    )


def software() -> Table:
    """Versions of everything that had a hand in the numbers."""
    return Table(
        title="Software",
        columns=("package", "version"),
        align="ll",
        rows=tuple(versions().items()),
    )


def versions() -> dict[str, str]:
    """Versions by name; a package that is not installed is left out."""
    found = {}
    for name in ("irtiming", "numpy", "scipy", "numba", "h5py", "hdf5plugin", "matplotlib", "GTC"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {**found, "python": platform.python_version(), "platform": platform.platform()}
