"""Find the mask opening in frames of a rolling microbolometer camera, and what level to expect of it."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy import ndimage

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, Mask, Pixels
from irtiming.records.choices import Choices
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording
from irtiming.records.reduced import Opening
from irtiming.reduce import remarks
from irtiming.reduce.nonuniformity import Correction
from irtiming.reduce.opening import (
    dead_pixels,
    dead_rows,
    expected_level,
    mask_shape,
    motion,
    sample_frames,
    wheel_contrast,
)
from irtiming.reduce.opening.expected_level import ExpectedLevel
from irtiming.reduce.opening.motion import Places, SampledFrames
from irtiming.reduce.opening.sample_frames import SampleFrames
from irtiming.reduce.opening.wheel_contrast import Outline
from irtiming.reduce.remarks import doubt

_LIVE_SHARE = 0.5  # of the sample frames
_MARGIN_PX = 4
_AWAY_PX = 3  # from the summed pixels: there pixels may be quiet
_STILL, _STILL_NOISES = 0.002, 3.5  # of the contrast, of its noise: pixels that move less with the wheel are quiet
_FEWEST_QUIET, _QUIET_SHARE = 100, 0.02  # pixels, of the image
_QUIET_ROWS = 120  # of the image are enough: their mean has less noise than the drift has meaning
_STILLEST = 0.25  # of the pixels around: taken for quiet where hardly any is
_EXTREME_SHARE = 0.06  # of the sample frames are averaged into the open and the covered frame
_LEAST_ROWS, _LEAST_PIXELS = 8, 6
_CLOSER_LOOK = 48  # frames that pixels are judged by one by one
_MOST_SATURATED = 0.01


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Sighting:
    """The opening and what else the sample frames tell.

    ``quiet`` are the pixels that see no more of the wheel than there must be, shape (row, column), none where there are too
    few; ``expected`` the level of the opening over them (over zero where there are none); ``noise_dn`` of one pixel from frame
    to frame; ``places`` where the opening lies in each part of the run, None where too few frames tell.
    """

    opening: Opening
    quiet: Mask
    expected: ExpectedLevel
    noise_dn: float
    places: Places | None
    findings: tuple[Finding, ...]


def find(
    recording: Recording, wheel_angle_rad: Array, *, correct: Correction, choices: Choices, before: Opening | None = None
) -> Sighting:  # fmt: skip
    """The opening, its dead pixels, and the level to be expected of it.

    Parameters
    ----------
    recording, wheel_angle_rad, correct
        A few hundred frames are read; their wheel angles (n_frame,), nan where unknown; non-uniformity correction.
    choices
        Region, threshold level and border where a person set them.
    before
        The opening of an earlier recording of the same camera; where it is still in place its mask and border are taken
        over, so that all recordings sum the same pixels.

    Raises
    ------
    ReductionError
        If no opening is found, most frames show something else, or the image cuts the opening.
    """
    name = recording.name
    sample = sample_frames.look(recording, wheel_angle_rad, correct=correct)
    good = is_whole = sample.is_whole
    for _ in range(2):  # the second time without the frames that do not show the scene
        outline = wheel_contrast.outline(sample, good, threshold_level=choices.threshold_level, name=name)
        if before is not None and mask_shape.is_in_place(outline.mask, before.mask):
            outline = replace(outline, mask=before.mask, border_px=before.border_px)
        quiet = _quiet(outline) & ~correct.bad
        sample = _with_common_level(sample, quiet)
        expected = _expected(sample, outline.mask, name)
        used, good = good, expected.good & is_whole
        if np.array_equal(used, good):
            break
    border = outline.border_px if choices.border_px is None else choices.border_px
    summed = ndimage.distance_transform_edt(~outline.mask) <= border
    roi = choices.roi or mask_shape.box(outline.mask, margin=border + _MARGIN_PX, name=name)
    mask_shape.check_roi(roi, summed, name=name)
    picked = np.flatnonzero(good)[:: max(1, int(good.sum()) // _CLOSER_LOOK)]
    live = sample.values[picked]
    bad = dead_pixels.find(live, outline.contrast, mask=outline.mask, summed=summed)
    bad |= correct.bad & (summed | dead_rows.of(correct.bad)[:, None])
    dead_rows.refuse_wide_gaps(correct.bad, outline.mask, name=name)
    _refuse_few_rows(outline.mask & ~bad, name)
    _refuse_saturation(live if correct.is_none else sample.raw[picked], outline.mask & ~bad, recording)
    expected = _expected(sample, outline.mask & ~bad, name)
    good = expected.good & is_whole
    surroundings = 0.0 if quiet.any() else float(np.median(live[:, ~summed]))
    colder = abs(expected.low_dn - surroundings) > abs(expected.high_dn - surroundings)
    bright, dark = _extreme_frames(sample, good, outline.mask & ~bad)
    opening = Opening(
        roi=roi, open_frame_dn=dark if colder else bright, covered_frame_dn=bright if colder else dark, mask=outline.mask,
        summed=summed, weight=dead_pixels.row_weights(summed, bad), border_px=border, bad=bad, blackbody_is_colder=bool(colder),
    )  # fmt: skip
    noise, found = sample_frames.noise_dn(live, ~summed), _doubts(recording, summed, bad)
    return Sighting(
        opening=opening, quiet=quiet, expected=expected, noise_dn=noise, findings=found,
        places=motion.places(_sampled(sample, good, n_frames=recording.frames.shape[0]), opening),
    )  # fmt: skip


def _sampled(sample: SampleFrames, good: Mask, *, n_frames: int) -> SampledFrames:
    index = np.rint(sample.place * n_frames).astype(np.int64)
    return SampledFrames(values=sample.values, angle_rad=sample.wheel_angle_rad, index=index, good=good)


def _quiet(outline: Outline) -> Mask:
    """Pixels away from the opening that do not follow the wheel; those that follow it least where hardly any does not."""
    away = ndimage.distance_transform_edt(~outline.mask) > outline.border_px + _AWAY_PX
    fewest = max(_FEWEST_QUIET, _QUIET_SHARE * away.size)
    if away.sum() < fewest:
        return np.zeros_like(away)
    moved = np.abs(outline.harmonic)
    quiet = away & (moved < max(_STILL * outline.interior_dn, _STILL_NOISES * outline.noise_dn))
    if quiet.sum() < fewest:
        quiet = away & (moved <= np.quantile(moved[away], _STILLEST))
    thin = np.zeros_like(quiet)
    thin[:: max(1, len(quiet) // _QUIET_ROWS)] = True
    return np.asarray(quiet & thin)


def _with_common_level(sample: SampleFrames, quiet: Mask) -> SampleFrames:
    """The sample with the mean of the quiet pixels as common level, zero where there are none."""
    return replace(sample, common_dn=sample_frames.mean_within(sample.values, quiet))


def _expected(sample: SampleFrames, mask: Mask, name: str) -> ExpectedLevel:
    expected = expected_level.learn(sample.wheel_angle_rad, sample.place, level_dn=sample.level(mask))
    if expected.good.mean() < _LIVE_SHARE:
        raise ReductionError(
            f"{name}: only {expected.good.mean():.0%} of the sample frames show what the wheel angle demands, at "
            f"least {_LIVE_SHARE:.0%} must: the shutter is closed, the camera frozen, or frames are counted to wrong triggers"
        )
    return expected


def _extreme_frames(sample: SampleFrames, good: Mask, mask: Mask) -> tuple[Array, Array]:
    """Mean of the brightest and of the darkest good frames, each brought to the same common level, shape (row, column)."""
    level = sample.level(mask)
    frames = np.flatnonzero(good)
    order = frames[np.argsort(level[frames])]
    n = max(3, round(_EXTREME_SHARE * frames.size))
    middle = float(np.median(sample.common_dn[frames]))
    bright, dark = (
        sample.values[part].mean(axis=0) - float(sample.common_dn[part].mean()) + middle
        for part in (order[-n:], order[:n])
    )
    return bright, dark


def _refuse_few_rows(mask: Mask, name: str) -> None:
    pixels = mask.sum(axis=1)
    wide = int(np.sum(pixels >= _LEAST_PIXELS))
    if wide < _LEAST_ROWS:
        raise ReductionError(
            f"{name}: {wide} image rows hold {_LEAST_PIXELS} or more live pixels of the opening, at least {_LEAST_ROWS} must: "
            "the row delay is found from differences between rows; move the camera nearer or use a longer lens"
        )


def _refuse_saturation(frames: Pixels, lit: Mask, recording: Recording) -> None:
    values = frames[:, lit]
    full_scale = 2**recording.bit_depth - 1
    for limit, share in ((0, float(np.mean(values == 0))), (full_scale, float(np.mean(values >= full_scale)))):
        if share > _MOST_SATURATED:
            raise ReductionError(
                f"{recording.name}: {share:.0%} of the opening's values are {limit} DN, the end of the scale, at most "
                f"{_MOST_SATURATED:.0%} may be; bring the blackbody nearer to room temperature or change the camera's range"
            )


def _doubts(recording: Recording, summed: Mask, bad: Mask) -> tuple[Finding, ...]:
    doubts = []
    if np.concatenate([summed[0], summed[-1], summed[:, 0], summed[:, -1]]).any():
        what = "the blurred border of the opening reaches the border of the image: what lies beyond is not summed"
        doubts.append(doubt(code="opening-at-image-border", recording=recording, what=what, cure="leave more room"))
    replaced = bad & summed & ~dead_pixels.hopeless_rows(summed, bad)[:, None]
    if replaced.any():
        doubts.append(remarks.pixels_replaced(recording, int(replaced.sum()), by="neighbours in the same row"))
    return tuple(doubts)
