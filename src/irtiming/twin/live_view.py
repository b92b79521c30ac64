"""What a camera of the twin sees of a wheel that still turns: one frame at a time, made as those of a recording are.

Time is in cycles of the trigger generator's counter. A run is what comes between the start and the end of an
acquisition; its first trigger is time zero of drift and shutter events, as in `irtiming.twin.rig.recorded`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol, TypeAlias, final

import numpy as np

from irtiming.errors import PlanError
from irtiming.records.arrays import Array, Pixels
from irtiming.twin.bolometer import (
    Exposure,
    Lens,
    RollingReadout,
    Shutter,
    View,
    covers,
    lens_of,
    patterns_of,
    rows_at_s,
    surface_dn_of,
    upkeep_at,
)
from irtiming.twin.frames import BlackbodyShots, WheelShots, prepared, started_at_s, window_s
from irtiming.twin.lag import Fading, LaggingPicture, response
from irtiming.twin.noise import FixedPattern, Values, generator
from irtiming.twin.pixels import Picture, expose
from irtiming.twin.scene import BolometerTiming, CameraTiming, Radiance, Scene
from irtiming.twin.wide_range import wide_pixel

_STANDING_RAD = 0.005
"""A wheel that turns by less within a time constant stands, for pixels: it is a fraction of one of them."""

_SAME_SPEED = 0.005
_COARSEST = 1 / 8
"""Rays gathered for one speed do for another down to this part of it: it costs 1e-7 of the contrast."""

_SAME_K, _SAME_WIDE_K = 0.005, 0.1
"""Changes of the blackbody below these change no picture; one of pixels that radiate takes long to make."""

Make: TypeAlias = Callable[[Values, Pixels], None]
"""Makes one frame, (row, column), in its second argument; the first is room for the work. In any thread."""


class SeenWheel(Protocol):
    """A wheel that somebody else turns; `irtiming.twin.driven_wheel.DrivenWheel` is one."""

    @property
    def turned_until_cycle(self) -> int:
        """The present, as far as the wheel knows."""
        ...

    def angle_at(self, cycles: Array) -> Array:
        """Unwrapped wheel angle, rad, any shape; constant while it stands."""
        ...

    def speed_rad_per_s(self, cycle: int) -> float:
        """Nominal speed, 0 while it stands."""
        ...


@final
@dataclass(frozen=True, kw_only=True)
class Moment:
    """When one frame is taken: from the trigger to the end of its last row, cycles. ``number`` counts the run's, from 0.

    ``triggered_s`` and ``start_s``, after the run's first trigger: the trigger, and when the integration or row 0 begins.
    """

    number: int
    trigger_cycle: int
    start_cycle: int
    end_cycle: int
    triggered_s: float
    start_s: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Surroundings:
    """What is before the camera; ``clock_frequency_hz`` is that of all cycles.

    ``blackbody_k`` tells its temperature at a cycle. ``is_bare``: whether wheel and mask are taken out of the way.
    """

    wheel: SeenWheel
    clock_frequency_hz: int
    blackbody_k: Callable[[int], float]
    is_bare: Callable[[], bool]

    def since(self, origin_cycle: int) -> "WheelSince":
        """The wheel with seconds from a cycle on."""
        return WheelSince(self.wheel, origin_cycle, self.clock_frequency_hz)


@final
@dataclass(frozen=True)
class WheelSince:
    """A wheel whose angle is asked for in seconds from ``origin_cycle`` on."""

    wheel: SeenWheel
    origin_cycle: int
    clock_frequency_hz: int

    def angle_at(self, time_s: Array) -> Array:
        """Unwrapped wheel angle, rad, at these times, any shape."""
        return self.wheel.angle_at(self.origin_cycle + np.asarray(time_s) * self.clock_frequency_hz)


@final
class LiveRun:
    """Moments and frames of one acquisition of either kind of camera.

    `moment` is asked once for each trigger, in order; `make` likewise, when the wheel has turned until its end.
    """

    def __init__(self, scene: Scene, surroundings: Surroundings, *, seed: int) -> None:
        self._scene, self._surroundings, self._seed = scene, surroundings, seed
        self._random = generator(seed, "exposure")
        self._rows_s = rows_at_s(scene)
        self._number = 0
        self._first_cycle: int | None = None
        self._last_cycle: int | None = None
        is_rolling = isinstance(scene.timing, BolometerTiming)
        if is_rolling:
            self._random.standard_normal()  # belongs to the exposure before the first trigger
        self._view = _RollingRun(scene, surroundings, seed=seed) if is_rolling else _SnapshotRun(scene, seed=seed)

    def moment(self, trigger_cycle: int) -> Moment | None:
        """Of the frame of a trigger; None where the camera still integrates, or reads rows, of the frame before."""
        clock_hz, timing = self._surroundings.clock_frequency_hz, self._scene.timing
        window = timing.integration_time_s if isinstance(timing, CameraTiming) else float(np.ptp(self._rows_s))
        if self._last_cycle is not None and trigger_cycle - self._last_cycle < window * clock_hz:
            return None
        self._last_cycle = trigger_cycle
        if self._first_cycle is None:
            self._first_cycle = trigger_cycle
        triggered_s = np.array([(trigger_cycle - self._first_cycle) / clock_hz])
        jitter = np.array([self._random.standard_normal()])
        start_s = float(started_at_s(timing, triggered_s, jitter=jitter)[0])
        first_s, last_s = start_s + float(min(self._rows_s)), start_s + float(max(self._rows_s))
        if isinstance(timing, CameraTiming):
            last_s += timing.integration_time_s
        self._number += 1
        return Moment(
            number=self._number - 1,
            trigger_cycle=trigger_cycle,
            start_cycle=self._first_cycle + math.floor(first_s * clock_hz),
            end_cycle=self._first_cycle + math.ceil(last_s * clock_hz),
            triggered_s=float(triggered_s[0]),
            start_s=start_s,
        )

    def make(self, moment: Moment) -> Make:
        """What will make the frame of a moment that is past."""
        blackbody_k = self._surroundings.blackbody_k(moment.start_cycle)
        wheel = self._surroundings.since(self._first_cycle or 0)
        if self._surroundings.is_bare():
            level_dn, pattern = self._view.bare(moment, blackbody_k)
            shots = BlackbodyShots(level_dn=level_dn, pattern=pattern, purpose="frame", seed=self._seed)
            return lambda signal_dn, out: shots(moment.number, signal_dn=signal_dn, out=out)
        return self._view.make(moment, wheel, blackbody_k)


@final
class _SnapshotRun:
    """Frames of a photon camera."""

    def __init__(self, scene: Scene, *, seed: int) -> None:
        self._scene, self._seed = scene, seed
        self._shot, self._pattern = prepared(scene)

    def bare(self, moment: Moment, blackbody_k: float) -> tuple[float, FixedPattern]:
        """Level of the bare blackbody, DN, and the pattern of that moment."""
        return self._scene.radiance.level_dn(blackbody_k), self._pattern

    def make(self, moment: Moment, wheel: WheelSince, blackbody_k: float) -> Make:
        timing = self._scene.timing
        if not isinstance(timing, CameraTiming):
            raise PlanError("snapshots from a microbolometer camera; start from paper_scene()")
        shots = WheelShots(
            shot=_before(self._shot, self._scene.radiance, blackbody_k=blackbody_k),
            pattern=self._pattern,
            wheel_angle_rad=wheel.angle_at(np.array([moment.start_s])[:, None] + window_s(timing)),
            frame_number=np.array([moment.number], dtype=np.int64),
            seed=self._seed,
        )
        return lambda signal_dn, out: shots(0, signal_dn=signal_dn, out=out)


@final
class _RollingRun:
    """Frames of a microbolometer camera."""

    def __init__(self, scene: Scene, surroundings: Surroundings, *, seed: int) -> None:
        self._scene, self._surroundings, self._seed = scene, surroundings, seed
        self._patterns = patterns_of(scene, seed)
        self._rows_s = rows_at_s(scene)
        self._lenses = _Lenses(scene)
        self._to_come = [event for event in scene.correction.events if event.kind == "closed"]
        self._shutter: Shutter | None = None
        self._shown: tuple[RollingReadout, Exposure] | None = None

    def bare(self, moment: Moment, blackbody_k: float) -> tuple[float, FixedPattern]:
        """Level of the bare blackbody, DN, and the pattern of that moment."""
        view = self._lenses.at(0.0, WheelSince(self._surroundings.wheel, 0, 1), blackbody_k=blackbody_k)
        return _settled_dn(self._scene, blackbody_k), self._readout(view).pattern_at(self._exposure(moment))

    def make(self, moment: Moment, wheel: WheelSince, blackbody_k: float) -> Make:
        speed = self._surroundings.wheel.speed_rad_per_s(moment.start_cycle)
        view = self._lenses.at(speed, wheel, blackbody_k=blackbody_k)
        exposure = self._exposure(moment)
        self._close_shutter(view, until_s=exposure.start_s + float(max(self._rows_s)))
        if self._shown is None or not self._is_frozen(moment):
            self._shown = self._readout(view), exposure
        readout, exposure = self._shown
        return lambda signal_dn, out: readout.read(exposure, signal_dn=signal_dn, out=out)

    def _exposure(self, moment: Moment) -> Exposure:
        epoch, level_dn = upkeep_at(self._scene, np.array([moment.triggered_s]))
        return Exposure(
            number=moment.number + 1, start_s=moment.start_s, level_dn=float(level_dn[0]), epoch=int(epoch[0])
        )

    def _is_frozen(self, moment: Moment) -> bool:
        now = np.array(moment.triggered_s)
        return any(event.kind == "frozen" and bool(covers(event, now)) for event in self._scene.correction.events)

    def _readout(self, view: View) -> RollingReadout:
        return RollingReadout(
            view=view, shutter=self._closures(), row_s=self._rows_s, patterns=self._patterns, seed=self._seed
        )

    def _closures(self) -> Shutter:
        if self._shutter is None:
            lag_s = self._lenses.time_constant_s
            self._shutter = Shutter(surface_dn=surface_dn_of(self._scene), fading=Fading(lag_s))
        return self._shutter

    def _close_shutter(self, view: View, *, until_s: float) -> None:
        """Take in the closures that have begun."""
        shape = (self._scene.detector.rows, self._scene.detector.columns)
        while self._to_come and self._to_come[0].start_s <= until_s:
            self._shutter = self._closures().closed_by(self._to_come.pop(0), view, rows_columns=shape)


@final
class _Lenses:
    """The lens for each speed and temperature, traced once and altered where that is enough."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._blackbody_k = scene.radiance.blackbody_k
        self._lens = self._traced = self._trace(2 * math.pi * scene.trigger.wheel_hz, self._blackbody_k)

    @property
    def time_constant_s(self) -> float:
        """Of the pixels."""
        return self._lens.time_constant_s

    def at(self, rad_per_s: float, wheel: WheelSince, *, blackbody_k: float) -> View:
        """What the pixels see of a wheel of this nominal speed before a blackbody of this temperature."""
        if rad_per_s * self.time_constant_s < _STANDING_RAD:
            standing, _ = prepared(self._scene)
            return _StandingWheel(shot=_before(standing, self._scene.radiance, blackbody_k=blackbody_k), wheel=wheel)
        other_speed = abs(rad_per_s / self._lens.nominal_rad_per_s - 1) > _SAME_SPEED
        warmer_k = abs(blackbody_k - self._blackbody_k)
        traced = self._traced.shot
        if not isinstance(traced, LaggingPicture):
            if other_speed or warmer_k > _SAME_WIDE_K:
                self._lens = self._traced = self._trace(rad_per_s, blackbody_k)
                self._blackbody_k = blackbody_k
        elif rad_per_s < _COARSEST * self._traced.nominal_rad_per_s:
            self._traced = self._trace(rad_per_s, self._scene.radiance.blackbody_k)
            return self.at(rad_per_s, wheel, blackbody_k=blackbody_k)
        elif other_speed or warmer_k > _SAME_K:
            shot = self._altered(traced, rad_per_s, blackbody_k)
            self._lens = replace(self._lens, shot=shot, nominal_rad_per_s=rad_per_s)
            self._blackbody_k = blackbody_k
        return replace(self._lens, motion=wheel)

    def _altered(self, traced: LaggingPicture, rad_per_s: float, blackbody_k: float) -> LaggingPicture:
        """Linear pixels at another speed before another blackbody."""
        radiance = self._scene.radiance
        warmer_dn = radiance.level_dn(blackbody_k) - radiance.level_dn(radiance.blackbody_k)
        gain_dn = traced.gain_dn + traced.nodes.share * (traced.nodes.behind == 0) * np.float32(warmer_dn)
        passing = response(self._scene.wheel, rad_per_s * self.time_constant_s)
        return replace(traced, gain_dn=gain_dn.astype(np.float32), response=passing)

    def _trace(self, rad_per_s: float, blackbody_k: float) -> Lens:
        scene = replace(self._scene, radiance=replace(self._scene.radiance, blackbody_k=blackbody_k))
        return lens_of(scene, WheelSince(_Nowhere(), 0, 1), rad_per_s=rad_per_s)


