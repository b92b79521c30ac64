"""One recording by the exact model: a camera that was summed point by point in the time domain comes back."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import row_fit, row_light
from irtiming.estimate.row_light import SHAPE_NUMBERS, SHAPE_STEPS, shape_of
from irtiming.inference.optimiser import minimise
from irtiming.physics import blurred_sector, sector_points
from irtiming.physics.light.row_sum import BLADE
from irtiming.physics.response.first_order_lag import HARMONICS
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.physics.wheel import wheel_model
from irtiming.physics.wheel_harmonics import at_angles

TURN = 2 * np.pi


@pytest.fixture(scope="module")
def camera(brute_bolometer):
    """Edges of the cutouts differ from those of the ring by up to 0.4 mrad."""
    return brute_bolometer(edge_delay_s=(2.31e-3, 2.29e-3, 2.3e-3, 2.32e-3))


@pytest.fixture(scope="module")
def truth(camera):
    return np.array([*camera.edge_delay_s, camera.time_constant_s, 0.0, camera.row_delay_s])


@pytest.fixture(scope="module")
def light(camera, brute_rows, sector_of):
    """Light of the rows by the camera's own sector."""
    return row_light.row_light(brute_rows(camera).rows.row_px, sector_of(camera), n_harmonics=HARMONICS)


@pytest.fixture(scope="module")
def exact(camera, brute_rows):
    """Rows without noise."""
    return brute_rows(camera)


def _six(fit):
    return fit.estimate.values


def _light_of(numbers, light, camera):
    """The same rows in the light of another sector."""
    shape = shape_of(dict(zip(SHAPE_NUMBERS, numbers, strict=True)), False, image=(camera.rows, camera.columns))
    points, over_rows = sector_points.light_points(shape, n_harmonics=HARMONICS), shape.blur.rows_px
    harmonics = blurred_sector.row_harmonics(points, light.row_px, blur_px=over_rows, n_harmonics=HARMONICS)
    return replace(light, harmonics=(1 - shape.glare) * harmonics)


def _noisy(rows, noise_of, *, seed):
    """Row sums with noise of shape (frame, row) added."""
    clean = rows.rows.row_sum_dn
    noisy = clean + noise_of(np.random.default_rng(seed), clean.shape)
    return replace(rows, rows=replace(rows.rows, row_sum_dn=noisy))


def _white(size_dn):
    return lambda rng, shape: rng.normal(0, size_dn, shape)


@pytest.mark.parametrize("contrast_dn", [-600.0, 700.0])
def test_what_made_the_frames_comes_back(camera, truth, light, brute_rows, contrast_dn):
    """Oracle: the camera's numbers, before a cold and a warm blackbody; points and harmonics leave 2.5 us and 30 ns."""
    fit = row_fit.fit(brute_rows(camera, contrast_dn=contrast_dn), camera.model, light=light)
    np.testing.assert_allclose(_six(fit)[:5], truth[:5], atol=2.5e-6)
    assert fit.row_delay_s == pytest.approx(truth[6], abs=4e-8)
    np.testing.assert_allclose(fit.gain_dn, contrast_dn * light.harmonics[:, 0].real, rtol=2e-3)
    assert fit.noise.max() < 1e-3


def test_cold_and_warm_blackbody_give_the_same(camera, light, brute_rows):
    """Oracle: the same frames with the contrast reversed; deviations below a nanosecond."""
    cold, warm = (row_fit.fit(brute_rows(camera, contrast_dn=c), camera.model, light=light) for c in (-600, 600))
    np.testing.assert_allclose(_six(cold), _six(warm), atol=1e-9)
    np.testing.assert_allclose(cold.fraction, warm.fraction, atol=1e-8)


@pytest.mark.parametrize("contrast_dn", [-600.0, 600.0])
def test_an_even_wheel_does_not_hide_which_blackbody_it_was(camera, truth, light, brute_rows, contrast_dn):
    """Oracle: the camera's delay. Ideal edges fit a quarter turn later as well, with the contrast reversed."""
    ideal = wheel_model(
        (0.0, TURN / 4, TURN / 2, 3 * TURN / 4), 0.2682, opening_angle_rad=1.3, centre_angle_rad=camera.centre_rad
    )
    rows = brute_rows(camera, contrast_dn=contrast_dn)
    for seed in range(4):
        fit = row_fit.fit(_noisy(rows, _white(300.0), seed=seed), ideal, light=light)
        np.testing.assert_allclose(fit.edge_delay_s, truth[:4], atol=0.3e-3)


