"""Figures of the report, looked at before they are drawn."""

import re

import numpy as np
import pytest

from irtiming.report import sheet
from irtiming.report.sections import image, joint_fit, pixel_sums, relative_delays, rig, uncertainty, wheel

FIGURES = [
    lambda analysis: rig.model(analysis.geometry.model),
    pixel_sums.averaged,
    pixel_sums.fitted,
    image.mean_frames,
    lambda analysis: image.histogram(analysis.recordings[0].opening.histogram),
    wheel.speed,
    wheel.slots,
    uncertainty.by_edge,
    uncertainty.draw_budget,
    relative_delays.figure,
    lambda analysis: joint_fit.draw_profiles(analysis.profiles),
    lambda analysis: joint_fit.draw_whiteness(analysis.joint.whiteness),
]


@pytest.mark.parametrize("make", FIGURES, ids=lambda make: make.__name__)
def test_every_figure_has_units_on_its_axes(analysis, make):
    """Oracle: the house rule: a label ends in its unit in parentheses; inner panels may leave the shared abscissa bare."""
    drawn = make(analysis)
    shown = [axes for axes in drawn.axes if axes.axison]
    labels = [axis.get_label_text() for axes in shown for axis in (axes.xaxis, axes.yaxis)]
    written = [label for label in labels if label]
    assert written
    assert all(re.search(r"\([^()]+\)\Z", label) for label in written), written


def test_residuals_stand_under_both_fits(analysis):
    """Oracle: one residual panel under the lines; one per nominal delay under the pixel sums, same abscissa."""
    averaged, fitted = pixel_sums.averaged(analysis), pixel_sums.fitted(analysis)
    assert [axes.get_ylabel()[:6] for axes in averaged.axes] == ["expose", "points"]
    panels = [axes for axes in fitted.axes if axes.get_ylabel().startswith("sums − model")]
    assert len(panels) == 5
    assert {axes.get_xlim() for axes in panels} == {(0.0, 360.0)}


def test_residuals_are_drawn_in_thousandths_of_the_step(analysis):
    """Oracle: noise of 0.2e-3 was put in, so the points scatter by 0.2."""
    panel = next(a for a in pixel_sums.fitted(analysis).axes if a.get_ylabel().startswith("sums"))
    points = max((line.get_ydata() for line in panel.get_lines()), key=len)
    assert np.std(points) == pytest.approx(0.2, rel=0.1)


def test_the_curves_of_all_nominal_delays_are_named(analysis):
    """Oracle: five delays of two runs each and the model."""
    drawn = pixel_sums.averaged(analysis)
    texts = [text.get_text() for text in drawn.legends[0].get_texts()]
    assert texts[0] == "model, no delay"
    assert texts[1:] == [f"{delay} ms set, 2 runs" for delay in (0, 25, 50, 75, 100)]


def test_no_legend_crowds_out_the_axes(analysis):
    """Oracle: with five delays the axes still take at least three quarters of the width."""
    drawn = pixel_sums.averaged(analysis)
    drawn.draw_without_rendering()
    assert all(axes.get_position().width > 0.75 for axes in drawn.axes)


def test_measurements_at_several_speeds_are_told_apart():
    """Oracle: names by hand."""
    assert sheet.run_names([0.0, 0.025], [3.0, 3.0]) == ["0 ms set", "25 ms set"]
    assert sheet.run_names([0.0, 0.0], [3.0, 6.0]) == ["0 ms set, 3 Hz", "0 ms set, 6 Hz"]


def test_the_speed_of_a_uniform_wheel_is_its_nominal_one(analysis):
    """Oracle: 40 turns of 1/3 s; a broken track loses no turn to the gap."""
    track = analysis.recordings[0].track
    middle_s, rate_hz = wheel.turn_rates(track)
    np.testing.assert_allclose(rate_hz, 3.0, rtol=1e-6)
    assert middle_s[0] == pytest.approx(1 / 6, abs=1e-6)


def test_an_svg_stands_alone(analysis):
    """Oracle: no style for the whole page, no link, no fixed size; names differ from figure to figure."""
    first = sheet.svg(rig.model(analysis.geometry.model), title="one & <two>")
    second = sheet.svg(rig.model(analysis.geometry.model), title="another")
    assert first.startswith('<svg role="img" aria-label="one &amp; &lt;two>"')
    assert "<style" not in first
    assert "http" not in first.replace('xmlns="http://www.w3.org/2000/svg"', "").replace(
        'xmlns:xlink="http://www.w3.org/1999/xlink"', ""
    )
    clips = [set(re.findall(r'clipPath id="(\w+)"', text)) for text in (first, second)]
    assert clips[0]
    assert not clips[0] & clips[1]
