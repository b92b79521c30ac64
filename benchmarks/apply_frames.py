"""Speed of ``irtiming apply frames`` against the same steps in NumPy, in one run; from file to file with the memory it takes.

In memory, processor time counts, so that other programs do not; from file to file, time by the clock as well. With --gigabytes,
files of these sizes in turn, each removed before the next: time must grow in proportion, memory not at all.

Usage: python benchmarks/apply_frames.py [--frames 400] [--rows 480] [--columns 640] [--in-file 1500]
       python benchmarks/apply_frames.py --gigabytes 3 6 12 --folder DIR
"""

import argparse
import json
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import deque
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from irtiming.apply.frames import Readout, SceneStream
from irtiming.apply.inverse_lag import Response, responses, step
from irtiming.archive.hdf5_file import h5py

READOUT = Readout(response=Response(time_constant_s=5e-3, recursive_filter=0.1), row_delay_s=37e-6)
PERIOD_S, NOISE = 1 / 30.303, 10.0


def frames_of(rows, columns, count=32):
    """Noise about an edge that moves by 5 px a frame."""
    rng = np.random.default_rng(1)
    edge = 2000.0 * (np.arange(columns) < 100 + 5 * np.arange(count)[:, None])
    return (8000 + edge[:, None, :] + rng.normal(0, NOISE, (count, rows, columns))).astype(np.uint16)


