"""`irtiming apply`: a result put to use on other frames of the same camera."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.apply.stamps import Latency, StampKind
from irtiming.cli.screen import say
from irtiming.errors import UnitError
from irtiming.units import seconds

app = typer.Typer(name="apply", help="Apply a result to frames of the same camera.", no_args_is_help=True)

ResultFile = Annotated[Path, typer.Argument(help="Result of irtiming analyse --json.")]


@app.command()
def time(
    result: ResultFile,
    stamps: Annotated[
        Path,
        typer.Argument(help="Recording, any file of frames that tells their times, or a CSV with one line per frame."),
    ],
    out: Annotated[
        Path,
        typer.Option(..., metavar="OUT", help="CSV to write, or .nxs: a copy of the recording with the times in it."),
    ],
    kind: Annotated[
        StampKind | None,
        typer.Option(
            help="What the stamps are: trigger edges, stamps of the camera, or arrival at the computer. Left out: trigger edges "
            "where there are any."
        ),
    ] = None,
    column: Annotated[str | None, typer.Option(help="Column of the stamps; for CSV.")] = None,
    unit: Annotated[
        str | None, typer.Option(help="s, ms, us or ns, where the name of the column does not end in it; for CSV.")
    ] = None,
    latency: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="By how much later than the trigger edge a stamp is; it is taken off."),
    ] = None,
    latency_u: Annotated[str, typer.Option(metavar="TIME", help="Standard uncertainty of the latency.")] = "0 s",
    calibrated_by: Annotated[
        Path | None,
        typer.Option(
            metavar="RECORDING",
            help="Recording with stamped triggers and the same stamps, made since the clocks were switched on: times are then in "
            "its trigger generator's scale.",
        ),
    ] = None,
    rows: Annotated[
        str | None,
        typer.Option(metavar="ROW,...", help="Image rows that are wanted, such as 0,240,479; left out: all."),
    ] = None,
) -> None:
    """Say when each row of each frame was exposed or read, with standard uncertainty and correlation.

    Start, middle and end of the integration of a photon camera; of a lagging one the moment of reading; and the effective moment:
    the scene is seen as it was then. A result for another camera, integration time, readout mode or image size is refused.
    """
    from irtiming.session.apply_time import TimeOrder, apply_time
    from irtiming.session.frame_stamps import StampsWanted

    late = None if latency is None else Latency(value_s=seconds(latency), u_s=seconds(latency_u))
    wanted = StampsWanted(source=stamps, kind=kind, column=column, unit=unit, latency=late, calibrated_by=calibrated_by)
    found = apply_time(TimeOrder(result=result, stamps=wanted, out=out, rows=_rows(rows)))
    n_frames, n_rows = found.triggers.time_s.size, found.rows_px.size
    say(f"{out}: times of {n_frames} frames, {n_rows} rows each, in {found.triggers.scale}")
    for remark in found.triggers.remarks:
        say(f"note: {remark}")


def _rows(text: str | None) -> tuple[int, ...] | None:
    if text is None:
        return None
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isdecimal() for part in parts):
        raise UnitError(f"--rows {text} are no image rows; write whole numbers from 0, such as 0,240,479")
    return tuple(int(part) for part in parts)
