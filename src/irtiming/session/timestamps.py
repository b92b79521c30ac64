"""Timestamps of one run from the trigger generator alone, and the recording that they make of the camera's frames."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

from irtiming.acquire.rig import wiring_of
from irtiming.acquire.trigger_train import measure
from irtiming.archive.captures.streams import CapturedTicks
from irtiming.archive.captures.timed_recording import CameraFacts, write_timed
from irtiming.archive.frames.opening import files_read
from irtiming.archive.json_file import require_places
from irtiming.archive.plan_file import read_plan
from irtiming.archive.timestamps_file import read_timestamps, write_timestamps
from irtiming.errors import ArchiveError, InstrumentError, PlanError
from irtiming.gateware.register_map import REGISTERS
from irtiming.instruments.generator.trigger_generator import Identity, connected
from irtiming.instruments.protocols import TriggerGenerator
from irtiming.records.finding import Finding
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.records.series_plan import WiringWishes
from irtiming.records.timestamps import Timestamps
from irtiming.units import counted


@final
@dataclass(frozen=True, kw_only=True)
class TimestampOrder:
    """What a person wants recorded: one run of a plan, counted from 1, by the trigger generator at a port."""

    port: str
    plan: Path
    out: Path
    run: int = 1
    wiring: WiringWishes = field(default_factory=WiringWishes)


@final
@dataclass(frozen=True, kw_only=True)
class FramesOrder:
    """What a person wants combined; ``camera`` and what stands below it are for frames in plain arrays."""

    timestamps: Path
    frames: Path
    out: Path
    camera: CameraType | None = None
    readout: ReadoutMode | None = None
    integration_time_s: float | None = None
    bit_depth: int | None = None

    def __post_init__(self) -> None:
        if self.camera is None and (self.readout, self.integration_time_s, self.bit_depth) != (None, None, None):
            raise ArchiveError(
                "{readout}, {integration_time_s} and {bit_depth} go with {camera}; give it too, or leave them out",
                "readout",
                "integration_time_s",
                "bit_depth",
                "camera",
            )


@final
@dataclass(frozen=True, kw_only=True)
class Registers:
    """What trigger generator is at a port, and what its registers hold, by their names."""

    identity: Identity
    values: dict[str, int]


async def identify(port: str) -> Registers:
    """Ask the trigger generator at a port.

    Raises
    ------
    InstrumentError
        If it cannot be used.
    """
    async with connected(port) as generator:
        values = {register.name: await generator.register(register.name) for register in REGISTERS}
        return Registers(identity=generator.identity, values=values)


async def record(order: TimestampOrder, *, progress: Callable[[int, int], None] | None = None) -> Timestamps:
    """Load one run of a plan, wait for the wheel, trigger the camera and write the timestamps.

    Raises
    ------
    IrTimingError
        If the run cannot be made, or timestamps were lost: what arrived is in the file then, marked as not whole.
    """
    require_places({"recording": [order.out]}, inputs=[order.plan])
    plan = read_plan(order.plan)
    if order.run > len(plan.runs):
        raise PlanError(
            f"{{run}} {order.run} was asked for, but {order.plan} has {len(plan.runs)} runs; name one of them", "run"
        )
    run = plan.runs[order.run - 1]
    wiring = wiring_of(order.wiring, clock_frequency_hz=plan.clock_frequency_hz)
    async with connected(order.port, wiring=wiring) as generator:
        try:
            found = await measure(generator, run, clock_frequency_hz=plan.clock_frequency_hz, progress=progress)
        except InstrumentError as error:
            if (kept := _kept(generator)) is not None:
                write_timestamps(kept, order.out, run=run)
                error.add_note(f"what arrived until then is in {order.out}, marked as not whole")
            raise
    write_timestamps(found, order.out, run=run)
    if not found.is_whole:
        raise InstrumentError(_lost(found, order.out))
    return found


def _kept(generator: TriggerGenerator) -> Timestamps | None:
    """What arrived before a run went wrong; None where no trigger did, or all is there."""
    try:
        kept = generator.captured()
    except InstrumentError:
        return None
    return kept if kept.camera_trigger_ticks.size and not kept.is_whole else None


def _lost(found: Timestamps, out: Path) -> str:
    lost, triggers = found.lost_after_ticks, found.camera_trigger_ticks
    first_s = float(lost[0] - (triggers[0] if triggers.size else lost[0])) / found.clock_frequency_hz
    return (
        f"timestamps were lost at {counted(lost.size, 'place')}, the first {first_s:.6f} s after the first trigger; "
        f"{out} is marked so and will not be analysed: check the line, stop what else keeps the computer busy, and record again"
    )


def combine(order: FramesOrder) -> list[Finding]:
    """Put timestamps and frames of one run together into a recording.

    Returns
    -------
    Oddities that do not stop an analysis.

    Raises
    ------
    ArchiveError
        If a file cannot be read or written, or frames and timestamps contradict each other.
    """
    require_places({"recording": [order.out]}, inputs=[order.timestamps, *files_read(order.frames)])
    stamped = read_timestamps(order.timestamps)
    facts = None
    if order.camera is not None:
        facts = CameraFacts(
            camera_type=order.camera,
            readout_mode=order.readout,
            rotation_speed_hz=stamped.rotation_speed_hz,
            integration_time_s=order.integration_time_s,
            trigger_delay_time_set_s=stamped.trigger_delay_time_set_s,
            bit_depth=order.bit_depth,
        )
    ticks = CapturedTicks(clock_frequency_hz=stamped.clock_frequency_hz, streams=stamped.streams)
    return write_timed(order.frames, order.out, ticks=ticks, facts=facts)
