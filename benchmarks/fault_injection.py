"""Random faults in the simulated rig while it is recorded: no recording may be wrong without saying so.

Each trial draws one or two faults of camera, trigger generator, chopper, blackbody, disk or person, and records one or two short
runs of the simulated rig through the real drivers over the real wires. The twin knows what each trigger's frame must look like
and when each edge was. A file that the reader takes must have exactly those pixels at those triggers, exactly those ticks, and
the blackbody's true temperature.

    python benchmarks/fault_injection.py --faults 1000 --seed 1
"""

import argparse
import asyncio
import gc
import json
import os
import random
import select
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Event, Thread
from unittest.mock import patch

import h5py
import numpy as np

from irtiming.acquire.attendant import Attendant
from irtiming.acquire.checklist import complaints
from irtiming.acquire.journal import Journal, digest_of
from irtiming.acquire.rig import connected_rig
from irtiming.acquire.series import Series, record_series
from irtiming.archive import layout, reader
from irtiming.archive.live import recording
from irtiming.archive.live.growing_file import set_ending
from irtiming.errors import ArchiveError, IrTimingError
from irtiming.gateware.register_map import Channel
from irtiming.records.recording import Recording
from irtiming.records.series_plan import BlackbodyWishes, CameraWishes, DeviceAddresses, SeriesPlan
from irtiming.records.trigger_plan import PlannedRun, TriggerPlan, TriggerScheme
from irtiming.twin.devices.bench import Bench, Workplace
from irtiming.twin.rig import SimulatedRig, draw
from irtiming.twin.scene import paper_scene

ROWS, COLUMNS = 48, 64
CLOCK_HZ = 48_000_000
SCHEME = TriggerScheme(turn_period_ticks=4_800_000, camera_period_ticks=920_000)
N = SCHEME.samples_per_turn
SPEEDS = (2.0, 4.0, 4.0, 8.0, 8.0)
POLL_S, LONGEST_START_S, LONGEST_S, HUNG_S = 0.005, 4.0, 90.0, 150.0
SAME_K = 0.25

COMPLETE, EARLY, IN_DOUBT, RIGHT_IN_DOUBT = "complete", "ended early", "not trusted", "... though right"
REFUSED, TRACEBACK, HUNG, WRONG = "refused", "traceback", "hung", "SILENTLY WRONG"
COLUMNS_OF_TABLE = (COMPLETE, EARLY, IN_DOUBT, RIGHT_IN_DOUBT, REFUSED, TRACEBACK, HUNG, WRONG)


@dataclass
class Trial:
    """One recording with its faults. ``later`` are things that are done so many seconds after it began, or its first frame."""

    chance: random.Random
    bench: Bench
    n_frames: int
    lasts_s: float
    later: list[tuple[bool, float, Callable[[], None]]] = field(default_factory=list)
    first_frame: Event = field(default_factory=Event)
    leaves: Event = field(default_factory=Event)
    disk: dict[str, float] = field(default_factory=dict)

    def at_some_time(self, what: Callable[[], None]) -> tuple[bool, float]:
        """Do something at a random moment: while all is made ready, or between triggers, or a little after the last."""
        is_running = self.chance.random() < 0.7
        when_s = self.chance.uniform(0, 1.2 * self.lasts_s if is_running else LONGEST_START_S)
        self.later.append((is_running, when_s, what))
        return is_running, when_s

    def now_or_later(self, faults: object, **values: object) -> None:
        """Set faults before the program begins, or at a random moment."""

        def happen() -> None:
            for name, value in values.items():
                setattr(faults, name, value)

        if self.chance.random() < 0.3:
            happen()
            return
        is_running, when_s = self.at_some_time(happen)
        if self.chance.random() < 0.3:
            before = {name: getattr(faults, name) for name in values}
            lasts_s = self.chance.uniform(0, self.lasts_s / 2)
            self.later.append(
                (is_running, when_s + lasts_s, lambda: [setattr(faults, n, v) for n, v in before.items()])
            )

    def some(self, where: str) -> frozenset[int]:
        """Numbers of frames: one or several, at the beginning, in the middle or at the end."""
        many = self.chance.choice((1, 1, 2, 3, 8))
        if where == "first":
            return frozenset(range(many))
        if where == "last":
            return frozenset(range(self.n_frames - many, self.n_frames))
        return frozenset(self.chance.sample(range(self.n_frames), many))


