"""One fit of all recordings together: what they share, how the search went, profiles, and whether residuals are white."""

import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from irtiming.records import sources
from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.result import LEAST_WHITENESS, Profile
from irtiming.report import sheet
from irtiming.report.blocks import DEG, MRAD, US, Panel, Section, Table
from irtiming.report.language import decimal, heads, several, t, with_capital, with_unit
from irtiming.report.meanings import SIGN, edge_delay_name, event, has_lag, method_name, several_speeds, words
from irtiming.report.rounding import fixed, in_unit, significant, time_text
from irtiming.report.sections import own_fits
from irtiming.report.sections.row_sums import published_fits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

EDGE_ANGLES = tuple(f"edge_angle_{edge}" for edge in range(4))
_WIDEST = 2.6  # standard uncertainties shown to either side
_LEAST_SHOWN = 1e-8  # probability
_TITLE_WIDTH = 16
_LATENCIES = {**sources.LATENCIES, "gates": sources.BOTH_GATES}
_MEANINGS = {
    **{f"latency_{name}": f"{source} beyond what rig.toml states" for name, source in _LATENCIES.items()},
    "clock_error": "relative error of the clock beyond what rig.toml states",
    "integration_time": "length of the integration window",
    "recursive_filter": "share of the frame before in each frame, by the camera’s noise filter",
    "pixel_memory": "share of the frame before that a pixel keeps",
    "bow": "by how much the opening is brighter at both ends than in its middle",
    "glare": "share of the opening’s light that goes astray in camera and lens",
    "window_tail_fast": "share of all that the camera takes in which comes soon after its window",
    "window_tail_slow": "share of all that the camera takes in which comes long after its window",
    "opening_angle": "opening angle of the mask",
    "lean_low": "mask edge at the lower wheel angle: angle by which it misses the axle, at the mean radius",
    "lean_high": "mask edge at the higher wheel angle: angle by which it misses the axle, at the mean radius",
    **{name: f"wheel edge {name[-1]}: angle by which it comes earlier than rig.toml says" for name in EDGE_ANGLES},
}


@final
@dataclass(frozen=True, kw_only=True)
class Shared:
    """A number that all recordings share, in its unit; ``scale`` and ``shown_unit`` are those of the tables."""

    name: str
    meaning: str
    unit: str
    start: float
    value: float
    standard_uncertainty: float
    prior: float | None = None
    prior_uncertainty: float | None = None

    @property
    def scale(self) -> float:
        """Of the unit in the tables."""
        return {"s": US, "rad": DEG if self.name == "opening_angle" else MRAD}.get(self.unit, 1.0)

    @property
    def shown_unit(self) -> str:
        """In the tables."""
        return {US: "µs", DEG: "°", MRAD: "mrad"}.get(self.scale, self.unit)

    @property
    def over_prior(self) -> float | None:
        """Estimate less what was expected, over the standard uncertainty of that; None where nothing was expected."""
        return None if not self.prior_uncertainty else (self.value - (self.prior or 0.0)) / self.prior_uncertainty


def section(analysis: Analysis) -> Section:
    """Tables and figures of all fits."""
    speeds = (by_speeds(analysis),) if several_speeds(analysis) and EDGE_ANGLES[0] in analysis.joint.parameters else ()
    profiles = (_profile_panel(analysis),) if analysis.profiles else ()
    tables = (numbers(analysis), search(analysis), *speeds, own_fits.table(analysis), searches(analysis))
    return Section(title=t("Joint fit"), blocks=(*tables, _whiteness_panel(analysis), *profiles))


def shared(analysis: Analysis) -> tuple[Shared, ...]:
    """What all recordings share, in the order of the fit."""
    joint = analysis.joint
    return tuple(
        Shared(
            name=name,
            meaning=_meaning(name, analysis),
            unit=unit,
            start=joint.start.get(name, 0.0),
            value=joint.parameters.value(name),
            standard_uncertainty=joint.parameters.u(name),
            prior=joint.prior.value(name) if name in joint.prior else None,
            prior_uncertainty=joint.prior.u(name) if name in joint.prior else None,
        )
        for name, unit in zip(joint.parameters.names, joint.parameters.units, strict=True)
    )


def _meaning(name: str, analysis: Analysis) -> str:
    if name == "delay":
        what = event("trigger_delay", analysis) if has_lag(analysis) else t("middle of the integration window")
        return t("{what} after the trigger edge", what=what)
    return t(_MEANINGS[name]) if name in _MEANINGS else words(name)


