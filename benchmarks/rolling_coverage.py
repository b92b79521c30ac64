"""Errors and pulls over random simulated rigs of a camera whose rows are summed, by both methods where there are two.

Every rig has its own wheel, gates, mask, optics, lens distortion (-0.08 to 0.02, stated to 0.02), roll, wheel centre, rate,
timing (of a rolling camera rows in either direction) and dead pixels, and one in four turns counterclockwise; rig.toml is off
by its stated uncertainties. A microbolometer has a time constant of 3 to 15 ms, drift and a shutter event; a photon camera a
window of 0.1 to 6 ms, and in every other rig no non-uniformity references. With --speeds the same camera is recorded at
several wheel rates, and --delays-ms adds extra trigger delays.

    .venv/bin/python benchmarks/rolling_coverage.py --rigs 60
    .venv/bin/python benchmarks/rolling_coverage.py --rigs 50 --camera photon --readout rolling
    .venv/bin/python benchmarks/rolling_coverage.py --rigs 50 --camera microbolometer --readout snapshot --speeds 2
"""

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from irtiming.errors import IrTimingError
from irtiming.measurement import Extra, analyse
from irtiming.records.recording import USUAL_READOUT, CameraType, ReadoutMode, Recording
from irtiming.records.rig import CameraOptics, Measured
from irtiming.twin import rig as twin
from irtiming.twin.cameras import camera_scene
from irtiming.twin.rig import SimulatedRig
from irtiming.twin.scene import BolometerTiming, CameraTiming, Scene, Timing, with_wheel_speed
from irtiming.twin.upkeep import Drift, SelfCorrection, ShutterEvent

RATES_HZ = (1.5, 2.0, 3.0, 4.0, 5.0)
WITHIN_US = {"time_constant": 10.0, "row_delay": 0.3}
ROWS, COLUMNS = 120, 160
DISTORTIONS, U_DISTORTION = (-0.08, 0.02), 0.02
BEST, PUBLISHED = "row sums", "as published"
EXTRAS: tuple[Extra, ...] = ("published",)

Pairs = dict[tuple[str, str], list[tuple[float, float]]]
"""Error and standard uncertainty, s, by parameter and method."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of camera."""

    camera: CameraType = "microbolometer"
    readout: ReadoutMode = "rolling"


def timing(kind: Kind, random: np.random.Generator, *, delay_s: float, row_delay_s: float | None) -> Timing:
    """Another camera."""
    if kind.camera == "microbolometer":
        lag_s = random.uniform(3e-3, 15e-3)
        return BolometerTiming(trigger_delay_s=delay_s, time_constant_s=lag_s, row_delay_s=row_delay_s)
    window_s = float(np.exp(random.uniform(np.log(0.1e-3), np.log(6e-3))))
    return CameraTiming(trigger_delay_s=delay_s, integration_time_s=window_s, row_delay_s=row_delay_s, substeps=64)


def nominal(kind: Kind, seed: int) -> Scene:
    """Another laboratory: camera, place and speed."""
    random = np.random.default_rng([seed, 4])
    scene = with_wheel_speed(
        camera_scene(kind.camera, kind.readout, rows=ROWS, columns=COLUMNS), float(random.choice(RATES_HZ))
    )
    upwards = random.random() < 0.5
    drawn_s = random.uniform(20e-6, 110e-6) * (-1 if upwards else 1)
    row_delay_s = None if kind.readout == "snapshot" else drawn_s
    optics = replace(
        scene.optics,
        pixel_pitch_m=scene.optics.pixel_pitch_m * random.uniform(1.08, 1.25),
        roll_rad=random.uniform(-0.05, 0.05),
        wheel_centre_row_px=scene.optics.wheel_centre_row_px + random.uniform(-2, 2),
        wheel_centre_column_px=scene.optics.wheel_centre_column_px + random.uniform(-8, 8),
        blur_px=random.uniform(0.5, 1.0),
        distortion=np.random.default_rng([seed, 5]).uniform(*DISTORTIONS),
    )
    before_trigger_s = max(0.0, -(row_delay_s or 0.0) * ROWS)
    delay_s = before_trigger_s + random.uniform(0, 8e-3 if kind.camera == "microbolometer" else 2e-3)
    drawn = replace(
        scene,
        optics=optics,
        wheel=replace(scene.wheel, rotation="counterclockwise" if random.random() < 0.25 else "clockwise"),
        timing=timing(kind, random, delay_s=delay_s, row_delay_s=row_delay_s),
        detector=replace(scene.detector, dead_pixels=20),
    )
    if kind.camera == "photon":
        frames = scene.radiance.reference_frames if random.random() < 0.5 else 0
        return replace(drawn, radiance=replace(scene.radiance, reference_frames=frames))
    return replace(
        drawn,
        drift=Drift(per_second_dn=random.normal(0, 2), settling_dn=random.normal(0, 20), settling_time_s=10.0),
        correction=SelfCorrection(events=(ShutterEvent(start_s=random.uniform(5, 25)),)),
    )


