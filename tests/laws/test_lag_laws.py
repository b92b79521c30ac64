"""Laws of lagging rows that hold for every wheel, every light and every timing."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from irtiming.estimate.harmonic_data import basis, compress, packed
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import EDGE_DELAYS, RowSum, harmonics
from irtiming.physics.response.first_order_lag import transfer
from irtiming.physics.wheel_harmonics import at_angles, later, open_harmonics
from irtiming.records.wheel_geometry import WheelModel

TURN = 2 * np.pi
M = 24


@st.composite
def _wheels(draw):
    """Any ascending edges; where gate and opening stand is only an angle."""
    edges = sorted(draw(st.lists(st.floats(0, TURN), min_size=4, max_size=4)))
    return WheelModel(
        cutout_edges_rad=tuple(edges),
        gate_angle_rad=draw(st.floats(-7, 7)),
        opening_angle_rad=1.0,
        centre_angle_rad=draw(st.floats(-7, 7)),
    )


@st.composite
def _rows(draw):
    """A wheel, three rows of any light, and any speed."""
    light = np.random.default_rng(draw(st.integers(0, 2**31))).normal(size=(3, 2, M + 1))
    return RowSum(
        camera=camera("microbolometer", "rolling"),
        open_harmonics=open_harmonics(draw(_wheels()), M),
        row_harmonics=light[:, 0] + 1j * light[:, 1],
        row_px=np.array(draw(st.lists(st.integers(0, 500), min_size=3, max_size=3, unique=True))),
        angular_frequency_rad_per_s=TURN * draw(st.floats(0.5, 50)),
        step_rad=draw(st.floats(0.01, 3)),
    )


_TIMES = st.floats(-0.05, 0.05)
_TAUS = st.floats(0, 0.1)
_ROW_DELAYS = st.floats(-2e-4, 2e-4)


def _numbers(delay, tau, t_row):
    return dict.fromkeys(EDGE_DELAYS, delay) | {"time_constant": tau, "row_delay": t_row}


@given(_rows(), _TIMES, _TAUS, _ROW_DELAYS, _TIMES)
def test_a_shift_of_the_delay_is_a_shift_of_the_angle(model, delay, tau, t_row, by):
    """Oracle: the wheel has turned on by omega times the delay."""
    theta = np.linspace(0, TURN, 17)
    moved = harmonics(model, _numbers(delay + by, tau, t_row))
    still = harmonics(model, _numbers(delay, tau, t_row))
    shift = model.angular_frequency_rad_per_s * by
    np.testing.assert_allclose(at_angles(moved, theta), at_angles(still, theta + shift), atol=1e-8)


@given(_rows(), _TIMES, _TAUS, _ROW_DELAYS)
def test_row_after_row_is_delay_after_delay(model, delay, tau, t_row):
    """Oracle: eq. 3; row y alone, read y row delays later in a snapshot."""
    whole = harmonics(model, _numbers(delay, tau, t_row))
    for k, row in enumerate(model.row_px):
        alone = harmonics(model, _numbers(delay + row * t_row, tau, 0.0))
        np.testing.assert_allclose(whole[k], alone[k], atol=1e-8)


@given(_rows(), _TIMES, _TAUS, _ROW_DELAYS, st.floats(-3, 3), st.floats(-3, 3))
def test_light_adds_up(model, delay, tau, t_row, a, b):
    """Oracle: eq. 2 is linear; rows lit by two lights show the sum of what each alone shows."""
    other = model.row_harmonics[::-1]

    def shown(light):
        return harmonics(replace(model, row_harmonics=light), _numbers(delay, tau, t_row))

    both = shown(a * model.row_harmonics + b * other)
    np.testing.assert_allclose(both, a * shown(model.row_harmonics) + b * shown(other), atol=1e-10)


@given(_wheels(), st.floats(-4, 4), _TAUS)
def test_a_lagging_pixel_stays_between_covered_and_open(wheel, theta, tau):
    """Oracle: relaxing towards 0 or 1 never leaves what lies between, and nor do Fejer's means, which do not ring at a step."""
    seen = open_harmonics(wheel, M).sum(axis=0) * transfer(3 * TURN, tau, n_harmonics=M)
    of_fejer = 1 - np.arange(M + 1) / (M + 1)
    assert -1e-9 < at_angles(seen * of_fejer, np.array([theta]))[0] < 1 + 1e-9


