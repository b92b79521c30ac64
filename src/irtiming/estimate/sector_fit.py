"""The opening's place and shape from the contrast image: where the axle lies, which way the mask points, how sharp it is.

Each pixel of the opening is covered and uncovered in its own time. So the phases of the contrast image tell polar angles
about the axle, and its amplitudes tell the mask: an annular sector, blurred, whose own centre need not be the axle. What a
pixel's projection would be is computed with the very weights that made it, so that missing frames do no harm.

Two things spoil amplitudes and leave phases alone: pixels differ in gain, and the solid wheel mirrors the camera unevenly.
So a pixel's deviation is split along and across its phase; only along it may differ by the pixels' gain scatter. What is left
along it counts as light, noise and all: the same noise is in the row sums, where it then does less harm than the doubt.

A lens that distorts moves the phases where the axle is not in the middle of the image, and a tilted camera moves the mask's arcs.
Where the image says nothing of lens and tilt they hardly matter; then what rig.toml states holds, or what no camera exceeds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from scipy import ndimage

from irtiming.estimate import contrast_look, lens_and_tilt, sector_image, sector_limits
from irtiming.estimate.contrast_look import Look
from irtiming.estimate.lens_and_tilt import ImageWord
from irtiming.estimate.row_light import SHAPE_NUMBERS, STEP_OF, Variation
from irtiming.estimate.sector_image import EXCHANGES, NUMBERS, SeenContrast, Sharp, View
from irtiming.estimate.sector_search import Misfit, Slopes, searched
from irtiming.inference import clustered, lens_knowledge
from irtiming.inference.lens_knowledge import N_KNOWN, LensKnowledge
from irtiming.inference.weighed_lens import SLIGHT
from irtiming.physics import blurred_sector
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import Timing
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.records.arrays import Array, ComplexArray, Mask, Ticks
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.row_timing import SectorFit
from irtiming.records.wheel_geometry import WheelModel

_WELL_INSIDE = 0.99  # of full contrast
_FEWEST_PIXELS = 30
_BORDER = 0.35  # about half of full contrast
_FIRST_SCATTER = 0.02
_FIELD_PRIORS = (1e-5, 0.1)  # at first the highest, later the field's own height: an even opening gets an even field
_N_PRIORS = sector_limits.N_USUAL + N_KNOWN
_CLUSTER_PX = 3.0
_SURE = 1.1  # of the noise: what a pixel's uncertainty across its phase is at most
_ODD = 10  # times the standard deviation
_NEIGHBOURS = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], bool)
_BLUR_SHAPE = 0.2  # of the blur's width: how far light on the border may lie beside the middle that a Gaussian gives
_OF_BLUR = ("blur_px", "blur_ellipticity", "glare", "glare_px")  # stay those of a Gaussian; `_reshaped` has the rest
_WARP_STEP_PX = 0.02  # over which what a warp does is taken
_U_SHARED = 0.1  # prior: of the share that is exchanged, beside a Gaussian blur


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Images:
    """Contrast images, one per wheel speed, the region, and uncertainties along (real) and across each pixel's phase, DN."""

    seen: list[Look]
    view: View
    u_dn: list[ComplexArray]

    def contrast(self, numbers: Mapping[str, float]) -> SeenContrast:
        return sector_image.contrast(self.seen, numbers, view=self.view, u_dn=self.u_dn)

    def sharp(self, numbers: Mapping[str, float]) -> list[Sharp]:
        return sector_image.sharp(self.seen, numbers, view=self.view)

    def misfit(self, numbers: Mapping[str, float], sharp: Sequence[Sharp]) -> list[Array]:
        return [
            sector_image.fitted(look, numbers, view=self.view, u_dn=u, known=known).misfit
            for look, u, known in zip(self.seen, self.u_dn, sharp, strict=True)
        ]


