"""Errors and pulls where everything is drawn: camera, readout, image, rates, window or lag, mask, wheel, contrast and faults.

What `laboratory_coverage` holds at one operating point is random here, beside all the defects of a laboratory: kind of camera
and readout, size of the image, 150 to 600 frames at 8 to 100 per second, one to three wheel rates from 1 to 14 Hz, windows of
20 us to 8 ms, lags of 2 to 15 ms, openings of 45 to 78 degrees at the top, the bottom or a side, unequal cutouts, 36 to 100
slots, a hot or a cold blackbody, noise, a rolled camera, delays that are set, lost frames, edges that are missing, doubled or
spurious, and recordings without references or integration time. A refusal is no error; a number that is wrong without a word is.

    .venv/bin/python benchmarks/operating_conditions.py --rigs 100 --out conditions.jsonl
"""

import argparse
import json
import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import monotonic
from typing import final

import numpy as np

from irtiming.records.recording import CameraType, ReadoutMode, Recording
from irtiming.records.rig import Measured
from irtiming.twin import random_laboratory
from irtiming.twin import rig as rigs
from irtiming.twin.noise import generator
from irtiming.twin.random_laboratory import Wanted
from irtiming.twin.rig import SimulatedRig
from irtiming.twin.scene import CameraTiming, EdgeFaults, Faults, Scene, with_wheel_speed
from laboratory_coverage import known_lines, outcome, table

KINDS: tuple[tuple[CameraType, ReadoutMode, float], ...] = (
    ("photon", "snapshot", 0.35), ("photon", "rolling", 0.2),
    ("microbolometer", "rolling", 0.35), ("microbolometer", "snapshot", 0.1),
)  # fmt: skip
PLACES_DEG = (-90, -90, -90, 0, 90, 180, -60, -120)
UNEQUAL_RAD = (0.0, 1.62, 3.2, 4.65)
U_ROLL_RAD = math.radians(3)


@final
@dataclass(frozen=True, kw_only=True)
class Conditions:
    """What is drawn beside the defects; angles of the mask in degrees, of the camera in quarter turns."""

    frame_hz: float
    window_s: float
    lag_s: float
    place_deg: float
    opening_deg: float
    is_unequal: bool
    is_inverted: bool
    noise: float
    slots: int
    quarter_turns: int
    wander: float
    has_references: bool
    states_window: bool


def drawn(seed: int) -> tuple[Wanted, Conditions]:
    """Kind of laboratory and its operating point."""
    random = generator(seed, "laboratory", index=20)

    def between(low: float, high: float) -> float:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))

    camera, readout, _ = KINDS[int(random.choice(len(KINDS), p=[one[2] for one in KINDS]))]
    rates, n_rates = [between(1, 14)], int(random.choice([1, 1, 2, 3]))
    while len(rates) < n_rates:
        rate = between(1, 14)
        if all(abs(math.log(rate / other)) > math.log(1.3) for other in rates):
            rates.append(rate)
    wanted = Wanted(
        camera=camera, readout=readout, rows=int(random.integers(48, 100)), columns=int(random.integers(60, 130)),
        frames=round(between(150, 600)), wheel_hz=tuple(round(rate, 3) for rate in sorted(rates)),
    )  # fmt: skip
    frame_hz = between(8, 100)
    return wanted, Conditions(
        frame_hz=frame_hz,
        window_s=between(20e-6, min(8e-3, 0.7 / frame_hz)),
        lag_s=between(2e-3, 15e-3),
        place_deg=float(random.choice(PLACES_DEG) + random.normal()),
        opening_deg=float(random.uniform(45, 78)),
        is_unequal=bool(random.random() < 0.3),
        is_inverted=bool(random.random() < 0.4),
        noise=between(0.5, 4),
        slots=int(random.choice([100, 100, 60, 36])),
        quarter_turns=int(random.choice([0, 0, 0, 1, -1, 2])),
        wander=float(random.choice([1, 1, 5])),
        has_references=bool(random.random() < 0.7),
        states_window=bool(random.random() < 0.7),
    )


