"""Time constants over a wide range of temperatures: what the recordings show, and the two constants behind it."""

from dataclasses import dataclass
from typing import Literal, final

from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate
from irtiming.records.finding import Finding
from irtiming.records.result import Bound, EffectiveTimeConstants

WheelTemperatureFrom = Literal["you", "contrast", "assumption"]
"""Who says how warm the wheel is."""

NAMES = ("substrate_time_constant", "scene_time_constant")
"""Of the two constants, in a result."""


@final
@dataclass(frozen=True, kw_only=True)
class PixelSurroundings:
    """What a pixel exchanges heat with beside the blackbody, K.

    ``substrate_temperature_k`` is that of the detector's substrate, ``wheel_temperature_k`` what the solid wheel looks like;
    ``wheel_temperature_from`` tells where the latter comes from: a person, the contrast of the recordings, or neither.
    """

    substrate_temperature_k: float
    wheel_temperature_k: float
    wheel_temperature_from: WheelTemperatureFrom


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class TwoConstantsResult:
    """Separate time constants of a pixel's exchange with the substrate and with the scene (Schatz 2023, section 4).

    Parameters
    ----------
    estimate
        The two, with covariance; empty where they are not determined, then ``bounds`` has what is known.
    reference_temperature_k
        Temperature of a pixel for which the scene's constant is stated.
    surroundings
        As used.
    effective
        The time constants that were fitted, one per blackbody temperature.
    pixel_temperature_k
        Shape (k,); middle of the two steady temperatures of a pixel in each of them.
    model_time_constant_s
        Shape (k,); what the two constants make of them.
    scene_share
        Share of the scene in the pixel's exchange of heat at the reference temperature, 0 to 1.
    share_scan, deviation
        Shape (m,); shares tried, and twice the log-likelihood lost with each, the sum of both exchanges at its best.
    least_share
        Smallest share that these temperatures and uncertainties would determine; None where no share would.
    curve_blackbody_k, curve_time_constant_s
        Shape (j,); the model over the blackbody's temperature.
    change_per_k_s
        Shape (2, 2); change of either constant, row by row, per kelvin by which substrate and wheel are warmer than stated.
    bend_s
        Shape (k,); by how much the model's effective constants were raised because the answer to a large step is no
        exponential.
    bounds, findings
        Of constants that are not determined; doubts.
    """

    estimate: Estimate
    reference_temperature_k: float
    surroundings: PixelSurroundings
    effective: EffectiveTimeConstants
    pixel_temperature_k: Array
    model_time_constant_s: Array
    scene_share: float
    share_scan: Array
    deviation: Array
    least_share: float | None
    curve_blackbody_k: Array
    curve_time_constant_s: Array
    change_per_k_s: Array
    bend_s: Array
    bounds: tuple[Bound, ...]
    findings: tuple[Finding, ...]
