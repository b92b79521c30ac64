"""``irtiming analyse``: recordings in, table, result JSON and report page out."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from irtiming.errors import EstimationError, UnitError
from irtiming.records.reduced import Choices, Method, ReferenceEdge
from irtiming.units import kelvin

if TYPE_CHECKING:
    from irtiming.records.recording import Recording

_SLOPE_LIMITS = "0.05,0.95"


def analyse(
    recording: Annotated[list[Path], typer.Argument(help="Recordings of one camera on one rig, in any order.")],
    rig: Annotated[Path, typer.Option(help="What was measured on the rig (rig.toml).")],
    json: Annotated[Path | None, typer.Option(metavar="OUT", help="Write the result as JSON.")] = None,
    report: Annotated[Path | None, typer.Option(metavar="OUT", help="Write the report as one HTML page.")] = None,
    method: Annotated[
        Method,
        typer.Option(
            help="The default is the best for the kind of camera: pixel sums, of a microbolometer row sums; published "
            "is the procedure of Schatz 2023 step by step."
        ),
    ] = "pixel-sum",
    roi: Annotated[
        str | None, typer.Option(metavar="R0,R1,C0,C1", help="Region of interest; ends excluded. Else automatic.")
    ] = None,
    threshold_dn: Annotated[
        float | None, typer.Option(help="Threshold, corrected DN; photon cameras only. Else automatic.")
    ] = None,
    threshold_level: Annotated[
        float,
        typer.Option(help="Place of the threshold between the histogram peaks, 0 covered .. 1 open."),
    ] = 0.5,
    border_px: Annotated[
        int | None,
        typer.Option(min=0, max=64, help="Border of the summed region around the opening, px. Else automatic."),
    ] = None,
    plateau_margin: Annotated[
        float,
        typer.Option(help="Share of a plateau's width kept away from each of its corners; photon cameras only."),
    ] = 0.15,
    slope_limits: Annotated[
        str,
        typer.Option(metavar="LOW,HIGH", help="Opening fractions that lines are fitted to; photon cameras only."),
    ] = _SLOPE_LIMITS,
    reference_edge: Annotated[
        ReferenceEdge,
        typer.Option(help="Which application edge is the angle zero; automatic: before the longer half turn."),
    ] = "automatic",
    substrate_temperature: Annotated[
        str | None,
        typer.Option(
            metavar="KELVIN",
            help="Of a microbolometer's detector substrate, such as '303 K': separates the constants of substrate and scene.",
        ),
    ] = None,
    wheel_temperature: Annotated[
        str | None,
        typer.Option(metavar="KELVIN", help="What the solid wheel looks like, for the same. Else from the contrast."),
    ] = None,
    wheel_calibration: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Slots of the same wheel, from irtiming calibrate-wheel, taken together with these."
        ),
    ] = None,
) -> None:
    """Timing of a camera from its recordings, with uncertainties.

    Of a snapshot photon camera the trigger delay; of a rolling microbolometer camera trigger delay, time constant and row
    delay. Every choice is made automatically and shown in the report; the options take it over.
    """
    from rich.console import Console

    from irtiming.archive import reader, result_file, rig_file
    from irtiming.archive.wheel_calibration_file import read_wheel_calibration
    from irtiming.cli.progress import shown
    from irtiming.cli.result_table import print_result
    from irtiming.measurement import analyse as run_analysis
    from irtiming.report import certificate

    choices = Choices(
        method=method,
        roi=_region(roi),
        threshold_dn=threshold_dn,
        threshold_level=_between(threshold_level, 0.05, 0.95, "--threshold-level"),
        border_px=border_px,
        plateau_margin=_between(plateau_margin, 0.0, 0.45, "--plateau-margin"),
        slope_limits=_limits(slope_limits),
        reference_edge=reference_edge,
        substrate_temperature_k=None if substrate_temperature is None else kelvin(substrate_temperature),
        wheel_temperature_k=None if wheel_temperature is None else kelvin(wheel_temperature),
    )
    if wheel_temperature is not None and substrate_temperature is None:
        raise UnitError(
            "--wheel-temperature is of use with --substrate-temperature only; give that too, or leave it out"
        )
    inputs = [*recording, rig, *([wheel_calibration] if wheel_calibration else [])]
    if json is not None:
        result_file.require_place(json, besides=inputs)
    if report is not None:
        result_file.require_place(report, besides=[*inputs, *([json] if json else [])])
    owner = rig_file.read_rig(rig)
    wheel = None if wheel_calibration is None else read_wheel_calibration(wheel_calibration)
    with shown("frames") as told:
        analysis = run_analysis(
            _of_use((reader.read(path) for path in recording), choices),
            owner,
            choices=choices,
            progress=told,
            wheel_calibration=wheel,
        )
    found = certificate.report(analysis)
    if json is not None:
        result_file.write_result(found.result, json)
    if report is not None:
        result_file.write_atomically(found.page, report)
    print_result(analysis, Console())


def _of_use(recordings: "Iterator[Recording]", choices: Choices) -> "Iterator[Recording]":
    """The recordings; a choice that means nothing for their kind of camera is refused."""
    default = Choices()
    given = [
        option
        for option, asked in (
            ("--threshold-dn", choices.threshold_dn != default.threshold_dn),
            ("--plateau-margin", choices.plateau_margin != default.plateau_margin),
            ("--slope-limits", choices.slope_limits != default.slope_limits),
        )
        if asked
    ]
    for recording in recordings:
        if given and recording.camera_type == "microbolometer":
            raise _foreign(given, recording.name)
        if choices.substrate_temperature_k is not None and recording.camera_type != "microbolometer":
            raise EstimationError(
                f"--substrate-temperature with {recording.name}, the recording of a photon camera, which has no time constants; "
                "leave it out"
            )
        yield recording


def _foreign(given: Sequence[str], name: str) -> EstimationError:
    return EstimationError(
        f"{', '.join(given)} with {name}, the recording of a microbolometer camera, which is analysed without threshold "
        f"values, plateaus and straight slopes; leave {'them' if len(given) > 1 else 'it'} out"
    )


def _numbers(text: str, n: int, option: str) -> list[float]:
    parts = text.split(",")
    try:
        values = [float(part) for part in parts]
    except ValueError:
        values = []
    if len(values) != n:
        raise UnitError(f"{option} is '{text}', must be {n} numbers with commas between them")
    return values


def _region(text: str | None) -> tuple[int, int, int, int] | None:
    if text is None:
        return None
    a, b, c, d = (int(value) for value in _numbers(text, 4, "--roi"))
    return a, b, c, d


def _between(value: float, low: float, high: float, option: str) -> float:
    if not low <= value <= high:
        raise UnitError(f"{option} is {value}, must lie between {low} and {high}")
    return value


def _limits(text: str) -> tuple[float, float]:
    low, high = _numbers(text, 2, "--slope-limits")
    if not 0 < low < high < 1:
        raise UnitError(f"--slope-limits is {text}, must be two fractions with 0 < LOW < HIGH < 1")
    return low, high
