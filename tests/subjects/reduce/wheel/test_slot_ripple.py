"""Slots and ripple told apart on tables made by hand."""

import numpy as np
import pytest

from irtiming.physics import slot_orders
from irtiming.records.wheel_calibration import SlotsAtSpeed
from irtiming.reduce.wheel.slot_ripple import separate

TURN = 2 * np.pi
PLACE = TURN * np.arange(100) / 100


def _centred(values):
    return values - values.mean()


def _slots(seed):
    return _centred(np.random.default_rng(seed).normal(0, 3e-4, 100))


def _ripple(order=1, size_rad=5e-4):
    return size_rad * np.cos(order * PLACE + 0.4)


def _seen(slots, ripple, hz, *, u_rad=0.0, seed=0):
    noise = _centred(np.random.default_rng(seed).normal(0, u_rad, 100)) if u_rad else 0.0
    return SlotsAtSpeed(
        rotation_speed_hz=hz,
        n_turns=100,
        deviation_rad=slots + ripple * (3 / hz) ** 2 + noise,
        order_variance_rad2=np.concatenate([[0], np.full(50, u_rad**2)]),
    )


@pytest.mark.parametrize("speeds_hz", [(3.0, 6.0), (3.0, 4.0, 5.0), (3.0, 12.0)])
def test_ripple_that_falls_with_the_square_is_taken_off(speeds_hz):
    """Oracle: the slots and the ripple that made the tables; without noise to the nanoradian."""
    tables = [_seen(_slots(1), _ripple() + _ripple(2, 2e-4), hz, u_rad=0) for hz in speeds_hz]
    slots, ripple = separate(tables)
    np.testing.assert_allclose(slots.deviation_rad, _slots(1), atol=1e-9)
    np.testing.assert_allclose(ripple.deviation_rad, _ripple() + _ripple(2, 2e-4), atol=1e-9)
    assert ripple.reference_speed_hz == 3.0
    assert ripple.chance < 1e-6
    assert np.flatnonzero(ripple.order_chance < 1e-6).tolist() == [1, 2]


@pytest.mark.parametrize("speeds_hz", [(3.0,), (3.0, 3.0), (3.0, 3.5)])
def test_at_one_speed_the_ripple_stays_in_the_slots(speeds_hz):
    """Oracle: by hand; the weighted mean of what was seen, and no ripple claimed."""
    tables = [_seen(_slots(1), _ripple(), hz, u_rad=1e-6, seed=k) for k, hz in enumerate(speeds_hz)]
    slots, ripple = separate(tables)
    assert ripple is None
    np.testing.assert_allclose(slots.deviation_rad, np.mean([t.deviation_rad for t in tables], axis=0), atol=1e-15)
    np.testing.assert_allclose(slots.order_variance_rad2[1:], 1e-12 / len(tables))


def test_noise_is_not_taken_for_ripple():
    """Oracle: 300 wheels without ripple; the error is below that of two free parameters, and the uncertainty is honest."""
    errors, u, chances = [], [], []
    for seed in range(300):
        tables = [_seen(_slots(seed), 0.0, hz, u_rad=1e-5 * hz / 3, seed=1000 * seed + int(hz)) for hz in (3.0, 6.0)]
        slots, ripple = separate(tables)
        errors.append(np.mean((slots.deviation_rad - _slots(seed)) ** 2))
        u.append(slots.u_deviation_rad[0] ** 2)
        chances.append(ripple.chance)
    free = 1e-5 * np.sqrt(16 * 4 + 1) / 3  # (4 c_6 - c_3) / 3, u(c_6) = 2 u(c_3)
    assert np.sqrt(np.mean(errors)) < 0.75 * free
    assert 0.9 < np.sqrt(np.mean(errors) / np.mean(u)) < 1.1
    assert 0.42 < np.mean(chances) < 0.58


@pytest.mark.parametrize("strength", [0.5, 1.0, 2.0, 4.0])
def test_uncertainty_holds_a_ripple_that_is_hardly_seen(strength):
    """Oracle: 60 wheels with a ripple in all orders about as large as its own uncertainty: the worst case for a shrunk one."""
    u_ripple = 1e-5 * np.sqrt(1 + 4) / (1 - 1 / 4)
    errors, u = [], []
    for seed in range(60):
        turned = np.exp(1j * np.random.default_rng(seed).uniform(0, TURN, 51))
        ripple = slot_orders.from_spectrum(strength * u_ripple * turned, 100)
        tables = [_seen(_slots(seed), ripple, hz, u_rad=1e-5 * hz / 3, seed=1000 * seed + int(hz)) for hz in (3.0, 6.0)]
        slots, _ = separate(tables)
        errors.append(np.mean((slots.deviation_rad - _slots(seed)) ** 2))
        u.append(slots.u_deviation_rad[0] ** 2)
    assert 0.9 < np.sqrt(np.mean(errors) / np.mean(u)) < 1.2
