"""How much faster is the exact fit than the published procedure, and which is nearer the truth? Both on the same row sums.

The exact fit is timed from row sums to covariance (`row_fit.fit` with its search for start values, and `rolling_timing`), the
published one from averaged opening fractions to its parameters (`row_delay_and_lag.fit`). Reading frames, which takes longer
than either, is left out, and so is the opening's shape, which is found once for all recordings of a camera.

    .venv/bin/python benchmarks/rolling_speed.py
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from irtiming.estimate import row_fit, row_light, timing, wheel_geometry
from irtiming.estimate.published import row_delay_and_lag
from irtiming.physics.response.first_order_lag import HARMONICS
from irtiming.records.choices import Choices
from irtiming.records.lag_estimate import WheelInImage
from irtiming.reduce import recipes
from irtiming.reduce.published import row_averages
from irtiming.twin import rig as twin
from irtiming.twin.scene import microbolometer_scene

NAMES = ("trigger_delay", "time_constant", "row_delay")


def best_of(repeats: int, work: Callable[[], object]) -> tuple[float, float]:
    """Shortest of several runs by the clock, and least processor time, s; the first run, which compiles, does not count."""
    work()
    walls, processors = [], []
    for _ in range(repeats):
        begin, used = time.perf_counter(), time.process_time()
        work()
        walls.append(time.perf_counter() - begin)
        processors.append(time.process_time() - used)
    return min(walls), min(processors)


def compare(rows: int, columns: int, seed: int, repeats: int) -> None:
    scene = microbolometer_scene(rows, columns)
    scene = replace(scene, optics=replace(scene.optics, pixel_pitch_m=1.1 * scene.optics.pixel_pitch_m))
    rig = twin.draw(scene, seed=seed)
    reduced = recipes.reduce(twin.simulate(rig.scene, seed=seed), rig.measured, choices=Choices())
    begin = time.perf_counter()
    found = timing.estimate([reduced], rig.measured)
    whole_s = time.perf_counter() - begin
    seen = found.recordings[0]
    light = row_light.row_light(seen.row_sums.row_px, found.sectors[0], n_harmonics=HARMONICS)
    wheel, known = found.geometry.model, found.fits[0]

    def exact() -> object:
        fit = row_fit.fit(seen, wheel, light=light)
        fit = replace(fit, shape_effect=known.shape_effect)
        return timing.of_row_fits([fit], found.geometry, sectors=found.sectors, n_rows=rows)

    equal = wheel_geometry.geometry(found.recordings, rig.measured, slots="equal", off_axle_mask=False)
    assert seen.axle is not None
    in_image = WheelInImage(
        row_px=seen.axle.row_px, column_px=seen.axle.column_px, roll_rad=equal.camera_roll_rad or 0.0
    )
    data = row_averages.average([seen])

    def published() -> row_delay_and_lag.PublishedLagFit:
        return row_delay_and_lag.fit(data, equal.model, wheel=in_image, initial_row_delay_s=1 / 30.303 / rows)

    (exact_s, exact_cpu_s), (published_s, published_cpu_s) = best_of(5 * repeats, exact), best_of(repeats, published)
    told = published()
    truth = twin.truth(rig.scene)
    print(f"\n{columns} x {rows} pixels, {light.row_px.size} rows, {seen.trigger_ticks.size} frames")
    print(f"  published procedure {1e3 * published_s:9.1f} ms ({told.n_simulations} simulations)")
    print(f"  exact fit           {1e3 * exact_s:9.1f} ms: {published_s / exact_s:.0f} times faster")
    print(
        f"  processor time      {1e3 * published_cpu_s:9.1f} and {1e3 * exact_cpu_s:.1f} ms: "
        f"{published_cpu_s / exact_cpu_s:.0f} times less (the published procedure runs in two threads, the exact fit in one)"
    )
    print(f"  opening's shape, light and fit in turns until they agree: {whole_s:.1f} s, once for all recordings")
    values = found.found.result.estimate.values
    published_values = (told.timing.trigger_delay_s, told.timing.time_constant_s, told.timing.row_delay_s)
    for k, name in enumerate(NAMES):
        true = float(str(truth[f"{name}_s"]))
        print(
            f"  error of {name:14} exact {1e6 * (values[k] - true):+10.3f} us, "
            f"published {1e6 * (published_values[k] - true):+10.3f} us"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--small", action="store_true", help="only the small image")
    arguments = parser.parse_args()
    np.seterr(all="raise", under="ignore")
    for rows, columns in ((120, 160), (480, 640))[: 1 if arguments.small else 2]:
        compare(rows, columns, arguments.seed, arguments.repeats)


if __name__ == "__main__":
    main()
