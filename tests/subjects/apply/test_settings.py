"""Timing between settings that were measured: lines that are known, errors that are drawn, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_result import COOLED, made_up_result

from irtiming.apply import camera_timing
from irtiming.apply.settings import between
from irtiming.errors import ConditionError
from irtiming.inference.weighted_line import line_weights

WINDOWS_S = (1e-4, 2.5e-4, 4e-4, 7e-4)
OWN_S, SHARED_S = 4e-7, 2e-6


def _camera(window_s, delay_s, *, own_s=OWN_S, shared_s=SHARED_S, **fields):
    """Of a result at an integration time, whose budget has this much of the rig's errors."""
    u = np.hypot(own_s, shared_s)
    numbers = {"trigger_delay": (delay_s, u), "exposure_midpoint_delay": (delay_s + window_s / 2, u)}
    made = made_up_result("photon", "snapshot", numbers, matrix=[[1.0, 1.0], [1.0, 1.0]], window_s=window_s, **fields)
    return replace(camera_timing.of_result(made), shared_u=(shared_s, shared_s))


def _wanted(window_s):
    return replace(_camera(1e-4, 4e-4).conditions, integration_time_s=window_s)


def test_timing_between_settings_misses_by_what_is_stated():
    """Oracle: 400 cameras whose delay lies on a line over the integration time; own errors, and one that all results share."""
    rng, pulls = np.random.default_rng(7), []
    for _ in range(400):
        slope, delay_s, common_s = rng.normal(0, 0.1), rng.uniform(3e-4, 6e-4), rng.normal(0, SHARED_S)
        series = [
            _camera(window_s, delay_s + slope * window_s + rng.normal(0, OWN_S) + common_s) for window_s in WINDOWS_S
        ]
        at = rng.uniform(WINDOWS_S[0], WINDOWS_S[-1])
        found, _ = between(series, _wanted(at), where="run.nxs")
        middle = next(one for one in found.moments(None) if one.name == "middle")
        true_s = delay_s + slope * at + at / 2
        pulls.append((found.offset_s(middle, np.zeros(1))[0] - true_s) / found.u_s(middle, np.zeros(1))[0])
        assert found.conditions.integration_time_s == at
        assert SHARED_S < found.u_s(middle, np.zeros(1))[0] < 1.5 * SHARED_S
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1, abs=0.12)


def test_the_line_is_that_of_generalised_least_squares():
    """Oracle: brute force: of all unbiased weights on a grid none has less variance; and chi-squared by its definition."""
    rng = np.random.default_rng(3)
    x, y, mixing = np.array([1.0, 2.0, 4.0]), rng.normal(size=3), rng.normal(size=(3, 3))
    covariance, at = mixing @ mixing.T + 0.1 * np.eye(3), 2.7
    weights, chi_squared = line_weights(x, y, covariance=covariance, at=at)
    assert weights.sum() == pytest.approx(1)
    assert weights @ x == pytest.approx(at)
    along = np.array([x[1] - x[2], x[2] - x[0], x[0] - x[1]])  # changes neither sum
    others = weights + np.linspace(-1, 1, 201)[:, None] * along
    assert np.min(np.einsum("ki,ij,kj->k", others, covariance, others)) >= weights @ covariance @ weights - 1e-12
    lines = [line_weights(x, y, covariance=covariance, at=place)[0] @ y for place in x]
    rest = y - np.array(lines)
    assert chi_squared == pytest.approx(rest @ np.linalg.inv(covariance) @ rest)


def test_half_way_between_two_results_is_their_mean():
    """Oracle: by hand; own parts average, the shared one stays, and that no third result tested the line is said."""
    found, said = between([_camera(1e-4, 4e-4), _camera(3e-4, 5e-4)], _wanted(2e-4), where="run.nxs")
    assert found.estimate.value("trigger_delay") == pytest.approx(4.5e-4)
    assert found.estimate.u("trigger_delay") == pytest.approx(np.hypot(OWN_S / 2**0.5, SHARED_S), rel=1e-6)
    assert "was not tested" in " ".join(said)


def test_a_setting_that_was_measured_has_its_own_result():
    """Oracle: the result itself."""
    series = [_camera(window_s, 4e-4) for window_s in WINDOWS_S]
    assert between(series, _wanted(2.5e-4), where="run.nxs") == (series[1], ())


def test_what_is_no_straight_line_widens_u_or_is_refused():
    """Oracle: a bend of 3 and of 30 of the results' own uncertainties; chi-squared of the first by hand is between the limits."""
    bent = [_camera(w, 4e-4 + bend) for w, bend in zip((1e-4, 2e-4, 3e-4), (0, 3 * OWN_S, 0), strict=True)]
    straight = [_camera(w, 4e-4) for w in (1e-4, 2e-4, 3e-4)]
    found, said = between(bent, _wanted(1.5e-4), where="run.nxs")
    usual, _ = between(straight, _wanted(1.5e-4), where="run.nxs")
    ratio = np.sqrt(9 / 1.5)  # the second difference, 6 own, over its standard deviation, sqrt(6) own
    own, wide = (one.estimate.u("trigger_delay") ** 2 - SHARED_S**2 for one in (usual, found))
    assert wide == pytest.approx(ratio**2 * own, rel=1e-3)
    assert "their own was multiplied: trigger_delay 2.4" in " ".join(said)
    worse = [_camera(w, 4e-4 + bend) for w, bend in zip((1e-4, 2e-4, 3e-4), (0, 30 * OWN_S, 0), strict=True)]
    with pytest.raises(ConditionError, match="trigger_delay is no straight line over the integration time"):
        between(worse, _wanted(1.5e-4), where="run.nxs")


@pytest.mark.parametrize(
    ("others", "wanted_s", "said"),
    [
        (
            [_camera(3e-4, 4e-4)],
            5e-4,
            r"its integration time is 500 µs, the results were measured from 100 µs to 300 µs",
        ),
        ([_camera(3e-4, 4e-4)], None, "the integration time is not stated by the frames"),
        ([_camera(3e-4, 4e-4, serial_number="8")], 2e-4, "its serial number is 8, the result was measured with 7"),
        (
            [camera_timing.of_result(made_up_result("photon", "snapshot", {"trigger_delay": COOLED["trigger_delay"]}))],
            2e-4,
            "all must have the same, analysed alike",
        ),
    ],
    ids=["beyond", "unknown", "another", "other numbers"],
)
def test_what_cannot_be_interpolated_is_refused(others, wanted_s, said):
    """Oracle: the words."""
    with pytest.raises(ConditionError, match=said):
        between([_camera(1e-4, 4e-4), *others], _wanted(wanted_s), where="run.nxs")
