"""Errors and pulls over random simulated rigs of a camera that runs free, by strobe, stamps and arrivals, beside a triggered one.

Every rig has its own wheel, gates, mask, optics and delay; rig.toml is off by its stated uncertainties, which are small here (2
um and 0.002 deg), so that what events add shows. Every camera has its own period, phase and clock, the computer too (20 ppm, k
= 1); stamps scatter by 50 us, arrivals by a gamma distribution with 2 % of hiccups up to 20 ms, and a tenth of the frames is
lost in every other rig. Wheel speed 3 Hz, 300 frames of 60 x 80 pixels.

    .venv/bin/python benchmarks/free_running.py --rigs 50
"""

import argparse
import math
from dataclasses import replace
from typing import Literal

import numpy as np

from irtiming.measurement import analyse
from irtiming.records.frame_events import FreeEvent
from irtiming.twin import rig as twin
from irtiming.twin.cameras import camera_scene
from irtiming.twin.free_camera import draw_free
from irtiming.twin.rig import Tolerances
from irtiming.twin.scene import Faults, with_wheel_speed

KINDS: tuple[Literal["trigger"] | FreeEvent, ...] = ("trigger", "strobe", "stamp", "arrival")
FRAMES, ROWS, COLUMNS = 300, 60, 80
KNOWN = Tolerances(u_beam_m=2e-6, u_mask_angle_rad=math.radians(0.002))


def error_and_u(
    kind: Literal["trigger"] | FreeEvent, seed: int, *, camera: Literal["photon", "microbolometer"]
) -> tuple[float, float]:
    """Error of the first delay of one rig, and its standard uncertainty, s."""
    nominal = with_wheel_speed(camera_scene(camera, None, rows=ROWS, columns=COLUMNS), 3.0, samples=FRAMES)
    rig = twin.draw(nominal, seed=seed, tolerances=KNOWN)
    scene = replace(rig.scene, faults=Faults(lost_frames=FRAMES // 10 * (seed % 2)))
    if kind != "trigger":
        scene = replace(scene, free=draw_free(kind, seed=seed))
    found = analyse([twin.simulate(scene, seed=seed)], rig.measured).best.estimate
    true = next(value for name, value in twin.truth(scene).items() if name in NAMES)
    return found.value("trigger_delay") - float(true), found.u("trigger_delay")  # type: ignore[arg-type]


NAMES = ("trigger_delay_s", "strobe_delay_s", "timestamp_delay_s")


def main() -> None:
    """Print a line per rig, and a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--camera", choices=("photon", "microbolometer"), default="photon")
    given = parser.parse_args()
    pairs: dict[str, list[tuple[float, float]]] = {kind: [] for kind in KINDS}
    for seed in range(given.seed, given.seed + given.rigs):
        for kind in KINDS:
            error, u = error_and_u(kind, seed, camera=given.camera)
            pairs[kind].append((error, u))
            print(f"{seed:4d}  {kind:8s} {1e6 * error:+9.2f} us  u {1e6 * u:8.2f} us  {error / u:+.2f} u", flush=True)
    print("event      rigs   rms error   median u   pull: mean    sd   within 1 u   2 u   largest")
    for kind, found in pairs.items():
        error, u = np.array(found).T
        pull = error / u
        print(
            f"{kind:8s} {pull.size:6d} {1e6 * np.sqrt(np.mean(error**2)):8.1f} us {1e6 * np.median(u):7.1f} us "
            f"{pull.mean():12.2f} {pull.std():6.2f} {100 * np.mean(np.abs(pull) < 1):10.0f} % "
            f"{100 * np.mean(np.abs(pull) < 2):4.0f} % {np.abs(pull).max():7.2f}"
        )


if __name__ == "__main__":
    main()
