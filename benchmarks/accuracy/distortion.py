"""Errors and pulls with a lens that distorts and an axle that is not in the middle of the image, both kinds of camera.

Each rig has its own random imperfections; rig.toml says nothing of the lens unless --stated gives its uncertainty. The axle is a
tenth of the image's rows below its middle and an eighth of them to the left.

    .venv/bin/python benchmarks/accuracy/distortion.py bolometer --rigs 6
    .venv/bin/python benchmarks/accuracy/distortion.py photon --rigs 6 --distortion 0
    .venv/bin/python benchmarks/accuracy/distortion.py bolometer --rows 480 --columns 640 --rigs 1 --runs 2
"""

import argparse
import time
from dataclasses import replace

import numpy as np

from irtiming import measurement
from irtiming.records.analysis import Analysis
from irtiming.records.rig import CameraOptics, Measured, Rig
from irtiming.twin import rig as twin
from irtiming.twin.rig import SimulatedRig
from irtiming.twin.scene import BolometerTiming, Scene, microbolometer_scene, paper_scene

ROWS_OFF, COLUMNS_OFF = 0.1, -0.125  # of the number of rows


def beside_the_middle(scene: Scene, *, distortion: float = -0.05) -> Scene:
    """Axle a tenth of the rows below the image's middle and an eighth of them to the left, and a lens."""
    rows = float(scene.detector.rows)
    optics = replace(
        scene.optics,
        distortion=distortion,
        wheel_centre_row_px=scene.optics.wheel_centre_row_px + ROWS_OFF * rows,
        wheel_centre_column_px=scene.optics.wheel_centre_column_px + COLUMNS_OFF * rows,
    )
    return replace(scene, optics=optics)


def scene_of(given: argparse.Namespace) -> Scene:
    scene = (paper_scene if given.camera == "photon" else microbolometer_scene)(given.rows, given.columns)
    if given.centred:
        return replace(scene, optics=replace(scene.optics, distortion=given.distortion))
    return beside_the_middle(scene, distortion=given.distortion)


def stated(rig: SimulatedRig, u: float | None, seed: int) -> Rig:
    """rig.toml, with a lens where its uncertainty is given."""
    if u is None:
        return rig.measured
    value = rig.scene.optics.distortion + u * float(np.random.default_rng([seed, 9]).standard_normal())
    detector = rig.scene.detector
    per_width = detector.columns**2 / (detector.rows**2 + detector.columns**2)  # rig.toml has it over half the width
    return replace(rig.measured, camera=CameraOptics(distortion=Measured(value * per_width, u * per_width)))


def truth(scene: Scene) -> dict[str, float]:
    timing, optics = scene.timing, scene.optics
    known = {"axle row": optics.wheel_centre_row_px, "axle column": optics.wheel_centre_column_px}
    known |= {"bisector": scene.mask.centre_angle_rad + optics.roll_rad, "distortion": optics.distortion}
    known["trigger_delay"] = timing.trigger_delay_s
    if isinstance(timing, BolometerTiming):
        known |= {"time_constant": timing.time_constant_s, "row_delay": timing.row_delay_s}
    return known


def told(analysis: Analysis) -> dict[str, tuple[float, float]]:
    """Values and standard uncertainties."""
    estimate = analysis.best.estimate
    view = analysis.recordings[0].axle
    assert view is not None
    found = {
        name: (float(value), float(u))
        for name, value, u in zip(estimate.names, estimate.values, estimate.standard_uncertainties, strict=True)
    }
    found |= {"axle row": (view.row_px, view.u_centre_px), "axle column": (view.column_px, view.u_centre_px)}
    found["bisector"] = (view.bisector_rad, view.u_bisector_rad)
    found["distortion"] = (view.distortion, view.u_distortion)
    return found


def one_rig(given: argparse.Namespace, seed: int) -> dict[str, tuple[float, float]]:
    """Error and uncertainty of each number."""
    rig = twin.draw(scene_of(given), seed=seed)
    runs = twin.series(rig.scene, [0.0], repeats=given.runs, seed=seed)
    analysis = measurement.analyse(list(runs), stated(rig, given.stated, seed))
    known = truth(rig.scene)
    errors = {}
    for name, (value, u) in told(analysis).items():
        if name in known:
            error = value - known[name]
            errors[name] = (float(np.angle(np.exp(1j * error))) if name == "bisector" else error, u)
    return errors


UNITS = {"axle row": (1, "px"), "axle column": (1, "px"), "bisector": (1e3, "mrad"), "distortion": (1, "")}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("camera", choices=("bolometer", "photon"))
    parser.add_argument("--rows", type=int, default=120)
    parser.add_argument("--columns", type=int, default=160)
    parser.add_argument("--rigs", type=int, default=6)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--distortion", type=float, default=-0.05)
    parser.add_argument("--stated", type=float, help="standard uncertainty of the distortion in rig.toml")
    parser.add_argument("--centred", action="store_true", help="axle in the middle of the image")
    given = parser.parse_args()
    all_found = []
    for seed in range(given.first, given.first + given.rigs):
        begun = time.perf_counter()
        found = one_rig(given, seed)
        all_found.append(found)
        words = [
            f"{name} {error * scale:+.4f}({u * scale:.4f}){unit}"
            for name, (error, u) in found.items()
            for scale, unit in [UNITS.get(name, (1e6, "us"))]
        ]
        print(f"rig {seed}, {time.perf_counter() - begun:.0f} s: " + ", ".join(words), flush=True)
    print(
        f"\n{given.camera}, {given.columns} x {given.rows}, distortion {given.distortion}, {given.runs} run(s) a rig\n"
    )
    print("| number | rms error | largest | rms u | rms pull |\n| --- | ---: | ---: | ---: | ---: |")
    for name in all_found[0]:
        error, u = np.array([found[name] for found in all_found]).T
        scale, unit = UNITS.get(name, (1e6, "us"))
        rms, rms_u, pull = (float(np.sqrt(np.mean(one**2))) for one in (error, u, error / u))
        largest = scale * np.abs(error).max()
        print(
            f"| {name.replace('_', ' ')} ({unit or '1'}) | {scale * rms:.4f} | {largest:.4f} | {scale * rms_u:.4f} | {pull:.2f} |"
        )


if __name__ == "__main__":
    main()
