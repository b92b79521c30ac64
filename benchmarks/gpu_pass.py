"""The single pass over the frames on a GPU against the compiled loops on all processors, in the same run, and how alike they are.

A recording of a rolling microbolometer camera of 800 x 600 pixels, whose opening has some 50 000, is simulated and kept as a
file, compressed as `irtiming record` leaves it, and in memory, where reading costs nothing. It is summed with and without maps of
every pixel. The best of several passes counts; the two processors take turns.

    .venv/bin/python benchmarks/gpu_pass.py
"""

import argparse

import numpy as np

from irtiming.records.choices import Processor
from irtiming.records.recording import Recording
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.reduce import device_memory
from maps_speed import made, pass_s

PROCESSORS: tuple[Processor, ...] = ("cpu", "gpu")


def apart(one: ReducedRecording, other: ReducedRecording) -> str:
    """Largest differences of row sums and of what maps are made of, relative to the largest value."""
    pairs = [("row sums", one.rows.row_sum_dn, other.rows.row_sum_dn)] if one.rows and other.rows else []
    if one.waves is not None and other.waves is not None:
        pairs.append(("waves", one.waves.sums_dn, other.waves.sums_dn))
    return ", ".join(f"{name} {np.abs(a - b).max() / np.abs(a).max():.1g}" for name, a, b in pairs)


def compare(name: str, recording: Recording, rig: Rig, *, rounds: int) -> None:
    for maps in (False, True):
        best, found = dict.fromkeys(PROCESSORS, np.inf), dict[str, ReducedRecording]()
        for _ in range(rounds + 1):  # the first compiles
            for processor in PROCESSORS:
                taken_s, found[processor] = pass_s(recording, rig, processor=processor, maps=maps)
                best[processor] = min(best[processor], taken_s)
        rate = {one: recording.frames.shape[0] / taken_s for one, taken_s in best.items()}
        print(
            f"{name}, {'with maps' if maps else 'no maps':<9}  processors {rate['cpu']:.0f} frames/s, GPU {rate['gpu']:.0f} "
            f"frames/s: {rate['gpu'] / rate['cpu']:.2f} times; apart by {apart(found['cpu'], found['gpu'])}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=600)
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    name = device_memory.gpu_name()
    if name is None:
        print("no GPU here that CuPy finds: nothing to compare")
        return
    print(name)
    with made(rows=options.rows, frames=options.frames) as one:
        compare("compressed file", one.stored, one.rig, rounds=options.rounds)
        compare("in memory      ", one.kept, one.rig, rounds=options.rounds)


if __name__ == "__main__":
    main()
