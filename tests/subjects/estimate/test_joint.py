"""The joint estimate of linear recordings: against least squares written out over all numbers, and against many draws."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from geometry_by_hand import GATES

from irtiming.estimate import joint, profiles, shared_numbers
from irtiming.estimate.joint import Measurand
from irtiming.estimate.shared_residual import Trace
from irtiming.inference.information import NOISE
from irtiming.records.estimate import EDGE_DELAYS, Estimate
from irtiming.records.wheel_geometry import WheelGeometry, WheelModel

TURN = 2 * np.pi
U_EDGE, U_MASK, U_GATE = 2e-4, 5e-4, 3e-4
GEOMETRY = WheelGeometry(
    model=WheelModel(
        cutout_edges_rad=(0.0, 1.57, 3.14, 4.71), gate_angle_rad=1.8, opening_angle_rad=1.3, centre_angle_rad=-1.5
    ),
    gates=replace(GATES, height_m=0.05, control_height_m=0.0445, sensitivity=(1.0, 1.0, 1.0)),
    angle_budget=(("mask", "B", U_MASK), ("register", "A", U_GATE)),
    u_edge_rad=U_EDGE,
    edges_from="rig.toml",
    camera_roll_rad=None,
    findings=(),
)
NAMES = (*EDGE_DELAYS, "time_constant")
SPEEDS_HZ = (3.0, 3.0, 8.0)
TRUE = {"delay": 4e-3, "time_constant": 5e-3}
ERRORS = (*(f"cutout edge {k}" for k in range(4)), "mask", "register")


def _covariance(seed, u_s=1e-6):
    """Of five local numbers that hang together."""
    half = np.random.default_rng(seed).normal(size=(5, 5)) + 2 * np.eye(5)
    return u_s**2 * half @ half.T


COVARIANCES = [_covariance(seed) for seed in (1, 2, 3)]


def _design(hz):
    """Local numbers of a recording over delay, time constant and the six errors, in units of theirs, by hand."""
    omega = TURN * hz
    rows = np.zeros((5, 8))
    rows[:4, 0], rows[4, 1] = 1.0, 1.0
    rows[:4, 2:6] = U_EDGE / omega * np.eye(4)
    rows[:4, 6], rows[:4, 7] = U_MASK / omega, U_GATE / omega
    return rows


DESIGNS = [_design(hz) for hz in SPEEDS_HZ]


def _drawn(random, *, errors=True):
    """Local values of three recordings: the truth, errors that all share, and noise of each."""
    shared = np.concatenate([[TRUE["delay"], TRUE["time_constant"]], random.normal(size=6) * errors])
    return [
        design @ shared + np.linalg.cholesky(covariance) @ random.normal(size=5)
        for design, covariance in zip(DESIGNS, COVARIANCES, strict=True)
    ]


def _fits(values):
    return [
        SimpleNamespace(
            angular_frequency_rad_per_s=TURN * hz,
            estimate=Estimate(names=NAMES, units=("s",) * 5, values=value, covariance=covariance),
        )
        for hz, value, covariance in zip(SPEEDS_HZ, values, COVARIANCES, strict=True)
    ]


def _fitted(values):
    fits = _fits(values)
    shared = [
        shared_numbers.delay(fits, start=1e-3),
        shared_numbers.same("time_constant", fits, start=1e-3),
        *shared_numbers.rig_errors(fits, GEOMETRY, u_edge_rad=U_EDGE),
    ]
    return joint.fit([joint.parabola(fit.estimate) for fit in fits], shared)


def _squares(values, forgotten=()):
    """Values and covariance of delay and time constant by least squares over everything, priors as further data.

    Edges that are forgotten have a free number of their own in each recording.
    """
    places = [EDGE_DELAYS.index(name) for name in forgotten]
    n = 8 + 3 * len(places)
    rows, targets = [], []
    for k, (design, covariance, value) in enumerate(zip(DESIGNS, COVARIANCES, values, strict=True)):
        wide = np.zeros((5, n))
        wide[:, :8] = design
        for m, place in enumerate(places):
            wide[place, 8 + k * len(places) + m] = 1.0
        half = np.linalg.inv(np.linalg.cholesky(covariance))
        rows.append(half @ wide)
        targets.append(half @ value)
    known = np.zeros((6, n))
    known[:, 2:8] = np.eye(6)
    matrix, target = np.concatenate([*rows, known]), np.concatenate([*targets, np.zeros(6)])
    scale = np.linalg.norm(matrix, axis=0)
    covariance = np.linalg.inv((matrix / scale).T @ (matrix / scale)) / np.outer(scale, scale)
    return covariance @ matrix.T @ target, covariance


DELAY, FALLING, RISING, TAU = MEASURANDS = (
    Measurand(name="delay", weights={"delay": 1.0}),
    Measurand(name="falling", weights={"delay": 1.0}, forgotten=(EDGE_DELAYS[1], EDGE_DELAYS[3])),
    Measurand(name="rising", weights={"delay": 1.0}, forgotten=(EDGE_DELAYS[0], EDGE_DELAYS[2])),
    Measurand(name="tau", weights={"time_constant": 1.0}),
)


def test_estimate_and_covariance_are_those_of_least_squares():
    """Oracle: one system of equations over all numbers, written out; forgotten edges have free numbers there."""
    values = _drawn(np.random.default_rng(4))
    found = _fitted(values)
    estimate = found.estimate(MEASURANDS)
    for name, place, forgotten in (("delay", 0, ()), ("falling", 0, FALLING.forgotten), ("rising", 0, RISING.forgotten),
                                   ("tau", 1, ())):  # fmt: skip
        best, covariance = _squares(values, forgotten)
        assert estimate.value(name) == pytest.approx(best[place], abs=1e-11)
        assert estimate.u(name) == pytest.approx(np.sqrt(covariance[place, place]), rel=1e-6)
    best, covariance = _squares(values)
    np.testing.assert_allclose(estimate.covariance[[0, 0], [0, 3]], covariance[0, :2], rtol=1e-6)
    assert found.values[2:] == pytest.approx(best[2:], abs=1e-6)


def test_pulls_of_all_measurands_are_standard():
    """Oracle: 150 draws of noise and of the rig's errors; each, and falling less rising, spreads by 1."""
    random, pulls = np.random.default_rng(5), []
    mixes = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, 1, -1, 0], [1, 0, 0, 1]])
    truth = np.array([TRUE["delay"]] * 3 + [TRUE["time_constant"]])
    for _ in range(150):
        estimate = _fitted(_drawn(random)).estimate(MEASURANDS)
        pulls.append([mix @ (estimate.values - truth) / np.sqrt(mix @ estimate.covariance @ mix) for mix in mixes])
    np.testing.assert_allclose(np.std(pulls, axis=0), 1, atol=0.15)
    assert np.all(np.abs(np.mean(pulls, axis=0)) < 0.3)


