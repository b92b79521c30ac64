"""Uncertainties of pixel sums: noise and its inflation, leans in the image, corners, and pulls of the joint delay."""

from dataclasses import replace

import numpy as np
import pytest
from sums_by_hand import EARLY, GEOMETRY, LEANS, MIDDLE, U_EDGE, WINDOW, recordings_by_hand

from irtiming.estimate import joint, opening_in_image, pixel_numbers, pixel_sums, timing
from irtiming.estimate.joint import Measurand
from irtiming.estimate.shared_numbers import DELAY
from irtiming.estimate.timing import Timing
from irtiming.physics.light import pixel_sum
from irtiming.records import sources

ERRORS = (*(f"cutout edge {k}" for k in range(4)), "mask centre angle phi_M")
MIDDLE_DELAY = Measurand(name="exposure_midpoint_delay", weights={DELAY: 1.0})


@pytest.fixture(scope="module")
def geometry():
    """What rig.toml says of the wheel."""
    return GEOMETRY


@pytest.fixture(scope="module")
def recordings(track_of, reduced_recording):
    """One recording per wheel rate, with the given noise."""
    return recordings_by_hand(track_of, reduced_recording)


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
    shared = [one for one in whole.found.joint.shared if not one.name.startswith(sources.RESIDUALS)]
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
        "pixel_memory": 0.0,
        sources.STRAIGHTNESS: 0.0,
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
