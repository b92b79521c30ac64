"""How what a camera gives out goes with the signal of its detector, as a record."""

from dataclasses import dataclass
from typing import final

from irtiming.errors import PlanError

_LEAST, _MOST = 0.5, 2.0


@final
@dataclass(frozen=True, kw_only=True)
class ResponseCurve:
    """A power law between two levels: a signal of low + (high - low) x gives low + (high - low) x^``exponent``.

    An exponent of 1 is a straight line. Of others, what is below ``low_dn`` is as low.
    """

    exponent: float = 1.0
    low_dn: float = 0.0
    high_dn: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what is no camera's."""
        if not (_LEAST <= self.exponent <= _MOST and self.low_dn < self.high_dn):
            raise PlanError(
                f"a response with the exponent {self.exponent:g} between {self.low_dn:g} and {self.high_dn:g} DN was asked for; "
                f"the exponent must lie between {_LEAST:g} and {_MOST:g}, and the levels must ascend"
            )