def test_model_and_fractions_are_the_openness_of_the_rows(camera, exact, light, brute_frames):
    """Oracle: the frames before they became DN, summed over the row and divided by its light."""
    fit = row_fit.fit(exact, camera.model, light=light)
    _, openness = brute_frames(camera)
    rows = openness[:, fit.row_px].sum(axis=2) / light.harmonics[:, 0].real
    offset = rows.mean(axis=0) - fit.fraction.mean(axis=0)
    assert np.abs(offset).max() < 2e-3
    np.testing.assert_allclose(fit.fraction + offset, rows, atol=2e-3)
    np.testing.assert_allclose(fit.model + offset, rows, atol=2e-3)
    np.testing.assert_allclose(at_angles(fit.harmonics, fit.wheel_angle_rad).T, fit.model, atol=1e-12)
    np.testing.assert_allclose(fit.fraction - fit.model, fit.residual, atol=1e-12)
    assert np.all((fit.wheel_angle_rad >= 0) & (fit.wheel_angle_rad < TURN))


def test_a_refusal_is_about_its_recording(camera, exact, light):
    """Oracle: by hand; rows that never change show no wheel, and of several recordings the message says which."""
    dark = replace(exact, rows=replace(exact.rows, row_sum_dn=np.full_like(exact.rows.row_sum_dn, 5000.0)))
    with pytest.raises(EstimationError, match=f"^{exact.name}: the row sums do not change with the wheel"):
        row_fit.fit(dark, camera.model, light=light)


def test_set_delay_is_taken_off(camera, truth, light, brute_rows):
    """Oracle: the camera's delay; the same frames as if triggered 20 ms earlier and 20 ms set."""
    rows = brute_rows(camera, set_s=0.02)
    assert row_fit.fit(rows, camera.model, light=light).trigger_delay_time_set_s == 0.02
    np.testing.assert_allclose(_six(row_fit.fit(rows, camera.model, light=light))[:4], truth[:4], atol=2.5e-6)


def test_a_shift_of_the_delay_is_a_shift_of_the_gate(camera, exact, light):
    """Oracle: the gate moved by omega times 1 ms; everything else stays."""
    moved = replace(camera.model, gate_angle_rad=camera.model.gate_angle_rad + camera.omega * 1e-3)
    one, other = (_six(row_fit.fit(exact, model, light=light)) for model in (camera.model, moved))
    np.testing.assert_allclose(other, one - np.array([1e-3] * 4 + [0] * (one.size - 4)), atol=1e-9)


def test_stretches_have_offsets_of_their_own(camera, truth, light, brute_rows):
    """Oracle: the same frames without a jump between the stretches; and the camera's numbers."""
    segment = (np.arange(400) > 150).astype(np.int64)
    calm, jumped = (
        row_fit.fit(brute_rows(camera, segment=segment, offset_dn=o), camera.model, light=light)
        for o in ((0.0, 0.0), (-200.0, 450.0))
    )
    np.testing.assert_allclose(_six(jumped), _six(calm), atol=1e-9)
    np.testing.assert_allclose(_six(jumped)[:5], truth[:5], atol=2.5e-6)
    np.testing.assert_allclose(jumped.residual, calm.residual, atol=1e-9)


def test_lost_frames_leave_no_gap(camera, truth, light, brute_rows):
    """Oracle: the camera's numbers; a quarter of the frames is missing, most of them side by side."""
    rng = np.random.default_rng(2)
    keep = np.delete(np.arange(400), np.concatenate([np.arange(60, 120), 150 + rng.choice(250, 40, replace=False)]))
    fit = row_fit.fit(brute_rows(camera, keep=keep), camera.model, light=light)
    np.testing.assert_allclose(_six(fit)[:5], truth[:5], atol=2.5e-6)
    assert fit.residual.shape[0] == 300


def _repeated(rows, camera, light, noise_of, *, n=60):
    start = row_fit.fit(rows, camera.model, light=light)
    fits = [row_fit.fit(_noisy(rows, noise_of, seed=k), camera.model, light=light, start=start) for k in range(n)]
    moved = np.array([_six(fit) for fit in fits]) - _six(start)
    return (
        moved,
        np.array([np.diag(fit.estimate.covariance) for fit in fits]) ** 0.5,
        np.array([f.variance_inflation for f in fits]),
    )


