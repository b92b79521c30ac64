"""Recordings whose program is killed (kill -9) at random moments: what is left of them.

A second process records run after run, without a pause, and says each frame when `append_frame` has returned. It is killed at a
random moment: while it makes a file, between frames, while it finishes one. Then every run that it said to be finished must be a
sound file, and the last one must open, with every frame that was said but at most the last: pixel by pixel, with its trigger.

    python benchmarks/killed_recordings.py --kills 100
"""

import argparse
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from irtiming.archive import reader
from irtiming.archive.finding import Complaint
from irtiming.archive.hdf5_file import opened
from irtiming.archive.live.head import RecordingHead
from irtiming.archive.live.recording import LiveRecording
from irtiming.archive.live.recovery import recover
from irtiming.archive.live.unfinished import frames_there, part_of
from irtiming.errors import ArchiveError
from irtiming.records.camera_frame import CameraFrame, CameraIdentity, CameraSetup
from irtiming.records.trigger_plan import PlannedRun, TriggerScheme

ROWS, COLUMNS, FRAMES_PER_RUN = 120, 160, 150
CLOCK_HZ, TURN_TICKS, CAMERA_TICKS, FIRST_TICKS = 49_152_000, 16_384_000, 1_622_016, 20_000_000
LONGEST_S = 1.0


def head(rows: int = ROWS, columns: int = COLUMNS) -> RecordingHead:
    return RecordingHead(
        name="run",
        camera_type="microbolometer",
        readout_mode="rolling",
        clock_frequency_hz=CLOCK_HZ,
        run=PlannedRun(
            scheme=TriggerScheme(turn_period_ticks=TURN_TICKS, camera_period_ticks=CAMERA_TICKS),
            trigger_delay_ticks=0,
            repeats=1,
            is_after_correction=False,
        ),
        camera=CameraIdentity(vendor="nobody", model="none", serial_number="0", firmware="0", address="none"),
        setup=CameraSetup(
            rows=rows, columns=columns, pixel_format="Mono16", bit_depth=16, trigger_source="Line0",
            trigger_activation="RisingEdge",
        ),
    )  # fmt: skip


def pixels_of(index: int) -> np.ndarray:
    return np.random.default_rng(index).integers(4000, 4064, (ROWS, COLUMNS), dtype=np.uint16)


def trigger_ticks(index: int) -> int:
    return FIRST_TICKS + index * CAMERA_TICKS


def record_for_ever(folder: Path) -> None:
    """Runs of frames with their timestamps, a trigger before its frame; on standard output, what is in the file."""
    print("ready", flush=True)
    run = 0
    while True:
        with LiveRecording(folder / f"{run}.nxs", head=head()) as live:
            for index in range(FRAMES_PER_RUN):
                slots = np.arange(index * CAMERA_TICKS // 163_840, (index + 1) * CAMERA_TICKS // 163_840)
                live.append_ticks("camera_trigger", np.array([trigger_ticks(index)]))
                live.append_ticks("control_slot", FIRST_TICKS + 163_840 * slots)
                live.append_ticks("application_slot", FIRST_TICKS + 8_192_000 * (slots[slots % 50 == 0] // 50))
                frame = CameraFrame(
                    pixels=pixels_of(index), frame_id=index, device_timestamp_ticks=0, host_time_s=float(index)
                )
                live.append_frame(frame, frame_number=index)
                print(f"frame {run} {index}", flush=True)
            live.finish()
        print(f"done {run} 0", flush=True)
        run += 1


@dataclass
class Left:
    """What a killed program left: runs it had finished, and the last one."""

    finished: int
    state: str
    reported: int
    there: int
    is_sound: bool


def kill_once(folder: Path, seed: int) -> Left:
    """Record in another process, kill it at a random moment, and look at what is left."""
    child = subprocess.Popen([sys.executable, __file__, "--record", str(folder)], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    child.stdout.readline()
    time.sleep(np.random.default_rng(seed).uniform(0, LONGEST_S))
    child.kill()
    with child.stdout as told:
        lines = [line.split() for line in told.read().split("\n")[:-1]]  # the last one may be cut
    child.wait()
    finished = [int(run) for word, run, _ in lines if word == "done"]
    sound = all(is_as_recorded(folder / f"{run}.nxs", FRAMES_PER_RUN) for run in finished)
    last = len(finished)
    reported = sum(word == "frame" and int(run) == last for word, run, _ in lines)
    return look_at(folder / f"{last}.nxs", finished=len(finished), reported=reported, is_sound=sound)


def look_at(path: Path, *, finished: int, reported: int, is_sound: bool) -> Left:
    part = part_of(path)
    if path.exists():
        return Left(finished, "renamed", reported, FRAMES_PER_RUN, is_sound and is_as_recorded(path, FRAMES_PER_RUN))
    if not part.exists():
        return Left(finished, "not begun", reported, 0, is_sound)
    try:
        with opened(part, is_growing=True) as file:
            there = frames_there(file)
    except Complaint as complaint:
        return Left(finished, f"NOT OPENED: {complaint}", reported, 0, False)
    if there < 8:  # less than half a turn of the wheel: too little for a recording
        return Left(finished, "begun", reported, there, is_sound)
    try:
        recover(part, trust=True)
    except ArchiveError as error:
        return Left(finished, f"NOT RECOVERED: {error}", reported, there, False)
    return Left(finished, "recovered", reported, there, is_sound and is_as_recorded(path, there))


def is_as_recorded(path: Path, n_frames: int) -> bool:
    """Every frame, its number and its trigger as they were made."""
    recording = reader.read(path)
    if recording.frame_number.tolist() != list(range(n_frames)):
        return False
    if recording.camera_trigger_ticks[:n_frames].tolist() != [trigger_ticks(index) for index in range(n_frames)]:
        return False
    frames = recording.frames.pick(list(range(n_frames)))
    return all(np.array_equal(frame, pixels_of(index)) for index, frame in enumerate(frames))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--record", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.record is not None:
        record_for_ever(options.record)
    found: list[Left] = []
    print(f"{'kill':>4} {'finished':>8} {'reported':>8} {'there':>6} {'missing':>7}  the last file")
    for kill in range(options.kills):
        with tempfile.TemporaryDirectory() as folder:
            left = kill_once(Path(folder), options.seed + kill)
        found.append(left)
        missing = max(0, left.reported - left.there)
        verdict = left.state if left.is_sound else f"{left.state}, NOT SOUND"
        print(f"{kill:4} {left.finished:8} {left.reported:8} {left.there:6} {missing:7}  {verdict}")
    worst = max(max(0, left.reported - left.there) for left in found)
    states = {state: sum(left.state == state for left in found) for state in sorted({left.state for left in found})}
    print(f"{sum(left.is_sound for left in found)} of {len(found)} sound; most frames missing: {worst}; {states}")
    sys.exit(0 if worst <= 1 and all(left.is_sound for left in found) else 1)


if __name__ == "__main__":
    main()
