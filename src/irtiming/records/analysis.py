"""Everything that a report needs: the result, and what led to it."""

from dataclasses import dataclass, fields
from typing import TypeAlias, final

from irtiming.records.camera_frame import CameraIdentity
from irtiming.records.choices import Choices
from irtiming.records.diagnosis import Diagnosis
from irtiming.records.estimate import EdgeDelayFit, PublishedFit
from irtiming.records.finding import Finding
from irtiming.records.lag_estimate import PublishedLagFit
from irtiming.records.pixel_maps import PixelMaps
from irtiming.records.prediction import Prediction
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.records.reduced import ReducedRecording
from irtiming.records.result import JointFit, Profile, Result
from irtiming.records.rig import Rig
from irtiming.records.row_timing import RowTimingFit, SectorFit
from irtiming.records.short_repr import short_repr
from irtiming.records.two_constants import TwoConstantsResult
from irtiming.records.wheel_calibration import WheelCalibration
from irtiming.records.wheel_geometry import WheelGeometry

Fits: TypeAlias = tuple[EdgeDelayFit | RowTimingFit, ...]
"""Of pixel sums or of row sums, one per recording."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Published:
    """By the procedure of Schatz 2023.

    ``result`` is empty and there are no ``fits``, one per nominal delay and wheel speed, where it could not be run; ``geometry``
    is that with equal slots, which the fits used.
    """

    __repr__ = short_repr

    result: Result
    fits: tuple[PublishedFit, ...] | tuple[PublishedLagFit, ...]
    geometry: WheelGeometry


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Analysis:
    """Of one camera on one rig.

    Parameters
    ----------
    camera_type, readout_mode
        Kind of camera: its response and its readout.
    rig, choices
        What a person measured and decided.
    recordings, fits, relative delays
        In the same order.
    geometry
        Wheel, gates and opening with learned slots.
    sectors
        The opening in the image as each recording shows it; recordings before one blackbody share one.
    joint
        The fit behind ``best``.
    best
        The result by the project's method.
    wheel
        Slots that all recordings tell together.
    published, profiles, prediction, two_constants, diagnosis, maps
        Made on request; None or empty where none were asked for, or none could be made.
    """

    __repr__ = short_repr

    camera_type: CameraType
    readout_mode: ReadoutMode
    rig: Rig
    choices: Choices
    recordings: tuple[ReducedRecording, ...]
    geometry: WheelGeometry
    sectors: tuple[SectorFit, ...]
    fits: Fits
    joint: JointFit
    best: Result
    wheel: WheelCalibration | None = None
    published: Published | None = None
    profiles: tuple[Profile, ...] = ()
    prediction: Prediction | None = None
    two_constants: TwoConstantsResult | None = None
    diagnosis: Diagnosis | None = None
    maps: PixelMaps | None = None

    @property
    def result(self) -> Result:
        """By the method that was chosen."""
        return self.published.result if self.choices.method == "published" and self.published else self.best

    @property
    def item(self) -> CameraIdentity:
        """Which camera it is, each word from the first recording that has it; empty where none has."""
        said = [one.camera for one in self.recordings if one.camera is not None]
        words = {
            one.name: next((word for camera in said if (word := getattr(camera, one.name))), "")
            for one in fields(CameraIdentity)
        }
        return CameraIdentity(**words)

    @property
    def is_simulated(self) -> bool:
        """Whether a recording says of itself that no camera made it."""
        return any(one.is_simulated for one in self.recordings)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All, each once, in order: of the recordings, the wheel, the result, and of what was made on request."""
        without = self.published.result.findings if self.published and not self.published.fits else ()
        two = self.two_constants.findings if self.two_constants else ()
        found = [one for recording in self.recordings for one in recording.findings]
        wheel = [
            Finding(code="slots-doubtful", severity="warning", what=text)
            for text in (self.wheel.warnings if self.wheel else ())
        ]
        cause = self.diagnosis.findings if self.diagnosis else ()
        mapped = self.maps.findings if self.maps else ()
        return tuple(dict.fromkeys([*found, *wheel, *self.result.findings, *without, *two, *cause, *mapped]))
