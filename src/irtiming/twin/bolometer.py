"""A microbolometer camera: when each row is read, what its shutter does to it, and its frames."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import final

import numpy as np

from irtiming.errors import PlanError
from irtiming.records.arrays import Array, Pixels, Ticks
from irtiming.twin.clockwork import Motion
from irtiming.twin.lag import Fading, LaggingPicture, lagging_picture, read_rows
from irtiming.twin.noise import FixedPattern, Values, corrected_pattern, digitise, generator
from irtiming.twin.scene import BolometerTiming, Detector, Scene
from irtiming.twin.upkeep import ShutterEvent
from irtiming.twin.wide_range import WidePicture, read_wide_rows, wide_picture, wide_pixel


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Lens:
    """The turning wheel as lagging pixels see it."""

    shot: LaggingPicture | WidePicture
    motion: Motion
    nominal_rad_per_s: float
    time_constant_s: float

    def show(self, row_time_s: Array, *, out: Values) -> None:
        """Signal, DN, shape (row, column), of rows that are read at these times, shape (row,), s."""
        if isinstance(self.shot, WidePicture):
            read_wide_rows(self.shot, self.motion.angle_at(row_time_s), out=out)
            return
        middle = np.median(row_time_s) - np.array([0.0, self.time_constant_s])
        now, before = self.motion.angle_at(middle)
        speed = (now - before) / (self.time_constant_s * self.nominal_rad_per_s) - 1
        read_rows(self.shot, self.motion.angle_at(row_time_s), speed=speed, out=out)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Closure:
    """A closed shutter from ``begin_s`` to ``end_s``.

    Shape (row, column), DN: closing_dn, by how much the pixels are above the shutter when it closes;
    opening_dn, by how much they are above what the scene would have made of them when it opens.
    """

    begin_s: float
    end_s: float
    closing_dn: Values
    opening_dn: Values


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Shutter:
    """All closures of a run, in order, before a surface that gives ``surface_dn``."""

    surface_dn: float
    fading: Fading
    closures: tuple[Closure, ...] = ()

    def cover(self, row_time_s: Array, *, signal_dn: Values) -> None:
        """Put the shutter, or what the pixels still remember of it, over a frame (row, column)."""
        for index, closure in enumerate(self.closures):
            later = self.closures[index + 1].begin_s if index + 1 < len(self.closures) else np.inf
            closed = (row_time_s >= closure.begin_s) & (row_time_s < closure.end_s)
            opened = (row_time_s >= closure.end_s) & (row_time_s < later)
            if closed.any():
                left = self.fading.left_after(row_time_s[closed] - closure.begin_s)[:, None]
                signal_dn[closed] = self.surface_dn + left * closure.closing_dn[closed]
            if opened.any():
                left = self.fading.left_after(row_time_s[opened] - closure.end_s)[:, None]
                signal_dn[opened] += (left * closure.opening_dn[opened]).astype(np.float32)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BolometerShots:
    """Frames of the turning wheel, read row after row.

    Shapes: source (n_frame,), which exposure each frame shows: exposure k belongs to trigger k - 1, so that
    there is one before the first. Of the exposures, shape (n_trigger + 1,): start_s, when row 0 is read;
    level_dn, drift and jumps up to then; epoch, which of the patterns is there. row_s (row,): how much later
    than row 0 each row is read.
    """

    lens: Lens
    shutter: Shutter
    source: Ticks
    start_s: Array
    row_s: Array
    level_dn: Array
    epoch: Ticks
    patterns: tuple[FixedPattern, ...]
    seed: int

    def __call__(self, index: int, *, signal_dn: Values, out: Pixels) -> None:
        """Read the frame out."""
        exposure = int(self.source[index])
        row_time_s = self.start_s[exposure] + self.row_s
        self.lens.show(row_time_s, out=signal_dn)
        self.shutter.cover(row_time_s, signal_dn=signal_dn)
        pattern = self.patterns[self.epoch[exposure]]
        moved = replace(pattern, offset_dn=pattern.offset_dn + np.float32(self.level_dn[exposure]))
        digitise(signal_dn, moved, random=generator(self.seed, "frame", index=exposure), out=out)


def bolometer_shots(scene: Scene, motion: Motion, *, kept: Ticks, seed: int) -> BolometerShots:
    """Frames of one run of a scene whose timing is a microbolometer's.

    Parameters
    ----------
    scene, motion
        The rig as it truly is, and how its wheel turned.
    kept
        Shape (n_frame,): triggers whose frames arrive.
    seed
        Fixes noise, jitter and the patterns after each correction.

    Raises
    ------
    PlanError
        If the camera is no microbolometer, or reads its rows for longer than the camera period.
    """
    timing, trigger, rows = scene.timing, scene.trigger, scene.detector.rows
    if not isinstance(timing, BolometerTiming):
        raise PlanError("rolling frames from a photon camera; start from microbolometer_scene()")
    refuse_slow_readout(scene)
    period_s = trigger.camera_period_ticks / trigger.clock_frequency_hz
    set_s = round(trigger.trigger_delay_time_set_s * trigger.clock_frequency_hz) / trigger.clock_frequency_hz
    triggered_s = np.arange(-1, trigger.n_triggers, dtype=np.float64) * period_s + set_s
    jitter_s = timing.jitter_s * generator(seed, "exposure").standard_normal(triggered_s.size)
    lens = _lens(scene, timing, motion)
    events = scene.correction.events
    epoch = np.searchsorted([event.start_s + event.duration_s for event in events], triggered_s, side="right")
    jumps = np.cumsum([0.0, *(event.level_jump_dn for event in events)])
    return BolometerShots(
        lens=lens,
        shutter=_shutter(scene, lens),
        source=_thawed(triggered_s, events)[np.asarray(kept) + 1],
        start_s=triggered_s + timing.trigger_delay_s + jitter_s,
        row_s=np.arange(rows, dtype=np.float64) * timing.row_delay_s,
        level_dn=jumps[epoch] + _drift_dn(scene, triggered_s),
        epoch=epoch,
        patterns=_patterns(scene, seed),
        seed=seed,
    )


def _lens(scene: Scene, timing: BolometerTiming, motion: Motion) -> Lens:
    """Linear pixels, or those that radiate; the latter leave the shutter with the shortest of their lags."""
    rad_per_s = 2 * math.pi * scene.trigger.wheel_hz
    if timing.radiative is None:
        lag_s = timing.time_constant_s
        shot: LaggingPicture | WidePicture = _lagging_picture(_still(scene), rad_per_s * lag_s)
    else:
        shot = _wide_picture(replace(_still(scene), timing=_lag_alone(timing)), rad_per_s)
        lag_s = wide_pixel(scene).shortest_lag_s
    return Lens(shot=shot, motion=motion, nominal_rad_per_s=rad_per_s, time_constant_s=lag_s)


def _lag_alone(timing: BolometerTiming) -> BolometerTiming:
    """The lag without what differs from camera to camera or run to run besides."""
    return BolometerTiming(time_constant_s=timing.time_constant_s, radiative=timing.radiative)


def _surface_dn(scene: Scene) -> float:
    """What pixels give before the shutter."""
    if isinstance(scene.timing, BolometerTiming) and scene.timing.radiative is not None:
        return float(wide_pixel(scene).settled_dn(np.array(scene.correction.surface_k)))
    return scene.radiance.level_dn(scene.correction.surface_k)


def refuse_slow_readout(scene: Scene) -> None:
    """Refuse a microbolometer that is still reading rows when the next trigger comes.

    Raises
    ------
    PlanError
        With the times, and what to change.
    """
    timing, trigger, rows = scene.timing, scene.trigger, scene.detector.rows
    if not isinstance(timing, BolometerTiming):
        return
    readout_s = abs(timing.row_delay_s) * rows
    period_s = trigger.camera_period_ticks / trigger.clock_frequency_hz
    if not readout_s <= period_s:
        raise PlanError(
            f"reading {rows} rows every {abs(timing.row_delay_s) * 1e6:g} us takes {readout_s * 1e3:.4g} ms, longer "
            f"than the camera period of {period_s * 1e3:.4g} ms; take a smaller row delay, fewer rows or a lower "
            "frame rate"
        )


@lru_cache(maxsize=2)
def _lagging_picture(scene: Scene, lag_rad: float) -> LaggingPicture:
    """Light of each pixel; the same for every run of a rig at one speed, so kept from one run to the next."""
    return lagging_picture(scene, lag_rad)


@lru_cache(maxsize=2)
def _wide_picture(scene: Scene, rad_per_s: float) -> WidePicture:
    """The same for pixels that radiate."""
    return wide_picture(scene, rad_per_s)


def _still(scene: Scene) -> Scene:
    """The part of a scene that says what each point sees of the wheel."""
    return Scene(
        wheel=scene.wheel,
        beams=scene.beams,
        mask=scene.mask,
        optics=scene.optics,
        radiance=scene.radiance,
        detector=Detector(rows=scene.detector.rows, columns=scene.detector.columns),
    )


def _thawed(triggered_s: Array, events: tuple[ShutterEvent, ...]) -> Ticks:
    """For each exposure the one that the camera gives out: itself, or the last before it froze."""
    own = np.arange(triggered_s.size)
    for event in events:
        if event.kind == "frozen":
            within = (triggered_s >= event.start_s) & (triggered_s < event.start_s + event.duration_s)
            own[within] = 0
    return np.maximum.accumulate(own)


def _drift_dn(scene: Scene, time_s: Array) -> Array:
    """Drift of all values at these times."""
    drift = scene.drift
    return drift.per_second_dn * time_s + drift.settling_dn * np.exp(-time_s / drift.settling_time_s)


def _patterns(scene: Scene, seed: int) -> tuple[FixedPattern, ...]:
    """Pattern at the start, which belongs to the camera, and after each correction, which is chance."""
    detector, surface_dn = scene.detector, _surface_dn(scene)
    shape = (detector.rows, detector.columns)
    first = generator(detector.pattern_seed, "correction").standard_normal(shape, dtype=np.float32)
    later = [
        generator(seed, "correction", index=1 + index).standard_normal(shape, dtype=np.float32)
        for index in range(len(scene.correction.events))
    ]
    return tuple(corrected_pattern(detector, surface_dn, residual=residual) for residual in (first, *later))


def _shutter(scene: Scene, lens: Lens) -> Shutter:
    """Every closure with what the pixels carry into it and out of it."""
    surface_dn = _surface_dn(scene)
    shape = (scene.detector.rows, scene.detector.columns)
    shutter = Shutter(surface_dn=surface_dn, fading=Fading(lens.time_constant_s))
    for event in scene.correction.events:
        if event.kind != "closed":
            continue
        begin_s, end_s = event.start_s, event.start_s + event.duration_s
        closing, opening = np.empty(shape, np.float32), np.empty(shape, np.float32)
        lens.show(np.full(shape[0], begin_s), out=closing)
        shutter.cover(np.full(shape[0], begin_s), signal_dn=closing)
        closing -= surface_dn
        lens.show(np.full(shape[0], end_s), out=opening)
        left = float(shutter.fading.left_after(np.array(event.duration_s)))
        opening = (surface_dn + left * closing - opening).astype(np.float32)
        closure = Closure(begin_s=begin_s, end_s=end_s, closing_dn=closing, opening_dn=opening)
        shutter = replace(shutter, closures=(*shutter.closures, closure))
    return shutter