def _rate(trial: Trial, low: float, high: float) -> float:
    return low * (high / low) ** trial.chance.random()


def _lost_lock(trial: Trial) -> Callable[[], None]:
    off, tells = trial.chance.choice((-1, 1)) * _rate(trial, 1e-3, 0.3), trial.chance.random() < 0.5
    return lambda: trial.bench.chopper.lose_lock(off, admits=tells)


def _other_temperature(trial: Trial) -> Callable[[], None]:
    degc = trial.chance.uniform(17, 47)
    return lambda: trial.bench.blackbody._set(f"{degc:.2f}")


FAULTS: dict[str, Callable[[Trial], object]] = {
    "nothing": lambda t: None,
    "packets lost": lambda t: t.now_or_later(t.bench.camera.faults, packets_lost_per_mille=_rate(t, 1, 100)),
    "packets lost for ever": lambda t: t.now_or_later(
        t.bench.camera.faults, packets_lost_per_mille=_rate(t, 1, 100), resend_honoured=False
    ),
    "packets doubled": lambda t: t.now_or_later(t.bench.camera.faults, packets_doubled_per_mille=_rate(t, 1, 300)),
    "packets late": lambda t: t.now_or_later(t.bench.camera.faults, packets_late_per_mille=_rate(t, 1, 300)),
    "frames lost": lambda t: setattr(
        t.bench.camera.faults, "frames_lost", t.some(t.chance.choice(("first", "last", "any")))
    ),
    "first triggers missed": lambda t: t.now_or_later(t.bench.camera.faults, triggers_missed=t.some("first")),
    "last triggers missed": lambda t: t.now_or_later(t.bench.camera.faults, triggers_missed=t.some("last")),
    "triggers missed": lambda t: setattr(t.bench.camera.faults, "triggers_missed", t.some("any")),
    "spurious frames": lambda t: setattr(
        t.bench.camera.faults, "frames_spurious", t.some(t.chance.choice(("first", "last", "any")))
    ),
    "camera frozen": lambda t: t.now_or_later(t.bench.camera.faults, frozen=True),
    "camera unplugged": lambda t: t.now_or_later(t.bench.camera.faults, unplugged=True),
    "camera without clock": lambda t: setattr(t.bench.camera.faults, "has_timestamps", False),
    "camera loses its clock": lambda t: t.now_or_later(t.bench.camera.faults, has_timestamps=False),
    "generator garbled": lambda t: t.now_or_later(t.bench.line, garbled=_rate(t, 1e-5, 1e-2)),
    "generator loses bytes": lambda t: t.now_or_later(t.bench.line, lost=_rate(t, 1e-5, 1e-2)),
    "generator silent": lambda t: t.now_or_later(t.bench.line, is_silent=True),
    "generator unplugged": lambda t: t.at_some_time(t.bench.unplug_generator),
    "chopper loses lock": lambda t: t.at_some_time(_lost_lock(t)),
    "chopper silent": lambda t: t.now_or_later(t.bench.chopper.faults, is_silent=True),
    "chopper garbled": lambda t: t.now_or_later(t.bench.chopper.faults, garbled=_rate(t, 1e-3, 0.1)),
    "chopper loses replies": lambda t: t.now_or_later(t.bench.chopper.faults, lost=_rate(t, 0.01, 0.5)),
    "chopper: wrong blade": lambda t: t.bench.chopper._values.update(blade=t.chance.choice((1, 2, 6, 7, 8))),
    "chopper: wrong identity": lambda t: setattr(t.bench.chopper, "_identity", t.chance.choice(("MFLI 7", "", "?"))),
    "blackbody silent": lambda t: t.now_or_later(t.bench.blackbody.faults, is_silent=True),
    "blackbody garbled": lambda t: t.now_or_later(t.bench.blackbody.faults, garbled=_rate(t, 1e-3, 0.1)),
    "blackbody loses replies": lambda t: t.now_or_later(t.bench.blackbody.faults, lost=_rate(t, 0.01, 0.5)),
    "blackbody never stable": lambda t: t.now_or_later(t.bench.blackbody.faults, is_never_stable=True),
    "blackbody drifts": lambda t: t.at_some_time(_other_temperature(t)),
    "blackbody: bit error": lambda t: setattr(t.bench.blackbody.faults, "bit_error", "FAN STOPPED"),
    "blackbody is another": lambda t: setattr(t.bench.blackbody.faults, "is_binary", True),
    "Ctrl-C": lambda t: t.at_some_time(t.leaves.set),
    "disk full": lambda t: t.at_some_time(lambda: t.disk.update(full=1)),
    "disk slow": lambda t: t.disk.update(slow_s=t.chance.uniform(0.005, 0.05)),
}


