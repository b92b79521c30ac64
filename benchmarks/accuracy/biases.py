"""The biases of the numbers, one by one, of both kinds of camera: each rig analysed as the program does, and as it did before.

A rig has its own random imperfections, but what one wheel speed cannot tell is as rig.toml says: gates, mask angle, cutout edges,
slots. What is left is the bias under study, and noise.

    .venv/bin/python benchmarks/accuracy/biases.py --rigs 6 --figure biases.svg
"""

import argparse
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from distortion import beside_the_middle

from irtiming import measurement
from irtiming.estimate import opening_in_image, pixel_numbers, sector_fit, wheel_geometry
from irtiming.records.rig import CameraOptics, Measured, Rig
from irtiming.reduce.wheel import nominal_angles
from irtiming.twin import rig as twin
from irtiming.twin.rig import SimulatedRig, Tolerances
from irtiming.twin.scene import Faults, Scene, microbolometer_scene, paper_scene, with_wheel_speed


@dataclass(frozen=True, kw_only=True)
class Bias:
    """A bias: which numbers it touches, on which scene, and what the program did before."""

    name: str
    quantities: tuple[str, ...]
    before: Callable[[], Any]
    scene: Callable[[], Scene] = lambda: paper_scene(120, 160)
    wheel_hz: tuple[float, ...] = (3.0,)
    stated: Callable[[Rig], Rig] = lambda rig: rig


def without_mask_shift() -> Any:
    """The mean angle of the light is taken for the bisector of the mask."""
    return patch.object(wheel_geometry, "_mask_shift", lambda _: (0.0, None))


def without_shares() -> Any:
    """Each frame counts alike in the pixels' phases, whatever frames are lost beside it."""
    return patch.object(nominal_angles, "share_of_turn", lambda angle, _: np.isfinite(angle).astype(float))


def field_taken_for_light() -> Any:
    """What the wheel reflects of the camera is taken for even."""
    return patch.object(sector_fit, "_FIELD_PRIORS", (1e-9, 1e-9))


@contextmanager
def edges_through_the_axle() -> Iterator[None]:
    """The mask's straight edges are held to point to the axle."""
    with (
        patch.object(opening_in_image, "edge_misalignments", lambda *_, **__: (np.zeros(2), 1e-9)),
        patch.object(pixel_numbers, "_LEAST_U_RAD", 1e-9),
    ):
        yield


def dead_pixels_own_light() -> Any:
    """The model gives a dead pixel the light of its place, though the row sums have its neighbours'."""
    return patch.object(sector_fit, "_borrowed", lambda light, _: np.zeros(light.shape))


def perfect_lens(rig: Rig) -> Rig:
    """rig.toml says that the lens does not distort, as if it were certain."""
    return replace(rig, camera=CameraOptics(distortion=Measured(0.0, 1e-9)))


def sharp_with_dead_pixels() -> Scene:
    """A microbolometer with a hundred dead pixels, and edges sharper than a pixel."""
    scene = microbolometer_scene(120, 160)
    return replace(scene, optics=replace(scene.optics, blur_px=0.5), detector=replace(scene.detector, dead_pixels=100))


BIASES = (
    Bias(name="mask beside the axle", quantities=("trigger_delay",), before=without_mask_shift),
    Bias(
        name="reflection on one end of the opening",
        quantities=("trigger_delay",),
        before=field_taken_for_light,
        scene=lambda: beside_the_middle(paper_scene(256, 320)),
    ),
    Bias(
        name="100 lost frames in the pixels' phases",
        quantities=("trigger_delay",),
        before=without_shares,
        scene=lambda: replace(paper_scene(120, 160), faults=Faults(lost_frames=100)),
    ),
    Bias(
        name="mask edges that miss the axle",
        quantities=("integration_time",),
        before=edges_through_the_axle,
        wheel_hz=(3.0, 5.0, 8.0, 12.0),
    ),
    Bias(
        name="lens taken as perfect",
        quantities=("time_constant", "row_delay"),
        before=nullcontext,
        scene=lambda: beside_the_middle(microbolometer_scene(120, 160)),
        stated=perfect_lens,
    ),
    Bias(
        name="dead pixels have their own light",
        quantities=("row_delay",),
        before=dead_pixels_own_light,
        scene=sharp_with_dead_pixels,
    ),
)


def drawn(bias: Bias, seed: int) -> SimulatedRig:
    """A rig whose gates, mask angle, cutout edges and slots are known."""
    known = replace(Tolerances(), cutout_error_rad=0.0, slot_error_rad=0.0, slot_eccentricity_rad=0.0)
    known = replace(known, beam_m=0.0, mask_angle_rad=0.0, u_beam_m=0.0, u_mask_angle_rad=0.0)
    return twin.draw(bias.scene(), seed=seed, tolerances=known)


def before_and_now(which: int, seed: int) -> np.ndarray:
    """Sizes of the errors of one rig, us, shape (quantity, 2)."""
    bias = BIASES[which]
    rig = drawn(bias, seed)
    truth = rig.scene.timing
    recordings = [
        one
        for k, hz in enumerate(bias.wheel_hz)
        for one in twin.series(with_wheel_speed(rig.scene, hz), [0.0], repeats=1, seed=10 * seed + k)
    ]
    found = []
    for way, stated in ((bias.before, bias.stated(rig.measured)), (nullcontext, rig.measured)):
        with way():
            told = measurement.analyse(recordings, stated).best.estimate
        values = dict(zip(told.names, told.values, strict=True))
        found.append([1e6 * abs(values[name] - getattr(truth, f"{name}_s")) for name in bias.quantities])
    return np.array(found).T


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=6)
    parser.add_argument("--first", type=int, default=1, help="seed of the first rig")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--figure", type=Path)
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.rigs)
    told: dict[str, np.ndarray] = {}
    print("| bias | number | before: rms error / us | now: rms error / us |\n| --- | --- | ---: | ---: |")
    with ProcessPoolExecutor(given.workers) as pool:
        for which, bias in enumerate(BIASES):
            rigs = np.array(list(pool.map(partial(before_and_now, which), seeds)))
            for k, quantity in enumerate(bias.quantities):
                name, rms = quantity.replace("_", " "), np.sqrt(np.mean(rigs[:, k] ** 2, axis=0))
                told[f"{bias.name}\n({name})"] = rigs[:, k]
                print(f"| {bias.name} | {name} | {rms[0]:.2f} | {rms[1]:.2f} |", flush=True)
    if given.figure:
        _draw(told, given.figure)


def _draw(told: dict[str, np.ndarray], path: Path) -> None:
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "irtiming"
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8.2, 5.2), layout="constrained")
    ways = (("before", "o", "#b35806", 0.12), ("as it is", "s", "#2166ac", -0.12))
    for column, (way, marker, colour, lift) in enumerate(ways):
        for place, errors in enumerate(told.values()):
            axes.plot(
                errors[:, column],
                np.full(len(errors), len(told) - place + lift),
                marker,
                color=colour,
                markersize=5,
                alpha=0.75,
                label=way if place == 0 else None,
            )
    axes.set_yticks(range(len(told), 0, -1), list(told))
    axes.set_xscale("log")
    axes.set_xlabel("size of the error of each simulated rig / us")
    axes.grid(axis="x", color="0.9")
    axes.legend(frameon=False, loc="lower right")
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main()
