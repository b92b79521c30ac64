"""What regular pulses tell of a clock: its rate, how it drifts and scatters, and which pulses are missing or extra."""

from dataclasses import dataclass
from typing import final

from irtiming.records.arrays import Array
from irtiming.records.finding import Finding
from irtiming.records.rig import Measured


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ClockCheck:
    """A clock against pulses of a known period, of one recording.

    ``relative_error`` is (true frequency - nominal) / nominal in the middle of the record, ``drift_per_s`` its change per second.
    Shapes (n_pulse,): ``time_s`` of each pulse that counts, from the first one, and ``residual_s``, how much later it was stamped
    than a straight line says. ``scatter_s`` is the residuals' standard deviation. ``stability`` has an interval in s and the
    overlapping Allan deviation of the relative frequency for each. ``missing_s`` and ``extra_s`` are times from the first pulse
    that counts.
    """

    name: str
    clock_frequency_hz: float
    pulse_period_s: float
    relative_error: Measured
    drift_per_s: Measured
    scatter_s: float
    time_s: Array
    residual_s: Array
    stability: tuple[tuple[float, float], ...]
    missing_s: tuple[float, ...]
    extra_s: tuple[float, ...]
    findings: tuple[Finding, ...] = ()


@final
@dataclass(frozen=True, kw_only=True)
class CameraClock:
    """The camera's own clock against the trigger generator's: its rate relative to that one minus 1, from ``n_frames`` frames.

    ``scatter_s`` is by how much a frame's own timestamp strays from a straight line over its trigger.
    """

    name: str
    relative_rate: Measured
    scatter_s: float
    n_frames: int
