"""What ``irtiming apply frames`` gains: an edge that swings and a temperature under a sine, filmed in steps of 0.1 ms.

    .venv/bin/python benchmarks/accuracy/scene_at_one_instant.py [--figure docs/explanation/the-scene-at-one-instant.svg]

Prints rms errors of the edge's position and of the temperature, in the frames and in the scene that was found, for some kinds of
camera and signal-to-noise ratios. The figure shows an edge that moves by 5 px per frame.
"""

import argparse
from dataclasses import dataclass

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from irtiming.apply.frames import Readout, scenes
from irtiming.apply.inverse_lag import Response

PERIOD_S, STEP_S, ROWS, COLUMNS, FIELD, FRAMES, SKIPPED = 0.03, 1e-4, 64, 96, 16, 40, 6
HIGH = 1000.0


@dataclass(frozen=True)
class Kind:
    """A camera: row delay, time constant and share of the frame before; the edge swings by ``swing_px`` at 1.5 Hz."""

    name: str
    row_delay_s: float = 0.0
    time_constant_s: float = 0.0
    share: float = 0.0
    swing_px: float = 9.0


KINDS = (
    Kind("rolling, no lag", row_delay_s=3e-4),
    Kind("rolling, lag 5 ms", row_delay_s=3e-4, time_constant_s=5e-3),
    Kind("snapshot, lag 7 ms", time_constant_s=7e-3),
    Kind("snapshot, lag 5 ms, filter 0.3", time_constant_s=5e-3, share=0.3),
)


def edge_px(kind, time_s):
    """Where the edge is."""
    return 40 + kind.swing_px * np.sin(2 * np.pi * 1.5 * time_s)


def warmth(time_s):
    """Temperature of the field on the right."""
    return 500 + 400 * np.sin(2 * np.pi * 2 * time_s + 0.4)


def scene_at(kind, time_s):
    """What the pixels of a row see, (column,)."""
    covered = np.clip(edge_px(kind, time_s) - np.arange(COLUMNS - FIELD), 0, 1)
    return np.append(HIGH * covered, np.full(FIELD, warmth(time_s)))


def film(kind, noise):
    """Frames (frame, row, column) and the moments of the middle row."""
    rng, frames, pixels, now = np.random.default_rng(1), [], np.zeros((ROWS, COLUMNS)), 0.0
    for n in range(FRAMES):
        start, frame = 0.1 + n * PERIOD_S, np.zeros((ROWS, COLUMNS))
        for _ in range(round((start + ROWS * kind.row_delay_s - now) / STEP_S)):
            if kind.time_constant_s:
                pixels = pixels + (scene_at(kind, now + STEP_S / 2) - pixels) * STEP_S / kind.time_constant_s
            else:
                pixels = np.tile(scene_at(kind, now + STEP_S), (ROWS, 1))
            now += STEP_S
            reads = [round((now - start) / kind.row_delay_s)] if kind.row_delay_s else range(ROWS)
            for row in reads:
                if 0 <= row < ROWS and abs(now - start - row * kind.row_delay_s) < STEP_S / 2:
                    frame[row] = pixels[row]
        frame += rng.normal(0, 1, frame.shape) * noise
        frames.append((1 - kind.share) * frame + kind.share * (frames[-1] if frames else frame))
    return np.array(frames), 0.1 + PERIOD_S * np.arange(FRAMES) + kind.row_delay_s * (ROWS - 1) / 2


def found_in(kind, frames, times_s, noise):
    """Index and pixels of the scene in each frame."""
    response = Response(time_constant_s=kind.time_constant_s, recursive_filter=kind.share)
    readout = Readout(response=response, row_delay_s=kind.row_delay_s)
    return {one.index: one.pixels.copy() for one in scenes(frames, times_s, readout=readout, noise=noise)}


def errors(kind, frames, times_s):
    """Rms error of the edge in px, and of the temperature."""
    edge = frames[:, :, : COLUMNS - FIELD].sum(axis=2) / HIGH
    return (
        np.sqrt(np.mean((edge - edge_px(kind, times_s)[:, None]) ** 2)),
        np.sqrt(np.mean((frames[:, :, COLUMNS - FIELD :] - warmth(times_s)[:, None, None]) ** 2)),
    )


def table():
    """Print errors before and after."""
    print("| camera | noise | edge, frames | found | temperature, frames | found |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for kind in KINDS:
        for noise in (0.0, 1.0, 10.0, 100.0):
            frames, times_s = film(kind, noise)
            found = found_in(kind, frames, times_s, noise)
            kept = [index for index in found if index >= SKIPPED]
            before = errors(kind, frames[kept], times_s[kept])
            after = errors(kind, np.array([found[index] for index in kept]), times_s[kept])
            print(
                f"| {kind.name} | {noise:g} | {before[0]:.4f} px | {after[0]:.4f} px | {before[1]:.2f} | {after[1]:.2f} |"
            )


def draw(path):
    """A frame, what is found of it, the scene, and the error of the edge in each row."""
    kind = Kind("rolling, lag 5 ms", row_delay_s=4e-4, time_constant_s=5e-3, swing_px=18.0)
    frames, times_s = film(kind, 1.0)
    shown = 17
    found = found_in(kind, frames, times_s, 1.0)[shown]
    true = np.tile(scene_at(kind, times_s[shown]), (ROWS, 1))
    edge = slice(0, COLUMNS - FIELD)
    late = [(image[:, edge] - true[:, edge]).sum(axis=1) / HIGH for image in (frames[shown], found)]
    with rc_context({"svg.hashsalt": "irtiming", "svg.fonttype": "none"}):
        figure = Figure(figsize=(9, 2.5), layout="constrained")
        for place, (title, image) in enumerate((("frame", frames[shown]), ("found", found), ("scene", true)), 1):
            axes = figure.add_subplot(1, 4, place, title=title, xlabel="column", ylabel="row" if place == 1 else None)
            axes.imshow(image, vmin=-100, vmax=1100, cmap="inferno", interpolation="nearest")
        axes = figure.add_subplot(1, 4, 4, title="edge − truth", xlabel="px", ylim=(ROWS, 0))
        for values, label in zip(late, ("frame", "found"), strict=True):
            axes.plot(values, np.arange(ROWS), label=label)
        axes.legend()
        figure.savefig(path, metadata={"Date": None})
    for values, image, word in zip(late, (frames[shown], found), ("frame", "found"), strict=True):
        print(
            f"{word}: edge off by {np.sqrt(np.mean(values**2)):.3f} px rms, pixels by {np.sqrt(np.mean((image - true) ** 2)):.0f}"
        )


def main():
    """Print the table; draw where asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--figure")
    given = parser.parse_args()
    if given.figure:
        draw(given.figure)
    table()


if __name__ == "__main__":
    main()
