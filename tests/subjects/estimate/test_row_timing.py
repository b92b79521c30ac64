"""The fit of all rows on compressed sums against the same on whole frames."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import norm

from irtiming.errors import EstimationError
from irtiming.estimate import row_timing
from irtiming.estimate.harmonic_data import basis, compress, packed
from irtiming.estimate.row_timing import solve
from irtiming.physics import blurred_sector, sector_points
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import BESIDE, BLADE, EDGE_DELAYS, RowSum, harmonics, linearised, timing_names
from irtiming.physics.wheel import exposed_fraction, wheel_model
from irtiming.physics.wheel_harmonics import at_angles, open_harmonics
from irtiming.records.row_timing import SectorShape

TURN = 2 * np.pi
OMEGA = 3 * TURN
EDGES = (0.0, 1.5718, 3.1421, 4.7125)
WHEEL = wheel_model(EDGES, 0.2682, opening_angle_rad=float(np.radians(75)), centre_angle_rad=float(np.radians(-90)))
BOLOMETER = camera("microbolometer", "rolling")
NAMES = tuple(name for name in timing_names(BOLOMETER) if name != BESIDE)
TRUTH = np.array([2.31e-3, 2.29e-3, 2.33e-3, 2.3e-3, 6e-3, 0.03, 0.01, 60e-6])
M = 40


def _model(n_harmonics=M, **change):
    shape = SectorShape(
        axle_row_px=35.2,
        axle_column_px=31.3,
        offset_row_px=0.0,
        offset_column_px=0.0,
        inner_radius_px=8.0,
        outer_radius_px=29.0,
        bisector_rad=float(np.radians(-91)),
        opening_angle_rad=float(np.radians(75)),
        blur_px=0.8,
    )
    rows = np.arange(8, 28, 2)
    light = blurred_sector.row_harmonics(
        sector_points.light_points(shape), rows, blur_px=shape.blur_px, n_harmonics=n_harmonics
    )
    values = {
        "camera": BOLOMETER,
        "open_harmonics": open_harmonics(WHEEL, n_harmonics),
        "row_harmonics": light,
        "row_px": rows,
        "angular_frequency_rad_per_s": OMEGA,
        "step_rad": 0.622,
    }
    return RowSum(**(values | change))


MODEL = _model()


def _named(values):
    return dict(zip(NAMES, map(float, values), strict=True))


def _values(found):
    return np.array([found.timing[name] for name in NAMES])


def _shown(model, values):
    return harmonics(model, _named(values))


def _frames(truth=TRUTH, *, model=MODEL, n=400, contrast=-600.0, noise=30.0, seed=1, offset=9e4, start=0.4):
    """Wheel angles and row sums (n, row) of the model with gain and offset."""
    theta = start + OMEGA * 0.033 * np.arange(n)
    sums = offset + contrast * at_angles(_shown(model, truth), theta).T
    return theta, sums + np.random.default_rng(seed).normal(0, noise, sums.shape)


@pytest.fixture(scope="module")
def two_parts():
    """Frames before and after a shutter event, gain and offset their own, and the same compressed."""
    parts = [_frames(n=250), _frames(n=170, seed=2, offset=4e4, start=40.0, contrast=-590.0)]
    return parts, [compress(theta, sums, n_harmonics=M) for theta, sums in parts]


def _left(values, parts, model=MODEL):
    """Residuals of the frames, gain and offset of each row in each part by numpy's own least squares."""
    left = []
    for theta, sums in parts:
        shapes = at_angles(_shown(model, values), theta).T
        centred, seen = shapes - shapes.mean(axis=0), sums - sums.mean(axis=0)
        gain = np.sum(centred * seen, axis=0) / np.sum(centred**2, axis=0)
        left.append(seen - gain * centred)
    return np.concatenate(left)


