"""Own noise of recordings and what their residuals share: pulls of delays over draws of noise and of rigs."""

import numpy as np
import pytest
from geometry_by_hand import GATES

from irtiming.estimate import shared_numbers, shared_residual, timing
from irtiming.estimate.joint import LocalModel
from irtiming.estimate.shared_residual import Trace
from irtiming.inference.optimiser import Linearised
from irtiming.physics.light import pixel_sum
from irtiming.physics.wheel import wheel_model
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit, Estimate
from irtiming.records.wheel_geometry import WheelGeometry

TURN = 2 * np.pi
N, NOISE, WINDOW, U_ANGLE, U_EDGE = 600, 1e-4, 250e-6, 5e-4, 2e-4
WHEEL = wheel_model((0.0, 1.5718, 3.1421, 4.7125), 0.27, opening_angle_rad=1.31, centre_angle_rad=-np.pi / 2)
GEOMETRY = WheelGeometry(
    model=WHEEL,
    gates=GATES,
    angle_budget=(("mask centre angle phi_M", "B", U_ANGLE),),
    u_edge_rad=U_EDGE,
    edges_from="rig.toml",
    camera_roll_rad=None,
    findings=(),
)
NAMES = (*EDGE_DELAYS, "opening_angle", "integration_time")


class _Run:
    """A recording of which all is linear: angles, levels (n, j) and derivatives (n, 6) of its sums at the truth."""

    def __init__(self, hz, *, start_rad):
        self.omega = TURN * hz
        self.angle = np.mod(start_rad + TURN * np.arange(N) / N, TURN)
        passing = pixel_sum.Passing(
            wheel=WHEEL, middle_rad=self.angle, edges_early_rad=np.zeros(4), opening_angle_rad=1.31,
            swept_rad=self.omega * WINDOW,
        )  # fmt: skip
        made, by = pixel_sum.shapes(passing), pixel_sum.slopes(passing)
        self.levels, _ = np.linalg.qr(np.stack([np.ones(N), made.fraction, made.skew, made.plate], axis=1))
        units = (*(self.omega * by[f"edge_{k}"] for k in range(4)), by["opening_angle"], self.omega * by["swept"])
        self.slopes = self._free(np.stack(units, axis=1))
        scale = np.linalg.norm(self.slopes, axis=0)
        self.taken, _ = np.linalg.qr(np.hstack([self.levels, self.slopes / scale]))

    def _free(self, values):
        return values - self.levels @ (self.levels.T @ values)

    def told(self, sums, set_delay_s=0.0):
        """Model and single fit of sums that differ from the truth by what is given."""
        data = self._free(sums)

        def at(numbers):
            values = np.array([numbers[name] for name in NAMES])
            return Linearised(residual=(data - self.slopes @ values) / NOISE, jacobian=-self.slopes / NOISE)

        def trace(numbers):
            return Trace(angle_rad=self.angle, residual=at(numbers).residual, taken=self.taken)

        five = self.slopes[:, :5]
        covariance = np.linalg.inv(five.T @ five) * NOISE**2
        values = covariance @ five.T @ data / NOISE**2
        residual = data - five @ values
        fit = EdgeDelayFit(
            name="", trigger_delay_time_set_s=set_delay_s, angular_frequency_rad_per_s=self.omega,
            estimate=Estimate(names=NAMES[:5], units=("s",) * 4 + ("rad",), values=values, covariance=covariance),
            edge_delay_s=values[:4], start_delay_s=1.0, wheel_angle_rad=self.angle, fraction=sums, residual=residual,
            degrees_of_freedom=N - 12, noise=NOISE, step=1.0, variance_inflation=1.0, n_dropped=0, kept=np.ones(N, bool),
        )  # fmt: skip
        return LocalModel(names=NAMES, at=at, trace=trace), fit


def _structure(random, size):
    """What a rig leaves at every angle: waves around the turn, the longer the larger."""
    orders = np.arange(1, 60)
    parts = random.normal(size=(2, orders.size)) * size / np.sqrt(orders)
    return lambda angle: np.cos(np.outer(angle, orders)) @ parts[0] + np.sin(np.outer(angle, orders)) @ parts[1]


def _own_waves(random, size):
    """The same of a single recording: few waves that no other has."""
    orders = np.arange(1, 24)
    parts = random.normal(size=(2, orders.size)) * size
    return lambda angle: np.cos(np.outer(angle, orders)) @ parts[0] + np.sin(np.outer(angle, orders)) @ parts[1]


def _result(told):
    """Timing of recordings that were told."""
    models, fits = [one for one, _ in told], [one for _, one in told]
    numbers = [
        shared_numbers.same("opening_angle", fits, start=0.0, unit="rad"),
        shared_numbers.same("integration_time", fits, start=0.0, u=0.1),
    ]
    return timing.of_pixel_fits(fits, GEOMETRY, models=models, own=numbers, stated_s=None).result


def _pulls(speeds_hz, *, n_draws, seed, structure, own=0.0):
    """Errors over u of the delay, where several speeds tell it, and of the second relative delay."""
    random = np.random.default_rng(seed)
    runs = [_Run(hz, start_rad=0.3 * k) for k, hz in enumerate(speeds_hz)]
    found = []
    for _ in range(n_draws):
        shared = _structure(random, structure)
        early = U_ANGLE * random.normal() + U_EDGE * random.normal(size=4)
        told = []
        for run in runs:
            angles = run.slopes[:, :4] @ (early / run.omega)
            mine = _own_waves(random, own)(run.angle) + NOISE * random.normal(size=N)
            told.append(run.told(angles + shared(run.angle) + mine))
        result = _result(told)
        delay = result.estimate.pick("exposure_midpoint_delay")
        pull = [delay.values[0] / delay.standard_uncertainties[0]]
        pull += [one.value_s / one.standard_uncertainty_s for one in result.relative_delays[1:2]]
        found.append(pull)
    return np.array(found)