def angles(analysis: Analysis) -> tuple[Shared, ...]:
    """The edges' common angle, and of each edge what it differs from it; none where no angles were fitted."""
    joint = analysis.joint
    if EDGE_ANGLES[0] not in joint.parameters:
        return ()
    found = joint.parameters.pick(*EDGE_ANGLES)
    prior = joint.prior.pick(*EDGE_ANGLES)
    start = np.array([joint.start.get(name, 0.0) for name in EDGE_ANGLES])
    common = np.full(4, 0.25)
    rows = [("common_angle", t("all edges together: angle by which they come earlier than rig.toml says"), common)]
    rows += [
        (
            f"edge_{edge}_alone",
            t("edge {edge}, beyond what all have in common", edge=edge),
            np.eye(4)[edge] - common,
        )
        for edge in range(4)
    ]
    return tuple(
        Shared(
            name=name,
            meaning=meaning,
            unit="rad",
            start=float(weight @ start),
            value=float(weight @ found.values),
            standard_uncertainty=float(np.sqrt(max(0.0, weight @ found.covariance @ weight))),
            prior=float(weight @ prior.values),
            prior_uncertainty=float(np.sqrt(max(0.0, weight @ prior.covariance @ weight))),
        )
        for name, meaning, weight in rows
    )


def moved(analysis: Analysis) -> tuple[float, float]:
    """How far the delay is from where the search began, s, and in its own standard uncertainties."""
    first = next(one for one in shared(analysis) if one.name == "delay")
    way = first.value - first.start
    return way, way / first.standard_uncertainty if first.standard_uncertainty > 0 else 0.0


def numbers(analysis: Analysis) -> Table:
    """Shared numbers with the start of the search and what was known before."""
    rows = tuple(
        (f"{one.meaning} ({one.shown_unit})", _shown(one, one.start), _shown(one, one.value),
         significant(one.standard_uncertainty / one.scale), *_prior(one))
        for one in shared(analysis)
    )  # fmt: skip
    window = (
        ""
        if has_lag(analysis)
        else (
            t(
                " The window is what the rounded corners say; the delays count on the integration time that the "
                "recordings state, where they state one."
            )
        )
    )
    return Table(
        title=t("What all recordings share"),
        columns=heads("quantity", "start", "estimate", "u", "prior u", "(estimate − prior) / prior u"),
        align="lrrrrr",
        rows=rows,
        note=t(
            "One likelihood over all recordings. The delay is {sign}; an angle is positive where an edge comes "
            "early. Prior: what rig.toml and the recordings state of a number before the fit, 0 of an angle. Prior u: what "
            "rig.toml, the images and the residuals allow it to be off.{window}",
            sign=t(SIGN),
            window=window,
        ),
    )


def _shown(one: Shared, value: float) -> str:
    return in_unit(value, one.standard_uncertainty, unit_s=one.scale)


def _prior(one: Shared) -> tuple[str, str]:
    if one.prior_uncertainty is None or one.over_prior is None:
        return "–", "–"
    return significant(one.prior_uncertainty / one.scale), fixed(one.over_prior, 2)


def search(analysis: Analysis) -> Table:
    """How the search went, and whether recordings and model agree."""
    joint = analysis.joint
    way_s, own = moved(analysis)
    way = f"{with_unit(significant(way_s / US, digits=3), 'µs')} = {with_unit(fixed(own, 2), 'u')}"
    low = int(np.sum(joint.whiteness < LEAST_WHITENESS))
    return Table(
        title=t("How the fit went"),
        columns=heads("what", "found", "expected"),
        align="lrl",
        rows=(
            (t("evaluations of the likelihood"), str(joint.n_steps), t("some")),
            (
                t("distance of the delay from its start"),
                way,
                t("not 0: a fit that stays at its start has found nothing"),
            ),
            (
                t("what a further step would move"),
                with_unit(decimal(f"{joint.decrement:.1g}"), "u"),
                t("far less than 1"),
            ),
            (
                t("reduced chi-square"),
                decimal(f"{joint.reduced_chi_square:.2f}"),
                t(
                    "about 1: one set of shared numbers does as well as each recording's own; less where noise was inflated"
                ),
            ),
            (
                t("Birge ratio of the recordings' delays"),
                decimal(f"{joint.birge:.2f}"),
                t("about 1: they scatter as their noise says"),
            ),
            (
                t("least Ljung-Box p-value of the residuals"),
                decimal(f"{float(np.min(joint.whiteness)):.2g}"),
                t("{least:g} or more", least=LEAST_WHITENESS),
            ),
            (t("recordings below that"), t("{n} of {total}", n=low, total=joint.whiteness.size), "0"),
        ),
        note=t("Delays of single recordings count from the trigger edge, with the delay set taken off."),
    )


