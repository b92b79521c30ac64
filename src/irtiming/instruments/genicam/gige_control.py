"""Control channel of a GigE Vision camera: registers, description, and the heartbeat that shows that both ends live."""

import lzma
import socket
import struct
import time
import zipfile
import zlib
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from threading import RLock
from typing import final

from pyGigEVision import GVCPClient, GVCPError

from irtiming.errors import InstrumentError, InstrumentRefused, InstrumentSilent
from irtiming.records.camera_frame import CameraIdentity

GVCP_PORT = 3956
_ACCESS_DENIED, _WRITE_PROTECTED, _BAD_ADDRESS = 0x8006, 0x8004, 0x8003
_CONTROL, _CONTROL_BIT = 0x0A00, 0x2
_CAPABILITY, _HEARTBEAT_TIMEOUT = 0x0934, 0x0938
_TICK_FREQUENCY_HIGH, _TICK_FREQUENCY_LOW = 0x093C, 0x0940
_DESCRIPTION_PLACES, _PLACE_BYTES = (0x0200, 0x0400), 512
_VENDOR, _MODEL, _FIRMWARE, _SERIAL = (0x0048, 32), (0x0068, 32), (0x0088, 32), (0x00D8, 16)
_RESEND_CAPABILITY = 0x4
_LONGEST_SILENCE_MS = 5000  # the library is heard every 2 s, of 3 by the standard: a busy computer needs more room
_STALE_CONTROL_S = 7.0  # a program that died keeps control until its heartbeat is missed
_LONGEST_DESCRIPTION = 64 * 2**20
_ZIP_ERRORS = (
    zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, IndexError, NotImplementedError, RuntimeError, OSError, ValueError,
)  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class DescriptionPlace:
    """Where in its memory a camera keeps its description."""

    file: str
    address: int
    length: int


def parse_place(text: str) -> DescriptionPlace:
    """Place of the description as the camera writes it; numbers are hexadecimal whether or not they look so.

    Parameters
    ----------
    text
        Such as ``"Local:camera.zip;10000;3e67?SchemaVersion=1.1.0"``.

    Raises
    ------
    InstrumentRefused
        If the text is something else, such as an address in the internet.
    """
    kind, _, rest = text.split("?")[0].partition(":")
    parts = rest.lstrip("/").split(";")
    try:
        file, address, length = parts[0], int(parts[1], 16), int(parts[2], 16)
    except (IndexError, ValueError) as error:
        raise InstrumentRefused(f"the camera's description is not in its memory, but at {text!r}") from error
    if kind.lower() != "local" or not 0 < length <= _LONGEST_DESCRIPTION:
        raise InstrumentRefused(f"the camera's description is not in its memory, but at {text!r}")
    return DescriptionPlace(file=file, address=address, length=length)


def unpacked(content: bytes) -> str:
    """Description as text, out of its ZIP archive where it is in one.

    Parameters
    ----------
    content
        As it is in the camera's memory.

    Raises
    ------
    InstrumentRefused
        If the archive is damaged or empty, or holds more than any description.
    """
    if content.startswith(b"PK"):
        try:
            with zipfile.ZipFile(BytesIO(content)) as archive, archive.open(archive.namelist()[0]) as file:
                content = file.read(_LONGEST_DESCRIPTION + 1)
        except _ZIP_ERRORS as error:
            raise InstrumentRefused(f"the camera's description is a damaged ZIP archive ({error})") from error
    if len(content) > _LONGEST_DESCRIPTION:
        raise InstrumentRefused(f"the camera's description has more than {_LONGEST_DESCRIPTION} bytes, which none has")
    return content.rstrip(b"\0").decode("utf-8-sig", errors="replace")


