"""Ctrl-C and SIGTERM held back while a library does what must not be stopped half-way."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Final, final

SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)
"""What stops a command: Ctrl-C, and what ``kill``, a service manager or a batch system sends."""

_Handler = Callable[[int, FrameType | None], object]


@final
class HeldSignals:
    """What came meanwhile; `tell` hands it on."""

    def __init__(self) -> None:
        self.before: Final[dict[signal.Signals, _Handler]] = {}
        self._came: signal.Signals | None = None

    def note(self, number: int, _: FrameType | None) -> None:
        """Handler that does nothing but remember."""
        self._came = signal.Signals(number)

    def tell(self) -> None:
        """Nothing where nothing came; else what the signal does otherwise, once: what tidies up is not stopped by the same.

        Raises
        ------
        KeyboardInterrupt
            If one came.
        """
        if self._came is not None:
            number, self._came = self._came, None
            self.before[number](number, None)
            raise KeyboardInterrupt


@contextmanager
def held_signals() -> Iterator[HeldSignals]:
    """For the time of a block they are only noted; other threads than the main one never see them."""
    held = HeldSignals()
    if threading.current_thread() is threading.main_thread():
        for number in SIGNALS:
            if callable(handler := signal.getsignal(number)):
                held.before[number] = handler
    for number in held.before:
        signal.signal(number, held.note)
    try:
        yield held
    finally:
        for number, handler in held.before.items():
            signal.signal(number, handler)
