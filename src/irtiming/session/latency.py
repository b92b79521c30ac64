"""Latencies of light gates and trigger from recordings, or from a trigger led back, as lines of rig.toml."""

import asyncio
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal, final

from irtiming.archive import layout, rig_update
from irtiming.archive.json_file import require_places, write_json
from irtiming.archive.layout import Field
from irtiming.archive.rig_file import read_rig
from irtiming.archive.timestamps_file import TimedRun, read_timestamps
from irtiming.errors import EstimationError, InstrumentError
from irtiming.estimate import latency
from irtiming.gateware.register_map import Channel
from irtiming.instruments.generator.trigger_generator import Wiring, connected
from irtiming.physics.wheel import TURN
from irtiming.records.latency_check import GateRegister, LatencyDifference, LoopBack
from irtiming.records.rig import Latency, Measured
from irtiming.records.trigger_plan import PlannedRun, TriggerScheme
from irtiming.reduce.wheel.gate_register import register
from irtiming.units import require_uncertainty

_USUAL_SLOTS = 100
LoopLine = Literal["spare", "camera_input"]
_LOOP_TRIGGERS, _LOOP_STEPS, _LOOP_POLL_S = 300, 7, 0.05
_LOOP_LINES: dict[LoopLine, Field] = {"spare": layout.SPARE, "camera_input": layout.CAMERA_INPUT}


@final
@dataclass(frozen=True, kw_only=True)
class GatesOrder:
    """What a person wants: recordings at several speeds, or one and one with the gates ``exchanged``.

    ``photodiode_s`` is the latency of a fast photodiode whose edges are at the spare input, None without one. Without it
    ``application_gate_s``, or that of ``rig``, is taken as known. ``place_u_rad`` is the standard uncertainty of the angle by
    which the beams stand elsewhere after the exchange. ``rig`` gets the lines of its section ``latency``.
    """

    recordings: tuple[Path, ...]
    exchanged: tuple[Path, ...] = ()
    photodiode_s: float | None = None
    photodiode_u_s: float = 0.0
    application_gate_s: float | None = None
    application_gate_u_s: float = 0.0
    place_u_rad: float | None = None
    rig: Path | None = None
    json: Path | None = None

    def __post_init__(self) -> None:
        for name in ("photodiode", "application_gate"):
            value, u = (f"{name}_s", f"{name}_u_s")
            require_uncertainty(getattr(self, u), of=getattr(self, value), fields=(value, u))
        if self.exchanged and self.place_u_rad is None:
            raise EstimationError(
                "{exchanged} wants {place_u_rad}: by how much the beams may stand elsewhere after the exchange; 1 um at 47 mm "
                "from the axle is 0.02 mrad, and at 3 Hz that is 1 µs",
                "exchanged",
                "place_u_rad",
            )
        if self.photodiode_s is not None and self.application_gate_s is not None:
            raise EstimationError(
                "{photodiode_s} and {application_gate_s} each give the same; leave one out",
                "photodiode_s",
                "application_gate_s",
            )


@final
@dataclass(frozen=True, kw_only=True)
class LoopOrder:
    """What a person wants: recordings, or timestamps, in which the trigger is led back to an input."""

    recordings: tuple[Path, ...]
    line: LoopLine = "spare"
    rig: Path | None = None
    json: Path | None = None


@final
@dataclass(frozen=True, kw_only=True)
class LoopTestOrder:
    """What a person wants: the trigger generator at a port tested by its own trigger, led back to an input."""

    port: str
    line: LoopLine = "spare"
    rig: Path | None = None
    json: Path | None = None


@final
@dataclass(frozen=True, kw_only=True)
class LatencyFound:
    """Differences of the gates' latencies, or triggers led back, and the latencies; None where nothing fixes them."""

    differences: tuple[LatencyDifference, ...] = ()
    loops: tuple[LoopBack, ...] = ()
    latency: Latency | None = None

    @property
    def lines(self) -> str:
        """For rig.toml; empty where no latency is known."""
        return (
            "" if self.latency is None else rig_update.section_text("latency", rig_update.latency_lines(self.latency))
        )


def of_gates(order: GatesOrder) -> LatencyFound:
    """Latencies of the light gates.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, or the recordings do not tell the difference.
    """
    require_places({"JSON": [order.json]}, inputs=[*order.recordings, *order.exchanged, order.rig])
    rig = None if order.rig is None else read_rig(order.rig)
    slots = _USUAL_SLOTS if rig is None else rig.wheel.control_slots
    pitch = TURN / slots
    runs = [read_timestamps(path) for path in order.recordings]
    registers = [_register(run, layout.APPLICATION_SLOT, control_slots=slots) for run in runs]
    if order.exchanged:
        other = _register(read_timestamps(order.exchanged[0]), layout.APPLICATION_SLOT, control_slots=slots)
        application = latency.exchanged(registers[0], other, pitch_rad=pitch, place_u_rad=order.place_u_rad or 0.0)
    else:
        application = latency.over_speeds(
            registers, line="application gate", later_than="control gate", pitch_rad=pitch
        )
    photodiode = None
    if order.photodiode_s is not None:
        beside = [_register(run, layout.SPARE, control_slots=slots) for run in runs]
        photodiode = latency.over_speeds(beside, line="photodiode", later_than="control gate", pitch_rad=pitch)
    known = _known(order, None if rig is None else rig.latency)
    found = LatencyFound(
        differences=(application,) if photodiode is None else (application, photodiode),
        latency=None if known is None else latency.of_gates(application, photodiode=photodiode, known=known),
    )
    _write(found, rig=order.rig, json=order.json)
    return found


