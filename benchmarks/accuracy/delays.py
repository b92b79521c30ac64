"""Does the truth lie where the stated uncertainty says? Snapshot photon camera, many simulated rigs.

Wheel, slots, gates, mask, optics and camera of each rig are drawn anew, and so are the numbers in its rig.toml about the truth,
with the uncertainties that it states. A pull is (estimate - truth) / standard uncertainty: its root mean square should be 1,
and 68 % of the pulls should lie within 1, 95 % within 2. The Birge ratio is that of all pulls of a row.

    python benchmarks/accuracy/delays.py --rigs 200                            # one speed, two delays, one run each
    python benchmarks/accuracy/delays.py --rigs 100 --wheel-hz 3,5,8,12 --delays-ms 0
    python benchmarks/accuracy/delays.py --rigs 40 --any                      # blur 0.4 to 1.5 px, window 50 us to 1 ms
    python benchmarks/accuracy/delays.py --rows 512 --columns 640 --runs 5    # the paper's scale
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from irtiming.measurement import ALL_EXTRAS, analyse
from irtiming.records.recording import Recording
from irtiming.records.result import Result
from irtiming.twin import rig as twin
from irtiming.twin.rig import SimulatedRig
from irtiming.twin.scene import Scene, paper_scene, with_wheel_speed

Pairs = list[tuple[float, float]]


def drawn(options: argparse.Namespace, seed: int) -> SimulatedRig:
    """A rig; with --any its blur and integration time are drawn too."""
    nominal = paper_scene(options.rows, options.columns)
    if options.any:
        random = np.random.default_rng(seed)
        nominal = replace(
            nominal,
            optics=replace(nominal.optics, blur_px=random.uniform(0.4, 1.5)),
            timing=replace(
                nominal.timing, integration_time_s=float(np.exp(random.uniform(np.log(5e-5), np.log(1e-3))))
            ),
        )
    return twin.draw(nominal, seed=seed)


def recordings(options: argparse.Namespace, scene: Scene, seed: int) -> list[Recording]:
    delays_s = [1e-3 * float(text) for text in options.delays_ms.split(",")]
    return [
        one
        for k, speed in enumerate(options.wheel_hz.split(","))
        for one in twin.series(
            with_wheel_speed(scene, float(speed)), delays_s, repeats=options.runs, seed=10 * seed + k
        )
    ]


def one_rig(options: argparse.Namespace, seed: int) -> dict[str, Pairs]:
    """Errors and standard uncertainties of one rig, s."""
    rig = drawn(options, seed)
    scene = rig.scene
    analysis = analyse(recordings(options, scene, seed), rig.measured, extras=ALL_EXTRAS[:1])
    published = None if analysis.published is None else analysis.published.result
    start_s, window_s = scene.timing.trigger_delay_s, scene.timing.integration_time_s
    truth = {"trigger_delay": start_s, "integration_time": window_s}
    found: dict[str, Pairs] = {}
    for method, result in (("", analysis.best), (", as published", published)):
        if result is None:
            continue
        names, values, us = result.estimate.names, result.estimate.values, result.estimate.standard_uncertainties
        for name, true in truth.items():
            if name in names:
                k = names.index(name)
                found[name + method] = [(float(values[k]) - true, float(us[k]))]
        split = np.array([(n == "trigger_delay_falling") - float(n == "trigger_delay_rising") for n in names])
        u_split = float(np.sqrt(max(split @ result.estimate.covariance @ split, 0.0)))
        if u_split > 0:  # the published method cannot run on every rig
            found["falling - rising" + method] = [(float(split @ values), u_split)]
        if apart := relative(result, by_runs=result is analysis.best):
            found["relative delay" + method] = apart
    return found


def relative(result: Result, *, by_runs: bool) -> Pairs:
    """Each recording that is not a reference; the published method gives one for all runs of a delay."""
    entries = [e for e in result.relative_delays if e.nominal_s > 0]
    if not by_runs:
        entries = list({round(e.nominal_s, 9): e for e in entries}.values())
    return [(e.value_s - e.nominal_s, e.standard_uncertainty_s) for e in entries]


def row(name: str, pairs: Pairs) -> str:
    error, u = np.array(pairs).T
    pull = np.abs(error / u)
    return (
        f"| {name} | {error.size} | {1e6 * np.sqrt(np.mean(error**2)):.3f} | {1e6 * np.abs(error).max():.3f} | "
        f"{1e6 * np.sqrt(np.mean(u**2)):.3f} | {np.sqrt(np.mean(pull**2)):.2f} | {np.mean(pull < 1):.0%} | "
        f"{np.mean(pull < 2):.0%} |"
    )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rows", type=int, default=120)
    options.add_argument("--columns", type=int, default=160)
    options.add_argument("--wheel-hz", default="3")
    options.add_argument("--delays-ms", default="0,25")
    options.add_argument("--runs", type=int, default=1)
    options.add_argument("--rigs", type=int, default=40)
    options.add_argument("--seed", type=int, default=1000)
    options.add_argument("--workers", type=int, default=2, help="rigs at a time")
    options.add_argument("--any", action="store_true")
    options.add_argument("--tell", action="store_true", help="print the table after every rig")
    given = options.parse_args()
    found: dict[str, Pairs] = {}
    head = (
        f"{given.columns} x {given.rows} pixels, {given.wheel_hz} Hz, {given.delays_ms} ms, {given.runs} run(s) each"
        + (", blur and window drawn" if given.any else "")
    )
    seeds = range(given.seed, given.seed + given.rigs)
    with ProcessPoolExecutor(given.workers) as pool:
        for n, one in enumerate(pool.map(partial(one_rig, given), seeds), start=1):
            for name, pairs in one.items():
                found.setdefault(name, []).extend(pairs)
            if given.tell or n == given.rigs:
                print(f"\n{n} rigs from seed {given.seed} on, {head}\n")
                print(
                    "| quantity | number | rms error / us | largest | rms u / us | rms pull | within 1 u | within 2 u |"
                )
                print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
                for name in sorted(found, reverse=True):
                    print(row(name, found[name]), flush=True)


if __name__ == "__main__":
    main()
