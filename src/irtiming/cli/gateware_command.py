"""`irtiming gateware`: the trigger generator itself, or a simulated one: build it, try it, record with it."""

import asyncio
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from irtiming.cli.gateware_build_command import build
from irtiming.cli.gateware_firmware_command import firmware
from irtiming.errors import ArchiveError, InstrumentError, PlanError, UnitError
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.units import seconds

if TYPE_CHECKING:
    from collections.abc import Iterator

    from irtiming.cli.progress import Told
    from irtiming.gateware.model_device import SimulatedDevice, Wheel
    from irtiming.instruments.generator.trigger_generator import Identity, Wiring
    from irtiming.records.timestamps import Timestamps
    from irtiming.records.trigger_plan import PlannedRun, TriggerPlan

Port = Annotated[str, typer.Argument(help="Serial port of the trigger generator, such as /dev/ttyUSB1 or COM3.")]

app = typer.Typer(
    name="gateware",
    help="The trigger generator: build it, identify it, record with it, or simulate one.",
    no_args_is_help=True,
)


def identify(
    port: Port,
    json: Annotated[Path | None, typer.Option("--json", metavar="OUT", help="Write all registers there.")] = None,
) -> None:
    """Say what trigger generator is at a port, and what its registers hold."""
    from rich.console import Console
    from rich.table import Table

    from irtiming.archive.json_file import require_place, write_json
    from irtiming.gateware.register_map import REGISTERS

    if json is not None:
        require_place(json)
    identity, values = asyncio.run(_registers(port))
    screen = Console(highlight=False)
    major, minor = identity.version
    screen.print(
        f"{port}: trigger generator, version {major}.{minor}, clock {identity.clock_frequency_hz} Hz",
        markup=False, soft_wrap=True,
    )  # fmt: skip
    table = Table(box=None, pad_edge=False)
    for heading, side in (("register", "left"), ("holds", "right"), ("", "left")):
        table.add_column(heading, justify="right" if side == "right" else "left", no_wrap=True)
    for register in REGISTERS:
        table.add_row(register.name, str(values[register.name]), register.unit)
    screen.print(table)
    if json is not None:
        write_json({"port": port, "version": list(identity.version), "registers": values}, json)


def record(
    port: Port,
    plan: Annotated[Path, typer.Option(metavar="FILE", help="Plan that irtiming plan --json wrote.")],
    out: Annotated[
        Path, typer.Option(metavar="OUT", help="Write the timestamps there (.nxs); combine adds the frames.")
    ],
    run: Annotated[int, typer.Option(min=1, help="Which run of the plan, counted from 1.")] = 1,
    falling: Annotated[
        list[str] | None,
        typer.Option(
            help="Line whose falling edge counts, such as control_slot or camera_output (which then idles high); repeatable."
        ),
    ] = None,
    glitch_filter: Annotated[
        str,
        typer.Option(metavar="TIME", help="An input edge counts once its level has lasted so long, such as '1 us'."),
    ] = "0 s",
    camera_pulse: Annotated[
        str, typer.Option(metavar="TIME", help="Length of a camera trigger; at most half of the camera period is set.")
    ] = "1 ms",
    camera_input: Annotated[
        bool, typer.Option("--camera-input", help="Also record what the camera sends back.")
    ] = False,
) -> None:
    """Load one run of a plan, wait for the wheel, trigger the camera and write the timestamps.

    The camera must wait for its triggers: start it first. A loss of timestamps is marked in the file and ends with status 2.
    """
    from rich.console import Console

    from irtiming.archive.json_file import require_place
    from irtiming.archive.plan_file import read_plan
    from irtiming.archive.timestamps_file import write_timestamps
    from irtiming.cli.progress import shown

    require_place(out, besides=[plan])
    planned = read_plan(plan)
    if run > len(planned.runs):
        raise PlanError(f"--run {run} was asked for, but {plan} has {len(planned.runs)} runs; name one of them")
    chosen = planned.runs[run - 1]
    wiring = _wiring(tuple(falling or ()), glitch_filter, camera_pulse, planned.clock_frequency_hz, camera_input)
    with shown("triggers") as told:
        found, failure = asyncio.run(_measured(port, planned, chosen, wiring=wiring, told=told))
    if found is not None:
        write_timestamps(found, out, run=chosen)
    if failure is not None:
        if found is not None:
            failure.add_note(f"what arrived until then is in {out}, marked as not whole")
        raise failure
    if found is not None and not found.is_whole:
        raise InstrumentError(_lost(found, out))
    if found is not None:
        counts = (
            f"{found.camera_trigger_ticks.size} triggers, {found.control_slot_ticks.size} control slots, "
            f"{found.application_edge_ticks.size} application edges"
        )
        Console().print(f"{out}: {counts}; nothing was lost", markup=False, highlight=False, soft_wrap=True)


