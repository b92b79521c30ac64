"""What a camera's parameters do over a setting: fits, a step, and the results they stand on."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array
from irtiming.records.setting_point import SETTINGS, CameraKey, SettingName, SettingPoint
from irtiming.records.short_repr import short_repr

SLOPES = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""What a time may change by where a time is set: not at all, with all of it, or with half."""

_AGREES = 2.0  # standard uncertainties


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LineFit:
    """Coefficients (k,) with their covariance (k, k), the residuals (n,), chi-squared and its degrees of freedom.

    ``probability`` is that of a chi-squared as large or larger; 1 where there is nothing to test.
    """

    coefficients: Array
    covariance: Array
    residuals: Array
    chi_squared: float
    degrees_of_freedom: int
    probability: float

    @property
    def birge(self) -> float:
        """Square root of chi-squared over its degrees of freedom; 1 where there are none."""
        freedom = self.degrees_of_freedom
        return float(np.sqrt(self.chi_squared / freedom)) if freedom > 0 else 1.0


@final
@dataclass(frozen=True, kw_only=True)
class Step:
    """The best place of a step in a line: between two settings, its size, and how likely one as clear is where there is none.

    The p-value is that of the gain in chi-squared times the number of places that were tried (Bonferroni), at most 1.
    """

    after: float
    before: float
    size: float
    standard_uncertainty: float
    p_value: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class OverSetting:
    """A parameter over a setting.

    Parameters
    ----------
    parameter, unit, event
        Of the results.
    setting
        In which they differ.
    points
        Results, ascending.
    x, values
        Shape (n,); setting in SI units, value in ``unit``.
    covariance
        Of the values, shape (n, n).
    level, line
        Fits; the line has its value at x = 0 and its slope.
    step
        None where there are too few values, or none is clear.
    """

    __repr__ = short_repr

    parameter: str
    unit: str
    event: str
    setting: SettingName
    points: tuple[SettingPoint, ...]
    x: Array
    values: Array
    covariance: Array
    level: LineFit
    line: LineFit
    step: Step | None

    @property
    def slope(self) -> tuple[float, float]:
        """Slope with its standard uncertainty, widened by the ratio of Birge where values lie further off than they should."""
        inflation = max(1.0, self.line.birge)
        return float(self.line.coefficients[1]), inflation * float(np.sqrt(self.line.covariance[1, 1]))

    @property
    def is_time_over_time(self) -> bool:
        """Whether a slope is a plain number that may be a simple one."""
        return self.unit == "s" and SETTINGS[self.setting][1] == "s"

    @property
    def simple_slopes(self) -> tuple[float, ...]:
        """Those of `SLOPES` that agree with the slope within two standard uncertainties; none where it is no time over a time."""
        value, u = self.slope
        return tuple(one for one in SLOPES if abs(value - one) <= _AGREES * u) if self.is_time_over_time else ()

    @property
    def differences(self) -> tuple[Array, Array]:
        """Values less the first, and standard uncertainties of that; shape (n,), in ``unit``; common inputs cancel."""
        variance = np.diag(self.covariance) + self.covariance[0, 0] - 2 * self.covariance[0]
        return self.values - self.values[0], np.sqrt(np.maximum(variance, 0.0))


@final
@dataclass(frozen=True, kw_only=True)
class CameraSeries:
    """A camera, all its points, and what its parameters do over each setting in which they differ."""

    camera: CameraKey
    points: tuple[SettingPoint, ...]
    over: tuple[OverSetting, ...]
