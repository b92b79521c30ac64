"""The recipe for a camera whose pixels are all read at once and do not lag: one number per frame (Schatz 2023, 3.1.2, 3.1.3)."""

from collections.abc import Callable
from dataclasses import replace
from typing import final

import numpy as np
from scipy import ndimage

from irtiming.errors import ReductionError
from irtiming.physics import robust
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.choices import Choices
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording
from irtiming.records.reduced import Opening, PixelSums, ReducedRecording, ShutterEvent
from irtiming.records.rig import Rig
from irtiming.reduce import frame_pass, nonuniformity, remarks, steadiness
from irtiming.reduce.accumulators import pixel_waves
from irtiming.reduce.accumulators.counts import Counts
from irtiming.reduce.accumulators.limits import Limits
from irtiming.reduce.accumulators.pixel_sum import PixelSum
from irtiming.reduce.accumulators.repeats import Repeats
from irtiming.reduce.frame_pass import Accumulators, Block, OfGoodFrames
from irtiming.reduce.nonuniformity import Correction
from irtiming.reduce.opening import contrast_image, dead_rows, in_plateau_frames, motion, steady_levels
from irtiming.reduce.opening.in_plateau_frames import Sighting
from irtiming.reduce.published import plateaus
from irtiming.reduce.remarks import doubt
from irtiming.reduce.wheel import frame_angles, nominal_angles
from irtiming.reduce.wheel.frame_angles import FrameAngles
from irtiming.units import counted

_DEAD_SHARE, _REPEATED_SHARE = 0.05, 0.2
_LONE_SHARE = 0.02
_ODD_COUNT = 0.2  # of the opening: by how much the number of bright pixels of a frame may be off
_MIDDLE_PART = 0.6  # of a plateau, whose mean frame is free of edges
_NEAR, _MARGIN, _SCATTERS = 2, 2, 8.0  # frames: of one event, kept away from it; of the sums' usual scatter
_FEWEST_SETTLED, _MOST_SETTLED = 5, 60


def reduce(
    recording: Recording, rig: Rig, *, choices: Choices, progress: Callable[[int], None], before: Opening | None,
    maps: bool,
) -> ReducedRecording:  # fmt: skip
    """Pixel counts and pixel sums of every frame, and the contrast of each pixel.

    Parameters
    ----------
    recording, rig, choices, progress, before, maps
        As of `recipes.reduce`.

    Raises
    ------
    ReductionError
        If the recording cannot be reduced; the message says why.
    """
    correct = dead_rows.marked(nonuniformity.correction(recording), recording)
    angles = frame_angles.of(recording, rig, reference_edge=choices.reference_edge)
    sighting = in_plateau_frames.find(
        recording, correct, choices=choices, before=before, wheel_angle_rad=angles.angle_rad
    )
    found, n_frames = sighting.opening, recording.frames.shape[0]
    thresholds = nonuniformity.raw_thresholds(sighting.histogram.threshold_dn, correct)[_box(found)]
    counts = Counts(thresholds, n_frames=n_frames)
    sums = PixelSum(found.weight[_box(found)], correct.within(found.roi), n_frames=n_frames)
    limits = Limits(2**recording.bit_depth - 1, n_frames=n_frames)
    repeats = Repeats(sighting.noise_dn, n_frames=n_frames)
    judge = _Alive(np.isfinite(angles.angle_rad), limits, repeats)
    while True:  # a second time only if frames were found bad, for those beside them to stand in for them
        known, n_known = np.where(judge.good, angles.angle_rad, np.nan), judge.good.sum()
        share = nominal_angles.share_of_turn(known, nominal_angles.samples_per_turn(recording))
        projection = contrast_image.projection(angles.angle_rad, found, share=share)
        waves = pixel_waves.of(angles, found) if maps else None
        good: list[OfGoodFrames] = [projection, waves] if waves else [projection]
        feeding = Accumulators(every=(counts, sums, limits, repeats), judge=judge, good=good)
        stretches = frame_pass.run(recording, found.roi, feeding=feeding, progress=progress, choices=choices)
        if not judge.is_shut.any() and not judge.is_odd.any():
            judge.leave_out(_far(sighting, np.where(judge.good, angles.angle_rad, np.nan), sums.total_dn, counts.count))
        if judge.good.sum() == n_known:
            break
    kept, dropped = _kept(recording, judge)
    no_drift_dn = np.zeros(int(kept.sum()))
    settled = _settled(recording, sighting, correct, np.where(kept, angles.angle_rad, np.nan), sums.total_dn)
    contrast = contrast_image.of(projection, settled, correct=correct, drift_dn=no_drift_dn, noise_dn=sighting.noise_dn)
    light_dn = judge.without_odd(sums.total_dn)
    above = thresholds.size - counts.count if found.blackbody_is_colder else counts.count
    return angles.reduced(
        stretches.segment,
        opening=settled,
        pixels=PixelSums(pixel_sum=sums.total_dn[kept], pixel_count=above[kept].astype(float)),
        contrast=contrast,
        waves=waves.found(correct=correct, drift_dn=no_drift_dn) if waves else None,
        pixel_maps={
            "mean_dn": contrast_image.mean_dn(projection, settled, correct=correct),
            "u_gain": nonuniformity.u_gain(recording, correct)[_box(settled)],
        },
        references=nonuniformity.fingerprint(recording),
        shutter_events=_shutter_events(judge),
        findings=(*sighting.findings, *dropped, *_of_run(angles, rig, sighting=sighting, light_dn=light_dn)),
    )


