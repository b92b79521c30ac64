"""The recipe for a snapshot photon camera, against sums over frames that were corrected one by one."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.records.choices import Choices
from irtiming.reduce import pixel_sums, recipes

CLOCK_HZ = 49_152_000


@pytest.fixture(scope="module")
def reduced(paper_wheel, recorded, rig):
    """Reduce 500 frames of a camera: ``reduced(camera, spoil=..., **fields)``; gives the reduced and the frames."""
    wheel = paper_wheel(duration_s=17.5)
    times = (recorded(wheel, n_triggers=500).camera_trigger_ticks - wheel.start) / CLOCK_HZ

    def run(camera, *, spoil=lambda frames: frames, **fields):
        frames = spoil(camera.frames(wheel.theta, times))
        return recipes.reduce(recorded(wheel, n_triggers=500, frames=frames, **fields), rig, choices=Choices()), frames

    return run


def test_sums_counts_and_projection_are_those_of_corrected_frames(reduced, paper_camera, flat_reference):
    """Oracle: plain NumPy, frame by frame: correct, weigh, compare, project; a dead pixel's neighbours stand in for it."""
    rng = np.random.default_rng(4)
    gain, offset = rng.uniform(0.7, 1.3, (60, 80)), rng.normal(0, 150, (60, 80))
    gain[22, 30] = 0.0
    references = flat_reference(gain, offset)
    found, frames = reduced(
        paper_camera(),
        spoil=lambda scene: np.rint(scene * gain + offset).astype(np.uint16),
        nonuniformity=references,
    )
    good = gain > 0
    low, high = references.low_dn[good].mean(), references.high_dn[good].mean()
    corrected = low + (frames - references.low_dn) * np.where(good, (high - low) / np.where(good, 1000 * gain, 1), 0)
    opening = found.opening
    total = np.einsum("nij,ij->n", corrected, opening.weight)
    np.testing.assert_allclose(found.pixels.pixel_sum, total, rtol=1e-6)
    rows, columns = slice(*opening.roi[:2]), slice(*opening.roi[2:])
    above = (corrected > opening.histogram.threshold_dn)[:, rows, columns] & good[rows, columns]
    assert np.array_equal(found.pixels.pixel_count, above.sum(axis=(1, 2)))
    weight = found.contrast.frame_weight
    assert abs(weight.sum()) < 1e-12
    projection = np.einsum("n,nij->ij", weight, corrected[:, rows, columns])
    shown = found.contrast.good
    np.testing.assert_allclose(found.contrast.projection_dn[shown], projection[shown], atol=1e-8)
    assert np.array_equal(shown, good[rows, columns])
    mean = corrected[:, rows, columns].mean(axis=0)
    np.testing.assert_allclose(found.pixel_maps["mean_dn"], mean, atol=1e-8)
    assert opening.weight[22, 30] == 0
    assert opening.weight.sum() == pytest.approx(opening.summed.sum())


def test_dead_rows_are_stood_in_for_by_those_above_and_below(reduced, paper_camera):
    """Oracle: the undamaged recording; its mask, the light of its sums within what changes over a gap, and the rows named."""

    def spoil(frames):
        frames[:, 20] = 5000
        frames[:, 30:33] = frames[:, 29:30]
        return frames

    clean, _ = reduced(paper_camera())
    found, _ = reduced(paper_camera(), spoil=spoil)
    assert np.mean(found.opening.mask != clean.opening.mask) < 5e-3
    assert found.opening.weight.sum() == pytest.approx(found.opening.summed.sum())
    light, whole = ((one - one.min()) / np.ptp(one) for one in (found.pixels.pixel_sum, clean.pixels.pixel_sum))
    np.testing.assert_allclose(light, whole, atol=0.02)
    told = next(one.what for one in found.findings if one.code == "rows-left-out")
    assert told.startswith("image rows 20, 29, 30, 31, 32 left out, with the rows above and below in their place: ")


def test_uncertainty_of_a_projection_is_that_of_the_noise(reduced, paper_camera):
    """Oracle: white noise of 3 DN and of rounding, added up with the frames' weights."""
    found, _ = reduced(paper_camera())
    assert found.contrast.u_dn == pytest.approx(
        np.sqrt((9 + 1 / 12) * np.sum(np.abs(found.contrast.frame_weight) ** 2) / 2), rel=0.1
    )


@pytest.mark.parametrize("value", [5000, 9000])
def test_a_lone_frame_of_something_else_leaves_the_image_alone(reduced, paper_camera, value):
    """Oracle: the recording without it; one frame shows a shutter, before which the phase of no pixel may move."""

    def shut(frames):
        frames[300] = value
        return frames

    whole, spoilt = reduced(paper_camera())[0], reduced(paper_camera(), spoil=shut)[0]
    assert np.setdiff1d(np.arange(500), spoilt.frame_index).tolist() == [300]
    assert spoilt.shutter_events == ()
    assert "run-not-steady" not in [one.code for one in spoilt.findings]
    one, other = spoilt.contrast.projection_dn, whole.contrast.projection_dn
    assert np.abs(one - other)[spoilt.contrast.good].max() < 6 * whole.contrast.u_dn