def experiment(wanted: Wanted, point: Conditions, *, seed: int) -> Scene:
    """The experiment at that point, without imperfections."""
    scene = random_laboratory.nominal(wanted, seed=seed)
    light = scene.radiance
    if point.is_inverted:
        mask_k = light.blackbody_k + math.copysign(0.1, light.blackbody_k - light.wheel_k)
        light = replace(light, blackbody_k=light.wheel_k, wheel_k=light.blackbody_k, mask_k=mask_k)
    edges = UNEQUAL_RAD if point.is_unequal else scene.wheel.ring_edges_rad
    photon = isinstance(scene.timing, CameraTiming)
    changed = {"integration_time_s": point.window_s} if photon else {"time_constant_s": point.lag_s}
    roll_rad = scene.optics.roll_rad + point.quarter_turns * math.pi / 2
    mask = replace(
        scene.mask, centre_angle_rad=math.radians(point.place_deg), opening_angle_rad=math.radians(point.opening_deg)
    )
    return replace(
        scene,
        wheel=replace(scene.wheel, ring_edges_rad=edges, control_slot_errors_rad=(0.0,) * point.slots),
        wander=replace(scene.wander, relative=scene.wander.relative * point.wander),
        mask=mask,
        optics=replace(scene.optics, roll_rad=roll_rad),
        radiance=light,
        detector=replace(scene.detector, noise_dn=scene.detector.noise_dn * point.noise),
        timing=replace(scene.timing, **changed),
    )


def laboratory(wanted: Wanted, point: Conditions, *, seed: int) -> SimulatedRig:
    """Its rig; a camera that is rolled on purpose is stated as such."""
    rig = random_laboratory.draw(wanted, seed=seed, experiment=experiment(wanted, point, seed=seed))
    if not point.quarter_turns:
        return rig
    roll = Measured(point.quarter_turns * math.pi / 2, U_ROLL_RAD)
    return replace(rig, measured=replace(rig.measured, camera=replace(rig.measured.camera, roll_rad=roll)))


def recordings(rig: SimulatedRig, wanted: Wanted, point: Conditions, *, seed: int) -> Iterator[Recording]:
    """One run at each wheel rate, each with faults of its own."""
    random = generator(seed, "laboratory", index=21)
    for index, rate_hz in enumerate(wanted.wheel_hz):
        scene = with_wheel_speed(rig.scene, rate_hz, frame_hz=point.frame_hz, samples=wanted.frames)
        slots = EdgeFaults(
            missing=int(random.integers(3)), doubled=int(random.integers(3)), spurious=int(random.integers(3))
        )
        faults = Faults(lost_frames=int(random.choice([0, 0, 3, 10])), control_slot=slots)
        trigger = replace(scene.trigger, trigger_delay_time_set_s=float(random.choice([0, 1e-3, 5e-3, 7.5e-3])))
        scene = replace(scene, trigger=trigger, faults=faults)
        run = rigs.simulate(scene, seed=seed + 1_000_003 * (index + 1), name=f"{wanted.camera}-{rate_hz:g}Hz")
        run = run if point.has_references else replace(run, nonuniformity=None)
        yield run if point.states_window else replace(run, integration_time_s=None)


def one_laboratory(seed: int) -> dict[str, object]:
    """What became of one, ready for a line of JSON."""
    begun = monotonic()
    wanted, point = drawn(seed)
    line: dict[str, object] = json.loads(json.dumps({**asdict(wanted), "conditions": asdict(point), "seed": seed}))
    rig = laboratory(wanted, point, seed=seed)
    return line | outcome(rig, recordings(rig, wanted, point, seed=seed)) | {"seconds": monotonic() - begun}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0, help="of the first rig")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="JSON lines; laboratories that are there already are not tried again")
    options = parser.parse_args()
    there = {int(str(line["seed"])): line for line in known_lines(options.out)}
    wanted = range(options.seed, options.seed + options.rigs)
    with ProcessPoolExecutor(options.workers) as pool:
        for line in pool.map(one_laboratory, [seed for seed in wanted if seed not in there]):
            there[int(str(line["seed"]))] = line
            if options.out is not None:
                with options.out.open("a") as file:
                    file.write(json.dumps(line) + "\n")
    for camera in ("photon", "microbolometer"):
        lines = [there[seed] for seed in wanted if there[seed]["camera"] == camera]
        if lines:
            print(f"\n{len(lines)} laboratories, {camera}, all conditions drawn\n\n{table(lines)}")


if __name__ == "__main__":
    main()