def test_deviance_variance_and_gain_are_those_of_the_frames(two_parts):
    """Oracle: residuals of all frames; n log of their squares over those of the best periodic curve, by numpy, row by row."""
    parts, data = two_parts
    at = row_timing._project(data, MODEL, _named(TRUTH))
    left = _left(TRUTH, parts)
    variance = np.sum(left**2, axis=0) / (420 - 4)
    np.testing.assert_allclose(at.variance, variance, rtol=1e-7)
    free = []
    for theta, sums in parts:
        waves = basis(theta, n_harmonics=M).T
        free.append(sums - waves @ np.linalg.lstsq(waves, sums, rcond=None)[0])
    least = np.sum(np.concatenate(free) ** 2, axis=0)
    assert at.deviance == pytest.approx(416 * np.sum(np.log(np.sum(left**2, axis=0) / least)), abs=1e-4)
    assert row_timing.likelihood(data, MODEL, timing=_named(TRUTH)).deviance == pytest.approx(at.deviance, abs=1e-6)
    assert at.gain.shape == (2, 10)
    np.testing.assert_allclose(at.gain.mean(axis=1), [-600, -590], rtol=2e-3)


def test_gradient_is_the_slope_of_the_deviance(two_parts):
    """Oracle: central differences of n sum log(residual squares) over all frames, minus a half of them; n is their freedom."""
    parts, data = two_parts
    at_point = TRUTH + np.array([1e-5, -2e-5, 0, 3e-5, 4e-5, 1e-3, 1e-3, 1e-7])
    found = row_timing.likelihood(data, MODEL, timing=_named(at_point)).gradient
    for k, step in enumerate([1e-6] * 5 + [1e-5, 1e-5, 1e-8]):
        ahead, behind = at_point.copy(), at_point.copy()
        ahead[k], behind[k] = at_point[k] + step, at_point[k] - step
        numeric = (
            -0.5
            * 416
            * sum(
                sign * np.sum(np.log(np.sum(_left(point, parts) ** 2, axis=0)))
                for sign, point in ((1, ahead), (-1, behind))
            )
            / (2 * step)
        )
        assert found[k] == pytest.approx(numeric, rel=1e-4, abs=1e-3 * abs(found).max() * step), k


def test_normal_matrix_is_that_of_the_frames(two_parts):
    """Oracle: J^T W J with the slopes of every frame, gain and offset of each row projected out by numpy."""
    parts, data = two_parts
    at = row_timing._project(data, MODEL, _named(TRUTH))
    np.testing.assert_allclose(row_timing.likelihood(data, MODEL, timing=_named(TRUTH)).normal, at.normal, rtol=1e-9)
    whole, slope = linearised(MODEL, _named(TRUTH))
    expected = np.zeros((8, 8))
    for part, (theta, _) in enumerate(parts):
        for row in range(10):
            nuisance = np.stack([np.ones_like(theta), at_angles(whole[row], theta)], axis=1)
            jacobian = at.gain[part, row] * at_angles(slope[:, row], theta).T
            jacobian = jacobian - nuisance @ np.linalg.lstsq(nuisance, jacobian, rcond=None)[0]
            expected += jacobian.T @ jacobian / at.variance[row]
    np.testing.assert_allclose(at.normal, expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max())


def test_solution_is_that_of_least_squares_on_the_frames(two_parts):
    """Oracle: scipy's least_squares on all frames by central differences, rows weighted alike until they agree."""
    parts, data = two_parts
    found = solve(data, MODEL)
    scale, weight = np.array([1e-3] * 5 + [0.01, 0.01, 1e-5]), np.ones(10)
    brute = TRUTH.copy()
    for _ in range(3):
        brute = least_squares(
            lambda x, w=weight: (_left(x * scale, parts) * w).ravel(), brute / scale, jac="3-point", xtol=1e-12, ftol=1e-12
        ).x * scale  # fmt: skip
        weight = 1 / np.sqrt(np.mean(_left(brute, parts) ** 2, axis=0))
    u = np.sqrt(np.diag(np.linalg.inv(found.normal)))
    np.testing.assert_array_less(np.abs(_values(found) - brute) / u, 5e-3)
    np.testing.assert_array_less(np.abs(_values(found) - TRUTH) / u, 4)


