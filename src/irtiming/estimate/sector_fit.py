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

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from scipy import ndimage

from irtiming.estimate import contrast_look, lens_knowledge, sector_image, sector_limits
from irtiming.estimate.contrast_look import Look
from irtiming.estimate.lens_knowledge import N_KNOWN, LensKnowledge
from irtiming.estimate.row_light import SHAPE_NUMBERS, SHAPE_STEPS, Product, Variation
from irtiming.estimate.sector_image import NUMBERS, SeenContrast, Sharp, View
from irtiming.estimate.sector_search import Misfit, Slopes, searched
from irtiming.physics import blurred_sector
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import Timing
from irtiming.records.arrays import Array, ComplexArray, Mask, Ticks
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.row_timing import SectorFit
from irtiming.records.wheel_geometry import WheelModel

_WELL_INSIDE = 0.99  # of full contrast
_FEWEST_PIXELS = 30
_BORDER = 0.35  # about half of full contrast
_FIRST_SCATTER = 0.02
_OTHER_SIGN = 0.3  # of the prior uncertainty of a distortion: with which either sign is tried
_FIELD_PRIORS = (1e-5, 0.1)  # at first the highest, later the field's own height: an even opening gets an even field
_N_PRIORS = 5 + N_KNOWN
_U_GLARE, _U_GLARE_WIDTH = 0.03, 0.7  # priors: of the share, and of the width's logarithm
_CLUSTER_PX = 3.0
_SURE = 1.1  # of the noise: what a pixel's uncertainty across its phase is at most
_ODD = 10  # times the standard deviation
_NEIGHBOURS = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], bool)
_BLUR_SHAPE = (
    0.2  # of the blur's width: where the light of a pixel on the border may lie beside the middle that a Gaussian gives
)
_SLIGHT = (
    "distortion",
    "keystone_row",
    "keystone_column",
    "log_focal_length",
    "lens_row_px",
    "lens_column_px",
)  # found once the rest is
_RING_MARGIN_PX = 2.0  # how far, roughly, a cutout reaches beyond the opening


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
    is_rolling = bool(camera(recordings[0].camera_type, recordings[0].readout_mode).readout.PARAMETERS)
    images = _images(recordings, wheel, rig=rig, timing=timing, known=start)
    return _fitted(images, recordings[0], rig=rig, start=start, is_rolling=is_rolling, slopes=slopes)


def fit_row_by_row(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, start: SectorFit
) -> SectorFit:
    """The same with a row delay of its own, of a camera that is said to read all rows at once; see `fit`."""
    images = _images(recordings, wheel, rig=rig, timing=timing, known=start)
    return _fitted(images, recordings[0], rig=rig, start=start, is_rolling=True, slopes=None)


def _fitted(
    images: _Images,
    first: ReducedRecording,
    *,
    rig: Rig,
    start: SectorFit | None,
    is_rolling: bool,
    slopes: Slopes | None,
) -> SectorFit:
    known = lens_knowledge.knowledge(rig.camera, image=images.view.image)
    begin = sector_image.first_guess(images.seen[0], images.view) | known.start if start is None else _numbers(start)
    held = (*known.held, *(() if is_rolling else ("row_delay_s",)), *(_SLIGHT if start is None else ()))
    free = [name for name in NUMBERS if name not in held]

    def residuals(numbers: Mapping[str, float], sharp: Sequence[Sharp]) -> Array:
        return np.concatenate([_priors(numbers), known.off(numbers), *images.misfit(numbers, sharp)])

    found = searched(
        Misfit(residuals=residuals, sharp=images.sharp),
        [begin | one for one in _signs(known, start)],
        free=free,
        n_before=0 if start is None else start.n_rounds,
        slopes=slopes,
    )
    numbers, residual = begin | dict(zip(free, map(float, found.x), strict=True)), np.asarray(found.fun)
    sector_limits.check(numbers, first)
    if "distortion" in free:
        sector_limits.check_lens(numbers, known.start, rows=first)
    covariance = np.zeros((len(NUMBERS), len(NUMBERS)))
    at = [NUMBERS.index(name) for name in free]
    clusters = _clusters(images, numbers, residual.size)
    covariance[np.ix_(at, at)] = _covariance(np.asarray(found.jac), residual, clusters)
    told = _told(images, numbers, known=(covariance, _chi_square(images, residual[clusters >= 0])))
    return replace(told, n_rounds=1 if start is None else start.n_rounds + 1)


def guess(recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing) -> SectorFit:
    """The sector with which a search would begin, for a first look at the rows; its covariance is zero.

    Parameters as for `fit`.
    """
    images = _images(recordings, wheel, rig=rig, timing=timing, known=None)
    known = lens_knowledge.knowledge(rig.camera, image=images.view.image)
    numbers = sector_image.first_guess(images.seen[0], images.view) | known.start
    none = np.zeros((len(NUMBERS), len(NUMBERS)))
    return replace(_told(images, numbers, known=(none, 1.0)), n_rounds=0)