def by_speeds(analysis: Analysis) -> Table:
    """What several wheel speeds say of the angles in rig.toml."""
    of = ("[mask] centre_angle_deg, [beams]", *["[wheel] cutout_edges_rad"] * 4)
    rows = tuple(
        (
            one.meaning,
            f"{_shown(one, one.value)} ± {significant(one.standard_uncertainty / one.scale)}",
            *_prior(one),
            check,
        )
        for one, check in zip(angles(analysis), of, strict=True)
    )
    return Table(
        title=t("What the wheel speeds say of rig.toml"),
        columns=heads("angle", "measured ± u (mrad)", "rig.toml: u (mrad)", "measured / u of rig.toml", "belongs to"),
        align="lrrrl",
        rows=rows,
        note=t(
            "A delay is an angle that grows with the wheel's speed, an error of rig.toml is one that does not: "
            "recordings at several speeds measure it. Positive: the edge comes early. Within about 2 u of rig.toml "
            "nothing need be done: the delay is already corrected for it."
        ),
    )


def searches(analysis: Analysis) -> Table:
    """Where each fit began and where it ended: a fit that stays at its start has found nothing."""
    beside = [name for name in ("time_constant", "row_delay") if name in analysis.fits[0].estimate]
    method = method_name(analysis.best.method)
    rows = []
    for fit in analysis.fits:
        starts = {"delay": fit.start_delay_s} if isinstance(fit, EdgeDelayFit) else dict(fit.start)
        begun = [starts.get("delay", starts.get("edge_delay_0", 0.0)), *(starts.get(name, 0.0) for name in beside)]
        ends = [float(fit.edge_delay_s.mean()), *(fit.estimate.value(name) for name in beside)]
        work = "–" if isinstance(fit, EdgeDelayFit) else several(fit.n_steps, "evaluation")
        rows.append((f"{method}, {fit.name}", *_moves(begun, ends), work))
    joint = analysis.joint
    begun = [joint.start.get(name, 0.0) for name in ("delay", *beside)]
    ends = [joint.parameters.value(name) if name in joint.parameters else 0.0 for name in ("delay", *beside)]
    rows.append(
        (t("{method}, all recordings", method=method), *_moves(begun, ends), several(joint.n_steps, "evaluation"))
    )
    for published in published_fits(analysis):
        first, last = published.initial_timing, published.timing
        begun = [first.trigger_delay_s, first.time_constant_s, first.row_delay_s][: 1 + len(beside)]
        ends = [last.trigger_delay_s, last.time_constant_s, last.row_delay_s][: 1 + len(beside)]
        work = several(published.n_simulations, "simulation")
        rows.append((t("published, {name}", name=published.data.names[0]), *_moves(begun, ends), work))
    return Table(
        title=t("Start and end of each search"),
        columns=(t("fit"), t("delay"), *(words(name) for name in beside), t("work")),
        align="lr" + "r" * len(beside) + "r",
        rows=tuple(rows),
        note=t(
            "Delay: {event}; of all recordings together of a window its middle. {sign}.",
            event=event(edge_delay_name(analysis), analysis),
            sign=with_capital(t(SIGN)),
        ),
    )


def _moves(begun: list[float], ends: list[float]) -> list[str]:
    return [f"{time_text(start)} → {time_text(end)}" for start, end in zip(begun, ends, strict=True)]


def _profile_panel(analysis: Analysis) -> Panel:
    return Panel(
        title=t("Profile likelihoods"),
        caption=t(
            "Twice the logarithm of the likelihood that is lost where a parameter is held at a value and all others "
            "are at their best. Points and blue line: as computed; grey: the parabola x² that the covariance "
            "expects. Red: where the deviation reaches 1, the ends of the interval of one standard uncertainty; they "
            "belong at −1 and +1. A curve narrower than the parabola: the stated u holds more than the frames' "
            "noise; wider or lopsided: value ± u is not the whole truth."
        ),
        svg=sheet.svg(draw_profiles(analysis.profiles), title=t("Profile likelihood of each parameter")),
    )


