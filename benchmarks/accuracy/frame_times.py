"""Times of frames and rows by ``irtiming apply time`` against the truth, over random simulated laboratories of the four kinds.

Each laboratory is measured, its result applied to the triggers of its own recording, and the moments of the first, the middle
and the last row compared with the camera's true ones. The result goes through its file's model on the way.

    .venv/bin/python benchmarks/accuracy/frame_times.py --rigs 25 [--rows 60 --columns 80 --frames 300 --first 1]
"""

import argparse

import numpy as np

from irtiming.apply import camera_timing, frame_times, stamps
from irtiming.archive.json_file import plain
from irtiming.archive.result_model import FORMAT, VERSION, Result
from irtiming.errors import IrTimingError
from irtiming.measurement import analyse
from irtiming.report import certificate
from irtiming.session.apply_time import generator_of
from irtiming.twin import rig as rigs
from irtiming.twin.random_laboratory import Wanted, draw, recordings

KINDS = (("photon", "snapshot"), ("photon", "rolling"), ("microbolometer", "snapshot"), ("microbolometer", "rolling"))


def true_offsets(truth, rows_px, period_s):
    """Moments after the edge at the camera's connector, s, by name."""
    row = truth.get("row_delay_s", 0.0) * rows_px
    begin = truth["trigger_delay_s"] + row
    share = truth["filter_share"] / (1 - truth["filter_share"])
    if truth["camera"] == "microbolometer":
        return {"reading": begin, "effective": begin - truth["time_constant_s"] - share * period_s}
    middle = truth["exposure_midpoint_delay_s"] + row
    return {"middle": middle}


def of_rig(kind, given, seed):
    """Pulls of one laboratory, by moment; the median u in s."""
    wanted = Wanted(camera=kind[0], readout=kind[1], rows=given.rows, columns=given.columns, frames=given.frames)
    rig = draw(wanted, seed=seed)
    made = list(recordings(rig, wanted, seed=seed))
    told = certificate.result.result(analyse(made, rig.measured))
    result = Result.model_validate({"format": FORMAT, "version": VERSION, **plain(told)})
    camera = camera_timing.of_result(result)
    truth = rigs.truth(rig.scene)
    recording = made[0]
    ticks = recording.camera_trigger_ticks[recording.frame_number]
    triggers = stamps.from_ticks(
        ticks, clock_frequency_hz=recording.clock_frequency_hz, set_delay_s=recording.trigger_delay_time_set_s,
        generator=generator_of(result),
    )  # fmt: skip
    rows = np.array([0.0, (given.rows - 1) / 2, given.rows - 1.0]) if kind[1] == "rolling" else None
    times = frame_times.apply(camera, triggers, rows_px=rows)
    edge_s = ticks / recording.clock_frequency_hz + recording.trigger_delay_time_set_s + truth["late_trigger_s"]
    found = {}
    for name, after in true_offsets(truth, times.rows_px, triggers.frame_period_s).items():
        error = times.time_s(name) - edge_s[:, None] - after * (1 + truth["clock_relative_error"])
        found[name] = error.mean(axis=0), times.u_s(name)
    return found


def main():
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    for name, value in (("rigs", 25), ("rows", 60), ("columns", 80), ("frames", 300), ("first", 1)):
        parser.add_argument(f"--{name}", type=int, default=value)
    given = parser.parse_args()
    print("| camera | moment | rigs | rms error, us | rms u, us | rms pull | within 2 u |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: |", flush=True)
    for kind in KINDS:
        every, refused = {}, 0
        for seed in range(given.first, given.first + given.rigs):
            try:
                for name, both in of_rig(kind, given, seed).items():
                    every.setdefault(name, []).append(both)
            except (IrTimingError, ValueError) as error:
                refused += 1
                print(f"    seed {seed}: {error}"[:150], flush=True)
        for name, pairs in every.items():
            error, u = np.array(pairs)[:, 0].ravel(), np.array(pairs)[:, 1].ravel()
            pull = error / u
            print(
                f"| {' '.join(kind)} | {name} | {len(pairs)} | {1e6 * np.sqrt(np.mean(error**2)):.2f} | "
                f"{1e6 * np.sqrt(np.mean(u**2)):.2f} | {np.sqrt(np.mean(pull**2)):.2f} | {np.mean(np.abs(pull) < 2):.0%} |",
                flush=True,
            )
        print(f"    {refused} refused", flush=True)


if __name__ == "__main__":
    main()
