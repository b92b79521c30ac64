"""Maps of every pixel's timing, as Python code and notebooks use them."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from irtiming.records.analysis import Analysis
from irtiming.records.arrays import Array, read_only
from irtiming.records.finding import Finding
from irtiming.records.pixel_maps import PixelMaps

if TYPE_CHECKING:
    from irtiming.report.map_figure import Drawn


@final
class PixelTiming(Mapping[str, Array]):
    """Maps by name, each a read-only array of shape (roi rows, roi columns), nan where there is no pixel of the opening.

    ``delay_s`` with ``u_delay_s``, ``deviation_s`` from the fit, ``contrast_dn`` with ``u_contrast_dn``, ``noise_dn``,
    ``u_shape_s``; of a camera that lags ``time_constant_s`` with ``u_time_constant_s``, and ``correlation`` of the two.
    ``record`` has the rest: means over ``rows`` and ``columns``, masks, patterns of the readout and what all pixels
    have in common.
    """

    def __init__(self, record: PixelMaps, *, analysis: Analysis) -> None:
        self.record, self._analysis = record, analysis
        self._images = {name: read_only(one) for name, one in record.images.items()}

    def __getitem__(self, name: str) -> Array:
        """One map.

        Raises
        ------
        KeyError
            If there is none of that name; the message lists those there are.
        """
        try:
            return self._images[name]
        except KeyError:
            raise KeyError(f"'{name}' is not among {', '.join(self)}") from None

    def __iter__(self) -> Iterator[str]:
        """Names of the maps."""
        return iter(self._images)

    def __len__(self) -> int:
        """Number of maps."""
        return len(self._images)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What the maps say of the readout, and which pixels stray."""
        return self.record.findings

    def to_pandas(self) -> Any:
        """A pandas ``DataFrame`` with one row for each pixel: ``row_px``, ``column_px``, and every map.

        Raises
        ------
        IrTimingError
            If pandas is not installed.
        """
        from irtiming.report.uncertain_numbers import pixel_frame

        return pixel_frame(self._images, self.record.roi)

    def plot(self, name: str = "deviation_s", *, axes: "Drawn | None" = None) -> "Drawn":
        """Draw one map.

        Parameters
        ----------
        name
            Of the map.
        axes
            Where to draw; new ones, if not given.

        Raises
        ------
        KeyError
            If there is no map of that name.
        """
        from irtiming.report.map_figure import draw

        return draw(name, self[name], roi=self.record.roi, axes=axes)

    def write(self, path: str | Path) -> None:
        """Write the maps as HDF5, and a picture of them beside it, as ``irtiming analyse --maps`` does.

        Raises
        ------
        ArchiveError
            If a file cannot be written.
        """
        from irtiming.session.analysis import write_maps_of

        write_maps_of(self._analysis, Path(path))

    def __repr__(self) -> str:
        """In one line."""
        row0, row1, column0, column1 = self.record.roi
        return (
            f"<PixelTiming of {self.record.n_pixels} pixels in rows {row0} to {row1 - 1}, columns {column0} to {column1 - 1}: "
            f"{', '.join(self)}>"
        )
