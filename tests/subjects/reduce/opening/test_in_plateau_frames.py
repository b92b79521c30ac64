"""The mask opening found in frames that were rendered by brute force, and every reason to refuse."""

import numpy as np
import pytest
from scipy import ndimage

from irtiming.errors import ReductionError
from irtiming.records.choices import Choices
from irtiming.reduce.nonuniformity import Correction, correction
from irtiming.reduce.opening import in_plateau_frames
from irtiming.reduce.opening.in_plateau_frames import dead_pixels, find

TURN = 2 * np.pi
# 1000 nominal angles of the paper's scheme, every fourth frame of it
_THETA = TURN * ((99 * np.arange(0, 1000, 4)) % 1000) / 1000
_TIMES = _THETA / (TURN * 3)


def _frames(camera, seed=0):
    return camera.frames(lambda t: TURN * 3 * t, _TIMES, seed=seed)


def _flat(shape):
    return Correction(gain=np.ones(shape), offset_dn=np.zeros(shape), bad=np.zeros(shape, bool))


@pytest.fixture(scope="module")
def look(paper_wheel, recorded):
    """Find the opening in frames: ``look(frames, choices=..., **fields of the recording).opening``."""
    wheel = paper_wheel(duration_s=5.0)

    def run(frames, *, choices=None, wheel_angle_rad=None, **fields):
        recording = recorded(wheel, frames=frames, n_triggers=len(frames), **fields)
        return find(recording, correction(recording), choices=choices or Choices(), wheel_angle_rad=wheel_angle_rad)

    return run


@pytest.fixture(scope="module")
def hot(paper_camera):
    """Frames before a hot blackbody."""
    return _frames(paper_camera())


def _peaks(found):
    return found.histogram.plate_dn, found.histogram.blackbody_dn


def _true_light(camera):
    light, _ = camera.light_by_angle()
    return light.sum(axis=0)


@pytest.mark.parametrize("blur", [0.3, 0.7, 1.2])
@pytest.mark.parametrize("blackbody", [6000.0, 4000.0])
def test_opening_is_found_before_a_hot_and_a_cold_blackbody(look, paper_camera, blur, blackbody):
    """Oracle: the rendered light of the mask; half of it is the mask's border, all of it lies in the summed region."""
    wheel_dn = 5050.0 if blackbody < 5000 else 4950.0
    camera = paper_camera(blur_px=blur, blackbody_dn=blackbody, wheel_dn=wheel_dn)
    light = _true_light(camera)
    seen = look(_frames(camera))
    found = seen.opening
    assert np.mean(found.mask != (light > 0.5)) < 0.012
    assert _peaks(seen) == pytest.approx((5000, blackbody), abs=4)
    assert seen.histogram.threshold_dn == pytest.approx((5000 + blackbody) / 2, abs=4)
    assert found.blackbody_is_colder == (blackbody < 5000)
    assert light[found.summed].sum() == pytest.approx(light.sum(), rel=1e-3)
    assert 2 * blur < found.border_px < 4 * blur + 4
    assert np.array_equal(dead_pixels.weights(found.summed, found.bad), found.summed.astype(float))
    assert found.n_bad_pixels == 0
    assert seen.findings == ()


def test_region_holds_the_opening_with_a_margin(look, hot, paper_camera):
    """Oracle: the box of the rendered light."""
    lit = np.argwhere(_true_light(paper_camera()) > 0.5)
    roi = look(hot).opening.roi
    for side, first, last in ((0, roi[0], roi[1] - 1), (1, roi[2], roi[3] - 1)):
        assert lit[:, side].min() - first >= 3
        assert last - lit[:, side].max() >= 3 or last == (59, 79)[side]


def test_open_and_covered_frames_are_the_scene(look, hot, paper_camera):
    """Oracle: the levels that were rendered, 1000 DN apart in the middle of the opening."""
    found = look(hot).opening
    inside = ndimage.binary_erosion(found.mask, iterations=3)
    np.testing.assert_allclose(found.open_frame_dn[inside], 6000, atol=5)
    np.testing.assert_allclose(found.covered_frame_dn[inside], 4950, atol=5)
    assert found.histogram.count.sum() == np.diff(found.roi)[[0, 2]].prod()
    assert found.histogram.bin_edges_dn.size == found.histogram.count.size + 1


