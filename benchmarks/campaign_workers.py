"""Campaigns on one Dask worker and on two: wall time, processor time, and the same table when a worker is killed on the way.

Cameras of the same rig, one recording each. In turn, round after round, all are measured anew with one worker and with two.
Efficiency is T1 / (2 T2) by wall time of the units alone, from the first that is given out to the last that is done, so without
the start of Python. By processor time it is that of all processes with one worker over that with two: what it costs that there
are two, which others on the machine hardly change. With ``--kill`` one of two workers is killed (SIGKILL) when a third of the
units is done.

    python benchmarks/campaign_workers.py --cameras 16 --rounds 2 --kill
"""

import argparse
import os
import resource
import signal
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from irtiming.archive import rig_writer, writer
from irtiming.session.campaign import TABLE, Order, run
from irtiming.twin.rig import draw, simulate
from irtiming.twin.scene import paper_scene, with_wheel_speed


@dataclass(frozen=True, kw_only=True)
class Size:
    """Of the campaign and its recordings."""

    cameras: int
    rows: int
    columns: int
    frames: int


@dataclass(frozen=True, kw_only=True)
class Took:
    """Wall time of the units, of the whole, and processor time of all processes, s; the table."""

    units_s: float
    whole_s: float
    processor_s: float
    table: bytes


def make(folder: Path, size: Size) -> None:
    """Recordings of cameras with delays of their own, before one wheel."""
    rng = np.random.default_rng(3)
    scene = with_wheel_speed(paper_scene(size.rows, size.columns), 3.0, frame_hz=30.303, samples=size.frames)
    drawn = draw(replace(scene, radiance=replace(scene.radiance, reference_frames=20)), seed=5)
    rig_writer.write_rig(drawn.measured, folder / "rig.toml")
    for k in range(size.cameras):
        timing = replace(drawn.scene.timing, trigger_delay_s=400e-6 + float(rng.normal(0, 60e-6)))
        one = simulate(replace(drawn.scene, timing=timing), seed=k + 1, name=f"C{k:03d}")
        writer.write(replace(one, camera=replace(one.camera, serial_number=one.name)), folder / f"{one.name}.nxs")


def measure(folder: Path, *, workers: int, kill: bool = False) -> Took:
    """All units anew."""
    times: list[float] = []
    killed: list[int] = []

    def told(name: str, done: int, total: int) -> None:
        if name.startswith("recordings"):
            return
        times.append(time.perf_counter())
        if kill and not killed and done >= total // 3:
            killed.append(_youngest_worker())
            os.kill(killed[0], signal.SIGKILL)

    with tempfile.TemporaryDirectory() as place:
        before, began = _processor_s(), time.perf_counter()
        order = Order(source=folder, rig=folder / "rig.toml", out=Path(place) / "out", workers=workers, register="none")
        done = run(order, progress=told)
        whole_s = time.perf_counter() - began
        if done.campaign.broken:
            raise SystemExit(f"not all could be measured: {done.campaign.broken}")
        table = (Path(place) / "out" / TABLE).read_bytes()
    return Took(units_s=times[-1] - times[0], whole_s=whole_s, processor_s=_processor_s() - before, table=table)


def _processor_s() -> float:
    """Of this process and all that it has waited for."""
    used = [resource.getrusage(which) for which in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def _youngest_worker() -> int:
    """Process of the worker that was started last; Python's own helpers are no workers."""
    children = [int(n) for path in Path("/proc/self/task").glob("*/children") for n in path.read_text().split()]
    return max(n for n in children if b"spawn_main" in Path(f"/proc/{n}/cmdline").read_bytes())


def main() -> None:
    """Print one line per measurement, and the efficiencies."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, value in (("cameras", 16), ("rows", 120), ("columns", 160), ("frames", 1000), ("rounds", 2)):
        parser.add_argument(f"--{name}", type=int, default=value)
    parser.add_argument("--kill", action="store_true")
    asked = parser.parse_args()
    size = Size(cameras=asked.cameras, rows=asked.rows, columns=asked.columns, frames=asked.frames)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        make(folder, size)
        found: dict[int, list[Took]] = {1: [], 2: []}
        for _ in range(asked.rounds):
            for workers, all_of in found.items():
                one = measure(folder, workers=workers)
                all_of.append(one)
                load = os.getloadavg()[0]
                took = f"units {one.units_s:.1f} s, whole {one.whole_s:.1f} s, processor {one.processor_s:.1f} s"
                print(f"{workers} workers: {took}, load {load:.1f}", flush=True)
        best = {n: min(each.units_s for each in all_of) for n, all_of in found.items()}
        used = {n: min(each.processor_s for each in all_of) for n, all_of in found.items()}
        tables = {each.table for all_of in found.values() for each in all_of}
        wall, processor = best[1] / (2 * best[2]), used[1] / used[2]
        print(f"efficiency by wall time {wall:.3f}, by processor time {processor:.3f}; {len(tables)} table")
        if asked.kill:
            one = measure(folder, workers=2, kill=True)
            print(f"one of two killed: units {one.units_s:.1f} s; the same table: {one.table in tables}")


if __name__ == "__main__":
    main()
