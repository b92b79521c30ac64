"""What is left of the slots' errors in the wheel angle: equal slots, slots learned at one speed, and at two.

The twin's wheel has 100 slots that are wrong by 0.2 mrad each for itself and by 0.4 mrad of eccentricity; its gate has 0.5 us of
jitter, its clock ticks at 49.152 MHz. For each case several wheels are drawn and spun. Of each the table of the slots is held
against the truth; the rms error is printed as a time at 3 Hz, with the rms stated uncertainty behind it.

    python benchmarks/slot_table.py --rigs 6
    python benchmarks/slot_table.py --rigs 0 --figure docs/explanation/slot-table.svg     # the explanation page's figure
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from irtiming.physics import slot_orders
from irtiming.records.recording import Recording
from irtiming.reduce.wheel import wheel_calibration
from irtiming.report import sheet
from irtiming.report.sections import wheel as wheel_section
from irtiming.twin.rig import SimulatedRig, Tolerances, draw, simulate
from irtiming.twin.scene import Ripple, SpeedWander, paper_scene, with_wheel_speed

TURN = 2 * np.pi
US = 1e6 / (TURN * 3)
TOLERANCES = Tolerances(slot_error_rad=0.2e-3, slot_eccentricity_rad=0.4e-3)
ORDERS = {1: 5e-4, 2: 3e-4}


@dataclass(frozen=True, kw_only=True)
class Case:
    name: str
    turns: int
    runs: int = 1
    wander: float = 0.0
    ripple: bool = False
    speeds_hz: tuple[float, ...] = (3.0,)


CASES = (
    Case(name="constant speed, 20 turns", turns=20),
    Case(name="constant speed, 100 turns", turns=100),
    Case(name="wander 0.01 %, 100 turns", turns=100, wander=1e-4),
    Case(name="wander 0.1 %, 20 turns", turns=20, wander=1e-3),
    Case(name="wander 0.1 %, 100 turns", turns=100, wander=1e-3),
    Case(name="wander 0.1 %, 20 runs of 100 turns", turns=100, runs=20, wander=1e-3),
    Case(name="wander 1 %, 100 turns", turns=100, wander=1e-2),
    Case(name="ripple, 10 runs of 100 turns at 3 Hz", turns=100, runs=10, ripple=True),
    Case(name="ripple, 10 runs of 100 turns at 6 Hz", turns=100, runs=10, ripple=True, speeds_hz=(6.0,)),
    Case(name="ripple, 5 runs at 3 Hz and 5 at 6 Hz", turns=100, runs=5, ripple=True, speeds_hz=(3.0, 6.0)),
    Case(name="ripple and wander 0.01 %, 5 and 5", turns=100, runs=5, wander=1e-4, ripple=True, speeds_hz=(3.0, 6.0)),
    Case(name="ripple and wander 0.01 %, 1 and 1", turns=100, wander=1e-4, ripple=True, speeds_hz=(3.0, 6.0)),
    Case(name="no ripple, wander 0.01 %, 1 and 1", turns=100, wander=1e-4, speeds_hz=(3.0, 6.0)),
    Case(name="no ripple, wander 0.01 %, 2 at 3 Hz", turns=100, runs=2, wander=1e-4),
)


def drawn(case: Case, hz: float, seed: int) -> SimulatedRig:
    scene = with_wheel_speed(paper_scene(64, 64), hz)
    fall = (3 / hz) ** 2 if case.ripple else 0.0  # a torque gives a ripple of the speed that falls with its square
    ripples = tuple(Ripple(order=order, relative=size * fall, phase_rad=order) for order, size in ORDERS.items())
    trigger = scene.trigger
    frames = int(case.turns * trigger.turn_period_ticks / trigger.camera_period_ticks)
    scene = replace(
        scene,
        wander=SpeedWander(relative=case.wander, ripples=ripples),
        beams=replace(scene.beams, jitter_s=0.5e-6),
        trigger=replace(trigger, n_triggers=frames),
    )
    rig = draw(scene, seed=seed, tolerances=TOLERANCES)
    ring = rig.scene.wheel.ring_edges_rad
    wheel = replace(rig.scene.wheel, ring_edges_rad=(ring[0], ring[1], np.pi + 0.03, ring[3]))  # told in any wander
    return replace(rig, scene=replace(rig.scene, wheel=wheel))


def recordings(case: Case, seed: int) -> list[Recording]:
    found = []
    for speed, hz in enumerate(case.speeds_hz):
        rig = drawn(case, hz, seed)
        for run in range(case.runs):
            turned = replace(rig.scene.trigger, start_angle_rad=1.7 * run)
            found.append(simulate(replace(rig.scene, trigger=turned), seed=10_000 * seed + 100 * speed + run))
    return found


def rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def draw_figure(path: Path) -> None:
    """One wheel from two runs at 3 Hz and two at 6 Hz, with a ripple of the speed."""
    case = Case(name="drawn", turns=99, speeds_hz=(3.0, 6.0), runs=2, wander=1e-4, ripple=True)
    rig = drawn(case, 3.0, 1)
    wheel = wheel_calibration.from_recordings(recordings(case, 1), rig.measured)
    path.write_text(sheet.svg(wheel_section.calibration(wheel), title="Deviation of the control slots, and its orders"))


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--rigs", type=int, default=6)
    arguments.add_argument("--figure", type=Path, help="draw the figure of the explanation page into this file")
    options = arguments.parse_args()
    if options.figure is not None:
        draw_figure(options.figure)
    if not options.rigs:
        return
    print(f"{options.rigs} wheels for each case; rms error of a slot in us at 3 Hz\n")
    print("| case | equal slots | learned | stated u |")
    print("| --- | ---: | ---: | ---: |")
    for case in CASES:
        equal, learned, u = [], [], []
        for seed in range(1, options.rigs + 1):
            rig = drawn(case, case.speeds_hz[0], seed)
            wheel = wheel_calibration.from_recordings(recordings(case, seed), rig.measured)
            true = np.array(rig.scene.wheel.control_slot_errors_rad)
            equal.append(np.std(true) * US)
            learned.append(np.std(wheel.slot_deviation_rad - true) * US)
            u.append(slot_orders.u_slot_rad(wheel.order_variance_rad2, true.size) * US)
        print(f"| {case.name} | {rms(equal):.1f} | {rms(learned):.2f} | {rms(u):.2f} |", flush=True)


if __name__ == "__main__":
    main()
