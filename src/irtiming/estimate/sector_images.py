"""The contrast images that a sector is fitted to, with what is known of their noise, gains and borders."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.estimate import contrast_look, sector_image, sector_limits
from irtiming.estimate.contrast_look import Look
from irtiming.estimate.row_light import SHAPE_NUMBERS
from irtiming.estimate.sector_image import Fitted, SeenContrast, Sharp, View
from irtiming.estimate.sector_search import Place
from irtiming.inference import lens_knowledge
from irtiming.inference.lens_knowledge import N_KNOWN, LensKnowledge
from irtiming.physics import blurred_sector, edge_motion
from irtiming.physics.edge_motion import Contradiction
from irtiming.physics.light.row_sum import Timing
from irtiming.records.arrays import Array, ComplexArray, Mask
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.row_timing import SectorFit
from irtiming.records.wheel_geometry import WheelModel

N_PRIORS = sector_limits.N_USUAL + N_KNOWN
"""Residuals that say what is known beforehand; they come first."""

FIRST_SCATTER = 0.02
"""Of gains and of the border, before an image told it; shares of the contrast."""

_HIDDEN = 0.1  # of the noise of an image, all pixels together
_BLUR_SHAPE = 0.2  # of the blur's width: how far light on the border may lie beside the middle that a Gaussian gives


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Images:
    """Contrast images, one per wheel speed, the region, and uncertainties along (real) and across each pixel's phase, DN.

    ``lens`` is what is known of it beforehand, ``name`` that of the first recording, ``rig`` what is stated of rotation and mask,
    ``begin`` the numbers of the earlier fit, with the turn that each image has by now; none without one.
    """

    seen: list[Look]
    view: View
    u_dn: list[ComplexArray]
    lens: LensKnowledge
    name: str
    rig: Rig
    begin: Mapping[str, float]

    def sense(self) -> Contradiction | None:
        """What the edges' way says against the stated rotation, by the bright pixels; asked for where no sector is found."""
        projection = self.seen[0].projection
        in_light = np.where(contrast_look.is_bright(np.abs(projection)), projection, 0.0)
        return edge_motion.contradiction(in_light, self.rig, least_turn_rad=1 / max(projection.shape))

    def residuals(self, numbers: Mapping[str, float], sharp: Sequence[Sharp]) -> Array:
        """What is known of the numbers beforehand, shape (N_PRIORS,), and then the misfit of all images."""
        return self.at(numbers, sharp).residual

    def at(self, numbers: Mapping[str, float], sharp: Sequence[Sharp]) -> Place:
        """Residuals at these numbers, from the sharp images there, and what they change by beside them, to first order."""
        every, fits = list(zip(self.seen, self.u_dn, strict=True)), self._fitted(numbers, sharp)
        before = self._off_known(numbers)

        def change(moved: Mapping[str, float], shown: Sequence[Sharp]) -> Array:
            changes = [
                sector_image.change(fit, look, numbers=moved, view=self.view, u_dn=u, known=known)
                for fit, (look, u), known in zip(fits, every, shown, strict=True)
            ]
            return np.concatenate([self._off_known(moved) - before, *changes])

        return Place(residual=np.concatenate([before, *(fit.misfit for fit in fits)]), change=change)

    def contrast(self, numbers: Mapping[str, float]) -> SeenContrast:
        """What the images say of each pixel beyond the model with these numbers."""
        return sector_image.contrast(self.seen, numbers, view=self.view, u_dn=self.u_dn)

    def sharp(self, numbers: Mapping[str, float]) -> list[Sharp]:
        """The sector without glare in each image."""
        return sector_image.sharp(self.seen, numbers, view=self.view)

    def misfit(self, numbers: Mapping[str, float], sharp: Sequence[Sharp]) -> list[Array]:
        """Deviations of each image from the model, over their uncertainties, as of `sector_image.Fitted`, shapes (m,)."""
        return [fit.misfit for fit in self._fitted(numbers, sharp)]

    def _fitted(self, numbers: Mapping[str, float], sharp: Sequence[Sharp]) -> list[Fitted]:
        return [
            sector_image.fitted(look, numbers, view=self.view, u_dn=u, known=known)
            for look, u, known in zip(self.seen, self.u_dn, sharp, strict=True)
        ]

    def _off_known(self, numbers: Mapping[str, float]) -> Array:
        return np.concatenate([sector_limits.off_usual(numbers), self.lens.off(numbers)])


