"""Where the axle lies in the image, and how the mask opening lies about it.

Each pixel of the opening is covered twice and uncovered twice a turn. The phase of the second harmonic of its values
over the wheel angle is therefore twice its polar angle about the axle, whatever the delay: no mask, edge or lens is
needed to find the centre. The mask's own two edges then give its bisector. Where the mask's centre is not the axle, the
mean angle of the light that comes through differs from the bisector, and the opening fraction is shifted by as much.

How much a pixel swings with the wheel is its contrast, in the opening and on the plate beside it. Frames on plateaus would not
do: in some of them an edge of the wheel stands beside the opening, and the plate seems to fade away from it.

All of these are angles in the plane that the lens has not distorted (`physics.lens`). Where the axle is not in the middle of the
image the same phases tell the distortion; where it is, what rig.toml states of it holds, and matters little.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy import ndimage
from scipy.optimize import least_squares

from irtiming.physics.covariance import of_correlated_scores
from irtiming.physics.lens import HIGHEST, LOWEST, Lens
from irtiming.records.arrays import Array, ComplexArray, Mask, Ticks
from irtiming.records.reduced import AxleView, ContrastImage, Opening
from irtiming.records.rig import Measured, Rig
from irtiming.reduce.opening import mask_shape, opening_share

_ENOUGH_PIXELS = 200
_U_STRAIGHT_PX = 0.1  # of an edge traced through blurred pixels: what simulated images of 160 to 640 columns showed
_FIRMEST = 1e-5  # uncertainty of a distortion that counts as exact
_ROUNDS = 3
_CLUSTER_PX = 3.0
_U_FIELD = 0.03  # of what the mirroring wheel would turn the bisector by: what hills and a skewed slope do not make
_WAVE_PX = 6
_EDGE_SPAN = (0.1, 0.9)  # of the radial extent of the mask: where its straight edges are traced


def locate(contrast: ContrastImage, opening: Opening, *, rig: Rig) -> AxleView | None:
    """Axle and mask in the image from the second harmonic of the pixel values.

    Parameters
    ----------
    contrast, opening
        Of the same recording.
    rig
        Direction of the wheel in the image, and what is known of the lens.

    Returns
    -------
    None where the opening has too few pixels to tell.
    """
    row0, row1, column0, column1 = opening.roi
    good = contrast.good
    inside = _well_inside(opening) & good
    if inside.sum() < 50:
        return None
    rows, columns = np.mgrid[row0:row1, column0:column1].astype(float)
    swing = contrast.projection_dn if rig.wheel.rotation == "counterclockwise" else contrast.projection_dn.conj()
    places = (rows[inside], columns[inside])
    image = opening.mask.shape
    seen = _centre(np.asarray(np.angle(swing[inside]), float), places, image=image, distortion=rig.camera.distortion)
    region = _region(swing, seen, opening=opening, good=good, inside=inside)
    told = _mask(seen, region)
    u_view, u_light = _by_view(seen, told, region), _by_light(seen, told, region)
    u_ends = float(np.sqrt(np.sum(told.ends.u_direction_rad**2)) / 2)
    return AxleView(
        row_px=float(seen.place[0]),
        column_px=float(seen.place[1]),
        u_centre_px=float(np.sqrt(max(seen.covariance[0, 0], seen.covariance[1, 1]))),
        bisector_rad=told.bisector_rad,
        u_bisector_rad=float(np.linalg.norm([u_ends, u_view, u_light])),
        mean_angle_rad=told.mean_angle_rad,
        edge_miss_px=(float(told.ends.miss_px[0]), float(told.ends.miss_px[1])),
        u_edge_miss_px=float(np.hypot(told.ends.u_miss_px.max(), _U_STRAIGHT_PX)),
        distortion=float(seen.place[2]),
        u_distortion=float(np.sqrt(seen.covariance[2, 2])),
    )


def _contrast(swing: ComplexArray, polar: Array, inside: Mask) -> Array:
    """By how much each pixel swings with the wheel, along the phase of its polar angle; its median is 1 inside the opening."""
    turned = swing * np.exp(-2j * polar)
    along = turned * np.exp(-1j * np.angle(turned[inside].sum()))
    return np.asarray(along.real / np.median(along.real[inside]))


def _beside(mask: Mask, border_px: int, *, radius: Array, inside: Mask) -> Mask:
    """Pixels of the plate beside the opening's two straight edges, where the cutouts pass too but no blur of it reaches."""
    away = ndimage.distance_transform_edt(~mask)
    low, high = _span(radius[inside])
    near = (away > border_px - 2) & (away <= border_px + 4)
    return np.asarray(near & (radius > low) & (radius < high))