def _of_run(angles: FrameAngles, rig: Rig, *, sighting: Sighting, light_dn: Array) -> tuple[Finding, ...]:
    moved = motion.findings(sighting.places, rig, name=angles.recording.name)
    return (*steadiness.findings(angles, rig, light_dn=light_dn), *moved)


def _box(found: Opening) -> tuple[slice, slice]:
    return slice(*found.roi[:2]), slice(*found.roi[2:])


@final
class _Alive:
    """Frames with a wheel angle and live pixels that are not the frame before are good; one look at each frame tells.

    Not those of a closed shutter (``is_shut``), nor single ones that show something else (``is_odd``): all sums tell which.
    """

    def __init__(self, is_known: Mask, limits: Limits, repeats: Repeats) -> None:
        self.is_known, self.limits, self.repeats = is_known, limits, repeats
        self.is_shut, self.is_odd = np.zeros((2, is_known.size), bool)

    @property
    def reach(self) -> int:
        """No frame ahead has a say."""
        return 0

    @property
    def good(self) -> Mask:
        """Shape (n_frame,), of the frames that have been read."""
        return self.is_known & ~self.limits.is_dead & ~self.repeats.is_repeated & ~self.is_shut & ~self.is_odd

    def leave_out(self, far: Mask) -> None:
        """Frames that do not show what the wheel demands, shape (n_frame,): those of a shutter, and single ones."""
        near = far & (ndimage.convolve1d(far.astype(int), np.ones(2 * _NEAR + 1, int), mode="constant") > 1)
        self.is_shut, self.is_odd = _shut(near), _lone(far & ~near)

    def without_odd(self, values: Array) -> Array:
        """Values of all frames, nan in those that are odd, shape (n_frame,)."""
        return np.where(self.is_odd, np.nan, values)

    def add(self, block: Block) -> None:
        """Everything is known from others."""

    def decide(self, first: int, end: int, *, n_read: int) -> tuple[Mask, Mask]:
        """Judge frames ``first`` to ``end`` (excluded) of the ``n_read`` that have been read; none is near an event."""
        return self.good[first:end], np.zeros(min(end, n_read) - first, bool)


def _far(sighting: Sighting, angle: Array, total: Array, count: Ticks) -> Mask:
    """Frames that do not show what the wheel demands, shape (n_frame,).

    A closed shutter may look as bright as the opening should, by chance, but not in part: pixels above the threshold are all or
    none then.
    """
    if sighting.steady is None:
        return np.zeros(angle.size, bool)
    far = np.zeros(angle.size, bool)
    for values, least in ((total, steady_levels.ODD), (count.astype(float), _ODD_COUNT)):
        strays = np.abs(np.nan_to_num(sighting.steady.of_sums(values, angle).strays))
        far |= strays > max(least, _SCATTERS * robust.spread(strays))
    return far


def _shut(near: Mask) -> Mask:
    """Such frames that have others ``near`` them, and those between and beside them, shape (n_frame,)."""
    return np.asarray(ndimage.binary_dilation(ndimage.binary_closing(near, iterations=_NEAR), iterations=_MARGIN))