def test_white_noise_is_what_it_is_said_to_be(camera, exact, light):
    """Oracle: 60 repetitions; scatter of the six numbers over the stated uncertainty, hardly any inflation of the variance."""
    moved, u, variance_inflation = _repeated(exact, camera, light, _white(150.0))
    pulls = moved / u
    assert np.all(np.abs(pulls.mean(axis=0)) < 4 / np.sqrt(60))
    np.testing.assert_allclose(pulls.std(axis=0), 1, atol=0.2)
    assert variance_inflation.min() >= 1
    assert variance_inflation.mean() < 1.25


def test_noise_common_to_the_rows_widens_what_it_moves(camera, brute_rows, light):
    """Oracle: 60 repetitions; each frame has a level of its own, as much in each row as its pixels are many.

    As many frames as recordings have: of 400 an edge has but eighty, of which 17 are taken together, and u is a tenth too small.
    """
    exact = brute_rows(camera, n=800)
    n_pixels = exact.opening.summed[exact.rows.row_px].sum(axis=1)

    def common(rng, shape):
        return rng.normal(0, 60.0, shape) + n_pixels * rng.normal(0, 4.0, (shape[0], 1))

    moved, u, variance_inflation = _repeated(exact, camera, light, common)
    pulls = moved / u
    assert np.all(np.abs(pulls.mean(axis=0)) < 4 / np.sqrt(60))
    assert np.sqrt(np.mean(pulls[:, :4] ** 2)) == pytest.approx(1, abs=0.2)  # the four edges are alike
    np.testing.assert_allclose(pulls[:, 4:].std(axis=0), 1, atol=0.2)
    assert variance_inflation.mean() > 3


def test_shape_effect_is_what_a_refit_finds(camera, exact, light):
    """Oracle: the fit with the light of a sector that is wrong by a little, number by number, both ways."""
    rows = _noisy(exact, _white(15.0), seed=3)
    numbers = np.array([getattr(camera.shape, name) for name in SHAPE_NUMBERS])
    wrong = [[_light_of(numbers + sign * step * (np.arange(numbers.size) == k), light, camera) for sign in (1, -1)]
             for k, step in enumerate(SHAPE_STEPS)]  # fmt: skip
    changes = np.array(
        [(a.harmonics - b.harmonics) / (2 * step) for (a, b), step in zip(wrong, SHAPE_STEPS, strict=True)]
    )
    fit = row_fit.fit(rows, camera.model, light=light)
    fit = row_fit.with_shape_effect(fit, rows, wheel=camera.model, light=light, changes=changes)
    u = np.sqrt(np.diag(fit.estimate.covariance))
    for k, step in enumerate(SHAPE_STEPS):
        moved = [_six(row_fit.fit(rows, camera.model, light=one, start=fit)) for one in wrong[k]]
        slope = (moved[0] - moved[1]) / (2 * step)
        odd = 0.02 if SHAPE_NUMBERS[k] not in WARP_NUMBERS else 0.1  # of these a step is large: the rows' gains follow
        np.testing.assert_allclose(
            fit.shape_effect[:, k] / u, slope / u, rtol=0.05, atol=odd / step, err_msg=SHAPE_NUMBERS[k]
        )


def test_a_number_of_the_sway_that_says_nothing_is_as_good_as_none():
    """Oracle: the same frames without it; an offset that goes as the gain is each row's own, and of all rows nothing is left."""
    of_timing, n_frames, n_rows = 2, 50, 6
    light = np.random.default_rng(7).normal(size=(n_frames, of_timing + 1, n_rows))  # the last is of a sway
    residual = np.random.default_rng(8).normal(size=(n_frames, n_rows))

    def scores(columns):
        timing = light[:, :of_timing]
        information, normal = columns @ columns.transpose(0, 2, 1), (timing @ timing.transpose(0, 2, 1)).sum(axis=0)
        return row_fit._without_sway(np.einsum("nky,ny->nk", columns, residual), information, normal=normal)

    without, beside = scores(light), scores(np.concatenate([light, np.zeros((n_frames, 1, n_rows))], axis=1))
    np.testing.assert_allclose(beside.timing, without.timing, atol=1e-12)
    np.testing.assert_allclose(beside.normal, without.normal, atol=1e-12)
    np.testing.assert_allclose(beside.sway_step, [*without.sway_step, 0], atol=1e-12)
    np.testing.assert_allclose(beside.sway_covariance, np.pad(without.sway_covariance, (0, 1)), atol=1e-12)


