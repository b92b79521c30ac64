"""A clock as its pulses show it: error, drift, scatter and stability, in tables and a figure."""

from typing import TYPE_CHECKING

import numpy as np

from irtiming.records.clock_check import CameraClock, ClockCheck
from irtiming.report import sheet
from irtiming.report.blocks import Table
from irtiming.report.rounding import significant

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PPM = 1e6
_NS = 1e9
_HOUR_S = 3600.0


def errors(checks: tuple[ClockCheck, ...]) -> Table:
    """Error, drift and scatter of the clock, recording by recording."""
    rows = tuple(
        (
            one.name,
            str(one.time_s.size),
            _ppm(one.relative_error.value),
            significant(_PPM * one.relative_error.standard_uncertainty),
            f"{_PPM * _HOUR_S * one.drift_per_s.value:+.2g}",
            significant(_PPM * _HOUR_S * one.drift_per_s.standard_uncertainty),
            significant(_NS * one.scatter_s),
        )
        for one in checks
    )
    return Table(
        title="Clock of the trigger generator against the pulses",
        columns=("recording", "pulses", "error/ppm", "u", "drift/(ppm/h)", "u", "scatter/ns"),
        align="lrrrrrr",
        rows=rows,
        note="error: (true frequency - clock_frequency) / clock_frequency; a time of 100 ms by the clock is "
        "100 ms / (1 + error). Taken on trust: the rate of the pulses, and that the clock stays as it is until the "
        "recordings that are analysed with it.",
    )


def stability(checks: tuple[ClockCheck, ...]) -> Table:
    """Allan deviation of the relative frequency over the interval."""
    intervals = sorted({interval for one in checks for interval, _ in one.stability})
    known = [dict(one.stability) for one in checks]
    rows = tuple(
        (f"{interval:g}", *(significant(_PPM * one[interval]) if interval in one else "–" for one in known))
        for interval in intervals
    )
    return Table(
        title="Allan deviation/ppm, noise of the pulses included",
        columns=("interval/s", *(one.name for one in checks)),
        align="r" * (len(checks) + 1),
        rows=rows,
    )


def cameras(found: tuple[CameraClock, ...]) -> Table:
    """The camera's clock against the trigger generator's."""
    rows = tuple(
        (
            one.name,
            str(one.n_frames),
            _ppm(one.relative_rate.value),
            significant(_PPM * one.relative_rate.standard_uncertainty),
            significant(_NS * one.scatter_s),
        )
        for one in found
    )
    return Table(
        title="Clock of the camera against that of the trigger generator",
        columns=("recording", "frames", "(rate - 1)/ppm", "u", "scatter/ns"),
        align="lrrrr",
        rows=rows,
        note="positive: the camera's clock counts more seconds than the trigger generator's.",
    )


def picture(checks: tuple[ClockCheck, ...]) -> "Figure":
    """Above, how much later than regular each pulse was stamped; below, the Allan deviation."""
    with sheet.style():
        drawn = sheet.figure(height_in=4.6)
        upper, lower = drawn.subplots(2, 1)
        for one, colour in zip(checks, sheet.SERIES * (1 + len(checks) // len(sheet.SERIES)), strict=False):
            upper.plot(one.time_s, _NS * one.residual_s, ".-", color=colour, linewidth=0.6, label=one.name)
            if one.stability:
                interval_s, deviation = np.array(one.stability).T
                lower.loglog(interval_s, _PPM * deviation, "o-", color=colour, label=one.name)
        upper.set(
            xlabel="time from the first pulse / s",
            ylabel="later than a line / ns",
            title="Pulses beside a straight line",
        )
        lower.set(
            xlabel="interval / s", ylabel="deviation / ppm", title="Allan deviation, with the noise of the pulses"
        )
        upper.legend()
    return drawn


def _ppm(relative: float) -> str:
    return f"{_PPM * relative:+.4f}"
