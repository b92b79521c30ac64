"""Uncertainties of pixel sums: noise and its inflation, leans in the image, corners, and pulls of the joint delay."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from irtiming.estimate import joint, opening_in_image, pixel_numbers, pixel_sums, shared_numbers, timing
from irtiming.estimate.joint import Measurand
from irtiming.estimate.shared_numbers import DELAY
from irtiming.estimate.timing import Timing
from irtiming.physics.light import pixel_sum
from irtiming.physics.wheel import wheel_model
from irtiming.records.reduced import AxleView
from irtiming.records.wheel_geometry import GateAngles, WheelGeometry

TURN = 2 * np.pi
CLOCK_HZ, START = 49_152_000, 7_000_000
EDGES = (0.0, 1.5718, 3.1421, 4.7125)
GAMMA, GATE, CENTRE = float(np.radians(75)), 0.2682, float(np.radians(-90))
MIDDLE, WINDOW = 4.969e-4, 250e-6
EARLY = np.array([3e-4, -2e-4, 5e-4, 1e-4])
LEANS = (6e-3, -4e-3)
RADII = (15.0, 39.5)
U_ANGLE, U_EDGE = 5e-4, 2e-4


@cache
def _sums(rate_hz, *, n=500, instants=24, n_radii=60):
    """Open share of each frame, counted over many instants and radii; mask edges miss the axle, edges come early."""
    t = 20_000_000 / CLOCK_HZ + 1_622_016 * np.arange(n) / CLOCK_HZ
    moments = t[:, None] + MIDDLE + WINDOW * ((np.arange(instants) + 0.5) / instants - 0.5)
    theta = TURN * rate_hz * moments + 0.4
    node, weight = np.polynomial.legendre.leggauss(n_radii)
    radius = np.mean(RADII) + np.diff(RADII)[0] / 2 * node
    share = weight * radius / np.sum(weight * radius)
    place = np.mean(RADII) / radius
    place = place - share @ place
    edges = np.array(EDGES) - EARLY
    total = np.zeros(n)
    for w, x in zip(share, place, strict=True):
        low = np.mod(np.pi / 2 + GATE + theta - CENTRE - GAMMA / 2, TURN) + LEANS[0] * x
        high = low - LEANS[0] * x + GAMMA + LEANS[1] * x
        for turn in (-1, 0, 1):
            for a, b in ((edges[1], edges[2]), (edges[3], TURN + edges[0])):
                over = np.minimum(high, b + TURN * turn) - np.maximum(low, a + TURN * turn)
                total += w * np.maximum(0, over).mean(axis=1)
    return total / GAMMA


def _ring_of_pixels():
    """A mask whose pixels lie at the radii of the sums, and the axle among them."""
    rows, columns = np.mgrid[0:80, 0:80]
    radius = np.hypot(rows - 40, columns - 40)
    inside = (radius >= RADII[0]) & (radius <= RADII[1])
    axle = AxleView(
        row_px=40.0, column_px=40.0, u_centre_px=1e-3, bisector_rad=CENTRE, u_bisector_rad=1e-4, mean_angle_rad=CENTRE,
        u_off_axle_rad=1e-4, edge_miss_px=(0.0, 0.0), u_edge_miss_px=0.3,
    )  # fmt: skip
    return inside, axle


@pytest.fixture(scope="module")
def geometry():
    """What rig.toml says of the wheel."""
    return WheelGeometry(
        model=wheel_model(EDGES, GATE, opening_angle_rad=GAMMA, centre_angle_rad=CENTRE),
        gates=GateAngles(application_rad=GATE, control_rad=0.3, height_m=0.047, sensitivity=(0.5, 0.0, 1.0)),
        angle_budget=(("mask centre angle phi_M", "B", U_ANGLE),),
        u_edge_rad=U_EDGE,
        edges_from="rig.toml",
        camera_roll_rad=None,
        findings=(),
    )


@pytest.fixture(scope="module")
def recordings(track_of, reduced_recording):
    """One recording per wheel rate, with the given noise."""
    mask, axle = _ring_of_pixels()

    def make(rates_hz, *, noise=0.0, seed=0):
        random = np.random.default_rng(seed)
        made = []
        for k, rate in enumerate(rates_hz):
            share = _sums(rate) + noise * random.normal(size=500)
            track = track_of(rate_hz=rate, start=START, duration_s=18.5)
            triggers = START + 20_000_000 + 1_622_016 * np.arange(500, dtype=np.int64)
            one = reduced_recording(
                track, triggers, 9e6 + 2e6 * share, rotation_speed_hz=rate, name=f"run {k}", axle=axle
            )
            made.append(replace(one, opening=replace(one.opening, mask=mask, border_px=2)))
        return made

    return make


ERRORS = (*(f"cutout edge {k}" for k in range(4)), "mask centre angle phi_M")
MIDDLE_DELAY = Measurand(name="exposure_midpoint_delay", weights={DELAY: 1.0})


def _combined(made, geometry, *, noise=None):
    """Timing of the recordings, without reduction and without images; with a noise that is given, or that of each fit."""
    fits = tuple(pixel_sums.fit(one, geometry.model) for one in made)
    if noise is not None:
        fits = tuple(replace(fit, noise=noise, variance_inflation=1.0) for fit in fits)
    models = tuple(timing._model(one, fit, geometry) for one, fit in zip(made, fits, strict=True))
    own = pixel_numbers.opening_and_window(made, fits, geometry=geometry)
    found = timing.of_pixel_fits(fits, geometry, models=models, own=own, stated_s=WINDOW)
    views = (None,) * len(made)
    return Timing(
        recordings=tuple(made), geometry=geometry, sectors=(), views=views, fits=fits, exact=models, found=found
    )


@pytest.fixture(scope="module")
def noisy(recordings, geometry):
    """Two recordings at 3 and 8 Hz with noise, weighed by just that, and nothing taken for common to their residuals."""
    whole = _combined(recordings((3.0, 8.0), noise=2e-5, seed=4), geometry, noise=2e-5)
    shared = [one for one in whole.found.joint.shared if not one.name.startswith(shared_numbers.RESIDUALS)]
    plain = joint.fit(whole.exact, shared)
    result = replace(whole.found.result, estimate=plain.estimate([MIDDLE_DELAY]))
    return replace(whole, found=replace(whole.found, joint=plain, profiled=(MIDDLE_DELAY,), result=result))


def _u(found, name):
    return found.estimate([Measurand(name=name, weights={name: 1.0})]).u(name)


def test_pulls_of_two_speeds_are_standard(noisy, recordings):
    """Oracle: the delay that made the sums; 120 draws of noise and of what rig.toml knows of the angles, one Newton step each.

    Edges are early by what made the sums; what is known of each error is that and a draw of its own uncertainty.
    """
    found, random, pulls = noisy.found.joint, np.random.default_rng(5), []
    exact = recordings((3.0, 8.0))
    true = dict(zip(ERRORS, (*(EARLY / U_EDGE), 0.0), strict=True))
    true |= {
        "lean_low": LEANS[0],
        "lean_high": LEANS[1],
        "integration_time": WINDOW,
        "glare": 0.0,
        shared_numbers.CORNERS_SOURCE: 0.0,
    }
    for _ in range(120):
        models = []
        for one, fit in zip(exact, noisy.fits, strict=True):
            sums = one.pixel_sums.pixel_sum + 2e6 * 2e-5 * random.normal(size=500)
            drawn = replace(one, pixels=replace(one.pixels, pixel_sum=sums))
            models.append(timing._model(drawn, fit, noisy.geometry))
        shared = [
            one if one.u is None else replace(one, known=true[one.name] + one.u * random.normal())
            for one in found.shared
        ]
        there = joint.at_point(models, shared, found=found.found)
        estimate = there.estimate([MIDDLE_DELAY])
        pulls.append((estimate.values[0] - MIDDLE) / estimate.standard_uncertainties[0])
    assert abs(np.mean(pulls)) < 0.25
    assert np.std(pulls) == pytest.approx(1, abs=0.15)


def test_falling_and_rising_slopes_alone_agree(recordings, geometry):
    """Oracle: the sums know of no difference between them; noise and cutout edges make one."""
    found = _combined(recordings((3.0, 8.0), noise=2e-5, seed=4), geometry).found.result.estimate
    apart = found.value("trigger_delay_falling") - found.value("trigger_delay_rising")
    k, m = (found.names.index(f"trigger_delay_{name}") for name in ("falling", "rising"))
    u = np.sqrt(found.covariance[k, k] + found.covariance[m, m] - 2 * found.covariance[k, m])
    assert abs(apart) < 5 * u


@pytest.mark.parametrize("variance_inflation", [1.0, 4.0, 9.0])
def test_correlated_residuals_say_so_much_less(recordings, geometry, variance_inflation):
    """Oracle: the variance inflation itself: the deviance of the frames falls by it, not by its square."""
    (one,) = recordings((3.0,), noise=2e-5)
    fit = replace(pixel_sums.fit(one, geometry.model), variance_inflation=variance_inflation)
    model = timing._model(one, fit, geometry)
    numbers = dict(zip(fit.estimate.names, fit.estimate.values, strict=True))
    numbers |= {"integration_time": WINDOW, "lean_low": 0.0, "lean_high": 0.0}
    plain = timing._model(one, replace(fit, variance_inflation=1.0), geometry).at(numbers)
    assert model.at(numbers).deviance == pytest.approx(plain.deviance / variance_inflation)


def test_noise_counts_its_degrees_of_freedom(recordings, geometry):
    """Oracle: by hand; four delays, opening, memory and bow, and seven numbers of the recording's own are fourteen.

    The seven are covered level and its drift, step, skew, plate, and blades before opening and border.
    """
    (one,) = recordings((3.0,), noise=2e-5)
    fit = pixel_sums.fit(one, geometry.model)
    assert fit.noise == pytest.approx(np.sqrt(fit.residual @ fit.residual / (fit.residual.size - 14)), rel=1e-9)
    assert fit.noise == pytest.approx(2e-5, rel=0.15)
    alone = pixel_sums.pixel_sums(one, geometry.model)
    given = replace(alone, kept=fit.kept, noise=fit.noise * fit.step, radii=pixel_sum.Radii())
    numbers = dict(zip(fit.estimate.names, fit.estimate.values, strict=True))
    numbers |= {"integration_time": WINDOW, "lean_low": 0.0, "lean_high": 0.0}
    jacobian = given.at(numbers).jacobian[:, [list(numbers).index(name) for name in fit.estimate.names]]
    scale = np.linalg.norm(jacobian, axis=0)
    white = np.linalg.inv((jacobian / scale).T @ (jacobian / scale)) / np.outer(scale, scale)
    np.testing.assert_allclose(fit.estimate.covariance, white * fit.variance_inflation, rtol=1e-3)


@pytest.mark.parametrize(("clockwise", "expected"), [(True, (4.0, -3.0)), (False, (3.0, -4.0))])
def test_leans_in_the_image_by_hand(recordings, clockwise, expected):
    """Oracle: by hand; an edge that misses the axle by m px stands m / r beyond its direction, and m over the mean radius there.

    Wheel coordinates grow against polar angles where the wheel turns clockwise: the ends change places and the sign turns.
    """
    (one,) = recordings((3.0,))
    seen = replace(one, axle=replace(one.axle, edge_miss_px=(3.0, -4.0), u_edge_miss_px=0.5))
    leans, u = opening_in_image.edge_misalignments(seen, turns_clockwise=clockwise)
    rows, columns = np.nonzero(one.opening.mask)
    inner, outer = np.quantile(np.hypot(rows - 40, columns - 40), [0.02, 0.98])
    middle = (inner + outer) / 2
    assert leans == pytest.approx(np.array(expected) / middle)
    assert u == pytest.approx(0.5 / middle)
    for unseen in (replace(seen, axle=None), replace(seen, axle=replace(seen.axle, edge_miss_px=None))):
        leans, u = opening_in_image.edge_misalignments(unseen, turns_clockwise=clockwise)
        assert (leans.tolist(), u) == ([0.0, 0.0], 0.01)


@pytest.mark.parametrize("stated_s", [None, WINDOW])
def test_only_several_speeds_tell_a_window(noisy, stated_s):
    """Oracle: by hand; an angle that rounds the corners is a time that falls with the speed, 8 Hz over 3 Hz."""
    window = timing._window(noisy.found.joint, noisy.fits, stated_s=stated_s)
    assert window.is_determined
    assert window.stated_s == stated_s
    assert not timing._window(noisy.found.joint, noisy.fits[:1], stated_s=stated_s).is_determined


def test_speeds_tell_the_window_from_what_rounds_corners_besides(recordings, geometry):
    """Oracle: the window that made the sums; u holds what the straightness of the edges leaves open, most at one speed."""
    u_s = []
    for rates in ((3.0,), (3.0, 8.0)):
        found = _combined(recordings(rates, noise=2e-5, seed=4), geometry).found.joint
        one = found.estimate([Measurand(name="integration_time", weights={"integration_time": 1.0})])
        assert abs(abs(one.values[0]) - WINDOW) < 3 * one.standard_uncertainties[0]
        u_s.append(one.standard_uncertainties[0])
    assert u_s[1] < u_s[0] / 2