def combine(
    timestamps: Annotated[Path, typer.Argument(help="File that irtiming gateware record wrote.")],
    frames: Annotated[Path, typer.Argument(help="The camera's frames of that run: .npy, .npz, or a recording.")],
    out: Annotated[Path, typer.Option(metavar="OUT", help="Recording to make of frames and timestamps.")],
    camera: Annotated[CameraType | None, typer.Option(help="Kind of camera; for .npy and .npz.")] = None,
    readout: Annotated[
        ReadoutMode | None,
        typer.Option(
            help="How it is read, if not as usual: photon cameras at once, others row by row; for .npy and .npz."
        ),
    ] = None,
    integration_time: Annotated[
        str | None, typer.Option(metavar="TIME", help="Of a photon camera, such as '250 us'; for .npy and .npz.")
    ] = None,
    bit_depth: Annotated[
        int | None, typer.Option(min=1, max=16, help="Bits of a pixel value, 16 if not given; for .npy and .npz.")
    ] = None,
) -> None:
    """Put timestamps and frames of one run together into a recording that is ready for analysis."""
    from rich.console import Console

    from irtiming.archive.captures.streams import CapturedTicks
    from irtiming.archive.captures.timed_recording import CameraFacts, write_timed
    from irtiming.archive.json_file import require_place
    from irtiming.archive.timestamps_file import read_timestamps

    require_place(out, besides=[timestamps, frames])
    if camera is None and (readout, integration_time, bit_depth) != (None, None, None):
        raise ArchiveError(
            "--readout, --integration-time and --bit-depth go with --camera; give it too, or leave them out"
        )
    stamped = read_timestamps(timestamps)
    facts = None
    if camera is not None:
        facts = CameraFacts(
            camera_type=camera,
            readout_mode=readout,
            rotation_speed_hz=stamped.rotation_speed_hz,
            integration_time_s=None if integration_time is None else seconds(integration_time),
            trigger_delay_time_set_s=stamped.trigger_delay_time_set_s,
            bit_depth=bit_depth or 16,
        )
    ticks = CapturedTicks(clock_frequency_hz=stamped.clock_frequency_hz, streams=stamped.streams)
    screen = Console()
    for finding in write_timed(frames, out, ticks=ticks, facts=facts):
        screen.print(f"warning: {finding.sentence()}", markup=False, highlight=False, soft_wrap=True)
    screen.print(f"{out}: check it with irtiming verify", markup=False, highlight=False, soft_wrap=True)