def test_a_number_of_the_sway_that_timing_takes_over_is_not_known_better_for_that():
    """Oracle: a law; what looks more and more like the timing is known worse and worse, and never all at once as if exactly."""
    random, n_rows = np.random.default_rng(9), 6
    timing, other = (random.normal(size=(50, 2, n_rows)) for _ in range(2))
    residual, normal = random.normal(size=(50, n_rows)), (timing @ timing.transpose(0, 2, 1)).sum(axis=0)

    def variance(unlike):
        columns = np.concatenate([timing, timing[:, :1] + unlike * other[:, :1], other[:, 1:]], axis=1)
        information, scores = columns @ columns.transpose(0, 2, 1), np.einsum("nky,ny->nk", columns, residual)
        return np.diag(row_fit._without_sway(scores, information, normal=normal).sway_covariance)

    of_sway = np.array([variance(unlike) for unlike in (1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5)])
    assert np.all(np.diff(of_sway[:, 0]) > -1e-3 * of_sway[1:, 0])
    assert of_sway[-1, 0] > 1e5 * of_sway[0, 0]
    np.testing.assert_allclose(of_sway[1:, 1], of_sway[1, 1], rtol=0.1)


def test_likelihood_is_a_parabola_to_four_standard_uncertainties(camera, exact, light):
    """Oracle: twice the log-likelihood of white noise; steps^2 at each standard uncertainty of the time constant."""
    rows = _noisy(exact, _white(150.0), seed=5)
    fit = row_fit.fit(rows, camera.model, light=light)
    likelihood = row_fit.likelihood(rows, camera.model, light=light)
    steps = np.linspace(-4, 4, 9)
    deviance = []
    for step in steps:
        start = fit.timing | {"time_constant": fit.timing["time_constant"] + step * fit.estimate.u("time_constant")}
        deviance.append(minimise(likelihood, start=start, held=("time_constant",)).at.deviance)
    lost = np.array(deviance) - min(deviance)
    assert lost[4] < 0.05
    white = np.polyfit(steps, lost, 2)[0]
    np.testing.assert_allclose(lost, white * steps**2, atol=0.7)
    assert 0.95 < white < 2.0  # the stated uncertainty is never below that of white noise


def test_start_is_told(camera, truth, exact, light):
    """Oracle: a fit that is given an earlier one begins there, the first one where its search ended."""
    first = row_fit.fit(exact, camera.model, light=light)
    assert abs(first.start["edge_delay_0"] - truth[:4].mean()) < 3e-3
    again = row_fit.fit(exact, camera.model, light=light, start=first)
    assert again.start == first.timing


OTHERS = {
    "rolling window": {"camera_type": "photon", "integration_time_s": 8e-3},
    "snapshot window": {
        "camera_type": "photon", "integration_time_s": 8e-3, "readout_mode": "snapshot", "row_delay_s": 0.0,
    },
    "snapshot lag": {"readout_mode": "snapshot", "row_delay_s": 0.0},
}  # fmt: skip


def _fitted(camera, brute_rows, sector_of, *, start=None, **options):
    """Fit of the camera's rows in the light of its own sector."""
    rows = brute_rows(camera, **options)
    order = 256 if camera.camera_type == "photon" else HARMONICS
    light = row_light.row_light(rows.rows.row_px, sector_of(camera), n_harmonics=order)
    return row_fit.fit(rows, camera.model, light=light, start=start)