def fit(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, start: SectorFit | None = None,
    slopes: Slopes | None = None,
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
    timing
        As known so far.
    start
        An earlier fit; without one it starts at what the image shows.
    slopes
        Of the fits before of the same images, where they are known well enough to begin with; the covariance is theirs then.

    Raises
    ------
    EstimationError
        If the image shows no sector.
    """
    images = _images(recordings, wheel, rig=rig, timing=timing, known=start)
    best = _searched(images, recordings[0], rig=rig, start=start, is_rolling=_is_rolling(recordings[0]), slopes=slopes)
    return _as_it_is(images, best, start=start)


def settled(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, start: SectorFit,
    slopes: Slopes | None = None,
) -> SectorFit:  # fmt: skip
    """The last fit: with lens and tilt settled (`lens_and_tilt`), for which fits before are but starts; see `fit`."""
    images = _images(recordings, wheel, rig=rig, timing=timing, known=start)
    best = _searched(images, recordings[0], rig=rig, start=start, is_rolling=_is_rolling(recordings[0]), slopes=slopes)
    word = _without_camera(images, best)
    last = lens_and_tilt.settled(word, images.view.shape(best.numbers), known=best.known)
    names = [*(name for name in best.free if name not in SLIGHT), *WARP_NUMBERS]
    n_own = len(names) - len(WARP_NUMBERS)
    at = np.delete(np.arange(last.moved.size), slice(n_own, n_own + len(EXCHANGES)))
    numbers = best.numbers | {
        name: best.numbers[name] + float(move)
        for name, move in zip(names, last.moved[at], strict=True)
        if name not in _OF_BLUR
    }
    told = _told(images, numbers, names=names, covariance=last.covariance[np.ix_(at, at)], chi_square=best.chi_square)
    return replace(told, n_rounds=start.n_rounds + 1, camera=last.camera)


def fit_row_by_row(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, start: SectorFit,
    slopes: Slopes | None = None,
) -> SectorFit:  # fmt: skip
    """The same with a row delay of its own, of a camera that is said to read all rows at once; see `fit`."""
    images = _images(recordings, wheel, rig=rig, timing=timing, known=start)
    best = _searched(images, recordings[0], rig=rig, start=start, is_rolling=True, slopes=slopes)
    return _as_it_is(images, best, start=start)


def _is_rolling(recording: ReducedRecording) -> bool:
    return bool(camera(recording.camera_type, recording.readout_mode).readout.PARAMETERS)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Best:
    """End of a search: all numbers, names of the free ones, residual (m,), its slopes (m, n_free) and clusters (m,)."""

    numbers: dict[str, float]
    free: list[str]
    residual: Array
    slopes: Array
    clusters: Ticks
    chi_square: float
    known: LensKnowledge


def _searched(
    images: _Images,
    first: ReducedRecording,
    *,
    rig: Rig,
    start: SectorFit | None,
    is_rolling: bool,
    slopes: Slopes | None,
) -> _Best:
    known = lens_knowledge.knowledge(rig.camera, image=images.view.image)
    begin = sector_image.first_guess(images.seen[0], images.view) | known.start if start is None else _numbers(start)
    held = (*known.held, *WARP_NUMBERS, *(() if is_rolling else ("row_delay_s",)), *(SLIGHT if start is None else ()))
    free = [name for name in NUMBERS if name not in held]

    def residuals(numbers: Mapping[str, float], sharp: Sequence[Sharp]) -> Array:
        return np.concatenate([sector_limits.off_usual(numbers), known.off(numbers), *images.misfit(numbers, sharp)])

    found = searched(
        Misfit(residuals=residuals, sharp=images.sharp),
        begin,
        free=free,
        n_before=0 if start is None else start.n_rounds,
        slopes=slopes,
    )
    numbers, residual = begin | dict(zip(free, map(float, found.x), strict=True)), np.asarray(found.fun)
    sector_limits.check(numbers, first)
    if "distortion" in free:
        sector_limits.check_lens(numbers, known.start, rows=first)
    clusters = _clusters(images, numbers, residual.size)
    return _Best(
        numbers=numbers,
        free=free,
        residual=residual,
        slopes=np.asarray(found.jac),
        clusters=clusters,
        chi_square=_chi_square(images, residual[clusters >= 0]),
        known=known,
    )


def _as_it_is(images: _Images, best: _Best, *, start: SectorFit | None) -> SectorFit:
    covariance = clustered.covariance(best.slopes, best.residual, clusters=best.clusters)
    told = _told(images, best.numbers, names=best.free, covariance=covariance, chi_square=best.chi_square)
    return replace(told, n_rounds=1 if start is None else start.n_rounds + 1)


def _reshaped(images: _Images, best: _Best) -> list[Array]:
    """What a blur of another shape does to the residual, per standard uncertainty of what is known of it, shape (m,) each."""
    sharp, columns = images.sharp(best.numbers), []
    for axis, away in EXCHANGES:
        moved = [one.exchanged(_U_SHARED, axis=axis, away=away) for one in sharp]
        here = np.concatenate(images.misfit(best.numbers, moved))
        columns.append(np.concatenate([np.zeros(_N_PRIORS), here - best.residual[_N_PRIORS:]]))
    return columns


def _without_camera(images: _Images, best: _Best) -> ImageWord:
    """What the images say of the other numbers and of a warp, with what is known of lens and tilt left out."""
    numbers, residual = best.numbers, best.residual
    kept = np.ones(residual.size, bool)
    kept[_N_PRIORS - N_KNOWN : _N_PRIORS] = False

    def warped(name: str) -> Array:
        moved = {**numbers, name: numbers[name] + _WARP_STEP_PX}
        here = np.concatenate(images.misfit(moved, images.sharp(moved)))
        return np.concatenate([np.zeros(_N_PRIORS), here - residual[_N_PRIORS:]]) / _WARP_STEP_PX

    own = [one for name, one in zip(best.free, best.slopes.T, strict=True) if name not in SLIGHT]
    jacobian = np.stack([*own, *_reshaped(images, best), *(warped(name) for name in WARP_NUMBERS)], axis=1)[kept]
    prior = np.eye(jacobian.shape[1])[len(own) : len(own) + len(EXCHANGES)]
    return ImageWord(
        residual=np.append(residual[kept], np.zeros(len(prior))),
        jacobian=np.concatenate([jacobian, prior]),
        clusters=np.append(best.clusters[kept], np.full(len(prior), -1)),
        n_warp=len(WARP_NUMBERS),
    )


def guess(recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing) -> SectorFit:
    """The sector with which a search would begin, for a first look at the rows; its covariance is zero.

    Parameters as for `fit`.
    """
    images = _images(recordings, wheel, rig=rig, timing=timing, known=None)
    known = lens_knowledge.knowledge(rig.camera, image=images.view.image)
    numbers = sector_image.first_guess(images.seen[0], images.view) | known.start
    told = _told(images, numbers, names=(), covariance=np.zeros((0, 0)), chi_square=1.0)
    return replace(told, n_rounds=0)


def _chi_square(images: _Images, residual: Array) -> float:
    """Mean square of the pixels' residuals, without those across the phase where the blur's shape is not known."""
    good = images.view.good
    parts = [
        np.concatenate([good[good], (u.imag < _SURE * look.u_dn)[good]])
        for look, u in zip(images.seen, images.u_dn, strict=True)
    ]
    return float(np.mean(residual[np.concatenate(parts)] ** 2))


def _clusters(images: _Images, numbers: Mapping[str, float], n_residual: int) -> Ticks:
    """Number of the cluster of each residual, -1 for priors, shape (n_residual,).

    Along its phase a pixel has gain and light of its own, but on the border its light is off by what the mask's border is off
    there, as is that of its neighbours; across it, the errors of the wheel's angle in the frames in which an edge passes, which
    it shares with all pixels of its sector of a few pixels' width.
    """
    view, shape = images.view, images.view.shape(numbers)
    angle, radius = blurred_sector.pixel_places(shape, roi=view.roi)
    width = _CLUSTER_PX / float(radius[view.good].mean())
    sector = np.unique((angle[view.good] / width).astype(np.int64), return_inverse=True)[1]
    n_good = sector.size
    row, column = np.indices(view.good.shape) // round(_CLUSTER_PX)
    cell = n_good + sector.max() + 1 + row * (column.max() + 1) + column
    alone = np.where(blurred_sector.near_border(shape, roi=view.roi)[view.good], cell[view.good], np.arange(n_good))
    own = np.concatenate([alone, n_good + sector])
    length, out = (n_residual - _N_PRIORS) // len(images.seen), np.full(n_residual, -1)
    for k in range(len(images.seen)):
        first = _N_PRIORS + k * length
        out[first : first + own.size] = own + k * (own.max() + 1)
    return out


def variations(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, found: SectorFit
) -> tuple[Variation, ...]:
    """The fitted sector with each number of its shape a little larger and smaller, and what the same images then leave over.

    Pixels of the contrast image show their own amount of light, so a number that is off changes little but where that light
    lies. Parameters as for `fit`, which gave ``found``.

    Returns
    -------
    One for each number that may be off, in the order of its covariance.
    """
    images = _images(recordings, wheel, rig=rig, timing=timing, known=found)
    return tuple(_varied(images, found, _numbers(found), name=name) for name in found.names)


def _varied(images: _Images, found: SectorFit, numbers: Mapping[str, float], *, name: str) -> Variation:
    step = STEP_OF[name]
    ahead, behind = (
        replace(found, **_light(images.contrast(moved), moved, view=images.view))
        for moved in ({**numbers, name: numbers[name] + way * step} for way in (1, -1))
    )
    return Variation(ahead=ahead, behind=behind, distance=2 * step)


def _images(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, known: SectorFit | None
) -> _Images:
    first = recordings[0]
    seen = contrast_look.looks(recordings, wheel, timing=timing)
    good = np.asarray(np.all([one.contrast_image.good for one in recordings], axis=0))
    view = View(
        roi=first.contrast_image.roi,
        image=first.opening.mask.shape,
        good=good,
        summed=_summed(first),
        mirrored=rig.wheel.rotation == "counterclockwise",
        field_prior=_FIELD_PRIORS[1] if known is None else float(np.clip(known.unevenness, *_FIELD_PRIORS)),
        lens_terms=lens_knowledge.knowledge(rig.camera, image=first.opening.mask.shape).terms,
    )
    if known is not None:
        seen = [sector_image.turned(look, _numbers(known), view=view) for look in seen]
    imperfect = complex(_FIRST_SCATTER) if known is None else _imperfect(known)
    u_dn = [
        np.hypot(look.u_dn, imperfect.real * look.full_dn) + 1j * np.hypot(look.u_dn, imperfect.imag * look.full_dn)
        for look in seen
    ]
    return _Images(seen=seen, view=view, u_dn=[u + np.zeros(good.shape) for u in u_dn])


def _told(
    images: _Images,
    numbers: Mapping[str, float],
    *,
    names: Sequence[str],
    covariance: Array,
    chi_square: float,
) -> SectorFit:
    """The measured contrast, split into sector, plate and excess, with what is known of the numbers and how well all fits."""
    view, seen = images.view, images.contrast(numbers)
    inside = view.good & (seen.sharp > _WELL_INSIDE)
    border = view.good & (np.abs(seen.sharp - 0.5) < _BORDER)
    weight = _border_weight(seen.sharp, numbers["blur_px"])
    gains = _scatter(seen.residual[inside], seen.u)
    burrs = _scatter((seen.residual / weight)[border], seen.u)
    of_shape = [k for k, name in enumerate(names) if name in SHAPE_NUMBERS]
    variance = dict(zip(names, np.diag(covariance).tolist(), strict=True))
    return SectorFit(
        **_light(seen, numbers, view=view),
        names=tuple(names[k] for k in of_shape),
        covariance=covariance[np.ix_(of_shape, of_shape)],
        contrast=seen.model + seen.residual,
        model_contrast=seen.light,
        unevenness=seen.unevenness,
        gain_scatter=gains,
        border_scatter=burrs,
        summed=view.summed,
        odd=_odd(seen, weight, gain_scatter=gains, border_scatter=burrs),
        turn_rad=numbers["turn_rad"],
        ring_radii_px=(numbers["ring_inner_px"], numbers["ring_outer_px"]),
        plate_reflection=numbers["plate_reflection"],
        row_delay_s=numbers["row_delay_s"],
        u_row_delay_s=float(np.sqrt(variance.get("row_delay_s", 0.0))),
        reduced_chi_square=chi_square,
        roi=view.roi,
        n_rounds=1,
    )


def _light(seen: SeenContrast, numbers: Mapping[str, float], *, view: View) -> dict[str, Any]:
    """Where the light comes from: the fields of a `SectorFit` that say so."""
    summed = np.where(view.summed, 1.0, 0.0)
    return {
        "shape": view.shape(numbers),
        "plate": seen.plate,
        "ring": seen.over_ring * summed,
        "swept": seen.ring * summed,
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


def _odd(seen: SeenContrast, border: Array, *, gain_scatter: float, border_scatter: float) -> Mask:
    """Pixels that stray from the model far more than noise, gains and the border's weight (roi rows, roi columns) let them.

    A dead pixel beside the opening strays by little, but alone: there no gain acts on light, so neighbours tell.
    """
    burrs = border_scatter * border
    usual = np.hypot(np.hypot(seen.u, gain_scatter), burrs)
    beside = seen.residual - ndimage.median_filter(seen.residual, footprint=_NEIGHBOURS)
    alone = np.hypot(np.hypot(seen.u, gain_scatter * np.clip(seen.light, 0, 1)), burrs)
    return np.asarray((np.abs(seen.residual) > _ODD * usual) | (np.abs(beside) > _ODD * alone))


def _border_weight(light: Array, blur_px: float) -> Array:
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
    border = _border_weight(light, found.shape.blur_px)
    across = 2 * _BLUR_SHAPE * border * blurred_sector.angular_reach(found.shape, roi=found.roi)
    along = np.hypot(found.gain_scatter * light, found.border_scatter * border)
    return np.asarray(np.where(found.odd, 1 + 1j, along + 1j * across))


def _numbers(found: SectorFit) -> dict[str, float]:
    return {name: getattr(found.shape, name) for name in SHAPE_NUMBERS} | {
        "row_delay_s": found.row_delay_s,
        "turn_rad": found.turn_rad,
        "ring_inner_px": found.ring_radii_px[0],
        "ring_outer_px": found.ring_radii_px[1],
        "plate_reflection": found.plate_reflection,
    }


def _summed(rows: ReducedRecording) -> Mask:
    first_row, end_row, first_column, end_column = rows.contrast_image.roi
    return rows.opening.summed[first_row:end_row, first_column:end_column]
