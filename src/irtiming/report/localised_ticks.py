"""Numbers at the axes of figures in the language of the page."""

from typing import Any, final

from matplotlib.ticker import Formatter

from irtiming.report.language import decimal


@final
class Localised(Formatter):
    """Writes what another formatter writes, with the decimal mark of the language."""

    def __init__(self, written_by: Formatter) -> None:
        self._written_by = written_by

    def __call__(self, x: float, pos: int | None = None) -> str:
        """One number at an axis."""
        return decimal(self._written_by(x, pos))

    def format_ticks(self, values: Any) -> list[str]:
        """All numbers at an axis."""
        return [decimal(one) for one in self._written_by.format_ticks(values)]

    def get_offset(self) -> str:
        """What all of them have in common."""
        return decimal(self._written_by.get_offset())

    def set_axis(self, axis: Any) -> None:
        """The axis, which the other one needs too."""
        super().set_axis(axis)
        self._written_by.set_axis(axis)

    def set_locs(self, locs: Any) -> None:
        """Where the numbers are, which the other one needs too."""
        self._written_by.set_locs(locs)
