"""The paper's experiments on simulated rigs, from planning to report."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, final

from irtiming.archive import reader, rig_writer, writer
from irtiming.archive.json_file import make_folder
from irtiming.measurement import ALL_EXTRAS, Progress, analyse
from irtiming.records.analysis import Analysis
from irtiming.records.recording import CameraType, Recording
from irtiming.session.analysis import write
from irtiming.twin import rig as twin
from irtiming.twin.scene import Scene, microbolometer_scene, paper_scene
from irtiming.twin.upkeep import Drift, SelfCorrection, ShutterEvent


@final
@dataclass(frozen=True, kw_only=True)
class DemoOrder:
    """One of the paper's cameras to be simulated, and the folder for what is found; recordings only where they are to be kept."""

    camera: CameraType
    delays_s: tuple[float, ...]
    rows: int
    columns: int
    runs: int
    seed: int = 2023
    folder: Path = Path("demo")
    keep: bool = False


USUAL = {
    "photon": DemoOrder(camera="photon", delays_s=(0.0, 0.025, 0.050, 0.075, 0.100), rows=160, columns=200, runs=3),
    "microbolometer": DemoOrder(camera="microbolometer", delays_s=(0.0, 0.010), rows=120, columns=160, runs=1),
}
"""Small images and few runs, within three minutes."""

_SUFFIX = {"photon": "", "microbolometer": "-microbolometer"}


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Demonstration:
    """What was found of one camera, its result as plain data, what is true of it, by name and in seconds, and its report."""

    analysis: Analysis
    result: Mapping[str, Any]
    truth_s: dict[str, float]
    report: Path


def demonstrate(order: DemoOrder, *, progress: Progress | None = None) -> Demonstration:
    """Simulate a camera, analyse it by both methods, and write rig, result and report.

    Raises
    ------
    ArchiveError
        If a file cannot be written.
    """
    make_folder(order.folder)
    rig = twin.draw(_scene(order), seed=order.seed)
    analysis = analyse(_recordings(rig.scene, order), rig.measured, progress=progress, extras=ALL_EXTRAS)
    suffix = _SUFFIX[order.camera]
    page = order.folder / f"report{suffix}.html"
    rig_writer.write_rig(rig.measured, order.folder / f"rig{suffix}.toml")
    result = write(analysis, result=order.folder / f"result{suffix}.json", report=page)
    true = {name: value for name, value in twin.truth(rig.scene).items() if isinstance(value, float)}
    return Demonstration(
        analysis=analysis,
        result=result,
        truth_s={name.removesuffix("_s"): value for name, value in true.items()},
        report=page,
    )


def _scene(order: DemoOrder) -> Scene:
    """The paper's experiment with this camera; the microbolometer drifts and closes its shutter once in the run."""
    if order.camera == "photon":
        return paper_scene(order.rows, order.columns)
    return replace(
        microbolometer_scene(order.rows, order.columns),
        correction=SelfCorrection(events=(ShutterEvent(start_s=14.0),)),
        drift=Drift(per_second_dn=0.3, settling_dn=20.0),
    )


def _recordings(scene: Scene, order: DemoOrder) -> Iterator[Recording]:
    """The runs one after the other; written to files and read back where they are to be kept."""
    for recording in twin.series(scene, order.delays_s, repeats=order.runs, seed=order.seed):
        if not order.keep:
            yield recording
            continue
        path = order.folder / f"{recording.name}.nxs"
        writer.write(recording, path, truth=twin.truth(scene), overwrite=True)
        yield reader.read(path)
