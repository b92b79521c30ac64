"""One likelihood over several recordings of a rolling camera, against an independent minimiser and the parabola."""

from dataclasses import replace

import numpy as np
import pytest
from geometry_by_hand import GATES
from iminuit import Minuit

from irtiming.estimate import doubts, joint, profiles, row_fit, row_light, timing
from irtiming.estimate.joint import Measurand
from irtiming.estimate.shared_numbers import DELAY
from irtiming.estimate.timing import Timing
from irtiming.physics.camera import camera as bolometer
from irtiming.physics.light.row_sum import timing_names
from irtiming.physics.response.first_order_lag import HARMONICS
from irtiming.records.wheel_geometry import WheelGeometry

TURN = 2 * np.pi
U_ANGLE, U_EDGE = 5e-4, 2e-4
SIX_NAMES = timing_names(bolometer("microbolometer", "rolling"))
SET_S = (0.0, 0.02, 0.05)


@pytest.fixture(scope="module")
def camera(brute_bolometer):
    """Edges of the cutouts differ from those of the ring by up to 0.4 mrad."""
    return brute_bolometer(edge_delay_s=(2.31e-3, 2.29e-3, 2.3e-3, 2.32e-3))


@pytest.fixture(scope="module")
def geometry(camera):
    return WheelGeometry(
        model=camera.model,
        gates=replace(GATES, application_rad=0.2682),
        angle_budget=(("mask centre angle phi_M", "B", U_ANGLE),),
        u_edge_rad=U_EDGE,
        edges_from="rig.toml",
        camera_roll_rad=None,
        findings=(),
    )


@pytest.fixture(scope="module")
def three(camera, brute_rows, sector_of):
    """Three recordings with noise, their fits, what each says of any six numbers, and the sector of all."""
    sector = sector_of(camera)
    recordings = [brute_rows(camera, set_s=set_s, noise_dn=6.0, seed=k) for k, set_s in enumerate(SET_S)]
    light = row_light.row_light(recordings[0].rows.row_px, sector, n_harmonics=HARMONICS)
    fits = [row_fit.fit(one, camera.model, light=light) for one in recordings]
    likelihoods = [row_fit.likelihood(one, camera.model, light=light) for one in recordings]
    return recordings, fits, likelihoods, [sector] * len(fits)


MEASURANDS = tuple(Measurand(name=name, weights={name: 1.0}) for name in (DELAY, "time_constant", "row_delay"))


@pytest.fixture(scope="module")
def timed(three, geometry):
    """Timing from parabolas, with the exact likelihoods beside."""
    recordings, fits, likelihoods, sectors = three
    exact = tuple(timing._exact(fit, one, names=SIX_NAMES) for fit, one in zip(fits, likelihoods, strict=True))
    found = timing.of_row_fits(fits, geometry, sectors=sectors, n_rows=48)
    return Timing(
        recordings=tuple(recordings),
        geometry=geometry,
        sectors=tuple(sectors),
        views=tuple(sectors),
        fits=tuple(fits),
        exact=exact,
        found=found,
    )


@pytest.fixture(scope="module")
def minimum(timed):
    """That of the exact likelihoods, in the numbers of the parabolas."""
    return joint.fit(timed.exact, timed.found.joint.shared)


def _values(found):
    return found.estimate(MEASURANDS)


def test_an_independent_minimiser_finds_the_same_minimum(timed, minimum, three):
    """Oracle: iminuit's MIGRAD on the deviance written out, without derivatives: six numbers by hand from the shared ones."""
    _, fits, likelihoods, _ = three
    shared, names, start = minimum.shared, minimum.names, minimum.values
    covariance = minimum.combined().covariance
    scale = np.sqrt(np.diag(covariance))
    root = scale[:, None] * np.linalg.cholesky(covariance / np.outer(scale, scale))

    def deviance(x):
        values = dict(zip(names, start + root @ x, strict=True))
        total = sum(values[one.name] ** 2 for one in shared if one.u is not None)
        for k, one in enumerate(likelihoods):
            local = {name: sum(values[s.name] * s.effects[k].get(name, 0.0) for s in shared) for name in SIX_NAMES}
            total += one(local).deviance
        return total

    best = minimum.found.at.deviance
    assert deviance(np.zeros(start.size)) == pytest.approx(best, rel=1e-9)
    minuit = Minuit(lambda x: deviance(x) - best, np.zeros(start.size))
    minuit.errordef = Minuit.LEAST_SQUARES
    minuit.strategy = 0
    minuit.migrad(ncall=20_000)
    assert minuit.fval == pytest.approx(0, abs=0.02)
    assert np.all(np.abs(np.array(minuit.values)[: len(MEASURANDS)]) < 0.1)
    assert len(fits) == len(timed.exact)


def test_the_result_is_the_minimum_to_a_fraction_of_its_uncertainty(timed, minimum):
    """Oracle: the exact likelihoods; the result takes each for a parabola and weighs by the residuals' own scatter."""
    told = timed.found.result.estimate
    assert told.names == ("trigger_delay", "time_constant", "row_delay", "recursive_filter")
    told = told.pick(*told.names[:3])
    apart = (_values(minimum).values - told.values) / told.standard_uncertainties
    assert np.all(np.abs(apart) < 0.3)


def test_the_minimum_does_not_remember_its_start(timed, minimum):
    """Oracle: the minimum from the usual start; begun 1 ms, 0.3 ms and 2 us beside it."""
    usual = _values(minimum)
    beside = {DELAY: 1e-3, "time_constant": 3e-4, "row_delay": 2e-6}
    for sign in (-1, 1):
        shared = [replace(one, start=one.start + sign * beside.get(one.name, 0.0)) for one in minimum.shared]
        other = joint.fit(timed.exact, shared)
        assert np.all(np.abs(_values(other).values - usual.values) < 0.05 * usual.standard_uncertainties)
        assert other.found.n_steps > 1


def test_profiles_are_the_parabola_of_the_stated_uncertainty(timed):
    """Oracle: a deviance of 1 and 4 at one and two standard uncertainties; the frames' noise is white here."""
    found = profiles.profiles(timed)
    assert [one.name for one in found] == list(timed.found.result.estimate.names[:3])
    for one in found:
        np.testing.assert_allclose(one.deviation, [4, 1, 0, 1, 4], atol=1.0)
        np.testing.assert_allclose(one.deviation[[1, 3]], 1, atol=0.25)
        assert one.lower < one.value < one.upper
    record = timed.found.joint_fit
    assert np.all((record.whiteness >= 0) & (record.whiteness <= 1))
    assert record.n_steps >= 2
    assert any(record.start[name] != record.parameters.value(name) for name in record.start)


def test_a_minimum_that_was_not_reached_is_told(timed):
    """Oracle: the limit of one standard uncertainty; the search itself ends far closer than that."""
    record = replace(timed.found.joint_fit, whiteness=np.ones(1))
    assert record.decrement < 0.01
    assert [one.code for one in doubts.of_joint(replace(record, decrement=1.1))] == ["minimum-not-reached"]
    assert doubts.of_joint(replace(record, decrement=0.9)) == ()


def test_the_reduced_chi_square_counts_what_is_free(timed, three):
    """Oracle: by hand; 50 residuals more than there are numbers that nothing is known of leave the deviance over 50."""
    found, fits = timed.found.joint, three[1]
    n_free = sum(one.u is None for one in found.shared)
    told = timing._record(found, fits, whiteness=[0.5], n_residuals=50 + n_free, u_edge_rad=U_EDGE)
    assert n_free > 0
    assert told.reduced_chi_square == pytest.approx(found.found.at.deviance / 50)
