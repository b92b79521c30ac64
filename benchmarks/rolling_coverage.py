"""Errors and pulls of trigger delay, time constant and row delay over random simulated rigs, by both methods.

Every rig has its own wheel, gates, mask, optics, lens distortion (-0.08 to 0.02, stated to 0.02), roll, wheel centre, rate,
time constant (3 to 15 ms), row delay (either sign), drift, shutter event, dead pixels, and one in four turns counterclockwise;
rig.toml is off by its stated uncertainties.

    .venv/bin/python benchmarks/rolling_coverage.py --rigs 60
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
from irtiming.records.rolling_result import RollingResult

from irtiming.errors import IrTimingError
from irtiming.measurement import analyse_rolling
from irtiming.records.rig import CameraOptics, Measured
from irtiming.twin import rig as twin
from irtiming.twin.rig import SimulatedRig
from irtiming.twin.scene import BolometerTiming, Scene, microbolometer_scene, with_wheel_speed
from irtiming.twin.upkeep import Drift, SelfCorrection, ShutterEvent

NAMES = ("trigger_delay", "time_constant", "row_delay")
RATES_HZ = (1.5, 2.0, 3.0, 4.0, 5.0)
WANTED_US = (np.inf, 10.0, 0.3)
ROWS, COLUMNS = 120, 160
DISTORTIONS, U_DISTORTION = (-0.08, 0.02), 0.02


def nominal(seed: int) -> Scene:
    """Another laboratory: camera, place and speed."""
    random = np.random.default_rng([seed, 4])
    scene = with_wheel_speed(microbolometer_scene(ROWS, COLUMNS), float(random.choice(RATES_HZ)))
    upwards = random.random() < 0.5
    row_delay_s = random.uniform(20e-6, 110e-6) * (-1 if upwards else 1)
    optics = replace(
        scene.optics,
        pixel_pitch_m=scene.optics.pixel_pitch_m * random.uniform(1.08, 1.25),
        roll_rad=random.uniform(-0.05, 0.05),
        wheel_centre_row_px=scene.optics.wheel_centre_row_px + random.uniform(-2, 2),
        wheel_centre_column_px=scene.optics.wheel_centre_column_px + random.uniform(-8, 8),
        blur_px=random.uniform(0.5, 1.0),
        distortion=np.random.default_rng([seed, 5]).uniform(*DISTORTIONS),
    )
    delay_s = random.uniform(0, 8e-3) + (-row_delay_s * ROWS if upwards else 0)
    return replace(
        scene,
        optics=optics,
        wheel=replace(scene.wheel, rotation="counterclockwise" if random.random() < 0.25 else "clockwise"),
        timing=BolometerTiming(
            trigger_delay_s=delay_s, time_constant_s=random.uniform(3e-3, 15e-3), row_delay_s=row_delay_s
        ),
        detector=replace(scene.detector, dead_pixels=20),
        drift=Drift(per_second_dn=random.normal(0, 2), settling_dn=random.normal(0, 20), settling_time_s=10.0),
        correction=SelfCorrection(events=(ShutterEvent(start_s=random.uniform(5, 25)),)),
    )


def draw(seed: int) -> SimulatedRig:
    """The rig; its timing is as nominal, which is random already."""
    scene = nominal(seed)
    tolerances = replace(twin.Tolerances(), bolometer_delay_s=0.0, time_constant_s=0.0, row_delay_s=0.0)
    rig = twin.draw(scene, seed=seed, tolerances=tolerances)
    told = np.random.default_rng([seed, 6]).normal(rig.scene.optics.distortion, U_DISTORTION)
    lens = CameraOptics(distortion=Measured(float(told), U_DISTORTION))
    return replace(rig, measured=replace(rig.measured, camera=lens))


def one_rig(seed: int) -> tuple[int, np.ndarray | str]:
    """Errors and uncertainties of both methods, shape (method, 2, parameter), s; or what went wrong."""
    rig = draw(seed)
    timing = rig.scene.timing
    assert isinstance(timing, BolometerTiming)
    truth = np.array([timing.trigger_delay_s, timing.time_constant_s, timing.row_delay_s])
    try:
        analysis = analyse_rolling([twin.simulate(rig.scene, seed=seed)], rig.measured)
        return seed, np.array([_told(result, truth) for result in (analysis.best, analysis.as_published)])
    except (IrTimingError, ValueError) as error:
        return seed, f"{type(error).__name__}: {error}"


def _told(result: RollingResult, truth: np.ndarray) -> np.ndarray:
    estimate = result.estimate
    order = [estimate.names.index(name) for name in NAMES]
    return np.array([estimate.values[order] - truth, estimate.standard_uncertainties[order]])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=60)
    parser.add_argument("--first", type=int, default=0, help="seed of the first rig")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--each", action="store_true", help="print every rig")
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.rigs)
    found, failed = [], []
    with ProcessPoolExecutor(arguments.workers) as pool:
        for seed, told in pool.map(one_rig, seeds):
            if isinstance(told, str):
                failed.append((seed, told))
                print(f"rig {seed}: {told}", flush=True)
                continue
            found.append(told)
            if arguments.each:
                print(
                    seed,
                    np.round(1e6 * told[:, 0], 3).tolist(),
                    np.round(told[:, 0] / told[:, 1], 2).tolist(),
                    flush=True,
                )
    told_all = np.array(found)
    print(f"\n{len(found)} rigs of {len(seeds)}, {COLUMNS} x {ROWS} pixels, one recording of 1000 frames each; us\n")
    print("| parameter, method | rms error | largest error | rms u | rms pull | within 1 u | within 2 u |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for k, name in enumerate(NAMES):
        for method, words in enumerate(("row sums", "as published")):
            error, u = told_all[:, method, 0, k], told_all[:, method, 1, k]
            pull = error / u
            print(
                f"| {name.replace('_', ' ')}, {words} | {1e6 * np.sqrt(np.mean(error**2)):.3f} | "
                f"{1e6 * np.max(np.abs(error)):.3f} | {1e6 * np.sqrt(np.mean(u**2)):.3f} | {np.sqrt(np.mean(pull**2)):.2f} | "
                f"{np.mean(np.abs(pull) < 1):.0%} | {np.mean(np.abs(pull) < 2):.0%} |"
            )
    for k, (name, wanted) in enumerate(zip(NAMES, WANTED_US, strict=True)):
        if np.isfinite(wanted):
            share = np.mean(np.abs(told_all[:, 0, 0, k]) < 1e-6 * wanted)
            print(f"row sums: {name} within {wanted} us on {share:.0%} of the rigs")
    pulls = told_all[:, 0, 0, 0] / told_all[:, 0, 1, 0]
    print(f"row sums: trigger delay within 3 u on {np.mean(np.abs(pulls) < 3):.0%} of the rigs; {len(failed)} failed")


if __name__ == "__main__":
    main()
