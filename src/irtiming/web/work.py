"""Work in a process of its own, and the line by which it tells how it stands and hears what is wanted of it."""

import os
import signal
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from multiprocessing.connection import Connection
from threading import Condition, Thread
from time import sleep
from typing import Any, Literal, NoReturn, TypeAlias, final

from irtiming.errors import IrTimingError, one_line

Kind = Literal["says", "step", "fact", "picture", "done", "failed"]
_MOST_SAID, _PATIENCE_S = 1000, 10.0

LEAVE = "leave"
"""Said to work that is to end as soon as it can, with what it has."""

MOVED = "moved"
"""Said when wheel and mask are where a person was asked to bring them."""


@final
@dataclass(frozen=True, kw_only=True)
class News:
    """A sentence, steps done of all, a fact by its name, a picture, or the end; ``value`` is plain data."""

    kind: Kind
    name: str = ""
    value: Any = None


@final
class Line:
    """The working end; whatever the server does, nothing here makes the work wait.

    Parameters
    ----------
    connection
        To the server. Where that has gone, it is as if `LEAVE` had been said.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._heard: set[str] = set()
        self._latest: dict[str, News] = {}
        self._said: deque[News] = deque(maxlen=_MOST_SAID)
        self._is_new, self._is_over = Condition(), False
        self._sender = Thread(target=self._send_all, name="sender", daemon=True)
        self._sender.start()

    def says(self, text: str) -> None:
        """A sentence for a person."""
        self._put(News(kind="says", value=one_line(text)))

    def step(self, name: str, *, done: int, total: int) -> None:
        """How far a piece of work is."""
        self._put(News(kind="step", name=name, value=[done, total]))

    def fact(self, name: str, value: object) -> None:
        """Something that is known now; it replaces what was known by that name."""
        self._put(News(kind="fact", name=name, value=value))

    def picture(self, content: bytes) -> None:
        """The latest picture, JPEG."""
        self._put(News(kind="picture", value=content))

    def hears(self, word: str) -> bool:
        """Whether the word was said so far."""
        try:
            while self._connection.poll():
                self._heard.add(self._connection.recv())
        except (EOFError, OSError):
            self._heard.add(LEAVE)
        return word in self._heard

    def forget(self, word: str) -> None:
        """Wait for the word anew."""
        self._heard.discard(word)

    def ends(self, news: News) -> None:
        """The last that is said; returns when all was sent, or the server takes nothing more."""
        self._put(news)
        with self._is_new:
            self._is_over = True
            self._is_new.notify()
        self._sender.join(_PATIENCE_S)

    def _put(self, news: News) -> None:
        with self._is_new:
            if news.kind in ("says", "done", "failed"):
                self._said.append(news)
            else:
                self._latest[f"{news.kind} {news.name}"] = news
            self._is_new.notify()

    def _send_all(self) -> None:
        """What the thread does that waits for the server."""
        with suppress(OSError):
            while True:
                with self._is_new:
                    while not (self._said or self._latest or self._is_over):
                        self._is_new.wait()
                    if not (self._said or self._latest):
                        return
                    going = [*self._latest.values(), *self._said]
                    self._latest.clear()
                    self._said.clear()
                for news in going:
                    self._connection.send(news)


Task: TypeAlias = str
"""``"files:check"`` is the function ``check`` of ``tasks/files.py``: it takes the line and its order, and gives plain data.

It is a name, for the server itself does not load what it needs.
"""


def function_of(task: Task) -> Callable[[Any, Any], Any]:
    """The function of a task, with all that it needs loaded."""
    module, _, name = task.partition(":")
    found: Callable[[Any, Any], Any] = getattr(import_module(f"irtiming.web.tasks.{module}"), name)
    return found


def run(connection: Connection, *, task: Task, order: object) -> None:
    """What the process does: the task, and how it ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which says so
    signal.signal(signal.SIGTERM, _leave)  # which breaks it off: what is half written is removed
    line = Line(connection)
    try:
        answer = function_of(task)(line, order)
    except (IrTimingError, OSError, MemoryError, ArithmeticError, ValueError) as error:
        notes = "".join(f" ({note})" for note in getattr(error, "__notes__", ()))
        line.ends(News(kind="failed", value=one_line(f"{error or type(error).__name__}{notes}")))
    else:
        line.ends(News(kind="done", value=answer))
    with suppress(OSError):
        connection.close()


def _leave(number: int, _: object) -> NoReturn:
    raise SystemExit(128 + number)


def give_way(by: int = 10) -> None:
    """Let a recording go first."""
    with suppress(AttributeError, OSError):
        os.nice(by)


def accompany(parent: int, *, every_s: float = 5.0) -> None:
    """Give way to recordings, and end when the parent process has: one that was killed can say nothing."""
    give_way()

    def watch() -> None:
        while os.getppid() == parent:
            sleep(every_s)
        os._exit(0)

    Thread(target=watch, name="companion", daemon=True).start()
