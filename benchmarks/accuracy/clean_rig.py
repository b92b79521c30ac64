"""How near the errors come to the least that any estimator of the pixel sums could have: root mean square over Cramér-Rao bound.

A rig without imperfections; only the frames' noise, the gates' jitter and the wheel's wander differ from run to run. The bound is
the Fisher information of the model at the noise that the frames have (`irtiming.plan`), angles known exactly for relative
delays, and free where two wheel speeds must tell them.

    python benchmarks/accuracy/clean_rig.py --draws 40
"""

import argparse
from dataclasses import fields, replace

import numpy as np

from irtiming.measurement import analyse_snapshot
from irtiming.twin import rig as twin
from irtiming.twin.rig import Tolerances
from irtiming.twin.scene import paper_scene, with_wheel_speed


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--draws", type=int, default=40)
    options.add_argument("--seed", type=int, default=1)
    given = options.parse_args()
    exact = Tolerances(**{field.name: 0.0 for field in fields(Tolerances)})
    clean = replace(exact, ring_edge_rad=0.5e-3, u_mask_angle_rad=1e-3)  # else no reference edge, and no free angle
    base = paper_scene(120, 160)
    even = replace(base, radiance=replace(base.radiance, mask_k=base.radiance.wheel_k, narcissus_dn=0.0))
    rig = twin.draw(even, seed=given.seed, tolerances=clean)
    true_s = rig.scene.timing.trigger_delay_s
    found: dict[str, list[tuple[float, float]]] = {}
    for draw in range(given.draws):
        slow, fast = (
            list(twin.series(with_wheel_speed(rig.scene, speed), delays, repeats=1, seed=1000 * draw + int(speed)))
            for speed, delays in ((3.0, (0.0, 0.025)), (12.0, (0.0,)))
        )
        one = analyse_snapshot(slow, rig.measured)
        both = analyse_snapshot([slow[0], *fast], rig.measured)
        least = {u.name: u.standard_uncertainty_s for u in both.prediction.uncertainties}
        k = both.best.estimate.names.index("trigger_delay")
        found.setdefault("trigger_delay, 3 and 12 Hz", []).append(
            (both.best.estimate.values[k] - true_s, least["trigger_delay"])
        )
        found.setdefault("relative delay, 3 Hz", []).append(
            (one.best.relative_delays[1].value_s - 0.025, one.prediction.relative_delays[0].standard_uncertainty_s)
        )
    print(f"{given.draws} draws of noise from seed {given.seed} on, 160 x 120 pixels, one run each\n")
    print("| quantity | rms error / us | Cramér-Rao bound / us | ratio | standard error of the ratio |")
    print("| --- | ---: | ---: | ---: | ---: |")
    for name, pairs in found.items():
        error, bound = np.array(pairs).T
        rms, least_s = float(np.sqrt(np.mean(error**2))), float(np.sqrt(np.mean(bound**2)))
        print(
            f"| {name} | {1e6 * rms:.3f} | {1e6 * least_s:.3f} | {rms / least_s:.2f} | "
            f"{rms / least_s / np.sqrt(2 * len(pairs)):.2f} |"
        )


if __name__ == "__main__":
    main()
