"""From the wire to the closed file: the simulated rig in a process of its own, `record` in this one; frames lost and CPU share.

Frames of 640 x 480 pixels of 16 bits come at four times 30.303 Hz over GigE Vision. In turn, round after round, they are (a)
recorded: received, given their triggers, compressed and written, with timestamps, to the closed file; (b) only received by our
driver; (c) only received by pyGigEVision, which the driver takes its control channel from. The pace is that of the frames as
they arrive, from the first to the last. The shares are of one core, from before the first trigger until the file is closed, or
the last frame is there; the twin's is that of its whole process.

    python benchmarks/acquisition_speed.py --frames 1000 --rounds 3
"""

import argparse
import asyncio
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Event, Thread

import numpy as np
from pyGigEVision import GVCPClient, GVSPReceiver

from irtiming.acquire.attendant import Attendant
from irtiming.acquire.counter import Counter
from irtiming.acquire.journal import Journal, digest_of
from irtiming.acquire.rig import Rig, connected_rig
from irtiming.acquire.series import Series, record_series
from irtiming.acquire.trigger_train import Accompaniment, trigger, wheel_at_speed
from irtiming.archive import reader
from irtiming.archive.series_file import read_series
from irtiming.records.series_plan import SeriesPlan
from irtiming.records.trigger_plan import PlannedRun, TriggerPlan
from irtiming.session.triggers import triggers_of
from irtiming.twin.devices.gige_registers import Address

ROWS, COLUMNS, SPEED = 480, 640, 4.0
PACKET_BYTES, HEADERS_BYTES, PATIENCE_S = 9000, 28, 2.0


@dataclass
class Stretch:
    """CPU time of this process and of the twin's from one moment to another, and how long it took, s."""

    twin: int
    elapsed_s: float = 0.0
    ours_s: float = 0.0
    twins_s: float = 0.0

    def begin(self) -> None:
        self.elapsed_s, self.ours_s, self.twins_s = -time.monotonic(), -time.process_time(), -cpu_of(self.twin)

    def end(self) -> None:
        self.elapsed_s += time.monotonic()
        self.ours_s += time.process_time()
        self.twins_s += cpu_of(self.twin)


@dataclass
class Found:
    lost: int
    damaged: int
    longest_queue: int
    stretch: Stretch
    pace_hz: float


class Arrivals:
    """When the first and the last frame arrived."""

    def __init__(self) -> None:
        self.count, self.first_s, self.last_s = 0, 0.0, 0.0

    def add(self) -> None:
        self.last_s = time.monotonic()
        self.first_s = self.first_s if self.count else self.last_s
        self.count += 1

    @property
    def pace_hz(self) -> float:
        return (self.count - 1) / (self.last_s - self.first_s) if self.count > 1 else 0.0


def cpu_of(process: int) -> float:
    """CPU time of another process so far, s."""
    words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def simulated_rig(folder: Path, address: str) -> Iterator[int]:
    """Number of the process that serves the rig."""
    program = str(Path(sys.executable).with_name("irtiming"))
    size = ["--rows", str(ROWS), "--columns", str(COLUMNS), "--speed", f"{SPEED:g}"]
    place = [
        "--camera-address",
        address,
        "--console",
        "0",
        "--settling",
        "3 s",
        "--run-up",
        "2 s",
        "--out",
        str(folder),
    ]
    command = [program, "rig", "--simulate", *size, *place]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            while "is ready" not in (line := process.stdout.readline()):
                if not line:
                    raise SystemExit("the simulated rig did not begin")
            yield process.pid
        finally:
            process.terminate()


class Watch(Attendant):
    """Times a run from before its first trigger to its closed file, and its frames."""

    def __init__(self, stretch: Stretch) -> None:
        self._stretch, self.arrivals = stretch, Arrivals()

    def begins(self, run, *, number, path) -> None:
        self._stretch.begin()

    def written(self, frame, *, number) -> None:
        self.arrivals.add()

    def ended(self, outcome) -> None:
        self._stretch.end()


async def recorded(plan: SeriesPlan, triggers: TriggerPlan, folder: Path, twin: int) -> Found:
    """Received and written."""
    stretch = Stretch(twin)
    watch = Watch(stretch)
    series = Series(plan=plan, triggers=triggers, folder=folder)
    journal = Journal.opened(folder, digest=digest_of(plan, triggers), n_runs=1)
    async with connected_rig(plan) as rig:
        outcome = await record_series(rig, series, attendant=watch, journal=journal)
    (run,) = outcome.outcomes
    n_read = reader.read(run.path).frames.shape[0]
    if not run.is_complete:
        print(f"not complete: {run.ending}")
    run.path.unlink()
    lost = run.verdict.triggers - n_read
    longest = max(run.longest_queue, run.counts.longest_queue)
    return Found(lost, run.counts.frames_damaged, longest, stretch, watch.arrivals.pace_hz)


async def triggered(rig: Rig, run: PlannedRun, stretch: Stretch, has_all: Event) -> None:
    """The train of triggers alone, until all frames are there."""

    async def begin() -> None:
        stretch.begin()

    beside = Accompaniment(before_start=begin)
    await trigger(rig.generator, run, counter=Counter(rig.generator), beside=beside, poll_s=rig.poll_s)
    until = time.monotonic() + PATIENCE_S
    while not has_all.is_set() and time.monotonic() < until:
        await asyncio.sleep(0.01)
    stretch.end()


async def at_speed(rig: Rig, run: PlannedRun) -> None:
    await rig.generator.load(run, clock_frequency_hz=rig.generator.clock_frequency_hz)
    if rig.chopper is not None and not (await rig.chopper.state()).is_enabled:
        await rig.chopper.prepare()
        await rig.chopper.start()
    await wheel_at_speed(rig.generator, run, poll_s=rig.poll_s)


