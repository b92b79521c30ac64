"""The joint fit of several recordings against the truth that made the sums, and against an independent minimiser."""

from dataclasses import replace

import numpy as np
import pytest
from iminuit import Minuit
from sums_by_hand import EARLY, GAMMA, GEOMETRY, LEANS, MIDDLE, TURN, U_ANGLE, U_EDGE, WINDOW, recordings_by_hand

from irtiming.errors import EstimationError
from irtiming.estimate import joint, measurands, pixel_numbers, pixel_sums, profiles, shared_numbers
from irtiming.estimate.pixel_sums import SHAPE
from irtiming.records.estimate import EDGE_DELAYS


@pytest.fixture(scope="module")
def geometry():
    """What rig.toml says of the wheel."""
    return GEOMETRY


@pytest.fixture(scope="module")
def recordings(track_of, reduced_recording):
    """One recording per wheel rate, with the given noise."""
    return recordings_by_hand(track_of, reduced_recording)


def _given(made, geometry, noise):
    """Models of the recordings with a known noise, and what they share."""
    fits = [pixel_sums.fit(one, geometry.model) for one in made]
    parts = [
        replace(pixel_sums.pixel_sums(one, geometry.model), kept=fit.kept, noise=noise * abs(fit.step))
        for one, fit in zip(made, fits, strict=True)
    ]
    middle = min(float(np.mean([fit.estimate.value(name) for name in EDGE_DELAYS])) for fit in fits)
    shared = [
        shared_numbers.delay(fits, start=middle),
        *pixel_numbers.opening_and_window(made, fits, geometry=geometry),
        *shared_numbers.rig_errors(fits, geometry, u_edge_rad=U_EDGE),
    ]
    return [joint.LocalModel(names=(*EDGE_DELAYS, *SHAPE), at=part.at) for part in parts], shared, fits


@pytest.fixture(scope="module")
def noisy(recordings, geometry):
    """Models, shared numbers and joint fit of two recordings at 3 and 8 Hz with noise."""
    models, shared, _ = _given(recordings((3.0, 8.0), noise=2e-5, seed=4), geometry, 2e-5)
    return models, shared, joint.fit(models, shared)


def _edges(found):
    """Angles by which the edges come early, from the errors that turn them."""
    values = found.found.values
    return np.array(
        [U_ANGLE * values["mask centre angle phi_M"] + U_EDGE * values[f"cutout edge {k}"] for k in range(4)]
    )


def test_everything_that_made_the_sums_is_found_from_two_speeds(recordings, geometry):
    """Oracle: the numbers that made the sums; nothing of them is known beforehand to better than 0.5 mrad."""
    models, shared, _ = _given(recordings((3.0, 8.0)), geometry, 1e-6)
    found = joint.fit(models, shared)
    values = found.found.values
    assert values["delay"] == pytest.approx(MIDDLE, abs=0.03e-6)
    np.testing.assert_allclose(_edges(found), EARLY, atol=3e-6)
    assert values["opening_angle"] == pytest.approx(GAMMA, abs=1e-5)
    assert abs(values["integration_time"]) == pytest.approx(WINDOW, abs=6e-6)
    np.testing.assert_allclose([values["lean_low"], values["lean_high"]], LEANS, atol=5e-4)


def test_the_fit_leaves_its_start_from_either_side(noisy):
    """Oracle: the same minimum from 100 us earlier and later, twice the window and half of it."""
    models, shared, found = noisy
    u = np.sqrt(np.diag(found.combined().covariance))
    for sign, factor in ((1, 2.0), (-1, 0.5)):
        moved = {"delay": sign * 100e-6, "integration_time": (factor - 1) * shared[2].start}
        begun = [replace(one, start=one.start + moved.get(one.name, 0.0)) for one in shared]
        again = joint.fit(models, begun)
        apart = np.abs(again.values - found.values) / u
        assert np.all(apart[[0, 1]] < 0.05)
        assert np.all(apart[5:] < 0.05)
        assert apart[2] < 0.5
        assert again.found.is_settled


