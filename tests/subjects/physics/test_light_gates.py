"""Depth of the light gates by Newton's method against a bracketing solver, differences and a symmetric case."""

from dataclasses import replace
from math import asin, atan, pi, radians, tan

import numpy as np
import pytest
from scipy.optimize import brentq

from irtiming.errors import GeometryError
from irtiming.physics.light_gates import gate_angles, refuse_other_slots
from irtiming.records.rig import LightGates, Measured


def _gates(d, dh):
    return LightGates(half_separation_m=Measured(d), height_difference_m=Measured(dh), whole_slots_between=9)


def _beside(d, dh, x):
    return LightGates(
        half_separation_m=Measured(d),
        height_difference_m=Measured(dh),
        whole_slots_between=9,
        lateral_offset_m=Measured(x),
    )


def _separation(h, d, dh):
    return atan(d / h) + atan(d / (h - dh))


@pytest.mark.parametrize("d", [1e-3, 13e-3, 0.2])
@pytest.mark.parametrize("dh", [-8e-3, 0.0, 5.5e-3, 30e-3])
@pytest.mark.parametrize("depth", [1e-3, 10e-3, 47e-3, 1.0])
def test_depth_agrees_with_a_bracketing_solver(d, dh, depth):
    """Oracle: scipy's brentq on dbeta(h), which falls from nearly pi to 0 over all possible depths."""
    low = max(dh, 0.0)
    separation = _separation(low + depth, d, dh)
    found = gate_angles(separation, _gates(d, dh))
    h = brentq(lambda x: _separation(x, d, dh) - separation, low + 1e-9, low + 10.0, xtol=1e-15, rtol=1e-14)
    assert found.height_m == pytest.approx(h, rel=1e-7)
    assert found.application_rad + found.control_rad == pytest.approx(separation, abs=1e-12)
    assert found.application_rad == pytest.approx(atan(d / h), abs=1e-9)


def test_gates_at_equal_height_share_the_angle():
    """Oracle: by hand; dh = 0 puts both gates at dbeta / 2, and d = h tan 30 deg."""
    found = gate_angles(radians(60), _gates(tan(radians(30)), 0.0))
    assert found.height_m == pytest.approx(1.0, abs=1e-14)
    assert found.application_rad == pytest.approx(radians(30), abs=1e-14)
    assert found.control_rad == pytest.approx(radians(30), abs=1e-14)
    # dbeta is shared equally; moving both gates out leaves the shares; lowering one gate by dh, as seen from the
    # axle at distance r = h / cos 30, turns it by dh sin 30 / r, half of which the other one gets
    per_separation, per_d, per_dh = found.sensitivity
    assert per_separation == pytest.approx(0.5)
    assert per_d == pytest.approx(0.0, abs=1e-14)
    assert per_dh == pytest.approx(-0.5 * np.sin(radians(30)) * np.cos(radians(30)))


def test_the_gate_nearer_the_axle_has_the_larger_angle():
    """Oracle: the drawing, figure 4(a): same d, smaller height, larger angle from the vertical."""
    found = gate_angles(0.57, _gates(13e-3, 5.5e-3))
    assert found.control_rad > found.application_rad > 0
    assert tan(found.control_rad) * (found.height_m - 5.5e-3) == pytest.approx(13e-3)


def test_known_rig_of_3_4_5_triangles():
    """Oracle: by hand; d = 12, gates 16 and 9 below the axle are at atan(3/4) and atan(4/3), together 90 deg."""
    found = gate_angles(pi / 2, _gates(12.0, 7.0))
    assert found.height_m == pytest.approx(16.0, rel=1e-13)
    assert found.application_rad == pytest.approx(asin(0.6), abs=1e-13)
    assert found.control_rad == pytest.approx(asin(0.8), abs=1e-13)