class Witness:
    """What truly happened: the frame of each trigger, and each edge of the light gates."""

    def __init__(self, bench: Bench, first_frame: Event) -> None:
        self.trigger_of: dict[bytes, int] = {}
        self.temperature_k: dict[int, float] = {}
        self.edges: dict[Channel, list[np.ndarray]] = {Channel.CONTROL_SLOT: [], Channel.APPLICATION_SLOT: []}
        begin, wheel = bench.view.begin, bench.generator._wheel
        turn = wheel.turn

        def watched_begin(deliver, **words):
            def watched(frame):
                self.trigger_of[frame.pixels.tobytes()] = frame.moment.trigger_cycle
                self.temperature_k[frame.moment.trigger_cycle] = bench.blackbody.temperature_k
                first_frame.set()
                deliver(frame)

            begin(watched, **words)

        def watched_turn(until_cycle, *, slot_period_cycles):
            changes = turn(until_cycle, slot_period_cycles=slot_period_cycles)
            for line, found in self.edges.items():
                found.append(np.stack([changes[line].cycle, changes[line].level]))
            return changes

        bench.view.begin, wheel.turn = watched_begin, watched_turn

    def objection(self, recording: Recording) -> str | None:
        """What is wrong with a recording; None if all of it is as it was."""
        numbers, triggers = recording.frame_number, recording.camera_trigger_ticks
        frames = recording.frames.pick(list(range(recording.frames.shape[0])))
        delay = round(recording.trigger_delay_time_set_s * CLOCK_HZ)
        for number, pixels in zip(numbers.tolist(), frames, strict=True):
            made = self.trigger_of.get(pixels.tobytes())
            if made is None:
                return f"the frame of trigger {number} is none that the camera made"
            if made != triggers[number] + delay:
                return f"the frame of trigger {number} belongs to {(made - triggers[number] - delay) / 920_000:+.3f}"
        if recording.ending == layout.COMPLETE:
            true_k = [self.temperature_k[tick + delay] for tick in triggers[numbers].tolist()]
            if max(abs(k - recording.blackbody_temperature_k) for k in true_k) > SAME_K:
                return f"the blackbody had {min(true_k):.2f} to {max(true_k):.2f} K"
        for line, told in (
            (Channel.CONTROL_SLOT, recording.control_slot_ticks),
            (Channel.APPLICATION_SLOT, recording.application_slot_ticks),
        ):
            cycle, level = np.concatenate(self.edges[line], axis=1)
            true = cycle[(level == 1) & (np.diff(level, prepend=0) == 1)] + 1
            within = true[(true >= told[0]) & (true <= told[-1])]
            if not np.array_equal(within, told):
                return f"{line.name}: {told.size} ticks, {within.size} true ones, or others"
        return None


class Person(Attendant):
    def __init__(self, trial: Trial) -> None:
        self._trial = trial

    def is_leaving(self) -> bool:
        return self._trial.leaves.is_set()

    def written(self, frame, *, number) -> None:
        time.sleep(self._trial.disk.get("slow_s", 0.0))


@contextmanager
def happening(trial: Trial) -> Iterator[None]:
    """What happens later happens in its time."""
    is_over = Event()

    def happen(is_running: bool) -> None:
        while is_running and not trial.first_frame.wait(POLL_S):
            if is_over.is_set():
                return
        begun = time.monotonic()
        for _, when_s, what in sorted((event for event in trial.later if event[0] == is_running), key=lambda e: e[1]):
            if is_over.wait(max(0.0, begun + when_s - time.monotonic())):
                return
            what()

    def room(place):
        found = statvfs(place)
        return os.statvfs_result((*found[:3], 0, 0, *found[5:])) if trial.disk.get("full") else found

    statvfs, threads = os.statvfs, [Thread(target=happen, args=(is_running,)) for is_running in (False, True)]
    for thread in threads:
        thread.start()
    try:
        with patch.object(recording.os, "statvfs", room):
            yield
    finally:
        is_over.set()
        for thread in threads:
            thread.join()


