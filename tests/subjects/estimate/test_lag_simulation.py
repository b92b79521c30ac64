"""The published simulation: pixels against a count, steps against the textbook's, the result against closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from irtiming.errors import EstimationError
from irtiming.estimate.published.lag_simulation import crossings, simulate
from irtiming.physics.wheel import wheel_model
from irtiming.records.lag_estimate import LagTiming, WheelInImage
from irtiming.records.wheel_geometry import WheelModel

TURN = 2 * np.pi
OMEGA = TURN * 3
EDGES = (0.0, 1.5718, 3.1421, 4.7125)
GATE = float(np.pi / 2 + 0.2682)
MODEL = wheel_model(EDGES, GATE - np.pi / 2, opening_angle_rad=float(np.radians(75)), centre_angle_rad=-np.pi / 2)
WHEEL = WheelInImage(row_px=60.4, column_px=79.6, roll_rad=0.0)
TIMING = LagTiming(trigger_delay_s=3.872e-3, row_delay_s=150e-6, time_constant_s=4.819e-3)


def _mask(shape=(120, 160)):
    row, column = np.mgrid[: shape[0], : shape[1]]
    phi = np.arctan2(row - WHEEL.row_px, column - WHEEL.column_px)
    radius = np.hypot(row - WHEEL.row_px, column - WHEEL.column_px)
    return (np.abs(phi + np.pi / 2) < np.radians(37.5)) & (radius > 14) & (radius < 52)


def _counted(row, column, angle, *, roll=0.0, counterclockwise=False):
    """Share of pixels with alpha in [alpha_1, alpha_2) or [alpha_3, 2 pi), one by one."""
    phi = np.arctan2(row - WHEEL.row_px, column - WHEEL.column_px) - roll
    alpha = np.mod(GATE + np.asarray(angle)[:, None] - (np.pi - phi if counterclockwise else phi), TURN)
    is_open = ((alpha >= EDGES[1]) & (alpha < EDGES[2])) | (alpha >= EDGES[3])
    return is_open.mean(axis=1)


def _normalised(curve):
    """Halves of the turn from one middle of a lower plateau to the next."""
    order = np.roll(curve, -int(np.argmin(curve)))
    middle = order.size // 4 + int(np.argmin(order[order.size // 4 : 3 * order.size // 4]))
    low = (order[0] + order[middle]) / 2
    high = (order[:middle].max() + order[middle:].max()) / 2
    return (curve - low) / (high - low)


@pytest.mark.parametrize(("rotation", "roll"), [("clockwise", 0.0), ("clockwise", 0.03), ("counterclockwise", -0.05)])
def test_fraction_between_crossings_is_the_count_of_open_pixels(rotation, roll):
    """Oracle: every pixel's angle against the cutout edges, at random wheel angles."""
    mask = _mask()
    wheel = WheelInImage(row_px=WHEEL.row_px, column_px=WHEEL.column_px, roll_rad=roll, rotation=rotation)
    found = crossings(mask, MODEL, wheel=wheel)
    angle = np.random.default_rng(0).uniform(0, TURN, 300)
    np.testing.assert_array_equal(found.row_px, np.flatnonzero(mask.any(axis=1)))
    np.testing.assert_array_equal(found.pixels, mask[found.row_px].sum(axis=1))
    for i, y in enumerate(found.row_px):
        own = slice(found.first[i], found.first[i + 1])
        assert np.all(np.diff(found.angle_rad[own]) >= 0)
        at = np.searchsorted(found.angle_rad[own], angle, side="right") - 1
        columns = np.flatnonzero(mask[y])
        counted = _counted(y, columns, angle, roll=roll, counterclockwise=rotation == "counterclockwise")
        np.testing.assert_allclose(found.fraction[own][at], counted, atol=1e-12)


