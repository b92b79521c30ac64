"""The work that goes on for the pages: owned by the server, whoever looks or has stopped looking."""

import os
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from threading import Lock, Thread
from time import monotonic
from typing import TYPE_CHECKING, Any, Literal, final

from irtiming.errors import InstrumentError, IrTimingError
from irtiming.web.work import LEAVE, News, Task, accompany, function_of, run

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

JobKind = Literal[
    "rig", "recording", "analysis", "check", "conversion", "certificate", "application", "search", "campaign"
]
ALONE: tuple[JobKind, ...] = ("rig", "recording", "analysis", "campaign")
"""Kinds of which there is one at a time: a rig has one master, and an analysis wants the whole computer."""

_LINES, _KEPT = 300, 40


@final
@dataclass(frozen=True, kw_only=True)
class Ending:
    """How a job ended: ``text`` says why it failed, empty where it did not; ``answer`` is plain data."""

    text: str = ""
    answer: Any = None

    @property
    def is_good(self) -> bool:
        """Whether it did what was wanted."""
        return not self.text


@final
class Job:
    """One piece of work in a process of its own; its attributes are what is known of it now.

    Parameters
    ----------
    kind, title
        What it is, in a word and for people.
    """

    def __init__(self, kind: JobKind, title: str) -> None:
        self.kind, self.title = kind, title
        self.lines: deque[str] = deque(maxlen=_LINES)
        self.steps: dict[str, list[int]] = {}
        self.facts: dict[str, Any] = {}
        self.picture: bytes | None = None
        self.n_pictures = self.n_lines = 0
        self.ending: Ending | None = None
        self.begun_s = monotonic()
        self._line: Connection | None = None
        self._process: Any = None
        self._is_broken_off = False

    @property
    def is_over(self) -> bool:
        """Whether it has ended."""
        return self.ending is not None

    def start(self, task: Task, order: object) -> None:
        """Begin, in a new process."""
        context = get_context("spawn")
        self._line, far = context.Pipe()
        self._process = context.Process(target=run, args=(far,), kwargs={"task": task, "order": order}, name=self.kind)
        self._process.start()
        far.close()
        Thread(target=self._listen, name=f"{self.kind} listener", daemon=True).start()

    def say(self, word: str) -> None:
        """Say a word to the work, such as `LEAVE`."""
        with suppress(OSError):
            if self._line is not None:
                self._line.send(word)

    def break_off(self) -> None:
        """End it, and at the second time at once; for work that writes nothing but whole files."""
        if self._process is not None and self._process.is_alive():
            (self._process.kill if self._is_broken_off else self._process.terminate)()
            self._is_broken_off = True

    def wait(self, timeout_s: float) -> bool:
        """Whether it has ended within that time."""
        if self._process is not None:
            self._process.join(timeout_s)
        return self._process is None or not self._process.is_alive()

    def _listen(self) -> None:
        line = self._line
        with suppress(EOFError, OSError):
            while line is not None:
                self._learn(line.recv())
        if self.ending is None:
            self._process.join()
            self.ending = Ending(text=f"its process ended without a word (status {self._process.exitcode})")

    def _learn(self, news: News) -> None:
        if news.kind == "says":
            self.lines.append(news.value)
            self.n_lines += 1
        elif news.kind == "step":
            self.steps[news.name] = news.value
        elif news.kind == "fact":
            self.facts[news.name] = news.value
        elif news.kind == "picture":
            self.picture = news.value
            self.n_pictures += 1
        else:
            self.ending = Ending(text=news.value) if news.kind == "failed" else Ending(answer=news.value)


@final
class Jobs:
    """All jobs of a server, the latest last."""

    def __init__(self) -> None:
        self._jobs: list[Job] = []
        self._lock = Lock()
        self._asked: ProcessPoolExecutor | None = None

    def __iter__(self) -> Iterator[Job]:
        return iter(tuple(self._jobs))

    def latest(self, kind: JobKind) -> Job | None:
        """The last job of a kind; None where there was none."""
        return next((one for one in reversed(self._jobs) if one.kind == kind), None)

    def running(self, kind: JobKind) -> Job | None:
        """The job of a kind that goes on now."""
        found = self.latest(kind)
        return None if found is None or found.is_over else found

    def start(self, kind: JobKind, title: str, *, task: Task, order: object) -> Job:
        """Begin a job.

        Raises
        ------
        InstrumentError
            If there may be only one of its kind, and there is one.
        """
        with self._lock:
            if kind in ALONE and (other := self.running(kind)) is not None:
                raise InstrumentError(
                    f"{other.title} goes on, perhaps from another window; wait for its end, or stop it"
                )
            if sum(not one.is_over for one in self._jobs) >= _KEPT // 2:
                raise InstrumentError("too much goes on at once; wait for the end of something")
            job = Job(kind, title)
            job.start(task, order)
            over = [one for one in self._jobs if one.is_over]
            gone = over[: max(0, len(self._jobs) - _KEPT)]
            self._jobs = [*(one for one in self._jobs if one not in gone), job]
            return job

    def ask(self, task: Task, order: object) -> "Future[Any]":
        """Have something small found out in a process that is kept for it."""
        with self._lock:
            if self._asked is None:
                self._asked = _companion()
            try:
                return self._asked.submit(_answered, task, order)
            except BrokenProcessPool:
                self._asked = _companion()
                return self._asked.submit(_answered, task, order)

    def end(self, patience_s: float) -> None:
        """Have all work leave what it does: a recording is closed with what it has."""
        going = [one for one in self._jobs if not one.is_over]
        for one in going:
            one.say(LEAVE)
            if one.kind not in ("recording", "rig"):
                one.break_off()
        until_s = monotonic() + patience_s
        for kind in ("recording", "rig", None):  # the rig last: a recording ends with its devices
            for one in going:
                if kind in (one.kind, None) and not one.wait(max(0.0, until_s - monotonic())):
                    one.break_off()
        if self._asked is not None:
            self._asked.shutdown(wait=False, cancel_futures=True)


def _companion() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=accompany, initargs=(os.getpid(),))


class _Silent:
    """A line on which nothing is said."""

    def __getattr__(self, name: str) -> Any:
        return lambda *_: False


def _answered(task: Task, order: object) -> Ending:
    try:
        return Ending(answer=function_of(task)(_Silent(), order))
    except (IrTimingError, OSError, MemoryError, ArithmeticError, ValueError) as error:
        return Ending(text=str(error) or type(error).__name__)
