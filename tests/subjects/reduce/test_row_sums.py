"""Rolling microbolometer recordings whose every frame was made, and broken, by hand."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import ndimage

from irtiming.archive import reader, rig_file
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.errors import ReductionError
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.choices import Choices
from irtiming.reduce import recipes

TURN = 2 * np.pi
_TAU_FRAMES = 0.033 / 6e-3  # time constants from frame to frame


def _shut(values, first, end, *, level=4500.0, jump=0.0):
    """Close the shutter before frames first..end, let pixels forget it afterwards, and shift all levels from then on."""
    open_values = values[min(end, len(values) - 1)].copy()
    values[first:end] = level
    values[end:] += jump
    if 0 < end < len(values):
        values[end] += (level - open_values) * np.exp(-0.3 * _TAU_FRAMES)
    return values


@pytest.fixture(scope="module")
def reduced(rig, rolled, paper_bolometer):
    """Reduce noise-free values made noisy: ``reduced(values, seed=..., choices=..., before=..., **fields)``."""

    def run(values, *, seed=0, choices=None, before=None, **fields):
        frames = values if values.dtype == np.uint16 else paper_bolometer().noisy(values, seed=seed)
        recording = rolled(frames, **fields)
        return recipes.reduce(recording, rig, choices=choices or Choices(), before=before)

    return run


@pytest.fixture(scope="module")
def clean_frames(turning, paper_bolometer):
    """A recording that nothing happens to."""
    return paper_bolometer().noisy(turning, seed=1)


@pytest.fixture(scope="module")
def clean(reduced, clean_frames):
    """Its reduction."""
    return reduced(clean_frames)


def _sentences(found):
    return tuple(finding.sentence() for finding in found.findings)


def _brute_row_sums(frames, found, area):
    """Sums over the rows, each bad pixel replaced by the mean of its nearest good neighbours in the row."""
    mended = frames.astype(float)
    for row, column in np.argwhere(found.opening.bad):
        good = np.flatnonzero(~found.opening.bad[row])
        left, right = good[good < column].max(), good[good > column].min()
        mended[:, row, column] = 0.5 * (mended[:, row, left] + mended[:, row, right])
    return (mended * area).sum(axis=2)[:, found.rows.row_px]


def _check_by_brute_force(frames, found):
    kept = frames[found.frame_index]
    rows, columns = slice(*found.opening.roi[:2]), slice(*found.opening.roi[2:])
    steady = kept[:, rows, columns] - found.rows.drift_dn[:, None, None]
    projection = np.einsum("n,nij->ij", found.contrast.frame_weight, steady)
    np.testing.assert_allclose(found.contrast.projection_dn, projection, atol=1e-9)
    sums = _brute_row_sums(kept, found, found.opening.summed)
    n_pixels = found.opening.summed[found.rows.row_px].sum(axis=1)
    np.testing.assert_allclose(found.rows.row_sum_dn, sums - np.outer(found.rows.drift_dn, n_pixels), atol=1e-6)
    for segment in np.unique(found.segment):
        assert abs(found.contrast.frame_weight[found.segment == segment].sum()) < 1e-12


def test_a_clean_recording_is_kept_to_the_last_frame(clean):
    """Oracle: nothing was done to the frames, so all are kept in one segment, without a word."""
    assert clean.shutter_events == ()
    assert np.array_equal(clean.frame_index, np.arange(1000))
    assert not clean.segment.any()
    assert clean.findings == ()
    assert clean.samples_per_turn == 1000


def test_projections_and_row_sums_are_those_of_brute_force(clean, clean_frames):
    """Oracle: the sums written out over all frames at once in double precision."""
    _check_by_brute_force(clean_frames, clean)


def test_weights_are_the_second_harmonic_at_trigger_and_set_delay(reduced, clean_frames):
    """Oracle: 2 / n exp(-2 i theta) with theta read from the learned track after the set delay, less its mean."""
    found = reduced(clean_frames, trigger_delay_time_set_s=0.02)
    theta = wheel_angle_rad(0.02, found.track, at_ticks=found.trigger_ticks)
    wave = 2 / theta.size * np.exp(-2j * theta)
    np.testing.assert_allclose(found.contrast.frame_weight, wave - wave.mean(), atol=1e-15)


def test_opening_is_the_light_that_was_rendered(clean, paper_bolometer):
    """Oracle: the rendered light of the mask; half of it is the mask's border, all but a thousandth of it is summed."""
    light = paper_bolometer().opening()
    assert np.mean(clean.opening.mask != (light > 0.5)) < 0.012
    assert (light * clean.opening.summed).sum() == pytest.approx(light.sum(), rel=1e-3)
    assert clean.opening.blackbody_is_colder
    assert not clean.opening.bad.any()
    assert np.array_equal(clean.rows.row_px, np.flatnonzero(clean.opening.summed.any(axis=1)))
    inside = ndimage.binary_erosion(clean.opening.mask, iterations=3)
    step = clean.opening.open_frame_dn - clean.opening.covered_frame_dn
    assert -950 < np.median(step[inside]) < -850  # the lag keeps it from the full 950 DN


