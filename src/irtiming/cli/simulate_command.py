"""`irtiming simulate`: recordings of a simulated camera on a simulated rig, with the truth beside them."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, final

import typer

from irtiming.cli.progress import Told, shown
from irtiming.errors import ArchiveError, PlanError
from irtiming.records.recording import USUAL_READOUT, CameraType, ReadoutMode
from irtiming.units import kelvin, readable_time, seconds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from irtiming.records.recording import Recording
    from irtiming.records.rig import Rotation
    from irtiming.twin.rig import SimulatedRig
    from irtiming.twin.scene import Scene, Timing

_SHORTEST_S = 1e-6
_STEEPEST_DRIFT = 1000.0  # DN per second

OutDir = Annotated[Path, typer.Argument(help="Folder for the recordings; made if it is not there.")]
Camera = Annotated[
    CameraType, typer.Option(help="What its pixels do: integrate over a window, or follow the scene with a lag.")
]
Readout = Annotated[
    ReadoutMode | None,
    typer.Option(help="All rows at once or one after the other; snapshot if not given, of a microbolometer rolling."),
]
Rows = Annotated[
    int | None, typer.Option(min=16, max=4096, help="Pixels down the image: 512, of a microbolometer 480.")
]
Columns = Annotated[int, typer.Option(min=16, max=4096, help="Pixels across the image.")]
Delays = Annotated[list[str] | None, typer.Option("--delay", help="Extra trigger delay, such as '25 ms'; repeatable.")]
WheelRates = Annotated[list[float] | None, typer.Option("--wheel-hz", help="Wheel rate in Hz; repeatable.")]
FrameRate = Annotated[float, typer.Option(help="Frame rate to come near to, in Hz.")]
Runs = Annotated[int, typer.Option(min=1, help="Runs for each delay and wheel rate.")]
Frames = Annotated[int, typer.Option(min=1, help="Triggers in a run, and samples per turn of the wheel.")]
Integration = Annotated[
    str | None, typer.Option("--integration-time", help="Integration time of a photon camera; 250 us if not given.")
]
TriggerDelay = Annotated[
    str | None, typer.Option("--trigger-delay", help="The camera's own delay, such as '3.9 ms'; else drawn at random.")
]
TimeConstant = Annotated[
    str | None, typer.Option("--time-constant", help="Lag of a microbolometer, such as '6 ms'; else drawn at random.")
]
SceneTimeConstant = Annotated[
    str | None,
    typer.Option(
        help="Makes the pixels of a microbolometer exchange heat with the scene by Planck's law, with this constant at 300 K; "
        "--time-constant is then that of the substrate alone."
    ),
]
SubstrateTemperature = Annotated[
    str | None, typer.Option(help="Of the detector's substrate, for --scene-time-constant; 303.15 K if not given.")
]
BlackbodyTemperatures = Annotated[
    list[str] | None,
    typer.Option("--blackbody-temperature", help="Of a microbolometer's scene, such as '313 K'; repeatable."),
]
RowDelay = Annotated[
    str | None,
    typer.Option(
        "--row-delay",
        help="Between rows of a rolling camera: '38.76 us', or '-40 us' from the last row up; else drawn.",
    ),
]
References = Annotated[
    int | None,
    typer.Option(
        "--reference-frames",
        min=0,
        help="Of a photon camera at each reference temperature, 50 if not given; 0 records none.",
    ),
]
NucAt = Annotated[
    list[str] | None,
    typer.Option("--nuc-at", help="A microbolometer closes its shutter this long after the first trigger; repeatable."),
]
DriftRate = Annotated[
    float | None, typer.Option("--drift-dn-per-s", help="Drift of a microbolometer's values, DN per second.")
]
Seed = Annotated[int, typer.Option(min=0, help="Draws rig and runs; the same seed gives the same files.")]
Blur = Annotated[float, typer.Option(min=0, max=20, help="Optical blur in pixels, standard deviation.")]
Counterclockwise = Annotated[bool, typer.Option("--counterclockwise", help="Mirror the rig: wheel, gates and image.")]
Distortion = Annotated[float, typer.Option(min=-0.2, max=0.2, help="Radial distortion at the image corner, relative.")]
MaskOffset = Annotated[float | None, typer.Option("--mask-offset-mm", help="Mask centre this far right of the axle.")]
LostFrames = Annotated[int, typer.Option(min=0, help="Frames lost in each run.")]
Json = Annotated[Path | None, typer.Option("--json", help="Write the list of files there.", metavar="OUT")]


@final
@dataclass(frozen=True, kw_only=True)
class _Series:
    """Runs to make."""

    delays_s: list[float]
    wheel_rates_hz: list[float]
    blackbodies_k: list[float]
    frame_hz: float
    frames: int
    runs: int
    seed: int


@final
@dataclass(frozen=True, kw_only=True)
class _Asked:
    """What the user wants of the camera, as it was typed; None where nothing was said."""

    camera: CameraType
    readout: ReadoutMode
    integration_time: str | None
    reference_frames: int | None
    trigger_delay: str | None
    time_constant: str | None
    scene_time_constant: str | None
    substrate_temperature: str | None
    blackbody_temperature: tuple[str, ...]
    row_delay: str | None
    nuc_at: tuple[str, ...]
    drift_dn_per_s: float | None

    def refuse_foreign(self) -> None:
        """Refuse options that make no sense for this kind of camera."""
        photons: dict[str, object] = {
            "--integration-time": self.integration_time,
            "--reference-frames": self.reference_frames,
        }
        lags: dict[str, object] = {
            "--time-constant": self.time_constant,
            "--scene-time-constant": self.scene_time_constant,
            "--substrate-temperature": self.substrate_temperature,
            "--blackbody-temperature": self.blackbody_temperature or None,
            "--nuc-at": self.nuc_at or None,
            "--drift-dn-per-s": self.drift_dn_per_s,
        }
        rows: dict[str, object] = {"--row-delay": self.row_delay}
        other = "--camera microbolometer" if self.camera == "photon" else "--camera photon"
        _refuse(lags if self.camera == "photon" else photons, f"--camera {self.camera}", other)
        if self.readout == "snapshot":
            _refuse(rows, f"--camera {self.camera} --readout snapshot", "--readout rolling")


def _refuse(foreign: dict[str, object], camera: str, other: str) -> None:
    """Refuse options that were given and that this camera has no use for."""
    given = [option for option, value in foreign.items() if value is not None]
    if given:
        raise PlanError(
            f"{', '.join(given)} with {camera}, which has no such thing; leave out {given[0]}, or take {other}"
        )


def simulate(
    out_dir: OutDir,
    camera: Camera = "photon",
    readout: Readout = None,
    rows: Rows = None,
    columns: Columns = 640,
    delay: Delays = None,
    wheel_hz: WheelRates = None,
    frame_hz: FrameRate = 30.303,
    runs: Runs = 1,
    frames: Frames = 1000,
    integration_time: Integration = None,
    trigger_delay: TriggerDelay = None,
    time_constant: TimeConstant = None,
    scene_time_constant: SceneTimeConstant = None,
    substrate_temperature: SubstrateTemperature = None,
    blackbody_temperature: BlackbodyTemperatures = None,
    row_delay: RowDelay = None,
    nuc_at: NucAt = None,
    drift_dn_per_s: DriftRate = None,
    reference_frames: References = None,
    seed: Seed = 1,
    blur_px: Blur = 0.7,
    counterclockwise: Counterclockwise = False,
    distortion: Distortion = 0.0,
    mask_offset_mm: MaskOffset = None,
    lost_frames: LostFrames = 0,
    json: Json = None,
) -> None:
    """Simulate a measurement: recordings, rig.toml and truth.json.

    Wheel, beams, mask and optics get random imperfections; rig.toml tells them as a person would have measured
    them, truth.json as they are.
    """
    from irtiming.archive.result_file import write_result
    from irtiming.twin.rig import draw

    asked = _Asked(
        camera=camera,
        readout=readout or USUAL_READOUT[camera],
        integration_time=integration_time,
        reference_frames=reference_frames,
        trigger_delay=trigger_delay,
        time_constant=time_constant,
        scene_time_constant=scene_time_constant,
        substrate_temperature=substrate_temperature,
        blackbody_temperature=tuple(blackbody_temperature or ()),
        row_delay=row_delay,
        nuc_at=tuple(nuc_at or ()),
        drift_dn_per_s=drift_dn_per_s,
    )
    nominal = _nominal(asked, rows, columns)
    rotation: Rotation = "counterclockwise" if counterclockwise else "clockwise"
    nominal = replace(
        nominal,
        wheel=replace(nominal.wheel, rotation=rotation),
        optics=replace(nominal.optics, blur_px=blur_px, distortion=distortion),
        faults=replace(nominal.faults, lost_frames=lost_frames),
    )
    if lost_frames >= frames:
        raise PlanError(f"{lost_frames} lost frames of {frames} were asked for; at least one must be left")
    rig = draw(nominal, seed=seed)
    rig = replace(rig, scene=replace(rig.scene, timing=_stated(rig.scene.timing, asked)))
    if mask_offset_mm is not None:
        mask = replace(rig.scene.mask, centre_x_m=mask_offset_mm * 1e-3, centre_y_m=0.0)
        rig = replace(rig, scene=replace(rig.scene, mask=mask))
    wanted = _Series(
        delays_s=[seconds(text) for text in delay or ["0 ms"]],
        wheel_rates_hz=wheel_hz or [3.0],
        blackbodies_k=[kelvin(text) for text in blackbody_temperature or ()],
        frame_hz=frame_hz,
        frames=frames,
        runs=runs,
        seed=seed,
    )
    files = _write_all(rig, wanted, out_dir)
    if json is not None:
        write_result({"camera": camera, "seed": seed, **files}, json)


def _nominal(asked: _Asked, rows: int | None, columns: int) -> "Scene":
    """Scene of the paper for this kind of camera, with what was asked for that is never drawn."""
    from irtiming.twin.cameras import camera_scene
    from irtiming.twin.upkeep import Drift, SelfCorrection, ShutterEvent

    asked.refuse_foreign()
    scene = camera_scene(asked.camera, asked.readout, rows=rows, columns=columns)
    if asked.reference_frames is not None:
        scene = replace(scene, radiance=replace(scene.radiance, reference_frames=asked.reference_frames))
    drift = asked.drift_dn_per_s or 0.0
    if not abs(drift) <= _STEEPEST_DRIFT:
        raise PlanError(f"a drift of {drift} DN per second was asked for; it must lie within +-{_STEEPEST_DRIFT:g}")
    events = tuple(ShutterEvent(start_s=start_s) for start_s in sorted(seconds(text) for text in asked.nuc_at))
    return replace(scene, correction=SelfCorrection(events=events), drift=Drift(per_second_dn=drift))


def _stated(drawn: "Timing", asked: _Asked) -> "Timing":
    """The camera's timing, with what was asked for in place of what was drawn."""
    from irtiming.twin.scene import CameraTiming, RadiativeExchange

    if asked.trigger_delay is not None:
        delay_s = _between(asked.trigger_delay, "a trigger delay", lowest_s=0.0)
        drawn = replace(drawn, trigger_delay_s=delay_s)
    if asked.row_delay is not None:
        drawn = replace(drawn, row_delay_s=_between(asked.row_delay, "a row delay", lowest_s=-1.0))
    if isinstance(drawn, CameraTiming):
        integration_s = _between(asked.integration_time or "250 us", "an integration time", lowest_s=_SHORTEST_S)
        return replace(drawn, integration_time_s=integration_s)
    if asked.time_constant is not None:
        lag_s = _between(asked.time_constant, "a time constant", lowest_s=_SHORTEST_S)
        drawn = replace(drawn, time_constant_s=lag_s)
    if asked.scene_time_constant is not None:
        scene_s = _between(asked.scene_time_constant, "a scene time constant", lowest_s=_SHORTEST_S)
        substrate_k = kelvin(asked.substrate_temperature or "303.15 K")
        drawn = replace(drawn, radiative=RadiativeExchange(scene_time_constant_s=scene_s, substrate_k=substrate_k))
    elif asked.substrate_temperature is not None:
        raise PlanError(
            "--substrate-temperature is of use with --scene-time-constant only; give that too, or leave it out"
        )
    return drawn


