"""Random numbers by name, and the detector: fixed pattern, noise, whole numbers, clipping.

Every random number depends on (seed, purpose, index), so that any frame can be made again by itself.
"""

from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias, final, get_args

import numpy as np
import numpy.typing as npt
from numba import njit

from irtiming.records.arrays import Pixels
from irtiming.twin.response_curve import ResponseCurve
from irtiming.twin.scene import Detector

Values: TypeAlias = npt.NDArray[np.float32]
"""Detector signal before it becomes whole numbers; shape (row, column), DN."""

Purpose = Literal[
    "rig",
    "motion",
    "edges",
    "faults",
    "exposure",
    "frame",
    "pattern",
    "reference_low",
    "reference_high",
    "run",
    "correction",
    "sway",
    "laboratory",
    "statement",
    "pulses",
    "free camera",
]
"""What a series of random numbers is for; the order counts, so add at the end."""


def generator(seed: int, purpose: Purpose, *, index: int = 0) -> np.random.Generator:
    """Random numbers that depend on these three and nothing else."""
    return np.random.Generator(np.random.SFC64([seed, get_args(Purpose).index(purpose), index]))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FixedPattern:
    """Gain and offset (DN) of each pixel and where it is dead; shape (row, column). Its curve comes before the noise."""

    gain: Values
    offset_dn: Values
    highest_dn: float
    noise_dn: float
    row_noise_dn: float = 0.0
    curve: ResponseCurve = field(default_factory=ResponseCurve)


def fixed_pattern(detector: Detector) -> FixedPattern:
    """Pattern of this detector: value = offset + gain x signal.

    A dead pixel has no gain and sits at 0 or at the top.
    """
    shape = (detector.rows, detector.columns)
    random = generator(detector.pattern_seed, "pattern")
    gain = 1 + detector.gain_spread * random.standard_normal(shape, dtype=np.float32)
    offset = detector.offset_spread_dn * random.standard_normal(shape, dtype=np.float32)
    highest = min(2.0**detector.bits - 1, detector.saturation_dn)
    dead = random.choice(gain.size, size=min(detector.dead_pixels, gain.size), replace=False)
    gain.flat[dead] = 0
    offset.flat[dead] = np.where(random.random(dead.size) < 0.5, -1e3, highest + 1e3)
    return FixedPattern(
        gain=gain,
        offset_dn=offset,
        highest_dn=highest,
        noise_dn=detector.noise_dn,
        row_noise_dn=detector.row_noise_dn,
        curve=detector.curve,
    )


def corrected_pattern(detector: Detector, surface_dn: float, *, residual: Values) -> FixedPattern:
    """Pattern that is left after the camera has corrected itself on a surface of this level.

    Parameters
    ----------
    detector
        Gain and dead pixels.
    surface_dn
        Level at which only the residual offset is left.
    residual
        Shape (row, column), multiples of the detector's spread of offsets.
    """
    pattern = fixed_pattern(detector)
    offset = detector.offset_spread_dn * residual + (1 - pattern.gain) * surface_dn
    return replace(pattern, offset_dn=np.where(pattern.gain == 0, pattern.offset_dn, offset).astype(np.float32))


def digitise(signal_dn: Values, pattern: FixedPattern, *, random: np.random.Generator, out: Pixels | Values) -> None:
    """What the detector gives for a signal, written into ``out``: whole numbers, unless that is made for others.

    Parameters
    ----------
    signal_dn
        Shape (row, column), DN of a mean pixel.
    pattern
        Gain, offset, noise and highest value.
    random
        Source of the noise of this frame.
    out
        Shape (row, column).
    """
    noise, row_noise = np.zeros(signal_dn.size, np.float32), np.zeros(signal_dn.shape[0], np.float32)
    if pattern.noise_dn > 0:
        noise = _normal(random, noise.size)
    if pattern.row_noise_dn > 0:
        row_noise = _normal(random, row_noise.size) * np.float32(pattern.row_noise_dn)
    curve = pattern.curve
    _read_out(
        (signal_dn, pattern.gain, pattern.offset_dn), (curve.exponent, curve.low_dn, curve.high_dn),
        noise.reshape(signal_dn.shape), row_noise,
        (pattern.noise_dn, pattern.highest_dn, 0.5 if out.dtype == np.uint16 else 0.0), out,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def _normal(random: np.random.Generator, n: int) -> Values:
    """Normal deviates: to the last bit those of NumPy's own call, which takes half as long again."""
    deviates: Values = random.standard_normal(n, dtype=np.float32)
    return deviates


@njit(cache=True, nogil=True)
def _read_out(
    seen: tuple[Values, Values, Values],
    curve: tuple[float, float, float],
    noise: Values,
    row_noise: npt.NDArray[np.float32],
    scale: tuple[float, float, float],
    out: Pixels | Values,
) -> None:
    """Signal with gain, offset, curve and noise, clipped and rounded, in one pass; numbers of 32 bits but for the curve.

    ``scale`` is the noise, the highest value, and what makes a cut a rounding.
    """
    signal, gain, offset = seen
    noise_dn, highest, half = np.float32(scale[0]), np.float32(scale[1]), np.float32(scale[2])
    lowest = np.float32(0)
    exponent, low, span = curve[0], curve[1], curve[2] - curve[1]
    for row in range(signal.shape[0]):
        for column in range(signal.shape[1]):
            value = signal[row, column] * gain[row, column] + offset[row, column]
            if exponent != 1:
                value = np.float32(low + span * max(0.0, (value - low) / span) ** exponent)
            value = value + noise[row, column] * noise_dn + row_noise[row]
            out[row, column] = min(max(value, lowest), highest) + half
