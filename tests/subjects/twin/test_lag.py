"""The twin's lag against an equation solver, and the light on its lagging pixels against geometry by hand."""

import itertools
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ndtr

from irtiming.twin.clockwork import Motion
from irtiming.twin.lag import Fading, response
from irtiming.twin.node_picture import NodePicture, node_picture, read_rows
from irtiming.twin.nodes import trace_nodes
from irtiming.twin.scene import ChopperWheel, Scene, microbolometer_scene
from irtiming.twin.spread import pixel_spread
from irtiming.twin.views import RowsView

_TAU_S, _RATE = 4.819e-3, 6 * math.pi
_UNEVEN = ChopperWheel(
    ring_edges_rad=(0.0, math.pi / 2 + 4e-4, math.pi + 5e-4, 1.5 * math.pi - 3e-4),
    cutout_errors_rad=(-2e-4, -1e-4, 0.0, 3e-4),
)


@cache
def _lagging_picture(scene: Scene, lag_rad: float) -> NodePicture:
    return node_picture(scene, response(scene.wheel, lag_rad), span_rad=lag_rad)


def _solved(wheel: ChopperWheel, lag_rad: float, alpha: np.ndarray) -> np.ndarray:
    """Equation 2 solved piece by piece between the edges over several turns; level at alpha of the last."""
    turn, edges = 2 * math.pi, sorted(edge % (2 * math.pi) for edge in wheel.cutout_edges_rad)
    opens = [edge % turn for edge in wheel.cutout_edges_rad[1::2]]
    borders = [0.0, *edges, turn]
    seen = 1.0 if edges[-1] in opens else 0.0
    value, level = 0.5, np.empty_like(alpha)
    for _ in range(2 + math.ceil(30 * lag_rad / turn)):
        for begin, end in itertools.pairwise(borders):
            seen = (1.0 if begin in opens else 0.0) if begin in edges else seen
            inside = (alpha >= begin) & (alpha < end)
            solution = solve_ivp(
                lambda _, y, seen=seen: (seen - y) / lag_rad,
                (begin, end),
                [value],
                method="DOP853",
                dense_output=True,
                rtol=1e-11,
                atol=1e-12,
            )
            if inside.any():
                level[inside] = solution.sol(alpha[inside])[0]
            value = solution.y[0, -1]
    return level


