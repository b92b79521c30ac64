"""The opening's place and shape from the contrast image: where the axle lies, which way the mask points, how sharp it is.

Each pixel of the opening is covered and uncovered in its own time. So the phases of the contrast image tell polar angles
about the axle, and its amplitudes tell the mask: an annular sector, blurred, whose own centre need not be the axle. What a
pixel's projection would be is computed with the very weights that made it, so that missing frames do no harm.

Two things spoil amplitudes and leave phases alone: pixels differ in gain, and the solid wheel mirrors the camera unevenly.
So a pixel's deviation is split along and across its phase; only along it may differ by the pixels' gain scatter. What is left
along it counts as light, noise and all: the same noise is in the row sums, where it then does less harm than the doubt.

A lens that distorts moves the phases where the axle is not in the middle of the image. Where it is, they say nothing of the lens,
nor does the lens matter; then what rig.toml states holds, or that few lenses distort more than tenths.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from scipy.optimize import least_squares

from irtiming.errors import EstimationError
from irtiming.estimate import sector_image
from irtiming.estimate.row_light import SHAPE_NUMBERS, SHAPE_STEPS, Variation, shape_of
from irtiming.estimate.sector_image import (
    BLUR,
    DISTORTION,
    PHASE,
    RING_INNER,
    RING_OUTER,
    ROW_DELAY,
    SCALES,
    Look,
    SeenContrast,
    View,
)
from irtiming.physics import lens
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Measured, Rig
from irtiming.records.row_timing import SectorFit
from irtiming.records.wheel_geometry import WheelModel

_SHARPEST_PX, _MOST_BLURRED_PX = 0.25, 8.0
_FIRMEST_DISTORTION = 1e-5  # uncertainty of one that counts as exact
_WELL_INSIDE = 0.99  # of full contrast
_FEWEST_PIXELS = 30
_BORDER = 0.35  # about half of full contrast
_FIRST_SCATTER = 0.02
_MOST_EVALUATIONS = 30
_FIELD_PRIORS = (1e-5, 0.1)  # at first the highest, later the field's own height: an even opening gets an even field
_N_PRIORS = 3
_RING_MARGIN_PX = 2.0  # how far, roughly, a cutout reaches beyond the opening


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Images:
    """Contrast images, one per wheel speed, the region to look at, and uncertainties along each pixel's phase, DN."""

    seen: list[Look]
    view: View
    along: list[Array]

    def contrast(self, numbers: Array) -> SeenContrast:
        return sector_image.contrast(self.seen, numbers, view=self.view, u_along_dn=self.along)


