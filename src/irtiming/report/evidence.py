"""What the report reads of an analysis: a view, so that the report knows nothing of how the analysis was made."""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from irtiming.records.choices import Choices
from irtiming.records.estimate import DelayResult, EdgeDelayFit, PublishedFit
from irtiming.records.joint_fit import JointFit
from irtiming.records.lag_estimate import PublishedLagFit
from irtiming.records.prediction import Prediction
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.rolling_result import RollingResult
from irtiming.records.row_timing import RowLikelihood, RowTimingFit, SectorFit, TimeConstantScan
from irtiming.records.two_constants import TwoConstantsResult
from irtiming.records.wheel_calibration import WheelCalibration
from irtiming.records.wheel_geometry import GateAngles, WheelModel
from irtiming.records.wheel_track import WheelTrack


class Geometry(Protocol):
    """Wheel, gates and opening as the fits used them."""

    @property
    def model(self) -> WheelModel:
        """Where the slopes would be without any delay."""
        ...

    @property
    def gates(self) -> GateAngles:
        """Angles of the two light gates."""
        ...

    @property
    def edges_from(self) -> str:
        """Where the cutout edge angles come from."""
        ...

    @property
    def camera_roll_rad(self) -> float | None:
        """Angle rho by which the camera is turned against the rig, from the mask's image."""
        ...


class Run(Protocol):
    """What any recording tells of the wheel."""

    @property
    def track(self) -> WheelTrack:
        """With learned slots."""
        ...

    @property
    def rotation_speed_hz(self) -> float:
        """Nominal."""
        ...

    @property
    def trigger_delay_time_set_s(self) -> float:
        """Set in the trigger generator."""
        ...


class WheelEvidence(Protocol):
    """What is known of the wheel, whatever the camera."""

    @property
    def rig(self) -> Rig:
        """As measured by its owner."""
        ...

    @property
    def recordings(self) -> Sequence[Run]:
        """One per run."""
        ...

    @property
    def wheel(self) -> WheelCalibration | None:
        """Slots that all recordings tell together; None where they were taken as equal."""
        ...

    @property
    def geometry(self) -> Geometry:
        """With learned slots."""
        ...


class Evidence(Protocol):
    """Of a snapshot photon camera: result, counterpart, and what led to them.

    ``recordings``, ``edge_fits`` and the relative delays of both results stand in the same order; ``published_fits`` has
    one entry per nominal delay and wheel speed, in that order too.
    """

    @property
    def rig(self) -> Rig:
        """As measured by its owner."""
        ...

    @property
    def choices(self) -> Choices:
        """What a person decided; the method among it."""
        ...

    @property
    def recordings(self) -> Sequence[ReducedRecording]:
        """One per run."""
        ...

    @property
    def wheel(self) -> WheelCalibration | None:
        """Slots that all recordings tell together; None where they were taken as equal."""
        ...

    @property
    def geometry(self) -> Geometry:
        """With learned slots; of the pixel sums."""
        ...

    @property
    def equal_geometry(self) -> Geometry:
        """With equal slots; of the published method."""
        ...

    @property
    def edge_fits(self) -> Sequence[EdgeDelayFit]:
        """One per recording."""
        ...

    @property
    def published_fits(self) -> Sequence[PublishedFit]:
        """One per nominal delay and wheel speed."""
        ...

    @property
    def joint(self) -> JointFit:
        """The fit behind ``best``; whiteness, information and pull in the order of ``recordings``."""
        ...

    @property
    def best(self) -> DelayResult:
        """By pixel sums."""
        ...

    @property
    def as_published(self) -> DelayResult:
        """By the procedure of Schatz 2023."""
        ...

    @property
    def prediction(self) -> Prediction | None:
        """What the recordings should tell; None where nobody predicted it."""
        ...

    @property
    def result(self) -> DelayResult:
        """By the chosen method."""
        ...

    @property
    def warnings(self) -> tuple[str, ...]:
        """All, each once."""
        ...


@runtime_checkable
class RollingEvidence(Protocol):
    """The same of a rolling microbolometer camera.

    ``recordings``, ``row_fits`` and the relative delays of both results stand in the same order; ``published_fits`` has one
    entry per nominal delay and wheel speed, in that order too. ``scan`` belongs to the first recording.
    """

    @property
    def rig(self) -> Rig:
        """As measured by its owner."""
        ...

    @property
    def choices(self) -> Choices:
        """What a person decided; the method among it."""
        ...

    @property
    def recordings(self) -> Sequence[ReducedRecording]:
        """One per run."""
        ...

    @property
    def wheel(self) -> WheelCalibration | None:
        """Slots that all recordings tell together; None where they were taken as equal."""
        ...

    @property
    def geometry(self) -> Geometry:
        """With learned slots."""
        ...

    @property
    def sector(self) -> SectorFit:
        """The opening in the image."""
        ...

    @property
    def row_fits(self) -> Sequence[RowTimingFit]:
        """One per recording."""
        ...

    @property
    def scan(self) -> TimeConstantScan:
        """How much worse other time constants fit."""
        ...

    @property
    def likelihood(self) -> RowLikelihood:
        """Of all recordings together."""
        ...

    @property
    def published_fits(self) -> Sequence[PublishedLagFit]:
        """One per nominal delay and wheel speed."""
        ...

    @property
    def best(self) -> RollingResult:
        """By row sums."""
        ...

    @property
    def as_published(self) -> RollingResult:
        """By the procedure of Schatz 2023."""
        ...

    @property
    def prediction(self) -> Prediction | None:
        """What the recordings should tell; None where nobody predicted it."""
        ...

    @property
    def two_constants(self) -> TwoConstantsResult | None:
        """Constants of substrate and scene; None where nobody asked for them."""
        ...

    @property
    def result(self) -> RollingResult:
        """By the chosen method."""
        ...

    @property
    def warnings(self) -> tuple[str, ...]:
        """All, each once."""
        ...
