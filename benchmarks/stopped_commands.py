"""Every command that writes, stopped at random moments: by kill -9, by Ctrl-C, and by a disk that takes no more.

Afterwards each file with a final name must be whole or not there. Ctrl-C and a full disk leave nothing else either, and end with
the exit status that is documented, 130 and 2, with one line and no traceback. The oracle of *whole* is the same command
undisturbed: the same datasets, keys, rows or last line. A full disk is a process that may not let a file grow beyond a limit.

`record` needs a rig; it is killed by killed_series.py and killed_recordings.py, and its disk filled by fault_injection.py.

    python benchmarks/stopped_commands.py --moments 100 --seed 1
    python benchmarks/stopped_commands.py --moments 10 --only convert
"""

import argparse
import atexit
import ctypes
import importlib
import json
import os
import pkgutil
import random
import resource
import select
import shutil
import signal
import sqlite3
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import h5py
import hdf5plugin  # noqa: F401
import numpy as np

from irtiming.archive.live.recording import LiveRecording
from irtiming.archive.live.unfinished import part_of
from irtiming.cli import start

EXAMPLES = Path(__file__).parents[1] / "examples"
FAULTS = ("kill -9", "Ctrl-C", "full disk")
PATIENCE_S = 120.0
AFTER_THE_END = 1.05  # of the undisturbed time, so that some moments come too late

LAB, RESULT, RIG = "../lab", "../lab/r.json", "../lab/rig.toml"
RUN = f"{LAB}/cooled-3Hz-0ms.nxs"
SIMULATE = ("simulate", "OUT", "--rows", "60", "--columns", "80", "--frames", "200", "--serial-number", "7")
LINES = "camera_trigger=camera_trigger,control_slot=control_slot,application_slot=application_slot"
COMMANDS: dict[str, tuple[str, ...]] = {
    "simulate": (*SIMULATE[:1], "lab", *SIMULATE[2:], "--delay", "0 ms", "--delay", "25 ms", "--json", "made.json"),
    "import-capture": (
        "import-capture", "../run.vcd", "--map", LINES, "--frames", RUN, "--out", "taken.nxs", "--json", "ticks.json",
    ),
    "recover": ("recover", "../killed.nxs.part", "--out", "found.nxs", "--keep", "--trust"),
    "convert to NeXus": ("convert", RUN, "frames.h5"),
    "convert to BigTIFF": ("convert", RUN, "frames.tif"),
    "convert to NumPy": ("convert", RUN, "frames.npy"),
    "export-vcd": ("export-vcd", RUN, "--out", "lines.vcd"),
    "calibrate-wheel": ("calibrate-wheel", RUN, "--rig", RIG, "--out", "wheel.json", "--picture", "wheel.svg"),
    "verify": ("verify", RUN, "--json", "told.json"),
    "info": ("info", RUN, "--json", "told.json"),
    "plan": (
        "plan", "--clock-hz", "49152000", "--wheel-hz", "3", "--frame-hz", "30.303", "--samples", "200", "--json", "plan.json",
    ),
    "analyse": ("analyse", RUN, "--rig", RIG, "--json", "r.json", "--report", "r.html"),
    "series": ("series", RESULT, "--json", "s.json", "--report", "s.html"),
    "history": ("history", "7", "--register", "r.sqlite", "--add", RESULT, "--json", "h.json"),
    "certificate": (
        "certificate", RESULT, "--with", "../certificate.toml", "--out", "c.html", "--out", "c.xml",
    ),
    "apply time to a table": ("apply", "time", RESULT, RUN, "--out", "times.csv"),
    "apply time to a copy": ("apply", "time", RESULT, RUN, "--out", "times.nxs"),
    "apply frames": ("apply", "frames", "../bolo.json", "../bolo/bolo-3Hz-0ms.nxs", "scene.nxs"),
    "apply export": ("apply", "export", RESULT, "--to", "kalibr", "--out", "hand.yaml"),
    "campaign": ("campaign", LAB, "--rig", RIG, "--out", "all", "--scheduler", "here", "--register", "r.sqlite"),
}  # fmt: skip
"""Words of each, said in a folder of its own beside the inputs."""


@dataclass(frozen=True, kw_only=True)
class Ending:
    """How a command ended: its status as a shell tells it, less for a signal, what it said last, and the time it took."""

    status: int
    said: str
    lasted_s: float