def fit(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, lag: tuple[Array, float],
    start: SectorFit | None = None,
) -> SectorFit:  # fmt: skip
    """Sector fitted to the contrast images of all recordings.

    Parameters
    ----------
    recordings
        Of one camera in one place.
    wheel
        Geometry of wheel and gates.
    rig
        Which way the wheel turns, and what is known of the lens.
    lag
        Edge delays (4,) and time constant as known so far, s; they matter only where frames are missing.
    start
        An earlier fit; without one it starts at what the image shows.

    Raises
    ------
    EstimationError
        If the image shows no sector.
    """
    images = _images(recordings, wheel, rig=rig, lag=lag, known=start)
    seen, view, along = images.seen, images.view, images.along
    begin = _begin(seen[0], view, rig) if start is None else _numbers(start)

    def misfit(numbers: Array) -> Array:
        fits = [
            sector_image.fitted(look, numbers, view=view, u_along_dn=u) for look, u in zip(seen, along, strict=True)
        ]
        return np.concatenate([_priors(numbers, rig.camera.distortion), *(one.misfit for one in fits)])

    low, high = np.full(SCALES.size, -np.inf), np.full(SCALES.size, np.inf)
    low[[4, RING_INNER]], low[BLUR], high[BLUR] = 0.0, _SHARPEST_PX, _MOST_BLURRED_PX
    low[DISTORTION], high[DISTORTION] = lens.LOWEST, lens.HIGHEST
    begin = np.clip(begin, low + 1e-6, high - 1e-6)
    found = least_squares(misfit, begin, x_scale=SCALES, bounds=(low, high), max_nfev=_MOST_EVALUATIONS, ftol=1e-6)
    numbers, residual = np.asarray(found.x), np.asarray(found.fun)
    _check(numbers, recordings[0])
    n_good = int(view.good.sum())
    pixels = np.concatenate(
        [_N_PRIORS + np.arange(2 * n_good) + k * ((residual.size - _N_PRIORS) // len(seen)) for k in range(len(seen))]
    )
    covariance = _covariance(np.asarray(found.jac), residual, pixels.reshape(2 * len(seen), n_good))
    told = _told(images, numbers, known=(covariance, float(np.mean(residual[pixels] ** 2))))
    return replace(told, n_rounds=1 if start is None else start.n_rounds + 1)


def variations(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, lag: tuple[Array, float], found: SectorFit
) -> tuple[Variation, ...]:
    """The fitted sector with each number of its shape a little larger and smaller, and what the same images then leave over.

    Pixels of the contrast image show their own amount of light, so a number that is off changes little but where that light
    lies. Parameters as for `fit`, which gave ``found``.

    Returns
    -------
    One for each number of the shape, in the order of its covariance.
    """
    images = _images(recordings, wheel, rig=rig, lag=lag, known=found)
    numbers = _numbers(found)
    varied = []
    for step, one in zip(SHAPE_STEPS, np.eye(len(SHAPE_STEPS), numbers.size), strict=True):
        ahead, behind = (
            replace(found, **_light(images.contrast(moved), moved, view=images.view))
            for moved in (numbers + step * one, numbers - step * one)
        )
        varied.append(Variation(ahead=ahead, behind=behind, distance=2 * step))
    return tuple(varied)


def _images(
    recordings: Sequence[ReducedRecording],
    wheel: WheelModel,
    *,
    rig: Rig,
    lag: tuple[Array, float],
    known: SectorFit | None,
) -> _Images:
    first = recordings[0]
    seen = sector_image.looks(recordings, wheel, lag=lag)
    good = np.asarray(np.all([one.contrast_image.good for one in recordings], axis=0))
    view = View(
        roi=first.contrast_image.roi,
        image=first.opening.mask.shape,
        good=good,
        summed=_summed(first),
        mirrored=rig.wheel.rotation == "counterclockwise",
        field_prior=_FIELD_PRIORS[1] if known is None else float(np.clip(known.unevenness, *_FIELD_PRIORS)),
    )
    imperfect = np.full(good.shape, _FIRST_SCATTER) if known is None else _imperfect(known)
    return _Images(seen=seen, view=view, along=[np.hypot(look.u_dn, imperfect * look.full_dn) for look in seen])


def _begin(seen: Look, view: View, rig: Rig) -> Array:
    """What the image shows, through the lens that rig.toml states."""
    numbers = sector_image.first_guess(seen, view)
    numbers[DISTORTION] = rig.camera.distortion.value
    return numbers


def _told(images: _Images, numbers: Array, *, known: tuple[Array, float]) -> SectorFit:
    """The measured contrast, split into sector, plate and excess, with the covariance and how well all fits."""
    view, seen = images.view, images.contrast(numbers)
    inside = view.good & (seen.light > _WELL_INSIDE)
    border = view.good & (np.abs(seen.light - 0.5) < _BORDER)
    covariance, chi_square = known
    return SectorFit(
        **_light(seen, numbers, view=view),
        covariance=covariance[: len(SHAPE_NUMBERS), : len(SHAPE_NUMBERS)],
        contrast=seen.model + seen.residual,
        model_contrast=seen.light,
        unevenness=seen.unevenness,
        gain_scatter=_scatter(seen.residual[inside], seen.u),
        border_scatter=_scatter((seen.residual / _border_weight(seen.light))[border], seen.u),
        phase_rad=float(numbers[PHASE]),
        ring_radii_px=(float(numbers[RING_INNER]), float(numbers[RING_OUTER])),
        row_delay_s=float(numbers[ROW_DELAY]),
        u_row_delay_s=float(np.sqrt(covariance[ROW_DELAY, ROW_DELAY])),
        reduced_chi_square=chi_square,
        roi=view.roi,
        n_rounds=1,
    )


def _light(seen: SeenContrast, numbers: Array, *, view: View) -> dict[str, Any]:
    """Where the light comes from: the fields of a `SectorFit` that say so."""
    summed = np.where(view.summed, 1.0, 0.0)
    return {
        "shape": shape_of(numbers, view.mirrored, image=view.image),
        "plate": seen.plate,
        "ring": seen.over_ring * summed,
        "ring_angle_rad": seen.centre_angle_rad,
        "borrowed": _borrowed(seen.model, view) * summed,
        "borrowed_angle_rad": seen.light_angle_rad,
        "excess": seen.residual * summed,
        "excess_angle_rad": np.where(seen.light > 0.5, seen.light_angle_rad, seen.centre_angle_rad),
    }


def _borrowed(light: Array, view: View) -> Array:
    """What dead pixels do not show of the light, and what their stand-ins show in their place."""
    out = np.zeros(light.shape)
    for row, column, beside in view.stand_ins:
        out[row, column] -= light[row, column]
        out[row, beside] += light[row, beside] / len(beside)
    return out


def _scatter(residual: Array, u: float) -> float:
    """Standard deviation beyond the noise."""
    beyond = float(np.mean(residual**2)) - u**2 if residual.size > _FEWEST_PIXELS else _FIRST_SCATTER**2
    return float(np.sqrt(max(beyond, 0.0)))


def _border_weight(light: Array) -> Array:
    """1 where half of a pixel is in the light, 0 well inside and well outside."""
    return np.asarray(np.maximum(4 * light * (1 - light), 1e-6))


def _imperfect(found: SectorFit) -> Array:
    """Standard deviation of a pixel's contrast because pixels differ in gain, and masks from sectors at their border."""
    light = np.clip(found.model_contrast, 0, 1)
    return np.asarray(np.hypot(found.gain_scatter * light, found.border_scatter * _border_weight(light)))


def _numbers(found: SectorFit) -> Array:
    return np.array(
        [
            *(getattr(found.shape, name) for name in SHAPE_NUMBERS),
            found.row_delay_s,
            found.phase_rad,
            *found.ring_radii_px,
        ]
    )


def _priors(numbers: Array, distortion: Measured) -> Array:
    """A loose word on the radii of the cutouts, for where the plate does not show, and what is known of the lens."""
    margin = np.array([numbers[4] - numbers[RING_INNER], numbers[RING_OUTER] - numbers[5]])
    off = (numbers[DISTORTION] - distortion.value) / max(distortion.standard_uncertainty, _FIRMEST_DISTORTION)
    return np.array([*(margin - _RING_MARGIN_PX) / _RING_MARGIN_PX, off])


def _summed(rows: ReducedRecording) -> Mask:
    first_row, end_row, first_column, end_column = rows.contrast_image.roi
    return rows.opening.summed[first_row:end_row, first_column:end_column]


def _check(numbers: Array, rows: ReducedRecording) -> None:
    width, off = numbers[5] - numbers[4], float(np.hypot(numbers[2], numbers[3]))
    if not (width > 3 and 0.1 < numbers[7] < np.pi and off < 0.3 * numbers[5]):
        raise EstimationError(
            f"{rows.name}: the opening does not look like an annular sector about the axle: radii {numbers[4]:.1f} .. "
            f"{numbers[5]:.1f} px, {np.degrees(numbers[7]):.1f} deg wide, centre {off:.1f} px beside the axle; the whole opening "
            "must be in view, sharp, and covered by the wheel alone"
        )


def _covariance(jacobian: Array, residual: Array, pixels: Ticks) -> Array:
    """Covariance that holds for pixels that differ from the model by more than noise, each a cluster of its own.

    ``pixels`` (n, n_good) are the places in the residual that belong to each pixel. In no direction is it smaller than noise
    and priors alone would make it.
    """
    scale = np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian))
    scaled = jacobian / np.where(scale > 0, scale, 1)
    sizes, axes = np.linalg.eigh(scaled.T @ scaled)
    white = axes / np.sqrt(np.maximum(sizes, 1e-12 * sizes[-1]))  # its square is the covariance of white noise
    scores = (scaled * residual[:, None])[pixels].sum(axis=0) @ white
    spread, turn = np.linalg.eigh(scores.T @ scores)
    root = white @ turn * np.sqrt(np.maximum(spread, 1.0)) / np.where(scale > 0, scale, 1)[:, None]
    return np.asarray(root @ root.T)
