"""Every command that writes, stopped at random moments: by kill -9, Ctrl-C and SIGTERM, and by a disk that takes no more.

Afterwards each file with a final name must be whole or not there, or as it was before. Ctrl-C, SIGTERM and a full disk leave
nothing else either, and end with the exit status that is documented, 130, 143 and 2, with one line and no traceback. The oracle
of *whole* is the same command undisturbed: the same datasets, keys, rows or last line. A full disk is a process that may not let
a file grow beyond a limit. The commands are those of stopped_table.py.

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
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import h5py
import hdf5plugin  # noqa: F401
import numpy as np
from pyarrow import parquet

from irtiming.cli import start
from irtiming.cli.interrupt import SIGNALS
from stopped_table import COMMANDS, Command, prepared

SENT = {"kill -9": signal.SIGKILL, "Ctrl-C": signal.SIGINT, "SIGTERM": signal.SIGTERM}
EXPECTED = {"kill -9": -signal.SIGKILL, "Ctrl-C": 130, "SIGTERM": 143, "full disk": 2}
FAULTS = tuple(EXPECTED)
PATIENCE_S = 120.0
AFTER_THE_END = 1.05  # of the undisturbed time, so that some moments come too late
FIRST, LAST = {".pdf": b"%PDF", ".png": b"\x89PNG"}, {".pdf": b"%%EOF", ".png": b"IEND\xaeB`\x82"}


@dataclass(frozen=True, kw_only=True)
class Ending:
    """How a command ended: its status as a shell tells it, less for a signal, what it said last, and the time it took."""

    status: int
    said: str
    lasted_s: float


def run(words: tuple[str, ...], folder: Path, *, stopped: tuple[float, int] | None = None, most: int = -1) -> Ending:
    """A command in a child of this process, whose parts are loaded already; C's own ``exit`` ends it, as HDF5 expects."""
    begun, (hears, says) = time.monotonic(), os.pipe()
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)  # until the program's own first handlers are there
    child = os.fork()
    if child == 0:
        _be(words, folder, says, most)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
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
        for number in SIGNALS:
            signal.signal(number, start._end_at_once)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
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


def face(path: Path, *, is_loose: bool = False) -> object:
    """What must be the same in a whole file, whenever it is made; of a loose one names and numbers of lines alone."""
    match path.suffix:
        case ".nxs" | ".h5":
            found = list(_datasets(path))
            return [name for name, _ in found] if is_loose else found
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
        case ".tif" | ".hcc" | ".part":
            return path.read_bytes()[:4], path.stat().st_size
        case ".parquet":
            table = parquet.read_table(path)
            return table.num_rows, table.column_names
        case ".zip":
            with zipfile.ZipFile(path) as crate:
                assert crate.testzip() is None
                return sorted(crate.namelist())
        case ".pdf" | ".png":
            content = path.read_bytes().rstrip()
            return content.startswith(FIRST[path.suffix]), content.endswith(LAST[path.suffix])
        case _:
            lines = path.read_text(encoding="utf-8").splitlines()
            return len(lines), "" if is_loose else lines[-1][-40:]


