"""`irtiming plan --for`: from a wanted uncertainty to proposals, as a table and JSON."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from irtiming.cli.camera_options import Described, camera

if TYPE_CHECKING:
    from rich.table import Table

    from irtiming.plan.prediction import Setting
    from irtiming.plan.proposals import Proposal, Proposals
    from irtiming.plan.targets import Target
    from irtiming.records.camera_description import Camera
    from irtiming.records.prediction import PredictedUncertainty
    from irtiming.records.trigger_plan import Wishes


_LEAST_SHARE = 1e-3  # of an uncertainty, below which a part of it is not worth a number


def plan_for(
    wanted: list[str],
    wishes: "Wishes",
    *,
    described: Described,
    most: int,
    files: tuple[Path | None, Path | None],
) -> None:
    """Print proposals that should reach what is wanted, and write the JSON and picture that are asked for."""
    from rich.console import Console

    from irtiming.archive.rig_file import read_rig
    from irtiming.cli.plan_command import show_runs
    from irtiming.cli.plan_json import write
    from irtiming.plan.assumptions import assumed
    from irtiming.plan.drawing import sampling_svg
    from irtiming.plan.photon_information import KNOWN_WINDOW, SHARED_SHAPE
    from irtiming.plan.prediction import Setting
    from irtiming.plan.proposals import propose
    from irtiming.plan.targets import targets

    seen = camera(described)
    asked = targets(wanted, seen)
    setting = Setting(
        camera=seen,
        rig=assumed(None if described.rig is None else read_rig(described.rig), seen),
        clock_frequency_hz=wishes.clock_frequency_hz,
        structure=KNOWN_WINDOW if described.known_integration_time else SHARED_SHAPE,
    )
    found = propose(setting, wishes, targets=asked, most=most)
    for path, content in (
        (files[0], _as_json(found, asked, setting=setting)),
        (files[1], sampling_svg(found.best[0].plan.schemes[0], wishes.clock_frequency_hz)),
    ):
        if path is not None:
            write(path, content)
    console = Console(highlight=False)
    console.print(_table(found.best, asked))
    console.print(_parts(found.best[0]))
    for line in (*_remarks(found, asked), *setting.rig.remarks, _camera_text(seen)):
        console.print(line, markup=False)
    show_runs(console, found.best[0].plan)


def _table(proposals: "tuple[Proposal, ...]", asked: "tuple[Target, ...]") -> "Table":
    from rich import box
    from rich.table import Table

    from irtiming.units import readable_time

    table = Table(title="Measurements that should do, shortest first", box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("", "wheel / Hz", "runs of each", "lasts"):
        table.add_column(heading, justify="right")
    for target in asked:
        table.add_column(f"u({target.name})\nwanted {_time(target.standard_uncertainty_s)}", justify="right")
    for rank, proposal in enumerate(proposals, 1):
        clock = proposal.plan.clock_frequency_hz
        table.add_row(
            str(rank),
            "\n".join(f"{clock / scheme.turn_period_ticks:.4g}" for scheme in proposal.plan.schemes),
            "\n".join(map(str, proposal.runs_of_each)),
            readable_time(float(f"{proposal.duration_s:.3g}")),
            *(_time(found.standard_uncertainty_s) for found in proposal.uncertainties),
        )
    return table


def _parts(best: "Proposal") -> "Table":
    from rich import box
    from rich.table import Table

    table = Table(title="What u of the first is made of", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("source")
    for found in best.uncertainties:
        table.add_column(found.name, justify="right")
    for k, part in enumerate(best.uncertainties[0].parts):
        cells = [
            _time(found.parts[k].standard_uncertainty_s)
            if found.parts[k].standard_uncertainty_s >= _LEAST_SHARE * found.standard_uncertainty_s
            else "–"
            for found in best.uncertainties
        ]
        table.add_row(part.source, *cells)
    return table


def _remarks(found: "Proposals", asked: "tuple[Target, ...]") -> list[str]:
    """What one wheel speed could do where several are proposed."""
    from irtiming.plan.proposals import MOST_RUNS, speeds_text

    if len(found.best[0].plan.schemes) == 1:
        return []
    missed = [
        (each, target)
        for each, target in zip(found.one_speed.uncertainties, asked, strict=True)
        if each.standard_uncertainty_s > target.standard_uncertainty_s
    ]
    return [
        f"One wheel speed alone reaches u({each.name}) = {_time(each.standard_uncertainty_s)} at best "
        f"({speeds_text(found.one_speed.wheel_rates_hz)}, {MOST_RUNS} runs); {each.largest_part.source} makes "
        f"{_time(each.largest_part.standard_uncertainty_s)} of it."
        for each, target in missed
    ]


def _camera_text(seen: "Camera") -> str:
    from irtiming.plan.photon_information import frame_noise
    from irtiming.records.camera_description import PhotonCamera

    noise = f"noise of a pixel {seen.noise_to_contrast:.2%} of the contrast"
    text = f"Camera: {noise}, {seen.opening_pixels:.0f} pixels in the opening"
    if isinstance(seen, PhotonCamera):
        return f"{text}, so noise of a frame {frame_noise(seen).share:.2g} of its step."
    return f"{text}, time constant about {_time(seen.time_constant_s)}."


def _time(time_s: float) -> str:
    from irtiming.units import readable_time

    return readable_time(float(f"{time_s:.2g}"))


def _as_json(found: "Proposals", asked: "tuple[Target, ...]", *, setting: "Setting") -> dict[str, Any]:
    from irtiming.cli.plan_json import plan_as_json, scheme_as_json

    best = found.best[0]
    return {
        "clock_frequency_hz": setting.clock_frequency_hz,
        "targets": {
            target.name: {"standard_uncertainty": target.standard_uncertainty_s, "unit": "s"} for target in asked
        },
        "camera": _camera_as_json(setting.camera),
        "assumptions": list(setting.rig.remarks),
        "predicted_uncertainty": predicted_as_json(best.uncertainties),
        "plan": plan_as_json(best.plan),
        "proposals": [
            {
                "rank": rank,
                "duration_s": proposal.duration_s,
                "runs_of_each": list(proposal.runs_of_each),
                "schemes": [scheme_as_json(scheme, setting.clock_frequency_hz) for scheme in proposal.plan.schemes],
                "predicted_uncertainty": predicted_as_json(proposal.uncertainties),
            }
            for rank, proposal in enumerate(found.best, 1)
        ],
    }


def predicted_as_json(found: "tuple[PredictedUncertainty, ...]") -> dict[str, Any]:
    """Predicted standard uncertainties by parameter, with their parts."""
    return {
        each.name: {
            "standard_uncertainty": each.standard_uncertainty_s,
            "unit": "s",
            "parts": [
                {"source": part.source, "standard_uncertainty": part.standard_uncertainty_s} for part in each.parts
            ],
        }
        for each in found
    }


def _camera_as_json(seen: "Camera") -> dict[str, Any]:
    from irtiming.records.camera_description import PhotonCamera

    shared = {"noise_to_contrast": seen.noise_to_contrast, "opening_pixels": seen.opening_pixels}
    if isinstance(seen, PhotonCamera):
        return {"camera": "photon", **shared, "integration_time": seen.integration_time_s, "unit": "s"}
    return {"camera": "microbolometer", **shared, "time_constant": seen.time_constant_s, "unit": "s"}
