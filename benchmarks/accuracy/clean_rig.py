"""How near the errors come to the least that any estimator could have: root mean square over Cramér-Rao bound.

A rig without imperfections; only the frames' noise, the gates' jitter and the wheel's wander differ from run to run. The bound is
the Fisher information of the model at the noise that the frames have (`irtiming.plan`). Photon camera: of the pixel sums, with
angles known exactly for relative delays, and free where two wheel speeds must tell them. Microbolometer: of row sums and contrast
image together, with angles known exactly.

    python benchmarks/accuracy/clean_rig.py --draws 40
    python benchmarks/accuracy/clean_rig.py --draws 40 --camera microbolometer
"""

import argparse
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, replace
from functools import partial

import numpy as np

from irtiming.measurement import ALL_EXTRAS, analyse
from irtiming.twin import rig as twin
from irtiming.twin.rig import SimulatedRig, Tolerances
from irtiming.twin.scene import Scene, microbolometer_scene, paper_scene, with_wheel_speed

Pairs = dict[str, tuple[float, float]]
"""Error and bound of each quantity, s."""

_RING_EDGE_RAD = 0.5e-3  # without it the reference edge cannot be determined


def clean(scene: Scene, *, seed: int, u_mask_angle_rad: float) -> SimulatedRig:
    """No imperfection: wheel, plate and pixels even, everything where it is drawn."""
    even = replace(
        scene,
        radiance=replace(scene.radiance, mask_k=scene.radiance.wheel_k, narcissus_dn=0.0),
        detector=replace(scene.detector, gain_spread=0.0, offset_spread_dn=0.0),
    )
    exact = Tolerances(**{field.name: 0.0 for field in fields(Tolerances)})
    exact = replace(exact, ring_edge_rad=_RING_EDGE_RAD, u_mask_angle_rad=u_mask_angle_rad)
    return twin.draw(even, seed=seed, tolerances=exact)


def photon(seed: int, draw: int) -> Pairs:
    """Pixel sums: trigger delay from two wheel speeds, relative delay from one."""
    rig = clean(paper_scene(120, 160), seed=seed, u_mask_angle_rad=1e-3)  # else no free angle
    slow, fast = (
        list(twin.series(with_wheel_speed(rig.scene, speed), delays, repeats=1, seed=1000 * draw + int(speed)))
        for speed, delays in ((3.0, (0.0, 0.025)), (12.0, (0.0,)))
    )
    one = analyse(slow, rig.measured, extras=ALL_EXTRAS)
    both = analyse([slow[0], *fast], rig.measured, extras=ALL_EXTRAS)
    least = {u.name: u.standard_uncertainty_s for u in both.prediction.uncertainties}
    k = both.best.estimate.names.index("trigger_delay")
    return {
        "trigger delay, 3 and 12 Hz": (
            both.best.estimate.values[k] - rig.scene.timing.trigger_delay_s,
            least["trigger_delay"],
        ),
        "relative delay, 3 Hz": (
            one.best.relative_delays[1].value_s - 0.025,
            one.prediction.relative_delays[0].standard_uncertainty_s,
        ),
    }


def microbolometer(seed: int, draw: int) -> Pairs:
    """Row sums of one recording at 3 Hz."""
    scene = microbolometer_scene(120, 160)
    roomy = replace(scene, optics=replace(scene.optics, pixel_pitch_m=1.12 * scene.optics.pixel_pitch_m))
    rig = clean(roomy, seed=seed, u_mask_angle_rad=1e-6)
    done = analyse(
        list(twin.series(rig.scene, [0.0], repeats=1, seed=1000 * draw + 3)), rig.measured, extras=ALL_EXTRAS
    )
    least = {u.name: u.standard_uncertainty_s for u in done.prediction.uncertainties}
    return {
        f"{name.replace('_', ' ')}, 3 Hz": (value - getattr(rig.scene.timing, f"{name}_s"), least[name])
        for name, value in zip(done.best.estimate.names, done.best.estimate.values, strict=True)
    }


CAMERAS: dict[str, Callable[[int, int], Pairs]] = {"photon": photon, "microbolometer": microbolometer}


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--camera", choices=list(CAMERAS), default="photon")
    options.add_argument("--draws", type=int, default=40)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--workers", type=int, default=2, help="draws at a time")
    given = options.parse_args()
    with ProcessPoolExecutor(given.workers) as pool:
        told = list(pool.map(partial(CAMERAS[given.camera], given.seed), range(given.draws)))
    print(f"{given.draws} draws of noise from seed {given.seed} on, {given.camera}, 160 x 120 pixels, one run each\n")
    print("| quantity | rms error / us | Cramér-Rao bound / us | ratio | standard error of the ratio |")
    print("| --- | ---: | ---: | ---: | ---: |")
    for name in told[0]:
        error, bound = np.array([one[name] for one in told]).T
        rms, least_s = float(np.sqrt(np.mean(error**2))), float(np.sqrt(np.mean(bound**2)))
        print(
            f"| {name} | {1e6 * rms:.3f} | {1e6 * least_s:.3f} | {rms / least_s:.2f} | "
            f"{rms / least_s / np.sqrt(2 * len(told)):.2f} |"
        )


if __name__ == "__main__":
    main()