def test_uncertainty_of_a_projection_is_that_of_the_noise(clean):
    """Oracle: white noise of 5 DN and rounding in 1000 frames: sqrt(25.1 * 2 / 1000) DN."""
    assert clean.contrast.u_dn == pytest.approx(np.sqrt(25.1 * 2 / 1000), rel=0.15)


@pytest.mark.parametrize(("contrast_over_noise", "seed"), [(190, 2), (20, 3), (5, 4), (5, 5), (5, 6), (5, 7)])
def test_no_false_alarm(reduced, turning, paper_bolometer, seed, contrast_over_noise):
    """Oracle: nothing was done to the frames; noise up to a fifth of the contrast of a pixel."""
    camera = paper_bolometer(noise_dn=950 / contrast_over_noise)
    found = reduced(camera.noisy(turning, seed=seed))
    assert found.shutter_events == ()
    assert found.frame_index.size == 1000
    assert found.opening.blackbody_is_colder
    assert found.opening.mask.sum() == pytest.approx((camera.opening() > 0.5).sum(), rel=0.03)


_EVENTS = {
    "at the first frame": [(0, 15)],
    "first frame only": [(0, 1)],
    "at the last frame": [(985, 1000)],
    "in the middle": [(400, 418)],
    "at both ends and twice between": [(0, 18), (300, 320), (610, 622), (990, 1000)],
    "two in quick succession": [(300, 318), (323, 340)],
    "four tenths of the time": [(200 * k + 60, 200 * k + 140) for k in range(5)],
}


@pytest.mark.parametrize(
    ("events", "level"),
    [(name, level) for name, level in zip(_EVENTS, (4500.0, 5800.0) * 4, strict=False)]
    + [("in the middle", 4000.0), ("in the middle", 4500.0), ("in the middle", 4950.0)],
)
def test_shutter_events_are_found_where_they_were_made(reduced, turning, events, level):
    """Oracle: the frames that were overwritten, with a level within the opening's range, at its ends, and outside."""
    values, closed = turning.copy(), np.zeros(1000, bool)
    for first, end in _EVENTS[events]:
        closed[first:end] = True
        _shut(values, first, end, level=level, jump=7.0)
    found = reduced(values)
    assert not closed[found.frame_index].any()
    near = ndimage.binary_dilation(closed, np.ones(11, bool))
    stretches, n = ndimage.label(~near)
    long_enough = [k for k in range(1, n + 1) if np.sum(stretches == k) >= 60]
    assert set(np.flatnonzero(np.isin(stretches, long_enough))) <= set(found.frame_index)
    assert np.unique(found.segment).size == len(long_enough)
    if events != "two in quick succession":  # which are one
        seen = [(e.first_frame, e.end_frame) for e in found.shutter_events]
        assert seen == [pytest.approx(event, abs=1) for event in _EVENTS[events]]
    assert {e.kind for e in found.shutter_events} == {"closed"}


def test_what_lies_between_the_events_is_reduced_exactly(reduced, turning, paper_bolometer):
    """Oracle: brute force over the kept frames, after events found late in a block."""
    values = turning.copy()
    for first, end in [(0, 18), (290, 303), (610, 622)]:
        _shut(values, first, end, jump=-12.0)
    frames = paper_bolometer().noisy(values)
    found = reduced(frames)
    assert np.unique(found.segment).tolist() == [0, 1, 2]
    _check_by_brute_force(frames, found)


