"""The contrast image of a camera whose levels sway, against frames of made-up pixels that were summed one by one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import contrast_look, steady_image
from irtiming.physics import wheel_waves
from irtiming.physics.light.row_sum import BLADE
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.estimate import EDGE_DELAYS, DriftingLevels, EdgeDelayFit, Estimate
from irtiming.records.pixel_waves import PixelWaves
from irtiming.records.row_timing import RowTimingFit, Sway

N = 400
SEGMENT = (np.arange(N) > 170).astype(np.int64)
CONTRAST_DN = -600.0


@pytest.fixture(scope="module")
def camera(brute_bolometer):
    return brute_bolometer(offset=(0.3, -0.2))


@pytest.fixture(scope="module")
def still(camera, brute_rows):
    """Frames in two stretches, of levels that stay."""
    return brute_rows(camera, segment=SEGMENT)


def _in_stretches(curve):
    """Less its mean in each stretch."""
    return curve - np.array([curve[number == SEGMENT].mean() for number in (0, 1)])[SEGMENT]


STEP_RAD = 2 * np.pi * 3.0 * 0.033  # of the wheel from frame to frame
"""A gain that goes as the fourth order of the wheel's angle, and an offset as the second: what a slow turn makes of a sway."""
GAIN = 1 + _in_stretches(0.03 * np.cos(4 * STEP_RAD * np.arange(N) + 1.0)) + np.where(SEGMENT, 0.01, -0.015)
OFFSET = _in_stretches(0.02 * np.cos(2 * STEP_RAD * np.arange(N)))  # as a share of the contrast


def _swayed(still, camera, brute_frames, *, own_dn=0.0):
    """The same frames with that gain and offset; pixels have levels of their own behind the wheel, ``own_dn`` (rows, columns)."""
    _, openness = brute_frames(camera, n=N)
    gain = GAIN[:, None, None]
    values = 5000 + gain * (own_dn + CONTRAST_DN * openness) + CONTRAST_DN * OFFSET[:, None, None]
    image = replace(still.contrast, projection_dn=np.einsum("n,nij->ij", still.contrast.frame_weight, values))
    return replace(still, contrast=image, pixel_maps={"mean_dn": values.mean(axis=0)})


@pytest.fixture(scope="module")
def row_fit(camera):
    """A fit that found what was put in: in each stretch a gain of its own, and curves beside it."""

    def make(**fields):
        nothing = np.zeros((N, 3))
        within = _in_stretches(GAIN)
        steps = np.array([GAIN[number == SEGMENT].mean() for number in (0, 1)])
        sway = Sway(
            gains=(within / steps[SEGMENT])[:, None], gain_amounts=np.ones(1), offsets=OFFSET[:, None],
            offset_amounts=np.ones(1), covariance=np.diag([4e-4, 9e-4]), n_looks=2,
        )  # fmt: skip
        shown = {
            "name": "", "trigger_delay_time_set_s": 0.0, "angular_frequency_rad_per_s": camera.omega,
            "estimate": Estimate(
                names=EDGE_DELAYS, units=("s",) * 4, covariance=np.eye(4),
                values=np.array([camera.timing[name] for name in EDGE_DELAYS]),
            ),
            "held": {},
            "step_rad": 0.6, "undone": 0.0, "blades_apart": False, "kept": np.ones(N, bool), "start": {}, "n_steps": 1,
            "shape_effect": np.zeros((0, 0)), "row_px": np.arange(3), "wheel_angle_rad": np.zeros(N),
            "fraction": nothing, "model": nothing, "residual": nothing, "noise": np.ones(3),
            "harmonics": np.full((3, 2), 0.5 + 0j), "gain_dn": np.ones(3), "contrast_dn": CONTRAST_DN * steps,
            "variance_inflation": 1.0, "sway": sway,
        }  # fmt: skip
        return RowTimingFit(**(shown | fields))

    return make