@pytest.mark.parametrize(
    ("delay", "tau", "t_row"),
    [(2e-3, 6e-3, 60e-6), (25e-3, 4e-3, 38e-6), (-9e-3, 12e-3, -90e-6), (0.0, 1e-3, 0.0), (38e-3, 16e-3, 200e-6)],
)
@pytest.mark.parametrize("contrast", [-600.0, 600.0])
@pytest.mark.parametrize("noise", [3.0, 100.0])
@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_search_finds_its_own_start(delay, tau, t_row, contrast, noise, share):
    """Oracle: the numbers that made the frames, before a cold and a warm blackbody."""
    truth = np.array([delay] * 4 + [tau, share, 0.01, t_row])
    model = _model(row_timing._COARSE)
    theta, sums = _frames(truth, model=model, contrast=contrast, noise=noise, n=600)
    found = solve([compress(theta, sums, n_harmonics=row_timing._COARSE)], model)
    u = np.sqrt(np.diag(np.linalg.inv(found.normal)))
    np.testing.assert_array_less(np.abs(_values(found) - truth) / u, 4.5)
    assert np.sign(found.gain).mean() == np.sign(contrast)
    assert found.n_steps < 40 * len(BOLOMETER.memory.LOOKED_AT)


@pytest.mark.parametrize("noise", [1e-3, 0.0])
def test_almost_no_noise_is_no_trouble(noise):
    """Oracle: the numbers that made the frames; what rounding leaves of the residuals is no reason to go on for ever."""
    theta, sums = _frames(noise=noise)
    found = solve([compress(theta, sums, n_harmonics=M)], MODEL)
    np.testing.assert_allclose(_values(found), TRUTH, rtol=1e-5)


@pytest.mark.parametrize(("half_turns", "alike"), [(1.0033, True), (3.996, True), (0.6, False)])
def test_frames_that_show_the_same_are_named_as_the_cause(half_turns, alike):
    """Oracle: by hand; two cutouts look the same after half a turn, or after any number of them."""
    said = row_timing._no_share(-1.2345, step_rad=half_turns * TURN / 2)
    assert said.startswith(
        "the row sums fit only if each frame holds -1.23 of the frame before, a share that must be between"
    )
    assert (f"turns by {half_turns:.4f} half turns from frame to frame" in said) == alike
    assert said.endswith("(irtiming plan)" if alike else "and that the camera's noise filter is off; then record again")


def test_a_given_start_is_used():
    """Oracle: the solution by searching; from nearby it takes fewer steps."""
    theta, sums = _frames()
    data = [compress(theta, sums, n_harmonics=M)]
    searched = solve(data, MODEL)
    again = solve(data, MODEL, start=searched.timing)
    u = np.sqrt(np.diag(np.linalg.inv(searched.normal)))
    np.testing.assert_array_less(np.abs(_values(again) - _values(searched)) / u, 2e-3)
    assert again.began == searched.timing
    assert 0 < again.n_steps <= searched.n_steps


def test_steps_are_those_of_every_search(monkeypatch):
    """Oracle: by hand; 5 and 7 of two coarse ones, and 11 and 13 of the fine ones from where those ended."""
    theta, sums = _frames()
    data = [compress(theta, sums, n_harmonics=M)]
    found = solve(data, MODEL)
    near = [SimpleNamespace(n_steps=n, start=found.timing, values=found.timing) for n in (5, 7)]
    monkeypatch.setattr(row_timing, "_near", lambda *_, **__: near)
    ends = iter([replace(found, n_steps=n) for n in (11, 13)])
    monkeypatch.setattr(row_timing, "_end", lambda *_, **__: next(ends))
    assert solve(data, MODEL).n_steps == 36


def test_pulls_of_300_repetitions_are_standard():
    """Oracle: the numbers that made the frames; (estimate - truth) / u by the normal matrix has mean 0, spread 1."""
    model = _model(row_timing._COARSE)
    theta, exact = _frames(model=model, noise=0.0, n=300)
    rng, pulls, deviations = np.random.default_rng(7), [], []
    start = None
    for _ in range(300):
        sums = exact + rng.normal(0, 30, exact.shape)
        found = solve([compress(theta, sums, n_harmonics=row_timing._COARSE)], model, start=start)
        start = _named(TRUTH)
        pulls.append((_values(found) - TRUTH) / np.sqrt(np.diag(np.linalg.inv(found.normal))))
        deviations.append((_values(found) - TRUTH) @ found.normal @ (_values(found) - TRUTH))
    assert np.all(np.abs(np.mean(pulls, axis=0)) < 0.2)
    np.testing.assert_allclose(np.std(pulls, axis=0), 1, atol=0.12)
    assert np.mean(deviations) == pytest.approx(8, abs=0.6)  # chi squared with eight degrees of freedom


