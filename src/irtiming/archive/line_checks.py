"""Checks of what is wired where: exchanged lines, edges that bounce, triggers without frames, the camera's own clock."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from irtiming.archive import layout
from irtiming.archive.finding import error_at, warning_at
from irtiming.physics.clock_rate import camera_clock
from irtiming.records.finding import Finding
from irtiming.units import counted, readable_time

if TYPE_CHECKING:
    from irtiming.archive.consistency import Contents
    from irtiming.records.arrays import Ticks

_EXCHANGED = 2.0
"""Control slots come fifty times as often as application edges; where they come half as often the lines are exchanged."""

_BOUNCE_SHARE = 0.05
"""Of the usual distance between edges: what comes sooner is the same edge once more."""

_FAR_MORE = 1.25
"""Triggers per frame: no link loses a fifth of all frames, a camera that cannot follow leaves out a half."""

_CRYSTALS = 200e-6
"""Two crystals do not disagree by more."""


def check_lines(contents: "Contents") -> list[Finding]:
    """Everything that looks like a line in the wrong place; fields that are None are left out."""
    if is_exchanged(contents):
        return list(_exchanged(contents))
    return [*_bounces(contents), *_triggers_without_frames(contents), *_camera_clock(contents)]


def is_exchanged(contents: "Contents") -> bool:
    """Whether the two light gates' lines are exchanged."""
    slots, edges = (_usual(contents.get(field)) for field in (layout.CONTROL_SLOT, layout.APPLICATION_SLOT))
    return slots is not None and edges is not None and slots > _EXCHANGED * edges


def _usual(ticks: "Ticks | None") -> float | None:
    return None if ticks is None or ticks.size < 3 else float(np.median(np.diff(ticks)))


def _exchanged(contents: "Contents") -> Iterator[Finding]:
    slots, edges = contents[layout.CONTROL_SLOT], contents[layout.APPLICATION_SLOT]
    share = (_usual(slots) or 0.0) / (_usual(edges) or 1.0)
    yield error_at(
        layout.CONTROL_SLOT.path,
        f"has edges {share:.3g} times as far apart as application_slot: the two lines are exchanged",
        code="lines-exchanged",
        cure="exchange the cables of the two light gates and record again, or exchange the two streams in the file",
    )


def _bounces(contents: "Contents") -> Iterator[Finding]:
    clock = contents.get(layout.CLOCK_FREQUENCY)
    for field in (layout.CONTROL_SLOT, layout.APPLICATION_SLOT, layout.APPLICATION_EDGES, layout.CAMERA_INPUT):
        ticks: Ticks | None = contents.get(field)
        usual = _usual(ticks)
        if ticks is None or usual is None or clock is None:
            continue
        steps = np.diff(ticks)
        short = steps[(steps > 0) & (steps < _BOUNCE_SHARE * usual)]
        if short.size:
            first = int(np.argmax((steps > 0) & (steps < _BOUNCE_SHARE * usual)))
            longest = readable_time(float(f"{short.max() / clock:.2g}"))
            yield warning_at(
                field.path,
                f"has {counted(short.size, 'bouncing edge')}: within {longest} of the one before, the first after entry {first}",
                code="edges-bounce",
                cure=f"set glitch_filter to more than {longest}, and clean slot and gate; the analysis leaves the later ones out",
            )


def _triggers_without_frames(contents: "Contents") -> Iterator[Finding]:
    shape, triggers = contents.get(layout.FRAMES), contents.get(layout.CAMERA_TRIGGER)
    numbers: Ticks | None = contents.get(layout.FRAME_NUMBER)
    if shape is None or triggers is None or triggers.size <= _FAR_MORE * shape[0]:
        return
    ratio = triggers.size / int(shape[0])
    what = f"has {triggers.size} triggers for {int(shape[0])} frames, {ratio:.3g} for each"
    cure = "the camera cannot follow, or the line carries more than triggers: lower the frame rate, check line and polarity"
    if numbers is None:
        what += ", and no frame_number says which made a frame: frames may be given wrong triggers"
    yield Finding(
        code="triggers-outnumber-frames",
        severity="doubt" if numbers is None else "warning",
        where=layout.CAMERA_TRIGGER.path,
        what=what,
        cure=cure,
    )


def _camera_clock(contents: "Contents") -> Iterator[Finding]:
    stamps: Ticks | None = contents.get(layout.FRAME_TIMESTAMP)
    stamps_hz, clock_hz = contents.get(layout.TIMESTAMP_FREQUENCY), contents.get(layout.CLOCK_FREQUENCY)
    triggers: Ticks | None = contents.get(layout.CAMERA_TRIGGER)
    numbers: Ticks | None = contents.get(layout.FRAME_NUMBER)
    if stamps is None or triggers is None or stamps_hz is None or clock_hz is None:
        return
    numbers = np.arange(stamps.size) if numbers is None else numbers
    if numbers.size != stamps.size or not stamps.size or numbers.min() < 0 or numbers.max() >= triggers.size:
        return
    found = camera_clock(
        "",
        stamp_ticks=stamps,
        stamp_frequency_hz=stamps_hz,
        trigger_ticks=triggers[numbers],
        clock_frequency_hz=clock_hz,
    )
    if found is None:
        return
    rate, u = 1e6 * found.relative_rate.value, 1e6 * found.relative_rate.standard_uncertainty
    what = f"the camera's clock runs {rate:+.3f} ppm (u = {u:.2g} ppm) against the trigger generator's"
    is_off = abs(found.relative_rate.value) > _CRYSTALS + 4 * found.relative_rate.standard_uncertainty
    cure = "two crystals agree better: check timestamp_frequency and clock_frequency, and that triggers make the frames"
    yield Finding(
        code="camera-clock-rate",
        severity="doubt" if is_off else "info",
        where=layout.FRAME_TIMESTAMP.path,
        what=what,
        cure=cure if is_off else "",
    )
