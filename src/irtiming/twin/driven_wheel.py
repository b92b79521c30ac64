"""The twin's wheel before the inputs of a simulated trigger generator: it turns as the chopper's reference asks for."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from threading import RLock
from typing import final

import numpy as np

from irtiming.gateware.event_model import PinChanges
from irtiming.gateware.register_map import Channel
from irtiming.records.arrays import Array, Ticks
from irtiming.twin.clockwork import Motion, first_trigger_ticks, spin, tick_streams
from irtiming.twin.scene import Scene

_TURNS_OF_A_BLOCK = 40
_FASTEST_HZ = 1000.0
"""A reference for a faster wheel is nothing that a wheel follows."""

_MEMORY_S = 60.0
"""For so long a wheel knows at least how it turned; 10 MB."""

_PULSE = 0.4
"""Part of a slot's pitch that the control line is high; edges of the control slots that count are the rising ones."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Block:
    """Some turns at one speed from a cycle on, and the changes of the lines within them."""

    begins: int
    ends: int
    rad_per_s: float
    motion: Motion
    lines: dict[Channel, PinChanges]


@final
class DrivenWheel:
    """Wheel of a scene, with its irregular slots, wander, ripple and jitter; implements `gateware.model_device.Wheel`.

    It takes a new speed at once, and is made block by block: at a seam the wheel is where it was, the wander starts anew.
    It knows how it turned in the last minute; one that ``remembers`` knows all and grows by 10 MB a minute. One thread may
    turn it while others ask where it is.
    """

    def __init__(self, scene: Scene, *, clock_frequency_hz: int, seed: int, remembers: bool = False) -> None:
        self._scene = scene
        self._clock_frequency_hz = clock_frequency_hz
        self._seed = seed
        self._remembers = remembers
        self._lock = RLock()
        self._cycle = 0
        self._slot_period = 0
        self._blocks: list[_Block] = []
        self._told = {Channel.CONTROL_SLOT: 0, Channel.APPLICATION_SLOT: 0}

    def turn(self, until_cycle: int, *, slot_period_cycles: int) -> Mapping[Channel, PinChanges]:
        """Changes of the two light gates from where the last call ended to before ``until_cycle``.

        Parameters
        ----------
        until_cycle
            Where to stop.
        slot_period_cycles
            Of the chopper's reference; the wheel stands where it is 0 or no wheel can follow.
        """
        with self._lock:
            return self._turn(until_cycle, slot_period_cycles)

    def _turn(self, until_cycle: int, slot_period_cycles: int) -> Mapping[Channel, PinChanges]:
        if slot_period_cycles != self._slot_period:
            self._slot_period = slot_period_cycles
            if self._blocks:
                self._blocks[-1] = replace(self._blocks[-1], ends=min(self._blocks[-1].ends, self._cycle))
            if self._can_follow():
                self._blocks.append(self._block(self._cycle))
        if self._can_follow():
            while self._blocks[-1].ends < until_cycle:
                self._blocks.append(self._block(self._blocks[-1].ends))
        changes = {line: self._changes(line, until_cycle) for line in self._told}
        self._cycle = max(self._cycle, until_cycle)
        if not self._remembers:
            known_from = self._cycle - int(_MEMORY_S * self._clock_frequency_hz)
            self._blocks = [block for block in self._blocks[:-1] if block.ends > known_from] + self._blocks[-1:]
        return changes

    @property
    def turned_until_cycle(self) -> int:
        """Up to which cycle the wheel has turned."""
        return self._cycle

    def angle_at(self, cycles: Array) -> Array:
        """Unwrapped wheel angle, rad, any shape; beyond what has been turned as if the speed stayed as it is.

        Parameters
        ----------
        cycles
            Of the counter, any shape; they need not be whole.
        """
        with self._lock:
            blocks = list(self._blocks)
        cycles = np.asarray(cycles, dtype=np.float64)
        if not blocks:
            return np.full(cycles.shape, self._scene.trigger.start_angle_rad)
        of_block = np.searchsorted([block.begins for block in blocks[1:]], cycles, side="right")
        angle = np.empty(cycles.shape)
        for index in np.unique(of_block):
            here = of_block == index
            angle[here] = self._angle_in(blocks[index], cycles[here])
        beyond_s = np.maximum(cycles - blocks[-1].ends, 0) / self._clock_frequency_hz
        return angle + beyond_s * self.speed_rad_per_s(blocks[-1].ends)

    def speed_rad_per_s(self, cycle: int) -> float:
        """Nominal speed at a cycle; 0 while the wheel stands, and that which it has beyond what has been turned."""
        with self._lock:
            blocks = list(self._blocks)
            can_follow = self._can_follow()
        if blocks and cycle >= blocks[-1].ends:
            return blocks[-1].rad_per_s if can_follow else 0.0
        return next((block.rad_per_s for block in blocks if block.begins <= cycle < block.ends), 0.0)

    def motion_from(self, cycle: int) -> Motion:
        """How the wheel turned, with time zero at the beginning of a cycle: what a camera saw that was triggered then.

        Parameters
        ----------
        cycle
            Of the counter.
        """
        times, angles = [], []
        with self._lock:
            blocks = list(self._blocks)
        for block in blocks:
            inside = block.motion.time_s < (block.ends - block.begins) / self._clock_frequency_hz
            times.append(block.motion.time_s[inside] + (block.begins - cycle) / self._clock_frequency_hz)
            angles.append(block.motion.angle_rad[inside])
        return Motion(time_s=np.concatenate(times), angle_rad=np.concatenate(angles))

    def _can_follow(self) -> bool:
        slots = len(self._scene.wheel.control_slot_errors_rad)
        turn = self._slot_period * slots
        return turn > 0 and self._clock_frequency_hz / turn <= _FASTEST_HZ

    def _block(self, begins: int) -> _Block:
        """The next turns, on from the angle that the wheel has."""
        turn = self._slot_period * len(self._scene.wheel.control_slot_errors_rad)
        trigger = replace(
            self._scene.trigger,
            clock_frequency_hz=float(self._clock_frequency_hz),
            turn_period_ticks=turn,
            camera_period_ticks=turn,
            n_triggers=_TURNS_OF_A_BLOCK,
            lead_turns=0.0,
        )
        scene, seed = replace(self._scene, trigger=trigger), self._seed + begins
        motion = spin(scene, seed=seed)
        motion = replace(motion, angle_rad=motion.angle_rad - motion.angle_rad[0] + self._angle_at(begins))
        seen = tick_streams(scene, motion, seed=seed)
        to_cycle = begins - first_trigger_ticks(trigger) - 1  # an edge is stamped at the first clock after it
        slots, edges = seen.control_slot + to_cycle, seen.application_edges + to_cycle
        ends = _widest_gap(slots, edges, after=begins + (_TURNS_OF_A_BLOCK - 1) * turn)
        pulses = np.column_stack([slots, slots + int(_PULSE * self._slot_period)])[slots < ends]
        rising = np.isin(edges, seen.application_slot + to_cycle)[edges < ends]
        levels = np.tile(np.array([1, 0], dtype=np.int64), len(pulses))
        return _Block(
            begins=begins,
            ends=ends,
            rad_per_s=2 * math.pi * trigger.wheel_hz,
            motion=motion,
            lines={
                Channel.CONTROL_SLOT: PinChanges(cycle=pulses.ravel(), level=levels),
                Channel.APPLICATION_SLOT: PinChanges(cycle=edges[edges < ends], level=rising.astype(np.int64)),
            },
        )

    def _angle_at(self, cycle: int) -> float:
        if not self._blocks:
            return self._scene.trigger.start_angle_rad
        return float(self._angle_in(self._blocks[-1], np.array(float(cycle))))

    def _angle_in(self, block: _Block, cycles: Array) -> Array:
        """Angle within one block, and where the wheel came to stand after it."""
        return block.motion.angle_at(
            (np.clip(cycles, block.begins, block.ends) - block.begins) / self._clock_frequency_hz
        )

    def _changes(self, line: Channel, until_cycle: int) -> PinChanges:
        parts = list(self._parts(line, until_cycle))
        cycle = np.concatenate([part[0] for part in parts]) if parts else np.empty(0, dtype=np.int64)
        level = np.concatenate([part[1] for part in parts]) if parts else np.empty(0, dtype=np.int64)
        changes = PinChanges(cycle=cycle, level=level, initial=self._told[line])
        if level.size:
            self._told[line] = int(level[-1])
        return changes

    def _parts(self, line: Channel, until_cycle: int) -> Iterator[tuple[Ticks, Ticks]]:
        for block in self._blocks:
            last = min(until_cycle, block.ends)
            if last > self._cycle:
                changes = block.lines[line]
                inside = slice(*np.searchsorted(changes.cycle, [self._cycle, last]))
                yield changes.cycle[inside], changes.level[inside]


def _widest_gap(slots: Ticks, edges: Ticks, *, after: int) -> int:
    """Middle of the longest time without an edge: where one block of turns may end and the next begin."""
    both = np.sort(np.concatenate([slots, edges]))
    both = both[both >= after]
    widest = int(np.argmax(np.diff(both)))
    return int(both[widest] + both[widest + 1]) // 2
