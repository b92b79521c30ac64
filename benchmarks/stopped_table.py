"""The commands that stopped_commands.py stops, and what they work on: small enough that each takes a second or two.

`record` needs a whole rig; it is killed by killed_series.py and killed_recordings.py, and its disk filled by fault_injection.py.
`gateware build` runs other programs' tools for minutes, and `serve` writes by what the other commands write by.
"""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import killed_recordings
from apply_frames import result_json
from irtiming.archive.live.recording import LiveRecording
from irtiming.archive.live.unfinished import part_of
from irtiming.archive.timestamps_file import write_timestamps
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun, TriggerScheme
from irtiming.session import demo
from irtiming.twin.scene import with_wheel_speed

EXAMPLES = Path(__file__).parents[1] / "examples"
CLOCK_HZ = 48_000_000
N_FRAMES = 200


@dataclass(frozen=True, kw_only=True)
class Command:
    """Words, said in a folder of its own beside the inputs; and copies of inputs that are in that folder before.

    What a loose one writes differs a little each time: a port that is free, or as many edges as came meanwhile.
    """

    words: tuple[str, ...]
    beside: tuple[str, ...] = ()
    is_loose: bool = False

    def at(self, top: Path, port: str) -> "Command":
        """The same with the names of the folder of inputs and of the simulated trigger generator's port."""
        words = tuple(port if word == "PORT" else _at(word, top) for word in self.words)
        return replace(self, words=words, beside=tuple(_at(name, top) for name in self.beside))


def _at(word: str, top: Path) -> str:
    return word.replace("../", f"{top}/", 1) if word.startswith("../") else word


def _say(*words: str, beside: tuple[str, ...] = (), is_loose: bool = False) -> Command:
    return Command(words=words, beside=beside, is_loose=is_loose)


