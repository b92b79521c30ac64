"""Maps: the timing of every pixel of the opening, and what the maps say of the readout."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.finding import Finding
from irtiming.records.reduced import Region
from irtiming.records.short_repr import short_repr

_IMAGES = (
    "delay_s", "u_delay_s", "deviation_s", "u_shape_s", "time_constant_s", "u_time_constant_s", "correlation", "contrast_dn",
    "u_contrast_dn", "noise_dn",
)  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class ReadoutPattern:
    """By how much later one part of the pixels is read than the other, beyond the row delay: ``name`` says which, s."""

    name: str
    later_s: float
    u_later_s: float

    @property
    def pull(self) -> float:
        """In standard uncertainties."""
        return self.later_s / self.u_later_s if self.u_later_s > 0 else 0.0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LineMeans:
    """Means of the maps over the pixels of each row, or of each column.

    Parameters
    ----------
    line_px
        Shape (k,); rows or columns that hold pixels of the maps.
    n_pixels
        Shape (k,); how many they hold.
    delay_s, u_delay_s
        Shape (k,); weighted mean of the delay, and its standard uncertainty by the pixels' noise.
    deviation_s
        Shape (k,); the same of the delay less what the fit says for each pixel's row.
    time_constant_s, u_time_constant_s
        Shape (k,); of a camera that lags, else None.
    """

    __repr__ = short_repr

    line_px: Ticks
    n_pixels: Ticks
    delay_s: Array
    u_delay_s: Array
    deviation_s: Array
    time_constant_s: Array | None = None
    u_time_constant_s: Array | None = None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PixelMaps:
    """Timing of every pixel of the opening; arrays without a shape are (roi rows, roi columns), nan where there is no pixel.

    Parameters
    ----------
    roi
        First row, end row, first column, end column of the image, ends excluded.
    delay_name
        What the delay is: ``trigger_delay``, to the reading of the pixel, or ``exposure_midpoint_delay``, to the middle of its
        window; or that of another event than the trigger.
    delay_s, u_delay_s
        Delay, and its standard uncertainty by the pixel's own noise alone.
    expected_delay_s
        What the fit over all rows says for the pixel's row.
    contrast_dn, u_contrast_dn
        From covered to open as the pixel shows it, DN, in the first recording; negative before a colder blackbody.
    time_constant_s, u_time_constant_s
        Of a camera that lags, else None.
    correlation
        Of the errors by noise of delay and time constant; None without the latter.
    noise_dn
        Standard deviation from frame to frame, in the first recording, by ``noise_degrees_of_freedom``.
    u_shape_s
        What errors of the opening's shape in the image, which all pixels share, add to the delay's uncertainty beyond a common
        delay and a row delay.
    u_common_delay_s, u_common_time_constant_s
        Standard uncertainties of what all pixels have in common, as the result states them: not in those of the pixels.
    is_border
        Pixels that the blur of the opening's border reaches; its share of their light is corrected for.
    is_dead
        Pixels of the opening that the reduction found dead or blinking: without values.
    is_deviating
        Pixels whose numbers stray from those around them by more than chance.
    rows, columns
        Means over rows and over columns.
    row_delay_s, u_row_delay_s
        Slope of the delay over rows, by the maps alone; ``u_row_delay_s`` holds noise and shape.
    fitted_row_delay_s
        That of the fit; 0 of a snapshot.
    unseen_row_px
        Rows of the image that hold no pixel of the maps.
    patterns
        What is read later than its neighbours, beyond the row delay.
    reduced_chi_square
        Of the harmonics about what the maps say; 1 where noise is all there is.
    n_recordings
        How many they are made of.
    """

    __repr__ = short_repr

    roi: Region
    delay_name: str
    delay_s: Array
    u_delay_s: Array
    expected_delay_s: Array
    contrast_dn: Array
    u_contrast_dn: Array
    time_constant_s: Array | None
    u_time_constant_s: Array | None
    correlation: Array | None
    noise_dn: Array
    noise_degrees_of_freedom: int
    u_shape_s: Array
    u_common_delay_s: float
    u_common_time_constant_s: float | None
    is_border: Mask
    is_dead: Mask
    is_deviating: Mask
    rows: LineMeans
    columns: LineMeans
    row_delay_s: float
    u_row_delay_s: float
    fitted_row_delay_s: float
    unseen_row_px: Ticks
    patterns: tuple[ReadoutPattern, ...]
    reduced_chi_square: float
    n_recordings: int
    findings: tuple[Finding, ...] = ()

    @property
    def deviation_s(self) -> Array:
        """Delay less what the fit says for the pixel's row, shape (roi rows, roi columns)."""
        return self.delay_s - self.expected_delay_s

    @property
    def images(self) -> dict[str, Array]:
        """Maps by the names under which files and Python show them; without time constants where the camera does not lag."""
        every = {name: getattr(self, name) for name in _IMAGES}
        return {name: one for name, one in every.items() if one is not None}

    @property
    def n_pixels(self) -> int:
        """How many pixels have values."""
        return int(np.isfinite(self.delay_s).sum())