def test_steps_are_those_of_the_classical_runge_kutta_method():
    """Oracle: the four stages written out, ten steps per sample and three turns from 0.5, for one row of pixels."""
    mask = np.zeros((120, 160), bool)
    mask[30, 65:95] = True
    samples = 60
    found = simulate(crossings(mask, MODEL, wheel=WHEEL), TIMING, samples=samples, angular_frequency_rad_per_s=OMEGA)
    step_s = TURN / OMEGA / samples / 10
    half = TURN / samples / 20 * np.arange(20 * samples + 1)
    advance = OMEGA * (TIMING.trigger_delay_s + 30 * TIMING.row_delay_s)
    target = _counted(30, np.flatnonzero(mask[30]), half + advance)
    value, out = 0.5, np.zeros(samples)
    for turn in range(3):
        for n in range(10 * samples):
            if turn == 2 and n % 10 == 0:
                out[n // 10] = value
            start, middle, end = target[2 * n : 2 * n + 3]
            k1 = (start - value) / TIMING.time_constant_s
            k2 = (middle - value - step_s / 2 * k1) / TIMING.time_constant_s
            k3 = (middle - value - step_s / 2 * k2) / TIMING.time_constant_s
            k4 = (end - value - step_s * k3) / TIMING.time_constant_s
            value += step_s / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    np.testing.assert_allclose(found.row_fraction[0], _normalised(out), atol=1e-12)
    np.testing.assert_allclose(found.fraction, found.row_fraction[0], atol=1e-12)
    np.testing.assert_allclose(found.wheel_angle_rad, TURN * np.arange(samples) / samples, atol=1e-12)


def test_follows_the_differential_equation_of_an_adaptive_solver():
    """Oracle: scipy's solve_ivp, restarted at every jump of one row's counted opening."""
    mask = np.zeros((120, 160), bool)
    mask[30, 70:90] = True
    table = crossings(mask, MODEL, wheel=WHEEL)
    found = simulate(table, TIMING, samples=500, angular_frequency_rad_per_s=OMEGA)
    advance = OMEGA * (TIMING.trigger_delay_s + 30 * TIMING.row_delay_s)
    samples = advance + TURN * np.arange(501) / 500
    turns = TURN * np.arange(np.floor(advance / TURN), np.floor(advance / TURN) + 3)
    jumps = (turns[:, None] + table.angle_rad).ravel()
    places = np.unique(np.concatenate([jumps[(jumps > samples[0]) & (jumps < samples[-1])], samples]))
    values = {}
    value = 0.5
    for _ in range(2):
        for begin, end in pairwise(places):
            values[begin] = value
            seen = float(_counted(30, np.flatnonzero(mask[30]), [(begin + end) / 2])[0])
            lag = OMEGA * TIMING.time_constant_s
            done = solve_ivp(lambda _, v, s=seen, lag=lag: (s - v) / lag, (begin, end), [value], rtol=1e-8, atol=1e-10)
            value = float(done.y[0, -1])
    exact = np.array([values[s] for s in samples[:-1]])
    np.testing.assert_allclose(found.row_fraction[0], _normalised(exact), atol=2e-3)


def test_agrees_with_the_closed_form(lagging_rows):
    """Oracle: each harmonic of the opening divided by 1 + i k omega tau, row by row with its delay."""
    mask = _mask()
    data = lagging_rows(
        mask,
        (WHEEL.row_px, WHEEL.column_px),
        timing_s=(TIMING.trigger_delay_s, TIMING.row_delay_s, TIMING.time_constant_s),
        gate_rad=GATE,
        edges_rad=EDGES,
    )
    found = simulate(crossings(mask, MODEL, wheel=WHEEL), TIMING, samples=1000, angular_frequency_rad_per_s=OMEGA)
    at = data.wheel_angle_rad
    np.testing.assert_allclose(
        np.interp(at, found.wheel_angle_rad, found.fraction, period=TURN), data.fraction, atol=2e-4
    )
    rows = [np.interp(at, found.wheel_angle_rad, row, period=TURN) for row in found.row_fraction]
    np.testing.assert_allclose(rows, data.row_fraction, atol=4e-3)
    assert np.sqrt(np.mean((rows - data.row_fraction) ** 2)) < 5e-4


def test_row_delay_advances_each_row_by_its_own_angle():
    """Oracle: the same row simulated with its whole delay as a trigger delay."""
    table = crossings(_mask(), MODEL, wheel=WHEEL)
    rolling = simulate(table, TIMING, samples=200, angular_frequency_rad_per_s=OMEGA)
    for i in (0, 11, 30):
        delay_s = TIMING.trigger_delay_s + table.row_px[i] * TIMING.row_delay_s
        still = LagTiming(trigger_delay_s=delay_s, row_delay_s=0.0, time_constant_s=TIMING.time_constant_s)
        found = simulate(table, still, samples=200, angular_frequency_rad_per_s=OMEGA)
        np.testing.assert_allclose(found.row_fraction[i], rolling.row_fraction[i], atol=1e-12)


def test_plateaus_lie_on_average_at_zero_and_one():
    """Oracle: extrema of the halves of the turn between the middles of the slopes."""
    found = simulate(crossings(_mask(), MODEL, wheel=WHEEL), TIMING, samples=1000, angular_frequency_rad_per_s=OMEGA)
    for curve in (found.fraction, *found.row_fraction):
        np.testing.assert_allclose(curve, _normalised(curve), atol=1e-9)


def test_a_mask_without_pixels_is_refused():
    """Oracle: there is nothing to count."""
    with pytest.raises(EstimationError, match="the mask has no pixel"):
        crossings(np.zeros((20, 20), bool), MODEL, wheel=WHEEL)


def test_a_time_constant_below_one_step_is_refused():
    """Oracle: 200 angles of 1/3 s in ten steps each are 166.7 us."""
    short = LagTiming(trigger_delay_s=0.0, row_delay_s=0.0, time_constant_s=150e-6)
    with pytest.raises(EstimationError, match=r"150\.0 µs with 200 angles per turn: a simulation step, 166\.7 µs"):
        simulate(crossings(_mask(), MODEL, wheel=WHEEL), short, samples=200, angular_frequency_rad_per_s=OMEGA)


def test_a_wheel_with_one_cutout_is_refused():
    """Oracle: the opening rises and falls once per turn only."""
    one = WheelModel(
        cutout_edges_rad=(0.0, 1.5, 3.1, 6.28),
        gate_angle_rad=GATE,
        opening_angle_rad=MODEL.opening_angle_rad,
        centre_angle_rad=MODEL.centre_angle_rad,
    )
    table = crossings(_mask(), one, wheel=WHEEL)
    with pytest.raises(EstimationError, match="does not rise and fall twice per turn"):
        simulate(table, TIMING, samples=200, angular_frequency_rad_per_s=OMEGA)
