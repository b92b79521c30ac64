"""The contrast image of a camera whose levels sway: what a fit of its sums found of gain and offset is taken into account.

A pixel of the light L and the mean level c shows c + (g - 1) (c - b) + a (g L (w - <w>) + o) in a frame of the relative gain g
and the offset o, b being the level of the opening behind the wheel, a its contrast, and w, of the mean <w>, what the wheel lets
through. A sway that is another one in frames that show one part of the opening than in those that show another turns the phases
of the whole image. Where triggers visit the wheel's angles in slow turns, a sway of a hundredth does so by a milliradian.
"""

from dataclasses import replace

import numpy as np

from irtiming.records.arrays import Array
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.reduced import LevelSway, ReducedRecording
from irtiming.records.row_timing import RowTimingFit


def by_rows(recording: ReducedRecording, fit: RowTimingFit) -> ReducedRecording:
    """The recording with a contrast image that knows what a fit of its rows found.

    Parameters
    ----------
    recording
        Whose contrast image, rid of a recursive filter, is of the frames that were fitted.
    fit
        Without a sway it leaves the image as it is. Between two shutter events the gain of the rows is the fit's own.
    """
    sway = fit.sway
    if sway is None:
        return recording
    between = np.searchsorted(np.unique(recording.segment[fit.kept]), recording.segment)
    contrast_dn = fit.contrast_dn[np.minimum(between, fit.contrast_dn.size - 1)]
    mean_dn, n = float(contrast_dn.mean()), sway.offset_amounts.size
    u = _root(sway.covariance)
    return _steadied(
        recording,
        LevelSway(
            relative_gain=sway.relative_gain * contrast_dn / mean_dn,
            u_gain=sway.gains @ u[n:],
            u_offset=sway.offsets @ u[:n],
        ),
        offset_dn=sway.offset_change * mean_dn,
        covered_dn=_opening_dn(recording) - mean_dn * float(fit.harmonics[:, 0].real.mean()),
    )


def by_sums(recording: ReducedRecording, fit: EdgeDelayFit) -> ReducedRecording:
    """The same for a fit of pixel sums.

    Parameters
    ----------
    recording
        Of which some frames may not have been fitted.
    fit
        Without levels it leaves the image as it is.
    """
    levels = fit.levels
    if levels is None:
        return recording
    known = np.flatnonzero(fit.kept)

    def every(curves: Array) -> Array:
        """Curves of all frames, (n, k) or (n,), from those of the frames that were fitted."""
        return curves[known[np.abs(np.arange(curves.shape[0])[:, None] - known).argmin(axis=1)]]

    n, u = levels.drift.shape[1], _root(levels.covariance)
    pixels = float(recording.opening.weight.sum())  # over which a sum goes: an offset is alike in all of them
    contrast_dn = levels.step_dn / float(recording.opening.mask.sum())
    return _steadied(
        recording,
        LevelSway(
            relative_gain=every(levels.relative_gain),
            u_gain=every(levels.gain) @ u[n:],
            u_offset=every(levels.drift) @ u[:n] * (levels.step_dn / pixels / contrast_dn),
        ),
        offset_dn=every(levels.relative_offset) * (levels.step_dn / pixels),
        covered_dn=_opening_dn(recording) - contrast_dn * float(fit.fraction.mean()),
    )


def _steadied(recording: ReducedRecording, sway: LevelSway, *, offset_dn: Array, covered_dn: float) -> ReducedRecording:
    """With an image rid of offsets, (n,), and of what the gain does to a pixel's level beside that of the covered opening."""
    image = recording.contrast_image
    by_gain, level = (complex(image.frame_weight @ curve) for curve in (sway.relative_gain, offset_dn))
    own_dn = recording.pixel_maps["mean_dn"] - covered_dn
    steady = replace(image, projection_dn=image.projection_dn - own_dn * by_gain - level, sway=sway)
    return replace(recording, contrast=steady)


def _opening_dn(recording: ReducedRecording) -> float:
    """Mean level of the opening's pixels."""
    opening = recording.opening
    box = np.s_[slice(*opening.roi[:2]), slice(*opening.roi[2:])]
    return float(recording.pixel_maps["mean_dn"][opening.mask[box]].mean())


def _root(covariance: Array) -> Array:
    """U with U U' = covariance, (n, n), whatever its rank."""
    variance, axes = np.linalg.eigh(covariance)
    return np.asarray(axes * np.sqrt(np.maximum(variance, 0.0)))
