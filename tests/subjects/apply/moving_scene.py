"""A moving scene, known at all times, and cameras that film it: brute force in small steps, no formula of the program."""

from dataclasses import dataclass

import numpy as np

STEP_S = 1e-4


@dataclass(frozen=True)
class FilmedBy:
    """A camera: times in s; ``tau_s`` 0 for a photon camera, whose window is ``window_s``; ``share`` of a recursive filter."""

    row_delay_s: float = 0.0
    tau_s: float = 0.0
    window_s: float = 0.0
    share: float = 0.0
    interval_s: float = 0.03
    delay_s: float = 0.004


@dataclass(frozen=True)
class Film:
    """Frames (frame, row, column), when each was triggered (frame,), and the scene at any time."""

    frames: np.ndarray
    trigger_s: np.ndarray
    camera: FilmedBy

    @staticmethod
    def edge_px(time_s):
        """Where the edge is: it swings by 9 px at 1.5 Hz."""
        return 24.3 + 9 * np.sin(2 * np.pi * 1.5 * np.asarray(time_s))

    @staticmethod
    def warmth(time_s):
        """The even field: a temperature that goes as a sine of 2 Hz."""
        return 500 + 400 * np.sin(2 * np.pi * 2 * np.asarray(time_s) + 0.4)


HIGH, LOW = 1000.0, 100.0
ROWS, COLUMNS, EDGE_COLUMNS = 32, 56, 48


def _scene(time_s):
    """What all pixels see, (row, column): on the left a bright side that covers pixels by area, on the right the even field."""
    covered = np.clip(Film.edge_px(time_s) - np.arange(EDGE_COLUMNS), 0, 1)
    row = np.append(LOW + (HIGH - LOW) * covered, np.full(COLUMNS - EDGE_COLUMNS, Film.warmth(time_s)))
    return np.tile(row, (ROWS, 1))


def film(camera, *, n_frames=40, noise=0.0):
    """Film by a camera."""
    trigger_s = 0.1 + camera.interval_s * np.arange(n_frames)
    first = trigger_s[0] + camera.delay_s + min(0, camera.row_delay_s * (ROWS - 1)) - 0.06
    frames = np.zeros((n_frames, ROWS, COLUMNS))
    late_s = camera.row_delay_s * np.arange(ROWS)
    begin = (trigger_s[:, None] + camera.delay_s + late_s).ravel()
    order = np.argsort(begin, kind="stable")
    if camera.tau_s:
        pixels, now, place = _scene(first), first, 0
        while place < begin.size:
            later = min(now + STEP_S, begin[order[place]])  # a step never runs past a reading
            seen = _scene((now + later) / 2)
            half = pixels + (seen - pixels) * (later - now) / (2 * camera.tau_s)
            pixels, now = pixels + (seen - half) * (later - now) / camera.tau_s, later
            while place < begin.size and begin[order[place]] <= now:
                frame, row = divmod(order[place], ROWS)
                frames[frame, row] = pixels[row]
                place += 1
    else:
        within = (np.arange(16) + 0.5) / 16 * camera.window_s
        for place, start in enumerate(begin):
            frame, row = divmod(place, ROWS)
            frames[frame, row] = np.mean([_scene(start + t)[row] for t in within], axis=0)
    frames += np.random.default_rng(5).normal(0, 1, frames.shape) * noise
    for n in range(1, n_frames):
        frames[n] = (1 - camera.share) * frames[n] + camera.share * frames[n - 1]
    return Film(frames=frames, trigger_s=trigger_s, camera=camera)
