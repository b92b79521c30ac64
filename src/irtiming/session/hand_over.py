"""A result as a file of another program, and as plain words."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import final

from irtiming.apply import export, handover
from irtiming.apply.camera_timing import CameraTiming
from irtiming.apply.handover import HandOver
from irtiming.archive.json_file import require_places, write_atomically
from irtiming.records.application import Program
from irtiming.records.frame_events import NOUNS
from irtiming.report.rounding import significant, time_text
from irtiming.session.apply_time import camera_of
from irtiming.units import readable_time, require_uncertainty


@final
@dataclass(frozen=True, kw_only=True)
class ExportOrder:
    """What a person wants: a result for a program; frames are stamped ``stamp_latency_s`` later than the result's event.

    ``frame_hz`` is the frame rate at which the camera is used, for a result of several.
    """

    result: Path
    program: Program
    out: Path
    stamp_latency_s: float = 0.0
    stamp_latency_u_s: float = 0.0
    frame_hz: float | None = None

    def __post_init__(self) -> None:
        require_uncertainty(
            self.stamp_latency_u_s, of=self.stamp_latency_s, fields=("stamp_latency_s", "stamp_latency_u_s")
        )


def hand_over(order: ExportOrder) -> HandOver:
    """Write a result as the file of another program; gives the numbers in it.

    Raises
    ------
    IrTimingError
        If the result cannot be read or applied, that program has no number for it, or the file cannot be written.
    """
    require_places({export.format_for(order.program): [order.out]}, inputs=[order.result])
    camera = camera_of(order.result)
    given = handover.of_camera(
        camera,
        stamp_latency_s=order.stamp_latency_s,
        stamp_latency_u_s=order.stamp_latency_u_s,
        frame_hz=order.frame_hz,
    )
    write_atomically(export.text_for(order.program, given), order.out)
    return given


def explain(path: Path, *, frame_hz: float | None = None) -> tuple[str, ...]:
    """A result in plain words, one sentence each.

    Parameters
    ----------
    path
        Of the result.
    frame_hz
        Frame rate at which the camera is used, for a result of several, Hz.

    Raises
    ------
    IrTimingError
        If the result cannot be read or applied.
    """
    camera = camera_of(path)
    return tuple(_sentences(camera, handover.of_camera(camera, frame_hz=frame_hz)))


def _sentences(camera: CameraTiming, given: HandOver) -> Iterator[str]:
    if given.simulated:
        yield "SIMULATED: no real camera was measured."
    where = "the middle row of your frame" if given.is_rolling else "your frame"
    yield f"{where[0].upper()}{where[1:]} shows the world as it was {_after(given)}."
    if given.validity is not None:
        tau = camera.estimate.value("time_constant"), camera.estimate.u("time_constant")
        yield (
            f"A pixel follows what it sees with a time constant of {time_text(*tau)}: "
            f"{time_text(3 * tau[0], 3 * tau[1])} after a sudden change it shows 95 % of it."
        )
        yield (
            f"Something that oscillates {significant(given.validity.frequency_hz)} times a second is shown 1 % too small; "
            "faster, it is shown smaller still."
        )
    elif given.integration is not None:
        window = time_text(given.integration.value_s, given.integration.u_s)
        yield (
            f"It is a mean over {window}: an edge that moves by 1 px in a millisecond is smeared over "
            f"{significant(1e3 * given.integration.value_s)} px."
        )
    if given.frames_back is not None:
        back = time_text(given.frames_back.value_s, given.frames_back.u_s)
        yield f"That counts the share of the frame before that each frame holds: it takes the moment back by {back}."
    if given.is_rolling and given.rows is not None:
        yield from _lean(given, given.rows)
    share = given.frame_period_s
    if share and abs(given.middle_row.value_s) > 0:
        yield f"One frame lasts {time_text(share)}: that is {significant(abs(given.middle_row.value_s) / share)} frames."
    if given.not_counted:
        yield (
            f"Not counted is the {given.not_counted}, the share of the frame before in each frame: it is not clear that there is "
            "one, and the recordings' frame periods differ, by which it would make the moment earlier; --frame-hz names yours."
        )
    if given.not_in_uncertainty:
        yield f"Not in the uncertainties, since it was not stated: {'; '.join(given.not_in_uncertainty)}."
    if camera.scatter is not None and {0.05, 0.95} <= set(camera.scatter.quantiles_s):
        early, late = (readable_time(float(f"{abs(camera.scatter.quantiles_s[share]):.2g}")) for share in (0.05, 0.95))
        what = "arrives" if camera.event == "arrival" else "is stamped"
        yield f"One frame of twenty {what} more than {early} before the median, one of twenty more than {late} after it."
    yield f"All that is counted from {NOUNS[camera.event]}; ± is one standard uncertainty."


def _after(given: HandOver) -> str:
    """How much after, or before, the event the middle row shows the scene."""
    side = "after" if given.middle_row.value_s >= 0 else "before"
    event = "the trigger edge" if given.event == "trigger" else NOUNS[given.event]
    return f"{time_text(abs(given.middle_row.value_s), given.middle_row.u_s)} {side} {event}"


def _lean(given: HandOver, rows: int) -> Iterator[str]:
    """What a rolling readout does to an edge."""
    last_s, u_s = abs((rows - 1) * given.row_delay.value_s), (rows - 1) * given.row_delay.u_s
    first, last = ("top", "bottom") if given.row_delay.value_s > 0 else ("bottom", "top")
    step = time_text(abs(given.row_delay.value_s), given.row_delay.u_s)
    yield (
        f"Rows are read from the {first} to the {last}, each {step} after the one before: the {last} row shows the world "
        f"{time_text(last_s, u_s)} later than the {first} row."
    )
    yield (
        f"A vertical edge that moves by 1 px in a row time leans by 45°, {rows - 1} px from top to bottom; one that moves at "
        f"100 px/s leans by {significant(100 * last_s)} px."
    )
