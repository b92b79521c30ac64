"""Maps of every pixel against the twin's truth: pulls with and without blur, row delay against the fit's, taps that are found.

Each rig has its own imperfections, 40 dead pixels and 20 lost frames of 1000, and is recorded by a rolling microbolometer camera,
or by a rolling photon camera with --camera photon. A pull is (map less truth less what all pixels have in common) over the
uncertainty by noise and shape. "Without blur" is one of 0.35 px, which is sharper than the pixels are wide.

    .venv/bin/python benchmarks/accuracy/pixel_maps.py --rigs 8
"""

import argparse
from dataclasses import replace

import numpy as np

from irtiming.measurement import analyse
from irtiming.records.pixel_maps import PixelMaps
from irtiming.twin import rig as twin
from irtiming.twin.cameras import camera_scene
from irtiming.twin.scene import BolometerTiming, CameraTiming, Faults, Scene
from irtiming.twin.taps import Taps

BLURS_PX = {"sharp (0.35 px)": 0.35, "blurred (0.7 px)": 0.7, "wide (1.0 px)": 1.0}
TAPS = {
    "none": Taps(),
    "odd columns 20 us later": Taps(odd_columns_later_s=20e-6),
    "right half 20 us later": Taps(right_half_later_s=20e-6),
    "middle rows 200 us later": Taps(middle_rows_later_s=200e-6),
}


def nominal(camera: str, rows: int, *, blur_px: float, taps: Taps) -> Scene:
    scene = camera_scene(
        "photon" if camera == "photon" else "microbolometer", "rolling", rows=rows, columns=rows * 4 // 3
    )
    return replace(
        scene,
        optics=replace(scene.optics, pixel_pitch_m=1.1 * scene.optics.pixel_pitch_m, blur_px=blur_px),
        detector=replace(scene.detector, dead_pixels=40),
        faults=Faults(lost_frames=20),
        taps=taps,
    )


def spread(off: np.ndarray, u: np.ndarray) -> float:
    """Spread of the pulls about what all pixels have in common."""
    common = np.average(off, weights=1 / u**2)
    return float(np.std((off - common) / u))


def pulls(maps: PixelMaps, timing: BolometerTiming | CameraTiming) -> dict[str, float]:
    rows = np.arange(*maps.roi[:2])[:, None]
    off = maps.delay_s - rows * (timing.row_delay_s or 0.0)
    u = np.hypot(maps.u_delay_s, maps.u_shape_s)
    seen = np.isfinite(off) & ~maps.is_deviating
    found = {}
    for name, these in (("inside", seen & ~maps.is_border), ("border", seen & maps.is_border)):
        found[f"delay, {name}"] = spread(off[these], u[these])
        if maps.time_constant_s is not None and maps.u_time_constant_s is not None:
            found[f"tau, {name}"] = spread(maps.time_constant_s[these], maps.u_time_constant_s[these])
    return found


def one(camera: str, rows: int, seed: int, *, blur_px: float, taps: Taps) -> tuple[PixelMaps, dict[str, float]]:
    drawn = twin.draw(nominal(camera, rows, blur_px=blur_px, taps=taps), seed=seed)
    analysis = analyse([twin.simulate(drawn.scene, seed=seed)], drawn.measured, extras=("maps",))
    maps, true, fit = analysis.maps, drawn.scene.timing.row_delay_s or 0.0, analysis.best.estimate
    assert maps is not None
    rows_told = {
        "row delay, map less fit over u of both": (maps.row_delay_s - fit.value("row_delay"))
        / np.hypot(maps.u_row_delay_s, fit.u("row_delay")),
        "row delay, map less truth over u": (maps.row_delay_s - true) / maps.u_row_delay_s,
        "row delay, fit less truth over u": (fit.value("row_delay") - true) / fit.u("row_delay"),
        "row delay, error of the map / ns": 1e9 * (maps.row_delay_s - true),
        "row delay, error of the fit / ns": 1e9 * (fit.value("row_delay") - true),
        "reduced chi square": maps.reduced_chi_square,
    }
    return maps, pulls(maps, drawn.scene.timing) | rows_told


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=4)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--rows", type=int, default=120)
    parser.add_argument("--camera", choices=("microbolometer", "photon"), default="microbolometer")
    parser.add_argument("--only", choices=("pulls", "taps"), default=None)
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.rigs)
    for name, blur_px in BLURS_PX.items() if options.only != "taps" else ():
        told = [one(options.camera, options.rows, seed, blur_px=blur_px, taps=Taps()) for seed in seeds]
        print(f"{name}: {len(told)} rigs, {np.mean([maps.n_pixels for maps, _ in told]):.0f} pixels each")
        for key in told[0][1]:
            values = np.array([found[key] for _, found in told])
            print(f"  {key:<42} mean {values.mean():+8.3f}  rms {np.sqrt(np.mean(values**2)):8.3f}")
        false = [finding.code for maps, _ in told for finding in maps.findings if finding.severity != "info"]
        print(f"  findings that there should not be: {', '.join(false) or 'none'}")
    for name, taps in TAPS.items() if options.only != "pulls" else ():
        print(f"taps: {name}")
        for seed in seeds:
            maps, _ = one(options.camera, options.rows, seed, blur_px=0.7, taps=taps)
            parts = ", ".join(f"{p.name} {1e6 * p.later_s:+.2f} ({1e6 * p.u_later_s:.2f})" for p in maps.patterns)
            told_codes = ", ".join(finding.code for finding in maps.findings if finding.severity != "info")
            print(f"  rig {seed}: {told_codes or 'no finding'}; us: {parts}")


if __name__ == "__main__":
    main()
