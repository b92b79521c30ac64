"""Deviations of the control slots as a sum of waves around the wheel: order k has k waves to a turn.

What shifts the slots' apparent angles by chance, the wheel's wander and the gate's jitter, does not know where on the wheel it
strikes. So its covariance between two slots depends on their distance only, and is described by one variance per order: the
eigenvalues of that matrix. Arrays over orders have shape (slots // 2 + 1,); order 0, the mean, is zero by definition.
"""

from typing import Any

import numpy as np
from scipy.special import gammaincc

from irtiming.records.arrays import Array


def spectrum(deviation_rad: Array) -> Any:
    """Complex component of each order of a table, shape (..., slots), rad, on waves of unit length, shape (..., slots // 2 + 1).

    Its mean square, where it is chance, is the variance.
    """
    return np.fft.rfft(deviation_rad, axis=-1) / np.sqrt(np.shape(deviation_rad)[-1])


def from_spectrum(components_rad: Any, n_slots: int) -> Array:
    """Deviation of each slot, rad, shape (slots,), with mean zero: the inverse of `spectrum`."""
    deviation = np.fft.irfft(components_rad, n_slots) * np.sqrt(n_slots)
    return np.asarray(deviation - deviation.mean(), dtype=np.float64)


def degrees_of_freedom(n_slots: int) -> Array:
    """Waves of each order, shape (slots // 2 + 1,): cosine and sine; an even ring's last order has one, order 0 none."""
    waves = np.full(n_slots // 2 + 1, 2.0)
    waves[0] = 0.0
    if n_slots % 2 == 0:
        waves[-1] = 1.0
    return waves


def amplitude_rad(deviation_rad: Array) -> Array:
    """Amplitude of each order, rad, shape (slots // 2 + 1,), of a table of shape (slots,).

    Deviation of slot j = sum over k of amplitude[k] cos(2 pi j k / slots + phase[k]).
    """
    n_slots = deviation_rad.size
    return np.asarray(np.abs(spectrum(deviation_rad)) * degrees_of_freedom(n_slots) / np.sqrt(n_slots))


def phase_rad(deviation_rad: Array) -> Array:
    """Phase of each order, rad, shape (slots // 2 + 1,), of a table of shape (slots,)."""
    return np.asarray(np.angle(spectrum(deviation_rad)))


def u_amplitude_rad(order_variance_rad2: Array, n_slots: int) -> Array:
    """Standard uncertainty of the amplitude of each order, rad, shape (slots // 2 + 1,); over it, that of the phase."""
    return np.sqrt(order_variance_rad2 * degrees_of_freedom(n_slots) / n_slots)


def u_slot_rad(order_variance_rad2: Array, n_slots: int) -> float:
    """Standard uncertainty of a single slot, the same for all, rad, from the variances per order, shape (slots // 2 + 1,)."""
    return float(np.sqrt(order_variance_rad2 @ degrees_of_freedom(n_slots) / n_slots))


def covariance_rad2(order_variance_rad2: Array, n_slots: int) -> Array:
    """Covariance of the slots' deviations, rad^2, shape (slots, slots); its rows add up to zero, as the mean is known."""
    row = np.fft.irfft(np.where(degrees_of_freedom(n_slots) > 0, order_variance_rad2, 0.0), n_slots)
    slot = np.arange(n_slots)
    return np.asarray(row[np.mod(slot[:, None] - slot, n_slots)])


def chi_square(difference_rad: Array, order_variance_rad2: Array) -> Array:
    """Square of a difference of two tables, shape (slots,), over its variance, per order, shape (slots // 2 + 1,).

    Chance makes `degrees_of_freedom` of it.
    """
    power = np.abs(spectrum(difference_rad)) ** 2 * degrees_of_freedom(difference_rad.size)
    return np.asarray(power / np.maximum(order_variance_rad2, np.finfo(float).tiny))


def p_value(chi_square_sum: Array | float, freedom: Array | float) -> Any:
    """Probability that noise alone makes a chi-square of so many degrees of freedom as large, or larger; any shape."""
    return gammaincc(np.maximum(freedom, 1e-9) / 2, np.asarray(chi_square_sum) / 2)
