"""How straight the in-band radiance is over temperature, and what its bend does to a fitted lag.

A pixel is stepped through eq. (2) of the paper with a heat exchange that follows the radiance instead of a straight line.
Share s of its exchange is with the scene within the band, the rest with the substrate, which is linear. The opening is
the mean of such pixels, uncovered one after the other by a perfect wheel. A linear lag is fitted to it. Prints two tables and
draws the figure of the explanation page.

    python benchmarks/radiance_and_lag.py --figure docs/explanation/radiance-straight-line.svg
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.integrate import cumulative_simpson, solve_ivp
from scipy.optimize import least_squares

from irtiming.physics.radiance import StraightLine, in_band_radiance, radiance_slope, slope_ratio, straight_line

PAPER_K, WIDE_K = (288.0, 298.0), (273.0, 323.0)
TIME_CONSTANT_S = 4.819e-3
QUARTER_S, RAMP_S = 1 / 12, 75 / 360 / 3  # a cutout, and the opening's 75 degrees, of a wheel at 3 Hz
STEP_S = 1e-5
SAMPLES_S = np.arange(500) / 3000


@dataclass(frozen=True)
class Case:
    cold_k: float
    hot_k: float
    share: float
    shows: str = "pixel"

    def __str__(self) -> str:
        values = "pixel's temperature" if self.shows == "pixel" else "scene's temperature"
        return f"{self.cold_k:g} to {self.hot_k:g} K | {self.share:g} | {values}"


CASES = (
    *(Case(*ends, share) for ends in (PAPER_K, WIDE_K) for share in (1.0, 0.1, 0.01)),
    *(Case(*ends, 0.0, "scene") for ends in (PAPER_K, WIDE_K)),
)


def step_response(case: Case, *, warming: bool) -> np.ndarray:
    """What a pixel that is settled shows after the scene has changed, 0 to 1, every STEP_S for a quarter of a turn."""
    time = np.arange(round(QUARTER_S / STEP_S) + 1) * STEP_S
    if case.share == 0:  # linear in what it receives; the camera then turns that into the scene's temperature
        left = np.exp(-time / TIME_CONSTANT_S)
        cold, hot = in_band_radiance([case.cold_k, case.hot_k])
        grid = np.linspace(case.cold_k, case.hot_k, 4001)
        shown = np.interp(
            hot - (hot - cold) * left if warming else cold + (hot - cold) * left, in_band_radiance(grid), grid
        )
    else:
        shown = _stepped(case, time, warming=warming)
    settled = case.hot_k if warming else case.cold_k
    start = shown[0]
    if case.share > 0:
        settled = _settled(case, settled)
    return (shown - start) / (settled - start)


def _rate(pixel_k: float, scene_k: float, case: Case) -> float:
    """K/s; the time constant belongs to the middle of the range, and so does the substrate."""
    middle = (case.cold_k + case.hot_k) / 2
    scene, pixel = in_band_radiance([scene_k, pixel_k])
    drawn = float((scene - pixel) / radiance_slope(middle))
    return (case.share * drawn + (1 - case.share) * (middle - pixel_k)) / TIME_CONSTANT_S


def _settled(case: Case, scene_k: float) -> float:
    """Temperature at which a pixel that sees one scene for ever stays."""
    ends = case.cold_k, case.hot_k
    pixel = sum(ends) / 2
    for _ in range(200):
        pixel += _rate(pixel, scene_k, case) * TIME_CONSTANT_S / 1.5
    return pixel


def _stepped(case: Case, time: np.ndarray, *, warming: bool) -> np.ndarray:
    before, after = (case.cold_k, case.hot_k) if warming else (case.hot_k, case.cold_k)
    start = _settled(case, before)
    solved = solve_ivp(
        lambda _, pixel: [_rate(pixel[0], after, case)], (0, time[-1]), [start], "DOP853", time, rtol=1e-11, atol=1e-11
    )
    return solved.y[0]


def mean_lag_s(response: np.ndarray) -> float:
    """Area between a step and what follows it: by how much a long ramp is late. The time constant, if linear."""
    return float(cumulative_simpson(1 - response, dx=STEP_S)[-1])


def half_turn(warm: np.ndarray, cool: np.ndarray) -> np.ndarray:
    """Mean over the opening while a hot background is uncovered from time 0, and covered again a quarter later."""
    return _ramp(warm, SAMPLES_S) - _ramp(cool, SAMPLES_S - QUARTER_S)


def _ramp(response: np.ndarray, time: np.ndarray) -> np.ndarray:
    area = np.append(0.0, cumulative_simpson(response, dx=STEP_S))
    known = np.arange(area.size) * STEP_S

    def up_to(moment: np.ndarray) -> np.ndarray:
        return np.interp(moment, known, area, left=0) + np.maximum(moment - known[-1], 0)

    return (up_to(time) - up_to(time - RAMP_S)) / RAMP_S


def linear_half_turn(time_constant: float, delays: tuple[float, float]) -> np.ndarray:
    """The same by the linear lag, in closed form, and late by one delay for warming and one for cooling."""

    def up_to(moment: np.ndarray) -> np.ndarray:
        moment = np.maximum(moment, 0)
        return moment - time_constant * -np.expm1(-moment / time_constant)

    first, second = SAMPLES_S - delays[0], SAMPLES_S - QUARTER_S - delays[1]
    return (up_to(first) - up_to(first - RAMP_S) - up_to(second) + up_to(second - RAMP_S)) / RAMP_S


def fitted(curve: np.ndarray, *, one_delay: bool) -> tuple[float, float, float]:
    """Time constant, delay of warming and of cooling, s; level and contrast are free."""

    def residual(unknown: np.ndarray) -> np.ndarray:
        level, contrast, tau, *delays = unknown
        return level + contrast * linear_half_turn(1e-3 * tau, (1e-3 * delays[0], 1e-3 * delays[-1])) - curve

    start = [0.0, 1.0, 4.0, 0.0] if one_delay else [0.0, 1.0, 4.0, 0.0, 0.0]
    found = least_squares(residual, start, x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14)
    _, _, tau, *delays = 1e-3 * found.x
    return float(tau), float(delays[0]), float(delays[-1])


def print_lines() -> None:
    print("| range | radiance at its ends | slope at its ends, ratio | RMS from the line | RMS / range |")
    print("| --- | --- | ---: | ---: | ---: |")
    for cold, hot in (PAPER_K, (283.0, 303.0), WIDE_K):
        low, high = in_band_radiance([cold, hot])
        rms = straight_line(cold, hot).rms_w_per_m2_sr
        ratio = slope_ratio(hot, cold)
        print(
            f"| {cold:g} to {hot:g} K | {low:.1f} to {high:.1f} | {ratio:.3f} | {rms:.3f} | {100 * rms / (high - low):.2f} % |"
        )


def print_lags() -> None:
    print("| range | share s | values show | lag warming | lag cooling | tau | delay | delay warming - cooling |")
    print("| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: |")
    for case in CASES:
        warm, cool = (step_response(case, warming=warming) for warming in (True, False))
        curve = half_turn(warm, cool)
        tau, delay, _ = fitted(curve, one_delay=True)
        _, first, second = fitted(curve, one_delay=False)
        lags = " | ".join(f"{100 * (mean_lag_s(r) / TIME_CONSTANT_S - 1):+.3f} %" for r in (warm, cool))
        change = f"{100 * (tau / TIME_CONSTANT_S - 1):+.3f} %"
        print(f"| {case} | {lags} | {change} | {1e6 * delay:+.2f} us | {1e6 * (first - second):+.2f} us |", flush=True)


def draw(path: Path) -> None:
    rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "irtiming"})
    figure = Figure(figsize=(9.6, 5.6), layout="constrained")
    axes = figure.subplots(2, 2, sharex="col", height_ratios=(2, 1))
    paper, wide = straight_line(*PAPER_K), straight_line(*WIDE_K)
    _column(axes[:, 0], PAPER_K, {"line for 288 to 298 K": ("C1", paper)})
    _column(axes[:, 1], WIDE_K, {"line for 288 to 298 K": ("C1", paper), "line for 273 to 323 K": ("C2", wide)})
    axes[0, 1].axvspan(*PAPER_K, color="C1", alpha=0.12, linewidth=0)
    axes[1, 1].axvspan(*PAPER_K, color="C1", alpha=0.12, linewidth=0)
    axes[0, 0].set_title("As measured in the paper: 10 K", fontsize=10)
    axes[0, 1].set_title("Section 4: 50 K", fontsize=10)
    axes[0, 0].set_ylabel("radiance, 7.5 to 14 µm\n/ (W m$^{-2}$ sr$^{-1}$)")
    axes[1, 0].set_ylabel("radiance − line\n/ (W m$^{-2}$ sr$^{-1}$)")
    figure.align_ylabels(axes[:, 0])
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Date": None})


def _column(axes: np.ndarray, ends: tuple[float, float], lines: dict[str, tuple[str, StraightLine]]) -> None:
    above, below = axes
    temperature = np.linspace(*ends, 201)
    radiance = in_band_radiance(temperature)
    above.plot(temperature, radiance, color="C0", linewidth=2.2, label="Planck's law")
    for label, (colour, line) in lines.items():
        straight = line.intercept_w_per_m2_sr + line.slope_w_per_m2_sr_k * temperature
        above.plot(temperature, straight, "--", color=colour, label=label)
        below.plot(temperature, radiance - straight, color=colour)
    _finish(above, below)


def _finish(above: Axes, below: Axes) -> None:
    above.legend(fontsize=8, loc="upper left")
    below.axhline(0, color="0.6", linewidth=0.8)
    below.set_xlabel("temperature / K")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--figure", type=Path)
    given = options.parse_args()
    print_lines()
    print()
    print_lags()
    if given.figure is not None:
        draw(given.figure)


if __name__ == "__main__":
    main()