KINDS = {
    "rolling window": (
        camera("photon", "rolling"),
        {"integration_time": 9e-3, "pixel_memory": 0.01, "blade_share": 0.01, "row_delay": 60e-6},
    ),
    "snapshot window": (
        camera("photon", "snapshot"),
        {"integration_time": 12e-3, "pixel_memory": 0.01, "blade_share": 0.01},
    ),
    "snapshot lag": (
        camera("microbolometer", "snapshot"),
        {"time_constant": 6e-3, "recursive_filter": 0.06, "blade_share": 0.01},
    ),
}


@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("delay", [-9e-3, 2e-3, 25e-3, 38e-3])
@pytest.mark.parametrize("contrast", [-600.0, 600.0])
def test_the_search_finds_its_own_start_for_every_camera(kind, delay, contrast):
    """Oracle: the numbers that made the frames, before a cold and a warm blackbody."""
    which, own = KINDS[kind]
    model, truth = _model(camera=which), dict.fromkeys(EDGE_DELAYS, delay) | own
    theta = 0.4 + OMEGA * 0.033 * np.arange(600)
    sums = 9e4 + contrast * at_angles(harmonics(model, truth), theta).T
    sums = sums + np.random.default_rng(4).normal(0, 20, sums.shape)
    found = solve([compress(theta, sums, n_harmonics=M)], model)
    u = np.sqrt(np.diag(np.linalg.inv(found.normal)))
    pulls = [(found.timing[name] - truth[name]) / size for name, size in zip(model.names, u, strict=True)]
    np.testing.assert_array_less(np.abs(pulls), 4.5)
    assert found.minimum.is_settled


def test_a_blade_that_is_less_warm_beside_the_opening_is_two_numbers():
    """Oracle: the numbers that made the frames; taken for one, they leave what is not white and turn others by many u."""
    beside = 0.4 * MODEL.row_harmonics * np.linspace(0.2, 2.0, len(MODEL.row_px))[:, None]
    both = replace(MODEL, beside_harmonics=beside, blades_apart=True)
    truth = _named(TRUTH) | {BLADE: 0.03, BESIDE: 0.01}
    theta = 0.4 + OMEGA * 0.033 * np.arange(600)
    sums = 9e4 - 600 * at_angles(harmonics(both, truth), theta).T
    sums = sums + np.random.default_rng(4).normal(0, 10, sums.shape)
    data = [compress(theta, sums, n_harmonics=M)]
    found = solve(data, both)
    u = np.sqrt(np.diag(np.linalg.inv(found.normal)))
    pulls = [(found.timing[name] - truth[name]) / size for name, size in zip(both.names, u, strict=True)]
    np.testing.assert_array_less(np.abs(pulls), 4.5)
    one = solve(data, replace(both, blades_apart=False))
    assert BESIDE not in one.timing
    assert one.minimum.at.deviance > found.minimum.at.deviance + 50


@pytest.mark.parametrize("kind", list(KINDS))
def test_pulls_of_every_camera_are_standard(kind):
    """Oracle: the numbers that made the frames; 150 repetitions, (estimate - truth) / u has mean 0 and spread 1."""
    which, own = KINDS[kind]
    n = row_timing._COARSE
    model, truth = _model(n, camera=which), dict.fromkeys(EDGE_DELAYS, 2e-3) | own
    theta = 0.4 + OMEGA * 0.033 * np.arange(300)
    exact = 9e4 - 600 * at_angles(harmonics(model, truth), theta).T
    rng, pulls = np.random.default_rng(8), []
    for _ in range(150):
        found = solve([compress(theta, exact + rng.normal(0, 30, exact.shape), n_harmonics=n)], model, start=truth)
        u = np.sqrt(np.diag(np.linalg.inv(found.normal)))
        pulls.append([(found.timing[name] - truth[name]) / size for name, size in zip(model.names, u, strict=True)])
    assert np.all(np.abs(np.mean(pulls, axis=0)) < 4 / 150**0.5)
    np.testing.assert_allclose(np.std(pulls, axis=0), 1, atol=0.15)


