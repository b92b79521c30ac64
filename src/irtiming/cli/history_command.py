"""``irtiming history``: the register of results."""

from datetime import date
from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import in_options
from irtiming.errors import UnitError


@in_options
def history(
    serial_number: Annotated[
        str | None, typer.Argument(metavar="[SERIAL]", help="Of the camera; left out: list all cameras.")
    ] = None,
    register: Annotated[
        str, typer.Option(metavar="FILE|URL", help="Register of results: an SQLite file, or an SQLAlchemy URL.")
    ] = "register.sqlite",
    add: Annotated[
        list[Path] | None,
        typer.Option(metavar="RESULT", help="Enter a result of irtiming analyse --json first; repeatable."),
    ] = None,
    since: Annotated[
        str | None,
        typer.Option(metavar="DAY", help="Drift since the last calibration up to this day, such as 2026-01-31."),
    ] = None,
    json: Annotated[Path | None, typer.Option(metavar="OUT", help="Write results and drift as JSON.")] = None,
) -> None:
    """What the register of results knows of a camera: every result, and its drift since the last calibration with its u.

    irtiming campaign enters all of its results; the register needs no set-up.
    """
    from rich.console import Console

    from irtiming.cli.history_table import show, show_cameras
    from irtiming.cli.screen import say
    from irtiming.session.history import HistoryOrder, cameras, of_camera
    from irtiming.session.history import add as enter
    from irtiming.units import counted

    screen = Console()
    if add:
        say(f"register: {enter(add, register)} new of {counted(len(add), 'result')}", screen)
    if serial_number is None:
        if json is not None or since is not None:
            raise UnitError(
                "--json and --since go with a serial number; name the camera, such as irtiming history C001"
            )
        return show_cameras(cameras(register), screen)
    order = HistoryOrder(serial_number=serial_number, register=register, since=_day(since), history=json)
    return show(of_camera(order), screen)


def _day(text: str | None) -> date | None:
    try:
        return None if text is None else date.fromisoformat(text)
    except ValueError as error:
        raise UnitError(f"--since is '{text:.40}', must be a day such as 2026-01-31") from error
