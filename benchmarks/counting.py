"""Counting pixels above a threshold: our kernel against plain NumPy and against the memory's read bandwidth.

The alternative does what the paper describes: correct each frame for non-uniformity, compare with the threshold, count.
Ours folds the correction into one integer threshold per pixel and never makes a corrected frame. The bandwidth is that of
two threads that add up the same memory. All three run in turn, several times over; the best time of each counts, and the
counts must agree to the last pixel.

    python benchmarks/counting.py
"""

import argparse
import time
from collections.abc import Callable

import numpy as np
from numba import get_num_threads, njit, prange, set_num_threads

from irtiming.reduce.kernels import count_above
from irtiming.reduce.nonuniformity import Correction, raw_thresholds

ROWS, COLUMNS, THRESHOLD_DN = 512, 640, 5000.0


@njit(parallel=True, fastmath=True)
def add_up(words):
    parts = np.zeros(words.shape[0], np.uint64)
    for part in prange(words.shape[0]):
        total = np.uint64(0)
        row = words[part]
        for i in range(row.size):
            total += row[i]
        parts[part] = total
    return parts.sum()


def correct_and_count(frames, gain, offset):
    """Plain NumPy: one corrected frame after the other."""
    return np.array([np.count_nonzero(frame * gain + offset > THRESHOLD_DN) for frame in frames])


def best_times(works: list[Callable[[], object]], rounds: int) -> list[float]:
    best = [np.inf] * len(works)
    for _ in range(rounds):
        for k, work in enumerate(works):
            start = time.perf_counter()
            work()
            best[k] = min(best[k], time.perf_counter() - start)
    return best


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--frames", type=int, default=400)
    arguments.add_argument("--rounds", type=int, default=7)
    options = arguments.parse_args()
    set_num_threads(min(2, get_num_threads()))

    random = np.random.default_rng(1)
    gain = random.normal(1, 0.02, (ROWS, COLUMNS))
    offset = random.normal(0, 60, (ROWS, COLUMNS))
    frames = random.integers(0, 2**14, (options.frames, ROWS, COLUMNS), dtype=np.uint16)
    thresholds = raw_thresholds(THRESHOLD_DN, Correction(gain=gain, offset_dn=offset, bad=np.zeros(gain.shape, bool)))
    words = frames.reshape(16, -1).view(np.uint64)

    assert np.array_equal(count_above(frames, thresholds), correct_and_count(frames, gain, offset))
    add_up(words)
    read, ours, plain = best_times(
        [
            lambda: add_up(words),
            lambda: count_above(frames, thresholds),
            lambda: correct_and_count(frames, gain, offset),
        ],
        options.rounds,
    )
    size = frames.nbytes / 1e9
    print(f"{options.frames} frames of {ROWS} x {COLUMNS}, {get_num_threads()} threads, best of {options.rounds}")
    print(f"memory read        {size / read:7.2f} GB/s")
    print(f"our count          {size / ours:7.2f} GB/s   {read / ours:6.1%} of the read bandwidth")
    print(f"correct-and-count  {size / plain:7.2f} GB/s   ours is {plain / ours:.1f} times faster")


if __name__ == "__main__":
    main()
