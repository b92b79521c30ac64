"""One likelihood over all recordings as figures: profiles beside their parabolas, and whiteness of the residuals."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from irtiming.records.arrays import Array
from irtiming.records.joint_fit import Profile
from irtiming.report import sheet
from irtiming.report.figures import Panel
from irtiming.report.joint_tables import LEAST_WHITENESS

_WIDEST = 2.6  # standard uncertainties shown to either side
_LEAST_SHOWN = 1e-8  # probability
_TITLE_WIDTH = 16


def profiles(found: tuple[Profile, ...]) -> Panel:
    """How far the covariance can be trusted."""
    return Panel(
        title="Profile likelihoods",
        caption="Twice the logarithm of the likelihood that is lost where a parameter is held at a value and all others are at "
        "their best. Points and blue line: as computed; grey: the parabola x² that the covariance expects. Red: where the "
        "deviation reaches 1, the ends of the interval of one standard uncertainty; they belong at −1 and +1. A curve "
        "narrower than the parabola: the stated u holds more than the frames' noise; wider or lopsided: value ± u is not the "
        "whole truth.",
        svg=sheet.svg(draw_profiles(found), title="Profile likelihood of each parameter"),
    )


def draw_profiles(found: tuple[Profile, ...]) -> Figure:
    """One panel per parameter."""
    with sheet.style():
        drawn = sheet.figure(height_in=2.9)
        panels = drawn.subplots(1, max(1, len(found)), sharey=True, squeeze=False)[0]
        for axes, profile in zip(panels, found, strict=False):
            _profile(axes, profile)
            axes.set_xlabel("(value − estimate) / u (1)")
        panels[0].set_ylabel("deviation (1)")
        panels[0].set_ylim(-0.2, 6.2)
    return drawn


def _profile(axes: Axes, profile: Profile) -> None:
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
            f"{place:+.2f}".replace("-", "−"), (place, 0), xytext=(-3 if place < 0 else 3, 3), textcoords="offset points",
            ha="right" if place < 0 else "left", color=sheet.RED, fontsize=7.5,
        )  # fmt: skip
    axes.set_title(textwrap.fill(profile.name.replace("_", " "), _TITLE_WIDTH), fontsize=8.5)
    axes.set_xlim(-_WIDEST, _WIDEST)
    axes.set_xticks(range(-2, 3))


def _in_u(profile: Profile, values: Array) -> Array:
    return np.asarray((values - profile.value) / profile.standard_uncertainty)


def _between(scaled: Array, deviation: Array, at: Array) -> Array:
    """Deviation between its points: its root, with a sign, is nearly a straight line."""
    return np.asarray(np.interp(at, scaled, np.sign(scaled) * np.sqrt(deviation)) ** 2)


def whiteness(probability: Array) -> Panel:
    """Whether residuals hang together along the wheel angle; probability by recording, shape (n,)."""
    return Panel(
        title="Are the residuals white?",
        caption="Probability of residuals at least as correlated along the wheel angle (20 lags, Ljung and Box), were they "
        "white; one point per recording, in the order of the inputs. White residuals scatter evenly over 0 to 1. "
        "Below the red line (a triangle: below 10⁻⁸) the model misses something of the rig; the uncertainty is widened for it.",
        svg=sheet.svg(draw_whiteness(probability), title="Whiteness of the residuals by recording"),
    )


def draw_whiteness(probability: Array) -> Figure:
    """Probability over recordings, shape (n,), with the limit."""
    number = np.arange(1, probability.size + 1)
    shown = np.maximum(probability, _LEAST_SHOWN)
    hidden, low = probability < _LEAST_SHOWN, probability < LEAST_WHITENESS
    with sheet.style():
        drawn = sheet.figure(height_in=1.9)
        axes = drawn.add_subplot()
        for which, marker, colour in (
            (~low, "o", sheet.BLUE),
            (low & ~hidden, "o", sheet.RED),
            (hidden, "v", sheet.RED),
        ):
            axes.semilogy(number[which], shown[which], marker, color=colour, markersize=5)
        axes.axhline(LEAST_WHITENESS, color=sheet.RED, linewidth=0.9, linestyle="--")
        axes.set_ylim(min(LEAST_WHITENESS / 10, float(shown.min()) / 3), 2)
        axes.set_xlim(0.5, probability.size + 0.5)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("recording, in the order of the inputs (1)")
        axes.set_ylabel("probability (1)")
    return drawn
