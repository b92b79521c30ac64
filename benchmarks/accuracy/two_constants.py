"""Constants of substrate and scene found from simulated recordings before several blackbodies, beside the true ones.

The twin steps the differential equation with the exact Planck integral, pixel by pixel. Every rig has its own wheel, gates,
mask, optics, roll, trigger and row delay; rig.toml is off by its stated uncertainties. Both exchanges together have 4.819 ms.

    .venv/bin/python benchmarks/accuracy/two_constants.py --rigs 3 --celsius 15 30 45
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np

from irtiming import measurement
from irtiming.estimate import two_constants
from irtiming.physics.response.two_constants import TwoConstants, bending, effective_time_constant, steady_temperature
from irtiming.records.choices import Choices
from irtiming.records.two_constants import TwoConstantsResult
from irtiming.reduce import recipes
from irtiming.twin import rig as twin
from irtiming.twin.scene import RadiativeExchange, microbolometer_scene, with_wheel_speed

BOTH_S = 4.819e-3
SUBSTRATE_K, WHEEL_K = 303.15, 296.15
ROWS, COLUMNS = 120, 160


def one(job: tuple[int, float, tuple[float, ...]]) -> tuple[float, int, TwoConstantsResult, np.ndarray]:
    """Share, seed, what was found, and the linear constants in the middle of each pixel's range, s."""
    seed, share, blackbodies_k = job
    scene = with_wheel_speed(microbolometer_scene(ROWS, COLUMNS), 3.0)
    scene = replace(scene, optics=replace(scene.optics, pixel_pitch_m=1.1 * scene.optics.pixel_pitch_m))
    rig = twin.draw(scene, seed=seed)
    exchange = RadiativeExchange(scene_time_constant_s=BOTH_S / share, substrate_k=SUBSTRATE_K)
    timing = replace(rig.scene.timing, time_constant_s=BOTH_S / (1 - share), radiative=exchange)
    reduced = []
    for k, kelvin in enumerate(blackbodies_k):
        shown = replace(rig.scene, timing=timing, radiance=replace(rig.scene.radiance, blackbody_k=kelvin))
        recording = twin.simulate(shown, seed=100 * seed + k, name=f"{kelvin:g} K")
        reduced.append(recipes.reduce(recording, rig.measured, choices=Choices()))
    effective = measurement.estimate(reduced, rig.measured).best.effective
    assert effective is not None
    found = two_constants.estimate(effective, substrate_temperature_k=SUBSTRATE_K)
    model = TwoConstants(substrate_time_constant_s=BOTH_S / (1 - share), scene_time_constant_s=BOTH_S / share)
    steady = steady_temperature(model, np.array([*blackbodies_k, WHEEL_K]), substrate_temperature_k=SUBSTRATE_K)
    middle = effective_time_constant(model, (steady[:-1] + steady[-1]) / 2)
    bend = bending(model, steady[:-1], second_k=np.full(len(blackbodies_k), steady[-1]))
    return share, seed, found, np.stack([middle, middle * (1 + 1.4 * bend**2)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=3)
    parser.add_argument("--shares", type=float, nargs="+", default=[0.1, 0.2, 1 / 3, 0.5, 2 / 3])
    parser.add_argument("--celsius", type=float, nargs="+", default=[15.0, 30.0, 45.0])
    parser.add_argument("--workers", type=int, default=1)
    arguments = parser.parse_args()
    blackbodies = tuple(celsius + 273.15 for celsius in arguments.celsius)
    jobs = [(seed, share, blackbodies) for share in arguments.shares for seed in range(1, 1 + arguments.rigs)]
    print(
        "| share | rig | true substrate, scene (ms) | found substrate (ms) | found scene (ms) | effective − middle (µs) | u |"
    )
    print("| ---: | ---: | --- | --- | --- | --- | --- |")
    with ProcessPoolExecutor(arguments.workers) as pool:
        for share, seed, found, expected in pool.map(one, jobs):
            truth = f"{1e3 * BOTH_S / (1 - share):.3f}, {1e3 * BOTH_S / share:.3f}"
            apart = 1e6 * (found.effective.time_constant_s - expected[0])
            left = 1e6 * (found.effective.time_constant_s - expected[1])
            u = 1e6 * np.sqrt(np.diag(found.effective.covariance_s2))
            cells = [
                f"{share:.2f}", str(seed), truth, *_cells(found),
                ", ".join(f"{a:+.1f} (bent {b:+.1f})" for a, b in zip(apart, left, strict=True)),
                ", ".join(f"{one:.1f}" for one in u),
            ]  # fmt: skip
            print("| " + " | ".join(cells) + " |", flush=True)


def _cells(found: TwoConstantsResult) -> list[str]:
    if not found.estimate.names:
        bounds = [(bound.lower_s or 0.0, bound.upper_s) for bound in found.bounds]
        return [f"{1e3 * low:.2f} … {'∞' if high is None else f'{1e3 * high:.2f}'}" for low, high in bounds]
    pairs = zip(found.estimate.values, found.estimate.standard_uncertainties, strict=True)
    return [f"{1e3 * value:.3f} ± {1e3 * u:.3f}" for value, u in pairs]


if __name__ == "__main__":
    main()
