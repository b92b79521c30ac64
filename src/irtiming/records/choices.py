"""What a person may decide in an analysis instead of the automatic choice."""

from dataclasses import dataclass
from typing import Literal, final, get_args

from irtiming.errors import EstimationError, UnitError, listed
from irtiming.records.recording import Recording
from irtiming.records.words import require_word

Method = Literal["pixel-sum", "row-sum", "published"]
"""As results name them: the project's best by what it sums, and the procedure of Schatz 2023 step by step.

The first, which need not be named, is the best for every kind of camera; row sums are those of cameras that lag or roll.
"""

_WIDEST_BORDER_PX = 64

_PIXEL_SUMS_ONLY = ("threshold_dn", "plateau_margin", "slope_limits")
"""Choices that mean something for the pixel sums of a snapshot photon camera only."""

Language = Literal["en", "de"]
"""In which reports and certificates are written."""

ReferenceEdge = Literal["automatic", "first", "second"]
"""Which of the two alternating application edges is edge 0: the one before the longer interval, or as chosen."""

Processor = Literal["automatic", "cpu", "gpu"]
"""What sums the frames; automatic is a GPU where there is one, else the processor."""


@final
@dataclass(frozen=True, kw_only=True)
class Choices:
    """Every choice of the analysis that a person may take over; None or the default means automatic.

    ``roi`` is (first row, end row, first column, end column), ends excluded. ``threshold_dn`` is a corrected pixel
    value; ``threshold_level`` the place between the histogram peaks where it is put otherwise (0 covered, 1 open).
    ``border_px`` is by how much the summed region exceeds the opening; ``plateau_margin`` the share of a plateau's width that
    is kept away from each of its corners. ``slope_limits`` are the opening fractions between which lines are fitted.
    ``reference_edge`` names the application edge that is the angle zero. ``substrate_temperature_k`` of a microbolometer
    detector and ``wheel_temperature_k`` are what its two time constants are separated with. ``processor`` is what sums the
    frames.
    """

    method: Method = "pixel-sum"
    roi: tuple[int, int, int, int] | None = None
    threshold_dn: float | None = None
    threshold_level: float = 0.5
    border_px: int | None = None
    plateau_margin: float = 0.15
    slope_limits: tuple[float, float] = (0.05, 0.95)
    reference_edge: ReferenceEdge = "automatic"
    substrate_temperature_k: float | None = None
    wheel_temperature_k: float | None = None
    processor: Processor = "automatic"

    def __post_init__(self) -> None:
        """Refuse what cannot be, whatever the recording."""
        require_word("method", self.method, known=get_args(Method), error=UnitError)
        require_word("reference_edge", self.reference_edge, known=get_args(ReferenceEdge), error=UnitError)
        require_word("processor", self.processor, known=get_args(Processor), error=UnitError)
        for name, low, high in (("threshold_level", 0.05, 0.95), ("plateau_margin", 0.0, 0.45)):
            if not low <= getattr(self, name) <= high:
                raise UnitError(f"{{{name}}} is {getattr(self, name)}, must lie between {low} and {high}", name)
        if not (
            self.border_px is None or (isinstance(self.border_px, int) and 0 <= self.border_px <= _WIDEST_BORDER_PX)
        ):
            raise UnitError(
                f"{{border_px}} is {self.border_px}, must be a whole number of pixels from 0 to {_WIDEST_BORDER_PX}; leave it "
                "out to have it chosen",
                "border_px",
            )
        low, high = self.slope_limits
        if not 0 < low < high < 1:
            raise UnitError(
                f"{{slope_limits}} is {low:g},{high:g}, must be two fractions with 0 < LOW < HIGH < 1", "slope_limits"
            )
        if self.roi is not None and not (0 <= self.roi[0] < self.roi[1] and 0 <= self.roi[2] < self.roi[3]):
            numbers = ",".join(map(str, self.roi))
            raise UnitError(f"{{roi}} is {numbers}, must be R0,R1,C0,C1 with 0 <= R0 < R1 and 0 <= C0 < C1", "roi")
        if self.wheel_temperature_k is not None and self.substrate_temperature_k is None:
            raise UnitError(
                "{wheel_temperature_k} is of use with {substrate_temperature_k} only; give that too, or leave it out",
                "wheel_temperature_k",
                "substrate_temperature_k",
            )

    def check_for(self, recording: Recording) -> None:
        """Refuse what means nothing for the kind of camera.

        Parameters
        ----------
        recording
            To be analysed with these choices.

        Raises
        ------
        EstimationError
            If one was made.
        """
        usual, kind = Choices(), recording.camera_type
        given = [name for name in _PIXEL_SUMS_ONLY if getattr(self, name) != getattr(usual, name)]
        if given and (recording.camera_type, recording.readout_mode) != ("photon", "snapshot"):
            raise EstimationError(
                f"{listed(given)} with {recording.name}, the recording of a {kind} camera, which is analysed without threshold "
                f"values, plateaus and straight slopes; leave {'them' if len(given) > 1 else 'it'} out",
                *given,
            )
        if self.method == "row-sum" and (recording.camera_type, recording.readout_mode) == ("photon", "snapshot"):
            raise EstimationError(
                f"{{method}} row-sum with {recording.name}, the recording of a snapshot photon camera, whose rows are all read "
                "at once: its pixels are summed; leave it out",
                "method",
            )
        if self.substrate_temperature_k is not None and recording.camera_type != "microbolometer":
            raise EstimationError(
                f"{{substrate_temperature_k}} with {recording.name}, the recording of a {kind} camera, which has no time "
                "constants; leave it out",
                "substrate_temperature_k",
            )
