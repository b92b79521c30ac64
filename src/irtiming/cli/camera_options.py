"""The camera as described on the command line, or as an earlier result tells it."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, final

from irtiming.errors import ArchiveError, PlanError
from irtiming.records.camera_description import Camera, Microbolometer, PhotonCamera
from irtiming.units import seconds

CameraKind = Literal["photon", "microbolometer"]

_USUAL_CONTRAST_K = {"photon": 9.0, "microbolometer": 8.0}


@final
@dataclass(frozen=True, kw_only=True)
class Described:
    """What the options say of camera and rig; None where they say nothing."""

    camera: CameraKind | None = None
    noise: float | None = None
    contrast: float | None = None
    opening_pixels: float | None = None
    integration_time: str | None = None
    known_integration_time: bool = False
    time_constant: str | None = None
    like: Path | None = None
    rig: Path | None = None


def camera(described: Described) -> Camera:
    """The camera that the options describe; the paper's where they are silent.

    Raises
    ------
    PlanError
        If an option does not belong to the kind of camera, or a number is impossible.
    ArchiveError
        If the result to take it from cannot be used.
    """
    found = _start(described)
    kind = "photon" if isinstance(found, PhotonCamera) else "microbolometer"
    foreign = {
        "--integration-time": kind != "photon" and described.integration_time is not None,
        "--known-integration-time": kind != "photon" and described.known_integration_time,
        "--time-constant": kind == "photon" and described.time_constant is not None,
    }
    wrong = [name for name, is_foreign in foreign.items() if is_foreign]
    if wrong:
        raise PlanError(f"{', '.join(wrong)} with a {kind} camera, which has no such thing; leave it out")
    if described.opening_pixels is not None:
        found = replace(found, opening_pixels=described.opening_pixels)
    if described.noise is not None or described.contrast is not None:
        found = replace(found, noise_to_contrast=_noise_to_contrast(described, found, kind))
    if isinstance(found, PhotonCamera) and described.integration_time is not None:
        found = replace(found, integration_time_s=seconds(described.integration_time))
    if isinstance(found, Microbolometer) and described.time_constant is not None:
        found = replace(found, time_constant_s=seconds(described.time_constant))
    return found


def _noise_to_contrast(described: Described, found: Camera, kind: str) -> float:
    contrast = _USUAL_CONTRAST_K[kind] if described.contrast is None else described.contrast
    if not contrast > 0:
        raise PlanError(f"--contrast is {contrast:g}, but must be greater than 0: blackbody minus wheel without sign")
    if described.noise is None:
        return found.noise_to_contrast * _USUAL_CONTRAST_K[kind] / contrast
    return described.noise / contrast


def _start(described: Described) -> Camera:
    """The paper's camera of the kind, or the one of an earlier result."""
    if described.like is None:
        return Microbolometer() if described.camera == "microbolometer" else PhotonCamera()
    told = _camera_of(described.like)
    if described.camera not in (None, told["camera"]):
        raise PlanError(
            f"{described.like} is of a {told['camera']} camera, --camera says {described.camera}; leave it out"
        )
    shared = {"noise_to_contrast": told["noise_to_contrast"], "opening_pixels": told["opening_pixels"]}
    if told["camera"] == "photon":
        usual = PhotonCamera(**shared)  # its noise holds the jitter of gates and camera already
        return replace(usual, integration_time_s=told.get("integration_time") or usual.integration_time_s,
                       gate_jitter_s=0.0, camera_jitter_s=0.0)  # fmt: skip
    return replace(
        Microbolometer(**shared), time_constant_s=told.get("time_constant") or Microbolometer().time_constant_s
    )


def _camera_of(path: Path) -> dict[str, Any]:
    """What a result says of its camera, checked."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        found = content["prediction"]["camera"]
        numbers = [float(found[name]) for name in ("noise_to_contrast", "opening_pixels")]
        if found["camera"] not in ("photon", "microbolometer") or min(numbers) <= 0:
            raise ValueError("no camera")
    except OSError as error:
        raise ArchiveError(
            f"{path} cannot be read ({error.strerror}); give the result JSON of irtiming analyse"
        ) from error
    except (ValueError, KeyError, TypeError) as error:
        raise ArchiveError(
            f"{path} does not describe a camera; give a result JSON that irtiming analyse wrote, with a prediction in it"
        ) from error
    return dict(found)
