"""Waves around the wheel: amplitudes, covariance and chi-square against sums written out by hand."""

import numpy as np
import pytest

from irtiming.physics import slot_orders

TURN = 2 * np.pi


@pytest.mark.parametrize("n_slots", [15, 60, 100])
def test_amplitude_and_phase_are_those_of_the_wave(n_slots):
    """Oracle: a cosine of known amplitude and phase, at order 1, in the middle and at the last order of an even ring."""
    slot = np.arange(n_slots)
    for order, phase in ((1, 0.7), (n_slots // 3, -2.0), *(((n_slots // 2, 0.0),) if n_slots % 2 == 0 else ())):
        deviation = 3e-4 * np.cos(TURN * order * slot / n_slots + phase)
        assert slot_orders.amplitude_rad(deviation)[order] == pytest.approx(3e-4)
        assert slot_orders.phase_rad(deviation)[order] == pytest.approx(phase)
        assert np.delete(slot_orders.amplitude_rad(deviation), order).max() < 1e-15


@pytest.mark.parametrize("n_slots", [7, 100])
def test_spectrum_leads_back_and_keeps_the_sum_of_squares(n_slots):
    """Oracle: Parseval; each order counts by its degrees of freedom."""
    deviation = np.random.default_rng(1).normal(0, 1e-4, n_slots)
    deviation -= deviation.mean()
    components = slot_orders.spectrum(deviation)
    np.testing.assert_allclose(slot_orders.from_spectrum(components, n_slots), deviation, atol=1e-18)
    waves = slot_orders.degrees_of_freedom(n_slots)
    assert waves.sum() == n_slots - 1
    assert np.sum(waves * np.abs(components) ** 2) == pytest.approx(np.sum(deviation**2))


@pytest.mark.parametrize("n_slots", [7, 12])
def test_covariance_is_that_of_many_random_tables(n_slots):
    """Oracle: 200 000 tables drawn wave by wave with the given variances; their sample covariance."""
    rng = np.random.default_rng(2)
    variance = 1e-8 / np.arange(1, n_slots // 2 + 2) ** 2
    slot = np.arange(n_slots)
    tables = np.zeros((200_000, n_slots))
    for order in range(1, n_slots // 2 + 1):
        for wave in (np.cos, np.sin):
            shape = wave(TURN * order * slot / n_slots)
            if np.abs(shape).max() > 1e-9:
                unit = shape / np.linalg.norm(shape)
                tables += rng.normal(0, np.sqrt(variance[order]), (len(tables), 1)) * unit
    covariance = slot_orders.covariance_rad2(variance, n_slots)
    np.testing.assert_allclose(covariance, np.cov(tables.T), atol=0.01 * covariance[0, 0])
    np.testing.assert_allclose(covariance.sum(axis=0), 0, atol=1e-15)
    assert slot_orders.u_slot_rad(variance, n_slots) == pytest.approx(np.sqrt(covariance[3, 3]))
    seen = np.mean([slot_orders.chi_square(table, variance) for table in tables[:4000]], axis=0)
    np.testing.assert_allclose(seen, slot_orders.degrees_of_freedom(n_slots), atol=0.15)
    amplitudes = np.array([slot_orders.amplitude_rad(table) for table in tables[:4000]])
    waves = np.maximum(
        slot_orders.degrees_of_freedom(n_slots), 1
    )  # a cosine and a sine share the square of an amplitude
    np.testing.assert_allclose(
        np.sqrt(np.mean(amplitudes**2, axis=0) / waves)[1:],
        slot_orders.u_amplitude_rad(variance, n_slots)[1:],
        rtol=0.05,
    )


def test_chance_is_the_tail_of_chi_square():
    """Oracle: printed tables of the chi-square distribution."""
    assert slot_orders.p_value(3.841, 1) == pytest.approx(0.05, rel=1e-3)
    assert slot_orders.p_value(124.342, 100) == pytest.approx(0.05, rel=1e-3)
    assert slot_orders.p_value(0.0, 0.0) == 1
