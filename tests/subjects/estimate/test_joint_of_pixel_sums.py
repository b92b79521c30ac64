"""The joint fit of several recordings against the truth that made the sums, and against an independent minimiser."""

from dataclasses import replace

import numpy as np
import pytest
from iminuit import Minuit
from irtiming.estimate.joint_delays import Told

from irtiming.errors import EstimationError
from irtiming.estimate import edge_delays, joint_delays, joint_fit, joint_profile, trigger_delay, whiteness
from irtiming.estimate import pixel_sum_model as model_of
from irtiming.physics.wheel import wheel_model
from irtiming.records.estimate import Estimate
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
        edge_miss_px=(0.0, 0.0), u_edge_miss_px=0.3,
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
        warnings=(),
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


def _problem(made, geometry, noise):
    fits = [edge_delays.estimate(one, geometry.model) for one in made]
    prior = U_ANGLE**2 + U_EDGE**2 * np.eye(4)
    return joint_fit.problem(made, fits, geometry=geometry, noise=np.full(len(made), noise), prior_rad2=prior), fits


@pytest.fixture(scope="module")
def noisy(recordings, geometry):
    """Problem, fits and solution of two recordings at 3 and 8 Hz with noise."""
    given, fits = _problem(recordings((3.0, 8.0), noise=2e-5, seed=4), geometry, 2e-5)
    return given, fits, joint_fit.search(given, joint_fit.begin(given, fits))


def test_everything_that_made_the_sums_is_found_from_two_speeds(recordings, geometry):
    """Oracle: the numbers that made the sums; nothing of them is known beforehand to better than 0.5 mrad."""
    given, fits = _problem(recordings((3.0, 8.0)), geometry, 1e-6)
    found = joint_fit.search(given, joint_fit.begin(given, fits))
    assert found.shared[joint_fit.T_MIDDLE] == pytest.approx(MIDDLE, abs=0.03e-6)
    np.testing.assert_allclose(found.shared[joint_fit.EDGES], EARLY, atol=3e-6)
    assert found.shared[joint_fit.OPENING] == pytest.approx(GAMMA, abs=1e-5)
    assert found.shared[joint_fit.WINDOW] == pytest.approx(WINDOW, abs=6e-6)
    np.testing.assert_allclose(found.shared[list(joint_fit.LEANS)], LEANS, atol=5e-4)


def test_the_fit_leaves_its_start_from_either_side(noisy):
    """Oracle: the same minimum from 100 us earlier and later, twice the window and half of it."""
    given, fits, found = noisy
    u = np.sqrt(np.diag(joint_fit.covariance(given, found)))
    for sign, factor in ((1, 2.0), (-1, 0.5)):
        start = joint_fit.begin(given, fits)
        start[joint_fit.T_MIDDLE] += sign * 100e-6
        start[joint_fit.WINDOW] *= factor
        again = joint_fit.search(given, start)
        assert np.all(np.abs(again.shared - found.shared)[:6] < 0.05 * u[:6])
        assert abs(again.shared[joint_fit.WINDOW] - found.shared[joint_fit.WINDOW]) < 0.5 * u[joint_fit.WINDOW]


def _minuit(given, found):
    """The deviance written out, for an independent minimiser, in units of the uncertainties."""
    n = len(given.parts)
    unit = np.sqrt(np.diag(joint_fit.covariance(given, found)))
    own_unit = np.array([[50.0, 100.0, 1e-4, 1e-4, 1e-4]] * n)

    def deviance(x):
        shared, own = found.shared + unit * x[:9], found.own + own_unit * x[9:].reshape(n, 5)
        total = 0.0
        for part, noise, row in zip(given.parts, given.noise, own, strict=True):
            misfit = model_of.residual(given.values(shared, row), part) / noise
            total += float(misfit @ misfit)
        edges = shared[joint_fit.EDGES]
        lean = (shared[list(joint_fit.LEANS)] - given.leans_rad) / given.u_lean_rad
        return total + float(edges @ np.linalg.inv(given.prior_rad2) @ edges + lean @ lean)

    minimiser = Minuit(deviance, np.zeros(9 + 5 * n))
    minimiser.errordef = Minuit.LEAST_SQUARES
    minimiser.errors[:] = 0.3
    return minimiser


def test_minimum_and_errors_are_those_of_an_independent_minimiser(noisy):
    """Oracle: iminuit's MIGRAD and HESSE on the deviance written out, numerical derivatives, all 19 numbers free."""
    given, _, found = noisy
    minimiser = _minuit(given, found)
    minimiser.migrad()
    minimiser.hesse()
    assert minimiser.fval <= found.deviance + 1e-6
    assert minimiser.fval == pytest.approx(found.deviance, abs=0.3)
    values, errors = np.array(minimiser.values), np.array(minimiser.errors)
    assert np.all(np.abs(values[:6]) < 0.1)
    np.testing.assert_allclose(errors[:6], 1.0, rtol=0.05)


