"""The recipe for a rolling microbolometer camera: one recording in, one sum per frame and row out (Schatz 2023, 3.2.3)."""

from collections.abc import Callable

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, ComplexArray, Ticks
from irtiming.records.choices import Choices
from irtiming.records.finding import Finding
from irtiming.records.recording import Recording
from irtiming.records.reduced import ContrastImage, Opening, ReducedRecording, RowSums, ShutterEvent
from irtiming.records.rig import Rig
from irtiming.records.wheel_track import WheelTrack
from irtiming.reduce import (
    drift,
    nominal_angles,
    remarks,
    rolling_opening,
    row_sums,
    shutter,
    wheel_angles,
    wheel_contrast,
)
from irtiming.reduce.drift import Drift
from irtiming.reduce.remarks import doubt
from irtiming.reduce.rolling_opening import Sighting
from irtiming.reduce.row_sums import Harvest
from irtiming.reduce.shutter import Watch

_FEWEST_FRAMES = 100


def reduce(
    recording: Recording, rig: Rig, *, choices: Choices, progress: Callable[[int], None] = lambda n: None,
    before: Opening | None = None,
) -> ReducedRecording:  # fmt: skip
    """Row sums of every frame that shows the scene, the wheel's track, and the contrast of each pixel.

    Parameters
    ----------
    recording
        Microbolometer camera, rolling; its frames are read once in a stream, after a look at some of them.
    rig
        As measured by its owner.
    choices, progress
        What a person decided instead of the automatic choice; what is told the number of frames done so far.
    before
        Opening of an earlier recording of the same camera, taken over where it is still in place.

    Raises
    ------
    ReductionError
        If the recording cannot be reduced; the message says why.
    """
    _check(recording)
    learned, equal = wheel_angles.both_tracks(recording, rig, reference_edge=choices.reference_edge)
    triggers = wheel_angles.frame_trigger_ticks(recording)
    angle = wheel_angle_rad(recording.trigger_delay_time_set_s, learned, at_ticks=triggers)
    sighting = rolling_opening.find(recording, angle, choices=choices, before=before)
    watch = _watch(recording, sighting, learned)
    harvest = row_sums.gather(recording, sighting, angle=angle, watch=watch, progress=progress)
    events = shutter.events(harvest.event, harvest.zone, levels=harvest.levels)
    dropped = _dropped(recording, harvest, angle, events)
    kept = harvest.segment >= 0
    time_s = (triggers - triggers[0]) / recording.clock_frequency_hz
    rows = _steady(recording, harvest, sighting, time_s=time_s[kept], angle=angle[kept])
    return ReducedRecording(
        name=recording.name,
        source=recording.source,
        sha256=recording.sha256,
        camera_type=recording.camera_type,
        readout_mode=recording.readout_mode,
        n_frames=recording.frames.shape[0],
        trigger_ticks=triggers[kept],
        frame_index=np.flatnonzero(kept),
        segment=harvest.segment[kept],
        samples_per_turn=nominal_angles.samples_per_turn(recording),
        track=learned,
        equal_track=equal,
        opening=sighting.opening,
        rows=rows,
        contrast=_contrast(harvest, sighting, angle[kept], rows.drift_dn),
        shutter_events=events,
        integration_time_s=recording.integration_time_s,
        trigger_delay_time_set_s=recording.trigger_delay_time_set_s,
        rotation_speed_hz=recording.rotation_speed_hz,
        blackbody_temperature_k=recording.blackbody_temperature_k,
        findings=(*remarks.of_input(recording, learned), *sighting.findings, *dropped),
    )


def _edge_frame(mask_row_sum: Array) -> int:
    """Place of the kept frame whose opening is nearest to half open."""
    level = mask_row_sum.sum(axis=1)
    return int(np.argmin(np.abs(level - np.mean(np.quantile(level, [0.02, 0.98])))))


def _check(recording: Recording) -> None:
    wheel_angles.refuse_lost_timestamps(recording)
    if recording.frames.shape[0] < _FEWEST_FRAMES:
        raise ReductionError(
            f"{recording.name}: {recording.frames.shape[0]} frames, at least {_FEWEST_FRAMES} are needed; record a whole "
            "measurement (irtiming plan)"
        )


def _watch(recording: Recording, sighting: Sighting, track: WheelTrack) -> Watch:
    contrast = sighting.expected.high_dn - sighting.expected.low_dn
    rough = shutter.watch(
        contrast_dn=contrast, scatter_dn=sighting.expected.scatter_dn, longest_level_s=0.0, frame_period_s=1.0
    )
    level_rad = sighting.expected.longest_level_rad(rough.tolerance_dn)
    period_ticks = recording.camera_period_ticks or float(np.median(np.diff(recording.camera_trigger_ticks)))
    return shutter.watch(
        contrast_dn=contrast,
        scatter_dn=sighting.expected.scatter_dn,
        longest_level_s=level_rad / track.angular_frequency_rad_per_s,
        frame_period_s=float(period_ticks) / recording.clock_frequency_hz,
    )


