"""Horizontal distance between the slopes of simulated and measured opening fractions (Schatz 2023, 3.2.4)."""

import math

import numpy as np
from numba import njit

from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, ComplexArray, Ticks

LIMITS = (0.2, 0.8)


def slope_distances(simulated: Array, measured: Array, *, wheel_angle_rad: Array) -> tuple[Array, Array]:
    """How far each measured row comes before its simulation, averaged over its four slopes.

    Each measured point between the limits is compared with the angle at which the simulation has the same fraction, linear
    between its samples. A slope is matched with the nearest of its kind.

    Parameters
    ----------
    simulated
        Shape (n_row, n_sample); at equidistant angles of a turn, 0 the first; without noise.
    measured
        Shape (n_row, n).
    wheel_angle_rad
        Shape (n,); of the measured fractions, rad.

    Returns
    -------
    Distances and their standard uncertainties from the scatter of the points, both of shape (n_row,), rad. A distance is
    within a quarter turn, and positive where the measurement comes first: its delay is the larger one. NaN where a slope
    has no point.
    """
    n = simulated.shape[1]
    # a shift by x turns the second harmonic by 2 x: good to a few samples, which is enough to tell the slopes apart
    there = _second_harmonic(measured, wheel_angle_rad)
    shift = np.angle(there * np.conj(_second_harmonic(simulated, TURN / n * np.arange(n)))) / 2
    both = _distances(np.ascontiguousarray(simulated), np.ascontiguousarray(measured), wheel_angle_rad, shift)
    return both[0], both[1]


def _second_harmonic(rows: Array, angle_rad: Array) -> ComplexArray:
    waves = np.stack([np.cos(2 * angle_rad), -np.sin(2 * angle_rad)], axis=1)
    parts = rows @ (waves - waves.mean(axis=0))
    return parts[:, 0] + 1j * parts[:, 1]


@njit(cache=True, nogil=True)
def _distances(simulated: Array, measured: Array, wheel_angle_rad: Array, shift: Array) -> Array:
    out = np.full((2, shift.size), np.nan)
    n = simulated.shape[1]
    for row in range(shift.size):
        curve = simulated[row]
        ends = _slopes(curve)
        if ends[3, 1] == 0:  # fewer than four
            continue
        total, count, squares = np.zeros(4), np.zeros(4), 0.0
        for k in range(wheel_angle_rad.size):
            value = measured[row, k]
            if not LIMITS[0] <= value <= LIMITS[1]:
                continue
            place = (wheel_angle_rad[k] + shift[row]) / TURN * n
            for slope in range(4):
                beside = _wrapped(place - (ends[slope, 0] + ends[slope, 1]) / 2, n)
                if abs(beside) < n / 8:
                    distance = _wrapped(_place(curve, ends[slope], value) - place, n) * TURN / n
                    total[slope] += distance
                    count[slope] += 1
                    squares += distance**2
                    break
        if count.min() > 0:
            points = count.sum()
            out[0, row] = np.mean(total / count) + shift[row]
            out[1, row] = math.sqrt(max(squares / points - (total.sum() / points) ** 2, 0.0) / points)
    return out


@njit(cache=True, nogil=True)
def _wrapped(samples: float, turn: int) -> float:
    """Distance within half a turn; ``%`` would take most of the time."""
    while samples > turn / 2:
        samples -= turn
    while samples <= -turn / 2:
        samples += turn
    return samples


@njit(cache=True, nogil=True)
def _slopes(curve: Array) -> Ticks:
    """First and last sample of each slope, shape (4, 2), such that the limits lie between; the last may be beyond n."""
    n = curve.size
    ends = np.zeros((4, 2), np.int64)
    begin = np.argmin(curve)
    last, found = begin, 0
    for k in range(begin, begin + n + 1):
        if LIMITS[0] < curve[k % n] < LIMITS[1]:
            continue
        if (curve[k % n] > 0.5) != (curve[last % n] > 0.5) and found < 4:
            ends[found] = last, k
            found += 1
        last = k
    return ends


@njit(cache=True, nogil=True)
def _place(curve: Array, ends: Ticks, value: float) -> float:
    """Sample, with its fraction, at which a slope has this value."""
    n = curve.size
    low, high = ends
    rises = curve[high % n] > curve[low % n]
    while high - low > 1:
        middle = (low + high) // 2
        if (curve[middle % n] < value) == rises:
            low = middle
        else:
            high = middle
    before, after = curve[low % n], curve[high % n]
    return low + (value - before) / (after - before)
