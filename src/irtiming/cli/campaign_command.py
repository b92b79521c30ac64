"""``irtiming campaign``: many cameras, one table."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import RigFile, filled, in_options
from irtiming.records.choices import Language


@in_options
def campaign(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="FOLDER|TABLE.CSV",
            help="Folder of recordings, or a CSV with a column file and, if wanted, serial_number, operator and run.",
        ),
    ],
    rig: RigFile,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FOLDER", help="Folder of results, table and page.")],
    limits: Annotated[
        Path | None, typer.Option(metavar="TOML", help="Limits of parameters and the decision rule (limits.toml).")
    ] = None,
    wheel_calibration: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Slots of the wheel, from irtiming calibrate-wheel; else made once of these."
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Running Dask scheduler, such as tcp://10.0.0.7:8786, whose workers see the same files; here: no other process.",
        ),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, max=1024, help="Processes on this computer; else one per processor.")
    ] = None,
    register: Annotated[
        str, typer.Option(metavar="FILE|URL", help="Register of results: an SQLite file, an SQLAlchemy URL, or none.")
    ] = "register.sqlite",
    language: Annotated[Language, typer.Option(help="Of the page.")] = "en",
    json: Annotated[Path | None, typer.Option(metavar="OUT", help="Write all of it as JSON.")] = None,
) -> None:
    """Measure many cameras on one rig: one table, one page, and every result in the register.

    Recordings of one camera at one setting are analysed together; those in one folder, or of one run in the table, count as one
    measurement. The same command again does only what is missing or has changed. Recordings that cannot be analysed are listed,
    the rest is done.
    """
    given = locals()
    from rich.console import Console

    from irtiming.cli.campaign_table import show
    from irtiming.cli.progress import shown
    from irtiming.session.campaign import Order, run

    with shown("") as progress:
        done = run(filled(Order, given), progress=progress)
    show(done, Console())
