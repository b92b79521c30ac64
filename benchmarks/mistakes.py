"""What becomes of a laboratory's mistakes: each is made once on a sound simulated rig, and the recording analysed.

A number that is more than 4 u off without a finding of severity "doubt", or a refusal, is silently wrong.

    .venv/bin/python benchmarks/mistakes.py --camera photon
    .venv/bin/python benchmarks/mistakes.py --camera microbolometer --only mask-angle-10-degrees-off
    .venv/bin/python benchmarks/mistakes.py --camera photon --out photon.jsonl --markdown photon.md
    .venv/bin/python benchmarks/mistakes.py --camera photon --out photon.jsonl --markdown photon.md --known
"""

import argparse
import json
import traceback
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import Any

import mistake_images  # noqa: F401  (puts its mistakes into the table)
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.archive.rig_file import read_rig
from irtiming.archive.rig_writer import write_rig
from irtiming.errors import IrTimingError
from irtiming.measurement import analyse
from irtiming.records.analysis import Analysis
from irtiming.records.recording import Recording
from irtiming.records.rig import Clock, Latency, Measured, Rig
from irtiming.twin import rig as rigs
from irtiming.twin.cameras import camera_scene
from irtiming.twin.scene import Scene, with_wheel_speed
from measured_commit import commit
from mistake_table import MISTAKES, ON_TRUST, Camera, Case

FAR_OFF = 4.0
ROWS, COLUMNS, FRAMES, WHEEL_HZ, SEED = 120, 160, 500, 3.0, 1
OTHER_DELAY_S = 25e-3
HEAD = (
    "| mistake | verdict | error/u, us | **doubts**, warnings, or refusal | run with |",
    "| --- | --- | --- | --- | --- |",
)


def sound(camera: Camera, seed: int = SEED) -> tuple[Case, Scene]:
    """A rig of the usual tolerances, whose owner knows it as well as rig.toml can say, and one run."""
    nominal = with_wheel_speed(camera_scene(camera, rows=ROWS, columns=COLUMNS), WHEEL_HZ, samples=FRAMES)
    rig = rigs.draw(nominal, seed=seed)
    none = Measured(0.0, 0.3e-6)
    measured = replace(
        rig.measured,
        light_gates=replace(rig.measured.light_gates, lateral_offset_m=Measured(0.0, 5e-5)),
        latency=Latency(application_gate_s=none, control_gate_s=none, trigger_s=none),
        clock=Clock(relative_error=Measured(0.0, 5e-6)),
        camera=replace(rig.measured.camera, integration_time_u_s=5e-6 if camera == "photon" else None),
    )

    def other(what: str) -> Recording:
        scene = rigs.draw(nominal, seed=seed + 7).scene if what == "camera" else rig.scene
        if what == "delay":
            scene = replace(scene, trigger=replace(scene.trigger, trigger_delay_time_set_s=OTHER_DELAY_S))
        return in_memory(rigs.simulate(scene, seed=seed + 99, name="other"))

    return Case(
        recording=in_memory(rigs.simulate(rig.scene, seed=seed + 4, name="run")), rig=measured, other=other
    ), rig.scene


def in_memory(recording: Recording) -> Recording:
    return replace(recording, frames=ArrayFrames(recording.frames.pick(list(range(recording.frames.shape[0])))))


def tried(name: str, case: Case, scene: Scene) -> dict[str, Any]:
    """What became of one mistake, ready for a line of JSON."""
    begun, (change, _, harmless) = monotonic(), MISTAKES[name]
    line: dict[str, Any] = {
        "name": name,
        "harmless": harmless,
        "commit": commit(),
        "parameters": {},
        "doubts": [],
        "warnings": [],
    }
    try:
        made = change(case)
        found = analyse([made.recording, *made.together], as_written(made.rig))
    except IrTimingError as error:
        line |= {"refused": f"{type(error).__name__}: {error}", "notes": getattr(error, "__notes__", [])}
    except Exception as error:
        line |= {"crashed": f"{type(error).__name__}: {error}", "trace": traceback.format_exc()[-600:]}
    else:
        line |= {"parameters": pulls(found, rigs.truth(scene))} | findings(found)
        line["trusted"] = " ".join(one.what for one in found.findings if one.code == "taken-on-trust")
    return line | {"seconds": monotonic() - begun}


def as_written(rig: Rig) -> Rig:
    """As it is read from the rig.toml that its owner wrote, which refuses some mistakes."""
    with TemporaryDirectory() as folder:
        write_rig(rig, Path(folder) / "rig.toml")
        try:
            return read_rig(Path(folder) / "rig.toml")
        except IrTimingError as error:
            raise type(error)(str(error).replace(f"{folder}/", "")) from error