def _dropped(
    recording: Recording, harvest: Harvest, angle: Array, events: tuple[ShutterEvent, ...]
) -> tuple[Finding, ...]:  # fmt: skip
    """What was dropped and why."""
    outside = ~np.isfinite(angle)
    found = [*remarks.without_angle(recording, outside)]
    for event in events:
        frames = f"in frames {event.first_frame} to {event.end_frame - 1}: dropped with the frames around them"
        if event.kind == "frozen":
            found.append(doubt(code="camera-frozen", recording=recording, what=f"the camera is frozen {frames}"))
        else:
            found.append(doubt(code="shutter-closed", recording=recording, what=f"the shutter is closed {frames}"))
    lone = harvest.suspicious & ~harvest.zone & ~outside
    if lone.any():
        what = f"{lone.sum()} single frames dropped: they do not show what the wheel angle demands"
        found.append(doubt(code="odd-frames", recording=recording, what=what))
    for first, end in harvest.short:
        what = f"frames {first} to {end - 1} dropped: fewer than {row_sums.SHORTEST} good frames between shutter events"
        found.append(doubt(code="short-stretch", recording=recording, what=what))
    if harvest.hopeless_row_px.size:
        rows = ", ".join(str(row) for row in harvest.hopeless_row_px)
        what = f"image rows {rows} left out: they have too few live pixels"
        found.append(doubt(code="rows-left-out", recording=recording, what=what))
    kept = int(np.sum(harvest.segment >= 0))
    if kept < _FEWEST_FRAMES:
        raise ReductionError(
            f"{recording.name}: {kept} of {angle.size} frames show the scene over {row_sums.SHORTEST} frames and more, at least "
            f"{_FEWEST_FRAMES} must ({outside.sum()} outside the control slots, {harvest.zone.sum()} at shutter events, "
            f"{lone.sum()} single bad ones); record longer, or switch the camera's own correction off"
        )
    return (*found, *remarks.lost_frames(recording))


def _drift(harvest: Harvest, sighting: Sighting, time_s: Array, angle: Array) -> Drift:
    """Drift of the quiet pixels, or of the opening itself where there are none."""
    kept = harvest.segment >= 0
    if sighting.quiet.any():
        return drift.fit(harvest.levels.quiet_dn[kept], time_s, wheel_angle_rad=None, segment=harvest.segment[kept])
    level = _mask_level(harvest, sighting)
    return drift.fit(level, time_s, wheel_angle_rad=angle, segment=harvest.segment[kept])


def _straight(harvest: Harvest, sighting: Sighting, time_s: Array, angle: Array) -> Drift:
    """Straight line through the mean over the mask, as published."""
    segment = harvest.segment[harvest.segment >= 0]
    return drift.fit(_mask_level(harvest, sighting), time_s, wheel_angle_rad=angle, segment=segment, straight=True)


def _mask_level(harvest: Harvest, sighting: Sighting) -> Array:
    """Mean over the mask in each kept frame, shape (n,), DN."""
    n_pixels = sighting.opening.mask[harvest.row_px].sum()
    return np.asarray(harvest.mask_row_sum[harvest.segment >= 0].sum(axis=1) / n_pixels)


def _steady(recording: Recording, harvest: Harvest, sighting: Sighting, *, time_s: Array, angle: Array) -> RowSums:
    """Sums over the rows without drift.

    From those over the summed pixels the drift of the quiet pixels is taken; from those over the mask the straight line, and
    the jumps at shutter events, which the paper had not.
    """
    slow, line = _drift(harvest, sighting, time_s, angle), _straight(harvest, sighting, time_s, angle)
    kept = harvest.segment >= 0
    summed, mask = (area[harvest.row_px].sum(axis=1) for area in (sighting.opening.summed, sighting.opening.mask))
    mask_row_sum = harvest.mask_row_sum[kept] - np.outer(line.level_dn, mask)
    edge_frame = _edge_frame(mask_row_sum)
    return RowSums(
        row_px=harvest.row_px,
        row_sum_dn=harvest.row_sum[kept] - np.outer(slow.level_dn, summed),
        mask_row_sum_dn=mask_row_sum,
        drift_dn=slow.level_dn,
        edge_frame_dn=recording.frames.pick([int(np.flatnonzero(kept)[edge_frame])])[0],
        edge_frame=edge_frame,
    )


def _contrast(harvest: Harvest, sighting: Sighting, angle: Array, drift_dn: Array) -> ContrastImage:
    opening = sighting.opening
    n = angle.size
    weight = _weights(angle, harvest.segment[harvest.segment >= 0])
    projection = 2 / n * harvest.projection_dn - np.sum(weight * drift_dn)
    box = np.s_[slice(*opening.roi[:2]), slice(*opening.roi[2:])]
    u_still = wheel_contrast.noise_between_neighbours(projection, ~opening.summed[box])
    return ContrastImage(
        projection_dn=projection,
        frame_weight=weight,
        u_dn=sighting.noise_dn * float(np.sqrt(2 / n)) if np.isnan(u_still) else u_still,
        good=~opening.bad[box],
        roi=opening.roi,
    )


def _weights(angle: Array, segment: Ticks) -> ComplexArray:
    """2 / n exp(-2 i theta) less its mean in each segment, shape (n,)."""
    wave = 2 / angle.size * np.exp(-2j * angle)
    count = np.bincount(segment)
    mean = (np.bincount(segment, wave.real) + 1j * np.bincount(segment, wave.imag)) / count
    return np.asarray(wave - mean[segment])
