"""`irtiming record` killed (kill -9) at random moments while it records the simulated rig: what is left, and does it go on.

The whole program is killed: while it connects, makes a file, takes frames, finishes one run or begins the next. Every file that
is left must open with every frame that the program had said to be written but at most the last; `irtiming verify` must say what
is there; and the same command, said again, must recover what is there and complete the series. Timestamps come a moment after
their frames: frames whose trigger has none yet are in the file, but are left out of what is recovered.

    python benchmarks/killed_series.py --kills 100
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import Queue

import numpy as np

from irtiming.archive import reader
from irtiming.archive.finding import Complaint
from irtiming.archive.hdf5_file import opened
from irtiming.archive.live.recovery import recover
from irtiming.archive.live.unfinished import frames_there
from irtiming.errors import ArchiveError

ROWS, COLUMNS, SPEED, N_RUNS, N_FRAMES = 48, 64, 4.0, 2, 120
RUN = {
    "turn_period_ticks": 4_800_000, "camera_period_ticks": 920_000, "control_slots": 100, "trigger_delay_ticks": 0,
    "repeats": 1, "is_after_correction": False,
}  # fmt: skip
FEWEST_FRAMES, PATIENCE_S, TRIES = 8, 90.0, 3
PROGRAM = str(Path(sys.executable).with_name("irtiming"))


def record(words: list[str]) -> None:
    """`irtiming record`, which also says on standard output what it has begun and written."""
    from irtiming.cli.main import run
    from irtiming.cli.person import Person

    begins, written = Person.begins, Person.written

    def told_begins(self, run, *, number, path) -> None:
        begins(self, run, number=number, path=path)
        os.write(1, f"begin {path.name}\n".encode())

    def told_written(self, frame, *, number) -> None:
        written(self, frame, number=number)
        os.write(1, f"frame {number}\n".encode())

    Person.begins, Person.written = told_begins, told_written
    sys.argv = ["irtiming", "record", *words]
    run()


@dataclass
class Left:
    """What was left of a killed program, and what became of it."""

    when: str
    reported: int
    there: int
    verified: str
    problems: list[str]
    untimed: int = 0

    @property
    def missing(self) -> int:
        return max(0, self.reported - self.there)


def kill_once(plan: Path, folder: Path, seed: int) -> Left:
    """Record, kill at a random moment, look at what is left, and go on."""
    chance = np.random.default_rng(seed)
    command = [sys.executable, __file__, "--record", str(plan), "--out", str(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        begun = 0
        if chance.random() > 0.15:
            wanted = 1 + int(chance.random() < 0.3)
            while begun < wanted and (line := child.stdout.readline()):
                begun += line.startswith("begin")
            lines = [f"begin {begun}"]
            time.sleep(chance.uniform(0, 1.5))
        else:
            lines = []
            time.sleep(chance.uniform(0, 4.0))
        child.kill()
        lines += child.stdout.read().split("\n")[:-1]  # the last one may be cut
        said = child.stderr.read() if child.stderr is not None else ""
    begins = [k for k, line in enumerate(lines) if line.startswith("begin")]
    reported = sum(line.startswith("frame") for line in lines[begins[-1] :]) if begins else 0
    left = look_at(folder, reported, has_begun=bool(begins))
    if "Traceback" in said:
        left.problems.append("traceback before the kill")
    left.problems += go_on(plan, folder)
    return left


def look_at(folder: Path, reported: int, *, has_begun: bool) -> Left:
    parts, files = sorted(folder.glob("*.part")), sorted(folder.glob("*.nxs"))
    problems = [text for path in files if (text := complaint_of(path))]
    if not parts:
        last = N_FRAMES if files else 0
        return Left("between files" if has_begun else "before any file", reported, last, "", problems)
    (part,), timed = parts, 0
    verified = subprocess.run([PROGRAM, "verify", str(part)], capture_output=True, text=True, check=False)
    line = " ".join(verified.stdout.split()).partition(": is ")[2]
    try:
        with opened(part, is_growing=True) as file:
            there = frames_there(file)
    except Complaint as complaint:
        return Left("in a file", reported, 0, line, [*problems, f"NOT OPENED: {complaint}"])
    if verified.returncode != 2 or f"it has {there} frames" not in verified.stdout or "Traceback" in verified.stderr:
        problems.append(f"verify says {verified.returncode}: {verified.stdout} {verified.stderr}")
    if there >= FEWEST_FRAMES:
        try:
            whole = reader.read(recover(part, folder / "trusted.nxs", keep=True, trust=True))
            timed = min(there, whole.camera_trigger_ticks.size)
            if whole.frame_number.tolist() != list(range(timed)):
                problems.append(f"{whole.frame_number.size} frames of {there} recovered, or others")
        except ArchiveError as error:
            if "slot" not in str(error) and "camera_trigger" not in str(error):  # too early for a turn of the wheel
                problems.append(f"NOT RECOVERED: {error}")
        (folder / "trusted.nxs").unlink(missing_ok=True)
    return Left("in a file", reported, there, line, problems, untimed=there - timed)


def complaint_of(path: Path) -> str | None:
    """What is wrong with a file that has its name: it must be whole."""
    try:
        recording = reader.read(path)
    except ArchiveError as error:
        return str(error)
    is_whole = recording.frame_number.tolist() == list(range(N_FRAMES)) and recording.ending == "complete"
    return None if is_whole else f"{path.name}: {recording.frame_number.size} frames, {recording.ending}"


def go_on(plan: Path, folder: Path) -> list[str]:
    """The same command again, and once more where a computer that is busy with many rigs made a device fall silent."""
    command = [PROGRAM, "record", str(plan), "--out", str(folder)]
    for _ in range(TRIES):
        try:
            again = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        except subprocess.TimeoutExpired:
            return ["the same command again did not end"]
        if again.returncode == 0:
            break
        if again.returncode != 2 or "Traceback" in again.stderr or "does not answer" not in again.stderr:
            return [f"the same command again ended with {again.returncode}: {again.stderr[-300:]}"]
    if again.returncode:
        return [f"the same command ended with {again.returncode} {TRIES} times: {again.stderr[-300:]}"]
    runs = json.loads((folder / "series.json").read_text())["runs"]
    problems = [text for run in runs.values() if (text := complaint_of(folder / run["file"]))]
    lost = again.stderr.count("cannot be recovered")  # too early for a turn of the wheel, and told
    if len(runs) != N_RUNS or len(list(folder.glob("*.part"))) > lost:
        problems.append(f"{len(runs)} of {N_RUNS} runs, {len(list(folder.glob('*.part')))} unfinished files")
    return problems


def served(folder: Path, address: str) -> subprocess.Popen:
    """A simulated rig, with the plan for it in the folder."""
    words = ["--rows", str(ROWS), "--columns", str(COLUMNS), "--speed", f"{SPEED:g}", "--camera-address", address]
    words += ["--console", "0", "--settling", "1 s", "--run-up", "0.2 s", "--out", str(folder)]
    rig = subprocess.Popen([PROGRAM, "rig", "--simulate", *words], stdout=subprocess.PIPE, text=True)
    assert rig.stdout is not None
    while "is ready" not in (line := rig.stdout.readline()):
        if not line:
            raise SystemExit("the simulated rig did not begin")
    (folder / "plan.json").write_text(json.dumps({"clock_frequency_hz": 48_000_000, "plan": {"runs": [RUN] * N_RUNS}}))
    text = (folder / "plan.toml").read_text()
    head, _, rest = text.partition("[series]")
    after = rest[rest.index("[blackbody]") :].partition("[references]")[0]
    (folder / "plan.toml").write_text(f'{head}[series]\nplan = "plan.json"\n\n{after}')
    return rig


def killed(kills: int, *, seed: int, workers: int) -> list[Left]:
    """Kills, some at a time, each on a rig that no other uses."""
    with tempfile.TemporaryDirectory() as name:
        places: Queue[Path] = Queue()
        rigs = []
        for k in range(workers):
            place = Path(name) / f"rig{k}"
            rigs.append(served(place, f"127.{100 + os.getpid() % 100}.9.{k + 2}"))
            places.put(place)

        def kill(index: int) -> Left:
            place = places.get()
            try:
                left = kill_once(place / "plan.toml", place / f"series{index}", seed + index)
            finally:
                places.put(place)
            print(
                f"{index:4} {left.when:16} {left.reported:8} {left.there:6} {left.missing:7}  {left.verified[:100]}",
                flush=True,
            )
            for problem in left.problems:
                print(f"     PROBLEM: {problem}", flush=True)
            return left

        try:
            with ThreadPoolExecutor(workers) as pool:
                return list(pool.map(kill, range(kills)))
        finally:
            for rig in rigs:
                rig.terminate()
                rig.wait()
                if rig.stdout is not None:
                    rig.stdout.close()


def main() -> None:
    if sys.argv[1:2] == ["--record"]:
        record(sys.argv[2:])
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=3, help="rigs and programs at a time")
    options = parser.parse_args()
    print(f"{'kill':>4} {'when':16} {'reported':>8} {'there':>6} {'missing':>7}  verify says: it is ...")
    found = killed(options.kills, seed=options.seed, workers=options.workers)
    states = {state: sum(left.when == state for left in found) for state in sorted({left.when for left in found})}
    untimed = [left.untimed for left in found if left.there >= FEWEST_FRAMES and left.when == "in a file"] or [0]
    print(f"frames without a timestamp of their trigger: {np.median(untimed):.0f} usually, {max(untimed)} at most")
    sound = sum(not left.problems for left in found)
    worst = max(left.missing for left in found)
    print(f"{sound} of {len(found)} sound and completed afterwards; most frames missing: {worst}; killed {states}")
    sys.exit(0 if sound == len(found) and worst <= 1 else 1)


if __name__ == "__main__":
    main()