def _point(camera, still, angle, gain):
    """What a point of light of the contrast 1 adds up to, seen with such a gain, its mean taken off."""
    theta = wheel_angle_rad(0.0, still.track, at_ticks=still.trigger_ticks)
    seen = camera.seen(theta + camera.gate_rad - camera.centre_rad - angle)
    return still.contrast.frame_weight @ (gain * (seen - 0.5))  # half of a turn is open


@pytest.mark.parametrize("angle", [-0.6, 0.0, 0.31, 2.0])
def test_a_point_of_light_is_seen_with_the_gain_of_each_frame(camera, still, row_fit, angle):
    """Oracle: a point that is covered, uncovered and lags in the time domain, times the gain, summed with the weights."""
    swayed = steady_image.by_rows(still, row_fit())
    (look,), (plain,) = (contrast_look.looks([one], camera.model, timing=camera.timing) for one in (swayed, still))
    expected = _point(camera, still, angle, GAIN / GAIN.mean())
    assert look.point.values(np.array(angle)) == pytest.approx(expected, abs=1.2e-3)
    assert abs(plain.point.values(np.array(angle)) - expected) > 4e-3


def test_an_image_is_rid_of_offset_and_own_levels(camera, still, row_fit, brute_frames):
    """Oracle: each pixel's light times the gain, less its mean, added up; its own level is a tenth of the contrast."""
    rows, columns = np.indices(still.contrast.good.shape)
    own_dn = 60 * np.sin(0.1 * rows) * np.cos(0.07 * columns)
    _, openness = brute_frames(camera, n=N)
    swayed = _swayed(still, camera, brute_frames, own_dn=own_dn)
    found = steady_image.by_rows(swayed, row_fit()).contrast
    varying = GAIN[:, None, None] * (openness - openness.mean(axis=0))
    expected = CONTRAST_DN * np.einsum("n,nij->ij", still.contrast.frame_weight, varying)
    before = np.abs(swayed.contrast.projection_dn - expected).max()
    assert before > 1.0
    np.testing.assert_allclose(found.projection_dn, expected, atol=0.05 * before)


def test_waves_of_pixels_are_rid_of_offset_and_own_levels(camera, still, row_fit, brute_frames):
    """Oracle: each pixel's light times the gain, less its mean, summed with each wave; a dozen pixels of the opening."""
    rows, columns = np.indices(still.contrast.good.shape)
    own_dn = 60 * np.sin(0.1 * rows) * np.cos(0.07 * columns)
    _, openness = brute_frames(camera, n=N)
    row_px, column_px = (one[::40][:12] for one in np.nonzero(still.opening.mask))
    angle = wheel_angle_rad(0.0, still.track, at_ticks=still.trigger_ticks)
    weight = wheel_waves.waves(angle, np.array([2, 6, 10, 41, 43]), segment=SEGMENT)
    values = (
        5000 + GAIN[:, None] * (own_dn + CONTRAST_DN * openness)[:, row_px, column_px] + CONTRAST_DN * OFFSET[:, None]
    )
    waves = PixelWaves(
        signal_orders=np.array([2, 6, 10]), quiet_orders=np.array([41, 43]), wheel_angle_rad=angle, segment=SEGMENT,
        row_px=row_px, column_px=column_px, sums_dn=weight @ values,
    )  # fmt: skip
    swayed = replace(_swayed(still, camera, brute_frames, own_dn=own_dn), waves=waves)
    found = steady_image.with_waves(swayed, row_fit()).waves
    expected = CONTRAST_DN * weight @ (GAIN[:, None] * (openness - openness.mean(axis=0))[:, row_px, column_px])
    before = np.abs(waves.sums_dn - expected).max()
    assert before > 1000
    np.testing.assert_allclose(found.sums_dn, expected, atol=0.05 * before)
    assert steady_image.with_waves(replace(swayed, waves=None), row_fit()).waves is None


