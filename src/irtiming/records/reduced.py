"""What the reduction hands to the estimation: exposed fractions over wheel angle, and every choice made on the way."""

from dataclasses import dataclass
from typing import Literal, final

from irtiming.errors import EstimationError, UnitError, listed
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.recording import Recording
from irtiming.records.wheel_track import WheelTrack

Method = Literal["pixel-sum", "published"]
"""The project's best method, and the procedure of Schatz 2023 step by step."""

_PIXEL_SUMS_ONLY = ("threshold_dn", "plateau_margin", "slope_limits")
"""Choices that mean something for the pixel sums of a snapshot photon camera only."""

ReferenceEdge = Literal["automatic", "first", "second"]
"""Which of the two alternating application edges is edge 0: the one before the longer interval, or as told."""


@final
@dataclass(frozen=True, kw_only=True)
class Choices:
    """Every choice of the analysis that a person may take over; None or the default means automatic.

    ``roi`` is (first row, end row, first column, end column), ends excluded. ``threshold_dn`` is a corrected pixel
    value; ``threshold_level`` the place between the histogram peaks where it is put otherwise (0 covered, 1 open).
    ``border_px`` is by how much the summed region exceeds the opening; ``plateau_margin`` the share of a plateau's width that
    is kept away from each of its corners. ``slope_limits`` are the opening fractions between which lines are fitted.
    ``reference_edge`` names the application edge that is the angle zero. ``substrate_temperature_k`` of a microbolometer
    detector and ``wheel_temperature_k`` are what its two time constants are separated with.
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

    def __post_init__(self) -> None:
        """Refuse what cannot be, whatever the recording."""
        for name, low, high in (("threshold_level", 0.05, 0.95), ("plateau_margin", 0.0, 0.45)):
            if not low <= getattr(self, name) <= high:
                raise UnitError(f"{{{name}}} is {getattr(self, name)}, must lie between {low} and {high}", name)
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
        if self.substrate_temperature_k is not None and recording.camera_type != "microbolometer":
            raise EstimationError(
                f"{{substrate_temperature_k}} with {recording.name}, the recording of a {kind} camera, which has no time "
                "constants; leave it out",
                "substrate_temperature_k",
            )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Opening:
    """The mask opening as the camera sees it, found in the frames.

    Parameters
    ----------
    roi
        First row, end row, first column, end column, ends excluded.
    open_frame_dn, covered_frame_dn
        Mean corrected frames, shape (row, column), DN.
    mask
        Pixels at more than half of the contrast, shape (row, column).
    weight
        Weight of each pixel of the region of interest in the pixel sum: 1 on the opening with its whole blurred border,
        0 elsewhere, more beside a dead pixel that a neighbour stands in for; shape (roi rows, roi columns).
    border_px
        By how much the summed region exceeds ``mask`` on all sides, px.
    threshold_dn, peaks_dn
        Corrected threshold and the histogram peaks (covered side, open side), DN.
    histogram_dn, histogram_count
        Bin edges (n + 1,) and pixels per bin (n,) of the region of interest in open frames.
    """

    roi: tuple[int, int, int, int]
    open_frame_dn: Array
    covered_frame_dn: Array
    mask: Mask
    weight: Array
    border_px: int
    threshold_dn: float
    peaks_dn: tuple[float, float]
    histogram_dn: Array
    histogram_count: Ticks
    n_bad_pixels: int
    warnings: tuple[str, ...] = ()


@final
@dataclass(frozen=True, kw_only=True)
class AxleView:
    """Wheel centre and mask as seen in the image.

    ``row_px``, ``column_px`` locate the axle, found from when each pixel is covered. ``bisector_rad`` is the direction of
    the bisector of the mask's two radial edges, ``mean_angle_rad`` the mean polar angle, about the axle, of the light
    that comes through: they differ when the mask's own centre lies beside the axle. Polar angles in the image.
    ``edge_miss_px`` is by how much the mask's radial edges, that of the smaller polar angle first, miss the axle: at the radius r
    an edge stands ``edge_miss_px`` / r beyond its direction. None where it was not looked at. ``distortion`` is that of the
    lens (`physics.lens`); angles and ``edge_miss_px`` are those of the undistorted plane.
    """

    row_px: float
    column_px: float
    u_centre_px: float
    bisector_rad: float
    u_bisector_rad: float
    mean_angle_rad: float
    edge_miss_px: tuple[float, float] | None = None
    u_edge_miss_px: float = 0.0
    distortion: float = 0.0
    u_distortion: float = 0.0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ReducedRecording:
    """One recording as numbers per frame.

    Parameters
    ----------
    trigger_ticks
        Shape (n,); nominal trigger of each kept frame, ticks.
    pixel_sum, pixel_count
        Shape (n,); weighted sum over the opening (DN) and pixels on the open side of the threshold.
    samples_per_turn
        Nominal wheel angles per turn, T / gcd(T, C).
    track, equal_track
        Wheel angles with learned and with equal slots.
    integration_time_s
        None where the recording does not tell it.
    """

    name: str
    source: str
    sha256: str
    n_frames: int
    trigger_ticks: Ticks
    pixel_sum: Array
    pixel_count: Array
    samples_per_turn: int
    track: WheelTrack
    equal_track: WheelTrack
    opening: Opening
    axle: AxleView | None
    integration_time_s: float | None
    trigger_delay_time_set_s: float
    rotation_speed_hz: float
    warnings: tuple[str, ...] = ()


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ExposedFraction:
    """Opening fraction over the wheel angle at the trigger, averaged over runs per nominal angle (figure 5).

    Shapes (n,), sorted by angle; the uncertainties are standard uncertainties of the means, None with a single run.
    ``plateaus`` are the angle intervals used for normalisation: (start, end, level 0 or 1).
    """

    trigger_delay_time_set_s: float
    rotation_speed_hz: float
    angular_frequency_rad_per_s: float
    names: tuple[str, ...]
    wheel_angle_rad: Array
    fraction: Array
    u_wheel_angle_rad: Array | None
    u_fraction: Array | None
    plateaus: tuple[tuple[float, float, int], ...]