def test_shares_of_the_sources_add_up_and_are_those_of_their_errors():
    """Oracle: least squares written out; a source's share is what its errors, or the noise, move the estimate by."""
    values = _drawn(np.random.default_rng(6))
    found = _fitted(values)
    shares = found.combined().shares({"delay": 1.0})
    _, covariance = _squares(values)
    assert sum(shares.values()) == pytest.approx(covariance[0, 0], rel=1e-9)
    for source, places in (("cutout edges", (2, 3, 4, 5)), ("mask", (6,)), ("register", (7,))):
        assert shares[source] == pytest.approx(sum(covariance[0, k] ** 2 for k in places), rel=1e-6)
    assert set(shares) == {NOISE, "cutout edges", "mask", "register"}


@pytest.mark.parametrize("setting", [[0, 0, 0], [0, 1, 2], [0, 1, 0]])
def test_delays_of_the_recordings_have_the_covariance_of_what_they_are_made_of(setting):
    """Oracle: central differences of the delays to each local value and each error's known value, J C J^T."""
    values = _drawn(np.random.default_rng(7))

    def at(locals_, known):
        found = _fitted(locals_)
        shared = [
            replace(one, known=dict(zip(ERRORS, known, strict=True)).get(one.name, one.known)) for one in found.shared
        ]
        return joint.each_delay(joint.fit(found.models, shared), setting)

    here, covariance = at(values, np.zeros(6))
    total = np.zeros((3, 3))
    for k, own in enumerate(COVARIANCES):
        root = np.linalg.cholesky(own)
        for column in root.T:
            moved = [[v + sign * column * (j == k) for j, v in enumerate(values)] for sign in (1, -1)]
            change = (at(moved[0], np.zeros(6))[0] - at(moved[1], np.zeros(6))[0]) / 2
            total += np.outer(change, change)
    for unit in np.eye(6):
        change = (at(values, unit)[0] - at(values, -unit)[0]) / 2
        total += np.outer(change, change)
    np.testing.assert_allclose(covariance, total, rtol=2e-3, atol=1e-3 * np.max(np.diag(total)))
    assert np.all(np.abs(here - TRUE["delay"]) < 5 * np.sqrt(np.diag(covariance)))