def _deviance(models, shared, found):
    """The deviance written out, over numbers in units of their uncertainties from the minimum."""
    unit, best = np.sqrt(np.diag(found.combined().covariance)), found.values

    def deviance(x):
        numbers = dict(zip(found.names, best + unit * np.asarray(x), strict=True))
        total = sum(((numbers[one.name] - one.known) / one.u) ** 2 for one in shared if one.u is not None)
        for k, model in enumerate(models):
            local = {
                name: sum(one.effects[k].get(name, 0.0) * numbers[one.name] for one in shared) for name in model.names
            }
            total += float(np.sum(model.at(local).residual ** 2))
        return total

    return deviance


def _minuit(models, shared, found):
    """That deviance for an independent minimiser."""
    minimiser = Minuit(_deviance(models, shared, found), np.zeros(len(shared)))
    minimiser.errordef = Minuit.LEAST_SQUARES
    minimiser.strategy = 0  # only the minimum is asked for, not its curvature
    minimiser.errors[:] = 0.3
    return minimiser


@pytest.fixture(scope="module")
def lowest(noisy):
    """The minimum of iminuit's MIGRAD, numerical derivatives, all numbers free."""
    return _minuit(*noisy).migrad()


def _by_second_differences(deviance, n, *, h=0.1):
    """Covariance of its numbers from the deviance's second differences."""
    ways = h * np.concatenate([np.eye(n), -np.eye(n)])
    curved, at_zero = np.zeros((n, n)), deviance(np.zeros(n))
    alone = [deviance(way) for way in ways]
    for i in range(n):
        curved[i, i] = (alone[i] + alone[n + i] - 2 * at_zero) / h**2
        for j in range(i):
            both = deviance(ways[i] + ways[j]) + deviance(-ways[i] - ways[j])
            both -= alone[i] + alone[n + i] + alone[j] + alone[n + j] - 2 * at_zero
            curved[i, j] = curved[j, i] = both / (2 * h**2)
    return np.linalg.inv(curved / 2)


def test_minimum_is_that_of_an_independent_minimiser(noisy, lowest):
    """Oracle: iminuit's MIGRAD on the deviance written out, numerical derivatives, all numbers free."""
    _, shared, found = noisy
    assert lowest.fval <= found.found.at.deviance + 1e-6
    assert lowest.fval == pytest.approx(found.found.at.deviance, abs=0.3)
    values = np.array(lowest.values)
    sure = [k for k, one in enumerate(shared) if one.name not in SHAPE[1:]]  # the corners' shape is no parabola
    assert np.all(np.abs(values[sure]) < 0.1)


def test_errors_are_those_of_second_differences(recordings, geometry):
    """Oracle: brute force; second differences of the deviance written out, all numbers free.

    The noise is stated, but the sums have none: a second derivative holds the drawn noise times the model's own curvature, which
    in the few frames with corners is a tenth of it, and the information, its mean over all draws, does not.
    """
    models, shared, _ = _given(recordings((3.0, 8.0)), geometry, 2e-5)
    found = joint.fit(models, shared)
    covariance = _by_second_differences(_deviance(models, shared, found), len(shared))
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), 1.0, rtol=0.05)
    turned = np.array([[U_ANGLE * (one.name.startswith("mask")) + U_EDGE * (one.name == f"cutout edge {k}") for one in shared]
                       for k in range(4)])  # fmt: skip
    turned = turned * np.sqrt(np.diag(found.combined().covariance))
    theirs = np.sqrt(np.diag(turned @ covariance @ turned.T))
    ours = found.estimate(measurands.edge_angles(found, TURN * 3)).standard_uncertainties
    np.testing.assert_allclose(theirs, ours, rtol=0.05)


def test_profile_is_that_of_an_independent_program(noisy, lowest):
    """Oracle: iminuit, holding the delay two uncertainties on either side of its best and freeing the rest."""
    models, shared, found = noisy
    u = float(np.sqrt(found.combined().variance({"delay": 1.0})))
    delay = joint.Measurand(name="exposure_midpoint_delay", weights={"delay": 1.0})
    profile = profiles.profile(delay, found, u=u)
    ends = list(zip(profile.values, profile.deviation, strict=True))
    for value, deviation in (ends[0], ends[-1]):
        held = _minuit(models, shared, found)
        held.values[0] = (value - found.found.values["delay"]) / u
        held.fixed[0] = True
        assert deviation == pytest.approx(held.migrad().fval - lowest.fval, abs=0.15)
    assert profile.upper - profile.value == pytest.approx(u, rel=0.1)
    assert profile.value - profile.lower == pytest.approx(u, rel=0.1)


