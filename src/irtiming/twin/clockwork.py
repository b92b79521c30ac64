"""The wheel turning in small steps of time, and the clock that counts its edges.

Time is in seconds from the first trigger. The wheel angle grows without wrapping.
"""

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numba import njit

from irtiming.records.arrays import Array, Ticks
from irtiming.twin.noise import generator
from irtiming.twin.scene import CameraTiming, EdgeFaults, Scene, SpeedWander, TriggerGenerator

_STEP_S = 100e-6
_DOUBLE_S = 8e-6
_PULSE_JITTER_S = 30e-9


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """Wheel angle on a fine grid of times; between grid points the speed is constant.

    Shapes (n_step,): time_s, s from the first trigger; angle_rad, increasing.
    """

    time_s: Array
    angle_rad: Array

    def angle_at(self, time_s: Array) -> Array:
        """Unwrapped wheel angle, rad, at these times, any shape."""
        return np.interp(time_s, self.time_s, self.angle_rad)

    def time_of(self, angle_rad: Array) -> Array:
        """Times, s, at which the wheel reaches these unwrapped angles, any shape."""
        return np.interp(angle_rad, self.angle_rad, self.time_s)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TickStreams:
    """Timestamps of one run, shapes (n_edge,): values of one counter, each in order."""

    camera_trigger: Ticks
    control_slot: Ticks
    application_slot: Ticks
    application_edges: Ticks
    spare: Ticks | None = None


def spin(scene: Scene, *, seed: int) -> Motion:
    """Let the wheel turn through a whole run.

    The speed is stepped: wander, pulled back to the reference's phase, plus the ripple that depends on the
    angle.
    """
    trigger = scene.trigger
    rate = 2 * math.pi * trigger.true_wheel_hz
    start_s = -trigger.lead_turns / trigger.true_wheel_hz
    last_s = (trigger.n_triggers - 1) * trigger.camera_period_ticks / trigger.true_frequency_hz
    after_s = trigger.trigger_delay_time_set_s + scene.timing.trigger_delay_s + _longest_read_s(scene)
    end_s = last_s + after_s + 1.5 / trigger.wheel_hz
    step_s = min(_STEP_S, 1 / (2000 * trigger.wheel_hz))
    time = start_s + step_s * np.arange(math.ceil((end_s - start_s) / step_s) + 1, dtype=np.float64)
    lag = _lag(
        scene.wander,
        rate,
        step_s,
        generator(seed, "motion").standard_normal(_run_in(scene.wander, step_s) + time.size),
    )
    steady = trigger.start_angle_rad + rate * time + lag[-time.size :]
    angle = steady
    for _ in range(2):  # the ripple depends on the angle that it changes, by some microradians
        angle = steady + _ripple(scene.wander, angle, rate * step_s)
    return Motion(time_s=time, angle_rad=angle)


def _longest_read_s(scene: Scene) -> float:
    """How long after its trigger delay a frame still takes values."""
    timing = scene.timing
    window_s = timing.integration_time_s + timing.after_s if isinstance(timing, CameraTiming) else 0.0
    return max(0.0, (scene.detector.rows - 1) * (scene.timing.row_delay_s or 0.0)) + window_s


def _run_in(wander: SpeedWander, step_s: float) -> int:
    """Steps after which the wander has forgotten where it started."""
    return math.ceil(12 * max(wander.correlation_time_s, wander.lock_time_s) / step_s)


def _lag(wander: SpeedWander, rate: float, step_s: float, kicks: Array) -> Array:
    """Angle by which the wheel strays from its reference, rad: one value per random kick.

    Step by step, s <- s - s dt / tau - lag dt / (rate lock^2) + kick and lag <- lag + rate s dt: two lags make the next.
    """
    keep = 1 - step_s / wander.correlation_time_s
    pull = (step_s / wander.lock_time_s) ** 2
    kick = wander.relative * math.sqrt(2 * step_s / wander.correlation_time_s)
    return np.asarray(_stepped(kicks, rate * step_s * kick, (1 + keep - pull, keep)))


@njit(cache=True, nogil=True)
def _stepped(kicks: Array, size: float, keeps: tuple[float, float]) -> Array:
    """From step to step: the first share of the value before, less the second of the one before that, and the kick."""
    found = np.empty(kicks.size)
    before, at = 0.0, 0.0
    for k in range(kicks.size):
        before, at = at, size * kicks[k] + (keeps[0] * at - keeps[1] * before)
        found[k] = at
    return found


