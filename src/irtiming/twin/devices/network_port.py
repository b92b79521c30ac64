"""Simulated devices behind a network port of this computer, as `gateware.pseudo_terminal` has them behind a serial one."""

import select
import socket
from abc import ABC, abstractmethod
from contextlib import suppress
from threading import Event, Thread
from time import monotonic
from types import TracebackType
from typing import Self, final

from irtiming.errors import InstrumentError
from irtiming.gateware.model_device import SimulatedDevice

_TICK_S = 0.005
_MOST_BYTES = 4096


class _Port(ABC):
    """Serves a device in a thread of its own while its ``with`` block runs."""

    def __init__(self, device: SimulatedDevice, kind: socket.SocketKind, *, host: str, port: int, speed: float) -> None:
        self._device = device
        self._rate = device.clock_frequency_hz * speed
        self._socket = socket.socket(socket.AF_INET, kind)
        try:
            if kind is socket.SOCK_STREAM:
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            raise InstrumentError(
                f"{host}:{port} cannot be served ({error.strerror}); end the program that uses it, or take port 0"
            ) from error
        self._host, self._port = self._socket.getsockname()[:2]
        self._is_over = Event()
        self._failure: BaseException | None = None
        self._thread = Thread(target=self._serve, name=f"device at {self._host}:{self._port}", daemon=True)

    @property
    def host(self) -> str:
        """IP address."""
        return str(self._host)

    @property
    def port(self) -> int:
        """Number of the port."""
        return int(self._port)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._is_over.set()
        self._thread.join()
        if self._failure is not None and error is None:
            raise self._failure

    def _serve(self) -> None:
        try:
            with self._socket:
                begun = monotonic()
                while not self._is_over.is_set():
                    self._turn(int((monotonic() - begun) * self._rate))
        except BaseException as error:  # given on to whoever ends the block
            self._failure = error

    def _exchange(self, received: bytes, cycle: int) -> bytes:
        """The device brought to a cycle, and what it says to what it hears then."""
        return self._device.exchange(b"", until_cycle=cycle) + self._device.exchange(received, until_cycle=cycle)

    @abstractmethod
    def _turn(self, cycle: int) -> None:
        """Wait a moment for bytes, and pass them on at a cycle."""


@final
class TcpPort(_Port):
    """A device that one computer at a time can connect to.

    Parameters
    ----------
    device
        The model.
    host, port
        Where; port 0 for any that is free.
    speed
        Seconds of the device in one of the user's.

    Raises
    ------
    InstrumentError
        If the port is taken.
    """

    def __init__(self, device: SimulatedDevice, *, host: str = "127.0.0.1", port: int = 0, speed: float = 1.0) -> None:
        super().__init__(device, socket.SOCK_STREAM, host=host, port=port, speed=speed)
        self._socket.listen(1)
        self._user: socket.socket | None = None

    def _serve(self) -> None:
        super()._serve()
        self._hang_up()

    def _turn(self, cycle: int) -> None:
        ready, _, _ = select.select([self._user or self._socket], [], [], _TICK_S)
        received = b""
        if ready and self._user is None:
            self._user, _ = self._socket.accept()
        elif ready and self._user is not None:
            with suppress(ConnectionError):
                received = self._user.recv(_MOST_BYTES)
            if not received:
                self._hang_up()
        sent = self._exchange(received, cycle)
        if sent and self._user is not None:
            try:
                self._user.sendall(sent)
            except ConnectionError:
                self._hang_up()

    def _hang_up(self) -> None:
        if self._user is not None:
            self._user.close()
            self._user = None


@final
class UdpPort(_Port):
    """A device to which each datagram is one message, without an end of its own.

    Parameters
    ----------
    device
        The model; on its side messages end in a carriage return.
    host, port
        Where; port 0 for any that is free.
    reply_port
        Of the computer, to which it answers; 0 for the one that asked.
    speed
        Seconds of the device in one of the user's.

    Raises
    ------
    InstrumentError
        If the port is taken.
    """

    def __init__(
        self,
        device: SimulatedDevice,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        reply_port: int = 5100,
        speed: float = 1.0,
    ) -> None:
        super().__init__(device, socket.SOCK_DGRAM, host=host, port=port, speed=speed)
        self._reply_port = reply_port
        self._asker: tuple[str, int] | None = None

    def _turn(self, cycle: int) -> None:
        ready, _, _ = select.select([self._socket], [], [], _TICK_S)
        received = b""
        if ready:
            received, sender = self._socket.recvfrom(_MOST_BYTES)
            received = received.rstrip(b"\r\n") + b"\r"
            self._asker = (sender[0], self._reply_port or sender[1])
        for message in self._exchange(received, cycle).split(b"\r"):
            if message and self._asker is not None:
                with suppress(OSError):  # no one has to listen
                    self._socket.sendto(message, self._asker)
