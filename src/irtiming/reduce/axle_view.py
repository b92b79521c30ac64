"""Where the axle lies in the image, and how the mask opening lies about it.

Each pixel of the opening is covered twice and uncovered twice a turn. The phase of the second harmonic of its values
over the wheel angle is therefore twice its polar angle about the axle, whatever the delay: no mask, edge or lens is
needed to find the centre. The mask's own two edges then give its bisector. Where the mask's centre is not the axle, the
mean angle of the light that comes through differs from the bisector, and the opening fraction is shifted by as much.
"""

import numpy as np
from scipy import ndimage
from scipy.optimize import least_squares

from irtiming.records.arrays import Array, Mask
from irtiming.records.reduced import AxleView, Opening

_ENOUGH_PIXELS = 200
_EDGE_SPAN = (0.1, 0.9)  # of the radial extent of the mask: where its straight edges are traced


def locate(harmonic: Array, opening: Opening, *, pixel_gain: Array, turns_clockwise: bool) -> AxleView | None:
    """Axle and mask in the image from the second harmonic of the pixel values.

    Parameters
    ----------
    harmonic
        Shape (2, roi rows, roi columns); sum over frames of cos(2 theta) and sin(2 theta) times the value.
    opening
        From the same recording.
    pixel_gain
        Gain of the non-uniformity correction in the region of interest, same shape as its pixels; 0 for a bad pixel.
    turns_clockwise
        Direction of the wheel in the image.

    Returns
    -------
    None where the opening has too few pixels to tell.
    """
    row0, row1, column0, column1 = opening.roi
    step = opening.open_frame_dn - opening.covered_frame_dn
    scale = opening.peaks_dn[1] - opening.peaks_dn[0]
    good = pixel_gain > 0
    contrast = _mended((step / scale)[row0:row1, column0:column1], good)
    inside = _well_inside(opening) & good
    if inside.sum() < 50:
        return None
    rows, columns = np.mgrid[row0:row1, column0:column1].astype(float)
    sense = 1.0 if turns_clockwise else -1.0
    phase = sense * np.arctan2(harmonic[1], harmonic[0])
    centre, u_centre = _centre(phase[inside], rows[inside], columns[inside])
    polar = np.arctan2(rows - centre[0], columns - centre[1])
    radius = np.hypot(rows - centre[0], columns - centre[1])[inside]
    low, high = np.quantile(radius, [0.02, 0.98])
    span = tuple(float(low + part * (high - low)) for part in _EDGE_SPAN)
    summed = opening.weight > 0
    light = np.where(summed | (~good & ndimage.binary_dilation(summed)), contrast, 0.0)
    middle = np.angle(np.sum(light * np.exp(1j * polar)))
    offset = np.mod(polar - middle + np.pi, 2 * np.pi) - np.pi
    origin = (float(centre[0]) - row0, float(centre[1]) - column0)
    bisector, u_bisector = _bisector(light, origin, float(middle), (span[0], span[1]))
    mean_offset = float(np.sum(light * offset) / np.sum(light))
    return AxleView(
        row_px=float(centre[0]),
        column_px=float(centre[1]),
        u_centre_px=u_centre,
        bisector_rad=float(middle + bisector),
        u_bisector_rad=u_bisector,
        mean_angle_rad=float(middle + mean_offset),
    )


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


def _centre(phase: Array, rows: Array, columns: Array) -> tuple[Array, float]:
    """Centre about which the phases are twice the polar angles, and its standard uncertainty, px."""

    def misfit(p: Array) -> Array:
        polar = np.arctan2(rows - p[0], columns - p[1])
        return np.asarray(np.angle(np.exp(1j * (phase - 2 * polar - p[2]))))

    def start(row: float, column: float) -> tuple[float, float, float]:
        polar = np.arctan2(rows - row, columns - column)
        return row, column, float(np.angle(np.mean(np.exp(1j * (phase - 2 * polar)))))

    row, column, reach = rows.mean(), columns.mean(), np.ptp(rows) + np.ptp(columns)
    around = [(row + reach * a, column + reach * b) for a in (-1, -0.5, 0, 0.5, 1) for b in (-1, -0.5, 0, 0.5, 1)]
    best = min((start(r, c) for r, c in around), key=lambda p: float(np.sum(misfit(np.asarray(p)) ** 2)))
    fit = least_squares(misfit, best, x_scale=(1.0, 1.0, 0.1))
    jacobian: Array = np.asarray(fit.jac)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * float(np.mean(fit.fun**2))
    return fit.x[:2], float(np.sqrt(max(covariance[0, 0], covariance[1, 1])))


def _bisector(
    contrast: Array, origin: tuple[float, float], middle: float, radii: tuple[float, float]
) -> tuple[float, float]:
    """Direction of the bisector of the mask's straight edges relative to ``middle``, and its uncertainty, rad.

    On each arc about the axle the light on one side of the middle reaches as far as the edge: its sum, not a threshold,
    gives the end. A straight edge that misses the axle by p ends at direction + p / radius.
    """
    n_rings = max(6, int(radii[1] - radii[0]))
    radius = np.linspace(*radii, n_rings)
    fan = np.linspace(0, np.pi / 2, max(200, int(4 * radii[1])))
    design = np.stack([np.ones(n_rings), 1 / radius], axis=1)
    ends, variances = [], []
    for side in (-1, 1):
        polar = middle + side * fan
        where = (
            origin[0] + radius[:, None] * np.sin(polar),
            origin[1] + radius[:, None] * np.cos(polar),
        )
        light = ndimage.map_coordinates(contrast, where, order=5, mode="nearest")
        reach = side * np.trapezoid(light, fan, axis=1)
        end, *_ = np.linalg.lstsq(design, reach, rcond=None)
        spread = reach - design @ end
        ends.append(float(end[0]))
        variances.append(float(spread @ spread / (n_rings - 2) * np.linalg.inv(design.T @ design)[0, 0]))
    return sum(ends) / 2, float(np.sqrt(sum(variances)) / 2)
