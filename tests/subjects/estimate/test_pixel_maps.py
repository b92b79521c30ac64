"""Pixels of several recordings put together, and what all have in common: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import pixel_maps
from irtiming.estimate.map_patterns import MappedDelays
from irtiming.estimate.pixel_fit import Reference
from irtiming.records.estimate import Estimate

SHAPE = (3, 2)


def _part(delay_s, response_s, *, u_s=(1e-6, 2e-6), correlation=0.0, sound=None, n_free=2):
    """Two pixels, in the rows 0 and 2 of column 1."""
    covariance = np.zeros((2, 3, 3))
    covariance[:, 0, 0] = 1.0
    covariance[:, 1, 1], covariance[:, 2, 2] = u_s[0] ** 2, u_s[1] ** 2
    covariance[:, 1, 2] = covariance[:, 2, 1] = correlation * u_s[0] * u_s[1]
    return SimpleNamespace(
        row_px=np.array([0, 2]), column_px=np.array([1, 1]), covariance=covariance[:, : 1 + n_free, : 1 + n_free],
        delay_s=np.array(delay_s), response_s=np.array(response_s), is_sound=np.array(sound or [True, True]),
    )  # fmt: skip


def _reference(*, row_delay_s=30e-6, response_s=8e-3, read_s=1e-3):
    return Reference(read_s=np.full(4, read_s), row_delay_s=row_delay_s, response_s=response_s, memory=0.0, blade=0.0)


def _estimate(**values):
    names = tuple(values)
    numbers = np.array([values[name][0] for name in names])
    covariance = np.diag([values[name][1] ** 2 for name in names])
    return Estimate(names=names, units=("s",) * len(names), values=numbers, covariance=covariance)


RESULT = {"trigger_delay": (5e-3, 4e-6), "time_constant": (8.1e-3, 5e-6), "row_delay": (31e-6, 1e-8)}


def test_pixels_of_two_recordings_are_their_weighted_mean_about_the_result():
    """Oracle: by hand; a recording that is twice as sure counts four times, each about its own fit's rows and time constant.

    Both pixels count alike, so that the middle row is row 1, at which the result's delay is taken.
    """
    first = _part([-31e-6, 33e-6], [8.004e-3, 7.998e-3])
    second = _part([-40e-6, 45e-6], [9.005e-3, 9.0e-3], u_s=(2e-6, 4e-6))
    references = [_reference(), _reference(row_delay_s=40e-6, response_s=9e-3)]
    found = pixel_maps._together([first, second], references, fitted=_estimate(**RESULT), shape=SHAPE)
    level = 5e-3 + 1 * 31e-6
    off = np.array([(4 * (-31e-6 - 30e-6) + (-40e-6 - 40e-6)) / 5, (4 * (33e-6 - 30e-6) + (45e-6 - 40e-6)) / 5])
    np.testing.assert_allclose(found.delay_s[[0, 2], 1], level + off, rtol=1e-9)
    np.testing.assert_allclose(found.lag_s[[0, 2], 1], 8.1e-3 + np.array([4 * 4e-6 + 5e-6, 4 * -2e-6]) / 5, rtol=1e-9)
    np.testing.assert_allclose(found.covariance[0, 1], np.diag([0.8e-12, 3.2e-12]), atol=1e-20)
    assert np.isnan(found.delay_s[:, 0]).all()
    assert np.isnan(found.delay_s[1, 1])
    np.testing.assert_allclose(found.expected_s[[0, 2], 1], [level - 31e-6, level + 31e-6])
    assert found.fitted_row_delay_s == pytest.approx(31e-6)
    assert found.u_common_s == pytest.approx(np.hypot(4e-6, 1e-8))
    assert found.u_common_lag_s == pytest.approx(5e-6)


def test_errors_that_go_together_weigh_together():
    """Oracle: the mean of two normal distributions with their whole covariances."""
    parts = [_part([1e-6, 0.0], [8.003e-3, 8e-3], correlation=0.9), _part([0.0, 0.0], [8e-3, 8e-3], correlation=-0.5)]
    flat = _reference(row_delay_s=0.0)
    found = pixel_maps._together(parts, [flat, flat], fitted=_estimate(**RESULT), shape=SHAPE)
    own = [np.linalg.inv(one.covariance[0, 1:, 1:]) for one in parts]
    mean = np.linalg.solve(own[0] + own[1], own[0] @ [1e-6, 3e-6])
    assert found.delay_s[0, 1] - (5e-3 + 31e-6) == pytest.approx(mean[0], abs=1e-12)
    assert found.lag_s[0, 1] - 8.1e-3 == pytest.approx(mean[1], abs=1e-12)
    np.testing.assert_allclose(found.covariance[0, 1], np.linalg.inv(own[0] + own[1]), rtol=1e-9)


def test_a_pixel_is_sound_that_is_so_in_all_recordings_and_has_a_window_of_no_constant():
    """Oracle: by hand; a camera that does not lag has a delay alone."""
    parts = [_part([0.0, 0.0], [0.0, 0.0], sound=[True, False], n_free=1), _part([0.0, 0.0], [0.0, 0.0], n_free=1)]
    found = pixel_maps._together(parts, [_reference()] * 2, fitted=_estimate(trigger_delay=(5e-3, 4e-6)), shape=SHAPE)
    assert found.is_sound.tolist() == [[False, True], [False, False], [False, False]]
    assert found.lag_s is None
    assert found.u_common_lag_s is None
    assert found.covariance.shape == (*SHAPE, 1, 1)


def test_the_middle_row_has_the_results_delay_with_the_rows_between():
    """Oracle: by hand; ten rows down, beside a row delay that is known to 0.1 us, and the same without one in the result."""
    both = _estimate(trigger_delay=(5e-3, 3e-6), row_delay=(31e-6, 0.4e-6))
    assert pixel_maps._level(both, [_reference()], middle=10.0) == pytest.approx((5.31e-3, 5e-6, 31e-6))
    alone = _estimate(exposure_midpoint_delay=(4e-3, 3e-6), trigger_delay=(5e-3, 9e-6))
    assert pixel_maps._level(alone, [_reference()], middle=10.0) == pytest.approx((4.3e-3, 3e-6, 30e-6))


def test_a_result_of_bounds_alone_leaves_the_recordings_own_numbers_with_no_u():
    """Oracle: by hand; the first recording's edges in the mean, ten rows down, and its own time constant."""
    bounds = _estimate(trigger_delay_falling=(1e-3, 1e-6))
    assert pixel_maps._level(bounds, [_reference(read_s=2e-3)], middle=10.0) == pytest.approx((2.3e-3, np.inf, 30e-6))
    assert pixel_maps._constant(bounds, [_reference()]) == (8e-3, np.inf)
    assert pixel_maps._constant(_estimate(**RESULT), [_reference()]) == (8.1e-3, pytest.approx(5e-6))