def pulls(found: Analysis, truth: dict[str, object]) -> dict[str, list[float]]:
    """Error and u of each number that the truth knows, us; relative delays against what was set."""
    estimate, known = found.best.estimate, {}
    for name, value, u in zip(estimate.names, estimate.values, estimate.standard_uncertainties, strict=True):
        true = truth.get(f"{name}_s")
        if isinstance(true, float) and u > 0:
            known[name] = [1e6 * (float(value) - true), 1e6 * float(u)]
    for one in found.best.relative_delays[1:]:
        if one.standard_uncertainty_s > 0:
            known["relative_delay"] = [1e6 * (one.value_s - one.nominal_s), 1e6 * one.standard_uncertainty_s]
    return known


def findings(found: Analysis) -> dict[str, list[str]]:
    return {
        f"{severity}s": sorted({one.code for one in found.findings if one.severity == severity})
        for severity in ("doubt", "warning")
    }


def verdict(line: dict[str, Any], usual: Iterable[str] = ()) -> str:
    """Of one line; doubts that the sound rig has too do not count."""
    if "crashed" in line:
        return "CRASHED"
    doubts = set(line["doubts"]) - set(usual)
    if line["harmless"] and ("refused" in line or doubts):
        return "FALSE DOUBT"
    if "refused" in line:
        return "refused"
    wrong = any(abs(error) > FAR_OFF * u for error, u in line["parameters"].values())
    if doubts:
        return "doubted" if wrong else "doubted, right"
    if wrong and ON_TRUST.get(line["name"], " nowhere ") in line.get("trusted", ""):
        return "listed as on trust"
    return "SILENTLY WRONG" if wrong else "right"


def row(line: dict[str, Any], usual: Iterable[str] = ()) -> str:
    """One line of the table; what a refusal is perhaps due to comes first."""
    short = {"trigger_delay": "delay", "exposure_midpoint_delay": "middle", "time_constant": "tau", "row_delay": "row"}
    numbers = ", ".join(
        f"{short.get(name, name.replace('_', ' '))} {error:+.3g}/{u:.2g}"
        for name, (error, u) in line["parameters"].items()
        if name != "exposure_midpoint_delay"
    )
    therefore = [note for note in line.get("notes", ()) if note.startswith("and perhaps therefore")]
    said = " ".join([*therefore, line.get("refused", "")]).strip() or line.get("crashed") or ", ".join(
        [*(f"**{code}**" for code in line["doubts"]), *line["warnings"]]
    )  # fmt: skip
    return (
        f"| {line['name'].replace('-', ' ')} | {verdict(line, usual)} | {numbers} | {said[:220].replace('|', '/')} "
        f"| {line.get('commit', '?')} |"
    )


def table(lines: list[dict[str, Any]]) -> str:
    """All lines as Markdown, and how many of each verdict."""
    usual = next((line["doubts"] for line in lines if line["name"] == "none"), [])
    count = Counter(verdict(line, usual) for line in lines)
    return "\n".join(
        [*HEAD, *(row(line, usual) for line in lines), "", ", ".join(f"{n} {v}" for v, n in count.most_common())]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--camera", choices=("photon", "microbolometer"), default="photon")
    parser.add_argument("--only", action="append", help="name of one mistake; may be given more than once")
    parser.add_argument("--out", type=Path, help="JSON lines; mistakes that are there already are not made again")
    parser.add_argument("--markdown", type=Path, help="the table")
    parser.add_argument("--known", action="store_true", help="make nothing: the table of the lines that --out has")
    options = parser.parse_args()
    names = [name for name, (_, cameras, _) in MISTAKES.items() if options.camera in cameras]
    if unknown := set(options.only or ()) - set(names):
        parser.error(f"--only {', '.join(unknown)}; it must be one of {', '.join(names)}")
    known = options.out.read_text().splitlines() if options.out and options.out.exists() else []
    lines = {line["name"]: line for line in map(json.loads, known)}
    if options.known:
        text = table([lines[name] for name in options.only or names if name in lines])
        print(text)
        if options.markdown:
            options.markdown.write_text(text + "\n")
        return
    case, scene = sound(options.camera)
    for name in options.only or names:
        if name not in lines:
            lines[name] = tried(name, case, scene)
            if options.out:
                with options.out.open("a") as file:
                    file.write(json.dumps(lines[name]) + "\n")
        print(row(lines[name]), flush=True)
    text = table([lines[name] for name in options.only or names])
    print(f"\n{text}")
    if options.markdown:
        options.markdown.write_text(text + "\n")


if __name__ == "__main__":
    main()