def test_new_offsets_after_each_event_leave_the_projection_alone(reduced, turning, paper_bolometer):
    """Oracle: the same frames with another offset for each pixel in each segment; weights sum to zero in each."""
    frames = paper_bolometer().noisy(_shut(turning.copy(), 400, 415))
    offsets = np.random.default_rng(5).integers(-40, 40, frames.shape[1:])
    moved = frames.copy()
    moved[415:] = (moved[415:] + offsets).astype(np.uint16)
    one, other = reduced(frames), reduced(moved)
    assert np.array_equal(one.frame_index, other.frame_index)
    drift = np.sum(one.contrast.frame_weight * (one.rows.drift_dn - other.rows.drift_dn))
    same = one.opening.roi == other.opening.roi
    assert same
    np.testing.assert_allclose(other.contrast.projection_dn, one.contrast.projection_dn + drift, atol=1e-8)


def test_frozen_frames_are_found(reduced, turning, paper_bolometer):
    """Oracle: a frame repeated bit by bit, twice, with another level afterwards."""
    frames = paper_bolometer().noisy(turning)
    for first, end in [(200, 215), (600, 608)]:
        frames[first:end] = frames[first - 1]
        frames[end:] += 9
    found = reduced(frames)
    assert [(e.first_frame, e.end_frame, e.kind) for e in found.shutter_events] == [
        (200, 215, "frozen"),
        (600, 608, "frozen"),
    ]
    assert np.bincount(found.segment).tolist() == [196, 377, 388]


@pytest.mark.parametrize("values", [(0, 65535, 5000), (65535, 5000, 0), (5000, 0, 65535)])
def test_a_lone_blank_frame_is_dropped_and_is_no_event(reduced, clean_frames, values):
    """Oracle: frames of one value, each among sound ones; only they go."""
    frames, blank = clean_frames.copy(), [3, 500, 996]
    for frame, value in zip(blank, values, strict=True):
        frames[frame] = value
    found = reduced(frames)
    assert found.shutter_events == ()
    assert np.setdiff1d(np.arange(1000), found.frame_index).tolist() == blank
    assert _sentences(found) == ("on paper: 3 single frames dropped: not what the wheel angle demands",)
    _check_by_brute_force(frames, found)


def test_half_a_frame_that_is_missing_is_dropped(reduced, clean_frames):
    """Oracle: the lower half of one frame at zero, as a broken transfer leaves it."""
    frames = clean_frames.copy()
    frames[321, 25:] = 0
    found = reduced(frames)
    assert 321 not in found.frame_index
    assert found.frame_index.size == 999


def test_rows_of_a_frame_read_behind_a_shutter_drop_it(reduced, clean_frames):
    """Oracle: by hand; six rows of three frames show a closed shutter, warm as it is, for as short was it closed."""
    frames, behind = clean_frames.copy(), {200: 3, 420: 40, 640: 57}
    for frame, first_row in behind.items():
        frames[frame, first_row : first_row + 6] = 9000
    found = reduced(frames)
    assert np.setdiff1d(np.arange(1000), found.frame_index).tolist() == list(behind)
    assert _sentences(found) == ("on paper: 3 single frames dropped: not what the wheel angle demands",)


def test_lost_frames_skip_their_triggers(reduced, clean_frames, clean):
    """Oracle: the same recording without 30 of its frames; sums of the others stay, but for the drift."""
    kept = np.delete(np.arange(1000), np.random.default_rng(2).choice(np.arange(1, 999), 30, replace=False))
    found = reduced(clean_frames[kept], frame_number=kept, n_triggers=1000, before=clean.opening)
    assert found.shutter_events == ()
    assert np.array_equal(found.trigger_ticks, clean.trigger_ticks[kept])
    assert _sentences(found) == (
        "on paper: 30 frames lost between the first and the last: triggers without a frame are skipped",
    )
    np.testing.assert_allclose(
        found.rows.mask_row_sum_dn.sum(axis=1), clean.rows.mask_row_sum_dn[kept].sum(axis=1), rtol=2e-4
    )


def test_frames_outside_the_control_slots_are_dropped(reduced, clean_frames, clean):
    """Oracle: the slots of the last part of the recording cut off."""
    end = clean.trigger_ticks[899] + 200_000
    ticks = clean.track.edge_ticks
    found = reduced(clean_frames, control_slot_ticks=ticks[ticks <= end])
    assert found.frame_index[-1] == 899
    assert "100 frames dropped: triggered where no control slots were recorded" in found.findings[0].sentence()


