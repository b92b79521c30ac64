"""The recipe for cameras that lag, or read row by row: one sum per frame and row (Schatz 2023, 3.2.3)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, Mask
from irtiming.records.choices import Choices
from irtiming.records.finding import Finding
from irtiming.records.recording import FEWEST_FRAMES, Recording
from irtiming.records.reduced import Opening, ReducedRecording, RowSums, ShutterEvent
from irtiming.records.rig import Rig
from irtiming.reduce import drift, frame_pass, nonuniformity, remarks, shutter, steadiness
from irtiming.reduce.accumulators import pixel_waves, row_sums
from irtiming.reduce.accumulators.limits import Limits
from irtiming.reduce.accumulators.quiet_level import QuietLevel
from irtiming.reduce.accumulators.repeats import Repeats
from irtiming.reduce.drift import Drift
from irtiming.reduce.frame_pass import SHORTEST, Accumulators, Stretches
from irtiming.reduce.opening import contrast_image, dead_rows, in_contrast, motion
from irtiming.reduce.opening.in_contrast import Sighting
from irtiming.reduce.remarks import doubt
from irtiming.reduce.shutter import Watch
from irtiming.reduce.shutter_judge import ShutterJudge
from irtiming.reduce.wheel import frame_angles
from irtiming.reduce.wheel.frame_angles import FrameAngles


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Harvest:
    """What the pass gathers: the angles of the frames, the opening, row sums, levels and judgement, and which were kept."""

    angles: FrameAngles
    sighting: Sighting
    rows: row_sums.RowSums
    judge: ShutterJudge
    stretches: Stretches

    @property
    def kept(self) -> Mask:
        return np.asarray(self.stretches.segment >= 0)

    def drift(self, level_dn: Array, *, follows_wheel: bool, straight: bool = False) -> Drift:
        """Drift of a level of every frame, over the kept ones."""
        kept = self.kept
        angle = self.angles.angle_rad[kept] if follows_wheel else None
        segment = self.stretches.segment[kept]
        return drift.fit(
            level_dn[kept], self.angles.time_s[kept], wheel_angle_rad=angle, segment=segment, straight=straight
        )


def reduce(
    recording: Recording, rig: Rig, *, choices: Choices, progress: Callable[[int], None], before: Opening | None,
    maps: bool,
) -> ReducedRecording:  # fmt: skip
    """Row sums of every frame that shows the scene, and the contrast of each pixel.

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
    sighting = in_contrast.find(recording, angles.angle_rad, correct=correct, choices=choices, before=before)
    found, n_frames = sighting.opening, recording.frames.shape[0]
    rows = row_sums.RowSums(found, correct, n_frames=n_frames)
    limits = Limits(2**recording.bit_depth - 1, n_frames=n_frames)
    repeats = Repeats(sighting.noise_dn, n_frames=n_frames)
    watch, expected = _watch(angles, sighting), _expected_dn(angles, sighting)
    fewest = shutter.fewest_pixels(watch.tolerance_dn, noise_dn=sighting.noise_dn)
    quiet = QuietLevel(sighting.quiet, correct, n_frames=n_frames, fewest=fewest)
    judge = ShutterJudge(watch, expected, rows=rows, quiet=quiet, limits=limits, repeats=repeats)
    projection = contrast_image.projection(angles.angle_rad, found, trigger_ticks=angles.trigger_ticks)
    waves = pixel_waves.of(angles, found) if maps else None
    feeding = Accumulators(
        every=(rows, quiet, limits, repeats), judge=judge, good=(projection, *([waves] if waves else []))
    )
    stretches = frame_pass.run(recording, found.roi, feeding=feeding, progress=progress, choices=choices)
    harvest = _Harvest(angles=angles, sighting=sighting, rows=rows, judge=judge, stretches=stretches)
    events = shutter.events(judge.event, judge.zone, levels=judge.levels)
    dropped = _dropped(recording, harvest, events)
    sums = _steady(recording, harvest)
    return angles.reduced(
        stretches.segment,
        opening=found,
        rows=sums,
        contrast=contrast_image.of(
            projection, found, correct=correct, drift_dn=sums.drift_dn, noise_dn=sighting.noise_dn
        ),
        waves=waves.found(correct=correct, drift_dn=sums.drift_dn) if waves else None,
        pixel_maps={"mean_dn": contrast_image.mean_dn(projection, found, correct=correct)},
        shutter_events=events,
        findings=(
            *sighting.findings,
            *dropped,
            *steadiness.findings(angles, rig, light_dn=rows.mask_dn.sum(axis=1)),
            *motion.findings(sighting.places, rig, name=recording.name),
        ),
    )