@pytest.mark.parametrize(("separation", "d", "dh"), [(0.5697, 13e-3, 5.5e-3), (1.8, 40e-3, -3e-3), (0.2, 0.01, 0.02)])
def test_sensitivities_are_the_derivatives(separation, d, dh):
    """Oracle: central differences of beta_1 to dbeta, d and dh."""

    def beta(*arguments):
        return gate_angles(arguments[0], _gates(arguments[1], arguments[2])).application_rad

    point = np.array([separation, d, dh])
    found = gate_angles(separation, _gates(d, dh)).sensitivity
    for i, size in enumerate((1e-5, d * 1e-4, d * 1e-4)):
        step = size * np.eye(3)[i]
        slope = (beta(*(point + step)) - beta(*(point - step))) / (2 * size)
        assert found[i] == pytest.approx(slope, rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("separation", [0.0, -0.3, pi, 4.0, float("nan")])
def test_separation_beyond_half_a_turn_is_refused(separation):
    """Oracle: two gates below the axle are less than half a turn apart."""
    with pytest.raises(GeometryError, match=r"must lie between 0 and pi; correct .beams. whole_slots_between"):
        gate_angles(separation, _gates(13e-3, 5.5e-3))


@pytest.mark.parametrize("dh", [20e-3, -20e-3])
def test_gates_that_would_lie_above_the_axle_are_refused(dh):
    """Oracle: by hand; d = 1 mm and |dh| = 20 mm keep dbeta below 90 deg + atan(1/20), so 2 rad cannot be."""
    with pytest.raises(
        GeometryError, match=r"mm below the axle, which they cannot; correct .beams. half_separation_mm"
    ):
        gate_angles(2.0, _gates(1e-3, dh))


@pytest.mark.parametrize("x", [-2e-3, 0.06e-3, 5e-3])
@pytest.mark.parametrize("dh", [-8e-3, 0.0, 5.5e-3])
def test_beams_beside_the_axle_agree_with_a_bracketing_solver(x, dh):
    """Oracle: scipy's brentq on dbeta(h) = atan((d - x) / h) + atan((d + x) / (h - dh)); beta_1 = atan((d - x) / h)."""
    d, h = 13e-3, 47e-3
    separation = atan((d - x) / h) + atan((d + x) / (h - dh))
    found = gate_angles(separation, _beside(d, dh, x))
    low = max(dh, 0.0)
    solved = brentq(lambda y: atan((d - x) / y) + atan((d + x) / (y - dh)) - separation, low + 1e-9, 10.0, xtol=1e-15)
    assert solved == pytest.approx(h)
    assert found.height_m == pytest.approx(h, rel=1e-9)
    assert found.application_rad == pytest.approx(atan((d - x) / h), abs=1e-12)
    assert found.control_rad == pytest.approx(atan((d + x) / (h - dh)), abs=1e-12)


@pytest.mark.parametrize("x", [-1e-3, 0.0, 0.3e-3])
def test_sensitivity_to_the_lateral_offset_is_the_derivative(x):
    """Oracle: central differences of beta_1 to x; conventions.md: 0.1 mm is about 2 mrad."""
    ahead, behind = (gate_angles(0.5697, _beside(13e-3, 5.5e-3, x + s)).application_rad for s in (1e-6, -1e-6))
    found = gate_angles(0.5697, _beside(13e-3, 5.5e-3, x)).per_lateral_offset
    assert found == pytest.approx((ahead - behind) / 2e-6, rel=1e-6)
    assert 1e-4 * found == pytest.approx(-2e-3, rel=0.15)


@pytest.mark.parametrize("x", [13e-3, -14e-3])
def test_beams_on_one_side_of_the_axle_are_refused(x):
    """Oracle: figure 4(a); one beam on either side of the vertical through the axle."""
    with pytest.raises(GeometryError, match=r"correct .beams. lateral_offset_mm"):
        gate_angles(0.57, _beside(13e-3, 5.5e-3, x))


@pytest.mark.parametrize(("ruler_mm", "fits"), [(47, 9), (49.5, 9), (45, 9), (53.0, 8), (42.5, 10)])
def test_a_ruler_tells_the_whole_slots(ruler_mm, fits):
    """Oracle: by hand; 0.5697 rad put the gate 48 mm below the axle, a slot (2 pi / 100) more or less 5 mm higher or lower."""
    gates = replace(_gates(13e-3, 5.5e-3), height_m=ruler_mm * 1e-3)
    if fits == 9:
        refuse_other_slots(0.5697, gates, control_slots=100)
        return
    with pytest.raises(GeometryError, match=rf"whole_slots_between = {fits} fits"):
        refuse_other_slots(0.5697, gates, control_slots=100)


def test_without_a_ruler_nothing_is_refused():
    """Oracle: the docstring."""
    refuse_other_slots(0.5697, _gates(13e-3, 5.5e-3), control_slots=100)