def _span(radius: Array) -> tuple[float, float]:
    """Radii between which the mask's edges are traced."""
    low, high = np.quantile(radius, [0.02, 0.98])
    return float(low + _EDGE_SPAN[0] * (high - low)), float(low + _EDGE_SPAN[1] * (high - low))


def _mended(contrast: Array, good: Mask) -> Array:
    """Contrast with each bad pixel replaced by the mean of its good neighbours: a hole would turn the mask."""
    light = ndimage.uniform_filter(np.where(good, contrast, 0.0), 3)
    share = ndimage.uniform_filter(good.astype(float), 3)
    return np.where(good, contrast, light / np.maximum(share, 1 / 9))


def _well_inside(opening: Opening) -> Mask:
    """Pixels whose blur does not reach the mask's border: a cut blur would shift their polar angle."""
    row0, row1, column0, column1 = opening.roi
    mask = opening.mask[row0:row1, column0:column1]
    for depth in range(max(2, opening.border_px - 2), 0, -1):
        inside = ndimage.binary_erosion(mask, iterations=depth)
        if inside.sum() >= _ENOUGH_PIXELS:
            return np.asarray(inside)
    return mask


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _View:
    """Row and column of the axle in the image (px) and distortion, shape (3,), their covariance, and the size of the image."""

    place: Array
    covariance: Array
    image: tuple[int, ...]

    @property
    def lens(self) -> Lens:
        return Lens(distortion=float(self.place[2]), rows=self.image[0], columns=self.image[1])

    def from_axle(self, rows: Array, columns: Array) -> tuple[Array, Array]:
        """Places of the image, from the axle down and to the right in the undistorted plane, px."""
        return _from_axle(self.place, rows, columns, image=self.image)

    def in_image(self, down: Array, across: Array) -> tuple[Array, Array]:
        """The way back."""
        row, column = self.lens.flat(*self.place[:2])
        back: tuple[Array, Array] = self.lens.seen(row + down, column + across)
        return back


def _from_axle(place: Array, rows: Array, columns: Array, *, image: tuple[int, ...]) -> tuple[Array, Array]:
    lens = Lens(distortion=float(place[2]), rows=image[0], columns=image[1])
    axle = lens.flat(float(place[0]), float(place[1]))
    row, column = lens.flat(rows, columns)
    return row - axle[0], column - axle[1]


def _centre(phase: Array, places: tuple[Array, Array], *, image: tuple[int, ...], distortion: Measured) -> _View:
    """Axle and distortion with which the phases are twice the polar angles."""
    rows, columns = places

    def misfit(p: Array) -> Array:
        down, across = _from_axle(np.array([p[0], p[1], p[3]]), rows, columns, image=image)
        return np.asarray(np.angle(np.exp(1j * (phase - 2 * np.arctan2(down, across) - p[2]))))

    def start(row: float, column: float) -> Array:
        polar = np.arctan2(rows - row, columns - column)
        turned = float(np.angle(np.mean(np.exp(1j * (phase - 2 * polar)))))
        return np.array([row, column, turned, distortion.value])

    row, column, reach = rows.mean(), columns.mean(), np.ptp(rows) + np.ptp(columns)
    around = [(row + reach * a, column + reach * b) for a in (-1, -0.5, 0, 0.5, 1) for b in (-1, -0.5, 0, 0.5, 1)]
    best = min((start(r, c) for r, c in around), key=lambda p: float(np.sum(misfit(p) ** 2)))
    u = max(distortion.standard_uncertainty, _FIRMEST)
    limits = ([-np.inf, -np.inf, -np.inf, LOWEST], [np.inf, np.inf, np.inf, HIGHEST])
    scatter, covariance = 0.0, np.zeros((4, 4))
    for _ in range(_ROUNDS):  # the prior weighs as much as the pixels' scatter lets it
        weight = scatter / u

        def known(p: Array, weight: float = weight) -> Array:
            return np.append(misfit(p), weight * (p[3] - distortion.value))

        fit = least_squares(known, best, x_scale=(1.0, 1.0, 0.1, 0.02), bounds=limits)
        best, jacobian = fit.x, np.asarray(fit.jac)
        down, across = _from_axle(best[[0, 1, 3]], rows, columns, image=image)
        pixels = _clusters(down, across)
        scatter = _scatter(jacobian[:-1], fit.fun[:-1], pixels)
        covariance = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-14) * scatter**2
    kept = np.array([0, 1, 3])
    return _View(place=best[kept], covariance=covariance[np.ix_(kept, kept)], image=image)


