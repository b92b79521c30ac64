"""The camera of an earlier result, as far as a plan for it needs it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from irtiming.archive.typed_file import json_of
from irtiming.errors import ArchiveError
from irtiming.records.camera_description import Camera, Microbolometer, PhotonCamera
from irtiming.records.recording import USUAL_READOUT

_USUAL_ROW_DELAY_S = 20e-6


def read_camera(path: str | Path) -> Camera:
    """The camera in the prediction of a result JSON of ``irtiming analyse``.

    Raises
    ------
    ArchiveError
        If the file cannot be read, or describes no camera.
    """
    content = json_of(Path(path), what="result JSON of irtiming analyse", cure="give that of irtiming analyse")
    try:
        return _camera(content["prediction"]["camera"])
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise ArchiveError(
            f"{path} does not describe a camera; give a result JSON that irtiming analyse wrote, with a prediction in it"
        ) from error


def _camera(found: dict[str, Any]) -> Camera:
    shared = {name: float(found[name]) for name in ("noise_to_contrast", "opening_pixels")}
    if found["camera"] not in ("photon", "microbolometer") or min(shared.values()) <= 0:
        raise ValueError("no camera")
    rolls = found.get("readout_mode", USUAL_READOUT[found["camera"]]) == "rolling"
    if found["camera"] == "microbolometer":
        usual = Microbolometer(**shared)
        row_delay_s = (found.get("row_delay") or usual.row_delay_s) if rolls else None
        return replace(
            usual, time_constant_s=found.get("time_constant") or usual.time_constant_s, row_delay_s=row_delay_s
        )
    cooled = PhotonCamera(**shared, gate_jitter_s=0.0, camera_jitter_s=0.0)  # its noise holds both jitters already
    return replace(
        cooled,
        integration_time_s=found.get("integration_time") or cooled.integration_time_s,
        row_delay_s=(found.get("row_delay") or _USUAL_ROW_DELAY_S) if rolls else None,
    )
