"""Errors and pulls over random simulated laboratories, with every defect at once or one alone.

Each laboratory has its own camera, wheel, gates, mask, optics and defects; rig.toml is off by the uncertainties that it
states. What became of each goes into a file of JSON lines, one per laboratory, as soon as it is known: a run that was
interrupted goes on where it stopped, and more laboratories are added to those that are there.

    .venv/bin/python benchmarks/laboratory_coverage.py --rigs 200 --camera photon --speeds 3 --out photon.jsonl
    .venv/bin/python benchmarks/laboratory_coverage.py --rigs 200 --camera microbolometer --speeds 2,3,5,8 --out bolo4.jsonl
    .venv/bin/python benchmarks/laboratory_coverage.py --rigs 40 --camera microbolometer --only filter --out filter.jsonl
    .venv/bin/python benchmarks/laboratory_coverage.py --rigs 40 --camera photon --only each --out alone.jsonl
    .venv/bin/python benchmarks/laboratory_coverage.py --rigs 60 --camera microbolometer --lens pincushion --out pincushion.jsonl

A laboratory is wrong without a word where a parameter is more than 4 u off and no finding is a doubt.
"""

import argparse
import json
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from functools import partial
from pathlib import Path
from time import monotonic

import numpy as np

from irtiming.errors import IrTimingError
from irtiming.measurement import analyse
from irtiming.records.recording import Recording
from irtiming.records.result import Result
from irtiming.twin import rig as rigs
from irtiming.twin.random_laboratory import Wanted, draw, groups, recordings
from irtiming.twin.rig import SimulatedRig

FAR_OFF = 4.0
KEY = ("camera", "readout", "rows", "columns", "frames", "wheel_hz", "only", "lens", "seed")
"""What makes a laboratory another one."""
SHARES = {"pixel_memory": "memory_share", "recursive_filter": "filter_share"}
"""Parameters without a unit, and what the truth calls them."""


def errors_of(result: Result, truth: dict[str, object]) -> dict[str, dict[str, float]]:
    """Error and standard uncertainty of every parameter that the truth knows: s, and of shares 1."""
    estimate, found = result.estimate, {}
    for name, value, u in zip(estimate.names, estimate.values, estimate.standard_uncertainties, strict=True):
        true, unit = truth.get(SHARES.get(name, f"{name}_s")), "" if name in SHARES else "_s"
        if isinstance(true, float) and u > 0:
            found[name] = {f"error{unit}": float(value) - true, f"u{unit}": float(u)}
    return found


def one_rig(wanted: Wanted, seed: int) -> dict[str, object]:
    """What became of one laboratory, ready for a line of JSON."""
    begun = monotonic()
    line: dict[str, object] = json.loads(json.dumps({**asdict(wanted), "seed": seed}))
    rig = draw(wanted, seed=seed)
    return line | outcome(rig, recordings(rig, wanted, seed=seed)) | {"seconds": monotonic() - begun}


