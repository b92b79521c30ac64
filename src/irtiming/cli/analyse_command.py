"""``irtiming analyse``: recordings in, table, result JSON and report page out."""

import math
from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import Edge, RigFile, filled, in_options
from irtiming.errors import UnitError
from irtiming.records.choices import Choices, Language, Method, Processor

_SLOPE_LIMITS = "0.05,0.95"


@in_options
def analyse(
    recording: Annotated[list[Path], typer.Argument(help="Recordings of one camera on one rig, in any order.")],
    rig: RigFile,
    json: Annotated[Path | None, typer.Option(metavar="OUT", help="Write the result as JSON.")] = None,
    report: Annotated[Path | None, typer.Option(metavar="OUT", help="Write the report as one HTML page.")] = None,
    language: Annotated[Language, typer.Option(help="Of the report.")] = "en",
    maps: Annotated[
        Path | None,
        typer.Option(
            metavar="OUT.h5", help="Write maps of every pixel's timing as HDF5, and a picture of them as OUT.png."
        ),
    ] = None,
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
        typer.Option(help="Border of the summed region around the opening, 0 to 64 px. Else automatic."),
    ] = None,
    plateau_margin: Annotated[
        float,
        typer.Option(help="Share of a plateau's width kept away from each of its corners; photon cameras only."),
    ] = 0.15,
    slope_limits: Annotated[
        str,
        typer.Option(metavar="LOW,HIGH", help="Opening fractions that lines are fitted to; photon cameras only."),
    ] = _SLOPE_LIMITS,
    reference_edge: Edge = "automatic",
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
    processor: Annotated[
        Processor, typer.Option(help="What sums the frames; automatic is a GPU where CuPy finds one.")
    ] = "automatic",
) -> None:
    """Timing of a camera from its recordings, with uncertainties.

    Trigger delay of any camera; time constant too where pixels lag behind the scene (microbolometer cameras), row delay where
    rows are read one after the other (rolling readout). Every choice is made automatically and shown in the report; the options
    take it over.
    """
    given = locals()
    low, high = _numbers(slope_limits, 2, "--slope-limits")
    region = None if roi is None else _region(roi)
    choices = filled(Choices, given, roi=region, slope_limits=(low, high))
    from rich.console import Console

    from irtiming.cli.progress import shown
    from irtiming.cli.result_table import print_result
    from irtiming.session.analysis import AnalysisOrder
    from irtiming.session.analysis import analyse as analyse_files

    order = filled(AnalysisOrder, given, recordings=tuple(recording), choices=choices, result=json)
    with shown("frames") as progress:
        analysis = analyse_files(order, progress=progress)
    print_result(analysis, Console())


def _numbers(text: str, n: int, option: str) -> list[float]:
    parts = text.split(",")
    try:
        values = [float(part) for part in parts]
    except ValueError:
        values = []
    if len(values) != n or not all(map(math.isfinite, values)):
        raise UnitError(f"{option} is '{text:.80}', must be {n} finite numbers with commas between them")
    return values


def _region(text: str) -> tuple[int, int, int, int]:
    numbers = _numbers(text, 4, "--roi")
    if not all(value.is_integer() for value in numbers):
        raise UnitError(
            f"--roi is '{text:.80}', must be four whole numbers: first row, end row, first column, end column"
        )
    a, b, c, d = map(int, numbers)
    return a, b, c, d
