"""A whole simulated rig, served at ports of its own, with the files that programs want which work with it."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import final

from irtiming.archive import rig_writer
from irtiming.archive.json_file import make_folder, write_atomically, write_json
from irtiming.records.frame_events import FreeEvent
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.twin.cameras import camera_scene
from irtiming.twin.devices.bench import Bench, Workplace
from irtiming.twin.devices.console import Console
from irtiming.twin.free_camera import draw_free
from irtiming.twin.rig import SimulatedRig, draw, truth
from irtiming.twin.scene import CameraTiming, readout_mode_of

_FROM_AN_EVENT = ("timestamp_delay_s", "exposure_midpoint_delay_s")


@final
@dataclass(frozen=True, kw_only=True)
class ServedOrder:
    """What a person wants served: a camera at a place, words taken at the port ``console`` (0: any that is free).

    With ``free_running`` it makes frames by itself, and its plan counts from that event. When frames arrive is this computer's
    doing, so truth.json holds no delay from an arrival.
    """

    camera: CameraType = "photon"
    readout: ReadoutMode | None = None
    rows: int = 120
    columns: int = 160
    place: Workplace = field(default_factory=Workplace)
    free_running: FreeEvent | None = None
    console: int = 0
    folder: Path | None = None


@final
@dataclass(frozen=True, kw_only=True)
class ServedRig:
    """A rig whose devices are at their addresses, and the port at which it takes words."""

    bench: Bench
    console: int


@contextmanager
def served(order: ServedOrder) -> Iterator[ServedRig]:
    """The rig while the ``with`` block runs; its files are in the folder before the block begins.

    Raises
    ------
    IrTimingError
        If the rig cannot be, an address is in use, or a file cannot be written.
    """
    scene = camera_scene(order.camera, order.readout, rows=order.rows, columns=order.columns)
    rig = draw(scene, seed=order.place.seed)
    if order.free_running is not None:
        rig = replace(rig, scene=replace(rig.scene, free=draw_free(order.free_running, seed=order.place.seed)))
    with Bench(rig, place=order.place) as bench, Console(bench, port=order.console) as words:
        found = ServedRig(bench=bench, console=words.port)
        if order.folder is not None:
            _write(found, rig, order.folder)
        yield found


def _write(found: ServedRig, rig: SimulatedRig, folder: Path) -> None:
    make_folder(folder)
    rig_writer.write_rig(rig.measured, folder / "rig.toml")
    write_json(_known(rig), folder / "truth.json")
    write_atomically(_plan(found, rig), folder / "plan.toml")


def _known(rig: SimulatedRig) -> dict[str, object]:
    """What is true of the rig, but for the way of its frames through this computer."""
    arrives = rig.scene.free is not None and rig.scene.free.event == "arrival"
    return {name: value for name, value in truth(rig.scene).items() if not (arrives and name in _FROM_AN_EVENT)}


def _plan(found: ServedRig, rig: SimulatedRig) -> str:
    """A series that this rig can record, to be changed as one likes."""
    timing, speed = rig.scene.timing, found.bench.place.speed
    integrates = isinstance(timing, CameraTiming)
    devices = "".join(f'{name} = "{address}"\n' for name, address in found.bench.addresses.items())
    camera = f'[camera]\ntype = "{"photon" if integrates else "microbolometer"}"\n'
    camera += f'readout_mode = "{readout_mode_of(timing)}"\n'
    if rig.scene.free is not None:
        camera += f'frame_event = "{rig.scene.free.event}"\n'
    if isinstance(timing, CameraTiming):
        camera += f'integration_time = "{1e6 * timing.integration_time_s:g} us"\n'
    return "\n".join(
        [
            f"[devices]\n{devices}speed = {speed:g}   # seconds of the rig in one of yours; leave it out on a real rig\n",
            camera,
            f"[series]\nwheel_hz = {[3, 9] if integrates else [3]}\nframe_hz = 30.303\nsamples = 1000\n",
            f'[blackbody]\ntemperature = "{rig.scene.radiance.blackbody_k:g} K"\n',
            *([_references(found, rig)] if integrates else []),
        ]
    )


def _references(found: ServedRig, rig: SimulatedRig) -> str:
    program, radiance = Path(sys.executable).with_name("irtiming"), rig.scene.radiance
    return (
        "[references]   # of the bare blackbody: the command takes wheel and mask out of the way, and brings them back\n"
        f'low = "{radiance.reference_low_k:g} K"\nhigh = "{radiance.reference_high_k:g} K"\nframes = 50\n'
        f'command = "{program} rig --console {found.console} --tell"\n'
    )
