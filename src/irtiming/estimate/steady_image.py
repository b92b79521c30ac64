"""The contrast image with what a fit of the recording's sums found: edges, a warmer blade, levels that sway.

A pixel of the light L and the mean level c shows c + (g - 1) (c - b) + a (g L (w - <w>) + o) in a frame of the relative gain g
and the offset o, b being the level of the opening behind the wheel, a its contrast, and w, of the mean <w>, what the wheel lets
through. A sway that is another one in frames that show one part of the opening than in those that show another turns the phases
of the whole image. Where triggers visit the wheel's angles in slow turns, a sway of a hundredth does so by a milliradian; and
there all orders of the wheel show in the image, so that each edge must be where it is.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.estimate import frame_jitter
from irtiming.physics import wheel_waves
from irtiming.physics.covariance import root
from irtiming.physics.light.row_sum import BLADE
from irtiming.records.arrays import Array
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit
from irtiming.records.pixel_waves import PixelWaves
from irtiming.records.reduced import ContrastImage, FoundInSums, ReducedRecording
from irtiming.records.row_timing import RowTimingFit


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Sway:
    """``found`` in the sums, offset of each kept frame (n,), and each pixel's level beside that of the covered opening, DN."""

    found: FoundInSums
    offset_dn: Array
    own_dn: Array

    def image_of(self, recording: ReducedRecording) -> ContrastImage:
        """The contrast image rid of offsets and of what the gain does to a pixel's own level."""
        image = recording.contrast_image
        by_gain, level = (complex(image.frame_weight @ curve) for curve in (self.found.relative_gain, self.offset_dn))
        return replace(image, projection_dn=image.projection_dn - self.own_dn * by_gain - level, in_sums=self.found)

    def waves_of(self, recording: ReducedRecording) -> PixelWaves | None:
        """The same for sums with waves, where there are any."""
        waves = recording.waves
        if waves is None:
            return None
        first_row, _, first_column, _ = recording.opening.roi
        own_dn = self.own_dn[waves.row_px - first_row, waves.column_px - first_column]
        weight = wheel_waves.waves(waves.wheel_angle_rad, waves.orders, segment=waves.segment)
        sway_dn = np.outer(weight @ self.found.relative_gain, own_dn) + (weight @ self.offset_dn)[:, None]
        return replace(waves, sums_dn=waves.sums_dn - sway_dn)


def with_waves(recording: ReducedRecording, fit: EdgeDelayFit | RowTimingFit) -> ReducedRecording:
    """The recording whose contrast image and waves know what its fit found; waves are of use for maps alone."""
    sway = _of_rows(recording, fit) if isinstance(fit, RowTimingFit) else _of_sums(recording, fit)
    if sway is None:
        return recording
    return replace(recording, contrast=sway.image_of(recording), waves=sway.waves_of(recording))


def by_rows(recording: ReducedRecording, fit: RowTimingFit) -> ReducedRecording:
    """The recording with a contrast image that knows what a fit of its rows found.

    Parameters
    ----------
    recording
        Whose contrast image, rid of a recursive filter, is of the frames that were fitted.
    fit
        Between two shutter events the gain of the rows is the fit's own.
    """
    known = replace(recording, contrast=_of_rows(recording, fit).image_of(recording))
    return replace(known, contrast=_noisier(known, fit))


def _of_rows(recording: ReducedRecording, fit: RowTimingFit) -> _Sway:
    n_frames, sway = recording.trigger_ticks.size, fit.sway
    between = np.searchsorted(np.unique(recording.segment[fit.kept]), recording.segment)
    contrast_dn = fit.contrast_dn[np.minimum(between, fit.contrast_dn.size - 1)]
    mean_dn = float(contrast_dn.mean())
    relative_gain, offset, columns = contrast_dn / mean_dn, np.zeros(n_frames), np.zeros((2, n_frames, 0))
    if sway is not None:
        n, u = sway.offset_amounts.size, root(sway.covariance)
        relative_gain, offset = relative_gain * sway.relative_gain, sway.offset_change
        columns = np.array([sway.gains @ u[n:], sway.offsets @ u[:n]])
    found = FoundInSums(
        edges_late_rad=fit.angular_frequency_rad_per_s * fit.edge_delay_s,
        blade_share=fit.timing.get(BLADE, 0.0),
        relative_gain=relative_gain,
        u_gain=columns[0],
        u_offset=columns[1],
    )
    covered_dn = _opening_dn(recording) - mean_dn * float(fit.harmonics[:, 0].real.mean())
    return _Sway(found=found, offset_dn=offset * mean_dn, own_dn=recording.pixel_maps["mean_dn"] - covered_dn)


def _noisier(recording: ReducedRecording, fit: RowTimingFit) -> ContrastImage:
    """With the noise of whole frames, whose delays scatter, beside that of single pixels."""
    image = recording.contrast_image
    pixel_dn = image.u_dn * float(np.sqrt(image.frame_weight.size / 2))
    noise = pixel_dn * np.sqrt(recording.opening.n_summed(fit.row_px)) / np.abs(fit.gain_dn)
    more = frame_jitter.excess(frame_jitter.scatter(recording, fit), fit, noise=noise)
    return replace(image, u_dn=image.u_dn * float(np.sqrt(more)))


def by_sums(recording: ReducedRecording, fit: EdgeDelayFit) -> ReducedRecording:
    """The same for a fit of pixel sums.

    Parameters
    ----------
    recording
        Of which some frames may not have been fitted.
    fit
        Whose levels are known.
    """
    sway = _of_sums(recording, fit)
    return recording if sway is None else replace(recording, contrast=sway.image_of(recording))


def _of_sums(recording: ReducedRecording, fit: EdgeDelayFit) -> _Sway | None:
    levels = fit.levels
    if levels is None:
        return None
    fitted = np.flatnonzero(fit.kept)
    nearest = fitted[np.searchsorted((fitted[1:] + fitted[:-1]) / 2, np.arange(fit.kept.size))]
    n, u = levels.drift.shape[1], root(levels.covariance)
    mask, pixels = (float(one.sum()) for one in (recording.opening.mask, recording.opening.weight))
    found = FoundInSums(
        edges_late_rad=fit.angular_frequency_rad_per_s * np.array([fit.estimate.value(name) for name in EDGE_DELAYS]),
        blade_share=fit.blades,
        relative_gain=levels.relative_gain[nearest],
        u_gain=levels.gain[nearest] @ u[n:],
        u_offset=levels.drift[nearest] @ u[:n] * (mask / pixels),  # an offset is alike in all pixels that are summed
    )
    covered_dn = _opening_dn(recording) - levels.step_dn / mask * float(fit.fraction.mean())
    offset_dn = levels.relative_offset[nearest] * levels.step_dn / pixels
    return _Sway(found=found, offset_dn=offset_dn, own_dn=recording.pixel_maps["mean_dn"] - covered_dn)


def _opening_dn(recording: ReducedRecording) -> float:
    """Mean level of the opening's pixels."""
    opening = recording.opening
    box = np.s_[slice(*opening.roi[:2]), slice(*opening.roi[2:])]
    return float(recording.pixel_maps["mean_dn"][opening.mask[box]].mean())
