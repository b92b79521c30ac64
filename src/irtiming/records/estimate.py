"""Estimates with their covariance, and what led to them."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array, Mask
from irtiming.records.choices import Method
from irtiming.records.exposed import ExposedFraction


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Estimate:
    """Named numbers with their units and covariance: measurands, or what a fit takes.

    Shapes: names, units and values (n,), covariance (n, n). Numbers are asked for by name.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    covariance: Array

    def __post_init__(self) -> None:
        n = len(self.names)
        if self.values.shape != (n,) or self.covariance.shape != (n, n) or len(self.units) != n:
            raise ValueError(
                f"{n} names, {len(self.units)} units, values {self.values.shape}, covariance {self.covariance.shape}: must agree"
            )

    @property
    def standard_uncertainties(self) -> Array:
        """Square roots of the diagonal, shape (n,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Array:
        """Correlation matrix, shape (n, n); 0 beside a measurand without uncertainty."""
        u = self.standard_uncertainties
        scale = np.where(u > 0, u, 1.0)
        return np.asarray(self.covariance / np.outer(scale, scale)) * np.outer(u > 0, u > 0)

    def __contains__(self, name: str) -> bool:
        return name in self.names

    def value(self, name: str) -> float:
        """Of one number."""
        return float(self.values[self.names.index(name)])

    def u(self, name: str) -> float:
        """Standard uncertainty of one number."""
        k = self.names.index(name)
        return float(np.sqrt(self.covariance[k, k]))

    def pick(self, *names: str) -> "Estimate":
        """Some of the numbers, in the order asked for."""
        at = [self.names.index(name) for name in names]
        return Estimate(
            names=names,
            units=tuple(self.units[k] for k in at),
            values=self.values[at],
            covariance=self.covariance[np.ix_(at, at)],
        )


@final
@dataclass(frozen=True, kw_only=True)
class RelativeDelay:
    """Delay of one recording minus that of the recordings with the smallest set delay: nominal and as measured, s."""

    file: str
    nominal_s: float
    value_s: float
    standard_uncertainty_s: float


@final
@dataclass(frozen=True, kw_only=True)
class Contribution:
    """One line of the uncertainty budget of the trigger delay: what it is, and its standard uncertainty, s.

    ``kind`` is A or B as in the GUM; ``degrees_of_freedom`` say how well the uncertainty itself is known.
    """

    source: str
    kind: str
    standard_uncertainty_s: float
    degrees_of_freedom: float = float("inf")


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SlopeLine:
    """The line 1/2 + m (x - c) through the points of one slope (Schatz 2023, 3.1.4).

    ``edge`` is the wheel edge 0..3 that makes the slope; ``angle_rad`` and ``fraction`` the points used, shape (n,), with
    angles unwrapped around ``centre_rad``.
    """

    edge: int
    centre_rad: float
    u_centre_rad: float
    slope_per_rad: float
    reduced_chi_square: float
    angle_rad: Array
    fraction: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class PublishedFit:
    """The averaged data of one nominal delay and the four lines through its slopes, in the order of edges 0..3."""

    data: ExposedFraction
    lines: tuple[SlopeLine, SlopeLine, SlopeLine, SlopeLine]
    angular_frequency_rad_per_s: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeDelayFit:
    """The piecewise model fitted to the pixel sums of one recording.

    Parameters
    ----------
    edge_delay_s, covariance_s2
        Shape (4,), (4, 4); delay of the start of integration as seen from each wheel edge, set delay taken off.
    start_delay_s
        Where the search began; the fit has left it.
    wheel_angle_rad, fraction, residual
        Shape (n,); angle at the start of integration in [0, 2 pi), normalised sums, and their difference from the
        model; sorted by angle.
    opening_angle_rad
        Fitted angle of the opening.
    noise
        Standard deviation of the residuals, opening fractions.
    widening
        Factor on the covariance for residuals that are correlated along the angle; 1 when they are white.
    kept
        Shape (n_frame,); frames of the reduced recording that took part.
    values
        Shape (12,); what the model took, in the order of `estimate.pixel_sum_model.NAMES`.
    """

    name: str
    trigger_delay_time_set_s: float
    angular_frequency_rad_per_s: float
    edge_delay_s: Array
    covariance_s2: Array
    start_delay_s: float
    wheel_angle_rad: Array
    fraction: Array
    residual: Array
    opening_angle_rad: float
    noise: float
    widening: float
    n_dropped: int
    kept: Mask
    values: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DelayResult:
    """What the estimation hands to the report."""

    method: Method
    estimate: Estimate
    relative_delays: tuple[RelativeDelay, ...]
    budget: tuple[Contribution, ...]
    edge_delay_s: Array
    u_edge_delay_s: Array
    warnings: tuple[str, ...]
