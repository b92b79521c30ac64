"""Frames for a recording that is to be made, from a file of any format, with what it tells of them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from irtiming.archive.captures.own_times import require_same_triggers
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.archive.frames.counts import counts_of
from irtiming.archive.frames.opening import open_frames
from irtiming.archive.frames.source import FrameFacts
from irtiming.archive.npz_file import read_arrays
from irtiming.archive.reader import reduce_reference
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Array, Ticks
from irtiming.records.camera_frame import CameraIdentity
from irtiming.records.recording import CameraType, FrameStack, NonuniformityReference, ReadoutMode

_ARRAYS = ("frames", "low", "high", "frame_number")
_DEFAULT_BITS = 16
_SAME = 1e-3
_FINEST_STEP_S = 1e-6
_CLOCKS = ("camera clock", "UTC")


@final
@dataclass(frozen=True, kw_only=True)
class CameraFacts:
    """What a file of frames does not tell of the camera that made them; None where it may tell, or it is unknown."""

    camera_type: CameraType
    rotation_speed_hz: float
    integration_time_s: float | None = None
    trigger_delay_time_set_s: float = 0.0
    bit_depth: int | None = None
    readout_mode: ReadoutMode | None = None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CameraFrames:
    """Frames and what was stated of them, by a person or by the file, as a `Recording` has it."""

    frames: FrameStack
    frame_number: Ticks
    bit_depth: int
    integration_time_s: float | None = None
    nonuniformity: NonuniformityReference | None = None
    camera: CameraIdentity | None = None
    start_time: str = ""
    frame_id: Ticks | None = None
    frame_timestamp_ticks: Ticks | None = None
    timestamp_frequency_hz: float | None = None


def camera_frames(source: Path, facts: CameraFacts, *, triggers_s: Array | None = None) -> CameraFrames:
    """Frames of a file.

    Parameters
    ----------
    source
        Any format of `open_frames`; ``.npz`` may have ``low``, ``high`` and ``frame_number`` too.
    facts
        What a person says.
    triggers_s
        Times of the triggers, shape (n_trigger,), s; the frames' own times are held against them.

    Raises
    ------
    ArchiveError
        If it cannot be read, or contradicts what the person says, or other triggers made the frames.
    """
    if source.suffix.lower() == ".npz":
        return _of_arrays(source, facts)
    found = open_frames(source)
    own = found.facts
    stamps, numbers = _stamps(own), _numbers(own)
    if triggers_s is not None:
        require_same_triggers(source, own, numbers=numbers, triggers_s=triggers_s)
    return CameraFrames(
        frames=counts_of(found, called=str(source)),
        frame_number=numbers,
        bit_depth=facts.bit_depth or _bits(own),
        integration_time_s=_integration_time(source, facts, own),
        camera=own.camera,
        start_time=own.start_time,
        frame_id=None if own.frame_id is None else own.frame_id - own.frame_id[0],
        frame_timestamp_ticks=stamps,
        timestamp_frequency_hz=None if stamps is None else _frequency_hz(own),
    )


def _numbers(facts: FrameFacts) -> Ticks:
    """Index of each frame's trigger: a gap in what the camera counted is a frame that was lost on the way."""
    if facts.frame_id is not None and np.all(np.diff(facts.frame_id) > 0):
        return np.asarray(facts.frame_id - facts.frame_id[0], np.int64)
    return np.arange(facts.frames, dtype=np.int64)


def _bits(facts: FrameFacts) -> int:
    if facts.bit_depth is not None and facts.bit_depth <= _DEFAULT_BITS:
        return facts.bit_depth
    return 8 if facts.dtype == "uint8" else _DEFAULT_BITS


def _integration_time(source: Path, facts: CameraFacts, told: FrameFacts) -> float | None:
    given_s, told_s = facts.integration_time_s, told.integration_time_s
    if facts.camera_type != "photon" or told_s is None:
        return given_s
    if given_s is not None and abs(given_s - told_s) > _SAME * told_s:
        raise ArchiveError(
            f"says an integration time of {told_s:g} s, {{integration_time_s}} says {given_s:g} s; leave out what is wrong",
            "integration_time_s",
            where=str(source),
        )
    return told_s


def _frequency_hz(facts: FrameFacts) -> float:
    return float(round(1.0 / (facts.time_step_s or _FINEST_STEP_S)))


def _stamps(facts: FrameFacts) -> Ticks | None:
    """The camera's own timestamps, ticks (n_frame,), where they are fine enough to be of use and rise."""
    if facts.times_s is None or facts.time_scale not in _CLOCKS or (facts.time_step_s or 1.0) > _FINEST_STEP_S:
        return None
    ticks = np.rint((facts.times_s - np.floor(facts.times_s[0]) + 1.0) * _frequency_hz(facts)).astype(np.int64)
    return ticks if np.all(np.diff(ticks) > 0) else None


def _of_arrays(source: Path, facts: CameraFacts) -> CameraFrames:
    arrays = read_arrays(source, _ARRAYS)
    if "frames" not in arrays:
        raise ArchiveError(f"{source}: holds no array 'frames'; save it with numpy.savez(file, frames=...)")
    for name in ("frames", "low", "high"):
        if name in arrays and (arrays[name].dtype != np.uint16 or arrays[name].ndim != 3):
            found = f"{arrays[name].dtype} {arrays[name].shape}"
            raise ArchiveError(f"{source}: '{name}' is {found}; it must be uint16 (frame, row, column)")
    if ("low" in arrays) != ("high" in arrays):
        raise ArchiveError(f"{source}: holds one of 'low' and 'high'; give both reference stacks or none")
    numbers = arrays.get("frame_number", np.arange(len(arrays["frames"])))
    if numbers.dtype.kind not in "iu" or numbers.shape != (len(arrays["frames"]),):
        raise ArchiveError(f"{source}: 'frame_number' must be one integer for each of {len(arrays['frames'])} frames")
    return CameraFrames(
        frames=ArrayFrames(arrays["frames"]),
        frame_number=numbers.astype(np.int64),
        bit_depth=facts.bit_depth or _DEFAULT_BITS,
        integration_time_s=facts.integration_time_s,
        nonuniformity=_reference(arrays) if "low" in arrays else None,
    )


def _reference(arrays: dict[str, Any]) -> NonuniformityReference:
    low, high = ArrayFrames(arrays["low"]), ArrayFrames(arrays["high"])
    low_dn, high_dn, low_noise_dn, high_noise_dn = reduce_reference(low, high)
    return NonuniformityReference(
        low_dn=low_dn,
        high_dn=high_dn,
        low_noise_dn=low_noise_dn,
        high_noise_dn=high_noise_dn,
        n_frames=min(low.shape[0], high.shape[0]),
        low_frames=low,
        high_frames=high,
    )
