"""Why falling and rising slopes disagree: threshold level, integration time, blur and wheel rate on a perfect rig.

Every combination is one run of the twin without any imperfection. The same frames are counted with thresholds at several
places between the histogram peaks, and summed. Prints a table and draws the figure of the explanation page.

    python benchmarks/falling_rising_split.py --figure docs/explanation/falling-rising-split.svg
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irtiming.measurement import analyse
from irtiming.records.choices import Choices
from irtiming.records.recording import FrameStack
from irtiming.twin import rig as twin
from irtiming.twin.scene import Scene, paper_scene, with_wheel_speed

PAPER_SPLIT_US = 567.74 - 488.91
LEVELS = (0.34, 0.42, 0.50, 0.58, 0.66)
PERFECT = twin.Tolerances(
    ring_edge_rad=2e-4, cutout_error_rad=0, slot_error_rad=0, slot_eccentricity_rad=0, beam_m=0, mask_angle_rad=0,
    mask_centre_m=0, roll_rad=0, wheel_centre_px=1, u_beam_m=0, u_mask_angle_rad=0,
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    wheel_hz: float
    integration_us: float
    blur_px: float

    def __str__(self) -> str:
        return f"{self.wheel_hz:g} Hz, {self.integration_us:g} µs, blur {self.blur_px:g} px"


CASES = (
    Case(3, 50, 0.1), Case(3, 250, 0.1), Case(3, 1000, 0.1), Case(6, 250, 0.1),
    Case(3, 250, 0.3), Case(3, 250, 0.7), Case(6, 250, 0.7),
)  # fmt: skip


class KeptFrames:
    """Frames of the twin, made once and held in memory for several analyses."""

    def __init__(self, frames: FrameStack) -> None:
        self.shape = frames.shape
        self._data = np.concatenate([block.copy() for _, block in frames.blocks()])

    def blocks(self) -> Iterator[tuple[int, np.ndarray]]:
        for first in range(0, self.shape[0], 50):
            yield first, self._data[first : first + 50]

    def pick(self, indices: list[int]) -> np.ndarray:
        return self._data[indices]


def scene(case: Case, rows: int, columns: int) -> Scene:
    base = with_wheel_speed(paper_scene(rows, columns), case.wheel_hz)
    return replace(
        base,
        radiance=replace(base.radiance, mask_k=base.radiance.wheel_k, narcissus_dn=0.0),
        timing=replace(base.timing, integration_time_s=case.integration_us * 1e-6, substeps=32),
        optics=replace(base.optics, blur_px=case.blur_px),
    )


def splits(case: Case, rows: int, columns: int, seed: int) -> tuple[list[float], float]:
    """Falling minus rising delay, us: by counts at each level, and by sums."""
    rig = twin.draw(scene(case, rows, columns), seed=seed, tolerances=PERFECT)
    recording = twin.simulate(rig.scene, seed=seed)
    recording = replace(recording, frames=KeptFrames(recording.frames))
    counted = []
    for level in LEVELS:
        analysis = analyse([recording], rig.measured, choices=Choices(threshold_level=level), extras=("published",))
        assert analysis.published is not None
        counted.append(_split(analysis.published.result.estimate.values))
    return counted, _split(analysis.best.estimate.values)


def _split(values: np.ndarray) -> float:
    """Both methods name falling and rising delays third and fourth."""
    return 1e6 * float(values[2] - values[3])


def draw(results: dict[Case, tuple[list[float], float]], path: Path) -> None:
    rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "irtiming"})
    figure = Figure(figsize=(9.6, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    _curves(left, {c: r for c, r in results.items() if c.blur_px == 0.1}, "Hardly any blur (0.1 px): integration time")
    _curves(
        right, {c: r for c, r in results.items() if c.integration_us == 250}, "Integration 250 µs: blur and wheel rate"
    )
    left.set_ylabel("falling minus rising delay / µs")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Date": None})


def _curves(axes: Axes, results: dict[Case, tuple[list[float], float]], title: str) -> None:
    for number, (case, (counted, summed)) in enumerate(results.items()):
        axes.plot(LEVELS, counted, "o-", color=f"C{number}", label=str(case))
        axes.plot(0.5, summed, "x", color=f"C{number}", markersize=9, markeredgewidth=2)
    axes.axhline(0, color="0.6", linewidth=0.8)
    axes.axhline(PAPER_SPLIT_US, color="0.3", linestyle=":", linewidth=1)
    words = f"Schatz 2023: {PAPER_SPLIT_US:.2f} µs"
    axes.annotate(words, (0.34, PAPER_SPLIT_US), xytext=(0, 3), textcoords="offset points", fontsize=8)
    axes.set_xlabel("threshold between the peaks (0 wheel, 1 blackbody)")
    axes.set_title(title, fontsize=10)
    axes.legend(fontsize=8, title="o counts   × sums", title_fontsize=8)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rows", type=int, default=512)
    options.add_argument("--columns", type=int, default=640)
    options.add_argument("--seed", type=int, default=3)
    options.add_argument("--figure", type=Path)
    given = options.parse_args()
    print(f"falling minus rising delay in us, {given.columns} x {given.rows} pixels, seed {given.seed}\n")
    print("| wheel | integration | blur |" + "".join(f" counts at {100 * q:.0f} % |" for q in LEVELS) + " sums |")
    print("| ---: | ---: | ---: |" + " ---: |" * (len(LEVELS) + 1))
    results = {}
    for case in CASES:
        counted, summed = results[case] = splits(case, given.rows, given.columns, given.seed)
        cells = "".join(f" {value:+.1f} |" for value in [*counted, summed])
        print(f"| {case.wheel_hz:g} Hz | {case.integration_us:g} us | {case.blur_px:g} px |{cells}", flush=True)
    if given.figure is not None:
        draw(results, given.figure)


if __name__ == "__main__":
    main()
