"""What a measurement found: one result for every camera, whatever parameters it has."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate
from irtiming.records.finding import Finding
from irtiming.records.short_repr import short_repr

Method = Literal["pixel-sum", "row-sum", "published"]
"""The project's best method by what it sums, and the procedure of Schatz 2023 step by step."""

_SURE = 6.0  # standard uncertainties of a variance, which no chance reaches
_ONE_SIDED_95 = 1.645

LEAST_WHITENESS = 1e-4
"""Ljung-Box p-value below which residuals are not called white: then there is a finding, and a red point in the report."""


@final
@dataclass(frozen=True, kw_only=True)
class RelativeDelay:
    """Delay of one recording minus that of the recordings with the smallest set delay: nominal and as measured, SI s.

    ``file`` is where the recording was read, or its name. ``deviation_s`` and ``u_deviation_s`` are measured minus nominal in the
    generator's own time, where its clock cancels; None where the method knows nothing of a clock: then the difference itself.
    """

    file: str
    nominal_s: float
    value_s: float
    standard_uncertainty_s: float
    deviation_s: float | None = None
    u_deviation_s: float | None = None

    @property
    def deviation(self) -> tuple[float, float]:
        """Measured minus nominal in the generator's own time, with its standard uncertainty, s."""
        if self.deviation_s is None or self.u_deviation_s is None:
            return self.value_s - self.nominal_s, self.standard_uncertainty_s
        return self.deviation_s, self.u_deviation_s


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Contribution:
    """One line of the uncertainty budget: what it is, A or B as in the GUM, and what it adds to each parameter.

    ``standard_uncertainty`` is by the parameter's name, in its unit; ``degrees_of_freedom`` say how well it is itself known.
    ``measured`` are standard uncertainty and unit of a measured quantity, where the line follows from one such number: what
    it adds over that is the sensitivity of the parameter.
    """

    source: str
    kind: str
    standard_uncertainty: Mapping[str, float]
    degrees_of_freedom: float = float("inf")
    measured: tuple[float, str] | None = None


@final
@dataclass(frozen=True, kw_only=True)
class Bound:
    """What is known of a parameter that the data do not determine: between ``lower`` and ``upper``, None if open; its unit."""

    name: str
    lower: float | None
    upper: float | None
    unit: str = "s"


@final
@dataclass(frozen=True, kw_only=True)
class DelayScatter:
    """By how much the delay differs from frame to frame: its variance and that one's standard uncertainty, s^2.

    Noise may make the variance negative.
    """

    variance_s2: float
    u_s2: float

    @property
    def is_sure(self) -> bool:
        """Whether it is more than chance."""
        return self.variance_s2 > _SURE * self.u_s2

    @property
    def standard_deviation_s(self) -> float:
        """Of the delay of a frame about the mean, where it is sure; else 0."""
        return float(np.sqrt(self.variance_s2)) if self.is_sure else 0.0

    @property
    def u_s(self) -> float:
        """Standard uncertainty of that, where it is sure; else 0."""
        return 0.5 * self.u_s2 / self.standard_deviation_s if self.is_sure else 0.0

    @property
    def upper_limit_s(self) -> float:
        """What the standard deviation stays below with 95 % probability."""
        return float(np.sqrt(max(self.variance_s2, 0.0) + _ONE_SIDED_95 * self.u_s2))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class EffectiveTimeConstants:
    """Time constant of eq. 2 as recordings at each blackbody temperature give it; they differ where the range is wide.

    Shapes (k,): ``blackbody_temperature_k``, ascending; ``time_constant_s``; ``contrast_dn``, mean change of the row sums from
    covered to open, negative for a blackbody colder than the wheel. ``covariance_s2`` (k, k).
    """

    __repr__ = short_repr

    blackbody_temperature_k: Array
    time_constant_s: Array
    covariance_s2: Array
    contrast_dn: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Likelihood along one parameter, all others at their best.

    Parameters
    ----------
    name, unit
        Of the parameter.
    value, standard_uncertainty
        Its estimate and what the covariance says.
    values, deviation
        Shape (k,); values tried, and twice the logarithm of the likelihood lost: 1 at one standard uncertainty.
    lower, upper
        Where the deviation reaches 1; None where the parameter's bound comes first.
    """

    __repr__ = short_repr

    name: str
    unit: str
    value: float
    standard_uncertainty: float
    values: Array
    deviation: Array
    lower: float | None
    upper: float | None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointFit:
    """One likelihood over all recordings of a camera on a rig.

    Parameters
    ----------
    parameters
        Every number that the recordings share, with units and covariance: ``delay`` (to the reading of row 0, or the middle of
        the integration window), the camera's ``integration_time``, ``time_constant``, ``row_delay``, the opening's
        ``opening_angle``, ``lean_low``, ``lean_high`` as far as it has them, and ``edge_angle_0`` .. ``edge_angle_3``, angles by
        which the edges come earlier than rig.toml says.
    start
        Where the search began, by name.
    prior
        What was known of some of them beforehand: values and covariance; the edges' angles from rig.toml, images and residuals.
    u_edge_rad
        Standard uncertainty of one cutout edge, as stated or from the scatter of the four.
    reduced_chi_square
        Deviance over its degrees of freedom; 1 where residuals are as large as each recording alone leaves them.
    birge
        Square root of the deviance over its degrees of freedom, of the recordings' delays against the common one.
    whiteness
        Shape (n_fit,); Ljung-Box p-value of each recording's residuals along the wheel angle.
    n_steps
        Evaluations of the likelihood from the start to the minimum.
    decrement
        What a further Newton step would move, in standard uncertainties.
    """

    __repr__ = short_repr

    parameters: Estimate
    start: Mapping[str, float]
    prior: Estimate
    u_edge_rad: float
    reduced_chi_square: float
    birge: float
    whiteness: Array
    n_steps: int
    decrement: float


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Result:
    """Timing of a camera by one method.

    Parameters
    ----------
    method
        Which gave it.
    estimate
        Values with covariance; a parameter that is not determined is left out and stands in ``bounds``.
    relative_delays
        One per recording, in their order.
    budget
        Contributions to the parameters.
    edge_delay_s, u_edge_delay_s
        Shape (4,); mean delay by wheel edge 0..3, and standard uncertainties from noise alone; nan where the method does not
        tell edges apart.
    bounds
        Of parameters that are not determined.
    findings
        Doubts about the result.
    effective
        Time constants of the blackbody temperatures one by one; None where these are not known, or there is no lag.
    not_in_uncertainty
        In words, what the uncertainties do not include because it was not stated.
    falling_rising
        ``falling_rising_time`` and ``falling_rising_angle``: delay by falling slopes less delay by rising ones, at the angular
        frequency omega, is the time plus the angle over omega; None where one wheel speed does not tell them apart.
    midpoint_leads
        Whether the middle of the integration window is to be reported before its start, whose distance is not well known.
    delay_scatter
        From frame to frame; None where the method does not tell it.
    """

    __repr__ = short_repr

    method: Method
    estimate: Estimate
    relative_delays: tuple[RelativeDelay, ...]
    budget: tuple[Contribution, ...]
    edge_delay_s: Array
    u_edge_delay_s: Array
    bounds: tuple[Bound, ...] = ()
    findings: tuple[Finding, ...] = ()
    effective: EffectiveTimeConstants | None = None
    not_in_uncertainty: tuple[str, ...] = ()
    midpoint_leads: bool = False
    falling_rising: Estimate | None = None
    delay_scatter: DelayScatter | None = None
