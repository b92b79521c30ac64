"""From contrast images to geometry: the fitted sector of each blackbody, and where axle and mask lie in the image.

A blackbody of another temperature shows the plate with another share of its contrast, so each has a sector of its own.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import (
    by_blackbody,
    contrast_look,
    image_doubts,
    pixel_sums,
    plate_light,
    sector_fit,
    steady_image,
)
from irtiming.estimate.row_light import slopes
from irtiming.estimate.sector_search import Slopes
from irtiming.inference.one_thread import one_thread
from irtiming.physics import blurred_sector
from irtiming.records.arrays import Array, Mask
from irtiming.records.finding import Finding
from irtiming.records.reduced import AxleView, Opening, ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.row_timing import SectorFit, SectorShape
from irtiming.records.wheel_geometry import WheelModel

_ROUNDS = 3  # the second knows what the first left over, and looks for the lens; the third knows what is left then
_NOT_SKEW = 0.03
"""Of the turn that uneven light brings: what it does to a slope beyond the skew of `physics.light.pixel_sum`."""
_GLARE_SHAPE = 0.3
"""Of the glare: by how much an exponential that the image takes for its Gaussian carries more or less away."""


def estimate(recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig) -> tuple[ReducedRecording, ...]:
    """The recordings of a camera without lag, which now know axle and mask; where the image shows no sector, a finding says so.

    Parameters
    ----------
    recordings
        Of one camera in one place.
    wheel
        Geometry of wheel and gates.
    rig
        Which way the wheel turns, and what is known of the lens.
    """
    return seen(recordings, wheel, rig=rig)[0]


def seen(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig
) -> tuple[tuple[ReducedRecording, ...], tuple[SectorFit | None, ...]]:
    """The same, and the sector that each recording shows; None where it shows none.

    Parameters
    ----------
    recordings, wheel, rig
        As of `estimate`.
    """
    groups = by_blackbody.of_recordings(recordings)
    found, sectors = list(recordings), list[SectorFit | None]([None] * len(recordings))
    for members in groups:
        group = [_steady(recordings[k], wheel) for k in members]
        axle: AxleView | None = None
        sector: SectorFit | None = None
        doubts: tuple[Finding, ...] = ()
        try:
            with one_thread():
                sector, by_rows = _sector(group, wheel, rig=rig)
                axle = view(sector, group[0].opening.summed)
            doubts = (
                *image_doubts.of_image(sector),
                *image_doubts.of_opening(sector, rig.mask_opening.opening_angle_rad),
                *image_doubts.of_lens_found(sector, rig.camera),
                *image_doubts.of_rows(by_rows),
            )
        except EstimationError as error:
            doubts = (_no_sector(error),)
        for k in members:
            own = None if axle is None or sector is None else _with_single_pixels(axle, sector, recordings[k].opening)
            found[k] = replace(recordings[k], axle=own, findings=recordings[k].findings + doubts)
            sectors[k] = sector
    return tuple(found), tuple(sectors)


def _steady(recording: ReducedRecording, wheel: WheelModel) -> ReducedRecording:
    """With an image that knows how the levels swayed; as it is where the pixel sums do not follow the wheel."""
    try:
        return steady_image.by_sums(recording, pixel_sums.fit(recording, wheel))
    except EstimationError:
        return recording


def _no_sector(error: EstimationError) -> Finding:
    """A doubt: then the image checks neither rotation nor mask, and the light is taken to lie about the mask's bisector."""
    return Finding(
        code="no-sector",
        severity="doubt",
        what=f"{error}; the image therefore checks neither the mask's angle nor the rotation",
        cure="check readout_mode, [wheel] rotation, that the image is not mirrored, focus, and that frames belong to their "
        "triggers",
    )


def _sector(recordings: list[ReducedRecording], wheel: WheelModel, *, rig: Rig) -> tuple[SectorFit, SectorFit]:
    """As read at once, and with a row delay."""
    timing = contrast_look.as_stated(recordings[0])
    sector = sector_fit.fit(recordings, wheel, rig=rig, timing=timing)
    kept = Slopes()
    for _ in range(_ROUNDS - 2):
        sector = sector_fit.fit(recordings, wheel, rig=rig, timing=timing, start=sector, slopes=kept)
    last = sector_fit.settled(recordings, wheel, rig=rig, timing=timing, start=sector, slopes=kept)
    return last, sector_fit.fit_row_by_row(recordings, wheel, rig=rig, timing=timing, start=last, slopes=kept)