async def record(trial: Trial, folder: Path) -> str:
    """What `irtiming record` does; gives the ending."""
    devices = DeviceAddresses(**trial.bench.addresses, speed=trial.bench.place.speed)
    plan = SeriesPlan(
        devices=devices,
        camera=CameraWishes(camera_type="photon"),
        blackbody=trial.chance.choice((None, BlackbodyWishes(temperatures_k=(303.15,), settle_within_s=20.0))),
        file_name="r{run}.nxs",
    )
    delay = trial.chance.choice((0, 240_000))
    run = PlannedRun(scheme=SCHEME, trigger_delay_ticks=delay, repeats=1, is_after_correction=False)
    triggers = TriggerPlan(clock_frequency_hz=CLOCK_HZ, schemes=(SCHEME,), runs=(run,) * trial.chance.choice((1, 1, 2)))
    series = Series(plan=plan, triggers=triggers, folder=folder)
    journal = Journal.opened(folder, digest=digest_of(plan, triggers), n_runs=len(series.runs))
    async with connected_rig(plan) as rig:
        found = await complaints(rig, series, journal=journal)
        if found:
            return f"refused: {'; '.join(found)}"
        return (await record_series(rig, series, attendant=Person(trial), journal=journal)).ending


def judged(path: Path, witness: Witness) -> tuple[str, str]:
    """What became of a file, and why."""
    try:
        recording = reader.read(path)
    except ArchiveError as error:
        with h5py.File(path, "r+") as file:
            set_ending(file, layout.COMPLETE)
        try:
            is_right = witness.objection(reader.read(path)) is None
        except ArchiveError:
            is_right = False
        return RIGHT_IN_DOUBT if is_right else IN_DOUBT, str(error)
    objection = witness.objection(recording)
    if objection is not None:
        return WRONG, f"{objection}; it says: {recording.ending}"
    return COMPLETE if recording.ending == layout.COMPLETE else EARLY, recording.ending


