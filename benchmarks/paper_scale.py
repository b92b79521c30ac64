"""The paper's experiment at the paper's scale on the twin: both methods on the same frames, beside the paper's Table 1.

Five nominal delays, twenty runs each, 640 x 512 pixels, 1000 frames a run: 100 000 frames, made, counted and summed as they
stream past; nothing is stored. Each rig has its own random imperfections and rig.toml numbers that are off by their stated
uncertainties.

    python benchmarks/paper_scale.py                      # the paper's scale, one rig: about a quarter of an hour
    python benchmarks/paper_scale.py --rows 120 --columns 160 --runs 3 --rigs 10
"""

import argparse

import numpy as np

from irtiming.cli.progress import shown
from irtiming.measurement import ALL_EXTRAS, analyse
from irtiming.records.analysis import Analysis
from irtiming.records.result import Result
from irtiming.twin import rig as twin
from irtiming.twin.scene import paper_scene

DELAYS_S = (0.0, 0.025, 0.050, 0.075, 0.100)
PAPER_DEVIATION_US = np.array([-1.745, -0.652, 3.000, -2.021])
PAPER_U_US = np.array([1.123, 1.277, 1.083, 1.137])


def by_nominal(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Mean deviation and mean standard uncertainty of the runs of each nominal delay, us; the first one left out."""
    nominal = np.array([entry.nominal_s for entry in result.relative_delays])
    deviation = np.array([entry.value_s - entry.nominal_s for entry in result.relative_delays])
    u = np.array([entry.standard_uncertainty_s for entry in result.relative_delays])
    groups = [np.isclose(nominal, delay) for delay in DELAYS_S[1:]]
    return np.array([1e6 * deviation[g].mean() for g in groups]), np.array([1e6 * u[g].mean() for g in groups])


def absolute(result: Result, truth_s: float) -> tuple[float, float]:
    k = result.estimate.names.index("trigger_delay")
    return 1e6 * (result.estimate.values[k] - truth_s), 1e6 * result.estimate.standard_uncertainties[k]


def show(analysis: Analysis, truth: dict[str, object]) -> tuple[np.ndarray, np.ndarray]:
    rows = [("published", *by_nominal(analysis.published.result)), ("pixel-sum", *by_nominal(analysis.best))]
    print(f"{'deviation in us at':>22}" + "".join(f"{1e3 * d:>16.0f} ms" for d in DELAYS_S[1:]) + f"{'rms':>8}")
    for name, deviation, u in [("the paper's camera", PAPER_DEVIATION_US, PAPER_U_US), *rows]:
        cells = "".join(f"{d:>+9.3f} +-{u_d:6.3f}" for d, u_d in zip(deviation, u, strict=True))
        print(f"{name:>22}{cells}{np.sqrt(np.mean(deviation**2)):>9.3f}")
    for name, result in (("published", analysis.published.result), ("pixel-sum", analysis.best)):
        error, u = absolute(result, float(truth["trigger_delay_s"]))
        falling, rising = (result.estimate.names.index(f"trigger_delay_{w}") for w in ("falling", "rising"))
        split = 1e6 * (result.estimate.values[falling] - result.estimate.values[rising])
        print(f"{name:>22}: trigger delay off by {error:+.2f} us, u = {u:.2f} us; falling minus rising {split:+.2f} us")
    return rows[0][1], rows[1][1]


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rows", type=int, default=512)
    options.add_argument("--columns", type=int, default=640)
    options.add_argument("--runs", type=int, default=20)
    options.add_argument("--rigs", type=int, default=1)
    options.add_argument("--seed", type=int, default=1)
    given = options.parse_args()
    all_published, all_best = [], []
    for seed in range(given.seed, given.seed + given.rigs):
        rig = twin.draw(paper_scene(given.rows, given.columns), seed=seed)
        with shown("frames") as told:
            analysis = analyse(
                twin.series(rig.scene, DELAYS_S, repeats=given.runs, seed=seed),
                rig.measured,
                progress=told,
                extras=ALL_EXTRAS[:1],
            )
        print(f"rig of seed {seed}, {given.columns} x {given.rows} pixels, {given.runs} runs for each delay")
        published, best = show(analysis, twin.truth(rig.scene))
        all_published.append(published)
        all_best.append(best)
    for name, deviations in (("published", all_published), ("pixel-sum", all_best)):
        print(f"rms deviation over {given.rigs} rigs, {name}: {np.sqrt(np.mean(np.square(deviations))):.3f} us")


if __name__ == "__main__":
    main()
