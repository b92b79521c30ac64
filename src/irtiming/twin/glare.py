"""Light that goes astray in a lens: a tabulated tail over many pixels, for whole frames and for rays."""

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.fft import irfft2, rfft2

from irtiming.records.arrays import Array, ComplexArray
from irtiming.twin.noise import Values
from irtiming.twin.optics import GlareShape, Optics
from irtiming.twin.spread import Offsets

_FARTHEST = {"gaussian": 4.5, "exponential": 7.0}
"""Where the tables end, in standard deviations along an axis."""

_ALONG_PIXEL = 5
_GOLDEN = (math.sqrt(5) - 1) / 2


def _density(radius_px: Array, glare_px: float, shape: GlareShape) -> Array:
    """Of light at a distance, any shape, up to a factor."""
    if shape == "gaussian":
        return np.exp(-0.5 * (radius_px / glare_px) ** 2)
    return np.exp(-radius_px * math.sqrt(3) / glare_px)  # of variance 3 lengths^2 along each axis


def tail_table(optics: Optics) -> Array:
    """Shares of the stray light by pixel, shape (2 n + 1, 2 n + 1), adding up to 1; its own pixel is in the middle.

    Parameters
    ----------
    optics
        Glare counts.
    """
    n = math.ceil(_FARTHEST[optics.glare_shape] * optics.glare_px)
    fine = (np.arange((2 * n + 1) * _ALONG_PIXEL) + 0.5) / _ALONG_PIXEL - n - 0.5
    density = _density(np.hypot(fine[:, None], fine[None, :]), optics.glare_px, optics.glare_shape)
    table = density.reshape(2 * n + 1, _ALONG_PIXEL, 2 * n + 1, _ALONG_PIXEL).sum(axis=(1, 3))
    return np.asarray(table / table.sum())


def stray_places(optics: Optics, n: int, *, variants: int) -> Offsets:
    """Places, px from a pixel's centre, from which its stray light comes in equal parts.

    Parameters
    ----------
    optics
        Glare counts.
    n
        Places of one variant; they fill the plane evenly.
    variants
        Shifted and turned copies.

    Returns
    -------
    Shape (variants, n, 2): row, column.
    """
    radius = np.linspace(0, _FARTHEST[optics.glare_shape] * optics.glare_px, 20_001)
    density = radius * _density(radius, optics.glare_px, optics.glare_shape)
    below = np.cumsum(density) - 0.5 * density
    shift = np.random.Generator(np.random.SFC64(2)).random((variants, 1, 2))
    order = np.arange(n)
    even = np.stack([(order + 0.5) / n, np.mod(0.5 + order * _GOLDEN, 1.0)], axis=1)
    even = np.mod(even + shift, 1.0)
    away, angle = np.interp(even[..., 0], below / density.sum(), radius), 2 * math.pi * even[..., 1]
    return np.stack([away * np.sin(angle), away * np.cos(angle)], axis=-1).astype(np.float32)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Veil:
    """The tail laid over whole frames that were taken at one instant; beyond their border they go on as they end.

    ``spectrum`` is the table's discrete Fourier transform over an image of ``size`` rows and columns, ``margin_px`` how far
    the tail reaches.
    """

    share: float
    margin_px: int
    size: tuple[int, int]
    spectrum: ComplexArray

    def cover(self, signal_dn: Values) -> None:
        """Replace a frame, shape (row, column), by what reaches its pixels."""
        margin, (rows, columns) = self.margin_px, signal_dn.shape
        level = np.float32(signal_dn[0, 0])
        wide = np.pad(signal_dn - level, margin, mode="edge")
        stray = irfft2(rfft2(wide, s=self.size) * self.spectrum, s=self.size)
        stray = stray[2 * margin : 2 * margin + rows, 2 * margin : 2 * margin + columns]
        signal_dn += np.float32(self.share) * (stray + level - signal_dn)


def veil_of(optics: Optics, *, rows_columns: tuple[int, int]) -> Veil | None:
    """The tail ready for frames of this size; None where no light goes astray.

    Parameters
    ----------
    optics
        Glare counts.
    rows_columns
        Size of the frames.
    """
    if optics.glare_share == 0:
        return None
    table = tail_table(optics)
    margin = table.shape[0] // 2
    size = (_fast_length(rows_columns[0] + 4 * margin), _fast_length(rows_columns[1] + 4 * margin))
    spectrum = rfft2(table.astype(np.float32), s=size)
    return Veil(share=optics.glare_share, margin_px=margin, size=size, spectrum=spectrum)


def _fast_length(n: int) -> int:
    """Least length from this one on that has no prime factor above 5: its Fourier transform is quick."""
    while 30 ** n.bit_length() % n:
        n += 1
    return n
