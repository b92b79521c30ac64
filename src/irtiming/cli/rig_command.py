"""`irtiming rig`: the simulated rig over the wires of a real one, and words by which to meddle with it."""

import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from irtiming.errors import ArchiveError, PlanError
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.units import seconds

if TYPE_CHECKING:
    from irtiming.twin.devices.bench import Bench
    from irtiming.twin.rig import SimulatedRig


def rig(
    simulate: Annotated[bool, typer.Option("--simulate", help="Serve a simulated rig until Ctrl-C.")] = False,
    camera: Annotated[CameraType, typer.Option(help="Kind of camera on the simulated rig.")] = "photon",
    readout: Annotated[
        ReadoutMode | None,
        typer.Option(help="How it is read, if not as usual: photon cameras at once, others row by row."),
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
            metavar="DIR", help="Write plan.toml, rig.toml and truth.json of this rig there; made if not there."
        ),
    ] = None,
    duration: Annotated[
        str | None, typer.Option(metavar="TIME", help="End after this, such as '10 min'; else Ctrl-C ends it.")
    ] = None,
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
    from rich.console import Console as Screen

    from irtiming.twin.cameras import camera_scene
    from irtiming.twin.devices.bench import Bench, Workplace
    from irtiming.twin.devices.console import WORDS, Console, say
    from irtiming.twin.rig import draw

    notes = Screen(highlight=False)
    if tell is not None:
        answer = "\n".join(WORDS) if tell == "help" else say(tell, port=console)
        notes.print(answer, markup=False, soft_wrap=True)
        return
    if not simulate:
        raise PlanError(
            "nothing was asked for; say --simulate to serve a simulated rig, or --tell WORDS to one that is served"
        )
    lasts_s = None if duration is None else seconds(duration)
    place = Workplace(
        camera_address=camera_address,
        blackbody_port=blackbody_port,
        clock_frequency_hz=clock_hz,
        speed=speed,
        run_up_s=seconds(run_up),
        settling_s=seconds(settling),
        seed=seed,
    )
    drawn = draw(camera_scene(camera, readout, rows=rows, columns=columns), seed=seed)
    notes.print(f"a {camera} camera of {columns} x {rows} pixels is being set up", soft_wrap=True)
    with Bench(drawn, place=place) as bench, Console(bench, port=console) as words:
        if out is not None:
            _write(bench, drawn, out, console=words.port)
        for name, address in bench.addresses.items():
            notes.print(f"{name:18} {address}", markup=False, soft_wrap=True)
        notes.print(f"{'console':18} {words.port}", markup=False, soft_wrap=True)
        ends = "Ctrl-C ends it" if lasts_s is None else f"ends after {duration}"
        notes.print(f"the rig is ready, {speed:g} of its seconds in one of yours; {ends}", soft_wrap=True)
        for number in (signal.SIGINT, signal.SIGTERM):  # a shell lets its jobs ignore the first
            signal.signal(number, lambda *_: bench.end())
        bench.serve(lasts_s)
    notes.print("the rig has ended")


def _write(bench: "Bench", drawn: "SimulatedRig", out: Path, *, console: int) -> None:
    """Files for the programs that work with this rig."""
    from irtiming.archive import rig_file
    from irtiming.archive.result_file import write_result
    from irtiming.twin.rig import truth

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(f"{out} cannot be made ({error.strerror}); give another folder") from error
    rig_file.write_rig(drawn.measured, out / "rig.toml")
    write_result(truth(drawn.scene), out / "truth.json")
    plan = out / "plan.toml"
    try:
        plan.write_text(_plan(bench, drawn, console=console), encoding="utf-8")
    except OSError as error:
        raise ArchiveError(f"{plan} cannot be written ({error.strerror}); give another folder") from error


def _plan(bench: "Bench", drawn: "SimulatedRig", *, console: int) -> str:
    """A series that this rig can record, to be changed as one likes."""
    from irtiming.twin.scene import readout_mode_of

    timing = drawn.scene.timing
    integration_s = getattr(timing, "integration_time_s", None)
    kind = "microbolometer" if integration_s is None else "photon"
    devices = "".join(f'{name} = "{address}"\n' for name, address in bench.addresses.items())
    lines = [
        f"[devices]\n{devices}speed = {bench.place.speed:g}   # seconds of the rig in one of yours; leave it out on a real rig\n",
        f'[camera]\ntype = "{kind}"\nreadout_mode = "{readout_mode_of(timing)}"\n',
        f"[series]\nwheel_hz = {[3, 9] if kind == 'photon' else [3]}\nframe_hz = 30.303\nsamples = 1000\n",
        f'[blackbody]\ntemperature = "{drawn.scene.radiance.blackbody_k:g} K"\n',
    ]
    if integration_s is not None:
        program = Path(sys.executable).with_name("irtiming")
        lines[1] += f'integration_time = "{1e6 * integration_s:g} us"\n'
        radiance = drawn.scene.radiance
        lines.append(
            f"[references]   # of the bare blackbody: the command takes wheel and mask out of the way, and brings them back\n"
            f'low = "{radiance.reference_low_k:g} K"\nhigh = "{radiance.reference_high_k:g} K"\nframes = 50\n'
            f'command = "{program} rig --console {console} --tell"\n'
        )
    return "\n".join(lines)
