"""What a camera of the twin sees of a wheel that still turns: one frame at a time, made as those of a recording are.

Time is in cycles of the trigger generator's counter. A run is what comes between the start and the end of an
acquisition; its first trigger is time zero of drift and shutter events, as in `irtiming.twin.rig.recorded`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol, TypeAlias, final

import numpy as np

from irtiming.records.arrays import Array, Pixels
from irtiming.twin import window
from irtiming.twin.frames import BlackbodyShots
from irtiming.twin.node_picture import SECOND_BLADE, NodePicture
from irtiming.twin.noise import Values, generator
from irtiming.twin.readout import (
    Exposure,
    Readout,
    busy_s,
    exposures_before,
    open_shutter,
    patterns_of,
    rows_at_s,
    started_at_s,
    upkeep_at,
)
from irtiming.twin.scene import CameraTiming, Scene
from irtiming.twin.shutter import Shutter, covers
from irtiming.twin.views import (
    RowsView,
    View,
    WindowView,
    response_of,
    rows_view,
    settled_dn,
    still_picture,
)

_STANDING_RAD, _STANDING_IN_WINDOW_RAD = 0.005, 1e-6
"""A wheel that turns by less within a time constant stands, for pixels: it is a fraction of one of them. So within a window."""

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
    """Moments and frames of one acquisition of any kind of camera.

    `moment` is asked once for each trigger, in order; `make` likewise, when the wheel has turned until its end.
    """

    def __init__(self, scene: Scene, surroundings: Surroundings, *, seed: int) -> None:
        self._scene, self._surroundings, self._seed = scene, surroundings, seed
        self._rows_s, self._busy_s = rows_at_s(scene), busy_s(scene)
        self._before = exposures_before(scene.timing)
        self._random = generator(seed, "exposure")
        self._random.standard_normal(self._before)
        self._number = 0
        self._first_cycle: int | None = None
        self._last_cycle: int | None = None
        self._patterns = patterns_of(scene, seed)
        self._views: _WindowViews | _RowsViews
        if isinstance(scene.timing, CameraTiming) and scene.timing.row_delay_s is None:
            self._views = _WindowViews(scene, window.instants_s(scene.timing))
        else:
            self._views = _RowsViews(scene)
        self._to_come = [event for event in scene.correction.events if event.kind == "closed"]
        self._shutter: Shutter | None = None
        self._shown: tuple[Readout, Exposure] | None = None

    def moment(self, trigger_cycle: int) -> Moment | None:
        """Of the frame of a trigger; None where the camera still integrates, or reads rows, of the frame before."""
        clock_hz, timing = self._surroundings.clock_frequency_hz, self._scene.timing
        if self._last_cycle is not None and trigger_cycle - self._last_cycle < self._busy_s * clock_hz:
            return None
        self._last_cycle = trigger_cycle
        if self._first_cycle is None:
            self._first_cycle = trigger_cycle
        triggered_s = np.array([(trigger_cycle - self._first_cycle) / clock_hz])
        jitter = np.array([self._random.standard_normal()])
        start_s = float(started_at_s(timing, triggered_s, jitter=jitter)[0])
        first_s = start_s + float(min(self._rows_s))
        self._number += 1
        return Moment(
            number=self._number - 1,
            trigger_cycle=trigger_cycle,
            start_cycle=self._first_cycle + math.floor(first_s * clock_hz),
            end_cycle=self._first_cycle + math.ceil((first_s + self._busy_s) * clock_hz),
            triggered_s=float(triggered_s[0]),
            start_s=start_s,
        )

    def make(self, moment: Moment) -> Make:
        """What will make the frame of a moment that is past."""
        blackbody_k = self._surroundings.blackbody_k(moment.start_cycle)
        exposure = self._exposure(moment)
        if self._surroundings.is_bare():
            warm = replace(self._scene, radiance=replace(self._scene.radiance, blackbody_k=blackbody_k))
            level_dn, pattern = settled_dn(warm, blackbody_k), exposure.pattern(self._patterns)
            shots = BlackbodyShots(level_dn=level_dn, pattern=pattern, purpose="frame", seed=self._seed)
            return lambda signal_dn, out: shots(moment.number, signal_dn=signal_dn, out=out)
        speed = self._surroundings.wheel.speed_rad_per_s(moment.start_cycle)
        view = self._views.at(speed, self._surroundings.since(self._first_cycle or 0), blackbody_k=blackbody_k)
        self._close_shutter(view, until_s=exposure.start_s + float(max(self._rows_s)))
        if self._shown is None or not self._is_frozen(moment):
            readout = Readout(
                view=view, shutter=self._shutter, row_s=self._rows_s, patterns=self._patterns, seed=self._seed
            )
            self._shown = readout, exposure
        readout, exposure = self._shown
        return lambda signal_dn, out: readout.read(exposure, signal_dn=signal_dn, out=out)

    def _exposure(self, moment: Moment) -> Exposure:
        epoch, level_dn = upkeep_at(self._scene, np.array([moment.triggered_s]))
        return Exposure(
            number=moment.number + self._before,
            start_s=moment.start_s,
            level_dn=float(level_dn[0]),
            epoch=int(epoch[0]),
        )

    def _is_frozen(self, moment: Moment) -> bool:
        now = np.array(moment.triggered_s)
        return any(event.kind == "frozen" and bool(covers(event, now)) for event in self._scene.correction.events)

    def _close_shutter(self, view: View, *, until_s: float) -> None:
        """Take in the closures that have begun."""
        shape = (self._scene.detector.rows, self._scene.detector.columns)
        while self._to_come and self._to_come[0].start_s <= until_s:
            shutter = self._shutter or open_shutter(self._scene)
            self._shutter = shutter.closed_by(self._to_come.pop(0), view, rows_columns=shape)


@final
class _WindowViews:
    """What pixels see that average over some instants, shape (n_instant,), s, whatever the speed."""

    def __init__(self, scene: Scene, instants: Array) -> None:
        self._scene, self._instants, self._shot = scene, instants, still_picture(scene)

    def at(self, rad_per_s: float, wheel: WheelSince, *, blackbody_k: float) -> View:
        """The wheel before a blackbody of this temperature, to which the light is linear."""
        radiance, shot = self._scene.radiance, self._shot
        warmer_dn = np.float32(radiance.level_dn(blackbody_k) - radiance.level_dn(radiance.blackbody_k))
        if warmer_dn:
            shot = replace(shot, opening_dn=shot.opening_dn + warmer_dn)
        return WindowView(shot=shot, motion=wheel, instants_s=self._instants)


@final
class _RowsViews:
    """What pixels that are looked up see at each speed and temperature, traced once and altered where that is enough."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._blackbody_k = scene.radiance.blackbody_k
        self._view = self._traced = self._trace(2 * math.pi * scene.trigger.wheel_hz, self._blackbody_k)

    def at(self, rad_per_s: float, wheel: WheelSince, *, blackbody_k: float) -> View:
        """What the pixels see of a wheel of this nominal speed before a blackbody of this temperature."""
        timing = self._scene.timing
        if isinstance(timing, CameraTiming):
            standing_rad, instants = _STANDING_IN_WINDOW_RAD, window.instants_s(timing)
        else:
            standing_rad, instants = _STANDING_RAD, np.zeros(1)
        if rad_per_s * self._view.span_s < standing_rad:
            return _WindowViews(self._scene, instants).at(rad_per_s, wheel, blackbody_k=blackbody_k)
        other_speed = abs(rad_per_s / self._view.nominal_rad_per_s - 1) > _SAME_SPEED
        warmer_k = abs(blackbody_k - self._blackbody_k)
        traced = self._traced.shot
        if not isinstance(traced, NodePicture):
            if other_speed or warmer_k > _SAME_WIDE_K:
                self._view = self._traced = self._trace(rad_per_s, blackbody_k)
                self._blackbody_k = blackbody_k
        elif rad_per_s < _COARSEST * self._traced.nominal_rad_per_s:
            self._traced = self._trace(rad_per_s, self._scene.radiance.blackbody_k)
            return self.at(rad_per_s, wheel, blackbody_k=blackbody_k)
        elif other_speed or warmer_k > _SAME_K:
            shot = self._altered(traced, rad_per_s, blackbody_k)
            self._view = replace(self._view, shot=shot, nominal_rad_per_s=rad_per_s)
            self._blackbody_k = blackbody_k
        return replace(self._view, motion=wheel)

    def _altered(self, traced: NodePicture, rad_per_s: float, blackbody_k: float) -> NodePicture:
        """Linear pixels at another speed before another blackbody."""
        radiance = self._scene.radiance
        warmer_dn = radiance.level_dn(blackbody_k) - radiance.level_dn(radiance.blackbody_k)
        gains_dn = traced.gains_dn.copy()
        gains_dn[0] += traced.nodes.share * (traced.nodes.behind == 0) * np.float32(warmer_dn)
        blade = None if traced.blade is None else response_of(self._scene, rad_per_s, seen=SECOND_BLADE)
        return replace(traced, gains_dn=gains_dn, response=response_of(self._scene, rad_per_s), blade=blade)

    def _trace(self, rad_per_s: float, blackbody_k: float) -> RowsView:
        scene = replace(self._scene, radiance=replace(self._scene.radiance, blackbody_k=blackbody_k))
        return rows_view(scene, WheelSince(_Nowhere(), 0, 1), rad_per_s=rad_per_s)


@final
class _Nowhere:
    """Stands for the wheel until there is one."""

    turned_until_cycle = 0

    def angle_at(self, cycles: Array) -> Array:
        return np.zeros_like(cycles)

    def speed_rad_per_s(self, cycle: int) -> float:
        return 0.0
