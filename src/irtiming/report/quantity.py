"""One measured number with its uncertainty, as Python code and notebooks use it."""

from dataclasses import dataclass
from math import inf
from typing import final

from irtiming.report import budget
from irtiming.report.rounding import value_text


@final
@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A measurand: SI value, standard uncertainty ``u`` (k = 1) and what both mean.

    ``event`` is what happens at the end of a time, ``sign`` what its sign means, None for a length of time.
    """

    name: str
    value: float
    u: float
    unit: str
    event: str
    sign: str | None = None
    degrees_of_freedom: float = inf

    def coverage_factor(self, probability: float = 0.95) -> float:
        """Factor k with which value ± k u holds the measurand with a probability, by Student's t (GUM, annex G.3).

        Raises
        ------
        UnitError
            If the probability is not between 0 and 1.
        """
        return budget.coverage_factor(self.degrees_of_freedom, probability=probability)

    def expanded(self, probability: float = 0.95) -> float:
        """Expanded uncertainty U = k u, in the unit of the value.

        Raises
        ------
        UnitError
            If the probability is not between 0 and 1.
        """
        return self.coverage_factor(probability) * self.u

    def __str__(self) -> str:
        """Value ± u, rounded, with unit."""
        return value_text(self.value, self.u, unit=self.unit)

    def __repr__(self) -> str:
        """In one line."""
        return f"<{self.name} {self}: {self.event}>"
