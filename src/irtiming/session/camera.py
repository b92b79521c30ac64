"""The camera that a person describes, or that an earlier result tells of."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, final

from irtiming.archive.result_camera import read_camera
from irtiming.errors import PlanError, listed
from irtiming.records.camera_description import Camera, Microbolometer, PhotonCamera

_OWN = {"photon": ("integration_time_s", "known_integration_time"), "microbolometer": ("time_constant_s",)}
_USUAL_CONTRAST_K = {"photon": 9.0, "microbolometer": 8.0}


@final
@dataclass(frozen=True, kw_only=True)
class Described:
    """What a person says of the camera; None where nothing. ``noise`` and ``contrast`` are both in K or both in DN."""

    camera: Literal["photon", "microbolometer"] | None = None
    noise: float | None = None
    contrast: float | None = None
    opening_pixels: float | None = None
    integration_time_s: float | None = None
    known_integration_time: bool = False
    time_constant_s: float | None = None
    like: Path | None = None

    def __post_init__(self) -> None:
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
    _refuse_foreign(described, _kind(found))
    said = {name: getattr(described, name) for name in ("opening_pixels", "integration_time_s", "time_constant_s")}
    said["noise_to_contrast"] = _noise_to_contrast(described, found)
    return replace(found, **{name: value for name, value in said.items() if value is not None})


def _kind(found: Camera) -> Literal["photon", "microbolometer"]:
    return "photon" if isinstance(found, PhotonCamera) else "microbolometer"


def _refuse_foreign(described: Described, kind: str) -> None:
    usual = Described()
    wrong = [
        name
        for other, names in _OWN.items()
        for name in names
        if other != kind and getattr(described, name) != getattr(usual, name)
    ]
    if wrong:
        raise PlanError(f"{listed(wrong)} with a {kind} camera, which has no such thing; leave it out", *wrong)


def _noise_to_contrast(described: Described, found: Camera) -> float | None:
    if described.noise is None and described.contrast is None:
        return None
    usual = _USUAL_CONTRAST_K[_kind(found)]
    noise = found.noise_to_contrast * usual if described.noise is None else described.noise
    return noise / (usual if described.contrast is None else described.contrast)


def _start(described: Described) -> Camera:
    """The paper's camera of the kind, or the one of an earlier result."""
    if described.like is None:
        return Microbolometer() if described.camera == "microbolometer" else PhotonCamera()
    found = read_camera(described.like)
    if described.camera not in (None, _kind(found)):
        raise PlanError(
            f"{described.like} is of a {_kind(found)} camera, {{camera}} says {described.camera}; leave it out",
            "camera",
        )
    return found
