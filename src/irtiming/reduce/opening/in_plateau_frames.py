"""Find the mask opening in the frames: region, threshold and weights, without a hand on the mouse (Schatz 2023, 3.1.3)."""

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import ndimage

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, Mask, Pixels, Ticks
from irtiming.records.choices import Choices
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording
from irtiming.records.reduced import Histogram, Opening, Region
from irtiming.reduce import remarks
from irtiming.reduce.nonuniformity import Correction, corrected
from irtiming.reduce.opening import dead_pixels, dead_rows, mask_shape, motion, never_open, sample_frames, steady_levels
from irtiming.reduce.opening.motion import Places, SampledFrames
from irtiming.reduce.opening.steady_levels import SteadyLevels
from irtiming.reduce.remarks import doubt

_CLOSER_LOOK = 48  # frames that noise is taken from
_FAR_PX = 15  # from the opening
_PLATEAU_SHARE = 0.035  # of the frames must be within 2 % of either extreme; a triangle wave has 0.02
_EVEN = 0.5  # of the contrast: pixels with less are looked at as they are
_FOR_A_MEDIAN = 4096  # pixels of a frame
_CLOSED = 0.5  # of the swing of the liveliest pixels, half of their contrast: no glare or sway moves all others so far


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Sample:
    """A sample of frames, which they are, which show the opening wholly open and wholly covered, and what their levels do.

    ``steady`` is None where they do not follow a wheel, or no angle is known.
    """

    raw: Pixels
    index: Ticks
    seeds: Mask
    open_frames: Mask
    covered_frames: Mask
    steady: SteadyLevels | None

    @property
    def few(self) -> Pixels:
        """Some of the frames, for a closer look."""
        return self.raw[:: max(1, len(self.raw) // _CLOSER_LOOK)]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Sighting:
    """The opening, the histogram that its threshold stands in, and what is doubtful about them.

    ``noise_dn`` is that of one raw pixel from frame to frame; ``steady`` what the levels of the sample frames do, None where they
    do not follow a wheel; ``places`` where the opening lies in each part of the run, None where nothing tells.
    """

    opening: Opening
    histogram: Histogram
    noise_dn: float
    findings: tuple[Finding, ...]
    steady: SteadyLevels | None = None
    places: Places | None = None


def find(
    recording: Recording, correct: Correction, *, choices: Choices, before: Opening | None = None,
    wheel_angle_rad: Array | None = None,
) -> Sighting:  # fmt: skip
    """The opening, its region of interest, threshold and weights.

    Parameters
    ----------
    recording
        A few hundred of its frames are read.
    correct
        Non-uniformity correction.
    choices
        Region and threshold where a person set them.
    before
        The opening of an earlier recording of the same camera. Where it is still in place it is taken over: a border that
        is drawn anew each time, a pixel more here or there, would shift the delays against each other.
    wheel_angle_rad
        Shape (n_frame,), nan where unknown; tells drifting levels and unlike blades from the wheel. None: levels are taken as
        steady.

    Raises
    ------
    ReductionError
        If nothing changes in the frames, no frame shows the opening wholly open or covered, or the image cuts it.
    """
    sample = _sample(recording, correct, wheel_angle_rad)
    open_dn = mean_frame(sample.raw[sample.open_frames], correct)
    covered_dn = mean_frame(sample.raw[sample.covered_frames], correct)
    covered_dn += _apart(open_dn - covered_dn, sample)
    step = float(np.median((open_dn - covered_dn)[sample.seeds]))
    contrast = _filled((open_dn - covered_dn) / step, correct.bad)
    mended = dead_pixels.mended(contrast)
    mask = mask_shape.largest_part((ndimage.uniform_filter(mended, 3) > 0.5) & (mended > 0.3))
    border_px = mask_shape.border_px(mended, mask)
    if before is not None and mask_shape.is_in_place(mask, before.mask):
        mask, border_px = before.mask, before.border_px
    border_px = border_px if choices.border_px is None else choices.border_px
    roi = choices.roi or mask_shape.box(mask, margin=border_px + 4, name=recording.name)
    mask_shape.check_roi(roi, mask, name=recording.name)
    in_roi = np.zeros_like(mask)
    in_roi[slice(*roi[:2]), slice(*roi[2:])] = True
    dead_rows.refuse_wide_gaps(correct.bad, mask, name=recording.name)
    summed = in_roi & (ndimage.distance_transform_edt(~mask) <= border_px)
    bad = correct.bad | _bad(sample, contrast, mask=mask, summed=summed, roi=roi, correct=correct)
    histogram = _histogram(open_dn, mask, in_roi=in_roi, choices=choices, bad=bad)
    found = Opening(
        roi=roi, open_frame_dn=open_dn, covered_frame_dn=covered_dn, mask=mask, summed=summed,
        weight=dead_pixels.weights(summed, bad), border_px=border_px, bad=bad,
        blackbody_is_colder=not histogram.blackbody_dn > histogram.plate_dn, histogram=histogram,
    )  # fmt: skip
    noise = sample_frames.noise_dn(sample.few, ~summed)
    return Sighting(
        opening=found, histogram=histogram, noise_dn=noise, steady=sample.steady,
        findings=_doubts(recording, found, histogram, new=bad & ~correct.bad),
        places=_places(sample, found, correct, wheel_angle_rad),
    )  # fmt: skip


def _bad(sample: _Sample, contrast: Array, *, mask: Mask, summed: Mask, roi: Region, correct: Correction) -> Mask:
    """Summed pixels that do not follow the wheel, or blink, whatever references say of them, shape (row, column)."""
    box, bad = np.s_[slice(*roi[:2]), slice(*roi[2:])], np.zeros_like(mask)
    known = correct.within(roi)
    follows = np.where(known.bad, 0.0, contrast[box])
    live = corrected(sample.few[:, *box], known)
    # Gains that no reference told would look like blinking.
    even: Array = live / np.where(follows > _EVEN, follows, 1.0)
    bad[box] = dead_pixels.find(even, follows, mask=mask[box], summed=summed[box])
    return bad


def _filled(contrast: Array, bad: Mask) -> Array:
    """Contrast, shape (row, column), with what is beside bad pixels and dead rows in their place."""
    dead = dead_rows.of(bad)
    filled = dead_rows.filled(contrast, dead)
    return np.where(bad & ~dead[:, None], ndimage.median_filter(filled, 5), filled)


def _places(sample: _Sample, found: Opening, correct: Correction, wheel_angle_rad: Array | None) -> Places | None:
    if wheel_angle_rad is None:
        return None
    good = np.ones(sample.index.size, bool) if sample.steady is None else ~sample.steady.is_odd
    sampled = SampledFrames(values=sample.raw, angle_rad=wheel_angle_rad[sample.index], index=sample.index, good=good)
    return motion.places(sampled, found, gain=correct.gain)


def _histogram(open_dn: Array, mask: Mask, *, in_roi: Mask, choices: Choices, bad: Mask) -> Histogram:
    plate, blackbody = _peaks(open_dn, mask, in_roi)
    threshold = choices.threshold_dn
    if threshold is None:
        threshold = plate + choices.threshold_level * (blackbody - plate)
    count, bins = np.histogram(open_dn[in_roi & ~bad], bins=128)
    return Histogram(
        threshold_dn=threshold, plate_dn=plate, blackbody_dn=blackbody, bin_edges_dn=bins, count=count.astype(np.int64)
    )


def _doubts(recording: Recording, opening: Opening, found: Histogram, *, new: Mask) -> tuple[Finding, ...]:
    """What is odd in the opening of a recording, and in its histogram; ``new`` pixels are bad, and references do not say so."""
    doubts = []
    if (dead := dead_rows.of(opening.bad) & opening.summed.any(axis=1)).any():
        instead = ", with the rows above and below in their place"
        doubts.append(remarks.rows_left_out(recording, np.flatnonzero(dead), instead=instead))
    if new.any():
        doubts.append(remarks.pixels_replaced(recording, int(new.sum()), by="those around them"))
    low, high = sorted((found.plate_dn, found.blackbody_dn))
    if not low < found.threshold_dn < high:
        peaks = f"{found.plate_dn:.0f} and {found.blackbody_dn:.0f} DN"
        what = f"threshold {found.threshold_dn:.0f} DN lies outside the histogram peaks {peaks}"
        doubts.append(doubt(code="threshold-outside-peaks", recording=recording, what=what))
    return tuple(doubts)


def _sample(recording: Recording, correct: Correction, wheel_angle_rad: Array | None) -> _Sample:
    raw, picked = _alive(recording, np.array(sample_frames.indices(recording.frames.shape)))
    swing = _swing(raw, correct)
    if (closed := _of_another_level(raw, swing)).any():
        raw, picked = raw[~closed], picked[~closed]
        swing = _swing(raw, correct)
    seeds = _changing_pixels(swing, correct, recording.name)
    values = np.array([corrected(frame, correct)[seeds].mean() for frame in raw])
    around = (
        ndimage.binary_dilation(seeds, iterations=12) & ~ndimage.binary_dilation(seeds, iterations=5) & ~correct.bad
    )
    first, (low, high) = corrected(raw[0], correct), (float(values.min()), float(values.max()))
    surroundings = first[around].mean() if around.any() else low
    bright_when_open = abs(high - surroundings) >= abs(low - surroundings)
    angle = None if wheel_angle_rad is None else wheel_angle_rad[picked]
    steady = None
    if angle is not None:
        place = picked / recording.frames.shape[0]
        steady = steady_levels.find(values, angle, place=place, is_colder=not bright_when_open)
    level = steady.steadied(values) if steady is not None and steady.is_disturbed else values
    alike = np.ones(level.size, bool) if steady is None else ~steady.is_odd
    near = 0.02 * float(np.ptp(level[alike]))
    tops, bottoms = alike & (level > level[alike].max() - near), alike & (level < level[alike].min() + near)
    for plateau, word in ((tops, "brightest"), (bottoms, "darkest")):
        if plateau.mean() < _PLATEAU_SHARE or plateau.sum() < 3:
            glare = _follows(raw, values, around=around, correct=correct)
            why = never_open.diagnosis(steady, angle, glare=glare)
            raise ReductionError(
                f"{recording.name}: only {plateau.sum()} of {plateau.size} sampled frames are as bright as the {word} one "
                f"(within 2 %), at least {max(3, int(np.ceil(_PLATEAU_SHARE * plateau.size)))} are needed: the opening is "
                f"never wholly open or covered; {why}"
            )
    _refuse_saturation(recording, raw[tops][:, seeds])
    tops, bottoms = _level_part(tops, level), _level_part(bottoms, level)
    return _Sample(
        raw=raw,
        index=picked,
        seeds=seeds,
        open_frames=tops if bright_when_open else bottoms,
        covered_frames=bottoms if bright_when_open else tops,
        steady=steady,
    )


def _follows(raw: Pixels, values: Array, *, around: Mask, correct: Correction) -> float:
    """By how much pixels around the opening follow it, as a share."""
    if not around.any():
        return 0.0
    beside = np.array([corrected(frame, correct)[around].mean() for frame in raw])
    rest = values - values.mean()
    return abs(float(rest @ beside) / float(rest @ rest))


def _apart(contrast_dn: Array, sample: _Sample) -> float:
    """Contrast of the pixels far from the opening, DN, where levels drift between the open and the covered frames."""
    far = ~ndimage.binary_dilation(sample.seeds, iterations=_FAR_PX)
    is_disturbed = sample.steady is not None and sample.steady.is_disturbed
    return float(np.median(contrast_dn[far])) if is_disturbed and far.any() else 0.0


def _level_part(near: Mask, values: Array) -> Mask:
    """The frames on the level part of a plateau, without those at its corners where an edge already shows."""
    level = float(np.median(values[near]))
    spread = float(np.median(np.abs(values[near] - level)))
    return np.asarray(near & (np.abs(values - level) <= 4 * spread))


def _alive(recording: Recording, picked: Ticks) -> tuple[Pixels, Ticks]:
    """The picked frames, and which they are, without those that are constant: blanks that stand for a lost or broken frame."""
    raw = recording.frames.pick([int(i) for i in picked])
    alive = raw.reshape(len(raw), -1).min(axis=1) < raw.reshape(len(raw), -1).max(axis=1)
    if alive.mean() < 0.8:
        raise ReductionError(
            f"{recording.name}: {np.sum(~alive)} of {alive.size} sampled frames are dead (all pixels alike), at most 20 % "
            "may be; check the camera's window, integration time and transfer"
        )
    return raw[alive], picked[alive]


def _refuse_saturation(recording: Recording, bright: Pixels) -> None:
    full_scale = 2**recording.bit_depth - 1
    share = float(np.mean(bright >= full_scale))
    if share > 0.01:
        raise ReductionError(
            f"{recording.name}: {share:.0%} of the opening's pixels are saturated at {full_scale} DN in bright frames, at most "
            "1 % may be; shorten the integration time or bring the blackbody nearer to room temperature"
        )


def _changing_pixels(swing: Array, correct: Correction, name: str) -> Mask:
    """Pixels whose value swings with the wheel: those of the opening."""
    quiet, loud = float(np.median(swing)), _loud(swing)
    seeds = mask_shape.largest_part(swing > 0.6 * loud)
    n_seeds, least_dn = int(seeds.sum()), 4 * quiet + 1
    if loud < least_dn or n_seeds < 30:
        cure = "check that the camera sees mask and blackbody and that they differ by some kelvin"
        if loud < least_dn:
            raise ReductionError(
                f"{name}: no opening found: the liveliest pixels vary by {loud:.1f} DN (standard deviation), at least "
                f"{least_dn:.1f} DN must be, as the others vary by {quiet:.1f} DN; {cure}"
            )
        raise ReductionError(f"{name}: no opening found: {n_seeds} pixels side by side vary, at least 30 must; {cure}")
    return seeds & ~correct.bad


def _swing(raw: Pixels, correct: Correction) -> Array:
    """Standard deviation of each pixel over the frames, shape (row, column), smoothed; none of bad ones."""
    total = np.zeros(raw.shape[1:])
    squares = np.zeros(raw.shape[1:])
    for frame in raw:
        value = corrected(frame, correct).astype(float)
        total += value
        squares += value * value
    swing = np.sqrt(np.maximum(squares / len(raw) - (total / len(raw)) ** 2, 0))
    dead = dead_rows.of(correct.bad)
    swing = ndimage.median_filter(dead_rows.filled(swing, dead), 3)
    swing[correct.bad & ~dead[:, None]] = 0
    return np.asarray(swing)


def _loud(swing: Array) -> float:
    """Swing of the liveliest pixels, DN."""
    return float(np.quantile(swing, 0.995))


def _of_another_level(raw: Pixels, swing: Array) -> Mask:
    """Frames of a closed shutter, shape (n_frame,): their median pixel is as far off as only the opening's swing.

    It lies beyond the outer fences of all frames (Tukey), too, which are wide where the opening is more than half of the image.
    """
    step = max(1, math.isqrt(raw[0].size // _FOR_A_MEDIAN))
    level = np.median(raw[:, ::step, ::step].reshape(len(raw), -1), axis=1)
    low, high = np.quantile(level, [0.25, 0.75])
    return np.asarray(np.abs(level - (low + high) / 2) > max(3.5 * (high - low), _CLOSED * _loud(swing)))


def mean_frame(raw: Pixels, correct: Correction) -> Array:
    """Mean of corrected frames, shape (row, column), DN."""
    mean = np.zeros(raw.shape[1:])
    for frame in raw:
        mean += corrected(frame, correct)
    return mean / len(raw)


def _peaks(open_dn: Array, mask: Mask, in_roi: Mask) -> tuple[float, float]:
    """The histogram's two peaks in open frames: mask plate around the opening, blackbody inside it."""
    inside = ndimage.binary_erosion(mask, iterations=3)
    around = ~ndimage.binary_dilation(mask, iterations=3)
    bright = open_dn[inside] if inside.any() else open_dn[mask]
    dark = open_dn[around & in_roi] if (around & in_roi).any() else open_dn[around]
    return float(np.median(dark)), float(np.median(bright))
