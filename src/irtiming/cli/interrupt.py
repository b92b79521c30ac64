"""Ctrl-C that is not lost: what raises it remembers it, for a library may drop what was raised within it.

Numba does so while it loads a compiled kernel: the work then goes on as if nothing had been pressed, and is stopped where it next
tells how far it is.
"""

import signal
import sys
from types import FrameType
from typing import Never, final


@final
class Interrupt:
    """Handler of the signal: raises `KeyboardInterrupt`, and remembers that it did (``is_pressed``)."""

    def __init__(self) -> None:
        self.is_pressed = False

    def __call__(self, number: int, frame: FrameType | None) -> Never:
        """Ctrl-C was pressed.

        Raises
        ------
        KeyboardInterrupt
            Always.
        """
        self.is_pressed = True
        raise KeyboardInterrupt


def say_nothing_of_dropped(what: "sys.UnraisableHookArgs") -> None:
    """Hook for what Python itself drops, such as in a destructor: of a Ctrl-C, which is remembered, it says nothing.

    Parameters
    ----------
    what
        As Python gives it to ``sys.unraisablehook``.
    """
    if not issubclass(what.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(what)


def raise_dropped() -> None:
    """Nothing, unless Ctrl-C was pressed before and got lost.

    Raises
    ------
    KeyboardInterrupt
        If it was.
    """
    handler = signal.getsignal(signal.SIGINT)
    if isinstance(handler, Interrupt) and handler.is_pressed:
        raise KeyboardInterrupt
