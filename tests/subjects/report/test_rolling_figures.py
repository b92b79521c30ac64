"""Figures of a rolling camera's report, looked at before they are drawn."""

import re

import numpy as np
import pytest

from irtiming.report import bent_edge, row_curves
from irtiming.report.sections import image, lag, level, relative_delays, rig, row_sums, uncertainty, wheel

FIGURES = [
    row_sums.figure_6,
    row_sums.residual_map,
    row_sums.row_delays,
    lag.scan,
    lag.ellipse,
    level.drift,
    image.mean_frames,
    lambda rolling: image.contrasts(rolling.sectors[0]),
    uncertainty.draw_budget,
    uncertainty.by_edge,
    relative_delays.figure,
]


@pytest.mark.parametrize("make", FIGURES, ids=lambda make: make.__name__)
def test_every_figure_has_units_on_its_axes(rolling, make):
    """Oracle: the house rule: a label ends in its unit in parentheses."""
    drawn = make(rolling)
    shown = [axes for axes in drawn.axes if axes.axison]
    labels = [axis.get_label_text() for axes in shown for axis in (axes.xaxis, axes.yaxis)]
    written = [label for label in labels if label]
    assert written
    assert all(re.search(r"\([^()]+\)\Z", label) for label in written), written


@pytest.mark.parametrize("section", [rig.section, wheel.section])
def test_figures_of_the_wheel_serve_every_camera(any_camera, section):
    """Oracle: they ask for nothing but wheel, gates and timestamps."""
    assert all(panel.svg.startswith("<svg") for panel in section(any_camera).blocks)


def test_figure_6_has_residuals_under_every_curve(rolling):
    """Oracle: the letters of the paper's figure; whole opening and four rows, each with its residuals; the frame has none."""
    drawn = row_sums.figure_6(rolling)
    titles = [axes.get_title(loc="left")[:3] for axes in drawn.axes]
    assert [title for title in titles if title] == ["(a)", "(b)", "(c)", "(d)", "(e)", "(f)"]
    assert sum(axes.get_ylabel().startswith("data − model") for axes in drawn.axes) == 5


def test_the_whole_opening_weighs_rows_by_their_light(rolling):
    """Oracle: rows alike give their own curve back: mean 1/2, whatever the sign of the gain."""
    curve = row_curves.whole(rolling.fits[0])
    assert np.mean(curve.fraction) == pytest.approx(0.5, abs=1e-3)
    assert np.mean(curve.model[:-1]) == pytest.approx(0.5, abs=1e-9)
    assert np.std(curve.residual) < 1e-3


def test_a_late_row_is_found_where_it_is(rolling):
    """Oracle: the fifth row was put 100 us beside the line, noise of 1e-3 of the step scatters the others by 5 us or so."""
    found = row_curves.row_delays(rolling.fits[0])
    apart = 1e6 * (found.delay_s - found.line_s)
    assert apart[4] == pytest.approx(100.0, abs=4 * 1e6 * found.u_delay_s[4])
    others = np.delete(apart, 4) / (1e6 * np.delete(found.u_delay_s, 4))
    assert 0.6 < others.std() < 1.5
    np.testing.assert_allclose(found.line_s, 4e-3 + 40e-6 * found.row_px)


def test_an_edge_bends_as_the_rows_are_read(rolling):
    """Oracle: without rolling the edge is a ray from the axle; with it, it turns by omega t_row per row about that ray."""
    straight = bent_edge.edges(rolling, rolling.fits[0], wheel_angle_rad=1.2, rolling=False)
    bent = bent_edge.edges(rolling, rolling.fits[0], wheel_angle_rad=1.2, rolling=True)
    assert len(straight) == len(bent) == 1
    turns = []
    for row, column in (straight[0], bent[0]):
        polar = np.arctan2(row - 45, column - 40)
        turns.append(np.polyfit(row, polar, 1)[0])
    assert turns[0] == pytest.approx(0, abs=1e-12)
    assert turns[1] == pytest.approx(6 * np.pi * 40e-6, rel=1e-9)


def test_times_of_frames_bridge_what_was_left_out(rolling):
    """Oracle: frame k at k / 30.303 Hz, also within the shutter event and beyond the last kept frame."""
    times = level.frame_time_s(rolling.recordings[0], np.array([0.0, 110, 399, 450]))
    np.testing.assert_allclose(times, np.array([0, 110, 399, 450]) * 0.033, rtol=1e-9)


def test_numbers_of_the_sector_end_where_their_uncertainty_does(rolling):
    """Oracle: by hand; 38 px with u = 0.001 px, 75 degrees with u = 0.001 rad, 40.00 us with u = 0.1 us."""
    rows = {row[0]: row[1:] for row in image.sector(rolling.sectors[0]).rows}
    assert rows["outer radius (px)"] == ("38.0000", "0.0010")
    assert rows["opening angle (degrees)"] == ("75.000", "0.057")
    name = next(one for one in rows if one.startswith("row delay"))
    assert (rows[name][0].partition(".")[2], rows[name][1]) == ("00", "0.10")
