r"""Microbolometer pixels under a turning wheel, as harmonics of the wheel angle (Schatz 2023, eq. 2 and 3).

A pixel follows what it sees with a first-order lag, :math:`\tau \dot T_{pixel} = T_{asympt} - T_{pixel}` (eq. 2). The wheel
turns evenly, so what it sees repeats every turn. Once the run-in has died away, harmonic m of the pixel is harmonic m of
the scene times 1 / (1 + i m omega tau): no time is stepped. In the time domain this is the exponential that each passing
edge leaves behind. A later reading (eq. 3) turns harmonic m by exp(i m omega delay).

Every periodic quantity is q(theta) = Re sum_m q_m exp(i m theta), m = 0 .. M; an array of its harmonics has m last.
"""

import numpy as np

from irtiming.physics.wheel import EDGE_SIGNS, TURN, EdgeAngles, WheelModel
from irtiming.records.arrays import Array
from irtiming.records.rolling import ComplexArray


def open_harmonics(model: WheelModel, n_harmonics: int) -> ComplexArray:
    """Harmonics of whether the opening's centre is open, edge by edge.

    Parameters
    ----------
    model
        Wheel and opening; the radius and width of the opening do not matter here.
    n_harmonics
        Highest order M.

    Returns
    -------
    Shape (4, M + 1); their sum over the edges is 1 where the wheel is cut out at the opening's centre and 0 elsewhere.
    The mean (m = 0) is shared evenly among the edges. Edge i seen a delay d later is multiplied by exp(i m omega d).

    Notes
    -----
    Schatz 2023, figure 4(b), for a vanishing opening: a step of EDGE_SIGNS[i] at wheel coordinate alpha_i has the harmonics
    exp(-i m alpha_i) / (i pi m).
    """
    order = np.arange(1, n_harmonics + 1)
    at_centre = np.exp(1j * order * model.opening_coordinate_rad)
    steps = [
        sign * np.exp(-1j * order * edge) / (1j * np.pi * order) * at_centre
        for sign, edge in zip(EDGE_SIGNS, model.cutout_edges_rad, strict=True)
    ]
    mean = _open_share(model.cutout_edges_rad) / 4
    return np.concatenate([np.full((4, 1), mean, complex), np.array(steps)], axis=1)


def lag_factor(angular_frequency_rad_per_s: float, time_constant_s: float, *, n_harmonics: int) -> ComplexArray:
    """What the lag leaves of each harmonic: 1 / (1 + i m omega tau), shape (M + 1,)."""
    return np.asarray(1 / (1 + 1j * np.arange(n_harmonics + 1) * angular_frequency_rad_per_s * time_constant_s))


def later(phase_rad: Array, *, n_harmonics: int) -> ComplexArray:
    """Factor exp(i m phase) on the harmonics of something read while the wheel has turned on by ``phase_rad``.

    Shape of ``phase_rad`` with (M + 1,) added.
    """
    return np.asarray(np.exp(1j * np.multiply.outer(np.asarray(phase_rad, float), np.arange(n_harmonics + 1))))


def at_angles(harmonics: ComplexArray, wheel_angle_rad: Array) -> Array:
    """Values at wheel angles, shape (..., n), from harmonics of shape (..., M + 1) and angles of shape (n,)."""
    order = np.arange(harmonics.shape[-1])
    waves = np.exp(1j * np.multiply.outer(order, np.asarray(wheel_angle_rad, float)))
    return np.asarray((harmonics.real @ waves.real) - (harmonics.imag @ waves.imag))


def _open_share(edges: EdgeAngles) -> float:
    return float(1 + sum(-sign * edge for sign, edge in zip(EDGE_SIGNS, edges, strict=True)) / TURN)
