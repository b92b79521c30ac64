"""The published search on data in closed form: what comes back, where it looks, and what it refuses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate.published import plausible_lag, row_delay_and_lag
from irtiming.estimate.published.plausible_lag import plausible_time_constant_s
from irtiming.physics.wheel import wheel_model
from irtiming.records.lag_estimate import WheelInImage

GATE, EDGES, GAMMA = float(np.pi / 2 + 0.2682), (0.0, 1.5718, 3.1421, 4.7125), float(np.radians(75))
MODEL = wheel_model(EDGES, GATE - np.pi / 2, opening_angle_rad=GAMMA, centre_angle_rad=-np.pi / 2)
CENTRE_PX = (60.4, 79.6)
WHEEL = WheelInImage(row_px=CENTRE_PX[0], column_px=CENTRE_PX[1], roll_rad=0.0)


@pytest.fixture(scope="module")
def mask():
    row, column = np.mgrid[:120, :160]
    phi = np.arctan2(row - CENTRE_PX[0], column - CENTRE_PX[1])
    radius = np.hypot(row - CENTRE_PX[0], column - CENTRE_PX[1])
    return (np.abs(phi + np.pi / 2) < GAMMA / 2) & (radius > 14) & (radius < 52)


@pytest.fixture(scope="module")
def data_of(lagging_rows, mask):
    def make(timing_s, **fields):
        return lagging_rows(mask, CENTRE_PX, timing_s=timing_s, gate_rad=GATE, edges_rad=EDGES, **fields)

    return make


def _fit(data, **options):
    return row_delay_and_lag.fit(data, MODEL, **({"wheel": WHEEL, "initial_row_delay_s": 1 / 60 / 120} | options))


@pytest.mark.parametrize(
    ("timing_s", "fields"),
    [
        ((3.872e-3, 38.76e-6, 4.819e-3), {}),
        ((20e-3, 150e-6, 9e-3), {"set_delay_s": 0.05}),
        ((-1e-3, -60e-6, 6e-3), {"noise": 2e-3, "lost": 60}),
        ((1e-3, 100e-6, 3e-3), {"rate_hz": 6.0, "n": 500}),
    ],
    ids=["the paper's", "late and slow", "last row first, angles lost", "fast wheel, few angles"],
)
def test_the_three_parameters_come_back(data_of, timing_s, fields):
    """Oracle: data in closed form; noise shifts the extrema, so that the method allows no more than some 0.1 ms."""
    fit = _fit(data_of(timing_s, **fields))
    assert fit.timing.trigger_delay_s == pytest.approx(timing_s[0], abs=60e-6)
    assert fit.timing.row_delay_s == pytest.approx(timing_s[1], abs=1e-6)
    assert fit.timing.time_constant_s == pytest.approx(timing_s[2], abs=60e-6)
    assert fit.row_px.size == fit.delay_of_row_s.size == 41
    assert fit.simulated_row_fraction.shape == fit.data.row_fraction.shape
    squares = [
        *(fit.simulated_row_fraction - fit.data.row_fraction) ** 2,
        (fit.simulated_fraction - fit.data.fraction) ** 2,
    ]
    assert fit.deviation_rms == pytest.approx(np.sqrt(np.mean(squares)), rel=1e-9)
    assert fit.n_simulations % 44 == 4


def test_delays_of_the_rows_lie_on_the_line(data_of):
    """Oracle: the delay of each row in the data; rows above the inner arc of the mask."""
    fit = _fit(data_of((3.872e-3, 100e-6, 4.819e-3)))
    wide = fit.row_px < 45
    line = fit.timing.trigger_delay_s + fit.row_px * fit.timing.row_delay_s
    np.testing.assert_allclose(fit.delay_of_row_s[wide], line[wide], atol=20e-6)


def test_uncertainty_of_the_time_constant_is_that_of_the_parabola(data_of):
    """Oracle: numpy's polyfit with its covariance, carried to the minimum -p1 / 2 p2."""
    fit = _fit(data_of((3.872e-3, 38.76e-6, 4.819e-3), noise=2e-3))
    x = (fit.time_constants_s - 4.8e-3) / 1e-4
    (p2, p1, p0), covariance = np.polyfit(x, fit.rms, 2, cov=True)
    along = np.array([p1 / (2 * p2**2), -1 / (2 * p2), 0.0])
    assert fit.timing.time_constant_s == pytest.approx(4.8e-3 - p1 / (2 * p2) * 1e-4, abs=1e-10)
    assert fit.u_timing.time_constant_s == pytest.approx(np.sqrt(along @ covariance @ along) * 1e-4, rel=1e-6)
    np.testing.assert_allclose(np.polynomial.Polynomial(fit.parabola)(fit.time_constants_s), p0 + p1 * x + p2 * x**2)