def _lone(alone: Mask) -> Mask:
    """Such frames with no others near, shape (n_frame,); none where there are many, for then it is not they that are odd."""
    return alone if alone.mean() <= _LONE_SHARE else np.zeros_like(alone)


def _shutter_events(judge: "_Alive") -> tuple[ShutterEvent, ...]:
    labels, n = ndimage.label(judge.is_shut)
    within = [np.flatnonzero(labels == k) for k in range(1, n + 1)]
    return tuple(
        ShutterEvent(first_frame=int(one[0]), end_frame=int(one[-1]) + 1, kind="closed") for one in within if one.size
    )


def _settled(recording: Recording, sighting: Sighting, correct: Correction, angle: Array, total: Array) -> Opening:
    """The opening with mean frames from the middle of the plateaus, where no blurred edge is near.

    The sample frames were chosen by their brightness alone: an edge that just touches the border hides
    in the noise of the sum, yet turns the image of the mask by a milliradian.
    """
    known, found = np.flatnonzero(np.isfinite(angle)), sighting.opening
    if sighting.steady is not None and sighting.steady.is_disturbed:
        total = sighting.steady.of_sums(total, angle).steady
    try:
        intervals = plateaus.find(np.mod(angle[known], TURN), total[known], name=recording.name)
    except ReductionError:  # too narrow ones: the sample frames show the opening no less
        return found
    bright_when_open = not found.blackbody_is_colder
    means = []
    for bright in (bright_when_open, not bright_when_open):
        middles = [_middle(interval) for interval in intervals if interval[2] == int(bright)]
        frames = known[np.any([plateaus.inside(angle[known], middle) for middle in middles], axis=0)]
        if frames.size < _FEWEST_SETTLED:
            return found
        picked = frames[np.linspace(0, frames.size - 1, min(frames.size, _MOST_SETTLED)).astype(int)]
        means.append(in_plateau_frames.mean_frame(recording.frames.pick([int(i) for i in picked]), correct))
    return replace(found, open_frame_dn=means[0], covered_frame_dn=means[1])


def _middle(interval: plateaus.Plateau) -> plateaus.Plateau:
    start, end, level = interval
    margin = (1 - _MIDDLE_PART) / 2 * (end - start)
    return start + margin, end - margin, level


def _kept(recording: Recording, judge: _Alive) -> tuple[Mask, tuple[Finding, ...]]:
    """Good frames, and a finding for each kind that was dropped."""
    outside, dead = ~judge.is_known, judge.limits.is_dead
    again = judge.repeats.is_repeated & ~dead
    dropped = [*remarks.without_angle(recording, outside)]
    dropped.extend(remarks.shutter_closed(recording, event) for event in _shutter_events(judge))
    if judge.is_odd.any():
        dropped.append(remarks.odd_frames(recording, judge.is_odd))
    if dead.any():
        what = f"{counted(int(dead.sum()), 'frame')} dropped: more than half of the pixels are at zero or full scale"
        dropped.append(doubt(code="dead-frames", recording=recording, what=what))
    if again.any():
        what = f"{counted(int(again.sum()), 'frame')} dropped: the same as the frame before, pixel by pixel"
        dropped.append(doubt(code="repeated-frames", recording=recording, what=what))
    if dead.mean() > _DEAD_SHARE:
        raise ReductionError(
            f"{recording.name}: {dead.sum()} of {dead.size} frames are dead or saturated, at most {_DEAD_SHARE:.0%} may be; "
            "check the integration time and the camera's transfer"
        )
    if again.mean() > _REPEATED_SHARE:
        raise ReductionError(
            f"{recording.name}: {again.sum()} of {again.size} frames repeat the one before, at most {_REPEATED_SHARE:.0%} may; "
            "the camera freezes or misses triggers: switch its own correction off, or trigger it more slowly"
        )
    if outside.mean() > 0.5 or judge.good.sum() < frame_pass.SHORTEST:
        raise ReductionError(
            f"{recording.name}: {outside.sum()} of {outside.size} frames were triggered outside the recorded control slots; "
            "triggers and slots must be values of the same counter over the same time"
        )
    return judge.good, (*dropped, *remarks.lost_frames(recording))