def test_a_closed_shutter_that_is_as_bright_as_the_opening_should_be_is_left_out(reduced, paper_camera):
    """Oracle: the frame that was spoilt; all of it shows the opening's own mean level, in a frame where an edge passes."""
    whole, _ = reduced(paper_camera())
    low, high = np.quantile(whole.pixels.pixel_sum, [0.02, 0.98])
    half = int(whole.frame_index[np.argmin(np.abs(whole.pixels.pixel_sum - (low + high) / 2))])

    def close(frames):
        weight = np.zeros(frames.shape[1:])
        weight[slice(*whole.opening.roi[:2]), slice(*whole.opening.roi[2:])] = whole.opening.weight[
            slice(*whole.opening.roi[:2]), slice(*whole.opening.roi[2:])
        ]
        level = np.sum(frames[half] * weight) / weight.sum()
        frames[half] = np.random.default_rng(2).normal(level, 3, frames[half].shape)
        return frames

    spoilt, _ = reduced(paper_camera(), spoil=close)
    assert np.setdiff1d(whole.frame_index, spoilt.frame_index).tolist() == [half]
    assert "odd-frames" in [one.code for one in spoilt.findings]


def test_repeated_frames_are_dropped(reduced, paper_camera):
    """Oracle: the recording without them; six frames that are the one before, and one later: seven are dropped and told."""

    def freeze(frames):
        frames[200:206], frames[400] = frames[199], frames[399]
        return frames

    whole, spoilt = reduced(paper_camera())[0], reduced(paper_camera(), spoil=freeze)[0]
    kept = np.delete(np.arange(500), [*range(200, 206), 400])
    assert spoilt.frame_index.tolist() == kept.tolist()
    assert np.array_equal(spoilt.trigger_ticks, whole.trigger_ticks[kept])
    np.testing.assert_allclose(spoilt.pixels.pixel_sum, whole.pixels.pixel_sum[kept], rtol=1e-4)
    assert spoilt.contrast.frame_weight.size == 493
    one, other = spoilt.contrast.projection_dn, whole.contrast.projection_dn
    strong = (
        np.abs(other) > 0.5 * np.abs(other).max()
    )  # pixels in the light keep their phase, which tells where the axle is
    assert np.abs(np.angle(one[strong] / other[strong])).max() < 0.05
    (finding,) = (one for one in spoilt.findings if one.code == "repeated-frames")
    assert finding.sentence() == "on paper: 7 frames dropped: the same as the frame before, pixel by pixel"


def test_frames_without_noise_are_no_repeats(reduced, paper_camera):
    """Oracle: by hand; without noise the same scene makes the same frame twice, as here when the wheel stops for a moment.

    What it shows is not what the wheel's angle demands; so it is dropped for that.
    """

    def stop(frames):
        frames[200] = frames[199]
        return frames

    found, _ = reduced(paper_camera(noise_dn=0.0), spoil=stop)
    assert np.setdiff1d(np.arange(500), found.frame_index).tolist() == [200]
    (finding,) = (one for one in found.findings if one.code in ("repeated-frames", "odd-frames"))
    assert finding.sentence() == "on paper: 1 single frame dropped: not what the wheel angle demands"


def test_a_camera_that_mostly_repeats_is_refused(reduced, paper_camera):
    """Oracle: by hand; every third frame is the one before."""

    def repeat(frames):
        frames[1::3] = frames[0:-1:3]
        return frames

    with pytest.raises(
        ReductionError, match=r"167 of 500 frames repeat the one before, at most 20% may; the camera fr"
    ):
        reduced(paper_camera(), spoil=repeat)


def test_the_findings_say_that_references_are_missing(reduced, paper_camera, flat_reference):
    """Oracle: by hand; a photon camera without references, and one with them."""
    codes = [one.code for one in reduced(paper_camera())[0].findings]
    assert codes == ["no-nonuniformity-reference"]
    flat = flat_reference(np.ones((60, 80)), np.zeros((60, 80)))
    assert reduced(paper_camera(), nonuniformity=flat)[0].findings == ()


def test_reduction_of_one_recording_is_the_same_whatever_the_blocks(paper_wheel, recorded, rig, paper_camera):
    """Oracle: the same frames in blocks of another length."""
    wheel = paper_wheel(duration_s=17.5)
    base = recorded(wheel, n_triggers=500)
    frames = paper_camera().frames(wheel.theta, (base.camera_trigger_ticks - wheel.start) / CLOCK_HZ)
    recording = recorded(wheel, n_triggers=500, frames=frames)

    class InBlocks:
        shape = frames.shape
        pick = recording.frames.pick

        def __init__(self, size):
            self.size = size

        def blocks(self):
            yield from ((first, frames[first : first + self.size]) for first in range(0, 500, self.size))

    one, other = (
        recipes.reduce(replace(recording, frames=InBlocks(size)), rig, choices=Choices()) for size in (37, 500)
    )
    assert np.array_equal(one.pixels.pixel_count, other.pixels.pixel_count)
    assert np.array_equal(one.pixels.pixel_sum, other.pixels.pixel_sum)
    np.testing.assert_allclose(one.contrast.projection_dn, other.contrast.projection_dn, atol=1e-9)