def test_a_held_number_stays_and_the_others_find_their_best():
    """Oracle: least squares without that number's column; the normal matrix of the others."""
    theta, sums = _frames()
    data = [compress(theta, sums, n_harmonics=M)]
    free = solve(data, MODEL)
    u = np.sqrt(np.linalg.inv(free.normal)[4, 4])
    held = {"time_constant": free.timing["time_constant"] + u}
    found = solve(data, MODEL, held=held)
    assert found.timing["time_constant"] == held["time_constant"]
    assert found.minimum.free == tuple(name for name in NAMES if name not in held)
    covariance = np.linalg.inv(free.normal)
    expected = _values(free)[:4] + covariance[:4, 4] / covariance[4, 4] * u
    np.testing.assert_allclose(_values(found)[:4], expected, atol=0.05 * np.sqrt(covariance[0, 0]))
    np.testing.assert_allclose(found.normal, np.delete(np.delete(free.normal, 4, 0), 4, 1), rtol=0.05)


def test_white_uncertainty_of_one_number_is_that_of_the_inverse_normal_matrix():
    """Oracle: numpy's inverse; and a window of no length, of which nothing is told."""
    theta, sums = _frames()
    data = [compress(theta, sums, n_harmonics=M)]
    found = solve(data, MODEL)
    u = np.sqrt(np.linalg.inv(found.normal)[4, 4])
    assert row_timing.uncertainty(data, MODEL, timing=found.timing, name="time_constant") == pytest.approx(u, rel=1e-6)
    which, own = KINDS["snapshot window"]
    truth = dict.fromkeys(EDGE_DELAYS, 2e-3) | own | {"integration_time": 0.0}
    assert row_timing.uncertainty(data, _model(camera=which), timing=truth, name="integration_time") == np.inf


def test_profile_of_the_time_constant_is_its_uncertainty():
    """Oracle: the normal matrix; one standard uncertainty away all else at its best costs one, two away four."""
    theta, sums = _frames(noise=60.0)
    data = [compress(theta, sums, n_harmonics=M)]
    found = solve(data, MODEL)
    u = np.sqrt(np.linalg.inv(found.normal)[4, 4])
    for steps in (-2, -1, 1, 2):
        held = {"time_constant": _values(found)[4] + steps * u}
        lost = (
            solve(data, MODEL, start={**found.timing, **held}, held=held).minimum.at.deviance
            - found.minimum.at.deviance
        )
        assert lost == pytest.approx(steps**2, rel=0.05)


def test_without_lag_a_row_shows_the_exposed_fraction_of_its_light():
    """Oracle: the limit tau -> 0; `physics.wheel` for each ray of the row, an opening of no width, weighted by its light."""
    n = 1024
    model = _model(n)
    shape_points = sector_points.light_points(
        SectorShape(
            axle_row_px=35.2,
            axle_column_px=31.3,
            offset_row_px=0.0,
            offset_column_px=0.0,
            inner_radius_px=8.0,
            outer_radius_px=29.0,
            bisector_rad=float(np.radians(-91)),
            opening_angle_rad=float(np.radians(75)),
            blur_px=0.8,
        )
    )
    whole = _shown(model, [2e-3] * 4 + [1e-7, 0.0, 0.0, 60e-6])
    theta = np.linspace(0, TURN, 200)
    for k in (1, 5, 9):
        row = model.row_px[k]
        light = (
            shape_points.area_px2
            * np.diff(norm.cdf((row + np.array([[-0.5], [0.5]]) - shape_points.row_px) / 0.8), axis=0)[0]
        )
        near = light > 1e-7
        at = theta[:, None] + OMEGA * (2e-3 + row * 60e-6) - shape_points.angle_rad[near]
        narrow = replace(WHEEL, opening_angle_rad=1e-6)
        expected = exposed_fraction(at, narrow) @ light[near]
        np.testing.assert_allclose(at_angles(whole[k : k + 1], theta)[0], expected, atol=0.03 * light.sum())
        assert np.mean(np.abs(at_angles(whole[k : k + 1], theta)[0] - expected)) < 0.003 * light.sum()


