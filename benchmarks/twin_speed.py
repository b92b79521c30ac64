"""How many frames a second the simulated rig makes, and how much faster that is than counting every ray of every frame.

Frames of 640 x 480 pixels, with pattern and noise, of a cooled camera and of a rolling microbolometer. The reference follows the
rays of the cooled camera's pixels through lens, mask and wheel in NumPy, each anew at each instant of the window, without tables
and without knowing which pixels see no edge: some pixels are taken, the time of a frame is that of all. As many rays are counted
as leave an rms error of 1e-4 of full scale. How far the simulated frame is from the truth is told by 32 768 rays, which are right
to 2e-5 of full scale, of many pixels: those that an edge passes are few, and the farthest off.

    .venv/bin/python benchmarks/twin_speed.py
"""

import argparse
import math
import time

import numpy as np
from scipy.stats import norm, qmc

from irtiming.records.arrays import Array
from irtiming.twin import rig as twin
from irtiming.twin.pixels import expose, picture
from irtiming.twin.scene import Scene, microbolometer_scene, paper_scene, with_wheel_speed

_INSTANTS = 8
_AT_ONCE = 100  # pixels
_FINEST = 15  # binary logarithm of the number of rays that tell the truth


def rays(scene: Scene, exponent: int) -> Array:
    """Places about a pixel's centre from which its light comes, px, shape (2^exponent, 2): its square and the blur's Gaussian."""
    even = qmc.Sobol(4, seed=1).random_base2(exponent)
    blur = np.array(scene.optics.blur_rows_columns_px)
    return np.asarray(even[:, :2] - 0.5 + blur * norm.ppf(even[:, 2:]))


def open_share(scene: Scene, row: Array, column: Array, *, theta_rad: Array, places: Array) -> Array:
    """Share of the rays of pixels, shapes (n,), that pass wheel and mask, and of those that end at its plate, shape (2, n)."""
    optics, detector, mask, wheel = scene.optics, scene.detector, scene.mask, scene.wheel
    middle = np.array([detector.rows - 1, detector.columns - 1]) / 2
    middle += [optics.lens_centre_row_px, optics.lens_centre_column_px]
    half = math.hypot(detector.rows, detector.columns) / 2

    def flat(place: Array) -> Array:
        """Without the lens's distortion, from its centre, px."""
        off = place - middle
        seen = np.hypot(off[..., 0], off[..., 1]) / half
        radius = seen.copy()
        for _ in range(40):
            radius = seen / (1 + optics.distortion * radius**2)
        return np.asarray(off * (radius / np.where(seen > 0, seen, 1.0))[..., None])

    seen = np.stack([row[:, None] + places[:, 0], column[:, None] + places[:, 1]], axis=-1)
    axle = flat(np.array([[optics.wheel_centre_row_px, optics.wheel_centre_column_px]]))
    down, right = np.moveaxis((flat(seen) - axle) * optics.pixel_pitch_m, -1, 0)
    cosine, sine = math.cos(optics.roll_rad), math.sin(optics.roll_rad)
    x, y = right * cosine + down * sine, down * cosine - right * sine
    away = np.hypot(x - mask.centre_x_m, y - mask.centre_y_m)
    right, up = math.cos(mask.centre_angle_rad), math.sin(mask.centre_angle_rad)
    along = (x - mask.centre_x_m) * right + (y - mask.centre_y_m) * up
    is_opening = (away >= mask.inner_radius_m) & (away <= mask.outer_radius_m)
    is_opening &= along >= away * math.cos(mask.opening_angle_rad / 2)
    radius = np.hypot(x, y)
    in_ring = (radius >= wheel.inner_radius_m) & (radius <= wheel.outer_radius_m)
    phi = np.arctan2(y, x if wheel.rotation == "clockwise" else -x)
    a0, a1, a2, a3 = wheel.cutout_edges_rad
    share = np.zeros((2, row.size))
    for theta in theta_rad:
        at = np.mod(math.pi / 2 + scene.beams.beta_1_rad + theta - phi, 2 * math.pi)
        is_open = in_ring & (((at >= a1) & (at < a2)) | (at >= a3) | (at < a0))
        share += [np.mean(is_open & is_opening, axis=1), np.mean(is_open & ~is_opening, axis=1)]
    return share / theta_rad.size


