"""Does the planner foretell what comes out? Predicted, stated and true errors over simulated rigs, for both kinds of cameras.

Three predictions are compared with the root mean square error and the root mean square of the stated standard uncertainty:
*planned* knows the camera's noise and pixels and what rig.toml states, as `irtiming plan --for` does; *in hindsight* takes noise,
angles and the uncertainties of the rig's angles from the recordings, as the report does.

    python benchmarks/accuracy/prediction.py --rigs 12
    python benchmarks/accuracy/prediction.py --rigs 24 --camera microbolometer
"""

import argparse
import sys
from collections.abc import Iterator

import numpy as np

from irtiming.errors import ReductionError
from irtiming.measurement import analyse
from irtiming.plan.assumptions import assumed
from irtiming.plan.photon_information import OWN_SHAPE
from irtiming.plan.prediction import Setting, uncertainties
from irtiming.records.analysis import Analysis
from irtiming.records.camera_description import Camera, Microbolometer, PhotonCamera
from irtiming.records.rig import Rig
from irtiming.records.trigger_plan import TriggerScheme
from irtiming.twin import rig as twin
from irtiming.twin.scene import Scene, microbolometer_scene, paper_scene, with_wheel_speed

DELAYS_S = (0.0, 0.025)
CASES = (
    ("photon", (3.0,), ("trigger_delay", "relative_delay")),
    ("photon", (3.0, 12.0), ("trigger_delay",)),
    ("microbolometer", (3.0,), ("trigger_delay", "time_constant", "row_delay")),
)


def recordings(scene: Scene, speeds_hz: tuple[float, ...], seed: int) -> Iterator[object]:
    delays = DELAYS_S if hasattr(scene.timing, "integration_time_s") else DELAYS_S[:1]
    for k, speed in enumerate(speeds_hz):
        yield from twin.series(with_wheel_speed(scene, speed), delays, repeats=1, seed=10 * seed + k)


def planned(
    kind: str, speeds_hz: tuple[float, ...], names: tuple[str, ...], *, rig: Rig, pixels: float
) -> dict[str, float]:
    radiance = (paper_scene if kind == "photon" else microbolometer_scene)(120, 160)
    step = abs(radiance.radiance.blackbody_k - radiance.radiance.wheel_k) * radiance.radiance.dn_per_k
    noise = radiance.detector.noise_dn / step
    camera: Camera = (
        PhotonCamera(noise_to_contrast=noise, opening_pixels=pixels)
        if kind == "photon"
        else Microbolometer(noise_to_contrast=noise, opening_pixels=pixels)
    )
    trigger = radiance.trigger
    setting = Setting(
        camera=camera, rig=assumed(rig, camera), clock_frequency_hz=int(trigger.clock_frequency_hz), structure=OWN_SHAPE
    )
    runs = []
    for speed in speeds_hz:
        there = with_wheel_speed(radiance, speed).trigger
        scheme = TriggerScheme(turn_period_ticks=there.turn_period_ticks, camera_period_ticks=there.camera_period_ticks)
        runs.append((setting.one_run(scheme), 1))
    n_delays = len(DELAYS_S) if kind == "photon" else 1
    return {each.name: each.standard_uncertainty_s for each in uncertainties(runs, names, n_delays=n_delays)}


def outcome(done: Analysis, scene: Scene, name: str) -> tuple[float, float, float]:
    """Error, stated and predicted uncertainty."""
    assert done.prediction is not None
    if name == "relative_delay":
        (found,) = [each for each in done.best.relative_delays if each.nominal_s > 0]
        (told,) = done.prediction.relative_delays
        return found.value_s - found.nominal_s, found.standard_uncertainty_s, told.standard_uncertainty_s
    estimate = done.best.estimate
    k = estimate.names.index(name)
    (foretold,) = [each.standard_uncertainty_s for each in done.prediction.uncertainties if each.name == name]
    return (
        float(estimate.values[k]) - getattr(scene.timing, f"{name}_s"),
        float(estimate.standard_uncertainties[k]),
        foretold,
    )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rigs", type=int, default=12)
    options.add_argument("--seed", type=int, default=3000)
    options.add_argument("--camera", choices=("photon", "microbolometer"), help="one of them alone")
    given = options.parse_args()
    print(
        f"{given.rigs} rigs from seed {given.seed} on, 160 x 120 pixels, one run of 1000 frames per set delay and speed; us\n"
    )
    print("| camera, wheel | parameter | planned | in hindsight | stated | rms error | stated / in hindsight |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: |")
    for kind, speeds_hz, names in (case for case in CASES if given.camera in (None, case[0])):
        found: dict[str, list[tuple[float, ...]]] = {name: [] for name in names}
        for seed in range(given.seed, given.seed + given.rigs):
            nominal = paper_scene(120, 160) if kind == "photon" else microbolometer_scene(120, 160)
            rig = twin.draw(nominal, seed=seed)
            try:
                done = analyse(recordings(rig.scene, speeds_hz, seed), rig.measured, extras=("prediction",))
            except ReductionError as error:  # a camera that was drawn so far aside that the opening is not all in view
                print(f"seed {seed} is left out: {error}", file=sys.stderr)
                continue
            pixels = float(done.recordings[0].opening.mask.sum())
            before = planned(kind, speeds_hz, names, rig=rig.measured, pixels=pixels)
            for name in names:
                found[name].append((before[name], *outcome(done, rig.scene, name)))
        for name, rows in found.items():
            before_s, error, stated, hindsight = 1e6 * np.sqrt(np.mean(np.square(rows), axis=0))
            speeds = " and ".join(f"{speed:g}" for speed in speeds_hz)
            print(
                f"| {kind}, {speeds} Hz | {name} | {before_s:.3g} | {hindsight:.3g} | {stated:.3g} | {error:.3g} | "
                f"{np.median([row[2] / row[3] for row in rows]):.2f} |"
            )


if __name__ == "__main__":
    main()
