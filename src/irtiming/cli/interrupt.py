"""Ctrl-C and SIGTERM that are not lost: what raises them remembers it, for a library may drop what was raised within it.

Numba does so while it loads a compiled kernel: the work then goes on as if nothing had come, and is stopped where it next
tells how far it is.
"""

import signal
import sys
from types import FrameType
from typing import Never, final

from irtiming.archive.held_signals import SIGNALS


@final
class Interrupt:
    """Handler of the signals: raises `KeyboardInterrupt`, and remembers for which of them (``number``).

    A command that heard a signal in its own way, to end cleanly, sets ``heard``: it changes the exit status alone.
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self.heard: int | None = None

    def __call__(self, number: int, frame: FrameType | None) -> Never:
        """One of them came.

        Raises
        ------
        KeyboardInterrupt
            Always.
        """
        self.number = number
        raise KeyboardInterrupt

    @property
    def exit_status(self) -> int:
        """As a shell tells it: 128 and the number of the signal, of Ctrl-C where none was remembered."""
        known = (number for number in (self.number, self.heard) if number is not None)
        return exit_status(next(known, signal.SIGINT))


def exit_status(number: int) -> int:
    """Exit status of a command that a signal stopped: 130 for Ctrl-C, 143 for SIGTERM."""
    return 128 + number


def heeded() -> list[signal.Signals]:
    """Those of the signals that this process may hear: a shell lets its jobs in the background ignore Ctrl-C."""
    return [number for number in SIGNALS if signal.getsignal(number) not in (signal.SIG_IGN, None)]


def ignore() -> None:
    """From now on none of them does anything."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def say_nothing_of_dropped(what: "sys.UnraisableHookArgs") -> None:
    """Hook for what Python itself drops, such as in a destructor: of a Ctrl-C, which is remembered, it says nothing.

    Parameters
    ----------
    what
        As Python gives it to ``sys.unraisablehook``.
    """
    if not issubclass(what.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(what)


def say_nothing(what: "sys.UnraisableHookArgs") -> None:
    """Hook for what Python itself drops after the last words of a stopped program.

    Parameters
    ----------
    what
        As Python gives it to ``sys.unraisablehook``.
    """


def raise_dropped() -> None:
    """Nothing, unless one of the signals came before and got lost.

    Raises
    ------
    KeyboardInterrupt
        If it did.
    """
    for handler in map(signal.getsignal, SIGNALS):
        if isinstance(handler, Interrupt) and handler.number is not None:
            raise KeyboardInterrupt