def attempt(rig: SimulatedRig, seed: int, *, kinds: list[str] | None = None, address: str) -> dict[str, object]:
    """One trial: its faults, what became of it, and what was said."""
    chance = random.Random(seed)
    names = [name for name in FAULTS if name != "nothing"]
    kinds = kinds or (["nothing"] if chance.random() < 0.02 else chance.sample(names, chance.choice((1, 1, 2))))
    speed = chance.choice(SPEEDS)
    place = Workplace(camera_address=address, speed=speed, run_up_s=0.2, settling_s=1.0, seed=seed)
    folder, begun = Path(tempfile.mkdtemp()), time.monotonic()
    try:
        with Bench(rig, place=place) as bench:
            bench.line.seed = seed
            bench.line.__post_init__()
            bench.camera.faults.seed = seed
            lasts_s = N * SCHEME.camera_period_ticks / CLOCK_HZ / speed
            trial = Trial(chance=chance, bench=bench, n_frames=N, lasts_s=lasts_s)
            witness = Witness(bench, trial.first_frame)
            for kind in kinds:
                FAULTS[kind](trial)
            results, said = _results(trial, witness, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    took_s = time.monotonic() - begun
    return {"seed": seed, "kinds": kinds, "speed": speed, "results": results, "said": said, "took_s": took_s}


def _results(trial: Trial, witness: Witness, folder: Path) -> tuple[list[str], list[str]]:
    try:
        with happening(trial):
            ending = asyncio.run(asyncio.wait_for(record(trial, folder), LONGEST_S))
    except TimeoutError:
        return [HUNG], [f"no end within {LONGEST_S:g} s"]
    except IrTimingError as error:
        ending = f"refused: {error}"
    except Exception:
        return [TRACEBACK], [traceback.format_exc()]
    found = [judged(path, witness) for path in sorted(folder.rglob("*.nxs"))]
    left = [path.name for path in folder.rglob("*.part")]
    said = [text for _, text in found] + [ending] + [f"left: {name}" for name in left]
    worst = [result for result, _ in found] or [REFUSED]
    if found and not ending.startswith(layout.COMPLETE) and worst[-1] == COMPLETE:
        worst.append(REFUSED)  # the next run could not begin
    return worst, said


def work(seeds: list[int], address: str, kinds: list[str] | None) -> None:
    """Trials of one process, one line of JSON for each."""
    scene = paper_scene(ROWS, COLUMNS)
    rig = draw(replace(scene, faults=replace(scene.faults, lost_frames=0)), seed=1)
    for seed in seeds:
        try:
            gc.collect()
            told = attempt(rig, seed, kinds=kinds, address=address)
        except Exception:
            told = {"seed": seed, "kinds": kinds or ["?"], "results": [TRACEBACK], "said": [traceback.format_exc()]}
        print(json.dumps(told), flush=True)


def trials(seeds: list[int], *, workers: int, kinds: list[str] | None) -> Iterator[dict[str, object]]:
    """Trials in processes of their own; one that hangs is killed, and its other seeds are given to a new one."""
    waiting = {k: seeds[k::workers] for k in range(workers)}
    running: dict[int, tuple[subprocess.Popen, float]] = {}
    while any(waiting.values()):
        for k, left in waiting.items():
            if left and k not in running:
                words = ["--work", ",".join(map(str, left)), "--address", f"127.{100 + os.getpid() % 100}.7.{k + 2}"]
                words += ["--only", ",".join(kinds)] if kinds else []
                command = [sys.executable, __file__, *words]
                running[k] = (subprocess.Popen(command, stdout=subprocess.PIPE, bufsize=0), time.monotonic())
        ready, _, _ = select.select([process.stdout for process, _ in running.values()], [], [], 1.0)
        for k, (process, since) in list(running.items()):
            if process.stdout in ready and (line := process.stdout.readline()):
                running[k] = (process, time.monotonic())
                told = json.loads(line)
                waiting[k].remove(told["seed"])
                yield told
                if waiting[k]:
                    continue
            elif process.stdout not in ready and time.monotonic() - since < HUNG_S:
                continue
            else:
                seed = waiting[k].pop(0)
                is_hung = process.poll() is None and process.stdout not in ready
                result = HUNG if is_hung else TRACEBACK
                yield {"seed": seed, "kinds": ["?"], "results": [result], "said": ["its process was lost"]}
            process.kill()
            process.stdout.close()
            process.wait()
            del running[k]


def show(found: list[dict[str, object]]) -> None:
    """The table: a trial of two faults stands in two lines, and once in the last."""
    lines: dict[str, Counter] = {}
    for told in found:
        for name in [*told["kinds"], "all"]:
            lines.setdefault(name, Counter()).update(told["results"])
            lines[name]["trials"] += 1
    print(f"\n{'fault':26}{'trials':>8}" + "".join(f"{name:>17}" for name in COLUMNS_OF_TABLE))
    for name in [*sorted(lines.keys() - {"all"}), "all"]:
        print(f"{name:26}{lines[name]['trials']:8}" + "".join(f"{lines[name][c]:17}" for c in COLUMNS_OF_TABLE))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--faults", type=int, default=1000, help="trials, each with one or two faults")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", help="kinds of fault, all of them in each trial, parted by commas")
    parser.add_argument("--log", type=Path, help="write every trial there, one line of JSON each")
    parser.add_argument("--work", help=argparse.SUPPRESS)
    parser.add_argument("--address", default="127.0.7.2", help=argparse.SUPPRESS)
    options = parser.parse_args()
    kinds = options.only.split(",") if options.only else None
    if options.work:
        work([int(seed) for seed in options.work.split(",")], options.address, kinds)
        return
    found, begun = [], time.monotonic()
    for told in trials(list(range(options.seed, options.seed + options.faults)), workers=options.workers, kinds=kinds):
        found.append(told)
        if options.log is not None:
            with options.log.open("a") as log:
                log.write(json.dumps(told) + "\n")
        if {TRACEBACK, HUNG, WRONG} & set(told["results"]):
            print(
                f"seed {told['seed']}: {', '.join(told['kinds'])}: {told['results']}: {' | '.join(told['said'])}",
                flush=True,
            )
    show(found)
    bad = sum(result in (TRACEBACK, HUNG, WRONG) for told in found for result in told["results"])
    load = os.getloadavg()[0]
    print(f"{len(found)} trials in {time.monotonic() - begun:.0f} s, load {load:.1f}: {bad} wrong, broken off or hung")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
