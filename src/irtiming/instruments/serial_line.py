"""A serial port that only this program uses: bytes out, bytes in, and a clear word when it is gone."""

import asyncio
from contextlib import suppress
from threading import Thread
from typing import Protocol, final

import serial
from serial.tools import list_ports

from irtiming.errors import InstrumentError, InstrumentSilent
from irtiming.gateware.register_map import BAUD

_WRITE_TIMEOUT_S = 2.0
_MOST_BYTES = 4096
_OF_SIMULATIONS = "/dev/pts/"


class Line(Protocol):
    """What a driver asks of its connection; `SerialLine`, or what a test puts in its place."""

    @property
    def name(self) -> str:
        """For messages."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes.

        Raises
        ------
        InstrumentSilent
            If the line is gone.
        """
        ...

    async def read(self) -> bytes:
        """Wait for the next bytes, in pieces of any size.

        Raises
        ------
        InstrumentSilent
            If the line is gone.
        """
        ...

    async def close(self) -> None:
        """Give the line back; again does no harm."""
        ...


@final
class SerialLine:
    """A serial port, opened by `open_line`. A thread reads it, so that it works the same on every system."""

    def __init__(self, port: serial.Serial) -> None:
        self._port = port
        self._arrived: asyncio.Queue[bytes | OSError] = asyncio.Queue()
        self._loop = asyncio.get_running_loop()
        self._is_open = True
        self._reader = Thread(target=self._read_port, name=f"reader of {self.name}", daemon=True)
        self._reader.start()

    @property
    def name(self) -> str:
        """Path of the port."""
        return str(self._port.port)

    def write(self, data: bytes) -> None:
        """Send bytes.

        Raises
        ------
        InstrumentSilent
            If the port is gone, or takes nothing for two seconds.
        """
        try:
            self._port.write(data)
        except OSError as error:
            raise self._gone(error) from error

    async def read(self) -> bytes:
        """Wait for the next bytes.

        Raises
        ------
        InstrumentSilent
            If the port is gone.
        """
        arrived = await self._arrived.get()
        if isinstance(arrived, OSError):
            self._arrived.put_nowait(arrived)  # it stays gone
            raise self._gone(arrived) from arrived
        return arrived

    async def close(self) -> None:
        """Give the port back; again does no harm."""
        if not self._is_open:
            return
        self._is_open = False
        with suppress(OSError):
            self._port.cancel_read()
        await asyncio.to_thread(self._reader.join)
        allow_others(self._port)
        with suppress(OSError):
            self._port.close()

    def _read_port(self) -> None:
        while self._is_open:
            arrived = self._next_bytes()
            if arrived and self._is_open:
                self._loop.call_soon_threadsafe(self._arrived.put_nowait, arrived)
            if isinstance(arrived, OSError):
                return

    def _next_bytes(self) -> bytes | OSError:
        try:
            first: bytes = self._port.read(1)
            waiting = min(self._port.in_waiting, _MOST_BYTES) if first else 0
            return first + self._port.read(waiting) if waiting else first
        except OSError as error:
            return error
        except TypeError:  # pyserial's word for a port that was closed while it read
            return OSError("the port was closed")

    def _gone(self, error: OSError) -> InstrumentSilent:
        return InstrumentSilent(
            f"the line to {self.name} is gone ({_reason(error)}); plug the device in again and repeat the run"
        )


async def open_line(port: str, *, baud: int = BAUD) -> SerialLine:
    """Open a serial port for this program alone.

    Parameters
    ----------
    port
        Its path or name, such as ``/dev/ttyUSB1`` or ``COM3``.
    baud
        Bits per second.

    Raises
    ------
    InstrumentError
        If there is no such port, this user may not open it, or another program has it.
    """
    try:
        opened = await asyncio.to_thread(
            serial.Serial, port, baud, timeout=None, write_timeout=_WRITE_TIMEOUT_S, exclusive=True
        )
    except (OSError, ValueError) as error:
        raise not_opened(port, error) from error
    refuse_others(opened)
    return SerialLine(opened)


def ports() -> list[str]:
    """Serial ports of this computer with what they say of themselves, one line each."""
    return [f"{port.device} ({port.description})" for port in sorted(list_ports.comports())]


def not_opened(port: str, error: Exception) -> InstrumentError:
    """Why a port could not be opened, and what to do.

    Parameters
    ----------
    port
        Its name.
    error
        What pyserial said.
    """
    number = error.errno if isinstance(error, OSError) else None
    text = str(error)
    if "exclusively lock" in text or number == 16 or "busy" in text.lower():
        return InstrumentError(f"{port} is used by another program; end that program, or name another port")
    if number == 13 or "denied" in text.lower():
        return InstrumentError(
            f"{port} may not be opened by this user, or another program has it; on Linux join the group that owns it "
            "(often dialout) and log in again"
        )
    there = ", ".join(ports()) or "none"
    return InstrumentError(f"{port} cannot be opened ({_reason(error)}); serial ports of this computer: {there}")


def _reason(error: Exception) -> str:
    """The innermost words of an error of pyserial."""
    text = str(error).rsplit("] ", 1)[-1]
    return "it gives no more bytes" if "returned no data" in text else text


def refuse_others(port: serial.Serial) -> None:
    """Make the system refuse the port to programs that know no locks; only where there are terminals.

    Not a pseudo-terminal: that of a simulated device lives on, and would stay closed when its user is killed.
    """
    if str(port.port).startswith(_OF_SIMULATIONS):
        return
    with suppress(ImportError, OSError):
        from fcntl import ioctl
        from termios import TIOCEXCL

        ioctl(port.fileno(), TIOCEXCL)


def allow_others(port: serial.Serial) -> None:
    """Take back what `refuse_others` did."""
    with suppress(ImportError, OSError):
        from fcntl import ioctl
        from termios import TIOCNXCL

        ioctl(port.fileno(), TIOCNXCL)
