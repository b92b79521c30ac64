"""The two-constant model of a pixel against an ODE solver, and its limits."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from irtiming.physics.radiance import in_band_radiance, radiance_slope
from irtiming.physics.response.two_constants import (
    TwoConstants,
    after_step,
    bending,
    effective_time_constant,
    relative_slope,
    steady_temperature,
)

HALF = TwoConstants(substrate_time_constant_s=10e-3, scene_time_constant_s=10e-3)
SUBSTRATE_K = 303.15


def _warming(model, pixel_k, scene_k):
    radiative = in_band_radiance(scene_k) - in_band_radiance(pixel_k)
    per_kelvin = float(radiance_slope(model.reference_temperature_k))
    return (SUBSTRATE_K - pixel_k) / model.substrate_time_constant_s + radiative / (
        per_kelvin * model.scene_time_constant_s
    )


@pytest.mark.parametrize("scene_k", [273.15, 303.15, 373.15])
def test_a_steady_pixel_neither_warms_nor_cools(scene_k):
    """Oracle: the differential equation itself; and a pixel lies between what it exchanges heat with."""
    pixel = float(steady_temperature(HALF, scene_k, substrate_temperature_k=SUBSTRATE_K))
    assert abs(_warming(HALF, pixel, scene_k)) * 1e-3 < 1e-9
    assert min(scene_k, SUBSTRATE_K) - 1e-9 <= pixel <= max(scene_k, SUBSTRATE_K) + 1e-9


@pytest.mark.parametrize(("from_k", "to_k"), [(296.0, 323.0), (323.0, 296.0), (296.0, 273.0), (273.0, 296.0)])
def test_a_step_follows_the_differential_equation(from_k, to_k):
    """Oracle: scipy's solve_ivp with the exact Planck integral; the parabola is off by a thousandth of the step at most."""
    time_s = np.linspace(0, 40e-3, 81)
    start = float(steady_temperature(HALF, from_k, substrate_temperature_k=SUBSTRATE_K))
    exact = solve_ivp(
        lambda t, pixel: _warming(HALF, pixel, to_k), (0, time_s[-1]), [start], t_eval=time_s, rtol=1e-10, atol=1e-10
    ).y[0]
    found = after_step(HALF, time_s, from_scene_k=from_k, to_scene_k=to_k, substrate_temperature_k=SUBSTRATE_K)
    size = abs(exact[-1] - exact[0])
    straight = exact[-1] + (start - exact[-1]) * np.exp(-time_s / float(effective_time_constant(HALF, start)))
    assert np.max(np.abs(found - exact)) < 1e-3 * size
    assert np.max(np.abs(straight - exact)) > 10 * np.max(np.abs(found - exact))


def test_a_small_range_is_equation_2():
    """Oracle: the exponential with 1/tau = 1/tau_substrate + L'(T)/L'(T_0)/tau_scene, which a step of 0.1 K must follow."""
    time_s = np.linspace(0, 20e-3, 41)
    found = after_step(HALF, time_s, from_scene_k=303.1, to_scene_k=303.2, substrate_temperature_k=SUBSTRATE_K)
    slope = float(radiance_slope(SUBSTRATE_K) / radiance_slope(300.0))
    tau = 1 / (1 / 10e-3 + slope / 10e-3)
    exponential = found[-1] + (found[0] - found[-1]) * (
        np.exp(-time_s / tau) - np.exp(-time_s[-1] / tau)
    ) / (1 - np.exp(-time_s[-1] / tau))  # fmt: skip
    assert found == pytest.approx(exponential, abs=1e-4 * abs(found[-1] - found[0]))


def test_without_exchange_with_the_scene_the_substrate_is_all():
    """Oracle: the equation with its second term gone: no step is seen, and tau is the substrate's at any temperature."""
    alone = TwoConstants(substrate_time_constant_s=5e-3, scene_time_constant_s=np.inf)
    assert effective_time_constant(alone, [250.0, 350.0]) == pytest.approx([5e-3, 5e-3])
    assert steady_temperature(alone, 400.0, substrate_temperature_k=300.0) == pytest.approx(300.0)
    still = after_step(alone, [0.0, 1e-3], from_scene_k=280.0, to_scene_k=320.0, substrate_temperature_k=300.0)
    assert still == pytest.approx([300.0, 300.0])


def test_the_slope_rises_as_the_paper_says():
    """Oracle: Schatz 2023, section 4: a factor of 1.6 from 273 K to 323 K (1.63 by our integral)."""
    cold = TwoConstants(substrate_time_constant_s=1.0, scene_time_constant_s=1.0, reference_temperature_k=273.0)
    assert float(relative_slope(cold, 323.0)) == pytest.approx(1.63, abs=0.005)


def test_bending_is_half_of_the_spread_of_rates():
    """Oracle: rates of return at both ends by the effective constants, over the middle one; to and fro are alike."""
    rates = 1 / effective_time_constant(HALF, [290.0, 310.0])
    expected = (rates[1] - rates[0]) / 4 * float(effective_time_constant(HALF, 300.0))
    assert float(bending(HALF, 290.0, second_k=310.0)) == pytest.approx(expected, rel=1e-12)
    assert float(bending(HALF, 310.0, second_k=290.0)) == pytest.approx(expected, rel=1e-12)
    assert float(bending(HALF, 300.0, second_k=300.0)) == 0
