"""`irtiming simulate`: recordings of a simulated camera on a simulated rig, with the truth beside them."""

import math
from pathlib import Path
from typing import Annotated, Literal

import typer

from irtiming.cli.options import filled, in_options
from irtiming.cli.screen import say
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.twin.optics import GlareShape
from irtiming.units import counted

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
Runs = Annotated[int, typer.Option(min=1, max=1000, help="Runs for each delay and wheel rate.")]
Frames = Annotated[int, typer.Option(min=1, max=2**20, help="Triggers in a run, and samples per turn of the wheel.")]
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
        max=10_000,
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
SerialNumber = Annotated[
    str, typer.Option(metavar="TEXT", help="What the camera calls itself; left out: made of its seed.")
]
InternalDelay = Annotated[
    str | None,
    typer.Option(metavar="TIME", help="Delay set in the camera itself, on top of its own, such as '50 us'."),
]
Seed = Annotated[
    int, typer.Option(min=0, max=2**63 - 1, help="Draws rig and runs; the same seed gives the same files.")
]
Blur = Annotated[float, typer.Option(min=0, max=20, help="Optical blur in pixels, standard deviation.")]
Counterclockwise = Annotated[bool, typer.Option("--counterclockwise", help="Mirror the rig: wheel, gates and image.")]
Distortion = Annotated[float, typer.Option(min=-0.2, max=0.2, help="Radial distortion at the image corner, relative.")]
MaskOffset = Annotated[float | None, typer.Option("--mask-offset-mm", help="Mask centre this far right of the axle.")]
Roll = Annotated[
    float,
    typer.Option(
        "--roll-deg", min=-180, max=180, help="Camera turned about its axis, clockwise angles of its image grow by it."
    ),
]
FreeRunning = Annotated[
    Literal["strobe", "stamp", "arrival"] | None,
    typer.Option(help="A camera that runs free instead of a triggered one, and what its frames' delays count from."),
]
LostFrames = Annotated[int, typer.Option(min=0, help="Frames lost in each run.")]
LateApplication = Annotated[
    str | None, typer.Option("--late-application-gate", help="How late its edges are timestamped, such as '5 us'.")
]
LateControl = Annotated[str | None, typer.Option("--late-control-gate", help="Likewise.")]
LateTrigger = Annotated[
    str | None, typer.Option("--late-trigger", help="How much later than its timestamp a trigger is at the camera.")
]
ClockPpm = Annotated[float, typer.Option(help="By how many millionths the trigger generator's clock is too fast.")]
LateralOffset = Annotated[
    float,
    typer.Option("--lateral-offset-mm", help="Middle of the beams beside the vertical, towards the control beam."),
]
Tilt = Annotated[
    tuple[float, float],
    typer.Option(
        "--tilt-deg", help="Tilt of the camera about a line along a row and one along a column.", metavar="ROW COLUMN"
    ),
]
FocalLength = Annotated[float, typer.Option("--focal-length-px", min=1, help="Distance of a tilted camera, in pixels.")]
LensCentre = Annotated[
    tuple[float, float],
    typer.Option(
        "--lens-centre-px", help="Lens's axis from the middle of the image, down and right.", metavar="DOWN RIGHT"
    ),
]
BlurRows = Annotated[float | None, typer.Option(min=0, max=20, help="Blur from row to row, if not --blur-px.")]
BlurColumns = Annotated[float | None, typer.Option(min=0, max=20, help="Blur from column to column, if not --blur-px.")]
BlurTurn = Annotated[
    float, typer.Option("--blur-turn-deg", min=-90, max=90, help="Both axes of that turned, from right to down.")
]
BlurGrowth = Annotated[
    float,
    typer.Option(min=-0.9, max=20, help="By which share the blur's variance is larger in the corners of the image."),
]
Glare = Annotated[float | None, typer.Option("--glare", help="Share of the light that goes astray, such as 0.03.")]
GlarePx = Annotated[float | None, typer.Option(help="How far, standard deviation in pixels; 6 if not given.")]
Shape = Annotated[GlareShape | None, typer.Option(help="How it falls off; exponential if not given.")]
Blade = Annotated[
    float | None, typer.Option("--blade", help="Share of the contrast by which one blade is warmer than the other.")
]
Sway = Annotated[
    float | None, typer.Option("--sway", help="Share of the contrast by which gain and offset go up and down in 33 s.")
]
ReferencesAnew = Annotated[bool, typer.Option("--references-anew", help="References of their own for each recording.")]
Exponent = Annotated[
    float, typer.Option(min=0.5, max=2, help="Of the camera's response to light, such as 0.9; 1 is a straight line.")
]
Filter = Annotated[
    float | None,
    typer.Option("--filter", help="Share of the frame before in the camera's recursive filter, such as 0.06."),
]
Averaged = Annotated[int | None, typer.Option(min=1, help="Each frame is the mean of so many, itself the last.")]
Memory = Annotated[float | None, typer.Option("--memory", help="Share of the frame before that pixels keep.")]
Rise = Annotated[str | None, typer.Option(help="Time in which the integration window opens, such as '10 us'.")]
Fall = Annotated[str | None, typer.Option(help="Time in which it closes.")]
Tail = Annotated[float | None, typer.Option("--tail", help="Share of the window that comes after its end.")]
TailTime = Annotated[str | None, typer.Option("--tail-time", help="Time in which that fades; 0.3 ms if not given.")]
CountTimeError = Annotated[
    str | None, typer.Option(help="How much longer an integration time the camera states than it has; may be negative.")
]
Laboratory = Annotated[
    bool,
    typer.Option("--laboratory", help="Draw all defects at random; rig.toml states what their owner knows."),
]
Json = Annotated[Path | None, typer.Option("--json", help="Write the list of files there.", metavar="OUT")]