def test_threshold_level_and_value_are_obeyed(look, hot):
    """Oracle: by hand; 66 % of the way from 5000 to 6000 DN, and the value as told."""
    assert look(hot, choices=Choices(threshold_level=0.66)).histogram.threshold_dn == pytest.approx(5660, abs=4)
    told = look(hot, choices=Choices(threshold_dn=7000.0))
    assert told.histogram.threshold_dn == 7000
    assert "threshold 7000 DN lies outside the histogram peaks" in told.findings[-1].what
    assert told.findings[-1].code == "threshold-outside-peaks"


def test_region_of_interest_is_obeyed(look, hot):
    """Oracle: the region as told; mask and summed region are the same pixels as found without it."""
    automatic, told = look(hot).opening, look(hot, choices=Choices(roi=(0, 50, 2, 79))).opening
    assert told.roi == (0, 50, 2, 79)
    assert np.array_equal(told.summed, automatic.summed)
    assert np.array_equal(told.mask, automatic.mask)


def test_dead_pixels_are_stood_in_for_by_their_neighbours(look, paper_camera, flat_reference):
    """Oracle: by hand; the weights keep their sum, dead pixels have none, and the opening is found as without them."""
    gain = np.ones((60, 80))
    dead = [(20, 40), (21, 41), (22, 30), (33, 38), (50, 5)]
    for pixel in dead:
        gain[pixel] = 0.0
    frames = _frames(paper_camera())
    clean = look(frames, nonuniformity=flat_reference(np.ones((60, 80)), np.zeros((60, 80)))).opening
    for pixel in dead:
        frames[(slice(None), *pixel)] = 200
    seen = look(frames, nonuniformity=flat_reference(gain, np.zeros((60, 80))))
    found = seen.opening
    assert found.roi == clean.roi
    assert np.array_equal(found.mask, clean.mask)
    assert np.array_equal(found.summed, clean.summed)
    weight = dead_pixels.weights(found.summed, found.bad)
    assert weight.sum() == pytest.approx(found.summed.sum())
    assert [weight[pixel] for pixel in dead[:4]] == [0, 0, 0, 0]
    assert weight[22, 31] == pytest.approx(1 + 1 / 8)
    assert found.n_bad_pixels == 4
    assert seen.findings == ()


def test_nonuniform_detector_gives_the_same_opening(look, paper_camera, flat_reference):
    """Oracle: the same scene on a perfect detector; raw values are scene times gain plus offset."""
    rng = np.random.default_rng(4)
    gain, offset = rng.uniform(0.7, 1.3, (60, 80)), rng.normal(0, 150, (60, 80))
    scene = _frames(paper_camera())
    raw = np.rint(scene * gain + offset).astype(np.uint16)
    found = look(raw, nonuniformity=flat_reference(gain, offset))
    perfect = look(scene, nonuniformity=flat_reference(np.ones((60, 80)), np.zeros((60, 80))))
    assert np.mean(found.opening.mask != perfect.opening.mask) < 1e-3
    assert _peaks(found) == pytest.approx(_peaks(perfect), abs=8)


def test_scouts_do_not_fall_in_step_with_the_wheel(paper_wheel, recorded, paper_camera):
    """Oracle: frames numbered so that every 101st shows the same angle; evenly spaced looks would see one angle only."""
    few = _frames(paper_camera())
    order = np.argsort(_THETA)

    class Endless:
        shape = (101 * 239 + 1, 60, 80)

        def pick(self, indices):
            turns = np.mod(10 / 101 * np.asarray(indices), 1.0)
            return few[order[np.floor(turns * len(few)).astype(int)]]

    recording = recorded(paper_wheel(duration_s=5.0), n_triggers=10)
    object.__setattr__(recording, "frames", Endless())
    found = find(recording, _flat((60, 80)), choices=Choices())
    assert _peaks(found) == pytest.approx((5000, 6000), abs=6)


@pytest.mark.parametrize("shift", [(-29, 0), (0, -23), (0, 23), (24, 0)])
def test_opening_cut_by_the_image_is_refused(look, paper_camera, shift):
    """Oracle: by hand; the opening spans rows 12..36 and columns 18..62, and is moved out of the image."""
    camera = paper_camera(axle=(48.0 + shift[0] + (0 if shift[0] <= 0 else 13), 40.3 + shift[1]))
    with pytest.raises(
        ReductionError, match=r"of a 60 x 80 image and is cut by its border; the whole opening with 2 pix"
    ):
        look(_frames(camera))