def draw_profiles(found: tuple[Profile, ...]) -> "Figure":
    """One panel per parameter."""
    with sheet.style():
        drawn = sheet.figure(height_in=2.9)
        panels = drawn.subplots(1, max(1, len(found)), sharey=True, squeeze=False)[0]
        for axes, profile in zip(panels, found, strict=False):
            _profile(axes, profile)
            axes.set_xlabel(t("(value − estimate) / u (1)"))
        panels[0].set_ylabel(t("deviation (1)"))
        panels[0].set_ylim(-0.2, 6.2)
    return drawn


def _profile(axes: "Axes", profile: Profile) -> None:
    x = np.linspace(-_WIDEST, _WIDEST, 161)
    axes.plot(x, x**2, color=sheet.FAINT, linewidth=2.6, alpha=0.5)
    scaled = _in_u(profile, profile.values)
    within = np.linspace(scaled.min(), scaled.max(), 161)
    axes.plot(within, _between(scaled, profile.deviation, within), color=sheet.BLUE, linewidth=1)
    axes.plot(scaled, profile.deviation, "o", color=sheet.BLUE, markersize=4)
    axes.axhline(1, color=sheet.RED, linewidth=0.7, linestyle="--")
    ends = [end for end in (profile.lower, profile.upper) if end is not None]
    for place in _in_u(profile, np.array(ends)):
        axes.plot([place, place], [0, 1], color=sheet.RED, linewidth=1)
        axes.annotate(
            decimal(f"{place:+.2f}"),
            (place, 0),
            xytext=(-3 if place < 0 else 3, 3),
            textcoords="offset points",
            ha="right" if place < 0 else "left",
            color=sheet.RED,
            fontsize=7.5,
        )
    axes.set_title(textwrap.fill(words(profile.name), _TITLE_WIDTH, break_long_words=False), fontsize=8.5)
    axes.set_xlim(-_WIDEST, _WIDEST)
    axes.set_xticks(range(-2, 3))


def _in_u(profile: Profile, values: Array) -> Array:
    return np.asarray((values - profile.value) / profile.standard_uncertainty)


def _between(scaled: Array, deviation: Array, at: Array) -> Array:
    """Deviation between its points: its root, with a sign, is nearly a straight line."""
    return np.asarray(np.interp(at, scaled, np.sign(scaled) * np.sqrt(deviation)) ** 2)


def _whiteness_panel(analysis: Analysis) -> Panel:
    return Panel(
        title=t("Are the residuals white?"),
        caption=t(
            "Ljung-Box p-value: the probability of residuals at least as correlated along the wheel angle (20 lags), "
            "were they white; one point per recording, in the order of the inputs. White residuals scatter evenly "
            "over 0 to 1. Below the red line (a triangle: below 10⁻⁸) the model misses something of the rig; the "
            "uncertainty is inflated for it, and a warning says so."
        ),
        svg=sheet.svg(draw_whiteness(analysis.joint.whiteness), title=t("Whiteness of the residuals by recording")),
    )


def draw_whiteness(probability: Array) -> "Figure":
    """P-value (n_recording,) over recordings with the limit."""
    from matplotlib.ticker import MaxNLocator

    number = np.arange(1, probability.size + 1)
    shown = np.maximum(probability, _LEAST_SHOWN)
    hidden, low = probability < _LEAST_SHOWN, probability < LEAST_WHITENESS
    with sheet.style():
        drawn = sheet.figure(height_in=1.9)
        axes = drawn.add_subplot()
        looks = ((~low, "o", sheet.BLUE), (low & ~hidden, "o", sheet.RED), (hidden, "v", sheet.RED))
        for which, marker, colour in looks:
            axes.semilogy(number[which], shown[which], marker, color=colour, markersize=5)
        axes.axhline(LEAST_WHITENESS, color=sheet.RED, linewidth=0.9, linestyle="--")
        axes.set_ylim(min(LEAST_WHITENESS / 10, float(shown.min()) / 3), 2)
        axes.set_xlim(0.5, probability.size + 0.5)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel(t("recording, in the order of the inputs (1)"))
        axes.set_ylabel(t("p-value (1)"))
    return drawn