def run(words: tuple[str, ...], folder: Path, *, stopped: tuple[float, int] | None = None, most: int = -1) -> Ending:
    """A command in a child of this process, whose parts are loaded already; C's own ``exit`` ends it, as HDF5 expects."""
    begun, (hears, says) = time.monotonic(), os.pipe()
    child = os.fork()
    if child == 0:
        _be(words, folder, says, most)
    os.close(says)
    if stopped is not None:
        time.sleep(stopped[0])
        os.kill(child, stopped[1])
    said = b""
    while time.monotonic() < begun + PATIENCE_S and select.select([hears], [], [], PATIENCE_S)[0]:
        piece = os.read(hears, 65536)
        if not piece:
            break
        said += piece
    else:
        os.kill(child, signal.SIGKILL)
        said += b"\nit did not end"
    os.close(hears)
    _, status = os.waitpid(child, 0)
    code = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
    return Ending(status=code, said=said.decode(errors="replace").strip(), lasted_s=time.monotonic() - begun)


def _be(words: tuple[str, ...], folder: Path, says: int, most: int) -> None:
    """The command; never comes back."""
    code: object = 1
    try:
        os.chdir(folder)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(says, 2)
        os.close(says)
        if most >= 0:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        signal.signal(signal.SIGINT, signal.default_int_handler)
        sys.argv = ["irtiming", *words]
        start.run()
        code = 0
    except SystemExit as ending:
        code = ending.code
    except BaseException as error:  # a traceback, which it must not have
        os.write(2, f"Traceback: {type(error).__name__}: {error}".encode())
    sys.stdout.flush()
    sys.stderr.flush()
    atexit._run_exitfuncs()
    ctypes.CDLL(None).exit(code if isinstance(code, int) else 0 if code is None else 1)