def test_still_scene_is_refused(look):
    """Oracle: by hand; noise of 3 DN everywhere, no opening."""
    frames = np.rint(np.random.default_rng(5).normal(5000, 3, (250, 60, 80)))
    with pytest.raises(
        ReductionError, match=r"no opening found: the liveliest pixels vary by .* differ by some kelvin"
    ):
        look(frames)


def test_saturated_opening_is_refused(look, paper_camera):
    """Oracle: by hand; a blackbody at 20 000 DN before a camera that ends at 16 383."""
    with pytest.raises(
        ReductionError, match=r"opening's pixels are saturated at 16383 DN .* shorten the integration time"
    ):
        look(_frames(paper_camera(blackbody_dn=20_000.0)))


def test_dead_frames_are_passed_over_or_refused(look, hot):
    """Oracle: by hand; a tenth of blank frames does no harm, a third is refused."""
    frames = hot.copy()
    frames[::10] = 0
    assert np.array_equal(look(frames).opening.mask, look(hot).opening.mask)
    frames[::3] = 0
    with pytest.raises(ReductionError, match=r"of 240 sampled frames are dead .all pixels alike., at most 20 % may be"):
        look(frames)


def test_mask_as_wide_as_the_cutouts_is_refused(look, paper_camera):
    """Oracle: by hand; an opening of 90 deg is wholly open and wholly covered for an instant only."""
    camera = paper_camera(opening_rad=float(np.radians(90)))
    with pytest.raises(
        ReductionError, match=r"never wholly open or covered; the mask must be narrower than the cutouts"
    ):
        look(_frames(camera))
    with pytest.raises(ReductionError, match=r"never wholly open or covered; geometry: the frames show an opening of"):
        look(_frames(camera), wheel_angle_rad=_THETA)


def test_levels_that_sway_and_unlike_blades_leave_the_opening(look, hot, paper_camera):
    """Oracle: the opening of the same frames without either; without the wheel's angles they are refused.

    All pixels sway by 2.5 % of the contrast, and the second half turn has its covered wheel 1.5 % warmer.
    """
    still = look(hot).opening
    light = _true_light(paper_camera())
    sway = 25 * np.sin(TURN * 1.3 * np.arange(len(hot)) / len(hot))
    dark = 1 - np.clip((hot[:, light.reshape(hot.shape[1:]) > 0.99].mean(axis=1) - 4950) / 1050, 0, 1)
    warmer = 15 * dark * (np.mod(_THETA, TURN) > TURN / 2)
    frames = np.rint(hot + sway[:, None, None] + warmer[:, None, None] * light.reshape(hot.shape[1:])).astype(np.uint16)
    with pytest.raises(ReductionError, match="never wholly open or covered"):
        look(frames)
    found = look(frames, wheel_angle_rad=_THETA).opening
    assert np.sum(found.mask ^ still.mask) <= 0.02 * still.mask.sum()
    assert abs(found.border_px - still.border_px) <= 1


@pytest.mark.parametrize("roi", [(0, 61, 0, 80), (0, 50, 0, 81)])
def test_region_outside_the_image_is_refused(look, hot, roi):
    """Oracle: by hand; the image has 60 rows and 80 columns."""
    with pytest.raises(
        ReductionError, match=r"lies outside the image of 60 rows and 80 columns; give first row, end row"
    ):
        look(hot, choices=Choices(roi=roi))


def test_region_that_cuts_the_opening_is_refused(look, hot):
    """Oracle: by hand; the opening's left third lies outside."""
    with pytest.raises(ReductionError, match=r"leaves out .* pixels of the opening; it must hold the whole opening"):
        look(hot, choices=Choices(roi=(0, 60, 32, 80)))


