"""Mistakes that show in the frames, in the references, or between recordings; they go into the table of `mistake_table`."""

from dataclasses import replace

import numpy as np
from scipy import ndimage

from mistake_table import Case, Pixels, mistake, put


def _moved(frames: Pixels, rows_px: Pixels, columns_px: Pixels) -> Pixels:
    """Each frame moved by its own amount, linear between pixels."""
    return np.stack([
        ndimage.shift(frame, (dy, dx), order=1, mode="nearest")
        for frame, dy, dx in zip(frames, rows_px, columns_px, strict=True)
    ])  # fmt: skip


def _share_of_run(c: Case) -> Pixels:
    return np.linspace(0.0, 1.0, 2 * c.half)


def _stepped(c: Case) -> Pixels:
    return np.where(np.arange(2 * c.half) < c.half, 0.0, 1.0)


put("image-creeps-by-3-px-along-rows", lambda c: c.seen(_moved(c.frames, 0 * _share_of_run(c), 3 * _share_of_run(c))))
put("image-creeps-by-3-px-down", lambda c: c.seen(_moved(c.frames, 3 * _share_of_run(c), 0 * _share_of_run(c))))
put("image-creeps-by-1-px-along-rows", lambda c: c.seen(_moved(c.frames, 0 * _share_of_run(c), _share_of_run(c))))
put("image-jumps-by-2-px-along-rows", lambda c: c.seen(_moved(c.frames, 0 * _stepped(c), 2 * _stepped(c))))
put("image-jumps-by-2-px-down", lambda c: c.seen(_moved(c.frames, 2 * _stepped(c), 0 * _stepped(c))))
put("image-jumps-by-10-px-down", lambda c: c.seen(_moved(c.frames, 10 * _stepped(c), 0 * _stepped(c))))


@mistake()
def image_shakes_by_1_px(c: Case) -> Case:
    """Camera or mask shake on their mounts, at a frequency of their own."""
    t = np.arange(2 * c.half)
    return c.seen(_moved(c.frames, np.cos(1.7 * t), np.sin(1.7 * t)))


@mistake()
def image_turns_by_1_degree(c: Case) -> Case:
    """The camera turns about its axis in the middle of the run."""
    frames = c.frames
    frames[c.half :] = ndimage.rotate(frames[c.half :], 1.0, axes=(1, 2), reshape=False, order=1, mode="nearest")
    return c.seen(frames)


@mistake()
def focus_creeps(c: Case) -> Case:
    """The image is blurred by up to 3 px more towards the end."""
    return c.seen(
        np.stack([ndimage.gaussian_filter(f, 3 * s) for f, s in zip(c.frames, _share_of_run(c), strict=True)])
    )


put("image-out-of-focus-4-px", lambda c: c.seen(ndimage.gaussian_filter(c.frames, (0, 4, 4))))
put("image-mirrored-left-right", lambda c: _flipped(c, 2))
put("image-mirrored-top-bottom", lambda c: _flipped(c, 1))
put("image-turned-by-180-degrees", lambda c: _flipped(c, 1, 2))


def _flipped(c: Case, *axes: int) -> Case:
    changed = c.seen(np.flip(c.frames, axes))
    if c.recording.nonuniformity is None:
        return changed
    planes = tuple(axis - 1 for axis in axes)
    return changed.references(lambda low, high: (np.flip(low, planes), np.flip(high, planes)))


@mistake()
def window_of_the_camera_read_8_rows_lower_from_the_middle_on(c: Case) -> Case:
    """Somebody changed the region of interest."""
    frames = c.frames
    frames[c.half :] = np.roll(frames[c.half :], -8, axis=1)
    return c.seen(frames)


@mistake()
def image_interlaced_columns(c: Case) -> Case:
    """Pairs of columns are exchanged, as by a wrong tap order."""
    frames = c.frames
    return c.seen(frames.reshape(*frames.shape[:2], -1, 2)[..., ::-1].reshape(frames.shape))


@mistake()
def rows_binned(c: Case) -> Case:
    """Pairs of rows hold their mean."""
    frames = c.frames
    return c.seen(np.repeat(frames.reshape(frames.shape[0], -1, 2, frames.shape[2]).mean(axis=2), 2, axis=1))


# --- values of pixels ----------------------------------------------------------------------------------------------------


def _levels(c: Case) -> tuple[float, float]:
    """Low and high end of the values that the wheel makes, DN."""
    low, high = np.percentile(c.frames, [1, 99])
    return float(low), float(high)


@mistake()
def bright_end_clipped(c: Case) -> Case:
    """The upper fifth of the contrast is beyond the converter's range."""
    low, high = _levels(c)
    return c.seen(np.minimum(c.frames, low + 0.8 * (high - low)))