@pytest.mark.parametrize(
    ("speeds_hz", "structure", "own"),
    [((3.0,), 1e-4, 0.0), ((3.0, 3.0), 1e-4, 0.0), ((3.0, 9.0), 1e-4, 0.0), ((3.0, 5.0, 8.0, 12.0), 1e-4, 1e-5)],
)
def test_pulls_are_standard_whatever_the_recordings_share(speeds_hz, structure, own):
    """Oracle: the truth, 0, over draws of noise, angles, and a rig whose structure is as large as the noise of a frame."""
    pulls = _pulls(speeds_hz, n_draws=60, seed=3, structure=structure, own=own)
    for column in pulls.T:
        assert 0.75 < np.sqrt(np.mean(column**2)) < 1.25
        assert 0.5 < np.mean(np.abs(column) < 1) < 0.85
        assert np.mean(np.abs(column) < 2) > 0.87


def _traces(residuals):
    run = _Run(3.0, start_rad=0.0)
    return [
        Trace(angle_rad=run.angle, residual=one - run.taken @ (run.taken.T @ one), taken=run.taken) for one in residuals
    ]


def test_what_recordings_share_is_no_noise_of_theirs():
    """Oracle: the draws; own noise of variance 1 and a structure that adds 9 to each frame, in waves that both have."""
    random = np.random.default_rng(5)
    orders, angle = np.arange(1, 21), _Run(3.0, start_rad=0.0).angle
    structure = sum(np.cos(m * angle + random.uniform(0, TURN)) for m in orders) * 3 * np.sqrt(2 / orders.size)
    white = random.normal(size=(4, N))
    parts = shared_residual.split(_traces(white + structure))
    assert parts.own == pytest.approx(1, abs=0.45)
    assert parts.degrees_of_freedom > 60
    power = N * 9 / (2 * orders.size)  # of all frames, in each of forty waves
    assert parts.shared == pytest.approx(power, rel=0.4)
    assert shared_residual.split(_traces(white)).shared == pytest.approx(0, abs=0.5)


def test_waves_of_a_recordings_own_are_its_noise():
    """Oracle: the draws; each recording has waves of its own, of ten times the variance of its white noise."""
    random, angle = np.random.default_rng(6), _Run(3.0, start_rad=0.0).angle
    waves = np.outer(np.arange(1, 21), angle)
    residuals = []
    for _ in range(4):
        parts = random.normal(size=(2, 20)) * np.sqrt(2 * 9 / N)
        residuals.append(random.normal(size=N) + parts[0] @ np.cos(waves) + parts[1] @ np.sin(waves))
    assert shared_residual.split(_traces(residuals)).own == pytest.approx(10, rel=0.35)


def test_one_recording_given_twice_is_one_recording():
    """Oracle: the same numbers once; a copy of a file adds nothing and must not crash."""
    told = _Run(3.0, start_rad=0.0).told(NOISE * np.random.default_rng(1).normal(size=N))
    once, twice = (_result([told] * n).estimate for n in (1, 2))
    np.testing.assert_allclose(twice.values, once.values, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(twice.standard_uncertainties, once.standard_uncertainties, rtol=0.01)


def test_copies_of_a_recording_weigh_as_much_as_it_alone():
    """Oracle: the draws, of variance 1; each of two copies counts half beside one that was given once."""
    copied, other = _traces(np.random.default_rng(9).normal(size=(2, N)))
    assert shared_residual.split([copied, copied, other]).own == pytest.approx([2, 2, 1], rel=0.35)


def test_structure_that_all_recordings_share_cancels_in_relative_delays():
    """Oracle: recordings without it; the structure is ten times the noise of a frame."""
    random = np.random.default_rng(2)
    run, shared = _Run(3.0, start_rad=0.0), _structure(random, 3e-4)
    noise = NOISE * random.normal(size=(4, N))
    plain, structured = (
        _result([run.told(one + k * shared(run.angle), 0.025 * j) for j, one in enumerate(noise)]) for k in (0, 1)
    )
    for one, other in zip(plain.relative_delays[1:], structured.relative_delays[1:], strict=True):
        assert other.value_s == pytest.approx(one.value_s, abs=0.05 * one.standard_uncertainty_s)
        assert other.standard_uncertainty_s == pytest.approx(one.standard_uncertainty_s, rel=0.1)
    assert structured.estimate.u("exposure_midpoint_delay") > plain.estimate.u("exposure_midpoint_delay")


def test_a_single_recording_is_all_its_own():
    """Oracle: nothing to compare it with."""
    assert shared_residual.split(_traces(np.random.default_rng(0).normal(size=(1, N)))) is None


def test_noise_that_few_recordings_have_apart_is_not_shared():
    """Oracle: the draws; the mean of two recordings' noise has half its variance, which is all taken off on average."""
    random = np.random.default_rng(8)
    found = [shared_residual.split(_traces(random.normal(size=(2, N)))).shared for _ in range(20)]
    assert np.mean(found) < 0.1