@given(_wheels(), _TAUS)
def test_lag_leaves_the_mean_and_lowers_every_wave(wheel, tau):
    """Oracle: what goes in comes out; only later and lower, the higher the order the more."""
    factor = transfer(3 * TURN, tau, n_harmonics=M)
    assert factor[0] == 1
    assert np.all(np.diff(np.abs(factor)) <= 1e-15)
    assert np.all(np.angle(factor[1:]) <= 0)
    assert np.all(np.angle(factor) > -np.pi / 2)
    seen = open_harmonics(wheel, M).sum(axis=0)
    turn = TURN * np.arange(200) / 200
    np.testing.assert_allclose(at_angles(seen * factor, turn).mean(), seen[0].real, atol=1e-12)


@settings(deadline=None)
@given(_TAUS, st.integers(1, M))
def test_a_lag_remembers_the_past_less_and_less(tau, order):
    """Oracle: eq. 2 solved: the mean over the past, exp(-s / tau) / tau, of exp(i m omega (t - s)), by scipy's quadrature."""
    wave = order * TURN * tau
    real = quad(lambda x: np.exp(-x) * np.cos(wave * x), 0, 40, limit=1000)[0]
    imaginary = -quad(lambda x: np.exp(-x) * np.sin(wave * x), 0, 40, limit=1000)[0]
    expected = real + 1j * imaginary
    np.testing.assert_allclose(transfer(TURN, tau, n_harmonics=M)[order], expected, atol=1e-7)


@given(_TAUS)
def test_small_lags_are_delays(tau):
    """Oracle: 1 / (1 + i x) = exp(-i x) to second order."""
    small = tau * 1e-3
    x = np.arange(M + 1) * TURN * small
    late = later(-TURN * small, n_harmonics=M)
    assert np.all(np.abs(transfer(TURN, small, n_harmonics=M) - late) <= x**2 + 1e-15)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**31), st.permutations(range(60)))
def test_the_order_of_the_frames_does_not_matter(seed, order):
    """Oracle: the same frames shuffled; sums do not know an order."""
    rng = np.random.default_rng(seed)
    theta, values = rng.uniform(0, 100, 60), rng.normal(0, 100, (60, 2))
    one, other = compress(theta, values, n_harmonics=5), compress(theta[order], values[order], n_harmonics=5)
    np.testing.assert_allclose(one.gram, other.gram, atol=1e-9)
    np.testing.assert_allclose(one.moment, other.moment, atol=1e-8)
    np.testing.assert_allclose(one.power, other.power)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**31), st.floats(-10, 10))
def test_a_turned_wheel_is_the_same_data_turned(seed, by):
    """Oracle: angles shifted by b; harmonics of a model turn by exp(-i m b), its sum of squares stays."""
    rng = np.random.default_rng(seed)
    theta, values = rng.uniform(0, 50, 40), rng.normal(0, 1, (40, 1))
    model = rng.normal(size=6) + 1j * rng.normal(size=6)
    squares = []
    for angle, turned in ((theta, model), (theta + by, model * later(-by, n_harmonics=5))):
        data, f = compress(angle, values, n_harmonics=5), packed(turned)
        squares.append(data.power[0] - 2 * f @ data.moment[0] + f @ data.gram @ f)
    shown = packed(model) @ basis(theta, n_harmonics=5)
    left = values[:, 0] - values.mean() - (shown - shown.mean())
    np.testing.assert_allclose(squares, left @ left, rtol=1e-8)
