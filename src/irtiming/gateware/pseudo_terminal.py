"""A simulated device behind a serial port of its own: a driver cannot tell it from a real one."""

import os
import select
import sys
from collections.abc import Callable
from threading import Event, Thread
from time import monotonic
from types import TracebackType
from typing import Self, TypeAlias, final

from irtiming.errors import GatewareError
from irtiming.gateware.model_device import SimulatedDevice

Bytes: TypeAlias = Callable[[bytes], bytes]
"""What a line makes of bytes; called over and over, also with none, so that it may hold some back."""

_TICK_S = 0.005
_LONGEST_DEBT_S = 0.5
"""So much of the time that a device was not let run it makes up for later; what is more it never lives through."""

_MOST_BYTES = 4096
_MOST_WAITING = 2**16
"""Bytes that wait for a reader; the device's time stands still while there are more."""


@final
class PseudoTerminal:
    """Serves a device at ``path`` while its ``with`` block runs.

    Parameters
    ----------
    device
        The model, or the compiled circuit.
    speed
        Seconds of the device in one of the user's. A device that cannot keep up runs as fast as it can.
    to_device, to_computer
        What the line makes of the bytes; a test lets them come to harm.

    Raises
    ------
    GatewareError
        On a system without pseudo-terminals.
    """

    def __init__(
        self, device: SimulatedDevice, *, speed: float = 1.0, to_device: Bytes = bytes, to_computer: Bytes = bytes
    ) -> None:
        if sys.platform == "win32":
            raise GatewareError("this system has no pseudo-terminals; run the simulated device on Linux or macOS")
        import tty

        self._device = device
        self._speed = speed
        self._to_device, self._to_computer = to_device, to_computer
        self._ours, self._theirs = os.openpty()  # theirs stays open: a port does not vanish when its user leaves
        tty.setraw(self._theirs)
        os.set_blocking(self._ours, False)
        self._path = os.ttyname(self._theirs)
        self._waiting = bytearray()
        self._is_unplugged = Event()
        self._failure: BaseException | None = None
        self._thread = Thread(target=self._serve, name=f"device at {self._path}", daemon=True)

    @property
    def path(self) -> str:
        """Of the port."""
        return self._path

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.unplug()
        if self._failure is not None and error is None:
            raise self._failure

    def unplug(self) -> None:
        """Take the port away under its user's hands; again does no harm."""
        if self._is_unplugged.is_set() and not self._thread.is_alive():
            return
        self._is_unplugged.set()
        self._thread.join()

    def wait(self, duration_s: float | None = None) -> None:
        """Go on serving for so long, or for ever."""
        self._is_unplugged.wait(duration_s)

    def _serve(self) -> None:
        try:
            self._serve_until_unplugged()
        except BaseException as error:
            self._failure = error
        finally:
            self._is_unplugged.set()
            os.close(self._ours)
            os.close(self._theirs)

    def _serve_until_unplugged(self) -> None:
        rate = self._device.clock_frequency_hz * self._speed
        cycle, owed, before = 0, 0, monotonic()
        most = step = int(2 * _TICK_S * rate)
        while not self._is_unplugged.is_set():
            select.select([self._ours], [self._ours] if self._waiting else [], [], _TICK_S)
            received = self._to_device(self._read())
            now = monotonic()
            if len(self._waiting) < _MOST_WAITING:
                owed = min(owed + int((now - before) * rate), int(_LONGEST_DEBT_S * rate))
                lived = min(owed, step)
                cycle, owed = cycle + lived, owed - lived
            before = now
            sent = self._device.exchange(b"", until_cycle=cycle)  # so that it hears a command now and not in its past
            sent += self._device.exchange(received, until_cycle=cycle) if received else b""
            self._waiting += self._to_computer(sent)
            is_slow = monotonic() - now > 2 * _TICK_S  # a command must not wait for long
            step = max(step // 2, 1) if is_slow else min(2 * step, most)
            self._write()

    def _read(self) -> bytes:
        try:
            return os.read(self._ours, _MOST_BYTES)
        except BlockingIOError:
            return b""

    def _write(self) -> None:
        if self._waiting:
            try:
                del self._waiting[: os.write(self._ours, self._waiting[:_MOST_BYTES])]
            except BlockingIOError:
                return
