"""A line to an instrument that speaks in texts: serial port, TCP, UDP, or whatever PyVISA reaches.

Serial ports and sockets are opened here and not by PyVISA: a port must be ours alone, and PyVISA takes a refused
connection for an open one. `TextAdapter` makes each of them an adapter for the instruments of pymeasure.
"""

import asyncio
import re
import socket
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from time import monotonic, sleep
from typing import Protocol, TypeVar, final
from urllib.parse import parse_qsl

import pyvisa
import serial
from pymeasure.adapters import Adapter, VISAAdapter

from irtiming.errors import InstrumentError, InstrumentSilent
from irtiming.instruments.serial_line import allow_others, not_opened, refuse_others
from irtiming.units import plain_integer

T = TypeVar("T")
_CONNECT_S = 5.0
_WRITE_TIMEOUT_S = 2.0
_MOST_BYTES = 4096
_NAMES = "a serial port such as /dev/ttyUSB0 or COM3, tcp:HOST:PORT, udp:HOST:PORT, or a VISA resource name"


class Channel(Protocol):
    """Bytes out and bytes in; whichever wire it is. All errors are `InstrumentError`."""

    def send(self, data: bytes) -> None:
        """Send bytes."""
        ...

    def receive(self, timeout_s: float) -> bytes:
        """Bytes as they come; none if none came in time."""
        ...

    def close(self) -> None:
        """Give the line back; again does no harm."""
        ...


@final
@dataclass(frozen=True, kw_only=True)
class Speech:
    """How an instrument marks where a message ends, and how long its answer may take.

    ``ends`` are the characters of which any one ends an answer. Where ``quiet_s`` is given, an answer also ends when
    nothing more came for so long.
    """

    baud: int
    ending: str = "\r"
    ends: str = "\r\n"
    reply_s: float = 1.0
    quiet_s: float | None = None


class Unanswered(InstrumentSilent):
    """No whole answer came in time; ``arrived`` is what came of it."""

    def __init__(self, message: str, arrived: str) -> None:
        super().__init__(message)
        self.arrived = arrived


class TextAdapter(Adapter):  # type: ignore[misc]  # pymeasure has no types
    """Texts over a channel, each ended as the instrument's speech asks for; open it by `open_text_line`."""

    def __init__(self, channel: Channel, speech: Speech, *, line: str) -> None:
        super().__init__()
        self.connection = channel
        self.line = line
        self._speech = speech
        self._arrived = bytearray()
        self._end = re.compile(f"[{speech.ends}]".encode())

    def flush_read_buffer(self) -> None:
        """Forget what came without having been asked for."""
        self._arrived.clear()
        while self.connection.receive(0.0):
            pass

    def _write(self, command: str, **_: object) -> None:
        self._write_bytes((command + self._speech.ending).encode("latin-1"))

    def _write_bytes(self, content: bytes, **_: object) -> None:
        self.connection.send(content)

    def _read(self, *, timeout_s: float | None = None, **_: object) -> str:
        """Next answer without its end; `Unanswered` if there is none in time."""
        deadline = monotonic() + (self._speech.reply_s if timeout_s is None else timeout_s)
        while True:
            end = self._end.search(self._arrived)
            if end is not None:
                text = self._arrived[: end.start()].decode("latin-1")
                del self._arrived[: end.end()]
                return text
            left = deadline - monotonic()
            is_begun = self._speech.quiet_s is not None and bool(self._arrived)
            more = self.connection.receive(max(0.0, min(left, self._speech.quiet_s or 0.0) if is_begun else left))
            self._arrived += more
            if left > 0 and (more or not is_begun):
                continue
            text = self._arrived.decode("latin-1")
            self._arrived.clear()
            if is_begun and not more:
                return text
            raise Unanswered(f"{self.line} does not answer", text)

    def __repr__(self) -> str:
        return f"<TextAdapter({self.line!r})>"


@final
class Pace:
    """Keeps messages apart."""

    def __init__(self, gap_s: float) -> None:
        self._gap_s = gap_s
        self._last_s: float | None = None

    def wait(self) -> None:
        """Sleep until the gap since the last call is over."""
        if self._last_s is not None:
            sleep(max(0.0, self._last_s + self._gap_s - monotonic()))
        self._last_s = monotonic()


@final
class Worker:
    """One thread that makes all calls to an instrument, one after the other, and keeps the event loop free."""

    def __init__(self, name: str) -> None:
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix=name)

    async def do(self, call: Callable[[], T]) -> T:
        """Result of a call, made after those before it; one that was begun goes on when the caller is cancelled."""
        return await asyncio.get_running_loop().run_in_executor(self._pool, call)

    async def close(self) -> None:
        """Wait until the last call is over; again does no harm."""
        await asyncio.to_thread(self._pool.shutdown)


