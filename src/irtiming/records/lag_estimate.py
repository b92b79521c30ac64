"""Estimates of the timing of a rolling microbolometer camera, and what led to them."""

from dataclasses import dataclass
from typing import final

from irtiming.records.arrays import Array, Ticks
from irtiming.records.exposed import ExposedRows
from irtiming.records.finding import Finding
from irtiming.records.rig import Rotation
from irtiming.records.short_repr import short_repr


@final
@dataclass(frozen=True, kw_only=True)
class WheelInImage:
    """How the camera sees the wheel.

    ``row_px``, ``column_px`` locate the axle in the image. ``roll_rad`` is the roll of the camera: polar angle in the image
    minus polar angle in the rig. ``rotation`` is as the camera sees it.
    """

    row_px: float
    column_px: float
    roll_rad: float
    rotation: Rotation = "clockwise"


@final
@dataclass(frozen=True, kw_only=True)
class LagTiming:
    """The three timing parameters of a microbolometer camera (Schatz 2023, equations 2 and 3), s.

    ``trigger_delay_s`` refers to image row 0, ``row_delay_s`` is added per row.
    """

    trigger_delay_s: float
    row_delay_s: float
    time_constant_s: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PublishedLagFit:
    """What the procedure of Schatz 2023, 3.2.4 finds in the averaged data of one nominal delay.

    Parameters
    ----------
    timing, u_timing
        Values, set delay taken off, and their standard uncertainties: of the time constant from the parabola, of the
        others from the straight line over the rows. They hold the scatter of those two fits and nothing else.
    initial_timing
        Where each search of both delays began; its time constant is the one read off the start of the slopes.
    time_constants_s, rms
        Shape (n_tau,); time constants tried, and the RMS deviation of the simulation from all data sets at each.
    parabola
        Shape (3,); coefficients of rms = p0 + p1 tau + p2 tau^2, tau in s.
    row_px, delay_of_row_s
        Shape (n_row,); image rows that were compared, and the delay of each, set delay taken off; ``timing`` is the line
        through them. NaN for a row that lacks points on a slope.
    simulated_fraction, simulated_row_fraction
        Shapes (n,) and (n_row, n); simulation with ``timing`` at the angles of ``data``.
    deviation_rms
        RMS deviation of that simulation from all data sets.
    n_simulations
        Simulations that it took.
    """

    __repr__ = short_repr

    data: ExposedRows
    timing: LagTiming
    u_timing: LagTiming
    initial_timing: LagTiming
    time_constants_s: Array
    rms: Array
    parabola: Array
    row_px: Ticks
    delay_of_row_s: Array
    simulated_fraction: Array
    simulated_row_fraction: Array
    deviation_rms: float
    n_simulations: int
    findings: tuple[Finding, ...] = ()