def test_rows_of_even_scatter_weigh_the_same():
    """Oracle: numpy's polyfit with its covariance over rows that scatter alike; one that scatters a lot moves nothing."""
    y, rng = np.arange(20.0), np.random.default_rng(5)
    value = 3.0 + 0.2 * y + rng.standard_normal(20)
    (slope, intercept), covariance = np.polyfit(y, value, 1, cov=True)
    line, u_line = row_delay_and_lag._line(y, value, u=np.full(20, 0.3))
    np.testing.assert_allclose(line, [intercept, slope])
    np.testing.assert_allclose(u_line, np.sqrt(np.diag(covariance))[::-1])
    split, u = np.append(value, 1e3), np.append(np.full(20, 0.3), 1e6)
    np.testing.assert_allclose(row_delay_and_lag._line(np.append(y, 20.0), split, u=u)[0], line, rtol=1e-6)


def test_a_counterclockwise_wheel_is_the_mirror_image(data_of):
    """Oracle: the image mirrored left to right, column by column."""
    data = data_of((3.872e-3, 38.76e-6, 4.819e-3))
    fit = _fit(data)
    mirrored = WheelInImage(
        row_px=CENTRE_PX[0], column_px=159 - CENTRE_PX[1], roll_rad=0.0, rotation="counterclockwise"
    )
    other = _fit(replace(data, mask=data.mask[:, ::-1]), wheel=mirrored)
    assert other.timing.trigger_delay_s == pytest.approx(fit.timing.trigger_delay_s, abs=1e-9)
    assert other.timing.time_constant_s == pytest.approx(fit.timing.time_constant_s, abs=1e-9)


def test_a_roll_of_the_camera_is_taken_off(data_of):
    """Oracle: the gate turned by as much; angles count from it."""
    data = data_of((3.872e-3, 38.76e-6, 4.819e-3))
    straight = _fit(data)
    turned = wheel_model(EDGES, GATE - np.pi / 2 - 0.02, opening_angle_rad=GAMMA, centre_angle_rad=-np.pi / 2)
    rolled = WheelInImage(row_px=CENTRE_PX[0], column_px=CENTRE_PX[1], roll_rad=0.02)
    other = row_delay_and_lag.fit(data, turned, wheel=rolled, initial_row_delay_s=1 / 60 / 120)
    assert other.timing.trigger_delay_s == pytest.approx(straight.timing.trigger_delay_s, abs=1e-9)


def test_rows_without_data_are_left_out(data_of):
    """Oracle: the rows that were taken away, or that are not numbers."""
    data = data_of((3.872e-3, 38.76e-6, 4.819e-3))
    row_fraction = data.row_fraction[3:].copy()
    row_fraction[4, 10] = np.nan
    fit = _fit(replace(data, row_px=data.row_px[3:], row_fraction=row_fraction))
    np.testing.assert_array_equal(fit.row_px, np.delete(data.row_px[3:], 4))
    assert fit.timing.time_constant_s == pytest.approx(4.819e-3, abs=60e-6)


@pytest.mark.parametrize(("lowest_ms", "settled"), [(4.5, False), (4.7, True), (5.3, True), (5.5, False)])
def test_a_range_is_settled_by_a_minimum_in_its_middle_third(lowest_ms, settled):
    """Oracle: by hand; of eleven time constants from 4 to 6 ms, 0.2 ms apart, the middle third is that of 4.6 to 5.4 ms."""
    tried = 1e-3 * np.linspace(4, 6, 11)
    found = row_delay_and_lag._minimum(tried, 1 + (tried - 1e-3 * lowest_ms) ** 2)
    assert found.settled is settled


