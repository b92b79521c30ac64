"""How much each pixel follows the wheel, and the outline of the mask opening from it.

A pixel of the opening is covered and uncovered twice a turn: the second harmonic of its values over the wheel angle is its
contrast, lowered by the lag alike for all. So no level need ever settle. Frames of a closed shutter or of a frozen camera
lower it further, alike for all. Around the opening the wheel turns before the mask plate: where that is not as warm as the
wheel, pixels follow the wheel too, but less.
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import ndimage

from irtiming.errors import ReductionError
from irtiming.physics import robust
from irtiming.records.arrays import Array, ComplexArray, Mask
from irtiming.reduce import kernels
from irtiming.reduce.opening import dead_pixels, mask_shape
from irtiming.reduce.opening.sample_frames import SampleFrames

_ORDERS = 12  # harmonics that are kept from leaking into the second where the angles are uneven
_FEWEST_SEEDS = 30
_FEWEST_THREES = 50
_NOISES = 8.0
_SMOOTHED_PX = 1.5  # over which the phase of neighbouring pixels is taken together
_AROUND_PX = (6, 20)  # from the seeds: where the plate shows


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Outline:
    """The opening as the second harmonic shows it.

    Shapes (row, column): ``harmonic``, DN; ``contrast``, 1 within the opening, about 0 around it, 0 far away; ``mask``, pixels
    beyond the threshold. ``interior_dn`` is the harmonic's amplitude within the opening, ``noise_dn`` its noise.
    """

    harmonic: ComplexArray
    contrast: Array
    interior_dn: float
    noise_dn: float
    mask: Mask
    border_px: int


def outline(sample: SampleFrames, good: Mask, *, threshold_level: float, name: str) -> Outline:
    """Outline of the opening.

    Parameters
    ----------
    sample
        Frames that were looked at.
    good
        Shape (frame,); those to use.
    threshold_level
        Place between the contrast around the opening (0) and in it (1) where the mask ends.
    name
        Of the recording, for messages.

    Raises
    ------
    ReductionError
        If no pixels follow the wheel together.
    """
    harmonic = _second_harmonic(sample, good)
    noise = noise_between_neighbours(harmonic, np.ones(harmonic.shape, bool))
    amplitude = np.hypot(ndimage.uniform_filter(harmonic.real, 3), ndimage.uniform_filter(harmonic.imag, 3))
    loud = float(np.quantile(amplitude, 0.995))
    seeds = mask_shape.largest_part(amplitude > 0.6 * loud)
    n_seeds, least_dn = int(seeds.sum()), _NOISES * noise + 1e-9
    if loud < least_dn or n_seeds < _FEWEST_SEEDS:
        cure = "check that the shutter is open, that the camera sees mask and blackbody and that they differ by some kelvin"
        if loud < least_dn:
            raise ReductionError(
                f"{name}: no opening found: the liveliest pixels swing by {loud:.1f} DN with the wheel, at least {least_dn:.1f} "
                f"DN must be, {_NOISES:g} times the noise; {cure}"
            )
        raise ReductionError(
            f"{name}: no opening found: {n_seeds} pixels side by side swing with the wheel, at least {_FEWEST_SEEDS} must; {cure}"
        )
    near = _box(seeds)
    nearby, interior = _contrast(harmonic[near], seeds[near])
    away = ndimage.distance_transform_edt(~seeds[near])
    around = (away > _AROUND_PX[0]) & (away < _AROUND_PX[1])
    plate = float(np.median(nearby[around])) if around.any() else 0.0
    nearby = (nearby - plate) / (1 - plate)
    mended = dead_pixels.mended(nearby)
    inside = (ndimage.uniform_filter(mended, 3) > threshold_level) & (mended > 0.6 * threshold_level)
    inside = np.asarray(ndimage.binary_fill_holes(mask_shape.largest_part(inside)))
    mask, contrast = np.zeros_like(seeds), np.zeros(seeds.shape)
    mask[near], contrast[near] = inside, nearby
    return Outline(
        harmonic=harmonic,
        contrast=contrast,
        interior_dn=interior,
        noise_dn=noise,
        mask=mask,
        border_px=mask_shape.border_px(mended, inside, plate=abs(plate)),
    )


def noise_between_neighbours(image: ComplexArray, area: Mask) -> float:
    """Noise of the real and of the imaginary part of a pixel in the area, from how it strays from its two neighbours' mean.

    Shapes (row, column). The larger of those along rows and along columns: noise that a row has in common shows along columns
    only. Nan where the area has fewer than 50 such threes.
    """
    found = []
    for picture, taken in ((image, area), (image.T, area.T)):
        beside = picture[1:-1] - 0.5 * (picture[:-2] + picture[2:])
        beside = beside[taken[1:-1] & taken[:-2] & taken[2:]]
        if beside.size < _FEWEST_THREES:
            return float("nan")
        parts = np.concatenate([beside.real, beside.imag])
        found.append(robust.spread(parts) / np.sqrt(1.5))
    return float(max(found))


def _box(seeds: Mask) -> tuple[slice, slice]:
    """Part of the image that holds the seeds and what is around them."""
    rows, columns = np.flatnonzero(seeds.any(axis=1)), np.flatnonzero(seeds.any(axis=0))
    reach = _AROUND_PX[1] + 4
    return (
        slice(max(0, int(rows[0]) - reach), int(rows[-1]) + reach + 1),
        slice(max(0, int(columns[0]) - reach), int(columns[-1]) + reach + 1),
    )


def _second_harmonic(sample: SampleFrames, good: Mask) -> ComplexArray:
    """Second harmonic of each pixel over the common level, shape (row, column), DN: fitted beside the other orders."""
    phase = np.arange(1, _ORDERS + 1) * sample.wheel_angle_rad[good, None]
    design = np.concatenate([np.ones((len(phase), 1)), np.cos(phase), np.sin(phase)], axis=1)
    inverse = np.linalg.pinv(design, rcond=0.05)
    weight = np.zeros((2, good.size))
    weight[:, good] = inverse[2], -inverse[_ORDERS + 2]
    sums = np.zeros((3, *sample.values.shape[1:]))
    kernels.add_projection(sample.values, weight[0], weight[1], sums)
    common = weight @ sample.common_dn
    return np.asarray(sums[0] - common[0] + 1j * (sums[1] - common[1]))


def direction(harmonic: ComplexArray, inner: Mask) -> ComplexArray:
    """Phase of the nearest ``inner`` pixels of the opening, as a number of size 1; all of shape (row, column)."""
    within = np.where(inner, harmonic, 0.0)
    smooth = ndimage.gaussian_filter(within.real, _SMOOTHED_PX) + 1j * ndimage.gaussian_filter(
        within.imag, _SMOOTHED_PX
    )
    nearest = ndimage.distance_transform_edt(~inner, return_distances=False, return_indices=True)
    smooth = smooth[tuple(nearest)]
    return np.asarray(smooth / np.maximum(np.abs(smooth), 1e-300))


def _contrast(harmonic: ComplexArray, seeds: Mask) -> tuple[Array, float]:
    """The part of each harmonic in phase with the nearest pixels of the opening, over that of the opening; and the latter.

    Where the plate is on the other side of the wheel's temperature than the blackbody, it is negative.
    """
    inner = ndimage.binary_erosion(seeds)
    inner = np.asarray(inner if inner.sum() >= _FEWEST_SEEDS else seeds)
    in_phase = (harmonic * direction(harmonic, inner).conj()).real
    interior = float(np.median(in_phase[inner]))
    return np.asarray(in_phase / interior), interior