def outcome(rig: SimulatedRig, made: Iterable[Recording]) -> dict[str, object]:
    """What the analysis makes of recordings of one rig: errors and findings, or why it was refused."""
    try:
        found = analyse(made, rig.measured)
        result = found.best
    except (IrTimingError, ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
        return {"refused": f"{type(error).__name__}: {error}"}
    return {
        "parameters": errors_of(result, rigs.truth(rig.scene)),
        "withheld": [bound.name for bound in result.bounds],
        "doubts": sorted({finding.code for finding in found.findings if finding.severity == "doubt"}),
        "warnings": sorted({finding.code for finding in found.findings if finding.severity == "warning"}),
    }


def key_of(line: dict[str, object]) -> str:
    """Of a laboratory; lines of before there were other lenses are of barrels."""
    whole = {"lens": "barrel"} | line
    return json.dumps([whole[name] for name in KEY])


def is_silently_wrong(line: dict[str, object]) -> bool:
    """Whether a number is far off and no finding says so."""
    both = [tuple(one.values()) for one in line.get("parameters", {}).values()]  # type: ignore[attr-defined]
    pulls = [abs(error) / u for error, u in both]
    return any(pull > FAR_OFF for pull in pulls) and not line["doubts"]


def table(lines: list[dict[str, object]]) -> str:
    """Errors and pulls of laboratories of one kind, parameter by parameter."""
    done = [line for line in lines if "refused" not in line]
    names = sorted({name for line in done for name in line["parameters"]})  # type: ignore[attr-defined]
    rows = [
        "| parameter | rigs | rms error, us or 1e-6 | rms u | rms pull | within 1 u | within 2 u | beyond 4 u | in doubt |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for name in names:
        having = [line for line in done if name in line["parameters"]]  # type: ignore[operator]
        error, u = np.array([tuple(line["parameters"][name].values()) for line in having]).T  # type: ignore[index]
        pull = np.abs(error / u)
        doubted = sum(bool(line["doubts"]) for line, one in zip(having, pull, strict=True) if one > FAR_OFF)
        rows.append(
            f"| {name.replace('_', ' ')} | {len(having)} | {1e6 * np.sqrt(np.mean(error**2)):.3f} | "
            f"{1e6 * np.sqrt(np.mean(u**2)):.3f} | {np.sqrt(np.mean(pull**2)):.2f} | {np.mean(pull < 1):.0%} | "
            f"{np.mean(pull < 2):.0%} | {np.sum(pull > FAR_OFF)} | {doubted} |"
        )
    refused = [line for line in lines if "refused" in line]
    silent = [line["seed"] for line in done if is_silently_wrong(line)]
    doubts = sum(bool(line["doubts"]) for line in done)
    rows.append("")
    rows.append(
        f"{len(done)} of {len(lines)} rigs with a result, {doubts} of them in doubt; {len(refused)} refused; wrong without a "
        f"word: {len(silent)}{f', seeds {silent[:20]}' if silent else ''}"
    )
    rows += [f"    seed {line['seed']}: {line['refused']}"[:240] for line in refused[:5]]
    return "\n".join(rows)


def known_lines(path: Path | None) -> list[dict[str, object]]:
    """What a file holds already; a last line that was cut off is left alone."""
    found: list[dict[str, object]] = []
    for text in path.read_text().splitlines() if path is not None and path.exists() else []:
        try:
            found.append(json.loads(text))
        except json.JSONDecodeError:
            print(f"a line of {path} is no JSON; it is left out")
    return found


def wanted_of(options: argparse.Namespace) -> list[Wanted]:
    """The kinds of laboratory that were asked for."""
    only = groups(options.camera) if options.only == "each" else [options.only]
    rates = tuple(float(text) for text in options.speeds.split(","))
    return [
        Wanted(camera=options.camera, readout=options.readout, rows=options.rows, columns=options.columns,
               frames=options.frames, wheel_hz=rates, only=one, lens=options.lens)
        for one in only
    ]  # fmt: skip


def tried(wanted: Wanted, options: argparse.Namespace, before: Iterable[dict[str, object]]) -> list[dict[str, object]]:
    """All laboratories of one kind: those of the file, and those that were missing there."""
    there = {key_of(line): line for line in before}
    keys = {seed: key_of(json.loads(json.dumps({**asdict(wanted), "seed": seed}))) for seed in seeds_of(options)}
    missing = [seed for seed, key in keys.items() if key not in there]
    if missing and options.out is not None and options.out.exists() and not options.out.read_text().endswith("\n"):
        options.out.write_text(options.out.read_text() + "\n")  # behind a line that was cut off
    with ProcessPoolExecutor(options.workers) as pool:
        for line in pool.map(partial(one_rig, wanted), missing):
            there[key_of(line)] = line
            if options.out is not None:
                with options.out.open("a") as file:
                    file.write(json.dumps(line) + "\n")
            if options.verbose:
                print(json.dumps(line), flush=True)
    return [there[key] for key in keys.values()]


def seeds_of(options: argparse.Namespace) -> range:
    return range(options.seed, options.seed + options.rigs)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--camera", choices=("photon", "microbolometer"), default="photon")
    parser.add_argument("--readout", choices=("snapshot", "rolling"), help="as usual for the camera if not given")
    parser.add_argument("--speeds", default="3", help="wheel rates of each rig, Hz, with commas between")
    parser.add_argument(
        "--only", help="one defect alone, or none, or 'each' for one after the other; all at once if not given"
    )
    parser.add_argument("--lens", choices=("barrel", "pincushion"), default="barrel", help="how lenses distort")
    parser.add_argument("--rigs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0, help="of the first rig")
    parser.add_argument("--rows", type=int, default=120)
    parser.add_argument("--columns", type=int, default=160)
    parser.add_argument("--frames", type=int, default=500)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="JSON lines; laboratories that are there already are not tried again")
    parser.add_argument("--verbose", action="store_true", help="print each line")
    options = parser.parse_args()
    if options.only not in (None, "each", *groups(options.camera)):
        parser.error(f"--only {options.only}; it must be 'each' or one of {', '.join(groups(options.camera))}")
    before = known_lines(options.out)
    for wanted in wanted_of(options):
        defects = "all defects at once" if wanted.only is None else f"defect: {wanted.only}"
        print(
            f"\n{options.rigs} laboratories, {options.camera}, {options.speeds} Hz, {options.columns} x {options.rows} pixels, "
            f"{options.frames} frames each, {options.lens} lenses, {defects}\n",
            flush=True,
        )
        print(table(tried(wanted, options, before)), flush=True)


if __name__ == "__main__":
    main()
