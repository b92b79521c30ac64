"""What ordinary defects of a rig do to the result: each by itself in a simulated rig, by an earlier program and by this one.

The rig has its own random imperfections besides; rig.toml states what its owner knows of latencies, clock and beams, and the
earlier program gets a rig.toml without the keys that it does not know.

    git worktree add ../before a328854
    .venv/bin/python benchmarks/accuracy/defects.py --before ../before --figure docs/explanation/defects.svg
"""

import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from irtiming.archive import reader, writer
from irtiming.archive.rig_writer import write_rig
from irtiming.measurement import analyse
from irtiming.twin import rig as twin
from irtiming.twin.defects import Defects, with_defects
from irtiming.twin.laboratory import Knowledge, known
from irtiming.twin.rig import SimulatedRig
from irtiming.twin.scene import microbolometer_scene, paper_scene, with_wheel_speed

SHAPE = (120, 160)
DEG = math.pi / 180
ONE, TWO, FOUR = (3.0,), (3.0, 8.0), (2.0, 3.0, 6.0, 12.0)
MICROBOLOMETER = ("trigger_delay", "time_constant", "row_delay")
UNKNOWN_TO_IT = re.compile(
    r"^(lateral_offset\w*|height_mm|integration_time_u_us) = .*\n|^\[(latency|clock)\]\n(?:\w.*\n)*", re.M
)


@dataclass(frozen=True, kw_only=True)
class Case:
    """One defect in one rig, and how often the wheel turns in its recordings."""

    name: str
    defects: Defects
    speeds_hz: tuple[float, ...] = ONE
    is_photon: bool = True


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """A parameter by one program: error and stated standard uncertainty, s, or what it said instead of a number."""

    error_s: float = math.nan
    u_s: float = math.nan
    warnings: int = 0
    doubts: int = 0
    refused: str = ""


CASES = (
    Case(name="light gates 5 µs late", defects=Defects(late_application_gate_s=5e-6, late_control_gate_s=5e-6), speeds_hz=FOUR),
    Case(name="beams 0.1 mm aside", defects=Defects(lateral_offset_m=1e-4)),
    Case(name="second blade 1.2 % warmer, levels sway by 3 %", defects=Defects(blade_share=0.012, sway_share=0.03)),
    Case(name="window with a tail, 4 % over 0.3 ms", defects=Defects(tail_share=0.04, tail_s=0.3e-3), speeds_hz=TWO),
    Case(name="count_time 12.5 µs wrong", defects=Defects(count_time_error_s=12.5e-6), speeds_hz=FOUR),
    Case(name="pixels keep 1 % of the frame before", defects=Defects(memory_share=0.01)),
    Case(name="four speeds, none of these", defects=Defects(), speeds_hz=FOUR),
    Case(
        name="camera tilted by 1.8°, lens centre 6 px off",
        defects=Defects(
            tilt_about_row_rad=1.4 * DEG, tilt_about_column_rad=-1.1 * DEG, focal_length_px=300.0, lens_centre_row_px=3.0,
            lens_centre_column_px=-5.0, distortion=-0.03,
        ),
        is_photon=False,
    ),
    Case(
        name="blur 0.55 px over rows, 0.95 px over columns",
        defects=Defects(blur_rows_px=0.55, blur_columns_px=0.95),
        is_photon=False,
    ),
    Case(name="glare, 3 % over 6 px", defects=Defects(glare_share=0.03, glare_px=6.0), is_photon=False),
    Case(name="recursive filter, 6 % of the frame before", defects=Defects(filter_share=0.06), is_photon=False),
    Case(name="second blade 1.2 % warmer", defects=Defects(blade_share=0.012), is_photon=False),
)  # fmt: skip


def drawn(case: Case, seed: int) -> SimulatedRig:
    """The rig with its defect, and what its owner knows of it."""
    nominal = paper_scene(*SHAPE) if case.is_photon else microbolometer_scene(*SHAPE)
    rig = twin.draw(nominal, seed=seed)
    knowledge = Knowledge(u_integration_time_s=15e-6 if case.defects.count_time_error_s else None)
    rig = SimulatedRig(scene=with_defects(rig.scene, case.defects), measured=rig.measured)
    return known(rig, seed=seed, knowledge=knowledge)


def recorded(case: Case, rig: SimulatedRig, folder: Path, *, seed: int) -> list[Path]:
    """Recordings in files, and rig.toml beside them."""
    paths = []
    for k, speed in enumerate(case.speeds_hz):
        for recording in twin.series(with_wheel_speed(rig.scene, speed), (0.0,), repeats=1, seed=100 * seed + k):
            paths.append(folder / f"{speed:g}Hz.nxs")
            writer.write(recording, paths[-1])
    write_rig(rig.measured, folder / "rig.toml")
    return paths