def _between(text: str, what: str, *, lowest_s: float) -> float:
    """Time in seconds from the lowest that can be to one second."""
    time_s = seconds(text)
    if not lowest_s <= time_s <= 1:
        raise PlanError(f"{what} of '{text}' was asked for; it must lie between {readable_time(lowest_s)} and 1 s")
    return time_s


def _write_all(rig: "SimulatedRig", wanted: _Series, out_dir: Path) -> dict[str, object]:
    """Write every run, the rig and the truth; return where they are."""
    from rich.console import Console

    from irtiming.archive import rig_file, writer
    from irtiming.archive.result_file import write_result
    from irtiming.twin.rig import truth

    scenes = _scenes(rig.scene, wanted)
    for scene in scenes:
        _refuse_impossible(scene)
    try:
        out_dir.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(f"{out_dir} cannot be made ({error.strerror}); give another folder") from error
    rig_file.write_rig(rig.measured, out_dir / "rig.toml")
    write_result(truth(rig.scene), out_dir / "truth.json")
    recordings: list[str] = []
    n_frames = wanted.frames - rig.scene.faults.lost_frames
    all_frames = n_frames * len(scenes) * len(wanted.delays_s) * wanted.runs
    with shown("frames") as told:
        for recording in _recordings(scenes, wanted):
            path = out_dir / f"{recording.name}.nxs"
            progress = _share_of(told, str(out_dir), before=n_frames * len(recordings), total=all_frames)
            writer.write(recording, path, truth=truth(rig.scene), progress=progress)
            recordings.append(str(path))
    Console().print(
        f"{len(recordings)} recordings, rig.toml and truth.json in {out_dir}",
        markup=False,
        highlight=False,
        soft_wrap=True,
    )
    return {
        "recordings": recordings,
        "rig": str(out_dir / "rig.toml"),
        "truth": str(out_dir / "truth.json"),
    }