@pytest.mark.parametrize("kind", list(OTHERS))
@pytest.mark.parametrize("contrast_dn", [-600.0, 700.0])
def test_every_camera_comes_back(brute_bolometer, brute_rows, sector_of, kind, contrast_dn):
    """Oracle: the camera's numbers by name; delays are those of the middle of a window, a snapshot has no row delay."""
    camera = brute_bolometer(edge_delay_s=(2.31e-3, 2.29e-3, 2.3e-3, 2.32e-3), **OTHERS[kind])
    fit = _fitted(camera, brute_rows, sector_of, contrast_dn=contrast_dn)
    own = {"integration_time": 8e-3} if camera.camera_type == "photon" else {"time_constant": camera.time_constant_s}
    own |= {"pixel_memory" if camera.camera_type == "photon" else "recursive_filter": 0.0} | {BLADE: 0.0}
    rolling = {"row_delay": camera.row_delay_s} if camera.readout_mode == "rolling" else {}
    assert fit.estimate.names == (*(f"edge_delay_{edge}" for edge in range(4)), *own, *rolling)
    np.testing.assert_allclose(fit.edge_delay_s, camera.edge_delay_s, atol=2e-6)
    tolerance = {"row_delay": 4e-8, "pixel_memory": 2e-4, "recursive_filter": 2e-4, BLADE: 2e-4}
    for name, value in (own | rolling).items():
        assert fit.timing[name] == pytest.approx(value, abs=tolerance.get(name, 2e-5)), name
    assert fit.held == {}


@pytest.mark.parametrize(("true_s", "stated_s"), [(100e-6, 100e-6), (100e-6, 105e-6), (2e-6, 2e-6)])
def test_a_window_that_frames_hardly_tell_is_held_as_stated(brute_bolometer, brute_rows, sector_of, true_s, stated_s):
    """Oracle: the recording's statement; delay of the middle and row delay come back within four uncertainties all the same."""
    camera = brute_bolometer(camera_type="photon", integration_time_s=true_s)
    fit = _fitted(camera, brute_rows, sector_of, noise_dn=30.0, stated_s=stated_s)
    assert fit.held == {"integration_time": stated_s}
    assert "integration_time" not in fit.estimate
    assert fit.timing["integration_time"] == stated_s
    assert np.all(np.abs(fit.edge_delay_s - 2.3e-3) < 4 * fit.estimate.standard_uncertainties[:4])
    assert abs(fit.row_delay_s - camera.row_delay_s) < 4 * fit.estimate.u("row_delay")


def test_a_window_that_nobody_states_is_held_where_it_was_found(brute_bolometer, brute_rows, sector_of):
    """Oracle: the frames' own uncertainty of it, more than a quarter of its length; nothing else suffers."""
    camera = brute_bolometer(camera_type="photon", integration_time_s=20e-6)
    fit = _fitted(camera, brute_rows, sector_of, noise_dn=60.0)
    assert set(fit.held) == {"integration_time"}
    assert np.all(np.abs(fit.edge_delay_s - 2.3e-3) < 4 * fit.estimate.standard_uncertainties[:4])
    assert np.all(np.isfinite(fit.estimate.covariance))


def test_a_window_that_has_become_too_short_is_held_at_the_shortest_that_frames_tell(
    brute_bolometer, brute_rows, sector_of
):
    """Oracle: by definition, a window as long as its u by the frames' derivatives; of one of 1 us, once taken for 8 ms.

    What it does goes as its square only nearly, with all orders of the wheel.
    """
    long, short = (brute_bolometer(camera_type="photon", integration_time_s=one) for one in (8e-3, 1e-6))
    before = _fitted(long, brute_rows, sector_of, noise_dn=6.0)
    assert before.held == {}
    rows = brute_rows(short, noise_dn=60.0, seed=3)
    light = row_light.row_light(rows.rows.row_px, sector_of(short), n_harmonics=256)
    fit = row_fit.fit(rows, short.model, light=light, start=before)
    assert set(fit.held) == {"integration_time"}
    assert row_fit.fit(rows, short.model, light=light, start=fit).held == fit.held
    assert np.all(np.abs(fit.edge_delay_s - 2.3e-3) < 4 * fit.estimate.standard_uncertainties[:4])
    at = row_fit.likelihood(rows, short.model, light=light, before=fit)(fit.timing)
    own = before.estimate.names.index("integration_time")
    u_s = float(np.linalg.inv(at.jacobian.T @ at.jacobian)[own, own] ** 0.5)
    assert fit.held["integration_time"] == pytest.approx(u_s, rel=0.25)