def of_trigger(order: LoopOrder) -> LatencyFound:
    """Latency of the trigger from one that was led back to an input.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, or no trigger came back.
    """
    require_places({"JSON": [order.json]}, inputs=[*order.recordings, order.rig])
    loops = tuple(_loop(read_timestamps(path), order.line) for path in order.recordings)
    longest = max(loops, key=lambda one: abs(one.mean_s))
    found = LatencyFound(loops=loops, latency=longest.latency)
    _write(found, rig=order.rig, json=order.json)
    return found


async def measure_loop(order: LoopTestOrder) -> LatencyFound:
    """Latency of the trigger from a short train that the trigger generator makes and stamps.

    Raises
    ------
    IrTimingError
        If the device cannot be used, timestamps were lost, or no trigger came back.
    """
    require_places({"JSON": [order.json]}, inputs=[order.rig])
    channel = {"spare": Channel.SPARE, "camera_input": Channel.CAMERA_INPUT}[order.line]
    async with connected(order.port, wiring=Wiring(also_recorded=channel)) as generator:
        clock_hz = generator.clock_frequency_hz
        step = clock_hz // (3 * _LOOP_TRIGGERS)
        scheme = TriggerScheme(turn_period_ticks=_LOOP_TRIGGERS * step, camera_period_ticks=_LOOP_STEPS * step)
        run = PlannedRun(scheme=scheme, trigger_delay_ticks=0, repeats=1, is_after_correction=False)
        await generator.load(run, clock_frequency_hz=clock_hz)
        await generator.arm()
        await generator.start()
        while not await generator.has_finished():
            await asyncio.sleep(_LOOP_POLL_S)
        found = await generator.stop()
    if not found.is_whole:
        raise InstrumentError(f"{order.port}: timestamps were lost; check the line and try again")
    stamps = found.spare_ticks if order.line == "spare" else found.camera_input_ticks
    loop = latency.of_loop(
        found.camera_trigger_delayed_ticks, stamps, name=order.port, line=order.line, clock_frequency_hz=clock_hz
    )
    outcome = LatencyFound(loops=(loop,), latency=loop.latency)
    _write(outcome, rig=order.rig, json=order.json)
    return outcome


def _register(run: TimedRun, field: Field, *, control_slots: int) -> GateRegister:
    edges = run.streams.get(field)
    if edges is None:
        raise EstimationError(f"{run.name}: {field.path} is not in it; record that line too")
    found = register(
        run.name,
        edge_ticks=edges,
        slot_ticks=run.streams[layout.CONTROL_SLOT],
        clock_frequency_hz=run.clock_frequency_hz,
        turn_ticks=run.clock_frequency_hz / run.rotation_speed_hz,
        control_slots=control_slots,
    )
    return replace(found, name=run.name)


def _known(order: GatesOrder, stated: Latency | None) -> Measured | None:
    """The latency that the others follow from: the photodiode's, or the application gate's."""
    if order.photodiode_s is not None:
        return Measured(order.photodiode_s, order.photodiode_u_s)
    if order.application_gate_s is not None:
        return Measured(order.application_gate_s, order.application_gate_u_s)
    return None if stated is None else stated.application_gate_s


def _loop(run: TimedRun, line: LoopLine) -> LoopBack:
    field = _LOOP_LINES[line]
    triggers = run.streams.get(layout.CAMERA_TRIGGER_DELAYED)
    if triggers is None or not triggers.size:
        if layout.CAMERA_TRIGGER not in run.streams:
            raise EstimationError(
                f"{run.name} has no camera_trigger: its camera runs free, and a loop-back needs triggers; record some "
                "that are led back to the input"
            )
        delay = round(run.trigger_delay_time_set_s * run.clock_frequency_hz)
        triggers = run.streams[layout.CAMERA_TRIGGER] + delay
    stamps = run.streams.get(field)
    return latency.of_loop(
        triggers,
        triggers[:0] if stamps is None else stamps,
        name=run.name,
        line=field.name,
        clock_frequency_hz=run.clock_frequency_hz,
    )


def _write(found: LatencyFound, *, rig: Path | None, json: Path | None) -> None:
    if json is not None:
        write_json(_content(found), json)
    if rig is not None and found.latency is not None:
        rig_update.update(rig, "latency", numbers=rig_update.latency_lines(found.latency))


def _content(found: LatencyFound) -> dict[str, Any]:
    return {
        "latency": None if found.latency is None else asdict(found.latency),
        "differences": [asdict(one) for one in found.differences],
        "loops": [asdict(one) for one in found.loops],
    }