def test_pulls_of_relative_delays_are_standard():
    """Oracle: 150 draws; differences of recordings at one speed know no error of the rig, at two speeds they do."""
    random, pulls = np.random.default_rng(8), []
    for _ in range(150):
        values, covariance = joint.each_delay(_fitted(_drawn(random)), [0, 1, 2])
        mixes = np.array([[-1, 1, 0], [-1, 0, 1], [0, -1, 1]])
        pulls.append([mix @ values / np.sqrt(mix @ covariance @ mix) for mix in mixes])
    np.testing.assert_allclose(np.std(pulls, axis=0), 1, atol=0.15)


@pytest.mark.parametrize("n", [2, 3, 5])
def test_birge_ratio_counts_one_degree_of_freedom_less_than_recordings(n):
    """Oracle: by hand; n recordings of four edges to 1 us each, d beside their mean: 2 d / 1 us over n - 1."""
    d = 3e-6 * np.linspace(-1, 1, n)
    fits = [
        SimpleNamespace(
            angular_frequency_rad_per_s=TURN * 3,
            estimate=Estimate(
                names=EDGE_DELAYS, units=("s",) * 4, values=np.full(4, 2e-3 + one), covariance=1e-12 * np.eye(4)
            ),
        )
        for one in d
    ]
    found = joint.fit(
        [joint.parabola(fit.estimate) for fit in fits],
        [shared_numbers.delay(fits, start=2e-3), *shared_numbers.rig_errors(fits, GEOMETRY, u_edge_rad=U_EDGE)],
    )
    expected = np.sqrt(np.sum((2 * d / 1e-6) ** 2) / (n - 1))
    assert joint.disagreement(found) == pytest.approx(expected, rel=1e-6)


def test_one_recording_agrees_with_itself():
    """Oracle: the definition: there is nothing to differ from."""
    fits = _fits(_drawn(np.random.default_rng(9)))[:1]
    shared = [shared_numbers.delay(fits, start=0.0), shared_numbers.same("time_constant", fits, start=0.0)]
    assert joint.disagreement(joint.fit([joint.parabola(fits[0].estimate)], shared)) == 1.0


