"""A camera and an IMU turned together: the offset of `irtiming apply export --to kalibr` against an independent estimate.

Each camera is measured in a simulated laboratory, and its result read as a program reads it. Then the same camera, as it truly
is, is turned before a texture with an IMU beside it: frames with rolling rows and lag or integration, noise in both. The
estimator knows nothing of the measurement: it registers each frame on the one before, and looks for the shift in time at which
the angles that the gyroscope went through between frames correlate best with these displacements. Its uncertainty is that of a
jackknife over blocks.

    .venv/bin/python benchmarks/accuracy/camera_imu.py --rigs 6
"""

import argparse
import math
from itertools import pairwise

import numpy as np
import yaml

from irtiming.apply import camera_timing, export, handover
from irtiming.archive.json_file import plain
from irtiming.archive.result_model import FORMAT, VERSION, Result
from irtiming.measurement import analyse
from irtiming.report import certificate
from irtiming.twin import rig as twin
from irtiming.twin.cameras import camera_scene
from irtiming.twin.rig import Tolerances
from irtiming.twin.scene import with_wheel_speed

KINDS = (("photon", "snapshot"), ("photon", "rolling"), ("microbolometer", "snapshot"), ("microbolometer", "rolling"))
KNOWN = Tolerances(u_beam_m=2e-6, u_mask_angle_rad=math.radians(0.002))
ROWS, COLUMNS, FRAMES = 60, 80, 300
PIXELS_PER_RAD, PERIOD_S, TURNED_FRAMES, GYRO_HZ = 600.0, 1 / 30, 1500, 1000.0
NODES, BLOCKS = 24, 20


def handed_over(kind, seed):
    """Shift in Kalibr's file and its u, s, of one measured camera; and the truth of that camera."""
    scene = with_wheel_speed(camera_scene(*kind, rows=ROWS, columns=COLUMNS), 3.0, samples=FRAMES)
    rig = twin.draw(scene, seed=seed, tolerances=KNOWN)
    told = certificate.result.result(analyse([twin.simulate(rig.scene, seed=seed)], rig.measured))
    result = Result.model_validate({"format": FORMAT, "version": VERSION, **plain(told)})
    given = handover.of_camera(camera_timing.of_result(result))
    chain = yaml.safe_load(export.text_for("kalibr", given))
    return chain["cam0"]["timeshift_cam_imu"], given.middle_row.u_s, twin.truth(rig.scene)


class Motion:
    """A random swing: angle in rad at any time, slow against the camera."""

    def __init__(self, rng, highest_hz=1.5):
        self.hz = rng.uniform(0.2, highest_hz, 12)
        self.phase, self.size = rng.uniform(0, 2 * np.pi, 12), rng.normal(0, 4e-3, 12) / self.hz

    def angle(self, time_s):
        """At these times, any shape."""
        turned = 2 * np.pi * self.hz * np.asarray(time_s)[..., None] + self.phase
        return np.sum(self.size * np.sin(turned), axis=-1)


def filmed(truth, motion, rng):
    """Frames of the texture, stamped at their triggers; each pixel's value is a mean over when it looked."""
    if truth["camera"] == "microbolometer":
        left = np.arange(NODES, -1, -1) / NODES  # of a past that fades: parts of equal weight, each at its own mean
        within = left - left * np.log(np.where(left > 0, left, 1.0))
        first_s, back_s = truth["trigger_delay_s"], -truth["time_constant_s"] * NODES * (within[:-1] - within[1:])
    else:
        first_s, back_s = truth["trigger_delay_s"], truth["integration_time_s"] * (np.arange(NODES) + 0.5) / NODES
    rows_s = truth.get("row_delay_s", 0.0) * np.arange(ROWS)
    texture = np.convolve(rng.normal(size=4096), np.hanning(17), mode="same")
    place, centre = np.arange(4096), 2048 + np.arange(COLUMNS) - COLUMNS / 2
    stamps_s = 1.0 + PERIOD_S * np.arange(TURNED_FRAMES)
    frames = np.empty((TURNED_FRAMES, ROWS, COLUMNS))
    for n, stamp_s in enumerate(stamps_s):
        moved = PIXELS_PER_RAD * motion.angle(stamp_s + first_s + rows_s[:, None] + back_s)
        seen = np.interp(centre + moved[:, :, None], place, texture)
        frames[n] = seen.mean(axis=1)
    return stamps_s, frames + rng.normal(0, 0.01 * texture.std(), frames.shape)


