"""Statements of conformity by a stated rule (ISO/IEC 17025, 7.8.6; ILAC-G8; JCGM 106)."""

from dataclasses import dataclass
from math import inf, isfinite
from typing import Literal, final

from scipy.special import stdtr

from irtiming.archive.certificate_file import Rule

Outcome = Literal["pass", "conditionalPass", "conditionalFail", "fail"]


@final
@dataclass(frozen=True, kw_only=True)
class Conformity:
    """What a rule says of a value between two limits, and the probability that the measurand lies between them."""

    outcome: Outcome
    probability: float


def judged(
    value: float, *, u: float, expanded: float, degrees_of_freedom: float, limits: tuple[float | None, float | None],
    rule: Rule,
) -> Conformity:  # fmt: skip
    """Judge a value, in the unit of the limits.

    Parameters
    ----------
    value, u, expanded
        Measured value, its standard and its expanded uncertainty.
    degrees_of_freedom
        Of ``u``; inf for a normal distribution.
    limits
        Lower and upper, both allowed; None where open.
    rule
        With ``"simple acceptance"`` the value alone decides. With ``"guard band"`` it passes where it is further than U inside
        both limits, fails where it is further than U outside one, and passes or fails on condition between.
    """
    low, high = (-inf if limits[0] is None else limits[0]), (inf if limits[1] is None else limits[1])
    room = min(value - low, high - value)
    guard = expanded if rule == "guard band" else 0.0
    if room >= guard:
        outcome: Outcome = "pass"
    elif room >= 0:
        outcome = "conditionalPass"
    else:
        outcome = "conditionalFail" if guard > 0 and -room <= guard else "fail"
    freedom = degrees_of_freedom if isfinite(degrees_of_freedom) else 1e9
    inside = (
        float(stdtr(freedom, (high - value) / u) - stdtr(freedom, (low - value) / u)) if u > 0 else float(room >= 0)
    )
    return Conformity(outcome=outcome, probability=inside)
