"""Timestamps from a logic analyser, and the recording that they make of frames."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import final

from irtiming.archive.captures.streams import CapturedTicks, captured_ticks, line_map
from irtiming.archive.captures.timed_recording import CameraFacts, write_timed
from irtiming.archive.frames.opening import files_read
from irtiming.archive.json_file import require_places, write_json
from irtiming.errors import ArchiveError
from irtiming.records.finding import Finding

_LONGEST_GLITCH_S = 1.0


@final
@dataclass(frozen=True, kw_only=True)
class CaptureOrder:
    """What a person wants of a capture.

    ``lines`` says in text which line each stream is; ``frames`` are those that the timestamps are for, and ``out`` the recording
    to make of both; ``json`` is for the timestamps alone. ``facts`` are those of plain arrays. Levels of less than ``shortest_s``
    are glitches. None as ``clock_hz`` takes the analyser's own.
    """

    capture: Path
    lines: str
    frames: Path | None = None
    out: Path | None = None
    json: Path | None = None
    facts: CameraFacts | None = None
    clock_hz: int | None = None
    shortest_s: float = 0.0
    is_delayed: bool = False

    def __post_init__(self) -> None:
        if not 0 <= self.shortest_s <= _LONGEST_GLITCH_S:
            raise ArchiveError(
                f"{{shortest_s}} is {self.shortest_s:g} s, must be from 0 to {_LONGEST_GLITCH_S:g} s: no glitch lasts longer",
                "shortest_s",
            )
        if (self.frames is None) != (self.out is None):
            raise ArchiveError(
                "{frames} and {out} belong together: the frames, and the recording to make of them", "frames", "out"
            )
        if self.out is None and self.json is None:
            raise ArchiveError(
                "nothing to write: give {frames} and {out} for a recording, or {json} for the timestamps alone",
                "frames",
                "out",
                "json",
            )

    @property
    def places(self) -> tuple[Path, ...]:
        """What is to be written."""
        return tuple(place for place in (self.out, self.json) if place is not None)


@final
@dataclass(frozen=True, kw_only=True)
class Imported:
    """Timestamps of a capture, and what is odd about the recording made with them."""

    ticks: CapturedTicks
    findings: tuple[Finding, ...] = ()


def import_capture(order: CaptureOrder) -> Imported:
    """Take timestamps from a capture, and put them and the frames into a recording.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, data were lost in the capture, or it contradicts the frames.
    """
    read = [order.capture, *(files_read(order.frames) if order.frames else [])]
    require_places({"recording": [order.out], "JSON": [order.json]}, inputs=read)
    lines = line_map(order.lines)
    ticks = captured_ticks(order.capture, lines, clock_hz=order.clock_hz, shortest_s=order.shortest_s)
    if order.json is not None:
        write_json(_as_json(ticks), order.json)
    if order.frames is None or order.out is None:
        return Imported(ticks=ticks)
    findings = write_timed(order.frames, order.out, ticks=ticks, facts=order.facts, is_delayed=order.is_delayed)
    return Imported(ticks=ticks, findings=tuple(findings))


def _as_json(ticks: CapturedTicks) -> Mapping[str, object]:
    streams = {field.name: values for field, values in ticks.streams.items()}
    return {"clock_frequency": {"value": ticks.clock_frequency_hz, "unit": "Hz"}, "ticks": streams}
