"""``irtiming demo``: the paper's experiment of section 3.1 on a simulated rig, from planning to report, in two minutes."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Iterator

    from irtiming.records.recording import Recording
    from irtiming.twin.rig import SimulatedRig

_DELAYS_S = (0.0, 0.025, 0.050, 0.075, 0.100)


def demo(
    out_dir: Annotated[Path, typer.Option(help="Folder for the report and the result.")] = Path("demo"),
    rows: Annotated[int, typer.Option(min=64, max=2048, help="Pixels down the image.")] = 160,
    columns: Annotated[int, typer.Option(min=64, max=2048, help="Pixels across the image.")] = 200,
    runs: Annotated[int, typer.Option(min=1, max=100, help="Runs for each delay; the paper made 20.")] = 3,
    seed: Annotated[int, typer.Option(min=0, help="Draws the rig and its runs.")] = 2023,
    keep: Annotated[bool, typer.Option("--keep", help="Keep the recordings too, as files to play with.")] = False,
    json: Annotated[Path | None, typer.Option(metavar="OUT", help="Write the result there as well.")] = None,
) -> None:
    """Simulate the paper's cooled camera, analyse it both ways, and show the deviations beside the paper's Table 1.

    The simulated rig has the imperfections of a real one: an eccentric wheel, irregular slots, a mask beside the axle,
    and a rig.toml whose numbers are off by their stated uncertainties.
    """
    from rich.console import Console

    from irtiming.archive import result_file, rig_file
    from irtiming.cli.progress import shown
    from irtiming.cli.result_table import print_demo
    from irtiming.measurement import analyse
    from irtiming.report import certificate
    from irtiming.twin import rig as twin
    from irtiming.twin.scene import paper_scene

    console = Console()
    if json is not None:
        result_file.require_place(json)
    rig = twin.draw(paper_scene(rows, columns), seed=seed)
    out_dir.mkdir(parents=True, exist_ok=True)
    console.print(
        f"simulating {len(_DELAYS_S)} delays x {runs} runs x 1000 frames of {columns} x {rows} pixels", highlight=False
    )
    with shown("frames") as told:
        analysis = analyse(_recordings(rig, runs, seed, out_dir if keep else None), rig.measured, progress=told)
    rig_file.write_rig(rig.measured, out_dir / "rig.toml")
    found = certificate.report(analysis)
    for path in (out_dir / "result.json", *([json] if json else [])):
        result_file.write_result(found.result, path)
    result_file.write_atomically(found.page, out_dir / "report.html")
    print_demo(analysis, float(str(twin.truth(rig.scene)["trigger_delay_s"])), console=console)
    console.print(f"report: {(out_dir / 'report.html').resolve()}", soft_wrap=True, highlight=False)


def _recordings(rig: "SimulatedRig", runs: int, seed: int, keep_in: Path | None) -> "Iterator[Recording]":
    """The runs one after the other; written to files and read back where they are to be kept."""
    from irtiming.archive import reader, writer
    from irtiming.twin import rig as twin

    for recording in twin.series(rig.scene, _DELAYS_S, repeats=runs, seed=seed):
        if keep_in is None:
            yield recording
            continue
        path = keep_in / f"{recording.name}.nxs"
        writer.write(recording, path, truth=twin.truth(rig.scene), overwrite=True)
        yield reader.read(path)
