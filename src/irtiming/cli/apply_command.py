"""`irtiming apply`: a result put to use on other frames of the same camera."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import FrameRate, filled, in_options
from irtiming.cli.screen import say
from irtiming.errors import UnitError
from irtiming.records.application import Program, StampKind
from irtiming.units import counted, seconds

app = typer.Typer(name="apply", help="Apply a result to frames of the same camera.", no_args_is_help=True)

ResultFile = Annotated[Path, typer.Argument(help="Result of irtiming analyse --json.")]
Series = Annotated[
    list[Path] | None,
    typer.Option(
        metavar="RESULT",
        help="Result of the same camera at another integration time or frame rate; may be given again. Frames whose setting lies "
        "between those measured get the timing on the straight line through them.",
    ),
]


@app.command()
@in_options
def time(
    result: ResultFile,
    stamps: Annotated[
        Path,
        typer.Argument(help="Recording, any file of frames that states their times, or a CSV with one line per frame."),
    ],
    out: Annotated[
        Path,
        typer.Option(
            ..., metavar="OUT", help="CSV to write, .parquet, or .nxs: a copy of the recording with the times in it."
        ),
    ],
    kind: Annotated[
        StampKind | None,
        typer.Option(
            help="What the stamps are: trigger edges, edges of the strobe, stamps of the camera, or arrival at the computer. "
            "Left out: that from which the result counts."
        ),
    ] = None,
    column: Annotated[str | None, typer.Option(help="Column of the stamps; for CSV.")] = None,
    unit: Annotated[
        str | None, typer.Option(help="s, ms, us or ns, where the name of the column does not end in it; for CSV.")
    ] = None,
    latency: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="By how much later than the event a stamp is; it is taken off."),
    ] = None,
    latency_u: Annotated[str, typer.Option(metavar="TIME", help="Standard uncertainty of the latency.")] = "0 s",
    alone: Annotated[
        bool,
        typer.Option(
            "--alone",
            help="Take each stamp by itself, as software must that has no others yet, not its place on the regular grid of all; "
            "for stamps and arrivals of a camera that was measured running free.",
        ),
    ] = False,
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
    series: Series = None,
) -> None:
    """Say when each row of each frame was exposed or read, with standard uncertainty and correlation.

    Start, middle and end of the integration of a photon camera; of a lagging one the moment of reading; and the effective moment:
    the scene appears as it was then. A result for another camera, integration time, readout mode or image size is refused.
    """
    given = locals()
    from irtiming.session.apply_time import TimeOrder, apply_time
    from irtiming.session.frame_stamps import StampsWanted

    wanted = filled(StampsWanted, given, source=stamps)
    found = apply_time(TimeOrder(result=result, stamps=wanted, out=out, rows=_rows(rows), series=tuple(series or ())))
    n_frames, n_rows = found.events.time_s.size, found.rows_px.size
    say(f"{out}: times of {counted(n_frames, 'frame')}, {counted(n_rows, 'row')} each, in {found.events.scale}")
    for remark in found.events.remarks:
        say(f"note: {remark}")


@app.command()
def frames(
    result: ResultFile,
    source: Annotated[Path, typer.Argument(help="Recording, or any file of frames; it is left as it is.")],
    out: Annotated[Path, typer.Argument(help="File to write, .nxs: the scene, its instants, gains and noise gains.")],
    noise: Annotated[
        float | None,
        typer.Option(
            min=0.0, help="Standard deviation of a pixel in the units of the frames; left out: from the frames."
        ),
    ] = None,
    stamps: Annotated[
        Path | None,
        typer.Option(metavar="CSV", help="Trigger times, for a file that does not state when its frames were taken."),
    ] = None,
    period: Annotated[
        str | None, typer.Option(metavar="TIME", help="Time between frames, for a file that does not state it.")
    ] = None,
    instant_row: Annotated[
        float | None,
        typer.Option(min=0.0, help="Row to whose moment all others are brought; left out: the middle one."),
    ] = None,
    fractions: Annotated[
        bool, typer.Option("--fractions", help="Write fractions of counts (float32) instead of whole counts.")
    ] = False,
    kelvin_at_zero: Annotated[
        float | None, typer.Option(help="Temperature that 0 counts stand for; for a result with two time constants.")
    ] = None,
    kelvin_per_count: Annotated[
        float | None, typer.Option(help="Kelvin per count; for a result with two time constants.")
    ] = None,
    series: Series = None,
) -> None:
    """Make frames of the scene at one instant each: rows brought to one moment, lag and filter undone.

    The correction is made as far as it stands out of the noise; gains, and by how much the noise grew, go along for each tile of
    the image. The first and last frames of each uninterrupted run have nothing to be found from and are left out.
    """
    from irtiming.cli.progress import shown
    from irtiming.session.apply_frames import FramesOrder, apply_frames

    order = FramesOrder(
        result=result, source=source, out=out, noise=noise, stamps=stamps, instant_row=instant_row,
        period_s=None if period is None else seconds(period), keeps_fractions=fractions,
        kelvin_at_zero=kelvin_at_zero, kelvin_per_count=kelvin_per_count, series=tuple(series or ()),
    )  # fmt: skip
    with shown("frames") as progress:
        found = apply_frames(order, progress=lambda done, total: progress(source.name, done, total))
    say(f"{out}: {found.n_written} of {found.n_frames} frames, mean gain {found.mean_gain:.3f}, noise times "
        f"{found.mean_noise_gain:.3f}, for pixel noise of {found.noise:.4g}")  # fmt: skip
    for line in found.description[1:]:
        say(line)


@app.command()
@in_options
def export(
    result: ResultFile,
    to: Annotated[Program, typer.Option(..., help="The program that is to read it.")],
    out: Annotated[Path, typer.Option(..., metavar="OUT", help="File to write.")],
    stamp_latency: Annotated[
        str,
        typer.Option(
            metavar="TIME",
            help="By how much later than the event, such as the trigger edge, that program's frames are stamped.",
        ),
    ] = "0 s",
    stamp_latency_u: Annotated[str, typer.Option(metavar="TIME", help="Its standard uncertainty.")] = "0 s",
    frame_hz: FrameRate = None,
) -> None:
    """Hand the timing to another program in its own words.

    Each file says which event and which sign it uses, and what that program cannot express: none has a time constant, so the
    effective moment stands for it, with the frequency up to which it does.
    """
    given = locals()
    from irtiming.session.hand_over import ExportOrder, hand_over

    found = hand_over(filled(ExportOrder, given, program=to))
    event = found.middle_row
    say(f"{out}: effective moment {1e3 * event.value_s:+.4f} ms after the stamp, u = {1e6 * event.u_s:.3g} µs")
    if found.validity is not None:
        say(f"no number there for the time constant: good up to {found.validity.frequency_hz:.2f} Hz")


def _rows(text: str | None) -> tuple[int, ...] | None:
    if text is None:
        return None
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isdecimal() for part in parts):
        raise UnitError(f"--rows {text} are no image rows; write whole numbers from 0, such as 0,240,479")
    return tuple(int(part) for part in parts)