def files(folder: Path) -> dict[str, Path]:
    return {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*")) if path.is_file()}


def face(path: Path) -> object:
    """What must be the same in a whole file, whenever it is made."""
    match path.suffix:
        case ".nxs" | ".h5":
            return list(_datasets(path))
        case ".json":
            content = json.loads(path.read_text(encoding="utf-8"))
            return sorted(content) if isinstance(content, dict) else len(content)
        case ".sqlite":
            with closing(sqlite3.connect(path)) as register:
                assert register.execute("pragma integrity_check").fetchone() == ("ok",)
                tables = register.execute("select name from sqlite_master where type = 'table'").fetchall()
                return {name: register.execute(f'select count(*) from "{name}"').fetchone()[0] for (name,) in tables}
        case ".npy":
            return np.load(path).shape
        case ".tif" | ".parquet":
            return path.read_bytes()[:4], path.stat().st_size
        case _:
            lines = path.read_text(encoding="utf-8").splitlines()
            return len(lines), lines[-1][-40:]


def _datasets(path: Path) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Name and shape of all, each read to its end."""
    found: list[h5py.Dataset] = []
    with h5py.File(path) as file:
        file.visititems(lambda _, one: found.append(one) if isinstance(one, h5py.Dataset) else None)
        for one in found:
            if one.shape is not None:
                _ = one[()]
            yield one.name, one.shape


def objection(folder: Path, whole: dict[str, object], ending: Ending, fault: str) -> str:
    """What is wrong with what is left and how it ended; empty where nothing is."""
    left, is_killed = files(folder), fault == "kill -9"
    for name, path in left.items():
        if name not in whole:
            if not is_killed:
                return f"{name} is left"
            continue
        try:
            seen = face(path)
        except Exception as error:  # of whatever kind
            return f"{name} is not whole: {type(error).__name__}: {error!s:.100}"
        if seen != whole[name] and not (path.suffix == ".sqlite" and isinstance(seen, dict) and not any(seen.values())):
            is_begun = path.suffix == ".sqlite" and seen.get("result", 0) == 0
            if not is_begun:
                return f"{name} is not as it must be: {seen!s:.80} for {whole[name]!s:.80}"
    lines = ending.said.splitlines()
    expected = {"kill -9": -signal.SIGKILL, "Ctrl-C": 130, "full disk": 2}[fault]
    if ending.status == 0:
        missing = set(whole) - set(left)
        return f"status 0 without {', '.join(sorted(missing))}" if missing else ""
    if ending.status != expected:
        return f"status {ending.status}: {ending.said[-200:]}"
    if not is_killed and ("Traceback" in ending.said or not lines or not lines[-1].startswith("irtiming: ")):
        return f"it says {ending.said[-200:]!r}"
    return ""


def tried(
    words: tuple[str, ...], place: Path, *, moments: int, chance: random.Random, tell: Callable[[str], None]
) -> Counter[str]:
    """Counts of endings by fault, and of objections."""
    undisturbed = place / "undisturbed"
    undisturbed.mkdir(parents=True)
    ending = run(words, undisturbed)
    if ending.status:
        tell(f"  UNDISTURBED it ends with {ending.status}: {ending.said[-300:]}")
        shutil.rmtree(place)
        return Counter({"objections": 1})
    whole = {name: face(path) for name, path in files(undisturbed).items()}
    largest = max(path.stat().st_size for path in files(undisturbed).values())
    count: Counter[str] = Counter()
    for _ in range(moments):
        for fault in FAULTS:
            folder = place / "out"
            folder.mkdir()
            if fault == "full disk":
                found = run(words, folder, most=int(largest * chance.random() ** 2))
            else:
                by = signal.SIGKILL if fault == "kill -9" else signal.SIGINT
                found = run(words, folder, stopped=(chance.uniform(0, AFTER_THE_END * ending.lasted_s), by))
            problem = objection(folder, whole, found, fault)
            count[f"{fault}: {'whole' if found.status == 0 else 'stopped'}"] += 1
            if problem:
                count["objections"] += 1
                tell(f"  {fault}: {problem}")
            shutil.rmtree(folder)
    shutil.rmtree(place)
    return count


def prepare(top: Path) -> None:
    """Recordings of both kinds of camera, a result of each, a capture, and a recording whose program was killed."""
    import killed_recordings
    from apply_frames import result_json

    for name, kind in (("lab", "photon"), ("bolo", "microbolometer")):
        words = [top.joinpath(name).as_posix() if word == "OUT" else word for word in SIMULATE]
        assert run((*words, "--camera", kind), top).status == 0
    for inputs in (
        ("analyse", RUN[3:], "--rig", RIG[3:], "--json", RESULT[3:]),
        ("export-vcd", RUN[3:], "--out", "run.vcd"),
    ):
        ending = run(inputs, top)
        assert ending.status == 0, ending.said
    (top / "bolo.json").write_text(json.dumps(result_json()))
    shutil.copy(EXAMPLES / "certificate.toml", top)
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


def load() -> None:
    """What commands load when they are said, once for all children."""
    for name in ("session", "archive", "estimate", "reduce", "report", "apply", "twin", "distribute"):
        package = importlib.import_module(f"irtiming.{name}")
        for module in pkgutil.walk_packages(package.__path__, f"irtiming.{name}."):
            importlib.import_module(module.name)


def main() -> int:
    """Exit status 1 if there is an objection."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moments", type=int, default=100, help="of each command and fault")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", default=[""], metavar="COMMAND", help="those whose names begin so")
    options = parser.parse_args()
    importlib.import_module("irtiming.cli.main")
    load()
    n_objections = 0
    kinds = [f"{fault}: {how}" for fault in FAULTS for how in ("stopped", "whole")]
    print("| command | " + " | ".join(kinds) + " | objections |", flush=True)
    print("| --- |" + " ---: |" * (len(kinds) + 1), flush=True)
    top = Path(tempfile.mkdtemp())  # a TemporaryDirectory would be removed by the first child that ends
    try:
        prepare(top)
        for command, words in COMMANDS.items():
            if command.startswith(tuple(options.only)):
                chance, said = random.Random(f"{command} {options.seed}"), list[str]()
                here = tuple(word.replace("../", f"{top}/", 1) if word.startswith("../") else word for word in words)
                count = tried(here, top / "place", moments=options.moments, chance=chance, tell=said.append)
                print(
                    f"| {command} | " + " | ".join(str(count[kind]) for kind in kinds) + f" | {count['objections']} |"
                )
                print("\n".join(said[:5]), end="\n" if said else "", flush=True)
                n_objections += count["objections"]
    finally:
        shutil.rmtree(top)
    return 1 if n_objections else 0


if __name__ == "__main__":
    sys.exit(main())
