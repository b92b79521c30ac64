"""``irtiming demo``: the paper's experiments on simulated rigs, from planning to report, within three minutes."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, final

import typer

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.console import Console

    from irtiming.measurement import Analysis, RollingAnalysis
    from irtiming.records.recording import Recording
    from irtiming.twin.rig import SimulatedRig
    from irtiming.twin.scene import Scene

_DELAYS_S = {"photon": (0.0, 0.025, 0.050, 0.075, 0.100), "microbolometer": (0.0, 0.010)}
_RUNS = {"photon": 3, "microbolometer": 1}
_SIZES = {"photon": (160, 200), "microbolometer": (120, 160)}
_SUFFIX = {"photon": "", "microbolometer": "-microbolometer"}


@final
@dataclass(frozen=True, kw_only=True)
class _Wanted:
    """What to simulate of one camera, and where to keep it."""

    kind: Literal["photon", "microbolometer"]
    rows: int
    columns: int
    runs: int
    seed: int
    out_dir: Path
    keep: bool


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
    from rich.console import Console

    from irtiming.archive import result_file

    console = Console()
    if json is not None:
        result_file.require_place(json)
    out_dir.mkdir(parents=True, exist_ok=True)
    results: dict[str, Any] = {}
    for kind in ("photon", "microbolometer"):
        if camera in ("both", kind):
            wanted = _Wanted(
                kind=kind,
                rows=rows or _SIZES[kind][0],
                columns=columns or _SIZES[kind][1],
                runs=runs or _RUNS[kind],
                seed=seed,
                out_dir=out_dir,
                keep=keep,
            )
            results[kind] = _one_camera(wanted, console)
    if json is not None:
        result_file.write_result(results if camera == "both" else results[camera], json)


def _one_camera(wanted: _Wanted, console: "Console") -> dict[str, Any]:
    """Simulate, analyse, write and print; returns the result."""
    from irtiming.archive import result_file, rig_file
    from irtiming.cli.progress import shown
    from irtiming.measurement import analyse
    from irtiming.report import certificate
    from irtiming.twin import rig as twin

    rig = twin.draw(_scene(wanted), seed=wanted.seed)
    delays = len(_DELAYS_S[wanted.kind])
    console.print(
        f"{wanted.kind} camera: simulating {delays} delays x {wanted.runs} run{'s' if wanted.runs > 1 else ''} x 1000 frames of "
        f"{wanted.columns} x {wanted.rows} pixels",
        highlight=False,
    )
    with shown("frames") as told:
        analysis = analyse(_recordings(rig, wanted), rig.measured, progress=told)
    suffix = _SUFFIX[wanted.kind]
    rig_file.write_rig(rig.measured, wanted.out_dir / f"rig{suffix}.toml")
    found = certificate.report(analysis)
    page = wanted.out_dir / f"report{suffix}.html"
    result_file.write_result(found.result, wanted.out_dir / f"result{suffix}.json")
    result_file.write_atomically(found.page, page)
    _print(analysis, twin.truth(rig.scene), console)
    console.print(f"report: {page.resolve()}", soft_wrap=True, highlight=False)
    return found.result


def _scene(wanted: _Wanted) -> "Scene":
    """The paper's experiment with this camera; the microbolometer drifts and closes its shutter once in the run."""
    from irtiming.twin.scene import microbolometer_scene, paper_scene
    from irtiming.twin.upkeep import Drift, SelfCorrection, ShutterEvent

    if wanted.kind == "photon":
        return paper_scene(wanted.rows, wanted.columns)
    return replace(
        microbolometer_scene(wanted.rows, wanted.columns),
        correction=SelfCorrection(events=(ShutterEvent(start_s=14.0),)),
        drift=Drift(per_second_dn=0.3, settling_dn=20.0),
    )


def _print(analysis: "Analysis | RollingAnalysis", truth: dict[str, object], console: "Console") -> None:
    from irtiming.cli.result_table import print_demo, print_rolling_demo
    from irtiming.measurement import RollingAnalysis

    true_s = {name.removesuffix("_s"): value for name, value in truth.items() if isinstance(value, float)}
    if isinstance(analysis, RollingAnalysis):
        print_rolling_demo(analysis, true_s, console=console)
    else:
        print_demo(analysis, true_s["trigger_delay"], console=console)


def _recordings(rig: "SimulatedRig", wanted: _Wanted) -> "Iterator[Recording]":
    """The runs one after the other; written to files and read back where they are to be kept."""
    from irtiming.archive import reader, writer
    from irtiming.twin import rig as twin

    for recording in twin.series(rig.scene, _DELAYS_S[wanted.kind], repeats=wanted.runs, seed=wanted.seed):
        if not wanted.keep:
            yield recording
            continue
        path = wanted.out_dir / f"{recording.name}.nxs"
        writer.write(recording, path, truth=twin.truth(rig.scene), overwrite=True)
        yield reader.read(path)