def _signs(known: LensKnowledge, start: SectorFit | None) -> list[dict[str, float]]:
    """Distortions with which a search begins once the rest is known roughly.

    A barrel about a lens centre to one side of the axle moves the phases as a pincushion about one to the other side does; only
    what is left then tells the two apart, and no search finds its way from the one to the other.
    """
    distortion = known.known["distortion"]
    if start is None or start.n_rounds > 1 or distortion.standard_uncertainty == 0:
        return [{}]
    return [{"distortion": distortion.value + sign * _OTHER_SIGN * distortion.standard_uncertainty} for sign in (-1, 1)]


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
    One for each number of the shape, in the order of its covariance.
    """
    images = _images(recordings, wheel, rig=rig, timing=timing, known=found)
    return tuple(
        _varied(images, found, _numbers(found), name=name, step=step)
        for name, step in zip(SHAPE_NUMBERS, SHAPE_STEPS, strict=True)
    )


def products(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, found: SectorFit
) -> tuple[Product, ...]:
    """Pairs of numbers of the shape that act by their product: a lens that is off its centre moves what it distorts.

    Where both are near zero the derivatives say nothing of it. Parameters as for `fit`, which gave ``found``.

    Returns
    -------
    One for each pair of which neither number is known; `Variation` of the second with the first one standard uncertainty larger
    and smaller.
    """
    u = found.u("distortion") if "distortion" in found.names else 0.0
    if u == 0:
        return ()
    images, numbers = _images(recordings, wheel, rig=rig, timing=timing, known=found), _numbers(found)
    bent = [numbers | {"distortion": numbers["distortion"] + way * u} for way in (1, -1)]
    made = []
    for axis in ("lens_row_px", "lens_column_px"):
        if axis in found.names and found.u(axis) > 0:
            step = found.u(axis)
            larger, smaller = (_varied(images, found, one, name=axis, step=step) for one in bent)
            made.append(Product(larger=larger, smaller=smaller, first="distortion", second=axis))
    return tuple(made)


def _varied(images: _Images, found: SectorFit, numbers: Mapping[str, float], *, name: str, step: float) -> Variation:
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


def _told(images: _Images, numbers: Mapping[str, float], *, known: tuple[Array, float]) -> SectorFit:
    """The measured contrast, split into sector, plate and excess, with the covariance and how well all fits."""
    view, seen = images.view, images.contrast(numbers)
    inside = view.good & (seen.sharp > _WELL_INSIDE)
    border = view.good & (np.abs(seen.sharp - 0.5) < _BORDER)
    weight = _border_weight(seen.sharp, numbers["blur_px"])
    gains = _scatter(seen.residual[inside], seen.u)
    burrs = _scatter((seen.residual / weight)[border], seen.u)
    covariance, chi_square = known
    row_delay = NUMBERS.index("row_delay_s")
    return SectorFit(
        **_light(seen, numbers, view=view),
        names=SHAPE_NUMBERS,
        covariance=covariance[: len(SHAPE_NUMBERS), : len(SHAPE_NUMBERS)],
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
        u_row_delay_s=float(np.sqrt(covariance[row_delay, row_delay])),
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


def _priors(numbers: Mapping[str, float]) -> Array:
    """A loose word on the radii of the cutouts, the plate's reflection and the glare, for where they do not show."""
    inner = numbers["inner_radius_px"] - numbers["ring_inner_px"]
    outer = numbers["ring_outer_px"] - numbers["outer_radius_px"]
    margins = [(margin - _RING_MARGIN_PX) / _RING_MARGIN_PX for margin in (inner, outer)]
    glare = numbers["glare"] / _U_GLARE, math.log(numbers["glare_px"] / sector_image.GLARE_PX) / _U_GLARE_WIDTH
    return np.array([*margins, numbers["plate_reflection"], *glare])


def _summed(rows: ReducedRecording) -> Mask:
    first_row, end_row, first_column, end_column = rows.contrast_image.roi
    return rows.opening.summed[first_row:end_row, first_column:end_column]


def _covariance(jacobian: Array, residual: Array, clusters: Ticks) -> Array:
    """Covariance that holds for residuals that differ from the model by more than noise, alike within a cluster.

    ``clusters`` (m,) numbers those of the residuals, -1 for priors. In no direction is it smaller than noise and priors alone
    would make it.
    """
    scale = np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian))
    scaled = jacobian / np.where(scale > 0, scale, 1)
    sizes, axes = np.linalg.eigh(scaled.T @ scaled)
    white = axes / np.sqrt(np.maximum(sizes, 1e-12 * sizes[-1]))  # its square is the covariance of white noise
    scores = np.array([np.bincount(clusters + 1, one)[1:] for one in ((scaled * residual[:, None]) @ white).T])
    spread, turn = np.linalg.eigh(scores @ scores.T)
    root = white @ turn * np.sqrt(np.maximum(spread, 1.0)) / np.where(scale > 0, scale, 1)[:, None]
    return np.asarray(root @ root.T)