def _with_single_pixels(axle: AxleView, sector: SectorFit, opening: Opening) -> AxleView:
    """With what dead and uneven pixels do to the sum: each recording may have other dead ones."""
    shift_rad = sector.shape.sense * (axle.mean_angle_rad - axle.bisector_rad)
    ends, share = plate_light.of_single_pixels(sector, opening.summed, weight=opening.weight, shift_rad=shift_rad)
    return replace(axle, pixels_ends_rad=tuple(ends.tolist()), pixels_share=tuple(share.tolist()))


def view(sector: SectorFit, summed: Mask) -> AxleView:
    """Axle and mask in the image as it is, whichever way the wheel turns.

    Parameters
    ----------
    sector
        Fitted to the contrast image.
    summed
        Pixels that are summed, shape (row, column).
    """
    shape = sector.shape
    seen_bisector = np.pi - shape.bisector_rad if shape.mirrored else shape.bisector_rad
    bisector = float(np.angle(np.exp(1j * seen_bisector)))
    row0, row1, column0, column1 = sector.roi
    light, even = (  # of the opening alone: what plate and field add has angles of its own
        np.where(summed[row0:row1, column0:column1], one, 0.0)
        for one in (sector.contrast - sector.ring, sector.model_contrast)
    )

    def seen(at: SectorShape) -> Array:
        """Mean angle of the light from the bisector, by how much each edge misses the axle, and what uneven light turns."""
        angle, _ = blurred_sector.pixel_places(at, roi=sector.roi)
        uneven = np.sum(light * angle) / np.sum(light) - np.sum(even * angle) / np.sum(even)
        return np.array([np.sum(light * angle) / np.sum(light), *_edge_miss_px(at), uneven])

    by_number = slopes(seen, sector)
    shift, low, high, uneven = seen(shape)
    beside = plate_light.beside(sector, summed, shift_rad=float(shift))
    lost_ends, lost = plate_light.lost(sector, summed, shift_rad=float(shift))
    u_shift, u_low, u_high, _ = np.sqrt(np.einsum("ki,kl,li->i", by_number, sector.covariance, by_number))
    return AxleView(
        row_px=shape.axle_row_px,
        column_px=shape.axle_column_px,
        u_centre_px=max(sector.u("axle_row_px"), sector.u("axle_column_px")),
        bisector_rad=bisector,
        u_bisector_rad=sector.u("bisector_rad"),
        mean_angle_rad=float(bisector + shape.sense * shift),
        u_off_axle_rad=float(np.hypot(u_shift, _NOT_SKEW * uneven)),
        edge_miss_px=(float(-high), float(-low)) if shape.mirrored else (float(low), float(high)),
        u_edge_miss_px=float(max(u_low, u_high)),
        distortion=sector.value("distortion"),
        u_distortion=sector.u("distortion"),
        blur_px=shape.blur_px,
        radii_px=(shape.inner_radius_px, shape.outer_radius_px),
        beside_ends_rad=() if beside is None else tuple(beside.ends_rad.tolist()),
        plate_share=() if beside is None else tuple(beside.plate.tolist()),
        uneven_share=() if beside is None else tuple(beside.uneven.tolist()),
        glare=shape.glare,
        u_glare=float(np.hypot(sector.u("glare"), _GLARE_SHAPE * shape.glare)),
        lost_ends_rad=tuple(lost_ends.tolist()),
        lost_share=tuple(lost.tolist()),
    )


def _edge_miss_px(shape: SectorShape) -> tuple[float, float]:
    """By how much each radial edge misses the axle, px, in the wheel's sense: they point to the mask's own centre."""
    ends = [shape.bisector_rad + side * shape.opening_angle_rad / 2 for side in (-1, 1)]
    low, high = (np.cos(end) * shape.offset_row_px - np.sin(end) * shape.offset_column_px for end in ends)
    return float(low), float(high)