@final
class _Nowhere:
    """Stands for the wheel until there is one."""

    turned_until_cycle = 0

    def angle_at(self, cycles: Array) -> Array:
        return np.zeros_like(cycles)

    def speed_rad_per_s(self, cycle: int) -> float:
        return 0.0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _StandingWheel:
    """A wheel that stands, as pixels see it that have settled on it."""

    shot: Picture
    wheel: WheelSince

    def show(self, row_time_s: Array, *, out: Values) -> None:
        expose(self.shot, self.wheel.angle_at(np.array([np.median(row_time_s)])), out=out)


def _before(shot: Picture, radiance: Radiance, *, blackbody_k: float) -> Picture:
    """A picture before a blackbody of another temperature than the scene's: its light is linear in the level."""
    warmer_dn = radiance.level_dn(blackbody_k) - radiance.level_dn(radiance.blackbody_k)
    return replace(shot, opening_dn=shot.opening_dn + np.float32(warmer_dn)) if warmer_dn else shot


def _settled_dn(scene: Scene, blackbody_k: float) -> float:
    """What a mean pixel gives that sees nothing but the blackbody, DN."""
    if isinstance(scene.timing, BolometerTiming) and scene.timing.radiative is not None:
        warmer = replace(scene, radiance=replace(scene.radiance, blackbody_k=blackbody_k))
        return float(wide_pixel(warmer).settled_dn(np.array(blackbody_k)))
    return scene.radiance.level_dn(blackbody_k)
