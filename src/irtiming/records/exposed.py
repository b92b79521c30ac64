"""Opening fractions over the wheel angle, averaged over runs: what the published procedures start from."""

from dataclasses import dataclass
from typing import final

from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.short_repr import short_repr


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ExposedFraction:
    """Opening fraction over the wheel angle at the trigger, averaged over runs per nominal angle (figure 5).

    Shapes (n,), sorted by angle; the uncertainties are standard uncertainties of the means, None with a single run.
    ``names`` and ``files`` are those of the recordings.
    ``plateaus`` are the angle intervals used for normalisation: (start, end, level 0 or 1).
    """

    __repr__ = short_repr

    trigger_delay_time_set_s: float
    rotation_speed_hz: float
    angular_frequency_rad_per_s: float
    names: tuple[str, ...]
    files: tuple[str, ...]
    wheel_angle_rad: Array
    fraction: Array
    u_wheel_angle_rad: Array | None
    u_fraction: Array | None
    plateaus: tuple[tuple[float, float, int], ...]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ExposedRows:
    """Opening fractions of whole opening and rows over the wheel angle at the trigger, averaged over runs (figure 6).

    Shapes: ``wheel_angle_rad`` (n,), sorted; ``fraction`` (n,) of the whole opening, ``row_fraction`` (n_row, n), all
    normalised by the averages of their upper and lower extrema and reversed for a cold blackbody, so that 1 is open;
    ``u_fraction`` (n,) and ``u_row_fraction`` (n_row, n) standard uncertainties of the means, None with a single run.
    ``row_px`` (n_row,). ``names`` and ``files`` are those of the recordings. ``mask`` is the binary mask (row, column).
    """

    __repr__ = short_repr

    trigger_delay_time_set_s: float
    rotation_speed_hz: float
    angular_frequency_rad_per_s: float
    names: tuple[str, ...]
    files: tuple[str, ...]
    wheel_angle_rad: Array
    fraction: Array
    u_fraction: Array | None
    row_px: Ticks
    row_fraction: Array
    u_row_fraction: Array | None
    mask: Mask
