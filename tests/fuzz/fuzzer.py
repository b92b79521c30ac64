"""Gives hostile inputs to every part of the program that takes any, in a process that may die.

As a program (``python fuzzer.py``) it is that process; `fuzz` starts it, and starts it again behind an input that killed it.
The oracle is the same for all: only the project's own errors come out, within 10 s, in less than 1 GB, and no crash.
"""

import json
import queue
import random
import resource
import signal
import subprocess
import sys
import threading
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

LONGEST_S = 10
MOST_KB = 1_000_000
_SILENT_S = 4 * LONGEST_S


@dataclass(kw_only=True)
class Report:
    """What came of it: inputs of each target; a find is (target, number of the input, what went wrong)."""

    n_inputs: Counter[str] = field(default_factory=Counter)
    finds: list[tuple[str, int, str]] = field(default_factory=list)
    slowest: tuple[float, str, int] = (0.0, "", -1)


def input_of(target: str, number: int, seed: int) -> bytes:
    """Input of a target: first those that did harm once, then the seeds as they are, then drawn ones."""
    from targets import FOUND, TARGETS

    found, seeds = FOUND.get(target, []), _seeds(target)
    if number < len(found) + len(seeds):
        return [*found, *seeds][number]
    rng = random.Random(f"{target} {number} {seed}")
    return rng.choice(TARGETS[target].changes)(rng, rng.choice(seeds), seeds)


def fuzz(*, seconds: float, seed: int, most_each: int = 2**62, only: str = "") -> Report:
    """Try inputs for so long, as many of each target whose name begins with ``only``, at most ``most_each``."""
    report, end_s = Report(), time.monotonic() + seconds
    first = 0
    while time.monotonic() < end_s:
        last = _one_process(report, first=first, seed=seed, end_s=end_s, most_each=most_each, only=only)
        if last is None:
            break
        first = last + 1
    return report


def _one_process(report: Report, *, first: int, seed: int, end_s: float, most_each: int, only: str) -> int | None:
    """Until it ends (None) or dies; then the count at which it did."""
    left_s = max(1.0, end_s - time.monotonic())
    command = [sys.executable, __file__, str(first), str(seed), str(left_s), str(most_each), only]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        lines: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=_pass_on, args=(process.stdout, lines), daemon=True).start()
        count, place = first, ("start", -1)
        while True:
            try:
                line = lines.get(timeout=_SILENT_S)
            except queue.Empty:
                process.kill()
                report.finds.append((*place, f"no sign of life for {_SILENT_S} s"))
                return count
            if line is None:
                break
            told = json.loads(line)
            if told["kind"] == "next":
                count, place = told["count"], (told["target"], told["number"])
            elif told["kind"] == "done":
                report.n_inputs[place[0]] += 1
                report.slowest = max(report.slowest, (told["lasted_s"], *place))
            else:
                report.finds.append((*place, told["what"]))
        said = process.stderr.read() if process.stderr else ""
        status = process.wait()
    if status == 0:
        return None
    if status != 3:
        report.finds.append((*place, f"the process died with {status}: {said[-500:]}"))
    return None if place[1] < 0 else count  # without an input the program itself is broken


def _pass_on(stream: Any, lines: "queue.Queue[str | None]") -> None:
    for line in stream:
        if line.startswith("{"):
            lines.put(line)
    lines.put(None)


def _order(only: str) -> Iterator[tuple[int, str, int]]:
    """Count, target, and number of its input: one of each target in each round that is its."""
    from targets import TARGETS

    count, turn = 0, 0
    chosen = [(target, TARGETS[target].round) for target in TARGETS if target.startswith(only)]
    while chosen:
        for target, each in chosen:
            if turn % each == 0:
                yield count, target, turn // each
                count += 1
        turn += 1


_known_seeds: dict[str, list[bytes]] = {}


def _seeds(target: str) -> list[bytes]:
    from targets import TARGETS

    if target not in _known_seeds:
        _known_seeds[target] = TARGETS[target].seeds()
    return _known_seeds[target]


class _TooLong(BaseException):
    pass


def _too_long(*_: object) -> None:
    raise _TooLong


def _tell(**what: object) -> None:
    print(json.dumps(what), flush=True)


def _main(first: int, seed: int, seconds: float, most_each: int, only: str) -> None:
    from targets import TARGETS

    from irtiming.archive import hdf5_probe

    warnings.simplefilter("ignore")
    hdf5_probe.LONGEST_CPU_S = 2
    resource.setrlimit(resource.RLIMIT_AS, (2**33, 2**33))
    signal.signal(signal.SIGPROF, _too_long)  # by the processor's time: others may be at work on the machine
    end_s = time.monotonic() + seconds
    for count, target, number in _order(only):
        if time.monotonic() > end_s or number >= most_each:
            return
        if count < first:
            continue
        data = input_of(target, number, seed)
        _tell(kind="next", count=count, target=target, number=number)
        begun_s = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
        try:
            TARGETS[target].take(data)
        except _TooLong:
            _tell(kind="find", what=f"took more than {LONGEST_S} s: {_where()}")
        except Exception as error:
            _tell(kind="find", what=f"{type(error).__name__}: {error!s:.200} ({_where()})")
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        _tell(kind="done", lasted_s=time.process_time() - begun_s)
        if (used_kb := _most_used_kb()) > MOST_KB:
            _tell(kind="find", what=f"took {used_kb // 1000} MB")
            sys.exit(3)


def _most_used_kb() -> int:
    """Most memory that this program took; ``ru_maxrss`` would be no less than what its parent had when it started this one."""
    (line,) = (line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1])


def _where() -> str:
    _, _, trace = sys.exc_info()
    places = [f"{Path(one.filename).name}:{one.lineno}" for one in traceback.extract_tb(trace)]
    return " ".join(places[-4:])


if __name__ == "__main__":
    _main(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]), sys.argv[5])
