"""Where the edges of a line lie between the control slots: a latency moves them in proportion to the wheel's speed."""

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Ticks
from irtiming.records.latency_check import GateRegister
from irtiming.records.rig import Measured
from irtiming.reduce.wheel.edge_train import number_edges

_PER_TURN = (1, 2, 4)
_FEWEST_TURNS = 5


def register(
    name: str, *, edge_ticks: Ticks, slot_ticks: Ticks, clock_frequency_hz: float, turn_ticks: float, control_slots: int
) -> GateRegister:
    """Mean wheel angle from the control slot before an edge to the edge, as the timestamps say.

    An edge that passes at wheel angle a is stamped L later, a slot l later: by the slots' own stamps the wheel then stands at
    a + omega (L - l). So the phase moves by L - l per rad/s, whatever the angles of slots, edges and gates are.

    Parameters
    ----------
    name
        Of the recording and the line, for messages.
    edge_ticks
        Of the line, shape (n_edge,): one, two or four a turn, or as many as there are slots.
    slot_ticks
        Of the control gate, shape (n_slot,).
    clock_frequency_hz
        Of the ticks.
    turn_ticks
        Nominal length of a turn.
    control_slots
        Slots of the ring.

    Raises
    ------
    ReductionError
        If the edges come at no such rhythm, or there are too few.
    """
    per_turn = _edges_per_turn(edge_ticks, turn_ticks, control_slots=control_slots, name=name)
    slots = number_edges(slot_ticks, period_ticks=turn_ticks / control_slots, name=f"{name}: control slots")
    edges = number_edges(edge_ticks, period_ticks=turn_ticks / per_turn, name=name)
    before = np.searchsorted(slots.ticks, edges.ticks, side="right") - 1
    inside = (before >= 0) & (before < slots.ticks.size - 1)
    inside[inside] = np.diff(slots.number)[before[inside]] == 1
    before, ticks, number = before[inside], edges.ticks[inside], edges.number[inside]
    if ticks.size < _FEWEST_TURNS * per_turn:
        raise ReductionError(
            f"{name}: {ticks.size} edges lie between control slots; record {_FEWEST_TURNS} turns or more"
        )
    pitch = (slots.ticks[before + 1] - slots.ticks[before]).astype(np.float64)
    fraction = (ticks - slots.ticks[before]) / pitch
    phase, u = _mean_over_classes(fraction, np.mod(number, per_turn), float(1 / pitch.mean()) / 6**0.5)
    pitch_rad = TURN / control_slots
    return GateRegister(
        name=name,
        wheel_rad_per_s=float(np.mean(pitch_rad / pitch)) * clock_frequency_hz,
        phase_rad=Measured(pitch_rad * phase, pitch_rad * u),
        n_edges=int(ticks.size),
    )


def _edges_per_turn(ticks: Ticks, turn_ticks: float, *, control_slots: int, name: str) -> int:
    if ticks.size < _FEWEST_TURNS:
        raise ReductionError(f"{name}: {ticks.size} edges were recorded; check the line and that it is recorded")
    per_turn = turn_ticks / float(np.median(np.diff(ticks)))
    usual = min((*_PER_TURN, control_slots), key=lambda n: abs(np.log(n / per_turn)))
    if not 0.8 < per_turn / usual < 1.25:
        raise ReductionError(
            f"{name}: {per_turn:.2f} edges come in a turn; 1, 2, 4 or {control_slots} are expected, check line and rotation_speed"
        )
    return usual


def _mean_over_classes(fraction: Array, of_class: Ticks, rounding: float) -> tuple[float, float]:
    """Mean of each edge of the turn over all turns, then of all edges, in slots, and its standard uncertainty.

    Which edge is which does not matter then. Fractions are counted from their common direction, so that 0 and 1 are one place.
    ``rounding`` is that of a fraction by the clock: no scatter is trusted to be less.
    """
    towards = float(np.angle(np.mean(np.exp(1j * TURN * fraction)))) / TURN
    fraction = towards + np.mod(fraction - towards + 0.5, 1.0) - 0.5
    classes = [fraction[of_class == one] for one in np.unique(of_class)]
    variances = [max(float(values.var(ddof=1)), rounding**2) / values.size for values in classes]
    return float(np.mean([values.mean() for values in classes])), float(np.sqrt(np.sum(variances))) / len(classes)