def _clusters(down: Array, across: Array) -> Ticks:
    """Number of the sector of a few pixels' width that a place lies in: an edge passes it in the same frames."""
    radius = float(np.hypot(down, across).mean())
    middle = float(np.arctan2(down.mean(), across.mean()))
    apart = np.mod(np.arctan2(down, across) - middle + np.pi, 2 * np.pi)
    return np.unique((apart * radius / _CLUSTER_PX).astype(np.int64), return_inverse=True)[1]


def _scatter(jacobian: Array, residual: Array, clusters: Ticks) -> float:
    """Standard deviation of a pixel's phase, were pixels independent: neighbours around the axle share the wheel's errors.

    By as much as the scores of whole clusters scatter more than those of their pixels would.
    """
    scale = np.sqrt(np.einsum("ij,ij->j", jacobian, jacobian))
    whitened = np.linalg.qr(jacobian / scale)[0] * residual[:, None]
    n = int(clusters.max()) + 1
    sums = np.array([np.bincount(clusters, one, n) for one in whitened.T])
    alone, together = float(np.mean(residual**2)), float(np.mean(np.sum(sums**2, axis=1))) * n / max(n - 4, 1)
    return float(np.sqrt(max(alone, together)))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Ends:
    """The mask's two straight edges, that of the smaller polar angle first.

    At the radius r an edge stands at direction + miss / r. Directions are relative to the middle of the mask; shapes (2,).
    """

    direction_rad: Array
    u_direction_rad: Array
    miss_px: Array
    u_miss_px: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Mask:
    """Direction of the bisector, mean angle of the light, and the edges, traced between two radii ``span_px``."""

    bisector_rad: float
    mean_angle_rad: float
    span_px: tuple[float, float]
    ends: _Ends


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Region:
    """Contrast of the region that begins at ``corner``, each pixel's share in the opening, and the pixels well inside it.

    Shapes (roi rows, roi columns). ``doubt`` is by how much the shares change with one u of the plate's mirroring.
    """

    light: Array
    share: Array
    doubt: Array
    inside: Mask
    corner: tuple[int, int]


def _region(swing: ComplexArray, seen: _View, *, opening: Opening, good: Mask, inside: Mask) -> _Region:
    """Contrast and shares of the pixels of the summed region."""
    row0, row1, column0, column1 = opening.roi
    mask = opening.mask[row0:row1, column0:column1]
    rows, columns = np.mgrid[row0:row1, column0:column1].astype(float)
    down, across = seen.from_axle(rows, columns)
    contrast = _mended(_contrast(swing, np.arctan2(down, across), inside), good)
    border_px = min(opening.border_px, mask_shape.border_px(contrast, mask) + 1)
    within = inside | ndimage.binary_erosion(mask, iterations=max(1, border_px - 2))
    beside = _beside(mask, border_px, radius=np.hypot(down, across), inside=inside)
    share, doubt = opening_share.of_pixels(contrast, inside=within & good, beside=beside & good)
    summed = opening.weight[row0:row1, column0:column1] > 0
    summed |= ~good & ndimage.binary_dilation(summed)
    return _Region(
        light=np.where(summed, contrast, 0.0),
        share=np.where(summed, share, 0.0),
        doubt=np.where(summed, doubt, 0.0),
        inside=inside,
        corner=(row0, column0),
    )