@pytest.mark.parametrize("unit_dn", [0.1, 20.0])
def test_frames_at_the_corners_of_a_plateau_are_not_on_its_level_part(unit_dn):
    """Oracle: by hand; half of the frames lie within one unit of their median: those beyond four are left out."""
    off = np.array([-1, 1, -1, 1, -0.5, 0.5, 0, 3, -3, 3.9, -4.1, 0])
    near = np.arange(off.size) < 11
    level = in_plateau_frames._level_part(near, 5000 + unit_dn * off)
    assert level.tolist() == [*[True] * 10, False, False]


@pytest.mark.parametrize(("radius", "blackbody"), [(6, 6000.0), (2, 5600.0)])
def test_the_blackbody_is_seen_well_inside_the_mask(radius, blackbody):
    """Oracle: by hand; a blurred border of three pixels shows 5600 DN, and a mask that is no wider shows nothing else."""
    rows, columns = np.mgrid[:31, :31]
    away = np.abs(rows - 15) + np.abs(columns - 15)  # steps from pixel to pixel, as a mask is worn away
    mask = away <= radius
    open_dn = np.where(away <= radius - 3, 6000.0, np.where(mask, 5600.0, 5000.0))
    assert in_plateau_frames._peaks(open_dn, mask, np.ones_like(mask)) == (5000.0, blackbody)


def test_the_plate_is_seen_by_most_pixels_around_the_mask():
    """Oracle: by hand; a tenth of them shows a bright screw, which a mean would follow."""
    rows, columns = np.mgrid[:31, :31]
    mask = (np.abs(rows - 15) <= 6) & (np.abs(columns - 15) <= 6)
    open_dn = np.where(mask, 6000.0, 5000.0)
    open_dn[:3] = 5900.0
    assert in_plateau_frames._peaks(open_dn, mask, np.ones_like(mask)) == (5000.0, 6000.0)


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize(("away", "is_closed"), [(34, False), (36, True)])
def test_a_closed_shutter_lies_beyond_the_outer_fences(sign, away, is_closed):
    """Oracle: by hand; quartiles 5 DN on either side of the middle put the fences at 35 DN; half of the swing is 4 DN."""
    level = 5000 + sign * np.array([-5, -5, -5, 0, 0, 0, 5, 5, away])
    frames = np.tile(level.astype(np.uint16)[:, None, None], (1, 6, 8))
    closed = in_plateau_frames._of_another_level(frames, np.full((6, 8), 8.0))
    assert closed.tolist() == [False] * 8 + [is_closed]


def test_glare_is_that_of_the_pixels_from_six_to_twelve_steps_around(look):
    """Oracle: the distances, counted; pixels up to nine steps away follow by a tenth, and those beyond not at all."""
    opening = np.zeros((50, 60), bool)
    opening[20:30, 25:35] = True
    rows, columns = np.mgrid[:50, :60]
    opening[[20, 20, 29, 29], [25, 34, 25, 34]] = False  # what a median of nine takes from a square
    steps = np.min([np.abs(rows - row) + np.abs(columns - column) for row, column in np.argwhere(opening)], axis=0)
    share = np.where(steps == 0, 1.0, np.where(steps <= 9, 0.1, 0.0))
    open_ = np.abs(np.mod(_THETA, TURN / 2) / (TURN / 4) - 1)  # an opening as wide as the cutouts
    frames = np.rint(5000 + 1000 * open_[:, None, None] * share).astype(np.uint16)
    around = (steps >= 6) & (steps <= 12)
    glare = 100 * share[around].mean()
    with pytest.raises(ReductionError, match=rf"glare: pixels far from the opening follow it by {glare:.1f}%"):
        look(frames, wheel_angle_rad=_THETA)


@pytest.mark.parametrize(("swing_dn", "is_opening"), [(4.9, False), (5.1, True), (5.9, True)])
def test_an_opening_swings_by_four_times_the_others_and_a_count(swing_dn, is_opening):
    """Oracle: by hand; the others vary by 1 DN, so at least 5 DN must be; 10 x 10 pixels of 40 x 40."""
    swing = np.ones((40, 40))
    swing[10:20, 10:20] = swing_dn
    if is_opening:
        found = in_plateau_frames._changing_pixels(swing, _flat(swing.shape), "x")
        assert np.array_equal(found, swing > 1)
    else:
        with pytest.raises(ReductionError, match=r"at least 5\.0 DN must be"):
            in_plateau_frames._changing_pixels(swing, _flat(swing.shape), "x")
