"""When a camera of any kind takes each row, and the frames of a run: rows behind view and shutter, with pattern and noise."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import final

import numpy as np

from irtiming.errors import PlanError
from irtiming.records.arrays import Array, Pixels, Ticks
from irtiming.twin.clockwork import Motion
from irtiming.twin.free_camera import begun_s
from irtiming.twin.lag import Fading
from irtiming.twin.noise import FixedPattern, Values, corrected_pattern, digitise, fixed_pattern, generator
from irtiming.twin.scene import CameraTiming, Detector, Scene, Timing
from irtiming.twin.shutter import Shutter, covers
from irtiming.twin.sway import swayed
from irtiming.twin.tapped_view import tapped
from irtiming.twin.upkeep import ShutterEvent
from irtiming.twin.views import View, settled_dn, settling_s, view_of_wheel

_FORGOTTEN_S = 1e-7
"""Time constant with which the pixels of a photon camera forget their shutter."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Exposure:
    """One reading of all rows.

    ``number`` fixes its noise; ``start_s`` is when the turn of row 0 begins; ``level_dn``, drift and jumps up to then;
    ``epoch``, which of the patterns is there; ``gain``, by how much more than else the pixels give for what is not as
    warm as the wheel.
    """

    number: int
    start_s: float
    level_dn: float
    epoch: int
    gain: float = 0.0

    def pattern(self, patterns: tuple[FixedPattern, ...]) -> FixedPattern:
        """The one of these that is there, with the drift so far."""
        there = patterns[self.epoch]
        if self.level_dn == 0:
            return there
        return replace(there, offset_dn=there.offset_dn + np.float32(self.level_dn))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Readout:
    """Rows behind lens and shutter; the turn of each comes ``row_s``, shape (row,), after that of row 0.

    A mean pixel gives ``wheel_dn`` for the wheel.
    """

    view: View
    row_s: Array
    patterns: tuple[FixedPattern, ...]
    seed: int
    shutter: Shutter | None = None
    wheel_dn: float = 0.0

    def read(self, exposure: Exposure, *, signal_dn: Values, out: Pixels | Values) -> None:
        """Write a frame, shape (row, column), to ``out``; ``signal_dn`` is room for the work."""
        row_time_s = exposure.start_s + self.row_s
        self.view.show(row_time_s, out=signal_dn)
        if self.shutter is not None:
            self.shutter.cover(row_time_s, signal_dn=signal_dn)
        if exposure.gain != 0:
            signal_dn += np.float32(exposure.gain) * (signal_dn - np.float32(self.wheel_dn))
        random = generator(self.seed, "frame", index=exposure.number)
        digitise(signal_dn, exposure.pattern(self.patterns), random=random, out=out)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WheelShots:
    """Frames of the turning wheel.

    Shapes: source (n_frame,), which exposure each frame shows. Of the exposures, shape (n_exposure,), as in `Exposure`:
    start_s, level_dn, epoch, gain.
    """

    readout: Readout
    source: Ticks
    start_s: Array
    level_dn: Array
    epoch: Ticks
    gain: Array

    def __call__(self, index: int, *, signal_dn: Values, out: Pixels | Values) -> None:
        """Read the frame out."""
        number = int(self.source[index])
        exposure = Exposure(
            number=number,
            start_s=self.start_s[number],
            level_dn=self.level_dn[number],
            epoch=int(self.epoch[number]),
            gain=float(self.gain[number]),
        )
        self.readout.read(exposure, signal_dn=signal_dn, out=out)


def wheel_shots(scene: Scene, motion: Motion, *, kept: Ticks, seed: int) -> WheelShots:
    """Frames of one run of a scene.

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
        If the camera takes its rows for longer than the camera period.
    """
    refuse_slow_readout(scene)
    trigger, before = scene.trigger, exposures_before(scene.timing)
    clock_hz = trigger.true_frequency_hz
    set_s = round(trigger.trigger_delay_time_set_s * trigger.clock_frequency_hz) / clock_hz + trigger.late_trigger_s
    triggered_s = begun_s(trigger, scene.free, number=np.arange(-before, trigger.n_triggers)) + set_s
    jitter = generator(seed, "exposure").standard_normal(triggered_s.size)
    view = tapped(view_of_wheel(scene, motion), scene.taps, columns=scene.detector.columns)
    epoch, level_dn = upkeep_at(scene, triggered_s)
    sway, wheel_dn = swayed(scene.sway, triggered_s, seed=seed), settled_dn(scene, scene.radiance.wheel_k)
    contrast_dn = abs(settled_dn(scene, scene.radiance.blackbody_k) - wheel_dn)
    shutter = None
    for event in scene.correction.events:
        if event.kind == "closed":
            shutter = (shutter or open_shutter(scene)).closed_by(event, view, rows_columns=_shape(scene.detector))
    return WheelShots(
        readout=Readout(
            view=view,
            shutter=shutter,
            row_s=rows_at_s(scene),
            patterns=patterns_of(scene, seed),
            seed=seed,
            wheel_dn=wheel_dn,
        ),
        source=_thawed(triggered_s, scene.correction.events)[np.asarray(kept) + before],
        start_s=started_at_s(scene.timing, triggered_s, jitter=jitter),
        level_dn=level_dn + contrast_dn * sway.offset,
        epoch=epoch,
        gain=sway.gain,
    )