def test_one_speed_leaves_the_delay_to_the_angles(recordings, geometry):
    """Oracle: by hand; sqrt(0.5^2 + 0.2^2 / 4) mrad over 18.85 rad/s."""
    models, shared, _ = _given(recordings((3.0,), noise=2e-5), geometry, 2e-5)
    found = joint.fit(models, shared)
    expected = np.hypot(U_ANGLE, U_EDGE / 2) / (TURN * 3)
    assert np.sqrt(found.combined().variance({"delay": 1.0})) == pytest.approx(expected, rel=0.01)


def test_pulls_of_two_speeds_are_standard(noisy):
    """Oracle: 400 draws of frames' noise and of the errors' true values, moved through one linear step at the minimum.

    The covariance of the joint fit must be that of the step's results; their spread over u is 1 within 0.1.
    """
    _, shared, found = noisy
    whole, random = found.combined(), np.random.default_rng(5)
    parts = [np.linalg.eigh(piece.matrix) for piece in found.pieces]  # of numbers that no frame tells they are 0
    roots = [axes * np.sqrt(np.maximum(sizes, 0.0)) for sizes, axes in parts]
    made, pulls = found.designs(), []
    for _ in range(400):
        pull = sum(a.T @ (root @ random.normal(size=len(root))) for a, root in zip(made, roots, strict=True))
        pull = pull + np.array([0.0 if one.u is None else random.normal() / one.u for one in shared])
        pulls.append((whole.covariance @ pull)[0] / np.sqrt(whole.variance({"delay": 1.0})))
    assert abs(np.mean(pulls)) < 4 / np.sqrt(400)
    assert np.std(pulls) == pytest.approx(1, abs=0.1)


def test_linear_algebra_at_the_minimum_agrees_with_the_minimum(noisy):
    """Oracle: the fit itself; pieces of information taken beside the minimum lead back to it in one step."""
    models, shared, found = noisy
    u = float(np.sqrt(found.combined().variance({"delay": 1.0})))
    beside = replace(found.found, values=found.found.values | {"delay": found.found.values["delay"] + 0.5 * u})
    there = joint.at_point(models, shared, found=beside)
    whole = joint.Measurand(name="all", weights={"delay": 1.0})
    back = there.estimate([whole, replace(whole, name="falling", forgotten=EDGE_DELAYS[1::2])])
    assert back.value("all") == pytest.approx(found.found.values["delay"], abs=0.05 * u)
    assert back.u("all") == pytest.approx(u, rel=1e-3)
    assert back.value("falling") == pytest.approx(back.value("all"), abs=5 * back.u("falling"))
    assert back.u("falling") > back.u("all")


def test_a_gate_that_is_late_is_one_more_shared_number(noisy):
    """Oracle: by hand; an offset common to all edges, known to 2 us, adds 2 us in quadrature to the delay's uncertainty."""
    models, shared, found = noisy
    late = shared_numbers.SharedNumber(
        name="application gate late",
        effects=[dict.fromkeys(EDGE_DELAYS, 2e-6)] * 2,
        unit="1",
        u=1.0,
        source="late gate",
    )
    with_it = joint.fit(models, [*shared, late])
    before, after = (one.combined().variance({"delay": 1.0}) for one in (found, with_it))
    assert after == pytest.approx(before + 4e-12, rel=1e-3)
    assert with_it.combined().shares({"delay": 1.0})["late gate"] == pytest.approx(4e-12, rel=1e-3)


def test_recordings_that_cannot_be_one_camera_end_in_one_line(recordings, geometry):
    """Oracle: the docstring; sums of noise alone never settle, or settle nowhere near a wheel."""
    made = recordings((3.0,))[0]
    noise = np.random.default_rng(0).normal(9e6, 1e5, 500)
    with pytest.raises(EstimationError):
        pixel_sums.fit(replace(made, pixels=replace(made.pixel_sums, pixel_sum=noise)), geometry.model)