LAB, RESULT, RIG = "../lab", "../lab/r.json", "../lab/rig.toml"
RUN = f"{LAB}/cooled-3Hz-0ms.nxs"
SIMULATE = ("simulate", "OUT", "--rows", "60", "--columns", "80", "--frames", str(N_FRAMES), "--serial-number", "7")
LINES = "camera_trigger=camera_trigger,control_slot=control_slot,application_slot=application_slot"
SLOW, FAST = "../slow.nxs", "../fast.nxs"
COMMANDS: dict[str, Command] = {
    "doctor": _say("doctor", "--json", "told.json"),
    "discover": _say("discover", "--timeout", "0.05", "--json", "told.json"),
    "plan": _say(
        "plan", "--clock-hz", "49152000", "--wheel-hz", "3", "--frame-hz", "30.303", "--samples", "200", "--json", "plan.json",
        "--picture", "order.svg",
    ),
    "rig": _say(
        "rig", "--simulate", "--out", "rig", "--rows", "16", "--columns", "16", "--camera-address", "127.0.0.77",
        "--console", "0", "--duration", "0.1 s", is_loose=True,
    ),
    "simulate": _say(*SIMULATE[:1], "lab", *SIMULATE[2:], "--delay", "0 ms", "--delay", "25 ms", "--json", "made.json"),
    "simulate anew": _say(
        *SIMULATE[:1], ".", *SIMULATE[2:], "--delay", "0 ms", "--force", beside=(RUN, RIG, f"{LAB}/truth.json")
    ),
    "import-capture": _say(
        "import-capture", "../run.vcd", "--map", LINES, "--frames", RUN, "--out", "taken.nxs", "--json", "ticks.json",
    ),
    "recover": _say("recover", "../killed.nxs.part", "--out", "found.nxs", "--keep", "--trust"),
    "recover in place": _say("recover", "killed.nxs.part", "--trust", beside=("../killed.nxs.part",)),
    "convert to NeXus": _say("convert", RUN, "frames.h5"),
    "convert to BigTIFF": _say("convert", RUN, "frames.tif"),
    "convert to NumPy": _say("convert", RUN, "frames.npy"),
    "convert to HCC": _say("convert", RUN, "frames.hcc"),
    "export-vcd": _say("export-vcd", RUN, "--out", "lines.vcd"),
    "calibrate-wheel": _say("calibrate-wheel", RUN, "--rig", RIG, "--out", "wheel.json", "--picture", "wheel.svg"),
    "clock": _say("clock", SLOW, "--rig", "rig.toml", "--json", "c.json", "--picture", "c.svg", beside=(RIG,)),
    "latency gates": _say(
        "latency", "gates", SLOW, FAST, "--application-gate", "5 us", "--application-gate-u", "300 ns", "--rig", "rig.toml",
        "--json", "l.json", beside=(RIG,),
    ),
    "latency loopback": _say(
        "latency", "loopback", SLOW, "--line", "camera_input", "--rig", "rig.toml", "--json", "l.json", beside=(RIG,)
    ),
    "verify": _say("verify", RUN, "--json", "told.json"),
    "info": _say("info", RUN, "--json", "told.json"),
    "analyse": _say(
        "analyse", RUN, "--rig", RIG, "--json", "r.json", "--report", "r.html", "--maps", "m.h5", beside=(RESULT,)
    ),
    "series": _say("series", RESULT, "--json", "s.json", "--report", "s.html"),
    "history": _say("history", "7", "--register", "r.sqlite", "--add", RESULT, "--json", "h.json"),
    "certificate in every form": _say(
        "certificate", RESULT, "--with", "../certificate.toml", "--out", "c.html", "--out", "c.xml", "--out", "c.pdf"
    ),
    "certificate as a crate": _say("certificate", RESULT, "--with", "../certificate.toml", "--out", "c.xml", "--crate", "c.zip"),
    "certificate read back": _say("certificate", "--check", "../c.xml", "--json", "told.json"),
    "apply time to a table": _say("apply", "time", RESULT, RUN, "--out", "times.csv"),
    "apply time to Parquet": _say("apply", "time", RESULT, RUN, "--out", "times.parquet"),
    "apply time to a copy": _say("apply", "time", RESULT, RUN, "--out", "times.nxs"),
    "apply frames": _say("apply", "frames", "../bolo.json", "../bolo/bolo-3Hz-0ms.nxs", "scene.nxs"),
    "apply export": _say("apply", "export", RESULT, "--to", "kalibr", "--out", "hand.yaml"),
    "campaign in one process": _say(
        "campaign", LAB, "--rig", RIG, "--out", "all", "--scheduler", "here", "--register", "r.sqlite", "--json", "all.json"
    ),
    "campaign by a worker": _say("campaign", LAB, "--rig", RIG, "--out", "all", "--workers", "1", "--register", "none"),
    "demo": _say("demo", "--camera", "photon", "--rows", "64", "--columns", "64", "--runs", "1", "--json", "d.json"),
    "gateware firmware": _say("gateware", "firmware", "--into", "board"),
    "gateware identify": _say("gateware", "identify", "PORT", "--json", "told.json"),
    "gateware record": _say(
        "gateware", "record", "PORT", "--plan", "../gateware-plan.json", "--out", "stamps.nxs", is_loose=True
    ),
    "gateware combine": _say("gateware", "combine", "../stamps.nxs", "../51.nxs", "--out", "whole.nxs"),
    "gateware loopback": _say("gateware", "loopback", "PORT", "--rig", "rig.toml", "--json", "told.json", beside=(RIG,)),
}  # fmt: skip


@contextmanager
def prepared(top: Path, run: Callable[[tuple[str, ...], Path], Any]) -> Iterator[str]:
    """Inputs of all commands, made by ``run`` in a folder, and the port of a simulated trigger generator that is served."""
    usual = demo._scene
    demo._scene = lambda order: with_wheel_speed(usual(order), 3.0, samples=N_FRAMES)
    with _generator(top) as port:
        for words in _inputs(top, port):
            ending = run(words, top)
            assert ending.status == 0, f"{' '.join(words)}: {ending.said}"
        (top / "bolo.json").write_text(json.dumps(result_json()))
        _make_killed(top)
        for name, speed_hz in (("slow", 3.0), ("fast", 9.0)):
            scheme = TriggerScheme(
                turn_period_ticks=round(CLOCK_HZ / speed_hz / 100) * 100, camera_period_ticks=1_584_000
            )
            planned = PlannedRun(scheme=scheme, trigger_delay_ticks=0, repeats=1, is_after_correction=False)
            write_timestamps(_timestamps(speed_hz), top / f"{name}.nxs", run=planned)
        yield port