async def received(plan: SeriesPlan, run: PlannedRun, twin: int) -> Found:
    """By our driver, and let go."""
    stretch, has_all, n_frames = Stretch(twin), Event(), run.scheme.samples_per_turn * run.repeats
    async with connected_rig(plan) as rig:
        await at_speed(rig, run)
        await rig.camera.arm()

        arrivals = Arrivals()

        async def take() -> int:
            count = 0
            async for frame in rig.camera.frames():
                arrivals.add()
                count += frame.is_whole
                if count == n_frames:
                    has_all.set()
            return count

        taking = asyncio.create_task(take())
        await triggered(rig, run, stretch, has_all)
        counts = await rig.camera.disarm()
        count = await taking
    return Found(n_frames - count, counts.frames_damaged, counts.longest_queue, stretch, arrivals.pace_hz)


async def received_by_other(plan: SeriesPlan, run: PlannedRun, twin: int) -> Found:
    """By pyGigEVision's receiver, and let go; our own driver only finds the generator."""
    stretch, has_all, n_frames = Stretch(twin), Event(), run.scheme.samples_per_turn * run.repeats
    async with connected_rig(plan) as rig:
        await at_speed(rig, run)
        await rig.camera.arm()
        await rig.camera.disarm()  # it is set up now
        host = plan.devices.camera.partition(":")[2]
        await rig.camera.close()
        client = GVCPClient(host)
        client.connect(force=False)
        other = GVSPReceiver(local_ip=host, packet_size=PACKET_BYTES - HEADERS_BYTES, camera_ip=host, max_queue=200)
        client.write_reg(Address.STREAM_ADDRESS, int.from_bytes(map(int, host.split("."))))
        client.write_reg(Address.STREAM_PORT, other.port)
        client.write_reg(Address.PACKET_SIZE, PACKET_BYTES)
        client.write_reg(Address.TRIGGER_MODE, 1)
        client.write_reg(Address.TRIGGER_SOURCE, 1)
        found, arrivals, is_over = [0, 0], Arrivals(), Event()

        def take() -> None:
            while not is_over.is_set():
                got = other.get_frame_with_info(timeout=0.2)
                if got is None:
                    continue
                arrivals.add()
                found[bool(got[1].get("missing_packets") or got[0].shape != (ROWS, COLUMNS))] += 1
                if found[0] == n_frames:
                    has_all.set()

        other.start()
        thread = Thread(target=take)
        thread.start()
        client.write_reg(Address.ACQUISITION_START, 1)
        await triggered(rig, run, stretch, has_all)
        client.write_reg(Address.ACQUISITION_STOP, 1)
        is_over.set()
        thread.join()
        other.close()
        client.disconnect()
    return Found(n_frames - found[0], found[1], 0, stretch, arrivals.pace_hz)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder", type=Path, help="where to write; if not given, that for temporary files")
    options = parser.parse_args()
    address = f"127.0.{8 + os.getpid() % 200}.7"
    found: dict[str, list[Found]] = {"recorded": [], "only received": [], "pyGigEVision": []}
    print(f"load before: {os.getloadavg()[0]:.2f} on {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory(dir=options.folder) as name, simulated_rig(Path(name), address) as twin:
        folder = Path(name)
        plan = read_series(folder / "plan.toml")
        assert plan.triggers is not None
        wishes = replace(plan.triggers, wheel_hz=("3",), samples=str(options.frames))
        plan = replace(plan, triggers=wishes, references=None)
        clock_hz = 48_000_000
        triggers = triggers_of(plan, clock_frequency_hz=clock_hz)
        run = triggers.runs[0]
        for turn in range(options.rounds):
            place = folder / f"{turn}"
            place.mkdir()
            found["recorded"].append(asyncio.run(recorded(plan, triggers, place, twin)))
            found["only received"].append(asyncio.run(received(plan, run, twin)))
            found["pyGigEVision"].append(asyncio.run(received_by_other(plan, run, twin)))
    rate_hz = SPEED * clock_hz / run.scheme.camera_period_ticks
    n_made = run.scheme.samples_per_turn * run.repeats
    print(f"{options.rounds} rounds of {n_made} frames of {COLUMNS} x {ROWS}, {rate_hz:.1f} triggers/s")
    print(
        f"{'':15}{'lost':>6}{'damaged':>9}{'longest queue':>15}{'frames/s':>10}{'CPU share':>11}{'twin':>8}{'per frame':>12}"
    )
    share = {}
    for label, rounds in found.items():
        shares = [one.stretch.ours_s / one.stretch.elapsed_s for one in rounds]
        share[label] = float(np.median(shares))
        twins = np.median([one.stretch.twins_s / one.stretch.elapsed_s for one in rounds])
        pace = np.median([one.pace_hz for one in rounds])
        lost, damaged = (sum(getattr(one, what) for one in rounds) for what in ("lost", "damaged"))
        longest = max(one.longest_queue for one in rounds)
        each = 1e3 * np.median([one.stretch.ours_s / n_made for one in rounds])
        print(
            f"{label:15}{lost:6}{damaged:9}{longest:15}{pace:10.1f}{share[label]:11.1%}{twins:8.1%}{each:9.2f} ms"
            f"   (rounds: {', '.join(f'{one:.1%}' for one in shares)})"
        )
    other = share["pyGigEVision"]
    print(f"pyGigEVision takes {other / share['only received']:.1f} times the CPU of our receiver", end=", ")
    print(f"{other / share['recorded']:.1f} times that of receiver and writer; load after: {os.getloadavg()[0]:.2f}")
    sys.exit(1 if sum(one.lost + one.damaged for one in found["recorded"]) else 0)


if __name__ == "__main__":
    main()
