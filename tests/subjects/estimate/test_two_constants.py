"""Constants of substrate and scene against exact steady states, and what is said when they cannot be told apart."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from irtiming.estimate import two_constants
from irtiming.physics.radiance import in_band_radiance, radiance_slope
from irtiming.records.result import EffectiveTimeConstants

SUBSTRATE_K, WHEEL_K = 303.15, 296.15


def _texts(found):
    return tuple(one.sentence() for one in found.findings)


def _steady(share, scene_k):
    """Root of the balance of heat."""

    def balance(pixel_k):
        radiative = float(in_band_radiance(scene_k) - in_band_radiance(pixel_k)) / float(radiance_slope(300.0))
        return (1 - share) * (SUBSTRATE_K - pixel_k) + share * radiative

    return brentq(balance, 200.0, 400.0)


def _seen(share, kelvins, *, both_s=4.8e-3, u_s=3e-6, common_s=0.0, noise=0):
    """Effective constants in the middle between both steady states, as recordings would give them."""
    middle = np.array([(_steady(share, kelvin) + _steady(share, WHEEL_K)) / 2 for kelvin in kelvins])
    slope = radiance_slope(middle) / radiance_slope(300.0)
    tau = both_s / (1 - share + share * slope)
    rng = np.random.default_rng(noise)
    return EffectiveTimeConstants(
        blackbody_temperature_k=np.array(kelvins),
        time_constant_s=tau + (u_s * rng.normal(size=tau.size) + common_s * rng.normal() if noise else 0.0),
        covariance_s2=u_s**2 * np.eye(tau.size) + common_s**2,
        contrast_dn=1e3 * (in_band_radiance(kelvins) - in_band_radiance(WHEEL_K)),
    )


@pytest.mark.parametrize("share", [0.2, 0.4])
def test_constants_come_back(share):
    """Oracle: the shares that made the effective constants; bending, which these have not, is below a tenth of u here."""
    found = two_constants.estimate(_seen(share, [288.15, 303.15, 313.15]), substrate_temperature_k=SUBSTRATE_K)
    assert found.estimate.names == two_constants.NAMES
    truth = np.array([4.8e-3 / (1 - share), 4.8e-3 / share])
    assert np.all(np.abs(found.estimate.values - truth) < 0.2 * found.estimate.standard_uncertainties)
    assert found.model_time_constant_s == pytest.approx(found.effective.time_constant_s, abs=0.3e-6)
    assert (found.bounds, _texts(found)) == ((), ())
    assert found.surroundings.wheel_temperature_from == "contrast"
    assert found.surroundings.wheel_temperature_k == pytest.approx(WHEEL_K, abs=0.01)


def test_noise_stays_within_the_stated_uncertainty():
    """Oracle: the truth, with noise of 3 us each and 20 us common to all; the latter leaves the share alone."""
    found = two_constants.estimate(
        _seen(0.4, [283.15, 303.15, 323.15], common_s=20e-6, noise=4),
        substrate_temperature_k=SUBSTRATE_K,
        wheel_temperature_k=WHEEL_K,
    )
    u = found.estimate.standard_uncertainties
    assert np.all(np.abs(found.estimate.values - [8e-3, 12e-3]) < 3 * u)
    alone = two_constants.estimate(
        _seen(0.4, [283.15, 303.15, 323.15], noise=4), substrate_temperature_k=SUBSTRATE_K, wheel_temperature_k=WHEEL_K
    )
    assert np.all(u < 1.5 * alone.estimate.standard_uncertainties)
    assert found.surroundings.wheel_temperature_from == "you"


def test_covariance_is_that_of_the_time_constants_carried_through_the_estimate():
    """Oracle: central differences of the estimate to each effective constant, J C J^T, off the diagonal too."""
    seen = _seen(0.4, [263.15, 303.15, 343.15], u_s=1e-6, common_s=20e-6)

    def at(values_s):
        moved = replace(seen, time_constant_s=values_s)
        return two_constants.estimate(moved, substrate_temperature_k=SUBSTRATE_K, wheel_temperature_k=WHEEL_K).estimate

    here, step_s = seen.time_constant_s, 2e-6
    jacobian = np.stack(
        [(at(here + step).values - at(here - step).values) / (2 * step_s) for step in step_s * np.eye(3)], axis=1
    )
    expected = jacobian @ seen.covariance_s2 @ jacobian.T
    np.testing.assert_allclose(at(here).covariance, expected, rtol=0.01)


@pytest.mark.parametrize(
    ("share", "kelvins", "says"),
    [
        (0.3, [303.15], "all recordings show a blackbody of 303.1"),
        (0.3, [300.15, 303.15], "blackbodies from 300.1"),
        (0.05, [288.15, 303.15, 318.15], "one from 0.1"),
    ],
)
def test_what_cannot_be_told_apart_gets_bounds(share, kelvins, says):
    """Oracle: the truth lies within the bounds, and the text says why there is no number."""
    found = two_constants.estimate(
        _seen(share, kelvins), substrate_temperature_k=SUBSTRATE_K, wheel_temperature_k=WHEEL_K
    )
    assert found.estimate.names == ()
    for bound, truth in zip(found.bounds, (4.8e-3 / (1 - share), 4.8e-3 / share), strict=True):
        assert bound.lower <= truth * 1.002
        assert bound.upper is None or truth <= bound.upper
    assert found.bounds[1].upper is None
    assert says in _texts(found)[0]
    assert len(kelvins) == 1 or "with u = 3 µs of each time constant" in _texts(found)[0]


def test_a_warmer_substrate_changes_the_constants_as_told():
    """Oracle: the estimate itself with the substrate a kelvin warmer."""
    seen = _seen(0.4, [288.15, 303.15, 318.15])
    here, there = (
        two_constants.estimate(seen, substrate_temperature_k=kelvin, wheel_temperature_k=WHEEL_K)
        for kelvin in (SUBSTRATE_K, SUBSTRATE_K + 1)
    )
    assert there.estimate.values - here.estimate.values == pytest.approx(here.change_per_k_s[:, 0], abs=1e-9)


def test_constants_that_do_not_follow_the_model_are_doubted():
    """Oracle: time constants that rise with temperature, which nothing explains; contrasts that never vanish."""
    wrong = EffectiveTimeConstants(
        blackbody_temperature_k=np.array([288.0, 303.0, 318.0]),
        time_constant_s=np.array([4.7e-3, 4.8e-3, 4.9e-3]),
        covariance_s2=9e-12 * np.eye(3),
        contrast_dn=np.array([-1.0, -2.0, -3.0]),
    )
    found = two_constants.estimate(wrong, substrate_temperature_k=SUBSTRATE_K)
    assert any("do not follow the two-constant model" in text for text in _texts(found))
    assert any("with 1 degree of freedom)" in text for text in _texts(found))
    assert any("--wheel-temperature" in text for text in _texts(found))
    assert found.surroundings.wheel_temperature_from == "assumption"


@pytest.mark.parametrize(("last", "is_bounded"), [(-2, True), (-1, False)])
def test_a_share_next_to_the_largest_still_bounds_the_substrates_constant(last, is_bounded):
    """Oracle: by hand; the constants at the ends of the shares that cost little, no bound where the last of all does."""
    shares = two_constants._SHARES
    problem = SimpleNamespace(
        effective=SimpleNamespace(time_constant_s=np.zeros(2)), constants=lambda share: np.array([1 + share, 9 - share])
    )
    deviation = np.full(shares.size, 1e9)
    deviation[[3, last]] = 0.0
    substrate, scene = two_constants._bounds(problem, deviation)
    assert (substrate.lower, scene.upper) == (1 + shares[3], 9 - shares[3])
    assert substrate.upper == (1 + shares[last] if is_bounded else None)
    assert scene.lower == 9 - shares[last]
