"""Whether every valid set of recordings ends in a result: random laboratories of all four cameras, one to six wheel speeds.

Cameras, readouts, numbers of speeds, speeds and image sizes are drawn; most images are small, some have 512 rows and 640
columns. All defects of a laboratory are there at once. A refusal counts as an end that must not be.
What became of each rig goes into a file of JSON lines as soon as it is known; a run that was interrupted goes on there.

    .venv/bin/python benchmarks/settling.py --rigs 1000 --out settling.jsonl
"""

import argparse
import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import get_args

import numpy as np

from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.twin.random_laboratory import Wanted
from laboratory_coverage import known_lines, one_rig, table

SLOWEST_HZ, FASTEST_HZ = 2.0, 12.0
ROWS, COLUMNS = (120, 512), (160, 640)
MOST_SPEEDS = 6
LEAST_STEP = 0.1  # between the logarithms of two speeds
MOSTLY_SMALL = 3.0
FRAMES = 300
KINDS = [(camera, readout) for camera in get_args(CameraType) for readout in get_args(ReadoutMode)]


def wanted(seed: int) -> Wanted:
    """Kind of the laboratory of this seed; its speeds differ by a tenth at least."""
    random = np.random.default_rng((20261125, seed))
    camera, readout = KINDS[seed % len(KINDS)]
    grown = random.uniform() ** MOSTLY_SMALL
    rows, columns = (round(low * (high / low) ** grown) for low, high in (ROWS, COLUMNS))
    n_speeds = int(random.integers(1, MOST_SPEEDS + 1))
    room = np.log(FASTEST_HZ / SLOWEST_HZ) - LEAST_STEP * (n_speeds - 1)
    steps = np.sort(random.uniform(0, room, n_speeds)) + LEAST_STEP * np.arange(n_speeds)
    speeds = SLOWEST_HZ * np.exp(steps)
    return Wanted(
        camera=camera, readout=readout, rows=rows, columns=columns, frames=FRAMES, wheel_hz=tuple(speeds.round(3).tolist())
    )  # fmt: skip


def ended(seed: int) -> dict[str, object]:
    """What became of the laboratory of this seed, ready for a line of JSON."""
    return one_rig(wanted(seed), seed)


def summary(lines: Sequence[dict[str, object]]) -> str:
    """Ends by kind of camera; pulls over all, and the words of the first refusals."""
    rows = ["| camera | readout | rigs | speeds | refused | s per rig |", "| --- | --- | ---: | ---: | ---: | ---: |"]
    for camera, readout in KINDS:
        mine = [line for line in lines if (line["camera"], line["readout"]) == (camera, readout)]
        if mine:
            refused = sum("refused" in line for line in mine)
            speeds = np.mean([len(line["wheel_hz"]) for line in mine])  # type: ignore[arg-type]
            seconds = np.mean([line["seconds"] for line in mine])  # type: ignore[arg-type]
            rows.append(f"| {camera} | {readout} | {len(mine)} | {speeds:.1f} | {refused} | {seconds:.1f} |")
    rows.append("")
    rows.append(table(list(lines)))
    return "\n".join(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0, help="of the first rig")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="JSON lines; rigs that are there already are not tried again")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.rigs)
    there = {line["seed"]: line for line in known_lines(options.out)}
    missing = [seed for seed in seeds if seed not in there]
    with ProcessPoolExecutor(options.workers) as pool:
        for line in pool.map(ended, missing):
            there[line["seed"]] = line
            if options.out is not None:
                with options.out.open("a") as file:
                    file.write(json.dumps(line) + "\n")
    print(summary([there[seed] for seed in seeds]))


if __name__ == "__main__":
    main()
