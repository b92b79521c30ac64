r"""What one pixel sees over the wheel angle, harmonic by harmonic, and its derivatives.

.. math:: F_{pm} = C_p\, K_{pm}\, \Omega_m\, R_m(\tau_p)\, e^{i m \omega \delta_p}

with :math:`C_p` the contrast of the pixel, :math:`K_{pm}` how its light lies over polar angle (1 at m = 0 for a pixel wholly in
the light; blur and the pixel's own width make it smaller as m grows, by a real factor away from the opening's border),
:math:`\Omega_m` what all pixels share: the wheel's edges and what frames keep of those before; :math:`R` the response
(`physics.response`) and :math:`\delta_p` the delay of the pixel's reading, or of its window's middle.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.physics.camera import Response
from irtiming.records.arrays import Array, ComplexArray, Ticks


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PixelLight:
    """Light of some pixels before the wheel: ``orders`` (s,), K (s, p) and Omega (s,), rad/s, and how pixels respond."""

    orders: Ticks
    light: ComplexArray
    wheel: ComplexArray
    angular_frequency_rad_per_s: float
    response: Response


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PixelNumbers:
    """Contrast (DN), delay and the response's parameter (s) of pixels, shapes (p,)."""

    contrast_dn: Array
    delay_s: Array
    response_s: Array


def linearised(pixels: PixelLight, at: PixelNumbers) -> tuple[ComplexArray, ComplexArray]:
    """Harmonics F, shape (s, p), and their derivatives to contrast, delay and the response's parameter, shape (3, s, p).

    Parameters
    ----------
    pixels, at
        Of the same pixels.
    """
    omega, orders = pixels.angular_frequency_rad_per_s, pixels.orders[:, None]
    still = pixels.light * pixels.wheel[:, None] * np.exp(1j * omega * orders * at.delay_s)
    passed, slope = _response(pixels, at.response_s)
    observed = at.contrast_dn * still * passed
    return observed, np.array([still * passed, 1j * omega * orders * observed, at.contrast_dn * still * slope])


def _response(pixels: PixelLight, parameter_s: Array) -> tuple[ComplexArray, ComplexArray]:
    """R and its derivative at each pixel's own parameter, shape (s, p): harmonic m is the first at m times the speed."""
    each, response = parameter_s[:, None], pixels.response
    speeds = [pixels.angular_frequency_rad_per_s * order for order in pixels.orders.tolist()]
    passed = [response.transfer(speed, each, n_harmonics=1)[:, 1] for speed in speeds]
    slope = [response.transfer_slope(speed, each, n_harmonics=1)[:, 1] for speed in speeds]
    return np.array(passed), np.array(slope)