def test_a_widened_recording_says_so_much_less():
    """Oracle: variances four times as large; deviance and information a quarter."""
    estimate = _fits(_drawn(np.random.default_rng(10)))[0].estimate
    model = joint.parabola(estimate)
    numbers = dict(zip(NAMES, estimate.values + 1e-6, strict=True))
    plain, wide = model.at(numbers), model.inflated(4.0).at(numbers)
    assert plain.deviance == pytest.approx(np.full(5, 1e-6) @ np.linalg.solve(estimate.covariance, np.full(5, 1e-6)))
    assert wide.deviance == pytest.approx(plain.deviance / 4)
    np.testing.assert_allclose(wide.normal, plain.normal / 4)
    np.testing.assert_allclose(np.linalg.inv(plain.normal), estimate.covariance, rtol=1e-6)


def test_residuals_along_the_angle_of_a_widened_recording_are_so_much_smaller():
    """Oracle: by hand; residuals of 2 and -6 over a noise that is twice as large, at the same angles."""
    trace = Trace(angle_rad=np.array([0.1, 3.0]), residual=np.array([2.0, -6.0]), taken=np.zeros((2, 0)))
    model = replace(joint.parabola(_fits(_drawn(np.random.default_rng(10)))[0].estimate), trace=lambda numbers: trace)
    wide = model.inflated(4.0).trace({})
    np.testing.assert_array_equal(wide.residual, [1.0, -3.0])
    np.testing.assert_array_equal(wide.angle_rad, trace.angle_rad)


def test_a_number_with_two_minima_ends_in_the_lower_one():
    """Oracle: by hand; (x^2 - 1)^2 with a slope that lowers the left side, begun on the right."""

    def at(numbers):
        x = numbers["x"]
        return joint.Linearised(residual=np.array([x**2 - 1, 0.1 * (x + 2)]), jacobian=np.array([[2 * x], [0.1]]))

    model = joint.LocalModel(names=("x",), at=at)
    one = replace(shared_numbers.same("x", [None], start=1.1, unit="1"), may_be_mirrored=True)
    found = joint.fit([model], [one])
    assert found.found.values["x"] == pytest.approx(-1, abs=0.02)
    assert found.found.start == {"x": 1.1}
    alone = joint.fit([model], [replace(one, may_be_mirrored=False)])
    assert alone.found.values["x"] == pytest.approx(1, abs=0.02)
    assert found.found.n_steps > alone.found.n_steps


def test_a_search_that_begins_again_elsewhere_ends_in_the_lower_minimum():
    """Oracle: by hand; (x - 1)^2 (x - 4)^2 with a slope that lowers the left side: begun at 4.2, and again at 0.5."""

    def at(numbers):
        x = numbers["x"]
        residual, slope = np.array([(x - 1) * (x - 4), 0.1 * x]), np.array([[2 * x - 5], [0.1]])
        return joint.Linearised(residual=residual, jacobian=slope)

    model = joint.LocalModel(names=("x",), at=at)
    one = shared_numbers.same("x", [None], start=4.2, unit="1")
    assert joint.fit([model], [one]).found.values["x"] == pytest.approx(4, abs=0.02)
    found = joint.fit([model], [replace(one, other_starts=(5.0, 0.5, 7.0))])
    assert found.found.values["x"] == pytest.approx(1, abs=0.02)
    assert found.found.start == {"x": 4.2}


def test_a_profile_is_that_of_the_sum_with_its_offset():
    """Oracle: by hand; deviances of a parabola, 4, 1, 0, 1, 4, at whole standard uncertainties, all of them 5 ms later."""
    found = _fitted(_drawn(np.random.default_rng(9)))
    u = found.estimate([DELAY]).u("delay")
    seen = profiles.profile(replace(DELAY, offset=5e-3), found, u=u)
    value = found.estimate([DELAY]).value("delay") + 5e-3
    assert seen.value == pytest.approx(value, abs=1e-12)
    np.testing.assert_allclose(seen.values, value + u * np.arange(-2, 3), atol=1e-12)
    np.testing.assert_allclose(seen.deviation, [4, 1, 0, 1, 4], atol=1e-3)
    assert (seen.lower, seen.upper) == pytest.approx((value - u, value + u), abs=1e-3 * u)
