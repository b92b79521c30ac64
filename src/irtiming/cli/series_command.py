"""``irtiming series``: one camera at several settings, and what they do to its timing."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import filled, in_options
from irtiming.records.choices import Language


@in_options
def series(
    source: Annotated[
        list[Path],
        typer.Argument(
            metavar="RECORDING|RESULT...",
            help="Recordings (.nxs) or results of irtiming analyse --json, of any cameras.",
        ),
    ],
    rig: Annotated[Path | None, typer.Option(help="What was measured on the rig (rig.toml); for recordings.")] = None,
    wheel_calibration: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Slots of the same wheel, from irtiming calibrate-wheel; for recordings."),
    ] = None,
    json: Annotated[
        Path | None, typer.Option(metavar="OUT", help="Write points, covariances and fits as JSON.")
    ] = None,
    report: Annotated[Path | None, typer.Option("--report", "-o", metavar="OUT", help="Write one HTML page.")] = None,
    language: Annotated[Language, typer.Option(help="Of the page.")] = "en",
) -> None:
    """Each parameter of a camera over integration time, frame rate, internal delay, region, gain and FPA temperature.

    Recordings of one camera at one setting are analysed together, cameras are distinguished by serial number and never taken
    together. Errors of the rig that all results have in common are in their covariance, so slopes and differences, such as those
    of the camera's internal delays, are known better than the delays themselves.
    """
    given = locals()
    from rich.console import Console

    from irtiming.cli.progress import shown
    from irtiming.cli.series_table import show
    from irtiming.session.over_settings import SeriesOrder, compare

    order = filled(SeriesOrder, given, sources=tuple(source), series=json)
    with shown("frames") as progress:
        found = compare(order, progress=progress)
    show(found, Console())
