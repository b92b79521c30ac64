"""One likelihood over several recordings of a rolling camera, against an independent minimiser and the parabola."""

import numpy as np
import pytest
from iminuit import Minuit

from irtiming.errors import EstimationError
from irtiming.estimate import rolling_timing, row_fit, row_light, row_likelihood
from irtiming.inference.condensed import condensed
from irtiming.physics.camera import camera as bolometer
from irtiming.physics.light.row_sum import timing_names
from irtiming.physics.response.first_order_lag import HARMONICS
from irtiming.records.wheel_geometry import GateAngles, WheelGeometry

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
        gates=GateAngles(application_rad=0.2682, control_rad=0.3, height_m=0.047, sensitivity=(0.5, 0.0, 1.0)),
        angle_budget=(("mask centre angle phi_M", "B", U_ANGLE),),
        u_edge_rad=U_EDGE,
        edges_from="rig.toml",
        camera_roll_rad=None,
        warnings=(),
    )


@pytest.fixture(scope="module")
def three(camera, brute_rows, sector_of):
    """Fits of three recordings with noise, what each says of any six numbers, and the sector of all."""
    sector = sector_of(camera)
    recordings = [brute_rows(camera, set_s=set_s, noise_dn=6.0, seed=k) for k, set_s in enumerate(SET_S)]
    light = row_light.row_light(recordings[0].rows.row_px, sector, n_harmonics=HARMONICS)
    fits = [row_fit.fit(one, camera.model, light=light) for one in recordings]
    return fits, [row_fit.likelihood(one, camera.model, light=light) for one in recordings], [sector] * len(fits)


@pytest.fixture(scope="module")
def given(three, geometry):
    fits, likelihoods, sectors = three
    return row_likelihood.problem(likelihoods, fits, geometry=geometry, sectors=sectors)


@pytest.fixture(scope="module")
def told(three, geometry):
    fits, _, sectors = three
    return rolling_timing.estimate(fits, geometry, sectors=sectors, n_rows=48).estimate


def _deviance(given, shared):
    """The likelihood of the docstring, written out."""
    each = [
        one(dict(zip(SIX_NAMES, own @ shared, strict=True))).deviance / factor
        for one, own, factor in zip(given.likelihoods, given.maps, given.factor, strict=True)
    ]
    return sum(each) + np.sum(shared[-given.n_errors :] ** 2)


def test_an_independent_minimiser_finds_the_same_minimum(given, three):
    """Oracle: iminuit's MIGRAD on the deviance alone, without derivatives; and HESSE for its curvature."""
    start = row_likelihood.begin(given, three[0])
    found = row_likelihood.minimum(given, start)
    u = 1 / np.sqrt(np.diag(found.normal))
    minuit = Minuit(lambda x: _deviance(given, start + u * x) - found.deviance, np.zeros(start.size))
    minuit.errordef = Minuit.LEAST_SQUARES
    minuit.strategy = 1
    minuit.migrad(ncall=20_000)
    covariance = np.linalg.inv(found.normal)
    apart = given.mix @ (start + u * np.array(minuit.values) - found.shared)
    assert np.all(np.abs(apart) < 0.05 * np.sqrt(np.diag(given.mix @ covariance @ given.mix.T)))
    assert minuit.fval == pytest.approx(0, abs=0.02)


def test_the_result_is_the_minimum_to_a_fraction_of_its_uncertainty(given, three, told):
    """Oracle: generalised least squares, which takes each likelihood for a parabola and weighs by the residuals' own scatter."""
    found = row_likelihood.minimum(given, row_likelihood.begin(given, three[0]))
    apart = (given.mix @ found.shared - told.values) / told.standard_uncertainties
    assert np.all(np.abs(apart) < 0.3)


def test_the_minimum_does_not_remember_its_start(given, three):
    """Oracle: the minimum from the usual start; begun 1 ms, 0.3 ms and 2 us beside it."""
    start = row_likelihood.begin(given, three[0])
    usual = row_likelihood.minimum(given, start)
    u = np.sqrt(np.diag(given.mix @ np.linalg.inv(usual.normal) @ given.mix.T))
    for sign in (-1, 1):
        beside = start.copy()
        beside[:3] += sign * np.array([1e-3, 2e-6, 3e-4])
        other = row_likelihood.minimum(given, beside)
        assert np.all(np.abs(given.mix @ (other.shared - usual.shared)) < 0.05 * u)
        assert other.n_steps > 1


def test_profiles_are_the_parabola_of_the_stated_uncertainty(three, geometry, told):
    """Oracle: a deviance of 1 and 4 at one and two standard uncertainties; the frames' noise is white here."""
    fits, likelihoods, sectors = three
    found = row_likelihood.estimate(likelihoods, fits, geometry=geometry, sectors=sectors, told=told)
    assert [one.name for one in found.profiles] == list(told.names)
    for one in found.profiles:
        np.testing.assert_allclose(one.deviation[[0, 1, 2, 3, 4]], [4, 1, 0, 1, 4], atol=1.0)
        np.testing.assert_allclose(one.deviation[[1, 3]], 1, atol=0.25)
        assert one.lower < one.value < one.upper
    assert np.all(found.whiteness >= 0)
    assert np.all(found.whiteness <= 1)
    assert found.n_steps >= 2
    assert np.any(found.start != found.values)


def test_a_likelihood_without_minimum_is_told():
    """Oracle: a slope that never ends; there is no step that would settle."""
    endless = condensed(deviance=6.0, gradient=np.ones(6), normal=np.eye(6))
    given = row_likelihood.Problem(
        likelihoods=(lambda _: endless,), maps=np.eye(6)[None], mix=np.eye(3, 6), factor=np.ones(1), n_errors=0
    )
    with pytest.raises(EstimationError, match="did not settle"):
        row_likelihood.minimum(given, np.zeros(6))