def split_options(address: str, known: tuple[str, ...]) -> tuple[str, dict[str, str]]:
    """Line and options of an address such as ``"/dev/ttyUSB0?blade=0&speed=20"``.

    Parameters
    ----------
    address
        As written by the user.
    known
        Names of the options that may be given.

    Raises
    ------
    InstrumentError
        If an option is none of these, or has no value.
    """
    line, mark, query = address.partition("?")
    options = dict(parse_qsl(query, keep_blank_values=True))
    for name, value in options.items():
        if name not in known or not value:
            raise InstrumentError(
                f"option {name}={value} of address {address!r} cannot be used; there are {', '.join(known)}, such as "
                f"{line}?{known[0]}=1"
            )
    if mark and not options:
        raise InstrumentError(f"address {address!r} ends in options that cannot be read; write NAME=VALUE&NAME=VALUE")
    return line, options


def speed_of(options: dict[str, str]) -> float:
    """Seconds of a simulated rig in one of the user's; 1 for a device of this world.

    Parameters
    ----------
    options
        Of an address.

    Raises
    ------
    InstrumentError
        If the option ``speed`` is no positive number.
    """
    text = options.get("speed", "1")
    with suppress(ValueError):
        if 0 < float(text) < float("inf"):
            return float(text)
    raise InstrumentError(f"speed={text} is no speed of a simulated rig; write a number above 0, such as speed=20")


def open_text_line(line: str, speech: Speech, *, reply_port: int = 0) -> TextAdapter:
    """Open a line for this program alone.

    Parameters
    ----------
    line
        Serial port, ``tcp:HOST:PORT``, ``udp:HOST:PORT`` or VISA resource name.
    speech
        Of the instrument.
    reply_port
        Port of this computer at which answers over UDP arrive; 0 for the one that the question was sent from.

    Raises
    ------
    InstrumentError
        If it cannot be opened, with the reason.
    """
    kind, _, rest = _plain(line).partition(":")
    channel: Channel
    if kind == "tcp":
        channel = _TcpChannel(*_host_and_port(rest, line), name=line)
    elif kind == "udp":
        channel = _UdpChannel(*_host_and_port(rest, line), name=line, reply_port=reply_port)
    elif "::" in line and kind != "serial":
        channel = VisaChannel(line)
    else:
        channel = _SerialChannel(rest if kind == "serial" else line, speech.baud)
    return TextAdapter(channel, speech, line=line)


def _plain(line: str) -> str:
    """Serial ports and sockets among the VISA names in our own words."""
    port = re.fullmatch(r"ASRL(.+?)(::INSTR)?", line, re.IGNORECASE)
    if port is not None:
        name, number = port[1], plain_integer(port[1])
        if number is not None:
            name = f"COM{number}" if sys.platform == "win32" else f"/dev/ttyS{number - 1}"
        return f"serial:{name}"
    host = re.fullmatch(r"TCPIP\d*::(.+)::(\d+)::SOCKET", line, re.IGNORECASE)
    return f"tcp:{host[1]}:{host[2]}" if host is not None else line


