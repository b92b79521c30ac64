"""What maps of every pixel cost: the single pass over the frames with and without, in the same run.

A recording of a rolling microbolometer camera of 800 x 600 pixels, whose opening has some 50 000, is simulated, kept as a file,
compressed as `irtiming record` leaves it, and in memory, where reading costs nothing and the ratio is at its worst. The best of
several passes counts; the two kinds take turns.

    .venv/bin/python benchmarks/maps_speed.py
"""

import argparse
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from irtiming.archive import reader, writer
from irtiming.archive.frame_stack import ArrayFrames
from irtiming.estimate import pixel_maps, timing
from irtiming.records.choices import Choices, Processor
from irtiming.records.recording import Recording
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.reduce import recipes
from irtiming.twin import rig as twin
from irtiming.twin.scene import microbolometer_scene


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Made:
    """One recording, as a file and in memory, and its rig."""

    stored: Recording
    kept: Recording
    rig: Rig


@contextmanager
def made(*, rows: int, frames: int) -> Iterator[Made]:
    """A simulated recording of a microbolometer camera; its file is there within."""
    scene = microbolometer_scene(rows, rows * 4 // 3)
    drawn = twin.draw(replace(scene, trigger=replace(scene.trigger, n_triggers=frames)), seed=1)
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "bolo.nxs"
        writer.write(twin.simulate(drawn.scene, seed=1), path)
        stored = reader.read(path)
        values = np.concatenate([block.copy() for _, block in stored.frames.blocks()])
        yield Made(stored=stored, kept=replace(stored, frames=ArrayFrames(values, block_frames=16)), rig=drawn.measured)


def pass_s(
    recording: Recording, rig: Rig, *, maps: bool, processor: Processor = "automatic"
) -> tuple[float, ReducedRecording]:
    """Time of the single pass, from what it tells after each block; the first block is not in it. And what it found."""
    told: list[tuple[int, float]] = []
    found = recipes.reduce(
        recording, rig, choices=Choices(processor=processor), maps=maps,
        progress=lambda n: told.append((n, time.perf_counter())),
    )  # fmt: skip
    (first, begin), (last, end) = told[0], told[-1]
    return (end - begin) * last / (last - first), found


def compare(name: str, recording: Recording, rig: Rig, *, rounds: int) -> None:
    pass_s(recording, rig, maps=True)  # compiles
    best, pixels = {False: np.inf, True: np.inf}, 0
    for _ in range(rounds):
        for maps in (False, True):
            taken_s, found = pass_s(recording, rig, maps=maps)
            best[maps] = min(best[maps], taken_s)
            pixels = pixels if found.waves is None else found.waves.row_px.size
    ratio = best[True] / best[False]
    print(f"{name:<18} pass {best[False]:.3f} s, with maps of {pixels} pixels {best[True]:.3f} s: {ratio:.2f} times")


def estimate(recording: Recording, rig: Rig) -> None:
    """Time of the estimate from what was reduced, and of the maps from both."""
    reduced = recipes.reduce(recording, rig, choices=Choices(), maps=True)
    begin = time.perf_counter()
    found = timing.estimate([reduced], rig)
    between = time.perf_counter()
    pixel_maps.maps(found, rig)
    print(f"estimate           {between - begin:.2f} s, maps from the sums {time.perf_counter() - between:.2f} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=600)
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--estimate", action="store_true", help="the estimate from the sums, too")
    options = parser.parse_args()
    with made(rows=options.rows, frames=options.frames) as one:
        compare("compressed file", one.stored, one.rig, rounds=options.rounds)
        compare("in memory", one.kept, one.rig, rounds=options.rounds)
        if options.estimate:
            estimate(one.kept, one.rig)


if __name__ == "__main__":
    main()
