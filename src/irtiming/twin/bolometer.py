"""A microbolometer camera: when each row is read, what its shutter does to it, and its frames."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol, Self, final

import numpy as np
import numpy.typing as npt

from irtiming.errors import PlanError
from irtiming.records.arrays import Array, Pixels, Ticks
from irtiming.twin.clockwork import Motion
from irtiming.twin.frames import started_at_s
from irtiming.twin.lag import Fading, LaggingPicture, lagging_picture, read_rows
from irtiming.twin.noise import FixedPattern, Values, corrected_pattern, digitise, generator
from irtiming.twin.scene import BolometerTiming, Detector, Scene
from irtiming.twin.upkeep import ShutterEvent
from irtiming.twin.wide_range import WidePicture, read_wide_rows, wide_picture, wide_pixel


class Turning(Protocol):
    """What tells the angle of a wheel: a whole `Motion`, or a wheel that still turns."""

    def angle_at(self, time_s: Array) -> Array:
        """Unwrapped wheel angle, rad, at these times, any shape."""
        ...


class View(Protocol):
    """What pixels would give if there were neither shutter nor noise."""

    def show(self, row_time_s: Array, *, out: Values) -> None:
        """Signal, DN, shape (row, column), of rows that are read at these times, shape (row,), s."""
        ...


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Lens:
    """The turning wheel as lagging pixels see it."""

    shot: LaggingPicture | WidePicture
    motion: Turning
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

    def closed_by(self, event: ShutterEvent, view: View, *, rows_columns: tuple[int, int]) -> Self:
        """With one more closure, and what pixels that see ``view`` carry into it and out of it."""
        begin_s, end_s = event.start_s, event.start_s + event.duration_s
        closing, opening = np.empty(rows_columns, np.float32), np.empty(rows_columns, np.float32)
        view.show(np.full(rows_columns[0], begin_s), out=closing)
        self.cover(np.full(rows_columns[0], begin_s), signal_dn=closing)
        closing -= self.surface_dn
        view.show(np.full(rows_columns[0], end_s), out=opening)
        left = float(self.fading.left_after(np.array(event.duration_s)))
        opening = (self.surface_dn + left * closing - opening).astype(np.float32)
        closure = Closure(begin_s=begin_s, end_s=end_s, closing_dn=closing, opening_dn=opening)
        return replace(self, closures=(*self.closures, closure))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Exposure:
    """One reading of all rows.

    ``number`` fixes its noise; ``start_s`` is when row 0 is read; ``level_dn``, drift and jumps up to then; ``epoch``,
    which of the patterns is there.
    """

    number: int
    start_s: float
    level_dn: float
    epoch: int


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RollingReadout:
    """Rows behind lens and shutter, each read ``row_s``, shape (row,), later than row 0."""

    view: View
    shutter: Shutter
    row_s: Array
    patterns: tuple[FixedPattern, ...]
    seed: int

    def pattern_at(self, exposure: Exposure) -> FixedPattern:
        """Fixed pattern with the drift so far."""
        pattern = self.patterns[exposure.epoch]
        return replace(pattern, offset_dn=pattern.offset_dn + np.float32(exposure.level_dn))

    def read(self, exposure: Exposure, *, signal_dn: Values, out: Pixels) -> None:
        """Write a frame, shape (row, column), to ``out``; ``signal_dn`` is room for the work."""
        row_time_s = exposure.start_s + self.row_s
        self.view.show(row_time_s, out=signal_dn)
        self.shutter.cover(row_time_s, signal_dn=signal_dn)
        random = generator(self.seed, "frame", index=exposure.number)
        digitise(signal_dn, self.pattern_at(exposure), random=random, out=out)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BolometerShots:
    """Frames of the turning wheel, read row after row.

    Shapes: source (n_frame,), which exposure each frame shows: exposure k belongs to trigger k - 1, so that
    there is one before the first. Of the exposures, shape (n_trigger + 1,), as in `Exposure`: start_s, level_dn, epoch.
    """

    readout: RollingReadout
    source: Ticks
    start_s: Array
    level_dn: Array
    epoch: Ticks

    def __call__(self, index: int, *, signal_dn: Values, out: Pixels) -> None:
        """Read the frame out."""
        number = int(self.source[index])
        exposure = Exposure(
            number=number,
            start_s=self.start_s[number],
            level_dn=self.level_dn[number],
            epoch=int(self.epoch[number]),
        )
        self.readout.read(exposure, signal_dn=signal_dn, out=out)


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
    timing, trigger = scene.timing, scene.trigger
    if not isinstance(timing, BolometerTiming):
        raise PlanError("rolling frames from a photon camera; start from microbolometer_scene()")
    refuse_slow_readout(scene)
    period_s = trigger.camera_period_ticks / trigger.clock_frequency_hz
    set_s = round(trigger.trigger_delay_time_set_s * trigger.clock_frequency_hz) / trigger.clock_frequency_hz
    triggered_s = np.arange(-1, trigger.n_triggers, dtype=np.float64) * period_s + set_s
    jitter = generator(seed, "exposure").standard_normal(triggered_s.size)
    lens = lens_of(scene, motion, rad_per_s=2 * math.pi * trigger.wheel_hz)
    epoch, level_dn = upkeep_at(scene, triggered_s)
    return BolometerShots(
        readout=RollingReadout(
            view=lens,
            shutter=_shutter(scene, lens),
            row_s=rows_at_s(scene),
            patterns=patterns_of(scene, seed),
            seed=seed,
        ),
        source=_thawed(triggered_s, scene.correction.events)[np.asarray(kept) + 1],
        start_s=started_at_s(timing, triggered_s, jitter=jitter),
        level_dn=level_dn,
        epoch=epoch,
    )


def rows_at_s(scene: Scene) -> Array:
    """How much later than row 0 each row is read, shape (row,), s; a photon camera has one moment for all."""
    row_delay_s = scene.timing.row_delay_s if isinstance(scene.timing, BolometerTiming) else 0.0
    return np.arange(scene.detector.rows, dtype=np.float64) * row_delay_s


def upkeep_at(scene: Scene, triggered_s: Array) -> tuple[Ticks, Array]:
    """Which of the patterns is there, and jumps and drift up to then, DN, at these triggers; shapes (n_trigger,)."""
    events = scene.correction.events
    epoch = np.searchsorted([event.start_s + event.duration_s for event in events], triggered_s, side="right")
    jumps = np.cumsum([0.0, *(event.level_jump_dn for event in events)])
    return epoch, jumps[epoch] + _drift_dn(scene, triggered_s)


def lens_of(scene: Scene, motion: Turning, *, rad_per_s: float) -> Lens:
    """Linear pixels, or those that radiate; the latter leave the shutter with the shortest of their lags.

    Parameters
    ----------
    scene
        Of a microbolometer.
    motion
        Of its wheel.
    rad_per_s
        Its nominal speed.
    """
    timing = scene.timing
    if not isinstance(timing, BolometerTiming):
        raise PlanError("pixels without lag in a photon camera; start from microbolometer_scene()")
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


def surface_dn_of(scene: Scene) -> float:
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


def covers(event: ShutterEvent, time_s: Array) -> npt.NDArray[np.bool_]:
    """Whether the event is under way at these times, any shape."""
    return (time_s >= event.start_s) & (time_s < event.start_s + event.duration_s)


def _thawed(triggered_s: Array, events: tuple[ShutterEvent, ...]) -> Ticks:
    """For each exposure the one that the camera gives out: itself, or the last before it froze."""
    own = np.arange(triggered_s.size)
    for event in events:
        if event.kind == "frozen":
            own[covers(event, triggered_s)] = 0
    return np.maximum.accumulate(own)


def _drift_dn(scene: Scene, time_s: Array) -> Array:
    """Drift of all values at these times."""
    drift = scene.drift
    return drift.per_second_dn * time_s + drift.settling_dn * np.exp(-time_s / drift.settling_time_s)


def patterns_of(scene: Scene, seed: int) -> tuple[FixedPattern, ...]:
    """Pattern at the start, which belongs to the camera, and after each correction, which is chance."""
    detector, surface_dn = scene.detector, surface_dn_of(scene)
    shape = (detector.rows, detector.columns)
    first = generator(detector.pattern_seed, "correction").standard_normal(shape, dtype=np.float32)
    later = [
        generator(seed, "correction", index=1 + index).standard_normal(shape, dtype=np.float32)
        for index in range(len(scene.correction.events))
    ]
    return tuple(corrected_pattern(detector, surface_dn, residual=residual) for residual in (first, *later))


def _shutter(scene: Scene, lens: Lens) -> Shutter:
    """Every closure with what the pixels carry into it and out of it."""
    shutter = Shutter(surface_dn=surface_dn_of(scene), fading=Fading(lens.time_constant_s))
    for event in scene.correction.events:
        if event.kind == "closed":
            shutter = shutter.closed_by(event, lens, rows_columns=(scene.detector.rows, scene.detector.columns))
    return shutter
