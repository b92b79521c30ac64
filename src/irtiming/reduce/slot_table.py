"""Angles of the control slots from their own timestamps, averaged over the turns of a recording."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array
from irtiming.reduce.edge_train import EdgeTrain

_TURNS_NEEDED = 8


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlotTable:
    """Deviation of each slot from its regular place and its standard uncertainty, rad, shape (slots,), mean zero."""

    deviation_rad: Array
    u_deviation_rad: Array


def equal_slots(n_slots: int) -> SlotTable:
    """Slots taken as regular, as published (Schatz 2023, 2.4)."""
    return SlotTable(deviation_rad=np.zeros(n_slots), u_deviation_rad=np.zeros(n_slots))


def learn_slots(train: EdgeTrain, n_slots: int) -> SlotTable:
    """Slot deviations from the timestamps of the control gate.

    Each slot's time is compared with the mean over the turn that is centred on it: a mean over whole turns knows
    nothing of the slots and follows the wheel's slow wander. The deviations are then averaged over all turns.

    Parameters
    ----------
    train
        Numbered edges of the control gate.
    n_slots
        Slots per turn.

    Returns
    -------
    Table whose entry 0 is the slot of the first edge; regular slots when there are fewer than 8 turns to average.

    Notes
    -----
    A speed ripple that repeats every turn cannot be told from slot deviations at one speed. The uncertainty is the
    scatter over turns, widened for its correlation from turn to turn; it does not hold that ripple.
    """
    if train.number[-1] + 1 < (_TURNS_NEEDED + 1) * n_slots:
        return equal_slots(n_slots)
    number = np.arange(train.number[-1] + 1)
    ticks = np.interp(number, train.number, train.ticks - train.ticks[0])
    half = n_slots // 2
    window = np.ones(2 * half + 1)
    if n_slots % 2 == 0:
        window[[0, -1]] = 0.5
    centre = np.convolve(ticks, window / n_slots, "valid")
    turn_ticks = (ticks[2 * half :] - ticks[: -2 * half]) * n_slots / (2 * half)
    deviation = 2 * np.pi * (ticks[half:-half] - centre) / turn_ticks
    turns = deviation.size // n_slots
    by_turn = np.roll(deviation[: turns * n_slots].reshape(turns, n_slots), half, axis=1)
    mean = by_turn.mean(axis=0)
    scatter = by_turn - mean
    power = float(np.mean(scatter**2)) or 1.0  # a perfect wheel on paper has none
    lag_one = float(np.mean(scatter[1:] * scatter[:-1])) / power
    widening = (1 + max(lag_one, 0.0)) / (1 - min(max(lag_one, 0.0), 0.9))
    u_mean = np.sqrt(widening * by_turn.var(axis=0, ddof=1) / turns)
    return SlotTable(deviation_rad=mean - mean.mean(), u_deviation_rad=u_mean)
