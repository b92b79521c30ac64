"""How the lines of the trigger generator stand while a run is recorded, line by line, for a person to look at."""

from dataclasses import dataclass
from typing import final

from irtiming.records.arrays import Ticks
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import TriggerScheme

_SILENT_TURNS = 1.5


@final
@dataclass(frozen=True, kw_only=True)
class LineSeen:
    """Edges of one line: how many came, how many in a turn of the wheel or s, how many should, and whether they come now."""

    name: str
    edges: int
    per_turn: float | None
    expected: int
    is_alive: bool

    @property
    def is_well(self) -> bool:
        """Whether edges come, as many as should."""
        return self.is_alive and (self.per_turn is None or round(self.per_turn) == self.expected)


@final
@dataclass(frozen=True, kw_only=True)
class EdgesSeen:
    """All lines of the wheel, its speed in the last turn and as planned, Hz, and whether stamps were lost."""

    lines: tuple[LineSeen, ...]
    wheel_hz: float | None
    planned_hz: float
    is_whole: bool


def seen(timestamps: Timestamps, scheme: TriggerScheme) -> EdgesSeen:
    """How the lines stand.

    Parameters
    ----------
    timestamps
        All of the run so far.
    scheme
        What the wheel was to do.
    """
    clock, slots = timestamps.clock_frequency_hz, timestamps.control_slot_ticks
    now = max((int(one[-1]) for one in (slots, timestamps.camera_trigger_ticks) if one.size), default=0)
    last_turn = slots[-1 - scheme.control_slots :]
    turn = int(last_turn[-1] - last_turn[0]) if last_turn.size > scheme.control_slots else None
    lines = (
        ("control slots", slots, scheme.control_slots),
        ("application slots", timestamps.application_slot_ticks, 2),
        ("application edges", timestamps.application_edge_ticks, 4),
    )
    return EdgesSeen(
        lines=tuple(
            _line(name, ticks, expected=expected, turn=turn, now=now) for name, ticks, expected in lines if ticks.size
        ),
        wheel_hz=None if turn is None else clock / turn,
        planned_hz=clock / scheme.turn_period_ticks,
        is_whole=timestamps.lost_after_ticks[:-1].size == 0,
    )


def _line(name: str, ticks: Ticks, *, expected: int, turn: int | None, now: int) -> LineSeen:
    span = int(ticks[-1] - ticks[0])
    per_turn = None if turn is None or span < turn else (ticks.size - 1) * turn / span
    is_alive = turn is None or now - int(ticks[-1]) < _SILENT_TURNS * turn
    return LineSeen(name=name, edges=int(ticks.size), per_turn=per_turn, expected=expected, is_alive=is_alive)
