"""The light of a blurred sector in the sums over rows, with its glare."""

from irtiming.physics import blurred_sector, sector_points
from irtiming.records.arrays import ComplexArray, Mask, Ticks
from irtiming.records.row_timing import SectorShape


def harmonics(
    shape: SectorShape, rows: Ticks, *, summed: Mask, roi: tuple[int, int, int, int], n_harmonics: int
) -> ComplexArray:
    """Fourier coefficients over polar angle of the light in each row, px^2, shape (n_row, M + 1).

    Parameters
    ----------
    shape
        The sector.
    rows
        Image rows in the region, shape (n_row,).
    summed
        Pixels of which each row's sum is made, shape (roi rows, roi columns): glare beside them is lost.
    roi
        The region: first row, end row, first column, end column.
    n_harmonics
        Highest order M.
    """
    points = sector_points.light_points(shape, n_harmonics=n_harmonics)
    inside = blurred_sector.row_harmonics(points, rows, blur_px=shape.blur.rows_px, n_harmonics=n_harmonics)
    if shape.glare == 0:
        return inside
    wide = blurred_sector.glare_harmonics(shape, summed, roi=roi, n_harmonics=n_harmonics)
    return (1 - shape.glare) * inside + shape.glare * wide[rows - roi[0]]
