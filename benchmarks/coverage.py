"""Does the truth lie where the stated uncertainty says? Many simulated rigs, each with its own random imperfections.

Wheel, slots, gates, mask, optics and camera of each rig are drawn anew, and so are the numbers in its rig.toml about the truth,
with the uncertainties that it states. A pull is (estimate - truth) / standard uncertainty: its root mean square should be 1,
and 68 % of the pulls should lie within 1, 95 % within 2.

    python benchmarks/coverage.py --rigs 40
"""

import argparse

import numpy as np

from irtiming.measurement import Analysis, analyse
from irtiming.records.estimate import DelayResult
from irtiming.twin import rig as twin
from irtiming.twin.scene import paper_scene

DELAYS_S = (0.0, 0.025)


def absolute(result: DelayResult, truth_s: float) -> list[tuple[float, float]]:
    k = result.estimate.names.index("trigger_delay")
    return [(result.estimate.values[k] - truth_s, result.estimate.standard_uncertainties[k])]


def relative(result: DelayResult, analysis: Analysis) -> list[tuple[float, float]]:
    """One entry per recording that is not a reference; the published method gives one for all runs of a delay."""
    entries = [e for e in result.relative_delays if e.nominal_s > 0]
    if result is analysis.as_published:
        entries = entries[:1]
    return [(e.value_s - e.nominal_s, e.standard_uncertainty_s) for e in entries]


def row(name: str, errors_and_us: list[tuple[float, float]]) -> str:
    error, u = np.array(errors_and_us).T
    pull = np.abs(error / u)
    return (
        f"| {name} | {error.size} | {1e6 * np.sqrt(np.mean(error**2)):.2f} | {1e6 * np.sqrt(np.mean(u**2)):.2f} | "
        f"{np.sqrt(np.mean(pull**2)):.2f} | {np.mean(pull < 1):.0%} | {np.mean(pull < 2):.0%} |"
    )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rows", type=int, default=120)
    options.add_argument("--columns", type=int, default=160)
    options.add_argument("--runs", type=int, default=2)
    options.add_argument("--rigs", type=int, default=40)
    options.add_argument("--seed", type=int, default=1000)
    given = options.parse_args()
    found: dict[str, list[tuple[float, float]]] = {}
    for seed in range(given.seed, given.seed + given.rigs):
        rig = twin.draw(paper_scene(given.rows, given.columns), seed=seed)
        analysis = analyse(twin.series(rig.scene, DELAYS_S, repeats=given.runs, seed=seed), rig.measured)
        for name, result in (("pixel sums", analysis.best), ("as published", analysis.as_published)):
            found.setdefault(f"trigger delay, {name}", []).extend(absolute(result, rig.scene.timing.trigger_delay_s))
            found.setdefault(f"relative delay, {name}", []).extend(relative(result, analysis))
    print(
        f"{given.rigs} rigs from seed {given.seed} on, {given.columns} x {given.rows} pixels, {len(DELAYS_S)} delays, "
        f"{given.runs} runs each, 3 Hz\n"
    )
    print("| delay, method | number | rms error / us | rms stated u / us | rms pull | within 1 u | within 2 u |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for name in sorted(found, reverse=True):
        print(row(name, found[name]))


if __name__ == "__main__":
    main()
