"""Angles of the control slots from their own timestamps, averaged over the turns of a recording."""

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from irtiming.physics import robust, slot_orders
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Mask
from irtiming.reduce.wheel.edge_train import EdgeTrain

_TURNS_NEEDED = 8
_FAR = 2.0  # standard deviations beyond which a turn counts no more than one that is so far off
_ROUNDS = 40
_ALIKE = 0.2  # orders that differ by less than this share are taken to have the same variance


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlotTable:
    """Deviation of each slot from its regular place, rad, shape (slots,), mean zero, and its variance per order, rad^2."""

    deviation_rad: Array
    order_variance_rad2: Array

    @property
    def u_deviation_rad(self) -> Array:
        """Standard uncertainty of each slot, rad, shape (slots,)."""
        n_slots = self.deviation_rad.size
        return np.full(n_slots, slot_orders.u_slot_rad(self.order_variance_rad2, n_slots))

    @property
    def u_register_rad(self) -> float:
        """Standard uncertainty of an angle counted from edge 0 that is read off the table, rad.

        The table has mean zero, but the slots' own errors have a mean. Slots that are wrong each for itself have one of
        their rms over the root of their number; eccentricity and other waves around the wheel have none. Beside it stands the
        uncertainty of the table at a single place.
        """
        mean = np.sqrt(np.mean(self.deviation_rad**2) / self.deviation_rad.size)
        return float(np.hypot(mean, self.u_deviation_rad[0]))


def equal_slots(n_slots: int) -> SlotTable:
    """Slots taken as regular, as published (Schatz 2023, 2.4)."""
    return SlotTable(deviation_rad=np.zeros(n_slots), order_variance_rad2=np.zeros(n_slots // 2 + 1))


def learn_slots(train: EdgeTrain, n_slots: int) -> SlotTable:
    """Slot deviations from the timestamps of the control gate.

    Each slot's time is compared with the mean over the turn that is centred on it: a mean over whole turns knows
    nothing of the slots and follows the wheel's slow wander. The deviations are then averaged over all turns; a turn that is
    far off, because the wheel was touched, counts little (Huber's mean), and an edge that was not recorded does not count.

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
    A speed ripple that repeats every turn cannot be distinguished from slot deviations at one speed. The variances are from the
    scatter over turns with its correlation from turn to turn; they do not hold that ripple.
    """
    if train.number[-1] + 1 < (_TURNS_NEEDED + 1) * n_slots:
        return equal_slots(n_slots)
    by_turn, is_recorded, tick_rad = _turns(train, n_slots)
    rise = np.roll((np.arange(n_slots) + 0.5) / n_slots, n_slots // 2)
    mean, influence = _robust_mean(by_turn, _faded(is_recorded, rise), least_scale=tick_rad)
    blocks = rise * influence[:-1] + (1 - rise) * influence[1:]
    return SlotTable(deviation_rad=mean - mean.mean(), order_variance_rad2=_variance_of_mean(blocks))


def _turns(train: EdgeTrain, n_slots: int) -> tuple[Array, Mask, float]:
    """Deviations and whether each edge was recorded, shapes (turn, slot), and the angle of one tick, rad."""
    number = np.arange(train.number[-1] + 1)
    ticks = np.interp(number, train.number, train.ticks - train.ticks[0])
    half = n_slots // 2
    window = np.ones(2 * half + 1)
    if n_slots % 2 == 0:
        window[[0, -1]] = 0.5
    centre = np.convolve(ticks, window / n_slots, "valid")
    turn_ticks = (ticks[2 * half :] - ticks[: -2 * half]) * n_slots / (2 * half)
    deviation = TURN * (ticks[half:-half] - centre) / turn_ticks
    is_recorded = np.isin(number[half:-half], train.number)
    by_turn, is_recorded_by_turn = (_by_turn(values, n_slots, half) for values in (deviation, is_recorded))
    return by_turn, is_recorded_by_turn, TURN / float(np.median(turn_ticks))


def _by_turn(values: Any, n_slots: int, first: int) -> Any:
    """Values of whole turns, shape (turn, slot), the first one of them of that slot."""
    turns = values.size // n_slots
    return np.roll(values[: turns * n_slots].reshape(turns, n_slots), first, axis=1)


def _faded(is_recorded: Mask, rise: Array) -> Array:
    """Weight of each value, (turn, slot): 1 where recorded, growing in the first turn and falling in the last one.

    So each slot has the weight of one turn less, and a wander that ends elsewhere than it began makes no step in the table.
    """
    weight = is_recorded.astype(float)
    weight[0] *= rise
    weight[-1] *= 1 - rise
    return weight


def _robust_mean(by_turn: Array, weight: Array, *, least_scale: float) -> tuple[Array, Array]:
    """Huber's mean of each slot over the turns, and by how much each value moves it: times the number of turns, (turn, slot)."""
    mean = np.median(by_turn, axis=0)
    scale = float(np.median(robust.OF_NORMAL * np.median(np.abs(by_turn - mean), axis=0)))
    limit = _FAR * max(scale, least_scale)
    for _ in range(_ROUNDS):
        off = by_turn - mean
        near = weight * np.minimum(1.0, limit / np.maximum(np.abs(off), limit))
        step = np.sum(near * off, axis=0) / np.maximum(near.sum(axis=0), 0.5)
        mean = mean + step
        if np.max(np.abs(step)) < 1e-4 * limit / np.sqrt(len(by_turn)):
            break
    off = by_turn - mean
    inside = np.sum(weight * (np.abs(off) <= limit), axis=0)
    return mean, np.clip(off, -limit, limit) * (weight > 0) * (len(by_turn) - 1) / np.maximum(inside, 0.5)


def _variance_of_mean(influence: Array) -> Array:
    """Variance of the mean over turns for each order, rad^2 (Newey and West 1987), the same for neighbouring orders."""
    turns, n_slots = influence.shape
    waves = np.fft.rfft(influence - influence.mean(axis=0), axis=1) / np.sqrt(n_slots)
    lags = max(2, round(turns ** (1 / 3)))
    variance = np.mean(np.abs(waves) ** 2, axis=0)
    for lag in range(1, lags + 1):
        product = np.sum(np.real(waves[lag:] * np.conj(waves[:-lag])), axis=0) / turns
        variance = variance + 2 * (1 - lag / (lags + 1)) * product
    variance = variance / (turns - 1 - lags)
    orders = np.arange(variance.size)
    alike = np.abs(orders[:, None] - orders) <= _ALIKE * orders[:, None]
    alike[:, 0] = False
    smooth: Array = alike @ variance / np.maximum(alike.sum(axis=1), 1)
    return smooth