def test_a_window_that_frames_tell_is_their_own(brute_bolometer, brute_rows, sector_of):
    """Oracle: the camera's window; what the recording states of it, an eighth too little, is where the search begins."""
    camera = brute_bolometer(camera_type="photon", integration_time_s=8e-3)
    fit = _fitted(camera, brute_rows, sector_of, noise_dn=6.0, stated_s=7e-3)
    assert fit.held == {}
    assert fit.timing["integration_time"] == pytest.approx(8e-3, abs=4 * fit.estimate.u("integration_time") + 2e-5)
    assert fit.start["integration_time"] == 7e-3


@pytest.mark.parametrize("is_made", [True, False])
@pytest.mark.parametrize("share", [0.06, 0.3])
def test_a_filter_in_the_camera_is_found_and_undone(camera, truth, light, exact, share, is_made):
    """Oracle: the camera's numbers and the share of a recursion frame by frame; lost on their way, or never made."""
    clean, n = exact.rows.row_sum_dn, exact.trigger_ticks.size
    gone = np.zeros(n, bool)
    gone[np.random.default_rng(3).choice(np.arange(5, n), 12, replace=False)] = True
    given = clean.copy()
    made = np.arange(n) if is_made else np.flatnonzero(~gone)
    for before, now in itertools.pairwise(made.tolist()):
        given[now] = (1 - share) * clean[now] + share * given[before]
    kept = ~gone
    rows = replace(
        exact, rows=replace(exact.rows, row_sum_dn=given[kept]), trigger_ticks=exact.trigger_ticks[kept],
        segment=exact.segment[kept],
    )  # fmt: skip
    fit = row_fit.fit(_noisy(rows, _white(1.0), seed=1), camera.model, light=light)
    for _ in range(2):
        fit = row_fit.fit(_noisy(rows, _white(1.0), seed=1), camera.model, light=light, start=fit)
    assert fit.timing["recursive_filter"] == pytest.approx(share, abs=2e-4)
    np.testing.assert_allclose(_six(fit)[:5], truth[:5], atol=4e-6)
    assert fit.undone == pytest.approx(share, abs=2e-4)
    assert fit.residual.shape[0] == np.sum(kept[1:] & kept[:-1]) == fit.kept.sum()


def test_a_sway_is_told_from_the_wheel_where_frames_visit_its_angles_slowly(brute_bolometer, brute_rows, sector_of):
    """Oracle: the camera's numbers; a quarter turn and a little from frame to frame, so that they go round once in the run.

    A sway of 2 % within the run then looks like the wheel: the first fit, which knows nothing of it, is far off. A gain moves the
    rows' own levels as well, here by a share of their light that is another one in each row; an offset is in all pixels that
    are summed, the wheel before them or not, which are more in the upper rows.
    """
    camera = brute_bolometer(edge_delay_s=(2.31e-3, 2.29e-3, 2.3e-3, 2.32e-3), rate_hz=(0.25 + 1 / 400) / 0.033)
    truth = np.array([*camera.edge_delay_s, camera.time_constant_s])
    light = row_light.row_light(brute_rows(camera).rows.row_px, sector_of(camera), n_harmonics=HARMONICS)
    rows = brute_rows(camera)
    summed = rows.opening.summed.copy()
    summed[rows.rows.row_px[:12]] = True
    rows = replace(rows, opening=replace(rows.opening, summed=summed))
    clean, time = rows.rows.row_sum_dn, np.arange(400) / 400
    gain, offset = 1 + 0.02 * np.sin(8 * time), 600 * 0.01 * np.cos(9 * time)
    pixels = summed[rows.rows.row_px].sum(axis=1)
    level = 0.3 * np.random.default_rng(4).standard_normal(clean.shape[1]) * np.ptp(clean, axis=0)
    swayed = gain[:, None] * (clean - clean.mean(axis=0) + level) + clean.mean(axis=0) + offset[:, None] * pixels
    rows = _noisy(replace(rows, rows=replace(rows.rows, row_sum_dn=swayed)), _white(20.0), seed=2)
    first = fit = row_fit.fit(rows, camera.model, light=light)
    for _ in range(12):  # steps of a sway are damped
        fit = row_fit.fit(rows, camera.model, light=light, start=fit)
    blind, errors = (np.abs(_six(one)[:5] - truth) for one in (first, fit))
    u = fit.estimate.standard_uncertainties[:5]
    assert np.max(errors / u) < 3
    assert np.max(blind / u) > 3
