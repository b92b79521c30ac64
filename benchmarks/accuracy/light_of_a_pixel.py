"""What a rolling camera's numbers owe to light that the sector does not explain, on rigs whose wheel mirrors the camera.

Every rig is one of those of rolling_coverage.py, with quiet and even pixels, so that what is left is no noise. Each is analysed
as the program does, and with what it did before: light beside the sector as points without width, and only as far as it exceeds
twice a pixel's uncertainty; the wheel's mirror image made of hills that all stand within the region and have a mean.

    .venv/bin/python benchmarks/accuracy/light_of_a_pixel.py --rigs 12 --figure light-of-a-pixel.svg
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from irtiming.estimate import row_light, sector_fit, sector_image
from irtiming.measurement import analyse
from irtiming.twin import rig as twin
from irtiming.twin.scene import BolometerTiming
from irtiming.twin.upkeep import Drift, SelfCorrection

sys.path.insert(0, str(Path(__file__).parents[1]))
from rolling_coverage import draw

_QUIET_DN = 2.0
_SIGNIFICANT = 2.0
_NODES_BEFORE = 7


@contextmanager
def without_width() -> Iterator[None]:
    """Light beside the sector sits in the middle of its pixel."""
    points = lambda radius_px, **_: np.ones_like(radius_px)  # noqa: E731
    with patch.object(row_light.blurred_sector, "pixel_smear", points, create=False), _wide_in_the_image():
        yield


@contextmanager
def beyond_noise_only() -> Iterator[None]:
    """What a pixel shows beyond the model counts as far as it exceeds twice its uncertainty."""
    told = sector_fit._light

    def shrunk(seen: Any, numbers: Any, *, view: Any) -> dict[str, Any]:
        found, u = told(seen, numbers, view=view), seen.u
        left = found["excess"]
        kept = np.maximum(0.0, 1 - (_SIGNIFICANT * u) ** 2 / np.maximum(left**2, 1e-30))
        return found | {"excess": left * kept}

    with patch.object(sector_fit, "_light", shrunk):
        yield


@contextmanager
def hills_within() -> Iterator[None]:
    """The smooth field is made of hills from end to end of the region, none beyond, and its mean is free."""

    def hills(view: sector_image.View) -> np.ndarray:
        along = []
        for places in (view.rows.ravel(), view.columns.ravel()):
            nodes = np.linspace(places[0], places[-1], _NODES_BEFORE)
            along.append(np.exp(-0.5 * ((places - nodes[:, None]) / (nodes[1] - nodes[0])) ** 2))
        return np.einsum("ar,bc->abrc", *along).reshape(-1, view.rows.size, view.columns.size)

    with (
        patch.object(sector_image.View, "field_terms", property(hills)),
        patch.object(sector_image, "_about_their_mean", lambda terms, _: terms),
    ):
        yield


def together(*ways: Callable[[], Any]) -> Callable[[], Any]:
    """Several at once."""

    @contextmanager
    def all_of_them() -> Iterator[None]:
        with ExitStack() as stack:
            for way in ways:
                stack.enter_context(way())
            yield

    return all_of_them


@contextmanager
def _wide_in_the_image() -> Iterator[None]:
    """The contrast image keeps the width that the rows lose."""
    with patch.object(sector_image, "blurred_sector", _Kept(sector_image.blurred_sector)):
        yield


class _Kept:
    """The module as it was when the patch began."""

    def __init__(self, module: Any) -> None:
        self._module, self.pixel_smear = module, _SMEAR

    def __getattr__(self, name: str) -> Any:
        return getattr(self._module, name)


_SMEAR = row_light.blurred_sector.pixel_smear

WAYS: dict[str, Callable[[], Any]] = {
    "as it was": together(without_width, beyond_noise_only, hills_within),
    "light as wide as a pixel": together(beyond_noise_only, hills_within),
    "all that a pixel shows": together(without_width, hills_within),
    "both": hills_within,
    "a field that meets its ends: as it is": nullcontext,
}


def errors_us(seed: int, *, mirrors: bool = True) -> dict[str, np.ndarray]:
    """Errors of time constant and row delay, us, of each way."""
    rig = draw(seed)
    scene = replace(
        rig.scene,
        detector=replace(rig.scene.detector, noise_dn=_QUIET_DN, gain_spread=0.0, dead_pixels=0),
        drift=Drift(),
        correction=SelfCorrection(),
    )
    if not mirrors:
        scene = replace(scene, radiance=replace(scene.radiance, narcissus_dn=0.0))
    timing = scene.timing
    assert isinstance(timing, BolometerTiming)
    recording = twin.simulate(scene, seed=seed)
    found = {}
    for name, way in WAYS.items():
        with way():
            estimate = analyse([recording], rig.measured).best.estimate
        values = dict(zip(estimate.names, estimate.values, strict=True))
        found[name] = 1e6 * np.array(
            [
                values["time_constant"] - timing.time_constant_s if "time_constant" in values else np.nan,
                values["row_delay"] - timing.row_delay_s,
            ]
        )
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=12)
    parser.add_argument("--first", type=int, default=3000, help="seed of the first rig")
    parser.add_argument("--figure", type=Path)
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.rigs)
    told = [errors_us(seed) for seed in seeds]
    print("| light beside the sector | time constant: mean, rms error / us | row delay: mean, rms error / us |")
    print("| --- | ---: | ---: |")
    for name in WAYS:
        errors = np.array([one[name] for one in told])
        mean, rms = np.nanmean(errors, axis=0), np.sqrt(np.nanmean(errors**2, axis=0))
        print(f"| {name} | {mean[0]:+.2f}, {rms[0]:.2f} | {mean[1]:+.3f}, {rms[1]:.3f} |")
    if arguments.figure:
        _draw(told, list(seeds), arguments.figure)


def _draw(told: list[dict[str, np.ndarray]], seeds: list[int], path: Path) -> None:
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "irtiming"
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 1, figsize=(7.2, 4.8), sharex=True, layout="constrained")
    for way, marker, colour in (
        ("as it was", "o", "#b35806"),
        ("a field that meets its ends: as it is", "s", "#2166ac"),
    ):
        errors = np.array([one[way] for one in told])
        for axis, values in zip(axes, errors.T, strict=True):
            axis.plot(range(len(seeds)), values, marker, color=colour, label=way, markersize=5)
    for axis, name in zip(axes, ("time constant", "row delay"), strict=True):
        axis.axhline(0, color="0.6", linewidth=0.8, zorder=0)
        axis.set_ylabel(f"error of the {name} / us")
    axes[0].legend(frameon=False)
    axes[1].set_xlabel("simulated rig")
    axes[1].set_xticks(range(len(seeds)))
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main()
