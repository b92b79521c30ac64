r"""What the wheel uncovers, as harmonics of its angle.

The wheel turns evenly, so what a pixel is shown repeats every turn: :math:`q(\theta) = \mathrm{Re} \sum_m q_m e^{i m \theta}`,
m = 0 .. M; an array of its harmonics has m last. A camera's response (`physics.response`) multiplies harmonic m by a number, a
later reading (`physics.readout`) turns it by exp(i m omega delay): no time is stepped.
"""

import math

import numpy as np

from irtiming.physics.wheel import EDGE_SIGNS, TURN
from irtiming.records.arrays import Array, ComplexArray
from irtiming.records.wheel_geometry import EdgeAngles, WheelModel


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
    The mean (m = 0) is shared evenly among the edges. Edge i at a delay d later is multiplied by exp(i m omega d).

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


def later(phase_rad: Array, *, n_harmonics: int) -> ComplexArray:
    """Factor exp(i m phase) on the harmonics of something read while the wheel has turned on by ``phase_rad``.

    ``phase_rad`` has any shape, here with (M + 1,) added. Each power is a product of one of a few and one of every so many: a
    product takes a tenth of the time of an exponential.
    """
    phase, few = np.asarray(phase_rad, float), math.isqrt(n_harmonics) + 1
    first, every = (np.exp(1j * np.multiply.outer(phase, step * np.arange(few))) for step in (1, few))
    powers = every[..., :, None] * first[..., None, :]
    return np.asarray(powers.reshape(*phase.shape, few * few)[..., : n_harmonics + 1])


def at_angles(harmonics: ComplexArray, wheel_angle_rad: Array) -> Array:
    """Values at wheel angles, shape (..., n), from harmonics of shape (..., M + 1) and angles of shape (n,)."""
    waves = later(wheel_angle_rad, n_harmonics=harmonics.shape[-1] - 1).T
    return np.asarray((harmonics.real @ waves.real) - (harmonics.imag @ waves.imag))


def _open_share(edges: EdgeAngles) -> float:
    return float(1 + sum(-sign * edge for sign, edge in zip(EDGE_SIGNS, edges, strict=True)) / TURN)