def _inputs(top: Path, port: str) -> Iterator[tuple[str, ...]]:
    for name, kind in (("lab", "photon"), ("bolo", "microbolometer")):
        yield (*SIMULATE[:1], name, *SIMULATE[2:], "--camera", kind)
    shutil.copy(EXAMPLES / "certificate.toml", top)
    yield ("analyse", RUN[3:], "--rig", RIG[3:], "--json", RESULT[3:])
    yield ("export-vcd", RUN[3:], "--out", "run.vcd")
    yield ("certificate", RESULT[3:], "--with", "certificate.toml", "--out", "c.xml")
    scheme = ("--clock-hz", str(CLOCK_HZ), "--wheel-hz", "3", "--frame-hz", "30.303", "--samples", "51")
    yield ("plan", *scheme, "--json", "gateware-plan.json")
    yield ("gateware", "record", port, "--plan", "gateware-plan.json", "--out", "stamps.nxs")
    yield ("simulate", "few", "--rows", "32", "--columns", "48", "--frames", "51")
    (top / "few" / RUN.rpartition("/")[2]).rename(top / "51.nxs")


@contextmanager
def _generator(top: Path) -> Iterator[str]:
    words = ("gateware", "simulate", "--model", "--speed", "30", "--loop", "40 ns")
    command = [sys.executable, "-m", "irtiming", *words]
    with subprocess.Popen(command, cwd=top, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.terminate()


def _make_killed(top: Path) -> None:
    """A recording whose program was killed: its ``.part``."""
    with LiveRecording(top / "killed.nxs", head=killed_recordings.head()) as live:
        for index in range(40):
            slots = np.arange(
                index * killed_recordings.CAMERA_TICKS // 163_840,
                (index + 1) * killed_recordings.CAMERA_TICKS // 163_840,
            )
            live.append_ticks("camera_trigger", np.array([killed_recordings.trigger_ticks(index)]))
            live.append_ticks("control_slot", killed_recordings.FIRST_TICKS + 163_840 * slots)
            live.append_ticks(
                "application_slot", killed_recordings.FIRST_TICKS + 8_192_000 * (slots[slots % 50 == 0] // 50)
            )
            frame = killed_recordings.CameraFrame(
                pixels=killed_recordings.pixels_of(index),
                frame_id=index,
                device_timestamp_ticks=0,
                host_time_s=float(index),
            )
            live.append_frame(frame, frame_number=index)
        shutil.copy(part_of(top / "killed.nxs"), top / "found.part")
        live.finish()
    (top / "killed.nxs").unlink()
    (top / "found.part").rename(top / "killed.nxs.part")


def _timestamps(speed_hz: float) -> Timestamps:
    """Sixty turns of a wheel, a pulse per second at the spare input, and triggers that are led back to the camera's input."""
    rng, turns = np.random.default_rng(1), np.arange(60)[:, None]
    slots_s = ((turns + (np.arange(100) + rng.normal(0, 0.006, 100) - 9.07) / 100).ravel() + 1) / speed_hz
    edges_s = ((turns + np.array([0.0, 0.5 + 5e-5])).ravel() + 1) / speed_hz
    trigger, none = np.arange(30) * 1_584_000 + CLOCK_HZ, np.empty(0, np.int64)
    slots, edges, pulses = (
        np.floor((times_s + rng.normal(0, 40e-9, times_s.size)) * CLOCK_HZ).astype(np.int64)
        for times_s in (slots_s, edges_s, np.arange(1.5, edges_s[-1], 1.0))
    )
    return Timestamps(
        clock_frequency_hz=CLOCK_HZ, camera_trigger_ticks=trigger, camera_trigger_delayed_ticks=trigger,
        control_slot_ticks=slots, application_slot_ticks=edges, application_edge_ticks=none, camera_input_ticks=trigger + 7,
        spare_ticks=pulses, lost_after_ticks=none,
    )  # fmt: skip
