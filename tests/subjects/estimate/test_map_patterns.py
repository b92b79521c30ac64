"""What maps say of the readout, from delays made by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import map_patterns
from irtiming.estimate.map_patterns import MappedDelays, RowClock
from irtiming.records.row_timing import SectorShape

U_S, ROW_S = 2e-6, 30e-6


def _delays(later):
    """A disc of pixels of an image of 80 x 100, read row after row, and later by a function of row and column; with noise."""
    row, column = np.indices((80, 100))
    at = (row - 40) ** 2 + (column - 50) ** 2 < 900
    row, column = row[at], column[at]
    random = np.random.default_rng(5)
    delay = 1e-3 + ROW_S * row + later(row, column) + random.normal(0, U_S, row.size)
    shape = np.stack([np.cos(0.02 * row), (column - 50) / 100, row / 80], axis=1) * 0.3e-6  # of an axle that is off
    return MappedDelays(
        row_px=row, column_px=column, delay_s=delay, u_s=np.full(row.size, U_S), shape_s=shape, image_rows=80,
        image_columns=100,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("name", "later"),
    [
        ("odd columns", lambda row, column: 1e-6 * (column % 2)),
        ("odd rows", lambda row, column: -1e-6 * (row % 2)),
        ("right half", lambda row, column: 1e-6 * (column >= 50)),
        ("lower half", lambda row, column: 2e-6 * (row >= 40)),
        ("middle rows", lambda row, column: 20e-6 * (1 - ((row - 40) / 29) ** 2)),
    ],
)
def test_each_pattern_is_found_with_its_size(name, later):
    """Oracle: the delays that were put in; noise is known."""
    delays = _delays(later)
    found = {one.name: one for one in map_patterns.patterns(delays, map_patterns.row_clock(delays))}[name]
    size = later(*np.indices((80, 100))).ravel()[np.abs(later(*np.indices((80, 100)))).argmax()]
    size = size if name != "middle rows" else 20e-6
    assert abs(found.pull) > 6
    assert abs(found.later_s - size) < 4 * found.u_later_s


def test_an_error_of_the_shape_is_no_pattern():
    """Oracle: a column of the shape itself, fifty standard uncertainties of it; and a row clock that is straight."""
    delays = _delays(lambda row, column: 15e-6 * (column - 50) / 100)
    clock = map_patterns.row_clock(delays)
    assert all(abs(one.pull) < 4 for one in map_patterns.patterns(delays, clock))
    p_value, _, _ = map_patterns.p_value_of_straight_rows(delays, clock)
    assert p_value > 1e-4


def test_rows_that_are_off_without_any_pattern_are_found():
    """Oracle: ten rows that were put later."""
    delays = _delays(lambda row, column: 3e-6 * ((row > 20) & (row < 31)))
    p_value, row, off_s = map_patterns.p_value_of_straight_rows(delays, map_patterns.row_clock(delays))
    assert p_value < 1e-6
    assert 20 < row < 31
    assert off_s > 1e-6


def test_chance_of_straight_rows_by_hand():
    """Oracle: four rows are 2, 0, -1 and 0 us off, each of two pixels: squares of pulls x, and exp(-x / 2) of two freedoms."""
    left, u = (
        1e-6 * np.array([1.0, 3.0, 1.0, -2.0, -1.0, -1.0, 0.5, -0.5]),
        1e-6 * np.array([1, 1, 1, 1.41421356, 2, 2, 3, 3]),
    )
    delays = MappedDelays(
        row_px=np.repeat(np.arange(7, 11), 2), column_px=np.tile([3, 4], 4), delay_s=left, u_s=u, shape_s=np.zeros((8, 0)),
        image_rows=20, image_columns=20,
    )  # fmt: skip
    clock = RowClock(row_delay_s=0.0, u_row_delay_s=0.0, left_s=left, scatter=1.5)
    p_value, row, off_s = map_patterns.p_value_of_straight_rows(delays, clock)
    squares = (2.0**2 / 0.5 + 0.0 + 1.0**2 / 2.0 + 0.0) / 1.5**2
    assert p_value == pytest.approx(np.exp(-squares / 2), rel=1e-6)
    assert row == 7
    assert off_s == pytest.approx(2e-6)


def test_the_row_delay_knows_what_the_shape_may_do():
    """Oracle: the closed form of a straight line's u, plus that of the shape's own slope over rows."""
    delays = _delays(lambda row, column: 0.0 * row)
    clock = map_patterns.row_clock(delays)
    noise = U_S / np.sqrt(np.sum((delays.row_px - delays.row_px.mean()) ** 2))
    assert abs(clock.row_delay_s - ROW_S) < 4 * clock.u_row_delay_s
    assert clock.u_row_delay_s > np.hypot(noise, 0.3e-6 / 80) * 0.99


def test_a_shape_that_is_off_turns_pixels_about_its_axle():
    """Oracle: by hand; a bisector turns all alike, an axle d columns further right those at (y, x) from it by d y / r^2."""
    shape = SectorShape(
        axle_row_px=61.0, axle_column_px=82.0, offset_row_px=0.0, offset_column_px=0.0, inner_radius_px=17.0,
        outer_radius_px=52.0, bisector_rad=-1.55, opening_angle_rad=1.3, blur_px=0.7, image_rows=120, image_columns=160,
    )  # fmt: skip
    sector = SimpleNamespace(
        shape=shape, roi=(5, 60, 30, 140), names=("bisector_rad", "axle_column_px"), covariance=np.diag([1e-8, 4e-4])
    )
    row, column = np.array([20, 30, 40]), np.array([60, 82, 100])
    found = map_patterns.shape_effect_s(sector, row_px=row, column_px=column, omega=20.0)
    down, right = row - 61.0, column - 82.0
    by_axle = 0.02 * down / (down**2 + right**2) / 20
    expected = np.stack([np.full(3, 1e-4 / 20), np.abs(by_axle)], axis=1)
    np.testing.assert_allclose(np.sort(np.abs(found)), np.sort(expected), rtol=1e-6)  # in any order, of any sign


def test_pixels_that_scatter_more_than_their_noise_make_the_row_delay_less_certain():
    """Oracle: the noise that was drawn, three times what is stated for it; and as it is stated."""
    delays = _delays(lambda row, column: 0.0 * row)
    stated, sure = (map_patterns.row_clock(replace(delays, u_s=u)) for u in (delays.u_s, delays.u_s / 3))
    assert stated.scatter == pytest.approx(1, abs=0.05)
    assert sure.scatter == pytest.approx(3, rel=0.05)
    assert sure.u_row_delay_s == pytest.approx(stated.u_row_delay_s, rel=0.05)


@pytest.mark.parametrize(("n_far", "left"), [(1, 199), (2, 200)])
def test_single_pixels_that_stray_are_left_out_but_not_a_part_of_the_readout(n_far, left):
    """Oracle: by hand; of 200 pixels that scatter twice as much as their noise, one is 17 of its u off, or two, 1 %."""
    delays = MappedDelays(
        row_px=np.arange(200), column_px=np.arange(200), delay_s=np.zeros(200), u_s=np.full(200, U_S),
        shape_s=np.zeros((200, 1)), image_rows=200, image_columns=200,
    )  # fmt: skip
    off = np.where(np.arange(200) < 100, 15.0, -15.0) * U_S  # as far as 7.5 of what they scatter
    off[:n_far] = -17.0 * U_S
    clock = RowClock(row_delay_s=0.0, u_row_delay_s=0.0, left_s=off, scatter=2.0)
    kept = map_patterns.near(delays, clock)
    assert kept.row_px.size == left
    assert kept.row_px[-1] == 199