class InNumpy:
    """The same numbers by whole-array operations, for frames at equal times."""

    def __init__(self, rows, columns):
        one = step(READOUT.response, PERIOD_S)
        self.one, self.power = one, NOISE**2 * responses(one).correction_power
        self.knots = deque(maxlen=5)
        late = READOUT.lateness_s(rows)
        after = -late >= 0
        times = np.where(after[:, None], np.arange(-1, 3), np.arange(-2, 2)) * PERIOD_S + late[:, None]
        weights = np.ones((rows, 4))
        for k in range(4):
            for other in range(4):
                if other != k:
                    weights[:, k] *= -times[:, other] / (times[:, k] - times[:, other])
        self.starts, self.weights = after.astype(int), weights.astype(np.float32)
        self.last = None

    def push(self, frame):
        """One frame in, one scene out once five are there."""
        value = frame.astype(np.float32)
        if self.last is None:
            self.last, self.pixel, self.scene = value, value, value
            corrected = value
        else:
            one = self.one
            seen = (value - np.float32(one.filter_share) * self.last) / np.float32(1 - one.filter_share)
            found = (seen - np.float32(one.decay) * self.pixel - np.float32(one.before) * self.scene) / np.float32(
                one.now
            )
            self.last, self.pixel, self.scene = value, seen, found
            change = found - value
            tiles = (change**2).reshape(frame.shape[0] // 8, 8, frame.shape[1] // 8, 8).mean(axis=(1, 3))
            gain = np.maximum(0, 1 - np.float32(self.power) / tiles)
            corrected = value + np.repeat(np.repeat(gain, 8, axis=0), 8, axis=1) * change
        self.knots.append(corrected)
        if len(self.knots) < 5:
            return None
        out = np.zeros_like(value)
        for start in (0, 1):
            at = self.starts == start
            for k in range(4):
                out[at] += self.weights[at, k : k + 1] * self.knots[start + k][at]
        return out


def in_memory(count, rows, columns):
    """Frames per second of both, taken in turns, and by how much they differ at most."""
    frames = frames_of(rows, columns)
    ours, theirs, differ = [], [], 0.0
    for _ in range(3):
        stream, plain = (
            SceneStream(READOUT, size=(rows, columns), interval_s=PERIOD_S, noise=NOISE),
            InNumpy(rows, columns),
        )
        spent = [0.0, 0.0]
        for n in range(count):
            start = process_time()
            found = [one.pixels for one in stream.push(frames[n % 32], index=n, time_s=n * PERIOD_S)]
            spent[0] += process_time() - start
            start = process_time()
            other = plain.push(frames[n % 32])
            spent[1] += process_time() - start
            if other is not None:
                differ = max(differ, float(np.abs(found[0] - other).max()))
        ours.append(count / spent[0])
        theirs.append(count / spent[1])
    return max(ours), max(theirs), differ


def result_json():
    """A result of such a camera."""
    event = {"reference_event": "", "sign": None, "expanded_uncertainty": None, "coverage_factor": 2.0}
    event |= {"effective_degrees_of_freedom": None}
    numbers = {"trigger_delay": 4e-3, "time_constant": 5e-3, "row_delay": 37e-6, "recursive_filter": 0.1}
    units = dict.fromkeys(numbers, "s") | {"recursive_filter": "1"}
    return {
        "format": "irtiming-result", "version": "1.1", "method": "", "camera": "microbolometer", "readout_mode": "rolling",
        "parameters": {k: event | {"value": v, "standard_uncertainty": v / 1e3, "unit": units[k]} for k, v in numbers.items()},
        "correlation": {"names": list(numbers), "matrix": np.eye(len(numbers)).tolist()},
        "relative_delays": [], "budget": [], "edge_delays": None, "warnings": [],
        "geometry": {}, "wheel": None, "choices": {}, "inputs": [], "rig": {"file": "", "sha256": ""}, "software": {},
    }  # fmt: skip


def from_file_to_file(count, rows, columns, folder):
    """Frames per second of the command's work, by the clock and of one processor, and the most memory it took, MiB."""
    frames = frames_of(rows, columns)
    source = folder / f"{count}.h5"
    with h5py.File(source, "w") as file:
        data = file.create_dataset("data", (count, rows, columns), "u2", chunks=(1, rows, columns))
        for n in range(count):
            data[n] = frames[n % 32]
    (folder / "result.json").write_text(json.dumps(result_json()))
    words = [str(folder / "result.json"), str(source), str(folder / "scene.nxs"), str(PERIOD_S)]
    done = subprocess.run([sys.executable, __file__, "--child", *words], capture_output=True, text=True, check=True)
    source.unlink()
    (folder / "scene.nxs").unlink()
    seconds, used, memory = map(float, done.stdout.split())
    return count / seconds, count / used, memory


def by_size(sizes, rows, columns, *, folder):
    """A line of a table for each size of file in GB (10^9 bytes of pixels)."""
    print("| pixels | frames | time | frames per second of a processor | most memory |")
    print("| ---: | ---: | ---: | ---: | ---: |", flush=True)
    for gigabytes in sizes:
        count = round(1e9 * gigabytes / (2 * rows * columns))
        free = shutil.disk_usage(folder).free
        if free < 2.5e9 * gigabytes:
            raise SystemExit(
                f"{folder}: {free / 1e9:.0f} GB are free, {2.5 * gigabytes:.0f} GB are needed; name another folder"
            )
        with tempfile.TemporaryDirectory(dir=folder) as place:
            speed, alone, memory = from_file_to_file(count, rows, columns, Path(place))
        print(f"| {gigabytes:g} GB | {count} | {count / speed:.0f} s | {alone:.0f} | {memory:.0f} MiB |", flush=True)


def child(result, source, out, period):
    """The work of the command in a process of its own: seconds, and the most memory in MiB."""
    from irtiming.session.apply_frames import FramesOrder, apply_frames

    start, used = perf_counter(), process_time()
    apply_frames(
        FramesOrder(result=Path(result), source=Path(source), out=Path(out), noise=NOISE, period_s=float(period))
    )
    print(perf_counter() - start, process_time() - used, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)


def main():
    """Print all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--rows", type=int, default=480)
    parser.add_argument("--columns", type=int, default=640)
    parser.add_argument("--in-file", type=int, default=1500)
    parser.add_argument("--gigabytes", type=float, nargs="+", default=())
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()))
    parser.add_argument("--child", nargs=4)
    given = parser.parse_args()
    if given.child:
        child(*given.child)
        return
    if given.gigabytes:
        by_size(given.gigabytes, given.rows, given.columns, folder=given.folder)
        return
    ours, theirs, differ = in_memory(given.frames, given.rows, given.columns)
    print(
        f"{given.columns} x {given.rows}, lag, filter and rolling rows, one thread; the fastest of three runs in turns"
    )
    print(f"compiled: {ours:.0f} frames/s   NumPy: {theirs:.0f} frames/s   ratio {ours / theirs:.1f}")
    print(f"largest difference of a pixel: {differ:.3f} DN")
    with tempfile.TemporaryDirectory() as folder:
        for count in (given.in_file // 5, given.in_file):
            speed, alone, memory = from_file_to_file(count, given.rows, given.columns, Path(folder))
            print(
                f"from file to file, {count} frames: {speed:.0f} frames/s by the clock, {alone:.0f} per second of a processor, "
                f"at most {memory:.0f} MiB"
            )


if __name__ == "__main__":
    main()