def test_what_is_not_known_of_a_gain_or_an_offset_is_what_another_one_does(camera, still, row_fit):
    """Oracle: the projection of a point with the gain moved by its u, 3 % of its curve, and that of an offset moved by 2 %."""
    fit = row_fit()
    swayed = steady_image.by_rows(still, fit)
    (look,) = contrast_look.looks([swayed], camera.model, timing=camera.timing)
    shown = np.array([one.at(np.array([0.0, 1.0]), np.array([0.2, 0.2])) for one in look.unsteady])
    weight, curve = still.contrast.frame_weight, fit.sway.gains[:, 0]
    by_offset = 0.02 * (weight @ OFFSET)
    by_gain = 0.03 * (_point(camera, still, 0.2, 1 + curve) - _point(camera, still, 0.2, np.ones(N)))
    order = np.argsort(np.abs(shown[:, 0]))  # a gain does nothing where there is no light
    assert np.abs(shown[order[0], 0]) < 1e-12
    assert abs(np.abs(shown[order[1], 0]) - abs(by_offset)) < 1e-9
    assert np.abs(shown[order[0], 1]) == pytest.approx(abs(by_gain), abs=3e-5)


def _sums_fit(still, *, covariance, kept):
    """A fit of pixel sums that found the same curves, as columns of their own."""
    pixels = float(still.opening.weight.sum())
    nothing = np.zeros(0)
    levels = DriftingLevels(
        drift=OFFSET[:, None], gain=(GAIN / GAIN.mean() - 1)[:, None], relative_gain=GAIN / GAIN.mean(),
        relative_offset=OFFSET * pixels / still.opening.mask.sum(), covariance=covariance,
        step_dn=CONTRAST_DN * GAIN.mean() * float(still.opening.mask.sum()),
    )  # fmt: skip
    return EdgeDelayFit(
        name="", trigger_delay_time_set_s=0.0, angular_frequency_rad_per_s=1.0, edge_delay_s=np.zeros(4), start_delay_s=0.0,
        estimate=Estimate(names=EDGE_DELAYS, units=("s",) * 4, values=np.zeros(4), covariance=np.eye(4)),
        wheel_angle_rad=nothing, fraction=np.full(N, 0.5), residual=nothing, degrees_of_freedom=N, noise=1.0, step=1.0,
        variance_inflation=1.0, n_dropped=0, kept=kept, levels=levels,
    )  # fmt: skip


def test_a_fit_of_pixel_sums_tells_an_image_the_same(camera, still, row_fit, brute_frames):
    """Oracle: the image that a fit of the rows leaves, which is checked above; frames that were not fitted go with neighbours."""
    swayed = _swayed(still, camera, brute_frames)
    rows = steady_image.by_rows(swayed, row_fit()).contrast
    kept = np.ones(N, bool)
    sums = steady_image.by_sums(swayed, _sums_fit(still, covariance=np.zeros((2, 2)), kept=kept)).contrast
    np.testing.assert_allclose(sums.in_sums.relative_gain, rows.in_sums.relative_gain, atol=1e-3)
    np.testing.assert_allclose(sums.projection_dn, rows.projection_dn, atol=0.02)
    kept[[0, 1, N - 1]] = False
    without = steady_image.by_sums(swayed, _sums_fit(still, covariance=np.zeros((2, 2)), kept=kept)).contrast
    expected = sums.in_sums.relative_gain.copy()
    expected[[0, 1, N - 1]] = expected[[2, 2, N - 2]]
    np.testing.assert_array_equal(without.in_sums.relative_gain, expected)


def test_numbers_that_are_not_independent_are_taken_apart(still):
    """Oracle: U U' is the covariance of gain and offset in any two frames, by hand from that of their amounts."""
    covariance = np.array([[4e-4, 3e-4], [3e-4, 9e-4]])
    fit = _sums_fit(still, covariance=covariance, kept=np.ones(N, bool))
    sway = steady_image.by_sums(still, fit).contrast.in_sums
    share = float(still.opening.mask.sum()) / float(still.opening.weight.sum())
    gain, offset = fit.levels.gain[:, 0], fit.levels.drift[:, 0] * share
    np.testing.assert_allclose(sway.u_gain @ sway.u_gain[7], 9e-4 * gain * gain[7], atol=1e-12)
    np.testing.assert_allclose(sway.u_gain @ sway.u_offset[7], 3e-4 * gain * offset[7], atol=1e-12)