def _refuse_impossible(scene: "Scene") -> None:
    """Refuse rows that take longer than a frame, and a correction outside the run."""
    from irtiming.twin.readout import refuse_slow_readout

    refuse_slow_readout(scene)
    trigger = scene.trigger
    run_s = trigger.n_triggers * trigger.camera_period_ticks / trigger.clock_frequency_hz
    for event in scene.correction.events:
        if not -event.duration_s < event.start_s < run_s:
            raise PlanError(
                f"--nuc-at {readable_time(event.start_s)} lies outside the run of {readable_time(run_s)}; "
                "give a time within it, or more --frames"
            )


def _share_of(told: Told, name: str, *, before: int, total: int) -> "Callable[[int, int], None]":
    """Progress of one file as a part of all files."""
    return lambda done, _: told(name, before + done, total)


def _scenes(scene: "Scene", wanted: _Series) -> "list[Scene]":
    """The same rig at each wheel rate, before each blackbody."""
    from irtiming.twin.scene import with_wheel_speed

    return [
        replace(
            with_wheel_speed(scene, rate_hz, frame_hz=wanted.frame_hz, samples=wanted.frames),
            radiance=replace(scene.radiance, blackbody_k=blackbody_k),
        )
        for rate_hz in wanted.wheel_rates_hz
        for blackbody_k in wanted.blackbodies_k or [scene.radiance.blackbody_k]
    ]


def _recordings(scenes: "list[Scene]", wanted: _Series) -> "Iterator[Recording]":
    """Every run, speed by speed."""
    from irtiming.twin.rig import series

    for index, scene in enumerate(scenes):
        for run in series(scene, wanted.delays_s, repeats=wanted.runs, seed=wanted.seed + 1_000_003 * index):
            blackbody = f"-{scene.radiance.blackbody_k:g}K" if len(wanted.blackbodies_k) > 1 else ""
            yield replace(run, name=f"{run.name}{blackbody}")
