"""`irtiming plan`: from wishes to the trigger schemes that meet them, as a table, a drawing and JSON."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from irtiming.cli.options import filled, in_options
from irtiming.errors import PlanError, listed
from irtiming.plan.wishes import exact_number, whole_number
from irtiming.records.recording import CameraType, ReadoutMode


@in_options
def plan(
    wanted: Annotated[
        list[str] | None,
        typer.Option("--for", metavar="PARAMETER=U", help="What to know, and how well (k = 1): 'trigger_delay=0.5us'."),
    ] = None,
    clock_hz: Annotated[str | None, typer.Option(help="Frequency of the trigger generator's clock; whole Hz.")] = None,
    wheel_hz: Annotated[
        list[str] | None,
        typer.Option(help="Wheel rate in Hz; repeat it for several. With --for: those to choose from."),
    ] = None,
    frame_hz: Annotated[str | None, typer.Option(help="Frame rate in Hz: 30.303, or exactly 1000/33.")] = None,
    samples: Annotated[str | None, typer.Option(help="Samples per turn of the wheel.")] = None,
    frame_hz_exact: Annotated[bool, typer.Option("--frame-hz-exact", help="No other frame rate will do.")] = False,
    frame_hz_min: Annotated[str | None, typer.Option(help="Lowest frame rate of the camera in Hz.")] = None,
    frame_hz_max: Annotated[str | None, typer.Option(help="Highest frame rate of the camera in Hz.")] = None,
    samples_min: Annotated[str | None, typer.Option(help="Fewest samples; with an exact frame rate half.")] = None,
    samples_max: Annotated[str | None, typer.Option(help="Most samples; with an exact frame rate double.")] = None,
    tolerance: Annotated[str, typer.Option(help="Limits of every wish that has none of its own.")] = "1%",
    wheel_tolerance: Annotated[str | None, typer.Option(help="Tolerance of the wheel rate; 0 is exact.")] = None,
    control_slots: Annotated[str, typer.Option(help="Slots of the ring that controls the wheel.")] = "100",
    between_corrections: Annotated[
        str | None,
        typer.Option(help="Longest time between two non-uniformity corrections, such as '20 min'."),
    ] = None,
    delay: Annotated[list[str] | None, typer.Option(help="Extra trigger delay, such as '25 ms'; repeatable.")] = None,
    repeats: Annotated[str, typer.Option(help="Runs for each wheel speed and delay; --for finds them itself.")] = "1",
    rig: Annotated[Path | None, typer.Option(help="With --for: rig.toml, for the uncertainties of its angles.")] = None,
    camera: Annotated[
        CameraType | None,
        typer.Option(help="With --for: kind of camera; photon if not given."),
    ] = None,
    readout: Annotated[
        ReadoutMode | None, typer.Option(help="With --for: its readout; as usual for the kind of camera if not given.")
    ] = None,
    noise: Annotated[
        float | None, typer.Option(help="With --for: noise of a pixel in K, or in DN as --contrast.")
    ] = None,
    contrast: Annotated[float | None, typer.Option(help="With --for: blackbody minus wheel in K, or in DN.")] = None,
    opening_pixels: Annotated[float | None, typer.Option(help="With --for: pixels within the mask opening.")] = None,
    integration_time: Annotated[
        str | None, typer.Option(help="With --for: of a photon camera, such as '250 us'.")
    ] = None,
    known_integration_time: Annotated[
        bool, typer.Option("--known-integration-time", help="With --for: it is exact and need not be found.")
    ] = False,
    time_constant: Annotated[
        str | None, typer.Option(help="With --for: of a microbolometer, roughly, such as '5 ms'.")
    ] = None,
    row_delay: Annotated[
        str | None, typer.Option(help="With --for: of a rolling camera, roughly, such as '20 us'.")
    ] = None,
    like: Annotated[
        Path | None, typer.Option(metavar="RESULT", help="With --for: take the camera from this result JSON.")
    ] = None,
    free_running: Annotated[
        str | None,
        typer.Option(
            metavar="PERIOD",
            help="Period of a camera that runs free, such as '33.3 ms': wheel speeds near --wheel-hz at which its frames, "
            "--samples in a run, visit all angles evenly.",
        ),
    ] = None,
    most: Annotated[int, typer.Option(min=1, max=10_000, help="Rows of the table.")] = 10,
    json: Annotated[Path | None, typer.Option(help="Write all schemes and the plan to this file.")] = None,
    picture: Annotated[Path | None, typer.Option(help="Draw the sampling order of the best to this SVG.")] = None,
) -> None:
    """Find every trigger scheme that meets the wishes, best first.

    With --for: the shortest measurements that should reach an uncertainty, whatever wheel speeds and runs that takes. Clock,
    frame rate and samples are then those of the paper if not given, and the wheel may turn at 2 to 50 Hz. With --free-running:
    wheel speeds for a camera that takes no triggers, and the uncertainty to expect of a run at each.
    """
    given = locals()
    if free_running is not None:
        _of_free_camera(given)
        return
    from irtiming.cli.plan_tables import show
    from irtiming.records.series_plan import TriggerWishes
    from irtiming.session.camera import Described
    from irtiming.session.plan import PlanOrder
    from irtiming.session.plan import plan as make_plan

    wishes = filled(
        TriggerWishes,
        given,
        wheel_hz=tuple(wheel_hz or ()),
        frame_hz=frame_hz or "",
        samples=samples or "",
        frame_hz_limits=(frame_hz_min, frame_hz_max),
        samples_limits=(samples_min, samples_max),
        delays=tuple(delay or ()),
    )
    order = filled(PlanOrder, given, wishes=wishes, camera=filled(Described, given))
    show(make_plan(order), most=most)


_OF_TRIGGERS = (
    "wanted", "clock_hz", "frame_hz", "frame_hz_min", "frame_hz_max", "samples_min", "samples_max", "wheel_tolerance",
    "between_corrections", "delay", "picture",
)  # fmt: skip


def _of_free_camera(given: Mapping[str, Any]) -> None:
    """Wheel speeds for a camera that runs free."""
    from irtiming.cli.plan_tables import show_free
    from irtiming.session.camera import Described
    from irtiming.session.free_plan import USUAL_HZ, FreePlanOrder
    from irtiming.session.free_plan import plan as make_free_plan

    if foreign := [name for name in _OF_TRIGGERS if given[name]]:
        raise PlanError(
            f"{listed(foreign)} with {{free_running}}, which has no triggers to plan; leave out {listed(foreign)}",
            *foreign,
            "free_running",
        )
    order = filled(
        FreePlanOrder,
        given,
        camera=filled(Described, given),
        samples=1000 if given["samples"] is None else whole_number(given["samples"], "the number of samples"),
        wheel_hz=tuple(float(exact_number(text, "the wheel rate")) for text in given["wheel_hz"] or ()) or USUAL_HZ,
        tolerance=1e-4,
    )
    show_free(make_free_plan(order), most=given["most"])
