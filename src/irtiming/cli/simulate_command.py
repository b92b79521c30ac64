"""`irtiming simulate`: recordings of a simulated camera on a simulated rig, with the truth beside them."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, final

import typer

from irtiming.cli.progress import Told, shown
from irtiming.errors import ArchiveError, PlanError
from irtiming.units import seconds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from irtiming.records.recording import Recording
    from irtiming.records.rig import Rotation
    from irtiming.twin.rig import SimulatedRig
    from irtiming.twin.scene import Scene

OutDir = Annotated[Path, typer.Argument(help="Folder for the recordings; made if it is not there.")]
Camera = Annotated[Literal["photon"], typer.Option(help="Kind of camera.")]
Rows = Annotated[int, typer.Option(min=16, max=4096, help="Pixels down the image.")]
Columns = Annotated[int, typer.Option(min=16, max=4096, help="Pixels across the image.")]
Delays = Annotated[list[str] | None, typer.Option("--delay", help="Extra trigger delay, such as '25 ms'; repeatable.")]
WheelRates = Annotated[list[float] | None, typer.Option("--wheel-hz", help="Wheel rate in Hz; repeatable.")]
FrameRate = Annotated[float, typer.Option(help="Frame rate to come near to, in Hz.")]
Runs = Annotated[int, typer.Option(min=1, help="Runs for each delay and wheel rate.")]
Frames = Annotated[int, typer.Option(min=1, help="Triggers in a run, and samples per turn of the wheel.")]
Integration = Annotated[str, typer.Option("--integration-time", help="Integration time, such as '250 us'.")]
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
    frame_hz: float
    frames: int
    runs: int
    seed: int


def simulate(
    out_dir: OutDir,
    camera: Camera = "photon",
    rows: Rows = 512,
    columns: Columns = 640,
    delay: Delays = None,
    wheel_hz: WheelRates = None,
    frame_hz: FrameRate = 30.303,
    runs: Runs = 1,
    frames: Frames = 1000,
    integration_time: Integration = "250 us",
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
    from irtiming.twin.scene import paper_scene

    nominal = paper_scene(rows, columns)
    rotation: Rotation = "counterclockwise" if counterclockwise else "clockwise"
    nominal = replace(
        nominal,
        wheel=replace(nominal.wheel, rotation=rotation),
        optics=replace(nominal.optics, blur_px=blur_px, distortion=distortion),
        timing=replace(nominal.timing, integration_time_s=_positive(integration_time)),
        faults=replace(nominal.faults, lost_frames=lost_frames),
    )
    if lost_frames >= frames:
        raise PlanError(f"{lost_frames} lost frames of {frames} were asked for; at least one must be left")
    rig = draw(nominal, seed=seed)
    if mask_offset_mm is not None:
        mask = replace(rig.scene.mask, centre_x_m=mask_offset_mm * 1e-3, centre_y_m=0.0)
        rig = replace(rig, scene=replace(rig.scene, mask=mask))
    wanted = _Series(
        delays_s=[seconds(text) for text in delay or ["0 ms"]],
        wheel_rates_hz=wheel_hz or [3.0],
        frame_hz=frame_hz,
        frames=frames,
        runs=runs,
        seed=seed,
    )
    files = _write_all(rig, wanted, out_dir)
    if json is not None:
        write_result({"camera": camera, "seed": seed, **files}, json)


def _positive(text: str) -> float:
    """Time in seconds that cannot be zero."""
    time_s = seconds(text)
    if not 0 < time_s < 1:
        raise PlanError(f"an integration time of '{text}' was asked for; it must lie between 0 and 1 s")
    return time_s


def _write_all(rig: "SimulatedRig", wanted: _Series, out_dir: Path) -> dict[str, object]:
    """Write every run, the rig and the truth; return where they are."""
    from rich.console import Console

    from irtiming.archive import rig_file, writer
    from irtiming.archive.result_file import write_result
    from irtiming.twin.rig import truth

    scenes = _scenes(rig.scene, wanted)
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


def _share_of(told: Told, name: str, *, before: int, total: int) -> "Callable[[int, int], None]":
    """Progress of one file as a part of all files."""
    return lambda done, _: told(name, before + done, total)


def _scenes(scene: "Scene", wanted: _Series) -> "list[Scene]":
    """The same rig at each wheel rate."""
    from irtiming.twin.scene import with_wheel_speed

    return [
        with_wheel_speed(scene, rate_hz, frame_hz=wanted.frame_hz, samples=wanted.frames)
        for rate_hz in wanted.wheel_rates_hz
    ]


def _recordings(scenes: "list[Scene]", wanted: _Series) -> "Iterator[Recording]":
    """Every run, speed by speed."""
    from irtiming.twin.rig import series

    for index, scene in enumerate(scenes):
        yield from series(scene, wanted.delays_s, repeats=wanted.runs, seed=wanted.seed + 1_000_003 * index)