@final
class GigeControl:
    """Registers of a camera under this program's control; all calls block, and may come from several threads."""

    def __init__(self, host: str) -> None:
        self.address = _resolved(host)
        self.name = f"camera {host}"
        self._client = GVCPClient(self.address)
        self._lock = RLock()
        self._is_gone = False
        self._found_silence_ms = 0

    def open(self) -> None:
        """Take control.

        Raises
        ------
        InstrumentSilent
            If nothing answers.
        InstrumentRefused
            If another program controls the camera.
        """
        until = time.monotonic() + _STALE_CONTROL_S
        while True:
            try:
                self._client.connect(force=False)
                self._allow_silence()
                return
            except GVCPError as error:
                if error.status != _ACCESS_DENIED:
                    raise self._explained(error, "control") from error
                if time.monotonic() > until:
                    raise InstrumentRefused(
                        f"{self.name} is controlled by another program; end that program"
                    ) from error
                time.sleep(0.5)
            except OSError as error:
                raise InstrumentSilent(f"{self.name} cannot be reached ({error}); check cable and addresses") from error

    def register(self, address: int) -> int:
        """Value of a register of 32 bits.

        Parameters
        ----------
        address
            Of its first byte.
        """
        return struct.unpack(">I", self.read(address, 4))[0]

    def set_register(self, address: int, value: int) -> None:
        """Set a register of 32 bits.

        Parameters
        ----------
        address
            Of its first byte.
        value
            From 0 on.
        """
        self.write(address, struct.pack(">I", value))

    def read(self, address: int, length: int) -> bytes:
        """Bytes from an address on; a register of 32 bits as such, since some cameras give it in no other way.

        Parameters
        ----------
        address
            Of the first byte.
        length
            Bytes.
        """
        self._require_there()
        try:
            with self._lock:
                if length == 4 and address % 4 == 0:
                    return struct.pack(">I", self._client.read_reg(address))
                return self._client.read_mem(address, length)
        except (GVCPError, OSError, AttributeError, struct.error) as error:
            raise self._explained(error, f"reading at {address:#x}") from error

    def write(self, address: int, data: bytes) -> None:
        """Set bytes from an address on, 4 at a time.

        Parameters
        ----------
        address
            Of the first byte.
        data
            A multiple of 4 bytes.

        Raises
        ------
        InstrumentError
            If they are no fours, or the camera does not take them.
        """
        if len(data) % 4:
            raise InstrumentRefused(f"{self.name}: {len(data)} bytes cannot be written at {address:#x}, only fours")
        self._require_there()
        try:
            with self._lock:
                for offset in range(0, len(data), 4):
                    self._client.write_reg(address + offset, struct.unpack_from(">I", data, offset)[0])
        except (GVCPError, OSError, AttributeError) as error:
            raise self._explained(error, f"writing at {address:#x}") from error

    def description(self) -> str:
        """The camera's own description of its features, XML.

        Raises
        ------
        InstrumentRefused
            If it has none that can be read.
        """
        problem = InstrumentRefused(
            f"{self.name} does not describe its features: it is no GenICam camera; check the address"
        )
        for place in _DESCRIPTION_PLACES:
            text = self.read(place, _PLACE_BYTES).split(b"\0")[0].decode("ascii", errors="replace")
            try:
                found = parse_place(text)
                return unpacked(self.read(found.address, found.length))
            except InstrumentRefused as error:
                problem = InstrumentRefused(f"{self.name}: {error}") if text else problem
        raise problem

    def identity(self) -> CameraIdentity:
        """What the camera says of itself."""

        def text(place: tuple[int, int]) -> str:
            return self.read(*place).split(b"\0")[0].decode("ascii", errors="replace").strip()

        return CameraIdentity(
            vendor=text(_VENDOR),
            model=text(_MODEL),
            firmware=text(_FIRMWARE),
            serial_number=text(_SERIAL),
            address=f"gige:{self.address}",
        )

    def tick_frequency_hz(self) -> float:
        """Of the camera's clock; 0 where it has none."""
        return float((self.register(_TICK_FREQUENCY_HIGH) << 32) + self.register(_TICK_FREQUENCY_LOW))

    def can_resend(self) -> bool:
        """Whether the camera sends a lost packet again."""
        return bool(self.register(_CAPABILITY) & _RESEND_CAPABILITY)

    def heartbeat_s(self) -> float:
        """How often this program must be heard: a third of what the camera waits for, at most 1 s."""
        return min(1.0, max(self.register(_HEARTBEAT_TIMEOUT), 500) / 3000)

    def require_control(self) -> None:
        """Nothing, if the camera answers and this program still controls it; the heartbeat.

        Raises
        ------
        InstrumentSilent
            If not.
        """
        try:
            is_controlled = bool(self.register(_CONTROL) & _CONTROL_BIT)
        except InstrumentSilent:
            self._is_gone = True  # whatever is asked from now on would only wait
            raise
        if not is_controlled:
            raise InstrumentSilent(
                f"{self.name} no longer knows that this program controls it: it was switched off and on, or another program "
                "took it; connect again"
            )

    def close(self) -> None:
        """Give up control; again does no harm."""
        if self._found_silence_ms:
            with suppress(InstrumentError):
                self.set_register(_HEARTBEAT_TIMEOUT, self._found_silence_ms)
            self._found_silence_ms = 0
        with self._lock, suppress(OSError, GVCPError):
            self._client.disconnect()

    def _allow_silence(self) -> None:
        """Let the camera wait longer for this program's heartbeat, if it takes that; `close` sets it back."""
        with suppress(InstrumentError):
            found_ms = self.register(_HEARTBEAT_TIMEOUT)
            if found_ms < _LONGEST_SILENCE_MS:
                self.set_register(_HEARTBEAT_TIMEOUT, _LONGEST_SILENCE_MS)
                self._found_silence_ms = found_ms

    def _require_there(self) -> None:
        if self._is_gone:
            raise self._silent()

    def _silent(self) -> InstrumentSilent:
        return InstrumentSilent(
            f"{self.name} does not answer; check its cable and power, and that its address is in a network of this computer "
            "(irtiming discover lists those that answer)"
        )

    def _explained(self, error: Exception, doing: str) -> InstrumentError:
        status = error.status if isinstance(error, GVCPError) else None
        if status == 0 or isinstance(error, OSError):
            return self._silent()
        if isinstance(error, AttributeError):  # the library's word for a channel that was closed
            return InstrumentSilent(f"{self.name} was closed")
        if status in (_ACCESS_DENIED, _WRITE_PROTECTED):
            return InstrumentRefused(
                f"{self.name} denies {doing}: it is read-only now, or another program controls the camera"
            )
        if status == _BAD_ADDRESS:
            return InstrumentRefused(f"{self.name} denies {doing}: it has no such register")
        return InstrumentRefused(f"{self.name} denies {doing} ({getattr(error, 'status_name', error)})")


def _resolved(host: str) -> str:
    """Numbers of an address; a name is looked up."""
    try:
        return socket.gethostbyname(host)
    except OSError as error:
        raise InstrumentError(
            f"{host!r} is no address of a camera ({error}); write it as in gige:192.168.0.7"
        ) from error


def local_address(camera_address: str) -> str:
    """Address of this computer by which a camera reaches it.

    Parameters
    ----------
    camera_address
        In numbers.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect((camera_address, GVCP_PORT))
        return str(probe.getsockname()[0])