def _datasets(path: Path) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Name and shape of all, each read to its end."""
    found: list[h5py.Dataset] = []
    with h5py.File(path) as file:
        file.visititems(lambda _, one: found.append(one) if isinstance(one, h5py.Dataset) else None)
        for one in found:
            if one.shape is not None:
                _ = one[()]
            yield one.name, one.shape


@dataclass(frozen=True, kw_only=True)
class Faces:
    """Of files as the command finds them, where it does, and as it leaves them undisturbed."""

    before: dict[str, object]
    after: dict[str, object]
    is_loose: bool


def objection(folder: Path, faces: Faces, ending: Ending, fault: str) -> str:
    """What is wrong with what is left and how it ended; empty where nothing is."""
    left, is_killed = files(folder), fault == "kill -9"
    for name, path in left.items():
        known = [one[name] for one in (faces.after, faces.before if ending.status else {}) if name in one]
        if not known:
            if not is_killed:
                return f"{name} is left at status {ending.status}: {ending.said[-200:]}"
            continue
        try:
            seen = face(path, is_loose=faces.is_loose)
        except Exception as error:  # of whatever kind
            return f"{name} is not whole: {type(error).__name__}: {error!s:.100}"
        if seen not in known and not (path.suffix == ".sqlite" and _is_begun(seen)):
            return f"{name} is not as it must be: {seen!s:.80} for {known[0]!s:.80}"
    taken = set(faces.before) - set(faces.after) if set(faces.after) <= set(left) else set()
    if gone := set(faces.before) - set(left) - taken:
        return f"{', '.join(sorted(gone))}: was there before"
    lines = ending.said.splitlines()
    if ending.status == 0:
        missing = set(faces.after) - set(left)
        return f"status 0 without {', '.join(sorted(missing))}" if missing else ""
    if ending.status != EXPECTED[fault]:
        return f"status {ending.status}: {ending.said[-200:]}"
    if not is_killed and ("Traceback" in ending.said or not lines or not lines[-1].startswith("irtiming: ")):
        return f"it says {ending.said[-200:]!r}"
    return ""


def _is_begun(seen: object) -> bool:
    """A register of which only the tables were made, or not all of them yet."""
    return isinstance(seen, dict) and (not any(seen.values()) or seen.get("result", 0) == 0)


def tried(
    command: Command, place: Path, *, moments: int, until_s: float, chance: random.Random, tell: Callable[[str], None]
) -> Counter[str]:
    """Counts of endings by fault, and of objections; of so many moments, or as many as there is time for."""
    undisturbed = begun(command, place / "undisturbed")
    before = {name: face(path, is_loose=command.is_loose) for name, path in files(undisturbed).items()}
    ending = run(command.words, undisturbed)
    if ending.status:
        tell(f"  UNDISTURBED it ends with {ending.status}: {ending.said[-300:]}")
        shutil.rmtree(place)
        return Counter({"objections": 1})
    after = {name: face(path, is_loose=command.is_loose) for name, path in files(undisturbed).items()}
    faces = Faces(before=before, after=after, is_loose=command.is_loose)
    largest = max(path.stat().st_size for path in files(undisturbed).values())
    count: Counter[str] = Counter()
    for index in range(moments):
        if time.monotonic() > until_s:
            break
        fault = FAULTS[index % len(FAULTS)]
        folder = begun(command, place / "out")
        if fault == "full disk":
            found = run(command.words, folder, most=int(largest * chance.random() ** 2))
        else:
            at_s = chance.uniform(0, AFTER_THE_END * ending.lasted_s)
            found = run(command.words, folder, stopped=(at_s, SENT[fault]))
        problem = objection(folder, faces, found, fault)
        count[f"{fault}: {'whole' if found.status == 0 else 'stopped'}"] += 1
        if problem:
            count["objections"] += 1
            tell(f"  {fault}: {problem}")
        shutil.rmtree(folder)
    shutil.rmtree(place)
    count["ms"] = int(1000 * ending.lasted_s)
    return count


def begun(command: Command, folder: Path) -> Path:
    """A folder with the files that the command finds there."""
    folder.mkdir(parents=True)
    for path in command.beside:
        shutil.copy(path, folder)
    return folder


def load() -> None:
    """What commands load when they are said, once for all children."""
    for name in (
        "session",
        "archive",
        "estimate",
        "reduce",
        "report",
        "apply",
        "twin",
        "distribute",
        "instruments",
        "plan",
        "acquire",
    ):
        package = importlib.import_module(f"irtiming.{name}")
        for module in pkgutil.walk_packages(package.__path__, f"irtiming.{name}."):
            importlib.import_module(module.name)


def main() -> int:
    """Exit status 1 if there is an objection."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moments", type=int, default=100, help="of each command, spread over the faults")
    parser.add_argument("--minutes", type=float, default=1e6, help="at most so long for each command")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", default=[""], metavar="COMMAND", help="those whose names begin so")
    options = parser.parse_args()
    importlib.import_module("irtiming.cli.main")
    load()
    n_objections = 0
    kinds = [f"{fault}: {how}" for fault in FAULTS for how in ("stopped", "whole")]
    print("| command | time undisturbed in s | " + " | ".join(kinds) + " | objections |", flush=True)
    print("| --- |" + " ---: |" * (len(kinds) + 2), flush=True)
    top = Path(tempfile.mkdtemp())  # a TemporaryDirectory would be removed by the first child that ends
    try:
        with prepared(top, lambda words, folder: run(words, folder)) as port:
            for name, command in COMMANDS.items():
                if name.startswith(tuple(options.only)):
                    chance, said = random.Random(f"{name} {options.seed}"), list[str]()
                    count = tried(
                        command.at(top, port),
                        top / "place",
                        moments=options.moments,
                        until_s=time.monotonic() + 60 * options.minutes,
                        chance=chance,
                        tell=said.append,
                    )
                    numbers = [
                        f"{count['ms'] / 1000:.2f}",
                        *(str(count[kind]) for kind in kinds),
                        str(count["objections"]),
                    ]
                    print(f"| {name} | {' | '.join(numbers)} |")
                    print("\n".join(said[:5]), end="\n" if said else "", flush=True)
                    n_objections += count["objections"]
    finally:
        shutil.rmtree(top)
    return 1 if n_objections else 0


if __name__ == "__main__":
    sys.exit(main())