def test_a_shutter_that_closes_is_left_out_and_told(reduced, paper_camera):
    """Oracle: the frames that were spoilt: ten of a closed shutter, and levels that are 3 % of the contrast higher afterwards."""

    def close(frames):
        frames[240:250] = np.random.default_rng(1).normal(5400, 3, frames[:10].shape)
        frames[250:] += 30
        return frames

    found, whole = reduced(paper_camera(), spoil=close)[0], reduced(paper_camera())[0]
    (event,) = found.shutter_events
    assert (event.kind, whole.shutter_events) == ("closed", ())
    assert 236 <= event.first_frame <= 240
    assert 250 <= event.end_frame <= 254
    assert "shutter-closed" in [finding.code for finding in found.findings]
    assert not np.any((found.frame_index >= 240) & (found.frame_index < 250))
    assert whole.trigger_ticks.size - found.trigger_ticks.size == event.end_frame - event.first_frame
    np.testing.assert_array_equal(found.opening.mask, whole.opening.mask)


def test_a_shutter_that_moves_all_pixels_more_than_the_wheel_does_hides_no_opening(reduced, paper_camera):
    """Oracle: the opening without it; a tenth of the frames is ten times as far from the plate as the blackbody is."""

    def close(frames):
        n = len(frames) // 10
        frames[200 : 200 + n] = np.random.default_rng(1).normal(14000, 3, frames[:n].shape)
        return frames

    found, whole = reduced(paper_camera(), spoil=close)[0], reduced(paper_camera())[0]
    assert "shutter-closed" in [finding.code for finding in found.findings]
    np.testing.assert_array_equal(found.opening.mask, whole.opening.mask)
    assert found.opening.blackbody_is_colder == whole.opening.blackbody_is_colder


def test_a_jump_is_of_the_sums_which_hold_more_of_the_plate_than_the_opening(reduced, paper_camera):
    """Oracle: the recording without it; a jump of all pixels by a twelfth of the contrast, beside which frames may go."""

    def jump(frames):
        frames[250:] += 80
        return frames

    camera = paper_camera(radii=(23.0, 29.0))
    found, whole = reduced(camera, spoil=jump)[0], reduced(camera)[0]
    gone = np.setdiff1d(whole.frame_index, found.frame_index)
    assert gone.size <= 6
    assert np.all(np.abs(gone - 250) < 5)
    step, true = (one.opening.open_frame_dn - one.opening.covered_frame_dn for one in (found, whole))
    assert np.ptp((step - true)[whole.opening.mask]) < 10


def test_mean_frames_are_of_the_middle_of_a_plateau():
    """Oracle: by hand; a fifth of it is left out at either end, where an edge may touch the border."""
    start, end, level = pixel_sums._middle((6.0, 7.0, 1))
    assert (start, end, level) == (pytest.approx(6.2), pytest.approx(6.8), 1)


def test_plateaus_too_narrow_for_a_straight_line_are_no_reason_to_refuse(reduced, paper_camera, monkeypatch):
    """Oracle: the recording with its plateaus; sums do not know of the mean frames, which the sample then gives, to its noise."""
    whole, _ = reduced(paper_camera())

    def none(*_, **__):
        raise ReductionError("no plateau between 57.7 and 60.2 deg")

    monkeypatch.setattr(pixel_sums.plateaus, "find", none)
    found, _ = reduced(paper_camera())
    np.testing.assert_array_equal(found.pixels.pixel_sum, whole.pixels.pixel_sum)
    inside = found.opening.mask
    step, before = (one.open_frame_dn[inside] - one.covered_frame_dn[inside] for one in (found.opening, whole.opening))
    assert np.median(step) == pytest.approx(np.median(before), rel=0.01)
    assert not np.array_equal(step, before)


def test_full_scale_is_the_largest_number_of_so_many_bits(reduced, paper_camera):
    """Oracle: by hand; of 14 bits it is 16 383, as one frame shows; one of 16 382 is merely not what the wheel shows."""

    def spoil(frames):
        frames[100], frames[300] = 16_383, 16_382
        return frames

    told = [one.what for one in reduced(paper_camera(), spoil=spoil)[0].findings]
    assert any(
        what.startswith("1 frame dropped: more than half of the pixels are at zero or full scale") for what in told
    )
    assert "1 single frame dropped: not what the wheel angle demands" in told