def now(paths: list[Path], rig: SimulatedRig) -> dict[str, Outcome]:
    """By this program."""
    best = analyse([reader.read(path) for path in paths], rig.measured).best
    severities = [finding.severity for finding in best.findings]
    return {
        name: Outcome(
            error_s=best.estimate.value(name) - truth,
            u_s=best.estimate.u(name),
            warnings=severities.count("warning"),
            doubts=severities.count("doubt"),
        )
        for name, truth in _truth(rig).items()
        if name in best.estimate
    }


def before(paths: list[Path], rig: SimulatedRig, checkout: Path) -> dict[str, Outcome]:
    """By the program of another checkout, with what it knows of rig.toml."""
    folder = paths[0].parent
    plain, out = folder / "plain.toml", folder / "before.json"
    plain.write_text(UNKNOWN_TO_IT.sub("", (folder / "rig.toml").read_text()))
    words = ["analyse", *map(str, paths), "--rig", str(plain), "--json", str(out)]
    command = [sys.executable, "-c", "from irtiming.cli.main import run; run()", *words]
    environment = {**os.environ, "PYTHONPATH": str(checkout / "src")}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        return {"trigger_delay": Outcome(refused=done.stderr.strip().splitlines()[-1])}
    result = json.loads(out.read_text())
    return {
        name: Outcome(
            error_s=result["parameters"][name]["value"] - truth,
            u_s=result["parameters"][name]["standard_uncertainty"],
            warnings=len(result["warnings"]),
        )
        for name, truth in _truth(rig).items()
        if name in result["parameters"]
    }


def _truth(rig: SimulatedRig) -> dict[str, float]:
    timing = rig.scene.timing
    return {name: getattr(timing, f"{name}_s") for name in MICROBOLOMETER if hasattr(timing, f"{name}_s")}


def compared(seed: int, checkout: Path) -> Iterator[tuple[Case, str, Outcome, Outcome]]:
    """Each parameter of each case by both programs; printed on the way."""
    print(f"{'defect':48} {'parameter':14} {'before, us':>22} {'now, us':>22}  doubts")
    for case in CASES:
        with tempfile.TemporaryDirectory() as place:
            rig = drawn(case, seed)
            paths = recorded(case, rig, Path(place), seed=seed)
            old, new = before(paths, rig, checkout), now(paths, rig)
        for name in MICROBOLOMETER:
            if name in old or name in new:
                both = old.get(name, Outcome(refused="no number")), new.get(name, Outcome(refused="no number"))
                print(
                    f"{case.name:48} {name:14} {_shown(both[0]):>22} {_shown(both[1]):>22}  {both[1].doubts}",
                    flush=True,
                )
                yield case, name, *both


def _shown(one: Outcome) -> str:
    return one.refused[:22] or f"{1e6 * one.error_s:+9.2f} / {1e6 * one.u_s:.2f}"


def figure(rows: list[tuple[Case, str, Outcome, Outcome]], path: Path) -> None:
    """Errors over their stated uncertainty, before and now, on a logarithmic scale."""
    drawing = Figure(figsize=(9.5, 0.42 * len(rows) + 1.4), layout="constrained")
    axes = drawing.add_subplot()
    y = np.arange(len(rows))[::-1]
    for k, (label, colour, marker) in enumerate((("before", "#c44e52", "o"), ("now", "#4c72b0", "D"))):
        pulls = np.array([abs(row[2 + k].error_s / row[2 + k].u_s) for row in rows])
        axes.plot(np.maximum(pulls, 0.05), y, marker, color=colour, label=label)
        for place, row in zip(y, rows, strict=True):
            if row[2 + k].refused:
                axes.text(4.5, place, f"{label}: no number", va="center", color=colour, fontsize=8)
    axes.axvspan(0.05, 2, color="#4c72b0", alpha=0.12, lw=0)
    axes.axvline(4, color="0.5", lw=0.8, ls=":")
    axes.set_xscale("log")
    axes.set_xlim(0.045, 400)
    axes.set_xticks([0.1, 1, 4, 10, 100], ["0.1", "1", "4", "10", "100"])
    axes.set_yticks(y, [f"{case.name}: {name.replace('_', ' ')}" for case, name, _, _ in rows], fontsize=8)
    axes.set_xlabel("|estimate − truth| in stated standard uncertainties (shaded: within 2)")
    axes.legend(loc="upper right", frameon=False)
    drawing.savefig(path)


def main() -> None:
    """Print the table, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=Path, required=True, help="checkout of an earlier program")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--rows", type=Path, help="write the numbers there as JSON")
    asked = parser.parse_args()
    rows = list(compared(asked.seed, asked.before))
    if asked.rows:
        asked.rows.write_text(json.dumps([(c.name, n, asdict(old), asdict(new)) for c, n, old, new in rows], indent=1))
    if asked.figure:
        figure(rows, asked.figure)


if __name__ == "__main__":
    main()
