"""Ctrl-C, SIGTERM and kill -9 at any moment: the exit status that is documented, one line, and each file whole or not there."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from irtiming.archive.verify import verify

_START = """
import signal
from irtiming.cli import start
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job in the background ignores it
print("here", flush=True)
start.run()
"""
_PROGRAM = [sys.executable, "-c", _START]
"""The program, which says when it is there: until then Python itself starts, with a word of its own for who stops it."""

_ENDS = {signal.SIGINT: (130, -signal.SIGINT), signal.SIGTERM: (143,), signal.SIGKILL: (-signal.SIGKILL,)}
"""What a shell calls 130 is two things: Python ends itself by the signal where it came while a class was being made."""


def _stopped(words: list[str], *, after_s: float, by: signal.Signals) -> tuple[int, list[str]]:
    """Exit status, and lines on standard error that no progress bar wrote."""
    with subprocess.Popen([*_PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "here\n"
        time.sleep(after_s)
        process.send_signal(by)
        try:
            _, said = process.communicate(timeout=8)
        except subprocess.TimeoutExpired:  # numba drops what is raised while it loads a kernel: a person presses again
            process.send_signal(by)
            _, said = process.communicate(timeout=60)
    return process.returncode, [line for line in said.splitlines() if "frames" not in line]


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("after_s", [0.05, 0.2, 0.4, 0.65])
def test_stopped_while_the_program_starts(tmp_path: Path, after_s: float, by: signal.Signals) -> None:
    """Oracle: the documented exit status; a program that is still loading has nothing to undo."""
    status, lines = _stopped(["simulate", str(tmp_path / "lab"), "--runs", "20"], after_s=after_s, by=by)
    assert status in _ENDS[by]
    assert len(lines) == 1
    assert lines[0].startswith("irtiming: stopped")


@pytest.mark.parametrize(
    ("after_s", "by"),
    [(1.0, signal.SIGINT), (1.0, signal.SIGTERM), (1.8, signal.SIGINT), (1.8, signal.SIGKILL), (2.6, signal.SIGTERM)],
)
def test_a_simulation_that_is_stopped(tmp_path: Path, after_s: float, by: signal.Signals) -> None:
    """Oracle: the documented exit status; every file with a final name is sound."""
    words = ["simulate", str(tmp_path / "lab"), "--rows", "48", "--columns", "64", "--frames", "2000", "--runs", "20"]
    status, lines = _stopped(words, after_s=after_s, by=by)
    assert status in _ENDS[by]
    assert len(lines) == (0 if by is signal.SIGKILL else 1)
    for path in tmp_path.rglob("*.nxs"):
        assert verify(path)[0].severity == "ok"
    for path in tmp_path.rglob("*.json"):
        json.loads(path.read_text())
    if by is not signal.SIGKILL:
        assert not list(tmp_path.rglob("*.part"))
