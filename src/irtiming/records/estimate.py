"""Estimates with their covariance, and what led to them."""

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from irtiming.records.arrays import Array, Mask
from irtiming.records.exposed import ExposedFraction
from irtiming.records.short_repr import short_repr

EDGE_DELAYS = ("edge_delay_0", "edge_delay_1", "edge_delay_2", "edge_delay_3")
"""Local numbers that every recording tells: delay as the passing of each wheel edge gives it, s."""

SHARES = ("recursive_filter", "pixel_memory")
"""Measurands that are no times but shares of the frame before: by a filter in the camera, or in its pixels."""


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
@dataclass(frozen=True, kw_only=True, eq=False)
class SlopeLine:
    """The line 1/2 + m (x - c) through the points of one slope (Schatz 2023, 3.1.4).

    ``edge`` is the wheel edge 0..3 that makes the slope; ``angle_rad`` and ``fraction`` the points used, shape (n,), with
    angles unwrapped around ``centre_rad``.
    """

    __repr__ = short_repr

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

    __repr__ = short_repr

    data: ExposedFraction
    lines: tuple[SlopeLine, SlopeLine, SlopeLine, SlopeLine]
    angular_frequency_rad_per_s: float


class RecordingFit(Protocol):
    """What any fit of one recording tells the joint fit."""

    @property
    def name(self) -> str:
        """Of the recording."""
        ...

    @property
    def trigger_delay_time_set_s(self) -> float:
        """Extra delay set, already taken off the edges' delays."""
        ...

    @property
    def angular_frequency_rad_per_s(self) -> float:
        """Of the wheel."""
        ...

    @property
    def estimate(self) -> Estimate:
        """Local numbers: EDGE_DELAYS, then what response, readout and light have."""
        ...

    @property
    def shape_effect(self) -> Array | None:
        """Shape (k, m); change of the local numbers per unit of each number of the sector's shape; None where it has no part."""
        ...

    @property
    def variance_inflation(self) -> float:
        """Variance inflation for correlated residuals, already in the covariance."""
        ...


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class DriftingLevels:
    """What the covered level and the step of one recording change by, each column with a number of its own.

    Parameters
    ----------
    drift
        Shape (n_frame, k); what is added to the covered level.
    gain
        Shape (n_frame, l); what is added to the step.
    relative_gain
        Shape (n_frame,); the step over its mean, by which small parts of the sum change as well.
    relative_offset
        Shape (n_frame,); covered level less its mean, over the mean of the step.
    covariance
        Shape (k + l, k + l); of the numbers of both, over the step, those of the covered level first.
    step_dn
        Mean of the step, DN of the pixel sum; negative for a cold blackbody.
    sway
        Range over which covered and open level go in the recording, opening fractions.
    jumps
        First frames after a jump of the levels, as places among the frames of the reduced recording.
    """

    drift: Array
    gain: Array
    relative_gain: Array
    relative_offset: Array
    covariance: Array
    step_dn: float
    sway: float = 0.0
    jumps: tuple[int, ...] = ()

    @property
    def n_numbers(self) -> int:
        """How many there are."""
        return self.drift.shape[1] + self.gain.shape[1]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeDelayFit:
    """The piecewise model fitted to the pixel sums of one recording.

    Parameters
    ----------
    estimate
        Local numbers: ``edge_delay_0`` .. ``edge_delay_3``, the middle of the integration window after trigger and set delay (s),
        ``opening_angle`` (rad), ``pixel_memory`` and ``bow`` (1).
    edge_delay_s
        Shape (4,); delay of the *start* of integration by each wheel edge; of the middle where the recording does not
        tell the integration time.
    start_delay_s
        Where the search began; the fit has left it.
    wheel_angle_rad, fraction, residual
        Shape (n,); angle at the start of integration in [0, 2 pi), normalised sums, and their difference from the
        model; sorted by angle.
    degrees_of_freedom
        Frames less the numbers of the estimate, and less those that the recording has for itself: levels, and how they drift.
    noise
        Standard deviation of the residuals, opening fractions.
    step
        Pixel sum from covered to open, over the first guess of it.
    variance_inflation
        Variance inflation for residuals that are correlated along the angle; 1 when they are white.
    kept
        Shape (n_frame,); frames of the reduced recording that took part; ``n_dropped`` did not.
    levels
        How the recording's levels drift; None: as a straight line.
    blades, u_blades
        By how much the covered level of the second blade lies above that of the first, and its standard uncertainty; opening
        fractions.
    """

    __repr__ = short_repr

    name: str
    trigger_delay_time_set_s: float
    angular_frequency_rad_per_s: float
    estimate: Estimate
    edge_delay_s: Array
    start_delay_s: float
    wheel_angle_rad: Array
    fraction: Array
    residual: Array
    degrees_of_freedom: int
    noise: float
    step: float
    variance_inflation: float
    n_dropped: int
    kept: Mask
    levels: DriftingLevels | None = None
    blades: float = 0.0
    u_blades: float = 0.0

    @property
    def covariance_s2(self) -> Array:
        """Of the four edges' delays, shape (4, 4)."""
        return self.estimate.covariance[:4, :4]

    @property
    def shape_effect(self) -> None:
        """The opening's shape in the image has no part in a sum over all of it."""
        return
