"""Facts about frames as JSON: beside a raw file, beside an ``.npy``, and in the description of a TIFF that irtiming wrote."""

import json
import math
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from irtiming.archive.frames.bounds import MOST_FRAMES, MOST_TEXT_BYTES
from irtiming.archive.frames.source import FrameFacts, TimeScale
from irtiming.archive.typed_file import Number, Part, fitted
from irtiming.archive.typed_misfit import FileKind
from irtiming.errors import ArchiveError
from irtiming.records.arrays import read_only
from irtiming.records.camera_frame import CameraIdentity

_KIND = FileKind(
    name="description of frames",
    cure="see docs/reference/frame-files.md",
)
_Times = Annotated[list[Number], Field(max_length=MOST_FRAMES)]
_Positive = Annotated[float, Field(gt=0, le=1e6)]


class Camera(Part):
    """What a camera says of itself."""

    vendor: str = ""
    model: str = ""
    serial_number: str = ""
    firmware: str = ""
    address: str = ""


class Told(Part):
    """What is known of frames beside their values; every key may be left out."""

    unit: Literal["DN", "K", ""] = "DN"
    bit_depth: Annotated[int, Field(ge=1, le=64)] | None = None
    camera: Camera | None = None
    start_time: str = ""
    integration_time_s: _Positive | None = None
    frame_period_s: _Positive | None = None
    times_s: _Times | None = None
    time_scale: TimeScale = ""
    time_step_s: _Positive | None = None
    trigger_times_s: _Times | None = None
    frame_id: Annotated[list[int], Field(max_length=MOST_FRAMES)] | None = None
    more: dict[str, str | float] = Field(default_factory=dict)

    def facts(self, **stack: Any) -> FrameFacts:
        """Facts of frames with ``format``, ``frames``, ``rows``, ``columns`` and ``dtype``.

        Raises
        ------
        ArchiveError
            If a list has not one entry for each frame.
        """
        found = {name: getattr(self, name) for name in Told.model_fields if name not in ("camera", *_LISTS)}
        for name in _LISTS:
            listed = getattr(self, name)
            if listed is None:
                continue
            if len(listed) != stack["frames"]:
                raise ArchiveError(
                    f"{name} has {len(listed)} entries for {stack['frames']} frames; give one for each frame"
                )
            found[name] = read_only(np.asarray(listed, np.int64 if name == "frame_id" else np.float64))
        identity = None if self.camera is None else CameraIdentity(**self.camera.model_dump())
        return FrameFacts(camera=identity, **found, **stack)


_LISTS = ("times_s", "trigger_times_s", "frame_id")


def told_in(text: str | bytes, model: type[Told], *, path: Path) -> Any:
    """Facts in a text of JSON.

    Raises
    ------
    ArchiveError
        If it is no JSON, or does not fit the model.
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ArchiveError(f"is not valid JSON ({error!s:.80}); {_KIND.cure}", where=str(path)) from error
    if not isinstance(content, dict):
        raise ArchiveError(f"holds a {type(content).__name__}, must be a {_KIND.name}; {_KIND.cure}", where=str(path))
    return fitted(content, model, path=path, kind=_KIND)


def told_beside(path: Path, model: type[Told]) -> Any:
    """Facts in a JSON file.

    Raises
    ------
    ArchiveError
        If it cannot be read, is too large, or does not fit the model.
    """
    with path.open("rb") as file:
        text = file.read(MOST_TEXT_BYTES + 1)
    if len(text) > MOST_TEXT_BYTES:
        raise ArchiveError(f"has more than {MOST_TEXT_BYTES} bytes, which no {_KIND.name} has", where=str(path))
    return told_in(text, model, path=path)


def as_told(facts: FrameFacts) -> dict[str, Any]:
    """Facts as `Told` takes them, for JSON; what is not known is left out."""
    found: dict[str, Any] = {}
    for name in Told.model_fields:
        value = getattr(facts, name)
        if isinstance(value, np.ndarray):
            found[name] = value.tolist()
        elif name == "camera" and value is not None:
            found[name] = {key: text for key, text in vars(value).items() if text}
        elif name == "more":
            found[name] = {key: one for key, one in value.items() if isinstance(one, str) or math.isfinite(one)}
        elif value is not None:
            found[name] = value
    return {name: value for name, value in found.items() if not isinstance(value, str | dict) or value}