def exposures_before(timing: Timing) -> int:
    """How many exposures there are before that of the first trigger: one, where a frozen camera might show it."""
    return 0 if isinstance(timing, CameraTiming) else 1


def rows_at_s(scene: Scene) -> Array:
    """How much later than row 0 the turn of each row comes, shape (row,), s; a snapshot has one moment for all."""
    rows = scene.detector.rows
    if scene.timing.row_delay_s is None:
        return np.zeros(rows)
    return np.arange(rows, dtype=np.float64) * scene.timing.row_delay_s + scene.taps.rows_later_s(rows)


def busy_s(scene: Scene) -> float:
    """From the first row's turn to the end of the last one's, s."""
    window_s = scene.timing.integration_time_s if isinstance(scene.timing, CameraTiming) else 0.0
    return window_s + float(np.ptp(rows_at_s(scene)))


def started_at_s(timing: Timing, triggered_s: Array, *, jitter: Array) -> Array:
    """When the turn of row 0 begins: its integration, or its reading; shape (n_trigger,), s.

    Parameters
    ----------
    timing
        Of the camera.
    triggered_s
        Shape (n_trigger,): when the triggers reach the camera, s.
    jitter
        Shape (n_trigger,): in standard deviations.
    """
    return triggered_s + timing.trigger_delay_s + timing.jitter_s * jitter


def refuse_slow_readout(scene: Scene) -> None:
    """Refuse a rolling camera that is still at its rows when the next trigger comes.

    Raises
    ------
    PlanError
        With the times, and what to change.
    """
    timing, trigger, rows = scene.timing, scene.trigger, scene.detector.rows
    if timing.row_delay_s is None:
        return
    window_s = timing.integration_time_s if isinstance(timing, CameraTiming) else 0.0
    readout_s = abs(timing.row_delay_s) * rows + window_s
    period_s = trigger.camera_period_ticks / trigger.true_frequency_hz
    if not readout_s <= period_s:
        window = f" for {window_s * 1e3:.4g} ms each" if window_s else ""
        raise PlanError(
            f"reading {rows} rows every {abs(timing.row_delay_s) * 1e6:g} us{window} takes {readout_s * 1e3:.4g} ms, longer "
            f"than the camera period of {period_s * 1e3:.4g} ms; take a smaller row delay, fewer rows or a lower "
            "frame rate"
        )


def upkeep_at(scene: Scene, triggered_s: Array) -> tuple[Ticks, Array]:
    """Which of the patterns is there, and jumps and drift up to then, DN, at these triggers; shapes (n_trigger,)."""
    events, drift = scene.correction.events, scene.drift
    epoch = np.searchsorted([event.start_s + event.duration_s for event in events], triggered_s, side="right")
    jumps = np.cumsum([0.0, *(event.level_jump_dn for event in events)])
    settling_dn = drift.settling_dn * np.exp(-triggered_s / drift.settling_time_s)
    return epoch, jumps[epoch] + (drift.per_second_dn * triggered_s + settling_dn)


def open_shutter(scene: Scene) -> Shutter:
    """Shutter of a camera before its first closure; a photon detector remembers next to nothing of it."""
    fading_s = _FORGOTTEN_S if isinstance(scene.timing, CameraTiming) else settling_s(scene)
    return Shutter(surface_dn=settled_dn(scene, scene.correction.surface_k), fading=Fading(fading_s))


def _thawed(triggered_s: Array, events: tuple[ShutterEvent, ...]) -> Ticks:
    """For each exposure the one that the camera gives out: itself, or the last before it froze."""
    own = np.arange(triggered_s.size)
    for event in events:
        if event.kind == "frozen":
            own[covers(event, triggered_s)] = 0
    return np.maximum.accumulate(own)


def patterns_of(scene: Scene, seed: int) -> tuple[FixedPattern, ...]:
    """A photon detector's pattern; a bolometer's at the start, which belongs to the camera, and those after each correction."""
    detector, n_corrections = scene.detector, len(scene.correction.events)
    if isinstance(scene.timing, CameraTiming):
        return (pattern_of(detector),) * (1 + n_corrections)
    surface_dn = settled_dn(scene, scene.correction.surface_k)
    chances = [generator(detector.pattern_seed, "correction")]
    chances += [generator(seed, "correction", index=1 + index) for index in range(n_corrections)]
    residuals = [chance.standard_normal(_shape(detector), dtype=np.float32) for chance in chances]
    return tuple(corrected_pattern(detector, surface_dn, residual=residual) for residual in residuals)


@lru_cache(maxsize=2)
def pattern_of(detector: Detector) -> FixedPattern:
    """`fixed_pattern`, kept from one call to the next."""
    return fixed_pattern(detector)


def _shape(detector: Detector) -> tuple[int, int]:
    return detector.rows, detector.columns
