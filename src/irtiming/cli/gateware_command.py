"""`irtiming gateware`: the trigger generator itself, or a simulated one: build it, try it, record with it."""

import asyncio
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from irtiming.cli.gateware_build_command import build
from irtiming.cli.gateware_firmware_command import firmware
from irtiming.cli.latency_command import Json, LoopLine, RigToUpdate, show
from irtiming.cli.options import ArrayBits, ArrayCamera, ArrayIntegration, ArrayReadout, Duration, filled, in_options
from irtiming.cli.screen import say
from irtiming.errors import GatewareError
from irtiming.units import seconds

if TYPE_CHECKING:
    from collections.abc import Iterator

    from irtiming.gateware.model_device import SimulatedDevice, Wheel

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

    from irtiming.archive.json_file import require_places, write_json
    from irtiming.gateware.register_map import REGISTERS
    from irtiming.session import timestamps as session

    require_places({"JSON": [json]})
    found = asyncio.run(session.identify(port))
    screen = Console(highlight=False)
    major, minor = found.identity.version
    clock_hz = found.identity.clock_frequency_hz
    say(f"{port}: trigger generator, version {major}.{minor}, clock {clock_hz} Hz", screen)
    table = Table(box=None, pad_edge=False)
    for heading, side in (("register", "left"), ("holds", "right"), ("", "left")):
        table.add_column(heading, justify="right" if side == "right" else "left", no_wrap=True)
    for register in REGISTERS:
        table.add_row(register.name, str(found.values[register.name]), register.unit)
    screen.print(table)
    if json is not None:
        write_json({"port": port, "version": [major, minor], "registers": found.values}, json)


@in_options
def record(
    port: Port,
    plan: Annotated[Path, typer.Option(metavar="FILE", help="Plan that irtiming plan --json wrote.")],
    out: Annotated[
        Path,
        typer.Option("--out", "-o", metavar="OUT", help="Write the timestamps there (.nxs); combine adds the frames."),
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
    spare: Annotated[
        bool, typer.Option("--spare", help="Also record the spare input, such as a pulse per second.")
    ] = False,
) -> None:
    """Load one run of a plan, wait for the wheel, trigger the camera and write the timestamps.

    The camera must wait for its triggers: start it first. A loss of timestamps is marked in the file and ends with status 2.
    """
    given = locals()
    from functools import partial

    from irtiming.cli.progress import shown
    from irtiming.records.series_plan import WiringWishes
    from irtiming.session import timestamps as session

    order = filled(session.TimestampOrder, given, wiring=filled(WiringWishes, given))
    with shown("triggers") as progress:
        found = asyncio.run(session.record(order, progress=partial(progress, port)))
    say(
        f"{out}: {found.camera_trigger_ticks.size} triggers, {found.control_slot_ticks.size} control slots, "
        f"{found.application_edge_ticks.size} application edges; nothing was lost"
    )


@in_options
def combine(
    timestamps: Annotated[Path, typer.Argument(help="File that irtiming gateware record wrote.")],
    frames: Annotated[
        Path, typer.Argument(help="The camera's frames of that run, in any format that irtiming info knows.")
    ],
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="OUT", help="Recording to make of frames and timestamps.")
    ],
    camera: ArrayCamera = None,
    readout: ArrayReadout = None,
    integration_time: ArrayIntegration = None,
    bit_depth: ArrayBits = None,
) -> None:
    """Put timestamps and frames of one run together into a recording that is ready for analysis."""
    given = locals()
    from irtiming.session import timestamps as session

    for finding in session.combine(filled(session.FramesOrder, given)):
        say(f"warning: {finding.sentence()}")
    say(f"{out}: check it with irtiming verify")


def simulate(
    clock_hz: Annotated[
        int, typer.Option(min=1_000_000, max=1_000_000_000, help="Clock of the device, whole Hz.")
    ] = 48_000_000,
    duration: Duration = None,
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
    loop: Annotated[
        str | None,
        typer.Option(
            metavar="TIME",
            help="With --model: the trigger is led back to spare_in and takes that time, such as '40 ns'.",
        ),
    ] = None,
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
    later = None if loop is None else round(seconds(loop) * clock_hz)
    with (
        _device(wheel, clock_hz, is_model=model, loop_cycles=later) as device,
        PseudoTerminal(device, speed=speed) as terminal,
    ):
        print(terminal.path, flush=True)  # noqa: T201 - for a program that reads it
        kind = "integer model" if model else "compiled circuit"
        end = "Ctrl-C ends it" if lasts_s is None else f"ends after {duration}"
        notes.print(f"simulated trigger generator, {kind}, clock {clock_hz} Hz; {end}", soft_wrap=True)
        try:
            terminal.wait(lasts_s)
        except KeyboardInterrupt:
            notes.print("ended")


@in_options
def loopback(port: Port, line: LoopLine = "spare", rig: RigToUpdate = None, json: Json = None) -> None:
    """Measure the trigger generator's own latency: its trigger, led back to an input, makes 300 timestamps.

    The camera's line goes to spare_in or camera_in, bare or through the cable and buffers of the rig; nothing else is needed. A
    chopper that is connected goes to 3 Hz.
    """
    given = locals()
    from irtiming.session.latency import LoopTestOrder, measure_loop

    show(asyncio.run(measure_loop(filled(LoopTestOrder, given))), rig)


for command in (build, firmware, identify, record, combine, loopback, simulate):
    app.command()(command)


@contextmanager
def _device(wheel: "Wheel", clock_hz: int, *, is_model: bool, loop_cycles: int | None) -> "Iterator[SimulatedDevice]":
    from irtiming.gateware.model_device import Loop, ModelDevice
    from irtiming.gateware.register_map import Channel

    if is_model:
        loop = None if loop_cycles is None else Loop(channel=Channel.SPARE, cycles=loop_cycles)
        yield ModelDevice(wheel, clock_frequency_hz=clock_hz, loop=loop)
        return
    if loop_cycles is not None:
        raise GatewareError("--loop is of the integer model; say --model too")
    from irtiming.gateware.compiled import CompiledCircuit
    from irtiming.gateware.compiled_device import CompiledDevice

    with CompiledCircuit(clock_frequency_hz=clock_hz) as circuit:
        yield CompiledDevice(circuit, wheel, clock_frequency_hz=clock_hz)