def test_profile_is_that_of_an_independent_program(noisy):
    """Oracle: iminuit, holding the delay two uncertainties beside its best and freeing the rest."""
    given, _, found = noisy
    u = float(np.sqrt(joint_fit.covariance(given, found)[0, 0]))
    estimate = Estimate(
        names=("exposure_midpoint_delay",),
        units=("s",),
        values=found.shared[:1],
        covariance=np.array([[u**2]]),
    )
    (profile,) = joint_profile.profiles(given, found, estimate=estimate, integration_time_s=WINDOW)
    lowest = _minuit(given, found).migrad().fval
    for value, deviation in list(zip(profile.values, profile.deviation, strict=True))[::4]:
        held = _minuit(given, found)
        held.values[0] = (value - found.shared[0]) / u
        held.fixed[0] = True
        assert deviation == pytest.approx(held.migrad().fval - lowest, abs=0.15)
    assert profile.upper - profile.value == pytest.approx(u, rel=0.1)
    assert profile.value - profile.lower == pytest.approx(u, rel=0.1)


def test_one_speed_leaves_the_delay_to_the_angles(recordings, geometry):
    """Oracle: by hand; sqrt(0.5^2 + 0.2^2 / 4) mrad over 18.85 rad/s."""
    given, fits = _problem(recordings((3.0,), noise=2e-5), geometry, 2e-5)
    found = joint_fit.search(given, joint_fit.begin(given, fits))
    expected = np.hypot(U_ANGLE, U_EDGE / 2) / (TURN * 3)
    assert np.sqrt(joint_fit.covariance(given, found)[0, 0]) == pytest.approx(expected, rel=0.01)


def test_pulls_of_two_speeds_are_standard(recordings, geometry):
    """Oracle: the delay that made the sums; 8 repetitions of the noise, edges 0.3 mrad off as P allows."""
    pulls = []
    for seed in range(8):
        made = recordings((3.0, 8.0), noise=2e-5, seed=100 + seed)
        fits = [edge_delays.estimate(one, geometry.model) for one in made]
        result = trigger_delay.estimate(made, fits, geometry=geometry, integration_time_s=WINDOW).result
        k = result.estimate.names.index("exposure_midpoint_delay")
        pulls.append((result.estimate.values[k] - MIDDLE) / result.estimate.standard_uncertainties[k])
    assert abs(np.mean(pulls)) < 3.5 / np.sqrt(8)
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1, abs=0.7)


def test_linear_algebra_at_the_minimum_agrees_with_the_minimum(noisy):
    """Oracle: the fit itself; a step from a point beside the minimum leads back to it."""
    given, fits, found = noisy
    beside = found.shared.copy()
    beside[0] += 1e-7
    image, image_pull = given.image(found.shared)
    parts = (joint_delays.AnglePart(source="all", kind="B", covariance_rad2=given.prior_rad2),)
    told = Told(
        shared=found.shared, information=found.information, pull=found.pull, image=image, image_pull=image_pull,
        angles=parts, angular_frequency_rad_per_s=np.array([f.angular_frequency_rad_per_s for f in fits]),
    )  # fmt: skip
    shared = joint_delays.shared_delays(told)
    u = np.sqrt(np.diag(joint_fit.covariance(given, found)))
    assert shared.values[0] == pytest.approx(found.shared[0], abs=0.05 * u[0])
    assert np.sqrt(shared.covariance[0, 0]) == pytest.approx(u[0], rel=1e-4)
    assert shared.values[1] == pytest.approx(shared.values[2], abs=5 * np.sqrt(shared.covariance[1, 1]))
    assert beside[0] != found.shared[0]


def test_recordings_that_cannot_be_one_camera_end_in_one_line(recordings, geometry):
    """Oracle: the docstring; sums of noise alone never settle, or settle nowhere near a wheel."""
    made = recordings((3.0,))
    wild = replace(made[0], pixel_sum=np.random.default_rng(0).normal(9e6, 1e5, 500))
    with pytest.raises(EstimationError):
        edge_delays.estimate(wild, geometry.model)


def test_whiteness_is_a_probability():
    """Oracle: by definition; white residuals give even probabilities, a slow wave none."""
    random = np.random.default_rng(1)
    chances = [whiteness.probability(random.normal(size=500)) for _ in range(200)]
    counts, _ = np.histogram(chances, bins=4, range=(0, 1))
    assert np.all(np.abs(counts - 50) < 4 * np.sqrt(50))
    wave = np.sin(np.arange(500) / 30) + random.normal(size=500)
    assert whiteness.probability(wave) < 1e-10
    assert whiteness.probability(np.zeros(500)) == 1.0
