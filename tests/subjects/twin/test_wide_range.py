"""Pixels that radiate against an equation solver, the printed radiances, and the linear twin."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from irtiming.errors import PlanError
from irtiming.twin.lag import response
from irtiming.twin.node_picture import node_picture, read_rows
from irtiming.twin.nodes import trace_nodes
from irtiming.twin.scene import BolometerTiming, RadiativeExchange, Scene, microbolometer_scene
from irtiming.twin.wide_range import read_wide_rows, wide_picture, wide_pixel

_RATE = 6 * math.pi
_EXCHANGE = RadiativeExchange(scene_time_constant_s=10e-3)


def _scene(**radiance: float) -> Scene:
    """32 x 40 pixels; no narcissus, so that closed pixels see the wheel's temperature."""
    scene = microbolometer_scene(32, 40)
    timing = BolometerTiming(time_constant_s=10e-3, radiative=_EXCHANGE)
    return replace(scene, timing=timing, radiance=replace(scene.radiance, narcissus_dn=0.0, **radiance))


def test_radiance_is_that_of_the_paper() -> None:
    """Oracle: Schatz 2023, 3.2.2 and section 4: 48.8 and 57.5 at 288 K and 298 K; 1.63 times steeper at 323 K than at 273 K."""
    pixel = wide_pixel(_scene(blackbody_k=330.0, wheel_k=268.0))
    assert pixel.radiance_of(np.array([288.0, 298.0])) == pytest.approx([48.8, 57.5], abs=0.05)
    near = pixel.radiance_of(np.array([272.5, 273.5, 322.5, 323.5]))
    assert (near[3] - near[2]) / (near[1] - near[0]) == pytest.approx(1.63, abs=0.005)


@pytest.mark.parametrize("shows", ["blackbody", "wheel"])
def test_a_pixel_before_one_surface_follows_the_equation(shows: str) -> None:
    """Oracle: scipy's solve_ivp from where the last ray has passed an edge to where the first meets the next."""
    scene, sharp = _scene(blackbody_k=323.15), microbolometer_scene(64, 80)
    scene = replace(scene, optics=replace(sharp.optics, blur_px=0.2), detector=sharp.detector)
    pixel, shot = wide_pixel(scene), wide_picture(scene, _RATE)
    nodes = trace_nodes(scene, pixel.shortest_lag_s * _RATE / 32)
    live = int(np.flatnonzero(nodes.pixel == 10 * 80 + 39)[0])
    rays = slice(nodes.first_node[live], nodes.first_node[live + 1])
    assert np.all(nodes.behind[rays] == 0)
    begin, end = scene.wheel.cutout_edges_rad[1:3] if shows == "blackbody" else scene.wheel.cutout_edges_rad[2:]
    place = np.arange(shot.level_dn.shape[1]) * 2 * math.pi / shot.level_dn.shape[1]
    within = (place > begin + nodes.offset_rad[rays].max()) & (place < end + nodes.offset_rad[rays].min())
    base = pixel.settled_k(pixel.radiance_of(np.array(288.15)))
    found = base + (shot.level_dn[live, within] - pixel.base_dn) / pixel.dn_per_k
    seen = pixel.radiance_of(np.array(scene.radiance.blackbody_k if shows == "blackbody" else scene.radiance.wheel_k))

    def warming(_: float, kelvin: np.ndarray) -> np.ndarray:
        conducted = (pixel.substrate_k - kelvin) / pixel.substrate_s
        return conducted + pixel.per_radiance * (seen - pixel.radiance_of(kelvin))

    time_s = (place[within] - place[within][0]) / _RATE
    solved = solve_ivp(warming, (0, time_s[-1]), [found[0]], t_eval=time_s, rtol=1e-9, atol=1e-9).y[0]
    assert np.ptp(solved) > 3
    assert found == pytest.approx(solved, abs=1e-4)


def test_a_small_range_is_the_linear_twin() -> None:
    """Oracle: `irtiming.twin.lag` with 1/tau = 1/tau_substrate + L'(T)/L'(T_0)/tau_scene; contrast of 0.5 K, 8000 DN per K."""
    wide = replace(
        _scene(blackbody_k=288.15, wheel_k=288.65, mask_k=288.7, dn_per_k=8000.0, base_dn=0.0),
        timing=BolometerTiming(time_constant_s=10e-3, radiative=replace(_EXCHANGE, substrate_k=288.4)),
    )
    pixel = wide_pixel(wide)
    near = np.diff(pixel.radiance_of(np.array([287.9, 288.9, 299.5, 300.5])))
    tau_s = 1 / (1 / 10e-3 + near[0] / near[2] / 10e-3)
    linear = replace(wide, timing=BolometerTiming(time_constant_s=tau_s))
    shape = (wide.detector.rows, wide.detector.columns)
    radiating, lagging = np.empty(shape, np.float32), np.empty(shape, np.float32)
    curved = wide_picture(wide, _RATE)
    straight = node_picture(linear, response(linear.wheel, _RATE * tau_s), span_rad=_RATE * tau_s)
    for start in np.linspace(0, 2 * math.pi, 7):
        angle = start + np.arange(shape[0]) * 38.76e-6 * _RATE
        read_wide_rows(curved, angle, out=radiating)
        read_rows(straight, angle, speed=0.0, out=lagging)
        assert np.abs(radiating - lagging).max() < 3e-3 * 4000.0


def test_values_settle_where_they_are_stated() -> None:
    """Oracle: the definitions: base_dn before 288.15 K, dn_per_k there; before the substrate's temperature it takes that on."""
    scene = _scene()
    pixel = wide_pixel(scene)
    assert float(pixel.settled_dn(np.array(288.15))) == pytest.approx(scene.radiance.base_dn, abs=1e-6)
    step = np.diff(pixel.settled_dn(np.array([288.05, 288.25])))[0] / 0.2
    assert step == pytest.approx(scene.radiance.dn_per_k, rel=1e-3)
    own = pixel.settled_k(pixel.radiance_of(np.array(pixel.substrate_k)))
    assert float(own) == pytest.approx(pixel.substrate_k, abs=1e-6)


def test_nonsense_is_refused() -> None:
    """Oracle: the messages name what is missing or too large."""
    with pytest.raises(PlanError, match="scene time constant of 0 s"):
        RadiativeExchange(scene_time_constant_s=0)
    with pytest.raises(PlanError, match="no radiative exchange"):
        wide_pixel(microbolometer_scene(32, 40))
    with pytest.raises(PlanError, match="MiB"):
        wide_picture(_scene(), _RATE * 1e-4)
