"""The joint fit with each recording's own noise, and with what residuals share: against generalised least squares written out."""

from dataclasses import dataclass

import numpy as np
import pytest

from irtiming.estimate import joint, own_noise, shared_numbers
from irtiming.estimate.joint import Measurand
from irtiming.estimate.scatter import Alike
from irtiming.estimate.shared_residual import SharedResidual
from irtiming.records.estimate import EDGE_DELAYS, Estimate

TURN, SPEEDS_HZ, DELAY_S = 2 * np.pi, (3.0, 3.0, 8.0, 3.0, 3.0), 4e-3
OMEGA = TURN * np.array(SPEEDS_HZ)


@dataclass(frozen=True, kw_only=True)
class _Fit:
    estimate: Estimate
    angular_frequency_rad_per_s: float

    @property
    def covariance_s2(self):
        return self.estimate.covariance


def _fits(spread=1.0):
    """Five recordings' delays of the four edges, drawn with their noise, or with so many times more."""
    random, found = np.random.default_rng(5), []
    for omega in OMEGA:
        half = 1e-6 * (random.normal(size=(4, 4)) + 2 * np.eye(4))
        values = DELAY_S + spread * half @ random.normal(size=4)
        estimate = Estimate(names=EDGE_DELAYS, units=("s",) * 4, values=values, covariance=half @ half.T)
        found.append(_Fit(estimate=estimate, angular_frequency_rad_per_s=omega))
    return found


def _weighed(fits, parts, groups=()):
    plain = joint.fit([joint.parabola(fit.estimate) for fit in fits], [shared_numbers.delay(fits, start=DELAY_S)])
    return plain, own_noise.weighed(plain, fits, groups=groups, parts=parts)


def _parts(own, shared):
    return SharedResidual(own=np.array(own), shared=np.array(shared), degrees_of_freedom=100.0)


def _squares(fits, factor, shared):
    """Delay and its variance where each recording's noise counts ``factor`` times, and errors of the edges' angles are common."""
    covariances = np.array([fit.covariance_s2 for fit in fits])
    common = np.mean([c * part * w**2 for c, part, w in zip(covariances, shared, OMEGA, strict=True)], axis=0)
    whole = np.zeros((20, 20))
    for k in range(5):
        for m in range(5):
            own = factor[k] * covariances[k] if k == m else 0.0
            whole[4 * k : 4 * k + 4, 4 * m : 4 * m + 4] = own + common / (OMEGA[k] * OMEGA[m])
    weight = np.linalg.solve(whole, np.ones(20))
    values = np.concatenate([fit.estimate.values for fit in fits])
    return weight @ values / weight.sum(), 1 / weight.sum()


def _estimate(found):
    estimate = found.estimate([Measurand(name="delay", weights={"delay": 1.0})])
    return estimate.values[0], estimate.covariance[0, 0]


def test_what_recordings_have_anyway_changes_nothing():
    """Oracle: by hand; own variances of 1 and nothing that is shared are the noise of the single fits."""
    plain, found = _weighed(_fits(), _parts([1.0] * 5, [0.0] * 5))
    assert found is plain


def test_each_recording_counts_with_its_own_variance():
    """Oracle: generalised least squares with covariances as many times larger."""
    own, fits = [1.0, 4.0, 2.0, 1.0, 0.5], _fits()
    _, found = _weighed(fits, _parts(own, [0.0] * 5))
    assert _estimate(found) == pytest.approx(_squares(fits, own, [0.0] * 5), rel=1e-9)


def test_what_residuals_share_is_an_error_of_the_edges_angles():
    """Oracle: generalised least squares with an error of all recordings that is larger in time where the wheel is slower."""
    own, shared, fits = [1.0, 1.5, 1.0, 2.0, 1.0], [0.5, 0.0, 3.0, 1.0, 0.2], _fits()
    _, found = _weighed(fits, _parts(own, shared))
    assert _estimate(found) == pytest.approx(_squares(fits, own, shared), rel=1e-7)
    _, found = _weighed(fits, _parts([1.0] * 5, shared))
    assert _estimate(found) == pytest.approx(_squares(fits, [1.0] * 5, shared), rel=1e-7)


def test_recordings_that_scatter_more_than_their_own_noise_count_with_what_they_scatter():
    """Oracle: how far means over the edges are from their weighted mean, squared over their own variances, over 3."""
    own, fits, members = np.array([1.0, 2.0, 1.0, 1.0, 0.8]), _fits(spread=4.0), [0, 1, 3, 4]
    _, found = _weighed(fits, _parts(own, [0.0] * 5), groups=[Alike(speed_hz=3.0, members=members)])
    values = np.array([fits[k].estimate.values.mean() for k in members])
    weights = np.array([1 / (own[k] * fits[k].covariance_s2.mean()) for k in members])
    birge_squared = weights @ (values - weights @ values / weights.sum()) ** 2 / 3
    assert birge_squared > 4
    factor = own.copy()
    factor[members] *= birge_squared
    assert _estimate(found) == pytest.approx(_squares(fits, factor, [0.0] * 5), rel=1e-9)