def test_blocks_do_not_matter(rig, rolled, turning, paper_bolometer):
    """Oracle: the same frames handed out in blocks of 7, 97 and all at once."""
    frames = paper_bolometer().noisy(_shut(_shut(turning.copy(), 200, 214), 505, 520))
    results = []
    for length in (7, 97, 1000):
        recording = rolled(frames)
        recording = type(recording)(**(recording.__dict__ | {"frames": ArrayFrames(frames, block_frames=length)}))
        results.append(recipes.reduce(recording, rig, choices=Choices()))
    for other in results[1:]:
        assert other.shutter_events == results[0].shutter_events
        assert np.array_equal(other.frame_index, results[0].frame_index)
        assert np.array_equal(other.rows.row_sum_dn, results[0].rows.row_sum_dn)
        np.testing.assert_allclose(other.contrast.projection_dn, results[0].contrast.projection_dn, atol=1e-9)


def test_progress_is_told_after_each_block(rig, rolled, clean_frames):
    """Oracle: blocks of 97 frames."""
    told = []
    recipes.reduce(rolled(clean_frames), rig, choices=Choices(), progress=told.append)
    assert told == [*range(97, 1000, 97), 1000]


@pytest.mark.parametrize("kind", ["stuck", "dead", "half", "noisy"])
def test_dead_pixels_in_the_opening_are_stood_in_for(reduced, clean_frames, clean, kind):
    """Oracle: the undamaged recording; a neighbour's value is off by what an edge moves within a pixel."""
    frames, rng = clean_frames.copy(), np.random.default_rng(3)
    inside = np.argwhere(ndimage.binary_erosion(clean.opening.mask, iterations=3))
    broken = [tuple(int(i) for i in pixel) for pixel in inside[:: len(inside) // 9]]
    broken.append((broken[4][0], broken[4][1] + 1))  # two side by side
    for row, column in broken:
        if kind == "stuck":
            frames[:, row, column] = 7000
        elif kind == "dead":
            frames[:, row, column] = rng.normal(300, 5, 1000).astype(np.uint16)
        elif kind == "half":
            frames[:, row, column] = (4950 + 0.3 * (frames[:, row, column] - 4950.0)).astype(np.uint16)
        else:
            frames[:, row, column] = (
                (frames[:, row, column] + rng.normal(0, 300, 1000)).clip(0, 65535).astype(np.uint16)
            )
    found = reduced(frames)
    if kind == "noisy":
        assert len(set(broken) - {tuple(p) for p in np.argwhere(found.opening.bad)}) <= 1  # one of the two side by side
    else:
        assert {tuple(p) for p in np.argwhere(found.opening.bad)} == set(broken)
    assert np.array_equal(found.opening.mask, clean.opening.mask)
    assert found.shutter_events == ()
    if kind != "noisy":
        np.testing.assert_allclose(found.rows.row_sum_dn, clean.rows.row_sum_dn, atol=0.5 * 950)
    assert "replaced by neighbours in the same row" in found.findings[0].sentence()
    _check_by_brute_force(frames, found)
    rows, columns = slice(*found.opening.roi[:2]), slice(*found.opening.roi[2:])
    assert np.array_equal(found.contrast.good, ~found.opening.bad[rows, columns])


def test_a_dead_row_is_left_out(reduced, clean_frames, clean):
    """Oracle: by hand; one row of the opening stuck, another one in its left half."""
    frames = clean_frames.copy()
    frames[:, 20] = 5000
    frames[:, 26, :40] = 5000
    assert np.mean(reduced(frames).opening.mask != clean.opening.mask) < 2e-3
    found = reduced(frames, before=clean.opening)
    assert set(clean.rows.row_px) - set(found.rows.row_px) == {20, 26}
    assert any(
        "image rows 20, 26 left out: they have too few live pixels, or are copies" in one for one in _sentences(found)
    )
    assert found.shutter_events == ()
    both = np.isin(clean.rows.row_px, found.rows.row_px)
    np.testing.assert_allclose(found.rows.row_sum_dn, clean.rows.row_sum_dn[:, both], atol=200)


def test_dead_rows_beside_each_other_and_copies_leave_the_opening(reduced, clean_frames, clean):
    """Oracle: the undamaged recording; its mask but for pixels of the border, and its sums in the rows that are left."""
    frames = clean_frames.copy()
    frames[:, 20:22] = 5000
    frames[:, 26] = frames[:, 25]
    found = reduced(frames)
    assert set(clean.rows.row_px) - set(found.rows.row_px) == {20, 21, 25, 26}
    assert np.mean(found.opening.mask != clean.opening.mask) < 2e-3
    assert [finding.code for finding in found.findings] == ["rows-left-out"]
    found = reduced(frames, before=clean.opening)
    both = np.isin(clean.rows.row_px, found.rows.row_px)
    np.testing.assert_allclose(found.rows.row_sum_dn, clean.rows.row_sum_dn[:, both], atol=200)


def test_a_filter_that_follows_motion_is_a_doubt(reduced, clean_frames):
    """Oracle: by hand; half of each frame is the one before, where they differ by less than 60 DN."""
    frames = clean_frames[:200].astype(float)
    for before, now in pairwise(frames):
        now -= 0.5 * (now - before) * (np.abs(now - before) < 60)
    codes = [finding.code for finding in reduced(np.rint(frames).astype(np.uint16)).findings]
    assert "filter-follows-motion" in codes


_TIME_S = 0.033 * np.arange(1000)
_DRIFTS = {
    "line": 5.0 * _TIME_S,
    "falling line": -3.0 * _TIME_S,
    "exponential": 120 * np.exp(-_TIME_S / 9),
    "there and back": 40 * np.cos(TURN * _TIME_S / 40),
}


@pytest.mark.parametrize(
    ("kind", "shutter"), [("line", False), ("falling line", True), ("exponential", True), ("there and back", False)]
)
def test_drift_is_taken_off(reduced, turning, kind, shutter):
    """Oracle: the drift that was added, up to a constant, and jumps at the events."""
    drift = _DRIFTS[kind].copy()
    values = turning + drift[:, None, None]
    if shutter:
        _shut(values, 300, 316, jump=25.0)
        drift[316:] += 25.0
    found = reduced(values)
    true = drift[found.frame_index]
    np.testing.assert_allclose(found.rows.drift_dn, true - true.mean(), atol=0.4)
    assert found.rows.drift_dn.mean() == pytest.approx(0, abs=1e-9)


def test_published_sums_lose_a_straight_line_only(reduced, turning, clean):
    """Oracle: a straight drift goes from the sums over the mask; of a bent one the bend stays."""
    straight = reduced(turning + (4.0 * _TIME_S)[:, None, None], seed=1)
    np.testing.assert_allclose(
        straight.rows.mask_row_sum_dn - straight.rows.mask_row_sum_dn.mean(axis=0),
        clean.rows.mask_row_sum_dn - clean.rows.mask_row_sum_dn.mean(axis=0),
        atol=0.3 * clean.opening.mask.sum(axis=1).max() + 30,
    )
    bend = 1.0 * (_TIME_S - _TIME_S.mean()) ** 2 / 10
    bent = reduced(turning + bend[:, None, None], seed=1)
    level = (bent.rows.mask_row_sum_dn - clean.rows.mask_row_sum_dn).sum(axis=1) / clean.opening.mask.sum()
    np.testing.assert_allclose(level - level.mean(), bend - bend.mean(), atol=0.5)


@pytest.mark.parametrize(
    ("plate", "wheel", "blackbody", "colder"),
    [
        (4950, 4950, 4000, True),
        (4950, 4950, 6000, False),
        (5000, 4900, 6000, False),
        (5000, 4900, 4000, True),
        (4900, 5000, 4000, True),
        (4900, 5000, 6000, False),
    ],
)
def test_warm_and_cold_blackbodies_are_told_apart(
    reduced, paper_bolometer, paper_camera, trigger_angles, plate, wheel, blackbody, colder
):
    """Oracle: the levels that were rendered; plate and wheel need not be alike."""
    camera = paper_camera(plate_dn=float(plate), wheel_dn=float(wheel), blackbody_dn=float(blackbody))
    found = reduced(paper_bolometer(camera=camera).scene(trigger_angles(500)))
    assert found.opening.blackbody_is_colder == colder
    assert found.shutter_events == ()
    step = np.median((found.opening.open_frame_dn - found.opening.covered_frame_dn)[found.opening.mask])
    assert (step < 0) == colder


@pytest.mark.parametrize(("tau", "row_delay"), [(2e-4, -250e-6), (15e-3, 250e-6)])
def test_fast_and_slow_pixels_and_rows_read_upwards(
    reduced, paper_bolometer, paper_camera, trigger_angles, tau, row_delay
):
    """Oracle: the rendered light again, whether levels settle or not; the shutter that was closed is found."""
    camera = paper_camera(plate_dn=4950.0, blackbody_dn=4000.0)
    bolometer = paper_bolometer(camera=camera, time_constant_s=tau, row_delay_s=row_delay, delay_s=18e-3)
    values = _shut(bolometer.scene(trigger_angles(500)), 220, 240, jump=4.0)
    found = reduced(values)
    assert [(e.first_frame, e.end_frame) for e in found.shutter_events] == [pytest.approx((220, 240), abs=1)]
    assert np.mean(found.opening.mask != (bolometer.opening() > 0.5)) < 0.012


def test_a_counterclockwise_wheel_is_no_matter(reduced, paper_bolometer, paper_camera, trigger_angles):
    """Oracle: the mirrored image, rendered."""
    camera = paper_camera(plate_dn=4950.0, blackbody_dn=4000.0, clockwise=False)
    bolometer = paper_bolometer(camera=camera)
    found = reduced(bolometer.scene(trigger_angles(500)))
    assert np.mean(found.opening.mask != (bolometer.opening() > 0.5)) < 0.012
    assert found.shutter_events == ()


def test_an_opening_in_place_is_taken_over(reduced, clean_frames, turning, clean):
    """Oracle: another noise of the same scene, whose own mask differs in single pixels; one that moved by 3 px is refused."""
    found = reduced(turning, seed=77, before=clean.opening)
    assert np.array_equal(found.opening.mask, clean.opening.mask)
    assert found.opening.border_px == clean.opening.border_px
    with pytest.raises(ReductionError, match="in the recordings before"):
        reduced(np.roll(clean_frames, 3, axis=2), before=clean.opening)


def test_choices_are_obeyed(reduced, clean_frames, clean):
    """Oracle: by hand; border and region as told."""
    found = reduced(clean_frames, choices=Choices(border_px=2, roi=(2, 58, 1, 79)))
    assert found.opening.roi == (2, 58, 1, 79)
    assert found.opening.border_px == 2
    assert found.contrast.projection_dn.shape == (56, 78)
    assert found.opening.summed.sum() < clean.opening.summed.sum()
    with pytest.raises(ReductionError, match="leaves out"):
        reduced(clean_frames, choices=Choices(roi=(20, 58, 1, 79)))


@pytest.mark.parametrize("fields", [{"camera_type": "photon"}, {"readout_mode": "snapshot"}])
def test_cameras_that_lag_or_roll_have_the_same_sums(reduced, clean, clean_frames, fields):
    """Oracle: the same frames by a rolling microbolometer: how they came about is not the reduction's business."""
    found = reduced(clean_frames, **fields)
    assert (found.camera_type, found.readout_mode) == tuple(
        ({"camera_type": "microbolometer", "readout_mode": "rolling"} | fields).values()
    )
    assert found.pixels is None
    assert np.array_equal(found.rows.row_sum_dn, clean.rows.row_sum_dn)


def test_short_recordings_are_refused(reduced, clean_frames):
    """Oracle: 99 frames."""
    with pytest.raises(ReductionError, match="99 frames, at least 100 are needed"):
        reduced(clean_frames[:99])


def test_a_recording_behind_the_shutter_is_refused(reduced, turning):
    """Oracle: a level surface in all frames, and in three of four."""
    values = turning.copy()
    values[:] = 4500.0
    with pytest.raises(ReductionError, match="no opening found"):
        reduced(values)
    values = turning.copy()
    values[200:950] = 4500.0
    with pytest.raises(ReductionError, match="show what the wheel angle demands"):
        reduced(values)


def test_blank_recordings_are_refused(reduced, clean_frames):
    """Oracle: all pixels of most frames at one value."""
    frames = clean_frames.copy()
    frames[::2] = 0
    frames[1::4] = 65535
    with pytest.raises(ReductionError, match="are blank"):
        reduced(frames)


def test_nothing_but_short_stretches_is_refused(reduced, turning):
    """Oracle: a shutter that closes every 60 frames for ten."""
    values = turning.copy()
    for first in range(5, 1000, 60):
        _shut(values, first, first + 10)
    with pytest.raises(ReductionError, match="frames show the scene over 60 frames and more"):
        reduced(values)


def test_an_opening_cut_by_the_image_is_refused(reduced, clean_frames):
    """Oracle: the image cropped through the opening."""
    with pytest.raises(ReductionError, match="is cut by its border"):
        reduced(clean_frames[:, 20:])


def test_an_opening_at_the_very_border_is_warned_of(reduced, clean_frames):
    """Oracle: the image cropped so that only the blurred border is cut."""
    found = reduced(clean_frames[:, 10:])
    assert "the blurred border of the opening reaches the border of the image" in found.findings[0].sentence()


def test_too_few_rows_are_refused(reduced, paper_bolometer, paper_camera, trigger_angles):
    """Oracle: a mask seven pixels high."""
    camera = paper_camera(plate_dn=4950.0, blackbody_dn=4000.0, radii=(27.0, 33.0), opening_rad=0.35)
    with pytest.raises(ReductionError, match=r"image rows hold 6 or more live pixels of the opening, at least 8 must"):
        reduced(paper_bolometer(camera=camera).scene(trigger_angles(1000)))


def test_a_saturated_opening_is_refused(reduced, turning):
    """Oracle: values beyond the end of a 12-bit scale."""
    frames = np.clip(turning, 0, 4095).astype(np.uint16)
    with pytest.raises(ReductionError, match="the end of the scale"):
        reduced(frames, bit_depth=12)


def test_a_standing_wheel_is_refused(reduced, clean_frames):
    """Oracle: no control slots at all, as at standstill."""
    with pytest.raises(ReductionError, match="control_slot"):
        reduced(clean_frames, control_slot_ticks=np.array([7_000_000], np.int64))


def test_the_shared_sample(shared_recordings):
    """Oracle: what its frames look like: the shutter is closed in 40..57 and 190..207; nothing else happens."""
    folder = shared_recordings / "bolo"
    recording = reader.read(folder / "bolo-3Hz-0ms.nxs")
    found = recipes.reduce(recording, rig_file.read_rig(folder / "rig.toml"), choices=Choices())
    assert [(e.first_frame, e.end_frame, e.kind) for e in found.shutter_events] == [
        (40, 58, "closed"),
        (190, 208, "closed"),
    ]
    assert found.opening.blackbody_is_colder
    assert not found.opening.bad.any()
    assert found.frame_index.min() > 57
    assert np.all(np.isin(np.arange(64, 185), found.frame_index))
    assert np.all(np.isin(np.arange(214, 1000), found.frame_index))
    _check_by_brute_force(recording.frames.pick(list(range(1000))), found)


def test_references_make_rows_even(reduced, turning, paper_bolometer, flat_reference, clean):
    """Oracle: plain NumPy, frame by frame; a detector of uneven gains with references has the row sums of an even one."""
    rng = np.random.default_rng(7)
    shape = turning.shape[1:]
    gain, offset = rng.uniform(0.8, 1.2, shape), rng.normal(0, 100, shape)
    gain[25, 40] = 0.0
    raw = np.rint(paper_bolometer().noisy(turning, seed=1) * gain + offset).astype(np.uint16)
    references = flat_reference(gain, offset)
    found = reduced(raw, camera_type="photon", nonuniformity=references)
    good = gain > 0
    low, high = references.low_dn[good].mean(), references.high_dn[good].mean()
    corrected = low + (raw - references.low_dn) * np.where(good, (high - low) / np.where(good, 1000 * gain, 1), 0)
    opening, rows = found.opening, found.rows
    assert opening.bad[25, 40]
    assert opening.weight[25, 40] == 0
    assert np.mean(opening.mask != clean.opening.mask) < 2e-3
    sums = np.einsum("nij,ij->ni", corrected, opening.weight)[:, rows.row_px]
    n_pixels = opening.summed[rows.row_px].sum(axis=1)
    np.testing.assert_allclose(rows.row_sum_dn, sums - np.outer(rows.drift_dn, n_pixels), rtol=2e-6)
    box = np.s_[slice(*opening.roi[:2]), slice(*opening.roi[2:])]
    steady = corrected[:, *box] - rows.drift_dn[:, None, None]
    projection = np.einsum("n,nij->ij", found.contrast.frame_weight, steady)
    shown = found.contrast.good
    np.testing.assert_allclose(found.contrast.projection_dn[shown], projection[shown], atol=1e-6)
    np.testing.assert_allclose(found.pixel_maps["mean_dn"], corrected[:, *box].mean(axis=0), atol=1e-8)