def test_without_row_delay_all_rows_are_read_at_once():
    """Oracle: the limit row delay 0 is a snapshot; the same row function at any row number, and the shift of a single delay."""
    still = np.array([2e-3] * 4 + [5e-3, 0.1, 0.01, 0.0])
    moved = replace(MODEL, row_px=MODEL.row_px + 100)
    np.testing.assert_allclose(_shown(MODEL, still), _shown(moved, still), atol=1e-14)
    rolling = np.array([2e-3] * 4 + [5e-3, 0.1, 0.01, 60e-6])
    for k, row in enumerate(MODEL.row_px):
        alone = still + np.array([row * 60e-6] * 4 + [0, 0, 0, 0])
        np.testing.assert_allclose(_shown(MODEL, rolling)[k], _shown(MODEL, alone)[k], atol=1e-12)


def test_a_shift_of_the_delay_is_a_shift_of_the_angle():
    """Oracle: frames of a wheel that is further on by omega times the delay."""
    theta, sums = _frames()
    shift = 1.7e-3
    one = solve([compress(theta, sums, n_harmonics=M)], MODEL)
    other = solve([compress(theta + OMEGA * shift, sums, n_harmonics=M)], MODEL)
    np.testing.assert_allclose(_values(other)[:4], _values(one)[:4] - shift, atol=1e-8)
    np.testing.assert_allclose(_values(other)[4:], _values(one)[4:], atol=1e-8)


def test_frames_that_know_nothing_of_the_wheel_do_not_pretend_to():
    """Oracle: pure noise, drawn eight times; it is refused, or the time constant is uncertain by a large part of itself."""
    u = []
    for seed in range(8):
        theta, sums = _frames(contrast=0.0, seed=seed)
        try:
            data = [compress(theta, sums, n_harmonics=M)]
            found = solve(data, MODEL)
        except EstimationError:
            u.append(np.inf)
        else:
            u.append(row_timing.uncertainty(data, MODEL, timing=found.timing, name="time_constant"))
    assert min(u) > 1e-3
    assert np.median(u) > 2e-3


def test_a_start_far_beside_is_no_reason_to_give_up():
    """Oracle: the solution by searching; a wrong start takes more steps, never an error."""
    theta, sums = _frames()
    data = [compress(theta, sums, n_harmonics=M)]
    searched = solve(data, MODEL)
    found = solve(data, MODEL, start=_named([9e-3] * 4 + [2e-3, 0.0, 0.0, 0.0]))
    u = np.sqrt(np.diag(np.linalg.inv(searched.normal)))
    np.testing.assert_array_less(np.abs(_values(found) - _values(searched)) / u, 1e-2)


def test_rows_that_do_not_change_are_told():
    """Oracle: constant sums; there is no phase to begin with."""
    theta, sums = _frames(contrast=0.0, noise=0.0)
    with pytest.raises(EstimationError, match="do not change with the wheel"):
        solve([compress(theta, np.zeros_like(sums), n_harmonics=M)], MODEL)


def test_fewer_harmonics_are_the_first_ones():
    """Oracle: the model made with fewer."""
    few = MODEL.lowest(9)
    np.testing.assert_array_equal(few.open_harmonics, _model(9).open_harmonics)
    np.testing.assert_allclose(few.row_harmonics, _model(9).row_harmonics, atol=1e-12)
    waves = basis(np.array([0.3]), n_harmonics=9)
    assert (packed(_shown(few, TRUTH)) @ waves).shape == (10, 1)


def test_angles_that_differ_by_rounding_alone_count_as_one():
    """Oracle: the truth's row delay, 60 us, found from twenty angles, one too few for 20 orders, that scatter by 1e-9 rad."""
    random, angle = np.random.default_rng(0), np.repeat(TURN * np.arange(20) / 20, 10)
    sums = -600 * at_angles(_shown(MODEL, TRUTH), angle).T + random.normal(0, 30, (200, 10))
    data = [compress(angle + 1e-9 * random.normal(size=200), sums, n_harmonics=20)]
    found = row_timing._search(data, MODEL.lowest(20), signs=(1, -1), held={"recursive_filter": 0.0})
    assert found["row_delay"] == pytest.approx(60e-6, abs=6e-6)