def of(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, known: SectorFit | None
) -> Images:
    """Images of all recordings of one camera in one place, with what an earlier fit, ``known``, left over of them."""
    first = recordings[0]
    lens = lens_knowledge.knowledge(rig.camera, image=first.opening.mask.shape)
    seen = contrast_look.looks(recordings, wheel, timing=timing)
    good = np.asarray(np.all([one.contrast_image.good for one in recordings], axis=0))
    view = View(
        roi=first.contrast_image.roi,
        image=first.opening.mask.shape,
        good=good,
        summed=_summed(first),
        mirrored=rig.wheel.rotation == "counterclockwise",
        field_prior=sector_image.HIGHEST_FIELD if known is None else known.field_height,
        lens_terms=lens.terms,
    )
    begin: dict[str, float] = {}
    if known is not None:
        begin = turned(seen, numbers_of(known), view=view)
        seen = [_swayed(look, known, view=view, turn_rad=begin[look.turn]) for look in seen]
    imperfect = complex(FIRST_SCATTER) if known is None else _imperfect(known)
    u_dn = [
        np.hypot(look.u_dn, imperfect.real * look.full_dn) + 1j * np.hypot(look.u_dn, imperfect.imag * look.full_dn)
        for look in seen
    ]
    return Images(
        seen=seen,
        view=view,
        u_dn=[u + np.zeros(good.shape) for u in u_dn],
        lens=lens,
        name=first.name,
        rig=rig,
        begin=begin,
    )


def _swayed(look: Look, known: SectorFit, *, view: View, turn_rad: float) -> Look:
    """The image with what numbers that are not known of the levels do to that of a sector, but for those that noise hides."""
    angle, _ = blurred_sector.pixel_places(known.shape, roi=view.roi)
    angle = angle - turn_rad - look.omega * known.row_delay_s * view.rows
    light = np.clip(known.model_contrast, 0, 1)
    shown = [one.at(light, angle) for one in look.unsteady]
    scale = look.full_dn / float(np.abs(look.point.table).mean())
    return replace(look, swayed=tuple(one for one in shown if np.linalg.norm(one) * scale > _HIDDEN * look.u_dn))


def turned(seen: Sequence[Look], numbers: Mapping[str, float], *, view: View) -> dict[str, float]:
    """The numbers with the turn that each image has."""
    found = dict(numbers)
    for look in seen:
        found = sector_image.met(look, found, view=view)
    return found


def numbers_of(found: SectorFit) -> dict[str, float]:
    """A fit's numbers by name."""
    return {name: getattr(found.shape, name) for name in SHAPE_NUMBERS} | {
        "row_delay_s": found.row_delay_s,
        "turn_rad": found.turn_rad,
        "ring_inner_px": found.ring_radii_px[0],
        "ring_outer_px": found.ring_radii_px[1],
        "plate_reflection": found.plate_reflection,
    }


def border_weight(light: Array, blur_px: float) -> Array:
    """Standard deviation of the light of pixels on the border; 1 where half of a pixel is in the light, 0 far from there.

    Its square goes as the slope of the light: then all pixels across a border count alike in where the border lies, which is
    where their light adds up to, whatever the shape of the blur.
    """
    slope = np.hypot(*np.gradient(light)) * np.sqrt(2 * np.pi) * blurred_sector.reach_px(blur_px)
    return np.asarray(np.sqrt(np.maximum(slope, 1e-6)))


def _imperfect(found: SectorFit) -> ComplexArray:
    """Standard deviation of a pixel's contrast because pixels differ in gain, and masks from sectors at their border.

    Along the phase, real, and across, imaginary. Where the light ends within a pixel, its middle depends on the blur's shape, and
    the phase is twice its polar angle.
    """
    light = np.clip(found.model_contrast, 0, 1)
    border = border_weight(light, found.shape.blur_px)
    across = 2 * _BLUR_SHAPE * border * blurred_sector.angular_reach(found.shape, roi=found.roi)
    along = np.hypot(found.gain_scatter * light, found.border_scatter * border)
    return np.asarray(np.where(found.odd, 1 + 1j, along + 1j * across))


def _summed(rows: ReducedRecording) -> Mask:
    first_row, end_row, first_column, end_column = rows.contrast_image.roi
    return rows.opening.summed[first_row:end_row, first_column:end_column]
