"""What the estimation of a rolling microbolometer camera hands to the report."""

from dataclasses import dataclass
from typing import Literal, final

from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate, RelativeDelay

RollingMethod = Literal["row-sum", "published"]
"""The exact model of all row sums, and the procedure of Schatz 2023 step by step."""


@final
@dataclass(frozen=True, kw_only=True)
class RollingContribution:
    """One line of the uncertainty budget: what it is, A or B, and its standard uncertainty in each parameter, s.

    ``degrees_of_freedom`` say how well the uncertainty itself is known.
    """

    source: str
    kind: str
    trigger_delay_s: float
    time_constant_s: float
    row_delay_s: float
    degrees_of_freedom: float = float("inf")


@final
@dataclass(frozen=True, kw_only=True)
class Bound:
    """What is known of a parameter that the data do not determine: between ``lower_s`` and ``upper_s``, None if open."""

    name: str
    lower_s: float | None
    upper_s: float | None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class EffectiveTimeConstants:
    """Time constant of eq. 2 as recordings at each blackbody temperature give it; they differ where the range is wide.

    Shapes (k,): ``blackbody_temperature_k``, ascending; ``time_constant_s``; ``contrast_dn``, mean change of the row sums from
    covered to open, negative for a blackbody colder than the wheel. ``covariance_s2`` (k, k).
    """

    blackbody_temperature_k: Array
    time_constant_s: Array
    covariance_s2: Array
    contrast_dn: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RollingResult:
    """Trigger delay at row 0, time constant and row delay, with what led to them.

    Parameters
    ----------
    method
        Which gave it.
    estimate
        Values with covariance; a parameter that is not determined is left out and stands in ``bounds``.
    relative_delays
        One per recording.
    budget
        Contributions to all three.
    edge_delay_s, u_edge_delay_s
        Shape (4,); mean delay of row 0 by wheel edge 0..3, and standard uncertainties from noise alone; nan where the
        method does not tell edges apart.
    bounds
        Of parameters that are not determined.
    warnings
        Doubts about the result.
    effective
        Time constants of the blackbody temperatures one by one; None where these are not known.
    """

    method: RollingMethod
    estimate: Estimate
    relative_delays: tuple[RelativeDelay, ...]
    budget: tuple[RollingContribution, ...]
    edge_delay_s: Array
    u_edge_delay_s: Array
    bounds: tuple[Bound, ...] = ()
    warnings: tuple[str, ...] = ()
    effective: EffectiveTimeConstants | None = None