def _ripple(wander: SpeedWander, angle_rad: Array, advance_rad: float) -> Array:
    """Angle gained by ripple up to each step, rad."""
    speed = np.zeros_like(angle_rad)
    for ripple in wander.ripples:
        speed += ripple.relative * np.cos(ripple.order * angle_rad + ripple.phase_rad)
    gained = np.cumsum(speed) * advance_rad
    gained -= speed * advance_rad  # up to the beginning of the step
    return gained


def first_tick_after(time_s: Array, trigger: TriggerGenerator) -> Ticks:
    """Counter at the first clock cycle after these times (s from the first trigger), any shape."""
    cycles = np.floor(time_s * trigger.true_frequency_hz).astype(np.int64) + 1
    return cycles + first_trigger_ticks(trigger)


def first_trigger_ticks(trigger: TriggerGenerator) -> int:
    """Counter at the first trigger: the lead and a little later than the counter's start."""
    return trigger.counter_start_ticks + math.ceil((trigger.lead_turns + 0.1) * trigger.turn_period_ticks)


def tick_streams(scene: Scene, motion: Motion, *, seed: int) -> TickStreams:
    """Timestamps of all channels, with the detectors' delay and jitter and the faults that the scene asks for.

    With clockwise rotation the control beam comes beta_1 + beta_2 before the application beam on an edge's
    way, so a slot at alpha passes it at wheel angle alpha - beta_1 - beta_2. Counterclockwise, everything
    is the mirror image.
    """
    random = generator(seed, "edges")
    between = scene.beams.beta_1_rad + scene.beams.beta_2_rad
    slots = _passages(motion, np.array(scene.wheel.control_slot_angles_rad) - between)
    edges = _passages(motion, np.array(scene.wheel.ring_edges_rad))
    slots = slots + scene.beams.jitter_s * random.standard_normal(slots.shape) + scene.beams.late_control_gate_s
    edges = edges + scene.beams.jitter_s * random.standard_normal(edges.shape) + scene.beams.late_application_gate_s
    begin_s, end_s = motion.time_s[0], motion.time_s[-1]
    control = _damage(_within(slots, begin_s, end_s), scene.faults.control_slot, generator(seed, "faults", index=1))
    slot = _damage(
        _within(edges[:, [0, 2]], begin_s, end_s), scene.faults.application, generator(seed, "faults", index=2)
    )
    triggers = np.arange(scene.trigger.n_triggers, dtype=np.int64) * scene.trigger.camera_period_ticks
    return TickStreams(
        camera_trigger=triggers + first_trigger_ticks(scene.trigger),
        control_slot=first_tick_after(control, scene.trigger),
        application_slot=first_tick_after(slot, scene.trigger),
        application_edges=first_tick_after(_within(edges, begin_s, end_s), scene.trigger),
        spare=first_tick_after(_pulses_per_second(begin_s, end_s, random=generator(seed, "pulses")), scene.trigger),
    )


def _pulses_per_second(begin_s: float, end_s: float, *, random: np.random.Generator) -> Array:
    """Times at which a receiver gives its pulse per second, with its jitter."""
    times = np.arange(begin_s + random.uniform(0, 1), end_s, 1.0)
    return np.asarray(times + _PULSE_JITTER_S * random.standard_normal(times.size))


def _passages(motion: Motion, angles_rad: Array) -> Array:
    """Times, s, shape (n_turn, n_angle), at which these angles of the wheel pass; beyond the run, NaN."""
    first = math.floor(motion.angle_rad[0] / (2 * math.pi)) - 1
    last = math.ceil(motion.angle_rad[-1] / (2 * math.pi)) + 1
    wanted = 2 * math.pi * np.arange(first, last + 1)[:, None] + angles_rad
    times = motion.time_of(wanted)
    return np.where((wanted > motion.angle_rad[0]) & (wanted < motion.angle_rad[-1]), times, np.nan)


def _within(times_s: Array, begin_s: float, end_s: float) -> Array:
    """Times within the run, in order."""
    flat = np.sort(times_s[np.isfinite(times_s)])
    return flat[(flat > begin_s) & (flat < end_s)]


def _damage(times_s: Array, faults: EdgeFaults, random: np.random.Generator) -> Array:
    """Edge times with some missing, doubled or added; each kind strikes other edges."""
    struck = random.permutation(times_s.size)[: faults.missing + faults.doubled]
    echoes = times_s[struck[faults.missing :]] + _DOUBLE_S * (
        0.5 + random.random(struck.size - min(faults.missing, struck.size))
    )
    ghosts = random.uniform(times_s[0], times_s[-1], faults.spurious)
    kept = np.delete(times_s, struck[: faults.missing])
    return np.sort(np.concatenate([kept, echoes, ghosts]))