def _looked_up(table: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    return np.interp(alpha, np.linspace(0, 2 * math.pi, table.size), table)


@pytest.mark.parametrize("tau_s", [0.3e-3, 1e-3, _TAU_S, 12e-3, 80e-3])
def test_response_is_the_solution_of_the_equation(tau_s: float) -> None:
    """Oracle: scipy's solve_ivp; an error of the level is at most 1 / tau as steep as one of time: below 0.1 us."""
    alpha = np.sort(np.random.default_rng(1).uniform(0, 2 * math.pi, 4000))
    error = _looked_up(response(_UNEVEN, _RATE * tau_s).level, alpha) - _solved(_UNEVEN, _RATE * tau_s, alpha)
    near_edge = np.abs(alpha[:, None] - np.array(_UNEVEN.cutout_edges_rad)).min(axis=1) < 2e-3
    assert np.abs(error[~near_edge]).max() * tau_s < 0.01e-6
    assert np.abs(error).max() * tau_s < 5e-6  # the kink at an edge, within one cell of 1/400 of the lag
    assert abs(np.trapezoid(error, alpha)) / _RATE < 0.02e-6


def test_response_to_a_slow_and_to_a_quick_pixel() -> None:
    """Oracle: limits: a quick pixel sees the wheel as it is, a slow one the mean of the turn."""
    alpha = np.array([0.5, 2.0, 3.0, 3.5, 4.5, 5.0, 6.0])
    assert _looked_up(response(ChopperWheel(), 1e-3).level, alpha) == pytest.approx([0, 1, 1, 0, 0, 1, 1], abs=1e-9)
    assert response(ChopperWheel(), 60.0).level == pytest.approx(0.5, abs=0.01)


def test_change_with_speed_is_that_of_a_wheel_at_another_speed() -> None:
    """Oracle: the response stepped at the other speed; a tenth of a per cent leaves an error of second order."""
    slow, fast = (response(ChopperWheel(), _RATE * _TAU_S * speed) for speed in (1.0, 1.001))
    alpha = np.linspace(0, 6.28, 1000)
    linear = _looked_up(slow.level, alpha) + 0.001 * _looked_up(slow.per_speed, alpha)
    assert np.abs(linear - _looked_up(fast.level, alpha)).max() * _TAU_S < 0.01e-6


def test_what_is_left_fades_as_an_exponential() -> None:
    """Oracle: exp, which the twin does not use."""
    time_s = np.linspace(0, 0.1, 1000)
    left = Fading(_TAU_S).left_after(time_s)
    assert left == pytest.approx(np.exp(-time_s / _TAU_S), abs=1e-6)
    assert Fading(_TAU_S).left_after(np.array([1.0])).tolist() == [0.0]


@pytest.fixture(scope="module")
def scene() -> Scene:
    """120 x 160 pixels, uneven wheel, no mirror image, plate like the wheel: the opening alone is seen."""
    scene = microbolometer_scene(120, 160)
    return replace(
        scene,
        wheel=replace(_UNEVEN, inner_radius_m=6.8e-3),
        radiance=replace(scene.radiance, narcissus_dn=0.0, mask_k=scene.radiance.wheel_k),
        optics=replace(scene.optics, roll_rad=0.01),
    )


def _open_share(scene: Scene, theta: np.ndarray) -> np.ndarray:
    """Share of an ideal opening that lies over a cutout: overlap of intervals of phi, by hand."""
    mask, gate = scene.mask, math.pi / 2 + scene.beams.beta_1_rad
    low, high = (mask.centre_angle_rad + side * mask.opening_angle_rad / 2 for side in (-1, 1))
    a0, a1, a2, a3 = scene.wheel.cutout_edges_rad
    overlap = np.zeros_like(theta)
    for begin, end in ((a1, a2), (a3, a0 + 2 * math.pi)):
        for turns in range(-3, 6):
            top = np.minimum(high, gate + theta - begin - 2 * math.pi * turns)
            bottom = np.maximum(low, gate + theta - end - 2 * math.pi * turns)
            overlap += np.maximum(0.0, top - bottom)
    return overlap / mask.opening_angle_rad


@pytest.mark.parametrize(("tau_s", "wander"), [(1e-3, 0.0), (_TAU_S, 0.0), (_TAU_S, 1e-3), (12e-3, 1e-3)])
def test_light_of_the_opening_lags_behind_the_wheel_as_it_really_turned(
    scene: Scene, tau_s: float, wander: float
) -> None:
    """Oracle: the open share of an ideal opening, by hand, its past weighted by exp(-age / tau): 0.2 us, a frame 2.5."""
    grid_s = np.arange(-0.6, 0.8, 1e-4)
    motion = Motion(time_s=grid_s, angle_rad=1.0 + _RATE * (grid_s + wander * 0.08 * np.sin(grid_s / 0.08)))
    shot = _lagging_picture(scene, _RATE * tau_s)
    lens = RowsView(shot=shot, motion=motion, nominal_rad_per_s=_RATE, looks_s=-tau_s)
    age_s = (np.arange(15_000) + 0.5) * tau_s / 500
    weight = np.exp(-age_s / tau_s) / np.exp(-age_s / tau_s).sum()
    full = math.radians(75) / 2 * (40.2e-3**2 - 8.1e-3**2) / scene.optics.pixel_pitch_m**2
    radiance = scene.radiance
    full *= radiance.level_dn(radiance.blackbody_k) - radiance.level_dn(radiance.wheel_k)
    errors, slopes = [], []
    for time_s in np.linspace(0.0, 0.33, 23):
        now, later = (_open_share(scene, motion.angle_at(t - age_s)) @ weight for t in (time_s, time_s + 1e-6))
        lens.show(np.full(120, time_s), out=(out := np.empty((120, 160), np.float32)))
        errors.append((out.astype(float) - lens.shot.closed_dn).sum() / full - now)
        slopes.append(later - now)
    assert abs(np.dot(errors, slopes) / np.dot(slopes, slopes)) < 0.2  # us
    assert np.abs(errors).max() < 2.5 * np.abs(slopes).max()


def test_light_of_each_row_comes_from_where_the_blur_takes_it(scene: Scene) -> None:
    """Oracle: points of the opening, 1600 to a pixel, dealt to rows by the Gaussian; rows within 5 us, 2 us rms."""
    optics, mask, shape = scene.optics, scene.mask, (120, 160)
    shot = _lagging_picture(scene, _RATE * _TAU_S)
    row, column = np.meshgrid(np.arange(0, 62, 1 / 40) + 1 / 80, np.arange(20, 140, 1 / 40) + 1 / 80, indexing="ij")
    down, right = row - optics.wheel_centre_row_px, column - optics.wheel_centre_column_px
    phi = np.arctan2(down, right) - optics.roll_rad
    radius = np.hypot(down, right) * optics.pixel_pitch_m
    inside = np.abs(phi - mask.centre_angle_rad) <= mask.opening_angle_rad / 2
    inside &= (radius > mask.inner_radius_m) & (radius < mask.outer_radius_m)
    line = row[:, 0]
    beyond = (np.arange(shape[0])[:, None] - line + np.array([[[0.5]], [[-0.5]]])) / optics.blur_px
    dealt = (ndtr(beyond[0]) - ndtr(beyond[1])) / 1600
    lit_line, lit_phi = np.nonzero(inside)[0], phi[inside]
    gain = shot.gains_dn[0, shot.nodes.behind == 0].sum() / shot.nodes.share[shot.nodes.behind == 0].sum()
    errors, slopes = [], []
    for theta in (1.2, 1.9, 2.6, 3.3, 4.3):
        light = [
            _looked_up(shot.response.level, np.mod(shot.gate_rad + theta + t - lit_phi, 2 * math.pi))
            for t in (0.0, 1e-6 * _RATE)
        ]
        now, later = (np.bincount(lit_line, one, minlength=line.size) for one in light)
        read_rows(shot, np.full(120, theta), speed=0.0, out=(out := np.empty(shape, np.float32)))
        errors.append((out.astype(float) - shot.closed_dn).sum(axis=1) / gain - dealt @ now)
        slopes.append(dealt @ (later - now))
    rows = slice(8, 45)
    late_us = np.abs(errors).max(axis=0)[rows] / np.abs(slopes).max(axis=0)[rows]
    assert late_us.max() < 5
    assert np.sqrt(np.mean(late_us**2)) < 2


def test_each_row_is_read_at_its_own_angle(scene: Scene) -> None:
    """Oracle: the same row of a frame whose rows are all read at that angle; equality."""
    shot = _lagging_picture(scene, _RATE * _TAU_S)
    angle = 2.0 + 0.003 * np.arange(120)
    read_rows(shot, angle, speed=0.0, out=(rolling := np.empty((120, 160), np.float32)))
    for row in (10, 25, 40):
        read_rows(shot, np.full(120, angle[row]), speed=0.0, out=(at_once := np.empty((120, 160), np.float32)))
        assert np.array_equal(rolling[row], at_once[row])
        assert not np.array_equal(rolling[row + 1], at_once[row + 1])


def test_places_of_a_pixel_have_the_moments_of_a_blurred_square() -> None:
    """Oracle: by hand: mean 0, variance 1/12 + blur^2, no covariance; kurtosis of square plus Gaussian."""
    for n, blur, variants in ((144, 0.7, 1), (3000, 0.7, 16), (1000, 0.0, 2)):
        place = pixel_spread(n, (blur, blur), variants=variants).astype(float)
        assert place.shape == (variants, n, 2)
        assert place.mean(axis=1) == pytest.approx(0, abs=1e-6)
        assert np.mean(place**2, axis=1) == pytest.approx(1 / 12 + blur**2, rel=1e-5)
        assert np.mean(place[..., 0] * place[..., 1], axis=1) == pytest.approx(0, abs=1e-6)
        fourth = 1 / 80 + 6 * blur**2 / 12 + 3 * blur**4
        assert np.mean(place**4, axis=1) == pytest.approx(fourth, rel=0.05)


def test_nodes_keep_light_and_direction(scene: Scene) -> None:
    """Oracle: area and mean direction of an ideal sector; 1 us is 19 microrad."""
    nodes = trace_nodes(scene, 1e-3)
    phi = np.repeat(nodes.reference_rad, np.diff(nodes.first_node)) + nodes.offset_rad
    light = np.where(nodes.behind == 0, nodes.share, 0.0)
    area = light.sum() * scene.optics.pixel_pitch_m**2
    assert area == pytest.approx(math.radians(75) / 2 * (40.2e-3**2 - 8.1e-3**2), rel=1e-5)
    assert (light @ phi) / light.sum() == pytest.approx(-math.pi / 2, abs=5e-6)


def test_wide_and_narrow_gathering_see_the_same(scene: Scene) -> None:
    """Oracle: the same rays gathered 40 times finer; the sum within 0.1 us, a pixel within a quarter of its noise."""
    shot, lag_rad = _lagging_picture(scene, _RATE * _TAU_S), _RATE * _TAU_S
    fine = trace_nodes(scene, lag_rad / 1280)
    gain = fine.share * (scene.radiance.dn_per_k * (scene.radiance.blackbody_k - scene.radiance.wheel_k))
    finer = replace(shot, nodes=fine, gains_dn=np.where(fine.behind == 0, gain, 0).astype(np.float32)[None])
    assert fine.offset_rad.size > 1.5 * shot.nodes.offset_rad.size
    for theta in np.linspace(0, 6, 13):
        one, other, later = (np.empty((120, 160), np.float32) for _ in range(3))
        read_rows(shot, np.full(120, theta), speed=0.0, out=one)
        read_rows(finer, np.full(120, theta), speed=0.0, out=other)
        read_rows(finer, np.full(120, theta + 1e-4 * _RATE), speed=0.0, out=later)
        assert np.abs(one - other).max() < 1.25
        steepest = max(1.0, abs((later.astype(float) - other).sum()) / 100)
        assert abs((one.astype(float) - other).sum()) < 0.1 * max(steepest, 20.0)