def draw(kind: Kind, seed: int) -> SimulatedRig:
    """The rig; its timing is as nominal, which is random already."""
    tolerances = replace(
        twin.Tolerances(), trigger_delay_s=0.0, bolometer_delay_s=0.0, time_constant_s=0.0, row_delay_s=0.0
    )
    rig = twin.draw(nominal(kind, seed), seed=seed, tolerances=tolerances)
    told = np.random.default_rng([seed, 6]).normal(rig.scene.optics.distortion, U_DISTORTION)
    detector = rig.scene.detector
    per_width = detector.columns**2 / (detector.rows**2 + detector.columns**2)  # rig.toml has it over half the width
    lens = CameraOptics(distortion=Measured(float(told) * per_width, U_DISTORTION * per_width))
    return replace(rig, measured=replace(rig.measured, camera=lens))


def recordings(scene: Scene, options: argparse.Namespace, seed: int) -> Iterator[Recording]:
    """At the rig's own rate, then at others; every extra delay at each."""
    delays_s = [1e-3 * float(text) for text in options.delays_ms.split(",")]
    others = [rate for rate in RATES_HZ if rate != scene.trigger.wheel_hz]
    later = np.random.default_rng([seed, 7]).permutation(others)[: options.speeds - 1]
    for k, rate_hz in enumerate([scene.trigger.wheel_hz, *later.tolist()]):
        at_rate = with_wheel_speed(scene, rate_hz)
        for j, delay_s in enumerate(delays_s):
            trigger = replace(at_rate.trigger, trigger_delay_time_set_s=delay_s)
            yield twin.simulate(replace(at_rate, trigger=trigger), seed=seed + 1_000_003 * (k * len(delays_s) + j))


def one_rig(options: argparse.Namespace, seed: int) -> tuple[int, Pairs | str]:
    """Errors and uncertainties of every parameter that the truth knows; or what went wrong."""
    rig = draw(Kind(camera=options.camera, readout=options.readout), seed)
    truth, found = twin.truth(rig.scene), Pairs()
    try:
        analysis = analyse(recordings(rig.scene, options, seed), rig.measured, extras=EXTRAS)
    except (IrTimingError, ValueError) as error:
        return seed, f"{type(error).__name__}: {error}"
    results = {BEST: analysis.best} | ({PUBLISHED: analysis.published.result} if analysis.published else {})
    for method, result in results.items():
        estimate = result.estimate
        for name, value, u in zip(estimate.names, estimate.values, estimate.standard_uncertainties, strict=True):
            true = truth.get(f"{name}_s")
            if isinstance(true, float) and u > 0:
                found.setdefault((name, method), []).append((float(value) - true, float(u)))
    return seed, found


def table_row(name: str, method: str, pairs: list[tuple[float, float]]) -> str:
    error, u = np.array(pairs).T
    pull = error / u
    return (
        f"| {name.replace('_', ' ')}, {method} | {1e6 * np.sqrt(np.mean(error**2)):.3f} | "
        f"{1e6 * np.max(np.abs(error)):.3f} | {1e6 * np.sqrt(np.mean(u**2)):.3f} | {np.sqrt(np.mean(pull**2)):.2f} | "
        f"{np.mean(np.abs(pull) < 1):.0%} | {np.mean(np.abs(pull) < 2):.0%} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--camera", choices=("photon", "microbolometer"), default="microbolometer")
    parser.add_argument("--readout", choices=("snapshot", "rolling"), help="as usual for the camera if not given")
    parser.add_argument("--speeds", type=int, default=1, help=f"wheel rates of each rig, 1 to {len(RATES_HZ)}")
    parser.add_argument("--delays-ms", default="0", help="extra trigger delays at each rate")
    parser.add_argument("--rigs", type=int, default=60)
    parser.add_argument("--first", type=int, default=0, help="seed of the first rig")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--each", action="store_true", help="print every rig")
    options = parser.parse_args()
    options.readout = options.readout or USUAL_READOUT[options.camera]
    seeds = range(options.first, options.first + options.rigs)
    found, failed = Pairs(), 0
    with ProcessPoolExecutor(options.workers) as pool:
        for seed, told in pool.map(partial(one_rig, options), seeds):
            if isinstance(told, str):
                failed += 1
                print(f"rig {seed}: {told}", flush=True)
                continue
            for key, pairs in told.items():
                found.setdefault(key, []).extend(pairs)
                if options.each and key[1] == BEST:
                    print(seed, key[0], [f"{1e6 * error:.3f} us, {error / u:.2f} u" for error, u in pairs], flush=True)
    print(
        f"\n{options.rigs - failed} rigs of {options.rigs}, {options.camera}, {options.readout}, {COLUMNS} x {ROWS} pixels, "
        f"{options.speeds} wheel speed(s), extra delays of {options.delays_ms} ms, 1000 frames each; us\n"
    )
    print("| parameter, method | rms error | largest error | rms u | rms pull | within 1 u | within 2 u |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for (name, method), pairs in sorted(found.items()):
        print(table_row(name, method, pairs))
    for (name, method), pairs in sorted(found.items()):
        error, u = np.array(pairs).T
        if method == BEST and name in WITHIN_US:
            print(
                f"{method}: {name} within {WITHIN_US[name]} us on {np.mean(np.abs(error) < 1e-6 * WITHIN_US[name]):.0%}"
            )
        if method == BEST and name == "trigger_delay":
            print(f"{method}: {name} within 3 u on {np.mean(np.abs(error) < 3 * u):.0%} of the rigs; {failed} failed")


if __name__ == "__main__":
    main()
