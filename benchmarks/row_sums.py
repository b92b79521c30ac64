"""The reduction of a rolling microbolometer recording against reading its frames alone.

A simulated recording is written to a file, as a camera would leave it. Then, in turn and several times over, its frames are
(a) read and decompressed block by block and thrown away, and (b) reduced: looked at, read once, judged, summed row by row and
projected. The best time of each counts. Of (b) the single pass over all frames is told apart: what comes before and after takes
the same time however long the recording. At the end the largest memory that the process ever held is told; writing the recording
is done by another process, so that it has no part in it.

    python benchmarks/row_sums.py
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from irtiming.archive import reader, rig_file, rig_writer
from irtiming.records.choices import Choices
from irtiming.records.recording import Recording
from irtiming.records.rig import Rig
from irtiming.reduce import recipes

ROWS, COLUMNS = 480, 640


def read_all(recording: Recording) -> int:
    """Touch a pixel of every block, so that nobody can say it was not read."""
    return sum(int(block[0, 0, 0]) for _, block in recording.frames.blocks())


def best_times(works: list[Callable[[], object]], rounds: int) -> list[float]:
    best = [np.inf] * len(works)
    for _ in range(rounds):
        for k, work in enumerate(works):
            start = time.perf_counter()
            work()
            best[k] = min(best[k], time.perf_counter() - start)
    return best


class TimedPass:
    """The best time of the single pass, from what it tells after each block; the first block is not in it."""

    def __init__(self, recording: Recording, rig: Rig) -> None:
        self.recording, self.rig, self.best_s = recording, rig, np.inf

    def __call__(self) -> None:
        told: list[tuple[int, float]] = []
        recipes.reduce(
            self.recording,
            self.rig,
            choices=Choices(),
            progress=lambda frames: told.append((frames, time.perf_counter())),
        )
        (first, begin), (last, end) = told[0], told[-1]
        self.best_s = min(self.best_s, (end - begin) * last / (last - first))


def simulate(folder: Path, frames: int) -> None:
    from dataclasses import replace

    from irtiming.archive import writer
    from irtiming.twin import rig as twin
    from irtiming.twin.scene import microbolometer_scene
    from irtiming.twin.upkeep import SelfCorrection, ShutterEvent

    scene = microbolometer_scene(ROWS, COLUMNS)
    events = (ShutterEvent(start_s=7.0), ShutterEvent(start_s=20.0, kind="frozen"))
    scene = replace(scene, trigger=replace(scene.trigger, n_triggers=frames), correction=SelfCorrection(events=events))
    drawn = twin.draw(scene, seed=1)
    writer.write(twin.simulate(drawn.scene, seed=1), folder / "bolo.nxs", overwrite=True)
    rig_writer.write_rig(drawn.measured, folder / "rig.toml")


def peak_bytes() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--frames", type=int, default=2000)
    arguments.add_argument("--rounds", type=int, default=3)
    arguments.add_argument("--folder", type=Path, help="keeps the recording here, and takes one that is here already")
    arguments.add_argument("--write-only", action="store_true", help=argparse.SUPPRESS)
    options = arguments.parse_args()
    if options.write_only:
        simulate(options.folder, options.frames)
        return
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        if not (folder / "bolo.nxs").exists():
            own = [sys.executable, __file__, "--write-only", "--folder", str(folder), "--frames", str(options.frames)]
            subprocess.run(own, check=True)
        recording = reader.read(folder / "bolo.nxs")
        rig = rig_file.read_rig(folder / "rig.toml")
        idle = peak_bytes()
        reduce = TimedPass(recording, rig)
        reduce()  # compiles
        read, ours = best_times([lambda: read_all(recording), reduce], options.rounds)
        on_disk = (folder / "bolo.nxs").stat().st_size
    n_frames = recording.frames.shape[0]
    size = n_frames * ROWS * COLUMNS * 2
    print(f"{n_frames} frames of {ROWS} x {COLUMNS}, {on_disk / 1e6:.0f} MB on disk, best of {options.rounds}")
    print(f"read and decompress  {read:6.2f} s   {n_frames / read:6.0f} frames/s   {size / read / 1e9:5.2f} GB/s")
    print(
        f"reduce               {ours:6.2f} s   {n_frames / ours:6.0f} frames/s   {read / ours:5.0%} of the reading speed"
    )
    once = reduce.best_s
    print(
        f"its single pass      {once:6.2f} s   {n_frames / once:6.0f} frames/s   {read / once:5.0%} of the reading speed"
    )
    print(f"peak memory          {peak_bytes() / 1e6:6.0f} MB, {idle / 1e6:.0f} MB of it before the first frame")


if __name__ == "__main__":
    main()