_FIELDS = {
    "clock_ppm": ("clock_relative_error",),
    "lateral_offset_mm": ("lateral_offset_m",),
    "tilt_deg": ("tilt_about_row_rad", "tilt_about_column_rad"),
    "lens_centre_px": ("lens_centre_row_px", "lens_centre_column_px"),
    "blur_turn_deg": ("blur_turn_rad",),
}
"""Of `Defects`, that options give whose names are not theirs."""


@in_options
def simulate(
    context: typer.Context,
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
    serial_number: SerialNumber = "",
    internal_delay: InternalDelay = None,
    reference_frames: References = None,
    seed: Seed = 1,
    blur_px: Blur = 0.7,
    counterclockwise: Counterclockwise = False,
    distortion: Distortion = 0.0,
    mask_offset_mm: MaskOffset = None,
    roll_deg: Roll = 0.0,
    lost_frames: LostFrames = 0,
    free_running: FreeRunning = None,
    late_application_gate: LateApplication = None,
    late_control_gate: LateControl = None,
    late_trigger: LateTrigger = None,
    clock_ppm: ClockPpm = 0.0,
    lateral_offset_mm: LateralOffset = 0.0,
    tilt_deg: Tilt = (0.0, 0.0),
    focal_length_px: FocalLength = 1000.0,
    lens_centre_px: LensCentre = (0.0, 0.0),
    blur_rows_px: BlurRows = None,
    blur_columns_px: BlurColumns = None,
    blur_turn_deg: BlurTurn = 0.0,
    blur_growth: BlurGrowth = 0.0,
    glare_share: Glare = None,
    glare_px: GlarePx = None,
    glare_shape: Shape = None,
    blade_share: Blade = None,
    sway_share: Sway = None,
    references_anew: ReferencesAnew = False,
    exponent: Exponent = 1.0,
    filter_share: Filter = None,
    averaged_frames: Averaged = None,
    memory_share: Memory = None,
    rise: Rise = None,
    fall: Fall = None,
    tail_share: Tail = None,
    tail: TailTime = None,
    count_time_error: CountTimeError = None,
    laboratory: Laboratory = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace recordings of those names, rig.toml and truth.json.")
    ] = False,
    json: Json = None,
) -> None:
    """Simulate a measurement: recordings, rig.toml and truth.json.

    Wheel, beams, mask and optics get random imperfections; rig.toml tells them as a person would have measured
    them, truth.json as they are. Defects that a laboratory has are options, none by default; rig.toml does not tell
    them, unless --laboratory draws them.
    """
    given = locals()
    from irtiming.archive.json_file import write_json
    from irtiming.archive.suffixes import require_suffix
    from irtiming.cli.progress import shown
    from irtiming.session.simulation import CameraOrder, SimulationOrder
    from irtiming.session.simulation import simulate as make_recordings
    from irtiming.twin.defects import Defects

    typed = {
        name for name in context.params if getattr(context.get_parameter_source(name), "name", "") == "COMMANDLINE"
    }
    defects = filled(
        Defects,
        {**given, "distortion": None},  # always that of the lens
        clock_relative_error=clock_ppm * 1e-6,
        lateral_offset_m=lateral_offset_mm * 1e-3,
        tilt_about_row_rad=math.radians(tilt_deg[0]),
        tilt_about_column_rad=math.radians(tilt_deg[1]),
        lens_centre_row_px=lens_centre_px[0],
        lens_centre_column_px=lens_centre_px[1],
        blur_turn_rad=math.radians(blur_turn_deg),
    )
    order = filled(
        SimulationOrder,
        given,
        folder=out_dir,
        camera=filled(CameraOrder, given),
        defects=defects,
        rotation="counterclockwise" if counterclockwise else "clockwise",
        roll_rad=math.radians(roll_deg),
        mask_offset_m=None if mask_offset_mm is None else mask_offset_mm * 1e-3,
        asked=frozenset(field for name in typed for field in _FIELDS.get(name, (name, f"{name}_s"))),
    )
    if json is not None:
        require_suffix(json, "JSON")
    with shown("frames") as progress:
        made = make_recordings(order, progress=progress)
    say(f"{counted(len(made.recordings), 'recording')}, rig.toml and truth.json in {out_dir}")
    if json is not None:
        write_json({"camera": camera, "seed": seed, **vars(made)}, json)
