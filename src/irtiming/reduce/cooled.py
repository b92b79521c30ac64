"""The recipe for a snapshot photon camera: one recording in, one number per frame out (Schatz 2023, 3.1.2, 3.1.3)."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, Ticks
from irtiming.records.choices import Choices
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording
from irtiming.records.reduced import Opening, PixelSums, ReducedRecording
from irtiming.records.rig import Rig
from irtiming.reduce import (
    axle_view,
    dead_pixels,
    kernels,
    nominal_angles,
    nonuniformity,
    opening,
    plateaus,
    remarks,
    wheel_angles,
)
from irtiming.reduce.nonuniformity import Correction
from irtiming.reduce.opening import Sighting
from irtiming.reduce.remarks import doubt

_DEAD_SHARE = 0.05
_FEWEST_FRAMES = 100
_MIDDLE_PART = 0.6  # of a plateau, whose mean frame is free of edges
_FEWEST_SETTLED, _MOST_SETTLED = 5, 60


@final
@dataclass(kw_only=True)
class _Tally:
    """What the single pass over the frames gathers."""

    count: list[Ticks] = field(default_factory=list)
    total: list[Array] = field(default_factory=list)
    zeros: list[Ticks] = field(default_factory=list)
    full: list[Ticks] = field(default_factory=list)
    harmonic: Array
    turning: Array = field(default_factory=lambda: np.zeros(2))


def reduce(
    recording: Recording, rig: Rig, *, choices: Choices, progress: Callable[[int], None] = lambda n: None,
    before: Opening | None = None,
) -> ReducedRecording:  # fmt: skip
    """Pixel counts and pixel sums of every frame, and the wheel's track.

    Parameters
    ----------
    recording
        Photon camera, snapshot; its frames are read once in a stream, after a look at some of them.
    rig
        As measured by its owner.
    choices, progress
        What a person decided instead of the automatic choice; what is given the number of frames done so far.
    before
        Opening of an earlier recording of the same camera, taken over where it is still in place.

    Raises
    ------
    ReductionError
        If the recording cannot be reduced; the message says why.
    """
    _check(recording)
    correct = nonuniformity.correction(recording)
    learned, equal = wheel_angles.both_tracks(recording, rig, reference_edge=choices.reference_edge)
    triggers = wheel_angles.frame_trigger_ticks(recording)
    angle = wheel_angle_rad(recording.trigger_delay_time_set_s, learned, at_ticks=triggers)
    sighting = opening.find(recording, correct, choices=choices, before=before)
    found = sighting.opening
    tally, dead = _measured_alive(recording, sighting, correct, angle, progress)
    count, total = _gathered(tally, found)
    kept, dropped = _kept(recording, angle, dead)
    settled = _settled(recording, found, correct, np.where(kept, angle, np.nan), total)
    gain = correct.gain[slice(*found.roi[:2]), slice(*found.roi[2:])]
    axle = axle_view.locate(_without_mean(tally, found, correct), settled, pixel_gain=gain, rig=rig)
    return ReducedRecording(
        name=recording.name,
        source=recording.source,
        sha256=recording.sha256,
        camera_type=recording.camera_type,
        readout_mode=recording.readout_mode,
        n_frames=recording.frames.shape[0],
        trigger_ticks=triggers[kept],
        frame_index=np.flatnonzero(kept),
        segment=np.zeros(int(kept.sum()), np.int64),
        samples_per_turn=nominal_angles.samples_per_turn(recording),
        track=learned,
        equal_track=equal,
        opening=settled,
        pixels=PixelSums(pixel_sum=total[kept], pixel_count=count[kept].astype(float)),
        axle=axle,
        integration_time_s=recording.integration_time_s,
        trigger_delay_time_set_s=recording.trigger_delay_time_set_s,
        rotation_speed_hz=recording.rotation_speed_hz,
        blackbody_temperature_k=recording.blackbody_temperature_k,
        findings=(*remarks.of_input(recording, learned), *sighting.findings, *dropped),
    )


def _check(recording: Recording) -> None:
    if recording.camera_type != "photon" or recording.readout_mode != "snapshot":
        raise ReductionError(
            f"{recording.name}: a {recording.readout_mode} {recording.camera_type} camera; this analysis is for a snapshot "
            "photon camera"
        )
    wheel_angles.refuse_lost_timestamps(recording)
    if recording.frames.shape[0] < _FEWEST_FRAMES:
        raise ReductionError(
            f"{recording.name}: {recording.frames.shape[0]} frames, at least {_FEWEST_FRAMES} are needed; record a whole "
            "measurement (irtiming plan)"
        )


def _measure(
    recording: Recording, sighting: Sighting, correct: Correction, angle: Array, progress: Callable[[int], None]
) -> _Tally:
    """The single pass: counts, sums, pixels at the limits and the second harmonic of every pixel.

    Frames without a wheel angle have no part in the harmonic; each other one counts by its share of the turn, so that a lost
    frame is stood in for by its neighbours.
    """
    found = sighting.opening
    rows, columns = slice(found.roi[0], found.roi[1]), slice(found.roi[2], found.roi[3])
    thresholds = np.ascontiguousarray(
        nonuniformity.raw_thresholds(sighting.histogram.threshold_dn, correct)[rows, columns]
    )
    weight = dead_pixels.weights(found.summed, found.bad)[rows, columns]
    weights = (weight * correct.gain[rows, columns]).astype(np.float32)
    constant = float(np.sum(weight * correct.offset_dn[rows, columns]))
    full_scale = 2**recording.bit_depth - 1
    tally = _Tally(harmonic=np.zeros((2, *weights.shape)))
    share = _share_of_turn(angle, nominal_angles.samples_per_turn(recording))
    wave = np.stack([np.cos(2 * angle), np.sin(2 * angle)])
    weighted = np.where(share > 0, share * wave, 0.0).astype(np.float32)
    for first, block in recording.frames.blocks():
        part = block[:, rows, columns]
        now = slice(first, first + len(block))
        tally.count.append(kernels.count_above(part, thresholds))
        tally.total.append(kernels.weighted_sum(part, weights) + constant)
        zeros, full = kernels.count_at_limits(part, full_scale)
        tally.zeros.append(zeros)
        tally.full.append(full)
        block_harmonic = np.zeros(tally.harmonic.shape, np.float32)
        kernels.add_harmonic(part, weighted[0, now], weighted[1, now], block_harmonic)
        tally.harmonic += block_harmonic
        tally.turning += weighted[:, now].sum(axis=1, dtype=float)
        progress(first + len(block))
    return tally


def _share_of_turn(angle: Array, samples_per_turn: int) -> Array:
    """How much of the turn each frame stands for, shape (n_frame,), mean about 1; 0 for a frame without an angle.

    Frames at one nominal angle share what lies half-way to the nearest nominal angles that were seen.
    """
    known = np.isfinite(angle)
    sample = np.mod(np.rint(np.where(known, angle, 0.0) / TURN * samples_per_turn).astype(int), samples_per_turn)
    count = np.bincount(sample[known], minlength=samples_per_turn)
    seen = np.flatnonzero(count)
    if seen.size < 3:
        return known.astype(float)
    gap = np.diff(seen, append=seen[0] + samples_per_turn)
    span = np.zeros(samples_per_turn)
    span[seen] = (gap + np.roll(gap, 1)) / 2
    share = np.where(known, span[sample] / np.maximum(count[sample], 1), 0.0)
    return np.asarray(share * known.sum() / share.sum())


def _measured_alive(
    recording: Recording, sighting: Sighting, correct: Correction, angle: Array, progress: Callable[[int], None]
) -> tuple[_Tally, np.ndarray]:
    """The pass, and which frames are dead: if there are any, it is made again, for their neighbours to stand in for them."""
    tally = _measure(recording, sighting, correct, angle, progress)
    dead = _dead(np.concatenate(tally.zeros), np.concatenate(tally.full), tally.harmonic[0].size)
    if dead.any():
        tally = _measure(recording, sighting, correct, np.where(dead, np.nan, angle), progress)
    return tally, dead


def _gathered(tally: _Tally, found: Opening) -> tuple[Ticks, Array]:
    """Pixels on the open side of the threshold, and pixel sum, each of shape (n_frame,)."""
    count = np.concatenate(tally.count)
    open_side = tally.harmonic[0].size - count if found.blackbody_is_colder else count
    return open_side, np.concatenate(tally.total)


def _without_mean(tally: _Tally, found: Opening, correct: Correction) -> Array:
    """Second harmonic of the values about their mean level, so that uneven sampling of the turn does no harm."""
    rows, columns = slice(found.roi[0], found.roi[1]), slice(found.roi[2], found.roi[3])
    gain = np.where(correct.bad, 1.0, correct.gain)
    level = (0.5 * (found.open_frame_dn + found.covered_frame_dn) - correct.offset_dn) / gain
    return np.asarray(tally.harmonic - tally.turning[:, None, None] * level[rows, columns])


def _settled(recording: Recording, found: Opening, correct: Correction, angle: Array, total: Array) -> Opening:
    """The opening with mean frames from the middle of the plateaus, where no blurred edge is near.

    The frames that were looked at first were chosen by their brightness alone: an edge that just touches the border hides
    in the noise of the sum, yet turns the image of the mask by a milliradian.
    """
    known = np.flatnonzero(np.isfinite(angle))
    intervals = plateaus.find(np.mod(angle[known], TURN), total[known], name=recording.name)
    bright_when_open = not found.blackbody_is_colder
    means = []
    for bright in (bright_when_open, not bright_when_open):
        middles = [_middle(interval) for interval in intervals if interval[2] == int(bright)]
        frames = known[np.any([plateaus.inside(angle[known], middle) for middle in middles], axis=0)]
        if frames.size < _FEWEST_SETTLED:
            return found
        picked = frames[np.linspace(0, frames.size - 1, min(frames.size, _MOST_SETTLED)).astype(int)]
        means.append(opening.mean_frame(recording.frames.pick([int(i) for i in picked]), correct))
    return replace(found, open_frame_dn=means[0], covered_frame_dn=means[1])


def _middle(interval: plateaus.Plateau) -> plateaus.Plateau:
    start, end, level = interval
    margin = (1 - _MIDDLE_PART) / 2 * (end - start)
    return start + margin, end - margin, level


def _dead(zeros: Ticks, full: Ticks, n_pixels: int) -> np.ndarray:
    """Which frames have more than half of their pixels at zero or at full scale."""
    return np.asarray(np.maximum(zeros, full) > 0.5 * n_pixels)


def _kept(recording: Recording, angle: Array, dead: np.ndarray) -> tuple[np.ndarray, tuple[Finding, ...]]:
    """Frames with a wheel angle and with live pixels, and a remark for each kind that was dropped."""
    outside = ~np.isfinite(angle)
    dropped = [*remarks.without_angle(recording, outside)]
    if dead.any():
        what = f"{dead.sum()} frames dropped: more than half of their pixels are at zero or full scale"
        dropped.append(doubt(code="dead-frames", recording=recording, what=what))
    if dead.mean() > _DEAD_SHARE:
        raise ReductionError(
            f"{recording.name}: {dead.sum()} of {dead.size} frames are dead or saturated, at most {_DEAD_SHARE:.0%} may be; "
            "check the integration time and the camera's transfer"
        )
    if outside.mean() > 0.5:
        raise ReductionError(
            f"{recording.name}: {outside.sum()} of {outside.size} frames were triggered outside the recorded control slots; "
            "triggers and slots must be values of the same counter over the same time"
        )
    return ~(outside | dead), (*dropped, *remarks.lost_frames(recording))
