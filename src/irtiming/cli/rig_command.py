"""`irtiming rig`: the simulated rig over the wires of a real one, and words by which to meddle with it."""

import signal
from pathlib import Path
from typing import Annotated, Literal

import typer

from irtiming.cli.options import Duration, filled
from irtiming.cli.screen import say
from irtiming.errors import PlanError
from irtiming.records.frame_events import FreeEvent
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.units import seconds


def rig(
    simulate: Annotated[bool, typer.Option("--simulate", help="Serve a simulated rig until Ctrl-C.")] = False,
    camera: Annotated[CameraType, typer.Option(help="Kind of camera on the simulated rig.")] = "photon",
    readout: Annotated[
        ReadoutMode | None,
        typer.Option(help="How it is read, if not as usual: photon cameras at once, others row by row."),
    ] = None,
    free_running: Annotated[
        FreeEvent | None,
        typer.Option(help="A camera that needs no trigger, and what the delay of its frames is to count from."),
    ] = None,
    rows: Annotated[int, typer.Option(min=16, max=4096, help="Pixels down the image.")] = 120,
    columns: Annotated[int, typer.Option(min=16, max=4096, help="Pixels across the image.")] = 160,
    speed: Annotated[
        float, typer.Option(min=0.01, max=100, help="Seconds of the rig per second: how fast its time goes.")
    ] = 1.0,
    clock_hz: Annotated[
        int, typer.Option(min=1_000_000, max=1_000_000_000, help="Clock of the trigger generator, whole Hz.")
    ] = 48_000_000,
    camera_address: Annotated[
        str, typer.Option(metavar="IP", help="Address of this computer at which the camera is served.")
    ] = "127.0.0.2",
    blackbody_port: Annotated[
        Literal["tcp", "udp", "serial"], typer.Option(help="How the blackbody is connected.")
    ] = "tcp",
    run_up: Annotated[str, typer.Option(metavar="TIME", help="Of the chopper from rest to lock.")] = "5 s",
    settling: Annotated[str, typer.Option(metavar="TIME", help="Time constant of the blackbody.")] = "60 s",
    seed: Annotated[int, typer.Option(min=0, help="Draws the rig's imperfections; the same seed, the same rig.")] = 1,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="DIR",
            help="Write plan.toml, rig.toml and truth.json of this rig there; made if not there.",
        ),
    ] = None,
    duration: Duration = None,
    console: Annotated[
        int, typer.Option(min=0, max=65535, help="Port at which --tell reaches this rig; 0 for any that is free.")
    ] = 3957,
    tell: Annotated[
        str | None,
        typer.Option(
            metavar="WORDS", help="Say something to a rig that is served: remove, insert, state, fault ..., help."
        ),
    ] = None,
) -> None:
    """Serve a whole simulated rig: camera (GigE Vision), trigger generator, chopper and blackbody at ports of their own.

    Every device speaks its own protocol, so the drivers cannot tell it from a real one. --out writes the files that
    irtiming record and irtiming analyse want.
    """
    given = locals()
    from irtiming.archive.held_signals import SIGNALS, held_signals
    from irtiming.session.served_rig import ServedOrder, served
    from irtiming.twin.devices.bench import Workplace
    from irtiming.twin.devices.console import WORDS
    from irtiming.twin.devices.console import say as tell_rig

    if tell is not None:
        say("\n".join(WORDS) if tell == "help" else tell_rig(tell, port=console))
        return
    if not simulate:
        raise PlanError(
            "nothing was asked for; say --simulate to serve a simulated rig, or --tell WORDS to one that is served"
        )
    lasts_s = None if duration is None else seconds(duration)
    place = filled(Workplace, given, clock_frequency_hz=clock_hz)
    order = filled(ServedOrder, given, place=place, folder=out)
    say(f"a {camera} camera of {columns} x {rows} pixels is being set up")
    with held_signals() as held, served(order) as found:  # a camera that is half set up could not be ended
        for number in SIGNALS:  # a shell lets its jobs ignore the first
            signal.signal(number, lambda *_: found.bench.end())
        held.tell()
        for name, address in (*found.bench.addresses.items(), ("console", found.console)):
            say(f"{name:18} {address}")
        ends = "Ctrl-C ends it" if lasts_s is None else f"ends after {duration}"
        say(f"the rig is ready, {speed:g} of its seconds in one of yours; {ends}")
        found.bench.serve(lasts_s)
    say("the rig has ended")
