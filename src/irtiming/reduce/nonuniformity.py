"""Two-point non-uniformity correction, folded into thresholds and weights so that no frame is ever corrected.

The corrected value of pixel p is  L + (raw - low_p) (H - L) / (high_p - low_p),  with low_p and high_p its mean values
at the two reference temperatures and L, H their means over the detector (Schatz 2023, 3.1.2).
"""

import hashlib
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
import numpy.typing as npt

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, Mask, Pixels
from irtiming.records.recording import Recording
from irtiming.records.reduced import Region

_LEAST_RESPONSE = 0.3  # of the median: a pixel that answers less to the reference step is dead
_LARGEST_NOISE = 6.0  # times the median noise: a pixel beyond is blinking
_BAD_SHARE = 0.05


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Correction:
    """corrected = offset_dn + gain * raw, per pixel; shapes (row, column). ``is_none`` where that changes nothing."""

    gain: Array
    offset_dn: Array
    bad: Mask
    is_none: bool = False

    def within(self, roi: Region) -> "Correction":
        """That of a region of interest: first row, end row, first column, end column, ends excluded."""
        return self.at((slice(*roi[:2]), slice(*roi[2:])))

    def at(self, part: tuple[slice, slice]) -> "Correction":
        """That of some rows and columns."""
        return replace(self, gain=self.gain[part], offset_dn=self.offset_dn[part], bad=self.bad[part])


def correction(recording: Recording) -> Correction:
    """Correction from the reference frames of the recording; none (gain 1) where it has no reference.

    Raises
    ------
    ReductionError
        If the references have another size than the frames, no step between them or one down, or too many dead pixels.
    """
    shape = recording.frames.shape[1:]
    reference = recording.nonuniformity
    if reference is None:
        nothing = np.zeros(shape)
        return Correction(gain=np.ones(shape), offset_dn=nothing, bad=nothing.astype(bool), is_none=True)
    if reference.low_dn.shape != shape:
        raise ReductionError(
            f"{recording.name}: the reference frames measure {reference.low_dn.shape} pixels, the frames {shape}; "
            "record the references with the same window"
        )
    step = reference.high_dn - reference.low_dn
    response = float(np.median(step))
    noise = np.maximum(reference.low_noise_dn, reference.high_noise_dn)
    least = 3 * float(np.median(noise)) / np.sqrt(max(reference.n_frames, 1))
    if response < -least:
        raise ReductionError(
            f"{recording.name}: low and high of nonuniformity_reference are exchanged: high is {-response:.1f} DN (median) "
            "darker than low, and must be the brighter one, of the warmer blackbody; exchange the two"
        )
    if not response > least:
        raise ReductionError(
            f"{recording.name}: the two reference recordings differ by {response:.1f} DN (median), which is no more than "
            "their noise; low and high must be the bare blackbody at two temperatures"
        )
    bad = (step < _LEAST_RESPONSE * response) | (step > response / _LEAST_RESPONSE)
    bad |= noise > _LARGEST_NOISE * float(np.median(noise))
    alone = bad[~np.all(bad, axis=1)]  # dead rows are others' business
    if alone.sum() > _BAD_SHARE * bad.size:
        raise ReductionError(
            f"{recording.name}: {alone.sum()} of {bad.size} pixels do not answer to the reference step or blink, at most "
            f"{_BAD_SHARE:.0%} can be replaced by their neighbours; check nonuniformity_reference"
        )
    good = ~bad
    low, high = float(reference.low_dn[good].mean()), float(reference.high_dn[good].mean())
    gain = np.where(bad, 0.0, (high - low) / np.where(bad, 1.0, step))
    return Correction(gain=gain, offset_dn=np.where(bad, low, low - gain * reference.low_dn), bad=bad)


def corrected(raw: Pixels, correct: Correction) -> npt.NDArray[np.float32]:
    """Corrected frames, DN, shape (..., row, column); only for the few frames that people look at."""
    values: npt.NDArray[Any] = raw * correct.gain.astype(np.float32) + correct.offset_dn.astype(np.float32)
    return values.astype(np.float32, copy=False)


def raw_thresholds(threshold_dn: float, correct: Correction) -> Pixels:
    """Raw value that each pixel must exceed for its corrected value to exceed the threshold, shape (row, column).

    Exact: a whole number exceeds x just when it exceeds floor(x), and what the division rounds is set right. Bad pixels get
    the largest value: never exceeded. A raw value of 0 exceeds nothing, whatever the threshold.
    """
    gain = np.where(correct.bad, 1.0, correct.gain)
    level = np.floor((threshold_dn - correct.offset_dn) / gain)
    level += correct.offset_dn + gain * (level + 1) <= threshold_dn
    level -= correct.offset_dn + gain * level > threshold_dn
    return np.where(correct.bad, 65535, np.clip(level, 0, 65535)).astype(np.uint16)


def u_gain(recording: Recording, correct: Correction) -> Array:
    """Relative standard uncertainty of each pixel's gain, since references have finitely many frames, shape (row, column).

    Parameters
    ----------
    recording, correct
        With its references, and what was made of them; 0 everywhere without, and for bad pixels.
    """
    reference = recording.nonuniformity
    if reference is None:
        return np.zeros(recording.frames.shape[1:])
    noise = np.hypot(reference.low_noise_dn, reference.high_noise_dn) / np.sqrt(max(reference.n_frames, 1))
    return np.where(correct.bad, 0.0, noise / np.where(correct.bad, 1.0, reference.high_dn - reference.low_dn))


def fingerprint(recording: Recording) -> str:
    """What tells references from others: sha256 of their mean frames; empty without.

    Parameters
    ----------
    recording
        With its references.
    """
    reference = recording.nonuniformity
    if reference is None:
        return ""
    return hashlib.sha256(reference.low_dn.tobytes() + reference.high_dn.tobytes()).hexdigest()
