"""The camera that a person describes, or that an earlier result tells of."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import final, get_args

from irtiming.archive.result_camera import read_camera
from irtiming.errors import PlanError, listed
from irtiming.records.camera_description import Camera, Microbolometer, PhotonCamera
from irtiming.records.recording import USUAL_READOUT, CameraType, ReadoutMode
from irtiming.records.words import require_word

_OWN = {
    "photon": ("integration_time_s", "known_integration_time"),
    "microbolometer": ("time_constant_s",),
    "rolling": ("row_delay_s",),
}
_USUAL: dict[tuple[CameraType, ReadoutMode], Camera] = {
    ("photon", "snapshot"): PhotonCamera(),
    ("photon", "rolling"): PhotonCamera(row_delay_s=20e-6),
    ("microbolometer", "rolling"): Microbolometer(),
    ("microbolometer", "snapshot"): Microbolometer(row_delay_s=None),
}
_USUAL_CONTRAST_K = {"photon": 9.0, "microbolometer": 8.0}


@final
@dataclass(frozen=True, kw_only=True)
class Described:
    """What a person says of the camera; None where nothing. ``noise`` and ``contrast`` are both in K or both in DN."""

    camera: CameraType | None = None
    readout: ReadoutMode | None = None
    noise: float | None = None
    contrast: float | None = None
    opening_pixels: float | None = None
    integration_time_s: float | None = None
    known_integration_time: bool = False
    time_constant_s: float | None = None
    row_delay_s: float | None = None
    like: Path | None = None

    def __post_init__(self) -> None:
        require_word("camera", self.camera, known=get_args(CameraType), error=PlanError, may_be_none=True)
        require_word("readout", self.readout, known=get_args(ReadoutMode), error=PlanError, may_be_none=True)
        if self.contrast is not None and not self.contrast > 0:
            raise PlanError(
                f"{{contrast}} is {self.contrast:g}, but must be greater than 0: blackbody minus wheel without sign",
                "contrast",
            )


def camera(described: Described) -> Camera:
    """The camera that is described; the paper's where nothing is said.

    Raises
    ------
    PlanError
        If something is said that this kind of camera does not have, or a number is impossible.
    ArchiveError
        If the result to take it from cannot be used.
    """
    found = _start(described)
    _refuse_foreign(described, found)
    names = ("opening_pixels", "integration_time_s", "time_constant_s", "row_delay_s")
    said = {name: getattr(described, name) for name in names}
    said["noise_to_contrast"] = _noise_to_contrast(described, found)
    return replace(found, **{name: value for name, value in said.items() if value is not None})


def _refuse_foreign(described: Described, found: Camera) -> None:
    usual = Described()
    others = [names for other, names in _OWN.items() if other not in (found.camera_type, found.readout_mode)]
    wrong = [name for names in others for name in names if getattr(described, name) != getattr(usual, name)]
    if wrong:
        kind = found.readout_mode if wrong == ["row_delay_s"] else found.camera_type
        raise PlanError(f"{listed(wrong)} with a {kind} camera, which has no such thing; leave it out", *wrong)


def _noise_to_contrast(described: Described, found: Camera) -> float | None:
    if described.noise is None and described.contrast is None:
        return None
    usual = _USUAL_CONTRAST_K[found.camera_type]
    noise = found.noise_to_contrast * usual if described.noise is None else described.noise
    return noise / (usual if described.contrast is None else described.contrast)


def _start(described: Described) -> Camera:
    """The paper's camera of the kind, or the one of an earlier result."""
    if described.like is None:
        kind = described.camera or "photon"
        return _USUAL[kind, described.readout or USUAL_READOUT[kind]]
    found = read_camera(described.like)
    for name, said, is_ in (
        ("camera", described.camera, found.camera_type),
        ("readout", described.readout, found.readout_mode),
    ):
        if said not in (None, is_):
            raise PlanError(f"{described.like} is of a {is_} camera, {{{name}}} says {said}; leave it out", name)
    return found
