"""The twin's wheel before the inputs of a simulated trigger generator: it turns as the chopper's reference asks for."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.gateware.event_model import PinChanges
from irtiming.gateware.register_map import Channel
from irtiming.records.arrays import Ticks
from irtiming.twin.clockwork import Motion, first_trigger_ticks, spin, tick_streams
from irtiming.twin.scene import Scene

_TURNS_OF_A_BLOCK = 40
_FASTEST_HZ = 1000.0
"""A reference for a faster wheel is nothing that a wheel follows."""

_PULSE = 0.4
"""Part of a slot's pitch that the control line is high; edges of the control slots that count are the rising ones."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Block:
    """Some turns at one speed from a cycle on, and the changes of the lines within them."""

    begins: int
    ends: int
    motion: Motion
    lines: dict[Channel, PinChanges]


@final
class DrivenWheel:
    """Wheel of a scene, with its irregular slots, wander, ripple and jitter; implements `gateware.model_device.Wheel`.

    It takes a new speed at once, and is made block by block: at a seam the wheel is where it was, the wander starts anew.
    Only one that ``remembers`` can tell by `motion_from` how it turned; it grows by 10 MB a minute.
    """

    def __init__(self, scene: Scene, *, clock_frequency_hz: int, seed: int, remembers: bool = False) -> None:
        self._scene = scene
        self._clock_frequency_hz = clock_frequency_hz
        self._seed = seed
        self._remembers = remembers
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
        if slot_period_cycles != self._slot_period:
            self._slot_period = slot_period_cycles
            if self._blocks:
                self._blocks[-1] = replace(self._blocks[-1], ends=self._cycle)
            if self._can_follow():
                self._blocks.append(self._block(self._cycle))
        if self._can_follow():
            while self._blocks[-1].ends < until_cycle:
                self._blocks.append(self._block(self._blocks[-1].ends))
        changes = {line: self._changes(line, until_cycle) for line in self._told}
        self._cycle = max(self._cycle, until_cycle)
        if not self._remembers:
            self._blocks = [block for block in self._blocks[:-1] if block.ends > self._cycle] + self._blocks[-1:]
        return changes

    def motion_from(self, cycle: int) -> Motion:
        """How the wheel turned, with time zero at the beginning of a cycle: what a camera saw that was triggered then.

        Parameters
        ----------
        cycle
            Of the counter.
        """
        times, angles = [], []
        for block in self._blocks:
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
            motion=motion,
            lines={
                Channel.CONTROL_SLOT: PinChanges(cycle=pulses.ravel(), level=levels),
                Channel.APPLICATION_SLOT: PinChanges(cycle=edges[edges < ends], level=rising.astype(np.int64)),
            },
        )

    def _angle_at(self, cycle: int) -> float:
        if not self._blocks:
            return self._scene.trigger.start_angle_rad
        last = self._blocks[-1]
        return float(last.motion.angle_at(np.array((cycle - last.begins) / self._clock_frequency_hz)))

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