def displacements(frames):
    """Of each frame against the one before, px: least squares on the brightness, the earlier moved until nothing is left."""
    place, found = np.arange(COLUMNS, dtype=float), []
    inner = slice(10, COLUMNS - 10)
    for one, other in pairwise(frames):
        shift = 0.0
        for _ in range(8):
            moved = np.array([np.interp(place + shift, place, row) for row in one])
            slope = np.gradient(moved, axis=1)[:, inner]
            step = float(np.sum(slope * (other - moved)[:, inner]) / np.sum(slope**2))
            shift += step
            if abs(step) < 1e-5:
                break
        found.append(shift)
    return np.array(found)


def offset(stamps_s, moved, gyro_s, turned):
    """Shift of the camera's stamps at which the angles between frames correlate best, and its jackknifed u, s."""
    shifts = np.arange(-0.012, 0.0121, 5e-4)
    between = np.array([np.diff(np.interp(stamps_s + shift, gyro_s, turned)) for shift in shifts])

    def best(kept):
        likeness = np.array([np.corrcoef(one[kept], moved[kept])[0, 1] for one in between])
        k = int(np.clip(np.argmax(likeness), 3, shifts.size - 4))
        near = slice(k - 3, k + 4)
        bend, slope, _ = np.polyfit(shifts[near] - shifts[k], likeness[near], 2)
        return shifts[k] - slope / (2 * bend)

    block = np.arange(moved.size) * BLOCKS // moved.size
    left_out = np.array([best(block != one) for one in range(BLOCKS)])
    return best(block >= 0), float(np.sqrt((BLOCKS - 1) * np.mean((left_out - left_out.mean()) ** 2)))


def estimated(truth, seed):
    """Offset by the independent estimator and its u, s."""
    rng = np.random.default_rng(seed)
    motion = Motion(rng)
    stamps_s, frames = filmed(truth, motion, rng)
    gyro_s = np.arange(0.5, stamps_s[-1] + 1.0, 1 / GYRO_HZ)
    rate = np.gradient(motion.angle(gyro_s), gyro_s) + rng.normal(0, 2e-3, gyro_s.size)
    turned = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2 / GYRO_HZ)])
    return offset(stamps_s, displacements(frames), gyro_s, turned)


def true_shift(truth):
    """Effective moment of the middle of the image after the stamp, s."""
    middle = (ROWS - 1) / 2 * truth.get("row_delay_s", 0.0)
    if truth["camera"] == "microbolometer":
        return truth["trigger_delay_s"] - truth["time_constant_s"] + middle
    return truth["trigger_delay_s"] + truth["integration_time_s"] / 2 + middle


def main():
    """Print a line per camera, and a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rigs", type=int, default=6)
    parser.add_argument("--first", type=int, default=1)
    given = parser.parse_args()
    lines = []
    for kind in KINDS:
        pulls = []
        for seed in range(given.first, given.first + given.rigs):
            ours, u_ours, truth = handed_over(kind, seed)
            theirs, u_theirs = estimated(truth, seed)
            pulls.append(((ours - theirs) / np.hypot(u_ours, u_theirs), u_ours, u_theirs))
            print(
                f"{' '.join(kind):24s} seed {seed}: handed over {1e6 * ours:+9.1f} ({1e6 * u_ours:.1f}) us, estimated "
                f"{1e6 * theirs:+9.1f} ({1e6 * u_theirs:.1f}) us, true {1e6 * true_shift(truth):+9.1f} us, {pulls[-1][0]:+.2f} u",
                flush=True,
            )
        pull, u_ours, u_theirs = np.array(pulls).T
        lines.append(
            f"| {' '.join(kind)} | {pull.size} | {1e6 * np.median(u_ours):.1f} | {1e6 * np.median(u_theirs):.1f} | "
            f"{np.sqrt(np.mean(pull**2)):.2f} | {np.abs(pull).max():.2f} |"
        )
    print("| camera | cameras | u handed over, us | u of the estimate, us | rms pull | largest |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
