r"""Microbolometer pixel over a wide range of temperatures: two time constants and Planck's law (Schatz 2023, section 4).

A pixel exchanges heat with the detector's substrate by conduction, which is linear, and with the scene by radiation, which is
not. With the in-band radiance L of `physics.radiance`,

.. math:: \dot T_{pixel} = \frac{T_{sub} - T_{pixel}}{\tau_{substrate}}
          + \frac{L(T_{scene}) - L(T_{pixel})}{L'(T_0)\,\tau_{scene}}

where :math:`\tau_{scene}` is stated at the reference temperature :math:`T_0`. Where the pixel covers so small a range that
:math:`L` is straight, this is eq. 2 with

.. math:: \frac{1}{\tau} = \frac{1}{\tau_{substrate}} + \frac{L'(T_{pixel})}{L'(T_0)}\,\frac{1}{\tau_{scene}}

so :math:`\tau` falls as the pixel gets warmer. Within a pixel that sees two surfaces, radiances add, not temperatures.

Assumed: a black scene, a substrate of one temperature, and all radiation of the pixel but that to the scene counted with the
substrate, where it is nearly constant.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from irtiming.physics.radiance import MICROBOLOMETER_BAND_M, Band, in_band_radiance, radiance_slope
from irtiming.records.arrays import Array

REFERENCE_TEMPERATURE_K = 300.0
"""Where the constant of the exchange with the scene is stated, unless said otherwise."""

_MOST_STEPS = 50
_SETTLED_K = 1e-10


@final
@dataclass(frozen=True, kw_only=True)
class TwoConstants:
    """The two constants of a pixel, s.

    ``scene_time_constant_s`` holds for a pixel at ``reference_temperature_k``; infinite, nothing is left but eq. 2.
    """

    substrate_time_constant_s: float
    scene_time_constant_s: float
    reference_temperature_k: float = REFERENCE_TEMPERATURE_K
    band_m: Band = MICROBOLOMETER_BAND_M


def relative_slope(model: TwoConstants, pixel_temperature_k: ArrayLike) -> Array:
    """L'(T_pixel) / L'(T_0): by how much the radiance is steeper there than at the reference; same shape."""
    reference = _reference_slope(model.reference_temperature_k, model.band_m)
    return np.asarray(radiance_slope(pixel_temperature_k, band_m=model.band_m) / reference)


def effective_time_constant(model: TwoConstants, pixel_temperature_k: ArrayLike) -> Array:
    """Time constant tau of eq. 2 for a pixel that stays near a temperature; same shape, s."""
    slope = relative_slope(model, pixel_temperature_k)
    return np.asarray(1 / (1 / model.substrate_time_constant_s + slope / model.scene_time_constant_s))


def steady_temperature(model: TwoConstants, scene_temperature_k: ArrayLike, *, substrate_temperature_k: float) -> Array:
    """Temperature of a pixel that has faced the same scene for long: between scene and substrate.

    Parameters
    ----------
    model
        The pixel.
    scene_temperature_k
        Any shape, above 0; K.
    substrate_temperature_k
        Of the detector's substrate, K.

    Returns
    -------
    Same shape; K. Newton's method from the substrate's temperature; the balance is smooth and monotonic.
    """
    radiance = in_band_radiance(scene_temperature_k, band_m=model.band_m)
    per_radiance = _per_radiance(model)
    pixel = np.full_like(radiance, substrate_temperature_k)
    for _ in range(_MOST_STEPS):
        gain = (substrate_temperature_k - pixel) / model.substrate_time_constant_s
        gain += per_radiance * (radiance - in_band_radiance(pixel, band_m=model.band_m))
        move = gain * effective_time_constant(model, pixel)
        pixel = np.maximum(pixel + move, 0.5 * pixel)
        if np.all(np.abs(move) < _SETTLED_K):
            break
    return pixel


def after_step(
    model: TwoConstants, time_s: ArrayLike, *, from_scene_k: float, to_scene_k: float, substrate_temperature_k: float
) -> Array:
    r"""Temperature of a pixel after its scene has stepped from one temperature to another, where it had settled.

    Parameters
    ----------
    model
        The pixel.
    time_s
        Any shape, since the step, not negative; s.
    from_scene_k, to_scene_k, substrate_temperature_k
        Temperatures, K.

    Returns
    -------
    Same shape; K.

    Notes
    -----
    Radiance counts as a parabola with Planck's slopes at both ends. The distance v from the end then obeys a Riccati equation,
    :math:`\dot v = -v (1/\tau_{end} + q v)`, with the solution
    :math:`v = v_0 e^{-t/\tau_{end}} / (1 + q \tau_{end} v_0 (1 - e^{-t/\tau_{end}}))`. Warming ends faster than it
    begins, cooling slower. With q = 0 it is the exponential of eq. 2.
    """
    scenes = np.array([from_scene_k, to_scene_k])
    start, end = steady_temperature(model, scenes, substrate_temperature_k=substrate_temperature_k)
    lag_s = float(effective_time_constant(model, end))
    decay = np.exp(-np.asarray(time_s, dtype=np.float64) / lag_s)
    bend = lag_s * _bend_per_s_k(model, float(start), float(end)) * (start - end)
    return np.asarray(end + (start - end) * decay / (1 + bend * (1 - decay)))


def bending(model: TwoConstants, first_k: ArrayLike, *, second_k: ArrayLike) -> Array:
    r"""How unlike an exponential the answer of a pixel is that alternates between two temperatures.

    Parameters
    ----------
    model
        The pixel.
    first_k, second_k
        Steady temperatures of the pixel, same shape; K.

    Returns
    -------
    Same shape; by how much the rate of return at the ends differs from that in the middle, as a share of the latter, halved:
    the :math:`\varepsilon` of the explanation of wide temperature ranges. Not negative.
    """
    first, second = np.asarray(first_k, dtype=np.float64), np.asarray(second_k, dtype=np.float64)
    steeper = relative_slope(model, second) - relative_slope(model, first)
    lag_s = effective_time_constant(model, (first + second) / 2)
    return np.asarray(np.abs(steeper) * lag_s / (4 * model.scene_time_constant_s))


def _per_radiance(model: TwoConstants) -> float:
    """Warming of the pixel per radiance of the scene, K s^-1 / (W m^-2 sr^-1)."""
    return 1 / (_reference_slope(model.reference_temperature_k, model.band_m) * model.scene_time_constant_s)


@lru_cache(maxsize=8)
def _reference_slope(reference_temperature_k: float, band_m: Band) -> float:
    """L'(T_0), W m^-2 sr^-1 K^-1."""
    return float(radiance_slope(reference_temperature_k, band_m=band_m))


def _bend_per_s_k(model: TwoConstants, start_k: float, end_k: float) -> float:
    """The q of the Riccati equation, s^-1 K^-1."""
    if start_k == end_k:
        return 0.0
    at_start, at_end = relative_slope(model, [start_k, end_k])
    return float((at_end - at_start) / (end_k - start_k) / (2 * model.scene_time_constant_s))