def _mask(view: _View, region: _Region) -> _Mask:
    """The mask about the axle."""
    light = region.light
    rows, columns = np.mgrid[: light.shape[0], : light.shape[1]].astype(float)
    down, across = view.from_axle(rows + region.corner[0], columns + region.corner[1])
    polar, span = np.arctan2(down, across), _span(np.hypot(down, across)[region.inside])
    middle = float(np.angle(np.sum(light * np.exp(1j * polar))))
    offset = np.mod(polar - middle + np.pi, 2 * np.pi) - np.pi
    ends = _ends(region.share, view, corner=region.corner, middle=middle, radii=span)
    return _Mask(
        bisector_rad=float(middle + ends.direction_rad.mean()),
        mean_angle_rad=middle + float(np.sum(light * offset) / np.sum(light)),
        span_px=span,
        ends=ends,
    )


def _by_view(view: _View, told: _Mask, region: _Region) -> float:
    """Uncertainty of mean angle minus bisector because axle and distortion are uncertain, rad."""
    sizes, axes = np.linalg.eigh(view.covariance)
    steps = axes * np.sqrt(np.maximum(sizes, 0.0))
    others = [
        _mask(replace(view, place=np.append((view.place + step)[:2], _possible((view.place + step)[2]))), region)
        for step in steps.T
    ]
    moved = [(one.mean_angle_rad - one.bisector_rad) - (told.mean_angle_rad - told.bisector_rad) for one in others]
    return float(np.linalg.norm(moved))


def _by_light(view: _View, told: _Mask, region: _Region) -> float:
    """Uncertainty of the bisector because the wheel mirrors the camera, and the plate may, rad."""
    middle = told.bisector_rad - float(told.ends.direction_rad.mean())

    def turned_by(light: Array) -> float:
        ends = _ends(light, view, corner=region.corner, middle=middle, radii=told.span_px)
        return float(np.mean(ends.direction_rad - told.ends.direction_rad))

    return float(np.hypot(turned_by(region.share + region.doubt), _U_FIELD * turned_by(region.light)))


def _possible(distortion: float) -> float:
    return float(np.clip(distortion, LOWEST, HIGHEST))


def _ends(contrast: Array, view: _View, *, corner: tuple[int, int], middle: float, radii: tuple[float, float]) -> _Ends:
    """Both straight edges of the mask.

    On each arc about the axle the light on one side of the middle reaches as far as the edge: its sum, not a threshold,
    gives the end.
    """
    n_rings = max(6, int(radii[1] - radii[0]))
    radius = np.linspace(*radii, n_rings)
    fan = np.linspace(0, np.pi / 2, max(200, int(4 * radii[1])))
    design = np.stack([np.ones(n_rings), 1 / radius], axis=1)
    found, variances = np.zeros((2, 2)), np.zeros((2, 2))
    for k, side in enumerate((-1, 1)):
        polar = middle + side * fan
        row, column = view.in_image(radius[:, None] * np.sin(polar), radius[:, None] * np.cos(polar))
        light = ndimage.map_coordinates(contrast, (row - corner[0], column - corner[1]), order=5, mode="nearest")
        reach = side * np.trapezoid(light, fan, axis=1)
        found[k], *_ = np.linalg.lstsq(design, reach, rcond=None)
        spread = reach - design @ found[k]
        variances[k] = np.diag(_line_covariance(design, spread))
    return _Ends(
        direction_rad=found[:, 0],
        u_direction_rad=np.sqrt(variances[:, 0]),
        miss_px=found[:, 1],
        u_miss_px=np.sqrt(variances[:, 1]),
    )


def _line_covariance(design: Array, spread: Array) -> Array:
    """Covariance of a straight line whose residuals wave as an oblique edge crosses the pixels: waves cancel."""
    white = np.linalg.inv(design.T @ design)
    middle = of_correlated_scores(design * spread[:, None], n_neighbours=_WAVE_PX, is_circular=False)
    return np.asarray(white @ middle @ white * spread.size / max(spread.size - 2, 1))