def test_variance_is_by_the_harmonics_that_are_left_over():
    """Oracle: by hand; squares of sound pixels alone, 12 harmonics less 3 numbers each, and a noise by 20 that is too small."""
    one = SimpleNamespace(
        misfit=np.array([9.0, 18.0, 1e6]), is_sound=np.array([True, True, False]), n_quiet=20, n_harmonics=12,
        covariance=np.zeros((3, 3, 3)),
    )  # fmt: skip
    other = SimpleNamespace(
        misfit=np.array([45.0]), is_sound=np.array([True]), n_quiet=4, n_harmonics=11, covariance=np.zeros((1, 2, 2))
    )
    assert pixel_maps._reduced_chi_square([one]) == pytest.approx(27 * 0.9 / 18)
    assert pixel_maps._reduced_chi_square([one, other]) == pytest.approx((27 * 0.9 + 45 * 0.5) / (18 + 9))


def test_means_over_lines_weigh_pixels_by_their_noise():
    """Oracle: by hand; of two pixels of a row one is twice as sure, in delay, and the other in time constant."""
    row, column = np.array([4, 4, 7]), np.array([0, 1, 1])
    delays = MappedDelays(
        row_px=row, column_px=column, delay_s=np.array([10e-6, 20e-6, 5e-6]), u_s=np.array([1e-6, 2e-6, 3e-6]),
        shape_s=np.zeros((3, 0)), image_rows=8, image_columns=2,
    )  # fmt: skip
    value, u = np.full((8, 2), np.nan), np.full((8, 2), np.nan)
    value[row, column], u[row, column] = [8e-3, 9e-3, 7e-3], [2e-5, 1e-5, 3e-5]
    found = pixel_maps._line_means(
        row, delays, expected_s=np.array([10e-6, 15e-6, 4e-6]), lag=pixel_maps._Lag(value_s=value, u_s=u)
    )
    assert found.line_px.tolist() == [4, 7]
    assert found.n_pixels.tolist() == [2, 1]
    np.testing.assert_allclose(found.delay_s, [12e-6, 5e-6])
    np.testing.assert_allclose(found.u_delay_s, [1e-6 / np.sqrt(1.25), 3e-6])
    np.testing.assert_allclose(found.deviation_s, [1e-6, 1e-6])
    np.testing.assert_allclose(found.time_constant_s, [8.8e-3, 7e-3])
    np.testing.assert_allclose(found.u_time_constant_s, [1e-5 / np.sqrt(1.25), 3e-5])
    assert pixel_maps._line_means(row, delays, expected_s=np.zeros(3), lag=None).time_constant_s is None


def test_time_constants_are_asked_how_far_they_are_from_the_median():
    """Oracle: by hand; pixels without a value do not count."""
    lag = pixel_maps._Lag(value_s=np.array([[7e-3, 8e-3, 8.2e-3, np.nan]]), u_s=np.array([[1e-4, 1e-4, 5e-5, np.nan]]))
    np.testing.assert_allclose(lag.pulls, [[-10.0, 0.0, 4.0, np.nan]])