def _host_and_port(text: str, line: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not host or not 0 < (plain_integer(port) or 0) < 2**16:
        raise InstrumentError(f"{line!r} is no line; write {_NAMES}, with a port from 1 to 65535")
    return host.strip("[]"), int(port)


@final
class _SerialChannel:
    def __init__(self, port: str, baud: int) -> None:
        try:
            self._port = serial.Serial(port, baud, timeout=0, write_timeout=_WRITE_TIMEOUT_S, exclusive=True)
        except (OSError, ValueError) as error:
            raise not_opened(port, error) from error
        refuse_others(self._port)
        self._name = port

    def send(self, data: bytes) -> None:
        try:
            self._port.write(data)
        except OSError as error:
            raise self._gone() from error

    def receive(self, timeout_s: float) -> bytes:
        try:
            self._port.timeout = timeout_s
            first: bytes = self._port.read(1)
            waiting = min(self._port.in_waiting, _MOST_BYTES) if first else 0
            return first + self._port.read(waiting) if waiting else first
        except (OSError, TypeError) as error:  # the latter is pyserial's word for a port that was closed meanwhile
            raise self._gone() from error

    def close(self) -> None:
        if self._port.is_open:
            allow_others(self._port)
            with suppress(OSError):
                self._port.close()

    def _gone(self) -> InstrumentSilent:
        return InstrumentSilent(f"the line to {self._name} is gone; plug the device in again and repeat the run")


@final
class _TcpChannel:
    def __init__(self, host: str, port: int, *, name: str) -> None:
        self._name = name
        try:
            self._socket = socket.create_connection((host, port), timeout=_CONNECT_S)
        except OSError as error:
            raise _not_connected(name, host, error) from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def send(self, data: bytes) -> None:
        try:
            self._socket.settimeout(_WRITE_TIMEOUT_S)
            self._socket.sendall(data)
        except OSError as error:
            raise self._gone() from error

    def receive(self, timeout_s: float) -> bytes:
        self._socket.settimeout(max(timeout_s, 1e-3))
        try:
            arrived = self._socket.recv(_MOST_BYTES)
        except TimeoutError:
            return b""
        except OSError as error:
            raise self._gone() from error
        if not arrived:
            raise self._gone()
        return arrived

    def close(self) -> None:
        self._socket.close()

    def _gone(self) -> InstrumentSilent:
        return InstrumentSilent(
            f"{self._name} has closed the connection; see that no other program uses it, and try again"
        )


@final
class _UdpChannel:
    """Messages without an end of their own: each datagram is one."""

    def __init__(self, host: str, port: int, *, name: str, reply_port: int) -> None:
        self._name = name
        try:
            self._host = socket.gethostbyname(host)
            here = _address_towards(self._host, port)
        except OSError as error:
            raise _not_connected(name, host, error) from error
        self._port = port
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((here, reply_port))
        except OSError as error:
            self._socket.close()
            raise InstrumentError(
                f"answers of {name} come to UDP port {reply_port} of this computer, which another program uses; end that "
                "program, or give ?reply_port=PORT as set in the device"
            ) from error

    def send(self, data: bytes) -> None:
        try:
            self._socket.sendto(data.rstrip(b"\r\n"), (self._host, self._port))
        except OSError as error:
            raise _not_connected(self._name, self._host, error) from error

    def receive(self, timeout_s: float) -> bytes:
        deadline = monotonic() + timeout_s
        while True:
            self._socket.settimeout(max(deadline - monotonic(), 1e-3))
            try:
                arrived, sender = self._socket.recvfrom(_MOST_BYTES)
            except TimeoutError:
                return b""
            except OSError as error:
                raise _not_connected(self._name, self._host, error) from error
            if sender[0] == self._host:
                return arrived.rstrip(b"\r\n") + b"\r"

    def close(self) -> None:
        self._socket.close()


@final
class VisaChannel:
    """What PyVISA reaches: GPIB and USB, with the library of its vendor or, without one, by pyvisa-py."""

    def __init__(self, name: str) -> None:
        self._name = name
        try:
            self._visa = VISAAdapter(name, visa_library="@py", open_timeout=int(1000 * _CONNECT_S))
        except Exception as error:  # PyVISA's backends raise whatever their libraries raise
            raise InstrumentError(f"{name} cannot be opened by PyVISA ({_words(error)}); write {_NAMES}") from error

    def send(self, data: bytes) -> None:
        """Send bytes."""
        try:
            self._visa.write_bytes(data)
        except (pyvisa.Error, OSError) as error:
            raise self._gone(error) from error

    def receive(self, timeout_s: float) -> bytes:
        """One byte, or none if none came in time: a longer read would lose what came before its timeout."""
        self._visa.connection.timeout = max(1, round(1000 * timeout_s))
        try:
            return bytes(self._visa.read_bytes(1))
        except pyvisa.VisaIOError as error:
            if error.error_code == pyvisa.constants.StatusCode.error_timeout:
                return b""
            raise self._gone(error) from error
        except OSError as error:
            raise self._gone(error) from error

    def close(self) -> None:
        """Give the line back; again does no harm."""
        with suppress(pyvisa.Error, OSError):
            self._visa.close()

    def _gone(self, error: Exception) -> InstrumentSilent:
        return InstrumentSilent(f"the line to {self._name} is gone ({_words(error)}); see to its cable and try again")


def _address_towards(host: str, port: int) -> str:
    """Address of this computer from which it reaches a host: what comes in by other networks is not heard."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect((host, port))
        return str(probe.getsockname()[0])


def _not_connected(name: str, host: str, error: OSError) -> InstrumentError:
    if isinstance(error, socket.gaierror):
        return InstrumentError(f"{name}: no host is called {host!r}; write its IP address")
    if isinstance(error, ConnectionRefusedError):
        return InstrumentError(
            f"{name} refuses the connection; see that the device is on, its port right and no other program in it"
        )
    if isinstance(error, TimeoutError):
        return InstrumentError(
            f"{name} does not answer within {_CONNECT_S:g} s; see that the device is on and in this network"
        )
    return InstrumentError(f"{name} cannot be reached ({_words(error)}); see that the device is on and in this network")


def _words(error: Exception) -> str:
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return " ".join(text.split()) or type(error).__name__
