"""The result of an analysis, as Python code and notebooks use it."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from math import inf, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import numpy as np

from irtiming.archive import result_file
from irtiming.archive.result_model import Item, Measured, Parameter, Result
from irtiming.errors import EstimationError
from irtiming.interface.pixel_timing import PixelTiming
from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array, read_only
from irtiming.records.choices import Language
from irtiming.records.finding import Finding
from irtiming.report.quantity import Quantity

if TYPE_CHECKING:
    from irtiming.report.budget_figure import Drawn


@final
class TimingResult(Mapping[str, Quantity]):
    """Timing of one camera: a mapping from the name of each determined parameter to its `Quantity`.

    ``content`` is all that the JSON file has, ``analysis`` everything behind it, None where the result comes from a file.
    """

    def __init__(self, content: Result, *, analysis: Analysis | None = None) -> None:
        self.content, self.analysis = content, analysis

    def __getitem__(self, name: str) -> Quantity:
        """One parameter.

        Raises
        ------
        KeyError
            If the recordings do not determine it, or there is none of that name; the message lists those there are.
        """
        try:
            return _quantity(name, self.content.parameters[name])
        except KeyError:
            bound = "; it has bounds only" if name in self.content.bounds else ""
            raise KeyError(f"'{name}' is not among {', '.join(self)}{bound}") from None

    def __iter__(self) -> Iterator[str]:
        """Names of the parameters, the first the most asked for."""
        return iter(self.content.parameters)

    def __len__(self) -> int:
        """Number of parameters."""
        return len(self.content.parameters)

    @property
    def headline(self) -> str:
        """The result in one sentence."""
        return self.content.headline

    @property
    def item(self) -> Item:
        """Which camera it is: manufacturer, model, serial number, firmware; None for what no recording says."""
        return self.content.item

    @property
    def is_simulated(self) -> bool:
        """Whether a recording says of itself that no camera made it."""
        return self.content.simulated

    @property
    def correlated_names(self) -> tuple[str, ...]:
        """Names of the parameters in the order of `covariance`."""
        return tuple(self.content.correlation.names)

    @cached_property
    def correlation(self) -> Array:
        """Correlation coefficients, shape (n, n), read-only, in the order of `correlated_names`."""
        matrix = [[nan if one is None else one for one in row] for row in self.content.correlation.matrix]
        return read_only(np.array(matrix, float).reshape(len(matrix), len(matrix)))

    @cached_property
    def covariance(self) -> Array:
        """Covariance, shape (n, n), read-only, in the order of `correlated_names` and the units of the parameters."""
        u = np.array([self[name].u for name in self.correlated_names])
        return read_only(self.correlation * np.outer(u, u))

    @property
    def relative_delays(self) -> tuple[Quantity, ...]:
        """Delay of each recording beyond that of the smallest set delay, by file."""
        return tuple(_quantity(one.file, one) for one in self.content.relative_delays)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Everything that is odd or to be known, with code, severity and cure."""
        return tuple(Finding.read_back(one.model_dump()) for one in self.content.findings)

    @cached_property
    def maps(self) -> PixelTiming:
        """Timing of every pixel.

        Raises
        ------
        IrTimingError
            If no maps were asked for, or the result was read from a file.
        """
        if self.analysis is None or self.analysis.maps is None:
            raise EstimationError("this result has no maps; analyse the recordings with maps=True")
        return PixelTiming(self.analysis.maps, analysis=self.analysis)

    def to_gtc(self) -> dict[str, Any]:
        """Uncertain numbers of the GUM Tree Calculator, correlated as the parameters are.

        Correlated numbers of GTC share one number of degrees of freedom: the smallest of theirs, which is on the safe side.
        """
        from irtiming.report.uncertain_numbers import gtc_numbers

        return gtc_numbers([self[name] for name in self.correlated_names], self.correlation)

    def to_uncertainties(self) -> dict[str, Any]:
        """Numbers of the package ``uncertainties``, correlated as the parameters are.

        Raises
        ------
        IrTimingError
            If the package is not installed.
        """
        from irtiming.report.uncertain_numbers import uncertainties_numbers

        return uncertainties_numbers([self[name] for name in self.correlated_names], self.covariance)

    def to_pandas(self) -> Any:
        """A pandas ``DataFrame`` with one row for each parameter.

        Raises
        ------
        IrTimingError
            If pandas is not installed.
        """
        from irtiming.report.uncertain_numbers import data_frame

        return data_frame(list(self.values()))

    def plot(self, name: str = "", *, axes: "Drawn | None" = None) -> "Drawn":
        """Draw what the standard uncertainty of a parameter consists of.

        Parameters
        ----------
        name
            Of the parameter; the first, if not given.
        axes
            Where to draw; new ones, if not given.

        Raises
        ------
        KeyError
            If there is no parameter of that name.
        """
        from irtiming.report.budget_figure import draw

        shown = self[name or next(iter(self))].name
        parts = {line.source: line.standard_uncertainty.get(shown) or 0.0 for line in self.content.contributions}
        return draw(shown, self[shown], parts=parts, axes=axes)

    def write(self, path: str | Path) -> None:
        """Write the result as JSON, as ``irtiming analyse --json`` does.

        Raises
        ------
        ArchiveError
            If the file cannot be written.
        """
        result_file.write_result(self.content.model_dump(exclude={"format", "version"}), path)

    def write_report(self, path: str | Path, *, language: Language = "en") -> None:
        """Write the report as one HTML page, in English or German ("de").

        Raises
        ------
        IrTimingError
            If the result was read from a file, which does not hold the curves that the report shows, or the page cannot be
            written.
        """
        from irtiming.session.analysis import write

        if self.analysis is None:
            raise EstimationError(
                "a result that was read from a file has no curves for a report; analyse the recordings"
            )
        write(self.analysis, report=Path(path), language=language)

    def __repr__(self) -> str:
        """In one line."""
        return f"<TimingResult of a {self.content.camera} camera: {', '.join(f'{name} {self[name]}' for name in self)}>"

    def _repr_html_(self) -> str:
        """A table for notebooks."""
        from irtiming.report.quantity_table import html

        return html(
            list(self.values()),
            heading=self.headline,
            findings=[one for one in self.findings if one.severity != "info"],
        )


def _quantity(name: str, said: Measured) -> Quantity:
    freedom = said.effective_degrees_of_freedom if isinstance(said, Parameter) else None
    return Quantity(
        name=name,
        value=nan if said.value is None else said.value,
        u=nan if said.standard_uncertainty is None else said.standard_uncertainty,
        unit=said.unit,
        event=said.reference_event,
        sign=said.sign,
        degrees_of_freedom=inf if freedom is None else freedom,
    )
