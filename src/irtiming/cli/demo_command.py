"""``irtiming demo``: the paper's experiments on simulated rigs, from planning to report, within three minutes."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from irtiming.session.demo import DemoOrder


def demo(
    out_dir: Annotated[Path, typer.Option(help="Folder for the reports and the results.")] = Path("demo"),
    camera: Annotated[
        Literal["both", "photon", "microbolometer"], typer.Option(help="Which of the paper's two cameras.")
    ] = "both",
    rows: Annotated[
        int | None, typer.Option(min=64, max=2048, help="Pixels down the image: 160, of a microbolometer 120.")
    ] = None,
    columns: Annotated[
        int | None, typer.Option(min=64, max=2048, help="Pixels across the image: 200, of a microbolometer 160.")
    ] = None,
    runs: Annotated[
        int | None,
        typer.Option(min=1, max=100, help="Runs for each delay: 3, of a microbolometer 1; the paper made 20 and 21."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Draws the rigs and their runs.")] = 2023,
    keep: Annotated[bool, typer.Option("--keep", help="Keep the recordings too, as files to play with.")] = False,
    json: Annotated[
        Path | None, typer.Option(metavar="OUT", help="Write the result there as well; of both, under their names.")
    ] = None,
) -> None:
    """Simulate the paper's two cameras and analyse each by both methods.

    The cooled camera's deviations stand beside the paper's Table 1, the microbolometer camera's timing beside the truth.
    The simulated rigs have the imperfections of real ones: an eccentric wheel, irregular slots, a mask beside the axle, a
    camera that drifts and corrects itself, and a rig.toml whose numbers are off by their stated uncertainties.
    """
    given = locals()
    from irtiming.archive import json_file
    from irtiming.session.demo import USUAL

    json_file.require_places({"JSON": [json]})
    said = {name: given[name] for name in ("rows", "columns", "runs", "seed", "keep") if given[name] is not None}
    results = {
        kind: _demonstrated(replace(usual, folder=out_dir, **said))
        for kind, usual in USUAL.items()
        if camera in ("both", kind)
    }
    if json is not None:
        json_file.write_json(results if camera == "both" else results[camera], json)


def _demonstrated(order: "DemoOrder") -> "Mapping[str, Any]":
    """One camera, printed; gives its result."""
    from rich.console import Console

    from irtiming.cli.progress import shown
    from irtiming.cli.result_table import print_demonstration
    from irtiming.cli.screen import say
    from irtiming.session.demo import demonstrate

    console = Console()
    say(
        f"{order.camera} camera: simulating {len(order.delays_s)} delays x {order.runs} run{'s' if order.runs > 1 else ''} "
        f"x 1000 frames of {order.columns} x {order.rows} pixels",
        console,
    )
    with shown("frames") as progress:
        done = demonstrate(order, progress=progress)
    print_demonstration(done.analysis, done.truth_s, console=console)
    say(f"report: {done.report.resolve()}", console)
    return done.result