def counted(scene: Scene, pixels: Array, *, theta_rad: Array, places: Array) -> Array:
    """Signal of some pixels, given by their place in the flat image, DN, shape (n,); a part of them at a time."""
    parts = np.array_split(pixels, math.ceil(pixels.size / _AT_ONCE))
    return np.concatenate([_counted(scene, part, theta_rad=theta_rad, places=places) for part in parts])


def _counted(scene: Scene, pixels: Array, *, theta_rad: Array, places: Array) -> Array:
    shot, radiance = picture(scene), scene.radiance
    row, column = np.divmod(pixels, scene.detector.columns)
    share = open_share(scene, row, column, theta_rad=theta_rad, places=places)
    closed = shot.closed_dn.ravel()[pixels].astype(float)
    behind = [radiance.level_dn(radiance.blackbody_k), radiance.level_dn(radiance.mask_k)]
    return closed + sum(part * (level - closed) for part, level in zip(share, behind, strict=True))


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def frames_per_s(scene: Scene, *, rounds: int) -> float:
    """Of a run of the scene, by the clock, as fast as the best of several goes."""
    best = 0.0
    for seed in range(rounds):
        run = twin.simulate(scene, seed=seed)
        begin = time.perf_counter()
        n_frames = sum(len(block) for _, block in run.frames.blocks())
        best = max(best, n_frames / (time.perf_counter() - begin))
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=480)
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--pixels", type=int, default=1500, help="of which the reference follows the rays")
    options = parser.parse_args()
    shape = options.rows, options.rows * 4 // 3
    cooled, lagging = (
        twin.draw(with_wheel_speed(scene(*shape), 3.0, samples=options.frames), seed=1).scene
        for scene in (paper_scene, microbolometer_scene)
    )
    speed = frames_per_s(cooled, rounds=options.rounds)
    print(f"cooled camera      {speed:.0f} frames/s")
    print(f"microbolometer     {frames_per_s(lagging, rounds=options.rounds):.0f} frames/s")

    shot, rng = picture(cooled), np.random.default_rng(1)
    full_scale = 2.0**cooled.detector.bits - 1
    frame = np.empty_like(shot.closed_dn)
    theta = 1.0 + cooled.timing.integration_time_s * 6 * math.pi * np.linspace(0, 1, _INSTANTS)
    expose(shot, theta, out=frame)
    among = shot.table.pixel[(frame - shot.closed_dn).ravel()[shot.table.pixel] > 1]
    pixels = np.sort(rng.choice(among, min(options.pixels, among.size), replace=False))
    truth = counted(cooled, pixels, theta_rad=theta, places=rays(cooled, _FINEST))
    off = (frame.ravel()[pixels] - truth) / full_scale
    print(
        f"simulated frame    off by {rms(off) * 1e4:.2f}e-04 of full scale (rms of {pixels.size} pixels in the light), "
        f"{np.abs(off).max() * 1e4:.0f}e-04 at most"
    )
    for exponent in range(6, _FINEST):
        begin = time.perf_counter()
        found = counted(cooled, pixels, theta_rad=theta, places=rays(cooled, exponent))
        frame_s = (time.perf_counter() - begin) * frame.size / pixels.size
        if rms(found - truth) < 1e-4 * full_scale:
            break
    print(f"rays one by one    {frame_s:.3g} s a frame with {2**exponent} rays for each pixel")
    print(f"the simulated rig is {frame_s * speed:.0f} times faster")


if __name__ == "__main__":
    main()