def test_without_a_sway_an_image_stays(still, row_fit):
    """Oracle: the very projection; an even gain, nothing that is not known, and edges as the fit has them."""
    plain = steady_image.by_rows(still, row_fit(sway=None, contrast_dn=np.full(2, CONTRAST_DN))).contrast
    np.testing.assert_allclose(plain.projection_dn, still.contrast.projection_dn, atol=1e-9)
    np.testing.assert_array_equal(plain.model_weight, still.contrast.frame_weight)
    assert plain.in_sums.u_gain.size == plain.in_sums.u_offset.size == 0
    assert (
        steady_image.by_sums(
            still, replace(_sums_fit(still, covariance=np.zeros((2, 2)), kept=np.ones(N, bool)), levels=None)
        )
        is still
    )


@pytest.mark.parametrize("contrast_dn", [-600.0, 600.0])
@pytest.mark.parametrize("angle", [-0.6, 0.31])
def test_a_warmer_blade_shows_in_the_image_where_frames_are_missing(camera, brute_rows, row_fit, contrast_dn, angle):
    """Oracle: a point in the time domain that shows 3 % of the contrast behind the second blade, in every other third of a turn.

    In even orders a blade is half a weaker contrast; where thirds of a turn are visited unevenly, the first order shows too.
    """
    share = 0.03
    theta = np.mod(STEP_RAD * np.arange(N), 2 * np.pi / 3)
    rows = brute_rows(camera, keep=np.flatnonzero(theta < np.pi / 3), contrast_dn=contrast_dn)
    kept = rows.trigger_ticks.size
    fit = row_fit(sway=None, contrast_dn=np.full(1, contrast_dn), kept=np.ones(kept, bool), held={BLADE: share})
    known, none = (
        contrast_look.looks(
            [steady_image.by_rows(rows, replace(fit, held={BLADE: one}))], camera.model, timing=camera.timing
        )[0]
        for one in (share, 0.0)
    )
    one_blade = replace(camera, edges=(*camera.edges[:2], camera.edges[3], camera.edges[3]))
    at = wheel_angle_rad(0.0, rows.track, at_ticks=rows.trigger_ticks) + camera.gate_rad - camera.centre_rad - angle
    seen = camera.seen(at) + share * (one_blade.seen(at) - camera.seen(at))
    expected = rows.contrast.frame_weight @ seen / (1 - share / 2)
    there = np.array(angle)
    assert known.point.values(there) + known.odd.values(there) == pytest.approx(expected, abs=1.5e-3)
    assert abs(none.point.values(there) - expected) > 4e-3
    assert np.array_equal(known.point.table, none.point.table)
    assert not none.odd.table.any()
    assert (
        np.vdot(known.projection, rows.contrast.projection_dn).real * contrast_dn > 0
    )  # a cold opening is turned over


def test_waves_are_rid_of_the_own_levels_of_their_pixels_wherever_the_region_of_interest_lies():
    """Oracle: by hand; a gain that is a wave twice a turn, and two pixels of a region from row 3 and column 10 on."""
    angle, segment = 2 * np.pi * np.arange(12) / 12, np.zeros(12, int)
    own_dn = np.arange(6.0).reshape(2, 3)
    waves = PixelWaves(
        signal_orders=np.array([2]), quiet_orders=np.array([4]), wheel_angle_rad=angle, segment=segment,
        row_px=np.array([3, 4]), column_px=np.array([12, 10]), sums_dn=np.zeros((4, 2)),
    )  # fmt: skip
    gain = 1 + 0.1 * np.cos(2 * angle)
    sway = steady_image._Sway(found=SimpleNamespace(relative_gain=gain), offset_dn=np.zeros(12), own_dn=own_dn)
    recording = SimpleNamespace(waves=waves, opening=SimpleNamespace(roi=(3, 5, 10, 13)))
    found = sway.waves_of(recording).sums_dn
    weight = wheel_waves.waves(angle, waves.orders, segment=segment)
    np.testing.assert_allclose(found, -np.outer(weight @ gain, [2.0, 3.0]), atol=1e-12)
    assert np.abs(found).max() > 0.1