@mistake()
def dark_end_clipped(c: Case) -> Case:
    """The lower fifth of the contrast is beyond the converter's range."""
    low, high = _levels(c)
    return c.seen(np.maximum(c.frames, low + 0.2 * (high - low)))


@mistake()
def gamma_0_7(c: Case) -> Case:
    """The camera's video curve is on."""
    low, high = c.frames.min(), c.frames.max()
    return c.seen(low + (high - low) * ((c.frames - low) / (high - low)) ** 0.7)


@mistake()
def gamma_0_95(c: Case) -> Case:
    """A response that is slightly bent."""
    low, high = c.frames.min(), c.frames.max()
    return c.seen(low + (high - low) * ((c.frames - low) / (high - low)) ** 0.95)


@mistake()
def scaled_to_8_bits(c: Case) -> Case:
    """Frames were saved as an 8-bit film."""
    low, high = c.frames.min(), c.frames.max()
    return c.seen(255 * (c.frames - low) / (high - low))


@mistake()
def scaled_to_8_bits_frame_by_frame(c: Case) -> Case:
    """Frames were saved as an 8-bit film, each stretched to its own range."""
    frames = c.frames
    low, high = (pick(frames, axis=(1, 2), keepdims=True) for pick in (np.min, np.max))
    return c.seen(255 * (frames - low) / (high - low))


@mistake()
def gain_controlled_by_the_mean(c: Case) -> Case:
    """The camera holds the mean of each frame."""
    frames = c.frames
    mean = frames.mean(axis=(1, 2), keepdims=True)
    return c.seen(frames * mean.mean() / mean)


@mistake()
def mean_of_each_frame_taken_off(c: Case) -> Case:
    """A high-pass in the camera: each frame has the same mean."""
    frames = c.frames
    mean = frames.mean(axis=(1, 2), keepdims=True)
    return c.seen(frames - mean + mean.mean())


@mistake()
def mean_of_each_row_taken_off(c: Case) -> Case:
    """The camera takes stripes away: each row of each frame has the mean of the run."""
    frames = c.frames
    mean = frames.mean(axis=2, keepdims=True)
    return c.seen(frames - mean + mean.mean(axis=0, keepdims=True))