def test_the_range_moves_to_the_minimum_and_says_so(data_of, monkeypatch):
    """Oracle: a start at three times the time constant, whose range of +-30 % does not hold it; simulations are counted."""
    simulated, simulate = [], row_delay_and_lag.simulate
    monkeypatch.setattr(row_delay_and_lag, "simulate", lambda *a, **b: simulated.append(1) or simulate(*a, **b))
    monkeypatch.setattr(row_delay_and_lag, "plausible_time_constant_s", lambda data: 15e-3)
    fit = _fit(data_of((3.872e-3, 38.76e-6, 5e-3)))
    assert fit.n_simulations == len(simulated)
    assert fit.timing.time_constant_s == pytest.approx(5e-3, abs=60e-6)
    assert fit.initial_timing.time_constant_s == 15e-3
    assert (
        "time constants of 10.500 to 19.500 ms have no minimum of the RMS deviation inside"
        in fit.findings[0].sentence()
    )


def test_a_start_far_beside_is_given_up(data_of, monkeypatch):
    """Oracle: six ranges of +-30 % reach down to an eighth of the start."""
    monkeypatch.setattr(row_delay_and_lag, "plausible_time_constant_s", lambda data: 90e-3)
    with pytest.raises(EstimationError, match="no minimum well inside"):
        _fit(data_of((3.872e-3, 38.76e-6, 3e-3)))


def test_rows_that_are_not_the_mask_s_are_refused(data_of):
    """Oracle: rows shifted out of the mask."""
    data = data_of((3.872e-3, 38.76e-6, 4.819e-3))
    with pytest.raises(EstimationError, match="0 image rows have both mask pixels and opening fractions"):
        _fit(replace(data, row_px=data.row_px + 60))


def test_rows_without_slopes_are_refused(data_of):
    """Oracle: rows that jump from plateau to plateau."""
    data = data_of((3.872e-3, 38.76e-6, 4.819e-3))
    with pytest.raises(EstimationError, match="only 0 rows have points between opening fractions 0.2 and 0.8"):
        _fit(replace(data, row_fraction=np.rint(data.row_fraction)))


@pytest.mark.parametrize("tau_s", [2e-3, 4.819e-3, 9e-3])
def test_plausible_time_constant_is_exact_without_rolling(data_of, tau_s):
    """Oracle: the time constant of data in closed form; only the pixels of the mask make the target uneven."""
    assert plausible_time_constant_s(data_of((2e-3, 0.0, tau_s))) == pytest.approx(tau_s, rel=0.1)


def test_plausible_time_constant_is_near_with_rolling(data_of):
    """Oracle: the time constant of data in closed form; well within the range of +-30 % that is tried."""
    assert plausible_time_constant_s(data_of((2e-3, 100e-6, 5e-3))) == pytest.approx(5e-3, rel=0.25)


def test_slopes_without_lag_tell_no_time_constant(data_of):
    """Oracle: jumps from plateau to plateau."""
    data = data_of((3.872e-3, 38.76e-6, 4.819e-3))
    with pytest.raises(EstimationError, match="no range of time constants can be given"):
        plausible_time_constant_s(replace(data, fraction=np.rint(data.fraction)))


@pytest.mark.parametrize("first", [3, 12, 33])
def test_slopes_begin_alike_wherever_the_turn_is_begun_to_count(first):
    """Oracle: the same turn counted from its start; a slope that the end of the turn parts in two is one all the same."""
    fraction = np.clip(1.5 * np.abs(np.mod(np.arange(80), 40) / 20 - 1) - 0.25, 0, 1) + 1e-3 * np.arange(80) / 80
    angle = 2 * np.pi * np.arange(80) / 80

    def starts(by):
        data = SimpleNamespace(
            fraction=np.roll(fraction, -by), wheel_angle_rad=np.roll(angle, -by), angular_frequency_rad_per_s=20.0
        )
        return sorted(plausible_lag._starts(data), key=lambda one: one[1].tolist())

    assert len(starts(0)) == 4
    for found, expected in zip(starts(first), starts(0), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-12)
