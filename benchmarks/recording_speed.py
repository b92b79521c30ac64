"""The writer of recordings against plain h5py: frames per second, and its share of a core at four times 30.303 Hz.

Frames of the simulated microbolometer camera, 640 x 480 pixels of 16 bits, are written (a) by plain h5py, one per chunk, neither
compressed nor brought out of HDF5's hands before the end; (b) as `LiveRecording` does: compressed, with checksum, number, times
and status of each frame, and the frame in the file when the call returns; (c) the same without bringing each frame out. The
rounds take turns, and the best of each counts. Then (b) at the camera's pace.

    python benchmarks/recording_speed.py
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from unittest.mock import patch

import h5py
import numpy as np

from irtiming.archive.live.recording import LiveRecording
from irtiming.records.camera_frame import CameraFrame
from killed_recordings import head, trigger_ticks

ROWS, COLUMNS, RATE_HZ, DIFFERENT = 480, 640, 4 * 30.303, 60


def twin_frames() -> np.ndarray:
    from dataclasses import replace

    from irtiming.twin import rig as twin
    from irtiming.twin.scene import microbolometer_scene

    scene = microbolometer_scene(ROWS, COLUMNS)
    drawn = twin.draw(replace(scene, trigger=replace(scene.trigger, n_triggers=DIFFERENT)), seed=1)
    return np.concatenate([block.copy() for _, block in twin.simulate(drawn.scene, seed=1).frames.blocks()])


def write_plain(frames: np.ndarray, folder: Path, n_frames: int) -> None:
    path = folder / "plain.h5"
    with h5py.File(path, "w") as file:
        data = file.create_dataset(
            "data", shape=(0, ROWS, COLUMNS), maxshape=(None, ROWS, COLUMNS), chunks=(1, ROWS, COLUMNS), dtype=np.uint16
        )
        for index in range(n_frames):
            data.resize(index + 1, axis=0)
            data[index] = frames[index % len(frames)]
    path.unlink()


def write_live(frames: np.ndarray, folder: Path, n_frames: int, *, rate_hz: float = 0.0) -> list[float]:
    """How long each frame took, s."""
    took_s: list[float] = []
    path = folder / "live.nxs"
    with LiveRecording(path, head=head(ROWS, COLUMNS)) as live:
        live.append_ticks("camera_trigger", trigger_ticks(np.arange(n_frames)))
        slots = trigger_ticks(0) + 163_840 * np.arange(n_frames * 10)
        live.append_ticks("control_slot", slots)
        live.append_ticks("application_slot", slots[::50])
        begin = time.perf_counter()
        for index in range(n_frames):
            if rate_hz:
                time.sleep(max(0.0, begin + index / rate_hz - time.perf_counter()))
            frame = CameraFrame(
                pixels=frames[index % len(frames)], frame_id=index, device_timestamp_ticks=0, host_time_s=0.0
            )
            called = time.perf_counter()
            live.append_frame(frame, frame_number=index)
            took_s.append(time.perf_counter() - called)
        live.finish()
    path.unlink()
    return took_s


def write_unflushed(frames: np.ndarray, folder: Path, n_frames: int) -> None:
    with patch.object(h5py.Dataset, "flush", lambda _: None):
        write_live(frames, folder, n_frames)


def times_of(work: Callable[[], None]) -> tuple[float, float]:
    """Elapsed time and that of the processor, s."""
    begin, begin_cpu = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - begin, time.process_time() - begin_cpu


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--folder", type=Path, help="where to write; if not given, that for temporary files")
    options = parser.parse_args()
    n_frames = options.frames
    frames = twin_frames()
    names = {"plain h5py": write_plain, "LiveRecording": write_live, "... without flush": write_unflushed}
    best = dict.fromkeys(names, (np.inf, np.inf))
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        folder = Path(name)
        for _ in range(options.rounds):
            for label, write in names.items():
                best[label] = min(best[label], times_of(lambda write=write: write(frames, folder, n_frames)))
        took_s: list[float] = []
        _, cpu_s = times_of(lambda: took_s.extend(write_live(frames, folder, n_frames, rate_hz=RATE_HZ)))
    print(f"{'':18} {'frames/s':>9} {'CPU per frame':>14} {'over plain h5py':>16}")
    for label, (elapsed, cpu) in best.items():
        ratio = best["plain h5py"][0] / elapsed
        print(f"{label:18} {n_frames / elapsed:9.0f} {1e3 * cpu / n_frames:11.2f} ms {ratio:15.2f}x")
    share, p99_ms = cpu_s * RATE_HZ / n_frames, 1e3 * np.quantile(took_s, 0.99)
    print(
        f"at {RATE_HZ:.1f} frames/s: {share:.1%} of one core; a frame takes {1e3 * np.median(took_s):.1f} ms, one in a "
        f"hundred {p99_ms:.1f} ms, the longest {1e3 * max(took_s):.1f} ms of {1e3 / RATE_HZ:.2f} ms"
    )


if __name__ == "__main__":
    main()