def _expected_dn(angles: FrameAngles, sighting: Sighting) -> Array:
    """Level of the opening that each frame's wheel angle demands, shape (n_frame,), DN; nan where the angle is unknown."""
    angle = angles.angle_rad
    place = np.arange(angle.size) / angle.size
    return np.where(np.isfinite(angle), sighting.expected.at(np.nan_to_num(angle), place), np.nan)


def _watch(angles: FrameAngles, sighting: Sighting) -> Watch:
    """How the frames are judged: for as long as the expected level stays about the same, a closed shutter may look open."""
    recording, expected = angles.recording, sighting.expected
    contrast = expected.high_dn - expected.low_dn
    tolerance_dn = shutter.tolerance_dn(contrast_dn=contrast, scatter_dn=expected.scatter_dn)
    period_ticks = recording.camera_period_ticks or float(np.median(np.diff(recording.camera_trigger_ticks)))
    return shutter.watch(
        tolerance_dn,
        longest_level_s=expected.longest_level_rad(tolerance_dn) / angles.learned.angular_frequency_rad_per_s,
        frame_period_s=float(period_ticks) / recording.clock_frequency_hz,
    )


def _dropped(
    recording: Recording, harvest: _Harvest, events: tuple[ShutterEvent, ...]
) -> tuple[Finding, ...]:  # fmt: skip
    """What was dropped and why."""
    outside, judge = ~np.isfinite(harvest.angles.angle_rad), harvest.judge
    found = [*remarks.without_angle(recording, outside)]
    for event in events:
        if event.kind == "frozen":
            frames = f"in frames {event.first_frame} to {event.end_frame - 1}"
            what = f"the camera is frozen {frames}: dropped with the frames around them"
            found.append(doubt(code="camera-frozen", recording=recording, what=what))
        else:
            found.append(remarks.shutter_closed(recording, event))
    lone = judge.suspicious & ~judge.zone & ~outside
    if lone.any():
        found.append(remarks.odd_frames(recording, lone))
    for first, end in harvest.stretches.short:
        what = f"frames {first} to {end - 1} dropped: fewer than {SHORTEST} good frames between shutter events"
        found.append(doubt(code="short-stretch", recording=recording, what=what))
    if harvest.rows.hopeless_row_px.size:
        found.append(remarks.rows_left_out(recording, harvest.rows.hopeless_row_px))
    kept = int(harvest.kept.sum())
    if kept < FEWEST_FRAMES:
        raise ReductionError(
            f"{recording.name}: {kept} of {outside.size} frames show the scene over {SHORTEST} frames and more, at least "
            f"{FEWEST_FRAMES} must ({outside.sum()} outside the control slots, {judge.zone.sum()} at shutter events, "
            f"{lone.sum()} single bad ones); record longer, or switch the camera's own correction off"
        )
    return (*found, *remarks.lost_frames(recording))


def _steady(recording: Recording, harvest: _Harvest) -> RowSums:
    """Sums over the rows without drift.

    From those over the summed pixels the drift of the quiet pixels is taken, or that of the opening itself where there are
    none; from those over the mask the straight line of its mean, as published, and the jumps at shutter events, which the paper
    had not.
    """
    rows, kept = harvest.rows, harvest.kept
    level = rows.mask_dn.sum(axis=1) / rows.n_mask.sum()
    line = harvest.drift(level, follows_wheel=True, straight=True)
    if harvest.sighting.quiet.any():
        slow = harvest.drift(harvest.judge.levels.quiet_dn, follows_wheel=False)
    else:
        slow = harvest.drift(level, follows_wheel=True)
    mask_row_sum = rows.mask_dn[kept] - np.outer(line.level_dn, rows.n_mask)
    edge_frame = _edge_frame(mask_row_sum)
    return RowSums(
        row_px=rows.row_px,
        row_sum_dn=rows.summed_dn[kept] - np.outer(slow.level_dn, rows.n_summed),
        mask_row_sum_dn=mask_row_sum,
        drift_dn=slow.level_dn,
        edge_frame_dn=recording.frames.pick([int(np.flatnonzero(kept)[edge_frame])])[0],
        edge_frame=edge_frame,
    )


def _edge_frame(mask_row_sum: Array) -> int:
    """Place of the kept frame whose opening is nearest to half open."""
    level = mask_row_sum.sum(axis=1)
    return int(np.argmin(np.abs(level - np.mean(np.quantile(level, [0.02, 0.98])))))