put("values-wrap-at-12-bits", lambda c: c.seen(c.frames % 4096))
put("bytes-exchanged", lambda c: c.told(bit_depth=16).seen(c.frames.astype(np.uint16).byteswap().astype(float)))
put("contrast-turned-over", lambda c: c.seen(2**c.recording.bit_depth - 1 - c.frames))
put("lowest-4-bits-lost", lambda c: c.seen(c.frames // 16 * 16))
put("median-filter-in-the-camera", lambda c: c.seen(ndimage.median_filter(c.frames, (1, 3, 3))))
put("sharpened-in-the-camera", lambda c: c.seen(2 * c.frames - ndimage.gaussian_filter(c.frames, (0, 1, 1))))


@mistake()
def median_of_three_frames(c: Case) -> Case:
    """A noise filter over frames that is not linear."""
    return c.seen(ndimage.median_filter(c.frames, (3, 1, 1)))


@mistake()
def mean_of_three_frames(c: Case) -> Case:
    """Each frame is the mean of itself and the two before."""
    frames = c.frames
    frames[2:] = (frames[2:] + frames[1:-1] + frames[:-2]) / 3
    return c.seen(frames)


# --- light ---------------------------------------------------------------------------------------------------------------


def _swing(c: Case) -> Pixels:
    """What the wheel does to the mean of each frame, about its middle, shape (frame, 1, 1)."""
    mean = c.frames.mean(axis=(1, 2), keepdims=True)
    return mean - mean.mean()


def _contrast(c: Case) -> float:
    """Of an open pixel, DN."""
    return float(np.max(np.ptp(c.frames[:60], axis=0)))


@mistake()
def stray_light_5_percent_with_gradient(c: Case) -> Case:
    """Light of the opening comes back from the lens all over the image, more to one side and the top."""
    rows, columns = c.frames.shape[1:]
    y, x = np.mgrid[0:rows, 0:columns]
    swing = _swing(c)
    spread = 0.05 * _contrast(c) / np.ptp(swing) * (0.5 + x / columns + y / rows)
    return c.seen(c.frames + spread * swing)


@mistake()
def stray_light_20_percent(c: Case) -> Case:
    """Light of the opening comes back from the lens, evenly."""
    swing = _swing(c)
    return c.seen(c.frames + 0.2 * _contrast(c) / np.ptp(swing) * swing)


@mistake()
def reflection_of_the_opening(c: Case) -> Case:
    """A ghost of the opening, a tenth as bright, 12 px to the side."""
    frames = c.frames
    return c.seen(frames + 0.1 * (np.roll(frames, 12, axis=2) - frames.mean(axis=0)))


def _with_gain(c: Case, gain: Pixels) -> Case:
    """Contrast about the covered level in proportion to ``gain``, shape (frame,)."""
    frames = c.frames
    covered = np.median(frames[:60], axis=0)
    return c.seen(covered + (frames - covered) * gain[:, None, None])


put("contrast-drifts-by-5-percent", lambda c: _with_gain(c, 1 + 0.05 * _share_of_run(c)))
put("contrast-drifts-by-30-percent", lambda c: _with_gain(c, 1 - 0.3 * _share_of_run(c)))
put("blackbody-changed-in-the-middle", lambda c: _with_gain(c, 1 - 0.2 * _stepped(c)))
put("blackbody-controller-swings", lambda c: _with_gain(c, 1 + 0.05 * np.sin(20 * np.pi * _share_of_run(c))))
put("level-drifts-by-300-DN", lambda c: c.seen(c.frames + 300 * _share_of_run(c)[:, None, None]))
put(
    "level-drifts-by-5-percent-of-contrast",
    lambda c: c.seen(c.frames + 0.05 * _contrast(c) * _share_of_run(c)[:, None, None]),
)
put("level-jumps-by-half-the-contrast", lambda c: c.seen(c.frames + 0.5 * _contrast(c) * _stepped(c)[:, None, None]))


@mistake()
def lamp_flickers(c: Case) -> Case:
    """A lamp flickers in time with the mains, against the frame rate, by 2 % of the contrast."""
    return c.seen(c.frames + 0.02 * _contrast(c) * np.sin(2.09 * np.arange(2 * c.half))[:, None, None])


@mistake()
def lamp_flickers_with_the_wheel(c: Case) -> Case:
    """A lamp shines through the cutouts onto the plate: 5 % of the contrast, a quarter of a slope late."""
    swing = np.roll(_swing(c), 3, axis=0)
    return c.seen(c.frames + 0.05 * _contrast(c) / np.ptp(swing) * swing)


@mistake()
def person_walks_through(c: Case) -> Case:
    """Thirty frames show a warm hand before a third of the image."""
    frames = c.frames
    frames[200:230, :, : frames.shape[2] // 3] = frames.max() * 0.95
    return c.seen(frames)


@mistake()
def shutter_for_ten_frames(c: Case) -> Case:
    """The camera closed its shutter, and said nothing."""
    frames = c.frames
    frames[200:210] = np.median(frames[:60], axis=0) + np.random.default_rng(3).normal(0, 5, frames[200:210].shape)
    return c.seen(frames)


@mistake()
def frozen_for_ten_frames(c: Case) -> Case:
    """The same frame ten times."""
    frames = c.frames
    frames[200:210] = frames[200]
    return c.seen(frames)


@mistake()
def frames_torn(c: Case) -> Case:
    """The upper half of each frame is of the frame before, as where a buffer is read while it is written."""
    frames = c.frames
    frames[1:, : frames.shape[1] // 2] = frames[:-1, : frames.shape[1] // 2].copy()
    return c.seen(frames)


@mistake()
def a_few_frames_torn(c: Case) -> Case:
    """Ten of the frames are torn."""
    frames = c.frames
    torn = np.arange(25, 500, 50)
    frames[torn, : frames.shape[1] // 2] = frames[torn - 1, : frames.shape[1] // 2]
    return c.seen(frames)


@mistake()
def dust_on_the_mask(c: Case) -> Case:
    """A grain of 8 px covers a part of the opening's border."""
    frames = c.frames
    step = np.ptp(frames[:60], axis=0)
    y, x = np.nonzero(step > 0.5 * step.max())
    row, column = int(y.min()), int(x[y.argmin()])
    patch = np.s_[:, row : row + 8, max(0, column - 4) : column + 4]
    frames[patch] = np.min(frames[:60], axis=0)[patch[1:]]
    return c.seen(frames)


@mistake()
def half_of_the_opening_hidden(c: Case) -> Case:
    """A cable hangs before the left half of the opening."""
    frames = c.frames
    frames[:, :, : frames.shape[2] // 2] = np.median(frames[:60], axis=0)[:, : frames.shape[2] // 2]
    return c.seen(frames)


def _covered(c: Case, where: str, *, from_frame: int = 0) -> Case:
    """Something as warm as the covered wheel before a part of the opening, a little out of focus."""
    frames = c.frames
    covered, open_ = np.percentile(frames[:100], (2, 98), axis=0)
    step = ndimage.gaussian_filter(open_ - covered, 1)
    row, column = np.indices(step.shape)
    y, x = np.nonzero(step > 0.5 * np.percentile(step, 99))
    if where == "side":  # as straight as the mask's own edge, and beside it
        right = [x[y == one].max() for one in np.unique(y)]
        slope, at = np.polyfit(np.unique(y), right, 1)
        part = column > at + slope * row - 2
    elif where == "end":
        part = column > np.percentile(x, 90)
    else:
        part = np.abs(column - np.percentile(x, 75 if where == "cable aside" else 50)) < 2
    share = ndimage.gaussian_filter(part.astype(float), 0.7)
    noise = np.random.default_rng(5).normal(0, np.std(np.diff(frames[:, 0], axis=0)) / 2**0.5, frames.shape)
    hidden = (1 - share) * frames + share * (covered + noise)
    return c.seen(np.where(np.arange(len(frames))[:, None, None] >= from_frame, hidden, frames))


put("opening-covered-by-a-finger-along-its-side", lambda c: _covered(c, "side"))
put("opening-covered-by-a-finger-at-its-end", lambda c: _covered(c, "end"))
put("opening-covered-by-a-cable", lambda c: _covered(c, "cable"))
put("opening-covered-by-a-cable-aside", lambda c: _covered(c, "cable aside"))
put("opening-covered-by-a-finger-from-the-middle-on", lambda c: _covered(c, "side", from_frame=c.half))
put("opening-covered-by-a-cable-from-the-middle-on", lambda c: _covered(c, "cable aside", from_frame=c.half))


@mistake()
def blackbody_as_cold_as_the_wheel(c: Case) -> Case:
    """Next to no contrast is left."""
    covered = np.median(c.frames[:60], axis=0)
    noise = np.random.default_rng(4).normal(0, 10, c.frames.shape)
    return c.seen(covered + 0.01 * (c.frames - covered) + noise)


# --- references ----------------------------------------------------------------------------------------------------------

put("references-exchanged", lambda c: c.references(lambda low, high: (high, low)), "photon")
put(
    "references-of-another-integration-time",
    lambda c: c.references(lambda low, high: (0.5 * low, 0.5 * high)),
    "photon",
)
put("references-alike", lambda c: c.references(lambda low, high: (low, low + 0.5)), "photon")
put(
    "references-of-another-window",
    lambda c: c.references(lambda low, high: (np.roll(low, 7, 1), np.roll(high, 7, 1))),
    "photon",
)
put(
    "references-out-of-focus",
    lambda c: c.references(lambda low, high: (ndimage.gaussian_filter(low, 4), ndimage.gaussian_filter(high, 4))),
    "photon",
)
put("no-references", lambda c: c.told(nonuniformity=None), "photon")


@mistake("photon")
def high_reference_with_the_wheel_in_view(c: Case) -> Case:
    """The high reference was taken through the mask: contrast only in the opening."""
    step = np.ptp(c.frames[:60], axis=0)
    return c.references(lambda low, high: (low, np.where(step > 0.5 * step.max(), high, low + 0.05 * (high - low))))


@mistake("photon")
def references_vignetted(c: Case) -> Case:
    """The blackbody did not fill the image when the high reference was taken: 20 % less to the right."""
    x = np.linspace(0, 1, c.frames.shape[2])
    return c.references(lambda low, high: (low, low + (high - low) * (1 - 0.2 * x)))


# --- recordings together -------------------------------------------------------------------------------------------------


@mistake()
def same_recording_twice(c: Case) -> Case:
    """A copy under another name."""
    return replace(c, together=(replace(c.recording, name="copy", source="copy"),))


@mistake()
def recording_of_another_camera(c: Case) -> Case:
    """A camera of the same kind with another delay and another place."""
    return replace(c, together=(c.other("camera"),))


@mistake()
def second_recording_with_set_delay_not_stated(c: Case) -> Case:
    """25 ms were set, and the file says 0."""
    return replace(c, together=(replace(c.other("delay"), trigger_delay_time_set_s=0.0),))


@mistake()
def second_recording_after_camera_was_moved(c: Case) -> Case:
    """The camera was knocked by 4 px between the runs."""
    moved = c.other("again")
    frames = np.roll(moved.frames.pick(list(range(moved.frames.shape[0]))), 4, axis=2)
    return replace(c, together=(replace(moved, frames=type(c.recording.frames)(frames)),))


@mistake()
def second_recording_missed_its_first_trigger(c: Case) -> Case:
    """One of two runs is one trigger early."""
    late = c.other("again")
    frames = late.frames.pick(list(range(1, late.frames.shape[0])))
    late = replace(late, frames=type(c.recording.frames)(frames), frame_number=np.arange(len(frames)))
    return replace(c, together=(late,))


@mistake(harmless=True)
def two_recordings(c: Case) -> Case:
    """Nothing is wrong."""
    return replace(c, together=(c.other("again"),))


@mistake()
def clock_50_mhz_of_two_set_delays(c: Case) -> Case:
    """As the clock of one recording, with 25 ms between the two."""
    two = [replace(one, clock_frequency_hz=50e6) for one in (c.recording, c.other("delay"))]
    return replace(c, recording=two[0], together=(two[1],))