def simulate(
    clock_hz: Annotated[
        int, typer.Option(min=1_000_000, max=1_000_000_000, help="Clock of the device, whole Hz.")
    ] = 48_000_000,
    duration: Annotated[
        str | None, typer.Option(metavar="TIME", help="End after this, such as '10 min'; else Ctrl-C ends it.")
    ] = None,
    model: Annotated[
        bool,
        typer.Option(
            "--model", help="The integer model instead of the compiled circuit; needs no tools, keeps real time."
        ),
    ] = False,
    speed: Annotated[
        float, typer.Option(min=0.001, max=1000, help="Seconds of the device per second, if it can.")
    ] = 1.0,
    seed: Annotated[int, typer.Option(min=0, help="Draws the wheel and how it turns.")] = 1,
) -> None:
    """Serve a simulated trigger generator at a serial port of its own, with a chopper wheel that follows it.

    The port's path is printed first. The compiled circuit runs at about a third of real time; it needs g++ and the tools of the
    extra "gateware".
    """
    from rich.console import Console

    from irtiming.gateware.pseudo_terminal import PseudoTerminal
    from irtiming.twin.driven_wheel import DrivenWheel
    from irtiming.twin.rig import draw
    from irtiming.twin.scene import paper_scene

    lasts_s = None if duration is None else seconds(duration)
    wheel = DrivenWheel(draw(paper_scene(), seed=seed).scene, clock_frequency_hz=clock_hz, seed=seed)
    notes = Console(stderr=True, highlight=False)
    with _device(wheel, clock_hz, is_model=model) as device, PseudoTerminal(device, speed=speed) as terminal:
        print(terminal.path, flush=True)  # noqa: T201 - for a program that reads it
        kind = "integer model" if model else "compiled circuit"
        end = "Ctrl-C ends it" if lasts_s is None else f"ends after {duration}"
        notes.print(f"simulated trigger generator, {kind}, clock {clock_hz} Hz; {end}", soft_wrap=True)
        try:
            terminal.wait(lasts_s)
        except KeyboardInterrupt:
            notes.print("ended")


for command in (build, firmware, identify, record, combine, simulate):
    app.command()(command)


@contextmanager
def _device(wheel: "Wheel", clock_hz: int, *, is_model: bool) -> "Iterator[SimulatedDevice]":
    from irtiming.gateware.model_device import ModelDevice

    if is_model:
        yield ModelDevice(wheel, clock_frequency_hz=clock_hz)
        return
    from irtiming.gateware.compiled import CompiledCircuit
    from irtiming.gateware.compiled_device import CompiledDevice

    with CompiledCircuit(clock_frequency_hz=clock_hz) as circuit:
        yield CompiledDevice(circuit, wheel, clock_frequency_hz=clock_hz)


async def _registers(port: str) -> "tuple[Identity, dict[str, int]]":
    from irtiming.gateware.register_map import REGISTERS
    from irtiming.instruments.generator.trigger_generator import connected

    async with connected(port) as generator:
        return generator.identity, {register.name: await generator.register(register.name) for register in REGISTERS}


async def _measured(
    port: str, plan: "TriggerPlan", run: "PlannedRun", *, wiring: "Wiring", told: "Told"
) -> "tuple[Timestamps | None, InstrumentError | None]":
    """Timestamps, and what went wrong; both where something arrived before it did."""
    from irtiming.acquire.trigger_train import measure
    from irtiming.instruments.generator.trigger_generator import connected

    clock = plan.clock_frequency_hz
    async with connected(port, wiring=wiring) as generator:
        progress = lambda done, total: told(port, done, total)  # noqa: E731
        try:
            return await measure(generator, run, clock_frequency_hz=clock, progress=progress), None
        except InstrumentError as error:
            try:
                kept = generator.captured()
            except InstrumentError:
                return None, error
            return (kept if kept.camera_trigger_ticks.size and not kept.is_whole else None), error


def _wiring(
    falling: tuple[str, ...], glitch_filter: str, camera_pulse: str, clock_hz: int, camera_input: bool
) -> "Wiring":
    from irtiming.acquire.rig import wiring_of
    from irtiming.gateware.register_map import Polarity
    from irtiming.records.series_plan import WiringWishes

    for name in falling:
        if name.upper() not in Polarity.__members__:
            lines = ", ".join(Polarity.__members__).lower()
            raise UnitError(f"--falling '{name}' is no line; name one of {lines}")
    wishes = WiringWishes(
        falling=falling,
        glitch_filter_s=seconds(glitch_filter),
        camera_pulse_s=seconds(camera_pulse),
        camera_input=camera_input,
    )
    return wiring_of(wishes, clock_frequency_hz=clock_hz)


def _lost(found: "Timestamps", out: Path) -> str:
    lost, triggers = found.lost_after_ticks, found.camera_trigger_ticks
    first_s = float(lost[0] - (triggers[0] if triggers.size else lost[0])) / found.clock_frequency_hz
    return (
        f"timestamps were lost at {lost.size} places, the first {first_s:.6f} s after the first trigger; {out} is marked so and "
        "will not be analysed: check the line, stop what else keeps the computer busy, and record again"
    )
