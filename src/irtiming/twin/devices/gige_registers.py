"""Registers of the simulated GigE Vision camera: the standard's bootstrap registers, the camera's own, and its XML.

Words have 32 bits and are big-endian; addresses are bytes. The camera's own registers are those that
``gige_camera.xml`` names.
"""

import struct
from dataclasses import dataclass
from enum import IntEnum
from importlib.resources import files
from ipaddress import IPv4Address
from typing import final

from irtiming.records.camera_frame import SIMULATED_VENDOR

XML_ADDRESS = 0xA0000
_XML_NAME = "irtiming_twin_camera.xml"
_MEMORY_BYTES = 0x9000
DISCOVERY_BYTES = 0xF8

MONO8, MONO16 = 0x01080001, 0x01100007


class Address(IntEnum):
    """Of registers that the camera itself reads or writes."""

    VERSION = 0x0000
    DEVICE_MODE = 0x0004
    MAC_HIGH = 0x0008
    MAC_LOW = 0x000C
    IP_CAPABILITY = 0x0010
    IP_CONFIGURATION = 0x0014
    IP_ADDRESS = 0x0024
    SUBNET_MASK = 0x0034
    GATEWAY = 0x0044
    MANUFACTURER = 0x0048
    MODEL = 0x0068
    DEVICE_VERSION = 0x0088
    MANUFACTURER_INFO = 0x00A8
    SERIAL_NUMBER = 0x00D8
    USER_NAME = 0x00E8
    FIRST_URL = 0x0200
    SECOND_URL = 0x0400
    INTERFACES = 0x0600
    MESSAGE_CHANNELS = 0x0900
    STREAM_CHANNELS = 0x0904
    GVCP_CAPABILITY = 0x0934
    HEARTBEAT_TIMEOUT = 0x0938
    TICK_FREQUENCY_HIGH = 0x093C
    TICK_FREQUENCY_LOW = 0x0940
    TIMESTAMP_CONTROL = 0x0944
    TIMESTAMP_HIGH = 0x0948
    TIMESTAMP_LOW = 0x094C
    CONTROL_PRIVILEGE = 0x0A00
    STREAM_PORT = 0x0D00
    PACKET_SIZE = 0x0D04
    PACKET_DELAY = 0x0D08
    STREAM_ADDRESS = 0x0D18
    STREAM_SOURCE_PORT = 0x0D1C
    STREAM_CAPABILITY = 0x0D20

    SENSOR_WIDTH = 0x8000
    SENSOR_HEIGHT = 0x8004
    WIDTH = 0x8008
    HEIGHT = 0x800C
    OFFSET_X = 0x8010
    OFFSET_Y = 0x8014
    PIXEL_FORMAT = 0x8018
    HIGHEST_VALUE = 0x801C
    IS_ROLLING = 0x8020
    ACQUISITION_MODE = 0x8100
    ACQUISITION_START = 0x8104
    ACQUISITION_STOP = 0x8108
    FRAME_COUNT = 0x810C
    FRAME_RATE = 0x8110
    TRIGGER_MODE = 0x8114
    TRIGGER_SOURCE = 0x8118
    TRIGGER_ACTIVATION = 0x811C
    TRIGGER_SOFTWARE = 0x8120
    EXPOSURE_TIME = 0x8124
    HAS_EXPOSURE_TIME = 0x8128
    TRIGGER_SELECTOR = 0x8130
    TEMPERATURE = 0x8200


class Refusal(IntEnum):
    """Status of an answer that says no."""

    NOT_IMPLEMENTED = 0x8001
    INVALID_PARAMETER = 0x8002
    INVALID_ADDRESS = 0x8003
    WRITE_PROTECT = 0x8004
    BAD_ALIGNMENT = 0x8005
    ACCESS_DENIED = 0x8006
    INVALID_HEADER = 0x800E


class RefusedError(Exception):
    """An access that the camera answers with a status, not with data."""

    def __init__(self, status: Refusal) -> None:
        super().__init__(status.name)
        self.status = status


_TEXTS = {
    Address.MANUFACTURER: 32,
    Address.MODEL: 32,
    Address.DEVICE_VERSION: 32,
    Address.MANUFACTURER_INFO: 48,
    Address.SERIAL_NUMBER: 16,
    Address.USER_NAME: 16,
    Address.FIRST_URL: 512,
    Address.SECOND_URL: 512,
}

_LOCKED_WHILE_ACQUIRING = frozenset(
    {
        Address.WIDTH, Address.HEIGHT, Address.OFFSET_X, Address.OFFSET_Y, Address.PIXEL_FORMAT, Address.ACQUISITION_MODE,
        Address.FRAME_COUNT, Address.FRAME_RATE, Address.TRIGGER_MODE, Address.TRIGGER_SOURCE, Address.TRIGGER_ACTIVATION,
        Address.EXPOSURE_TIME,
    }
)  # fmt: skip

COMMANDS = frozenset(
    {Address.TIMESTAMP_CONTROL, Address.ACQUISITION_START, Address.ACQUISITION_STOP, Address.TRIGGER_SOFTWARE}
)
_WRITABLE = _LOCKED_WHILE_ACQUIRING | COMMANDS | {
    Address.HEARTBEAT_TIMEOUT, Address.CONTROL_PRIVILEGE, Address.STREAM_PORT, Address.PACKET_SIZE, Address.PACKET_DELAY,
    Address.STREAM_ADDRESS, Address.TRIGGER_SELECTOR,
}  # fmt: skip

FIRE_TEST_PACKET, DO_NOT_FRAGMENT, BIG_ENDIAN = 1 << 31, 1 << 30, 1 << 29
_SMALLEST_PACKET, _LARGEST_PACKET = 220, 9000
_SHORTEST_HEARTBEAT_MS = 500
_SMALLEST_IMAGE = 16

_CAN = 1 << 0 | 1 << 1 | 1 << 2 | 1 << 30 | 1 << 31
"""Several registers in one command, memory writes, packet resend, serial number, user's name."""


@final
@dataclass(frozen=True, kw_only=True)
class Identity:
    """What the camera says of itself and of its detector. ``integration_time_s`` is None where it is no feature."""

    address: str
    serial_number: str
    model: str
    rows: int
    columns: int
    highest_value: int
    is_rolling: bool
    integration_time_s: float | None
    timestamp_frequency_hz: int


@final
class Registers:
    """The memory of the camera as clients see it, with what may be written and what it may hold."""

    def __init__(self, identity: Identity) -> None:
        self._memory = bytearray(_MEMORY_BYTES)
        self._xml = files("irtiming.twin.devices").joinpath("gige_camera.xml").read_bytes()
        self._identity = identity
        self._fill(identity)

    def word(self, address: int) -> int:
        """Value of a register."""
        return int.from_bytes(self._memory[address : address + 4])

    def number(self, address: int) -> float:
        """Value of a register that holds a float."""
        (value,) = struct.unpack(">f", self._memory[address : address + 4])
        return float(value)

    def put(self, address: int, value: int) -> None:
        """Set a register from within the camera."""
        self._memory[address : address + 4] = (value & 0xFFFFFFFF).to_bytes(4)

    def put_number(self, address: int, value: float) -> None:
        """Set a register that holds a float from within the camera."""
        self._memory[address : address + 4] = struct.pack(">f", value)

    def put_long(self, address: int, value: int) -> None:
        """Set a pair of registers, the upper word first, from within the camera."""
        self.put(address, value >> 32)
        self.put(address + 4, value)

    def discovery(self) -> bytes:
        """What the camera answers who it is: its first registers."""
        return bytes(self._memory[:DISCOVERY_BYTES])

    def read(self, address: int, size: int) -> bytes:
        """Bytes of whole words that a client reads.

        Raises
        ------
        RefusedError
            If there is nothing at the address, or it or the size is no multiple of 4.
        """
        if address % 4 or size % 4:
            raise RefusedError(Refusal.BAD_ALIGNMENT)
        if address >= XML_ADDRESS and address + size <= XML_ADDRESS + len(self._xml) + 3:
            first = address - XML_ADDRESS
            return self._xml[first : first + size].ljust(size, b"\0")
        if not all(_is_there(word) for word in range(address, address + size, 4)):
            raise RefusedError(Refusal.INVALID_ADDRESS)
        return bytes(self._memory[address : address + size])

    def write(self, address: int, value: int, *, is_acquiring: bool) -> None:
        """Set a register as a client asks for; what a command does is not done here.

        Parameters
        ----------
        address, value
            Of the register.
        is_acquiring
            Whether frames are under way: then most are locked.

        Raises
        ------
        RefusedError
            If it may not be written now, or not to this value.
        """
        if address % 4:
            raise RefusedError(Refusal.BAD_ALIGNMENT)
        in_user_name = Address.USER_NAME <= address < Address.USER_NAME + _TEXTS[Address.USER_NAME]
        if not _is_there(address):
            raise RefusedError(Refusal.INVALID_ADDRESS)
        if not in_user_name and (address not in _WRITABLE or (is_acquiring and address in _LOCKED_WHILE_ACQUIRING)):
            raise RefusedError(Refusal.WRITE_PROTECT)
        if not in_user_name and not self._can_hold(Address(address), value):
            raise RefusedError(Refusal.INVALID_PARAMETER)
        if address == Address.HEARTBEAT_TIMEOUT:
            value = max(value, _SHORTEST_HEARTBEAT_MS)
        if address == Address.PACKET_SIZE:
            value &= ~FIRE_TEST_PACKET
        if address not in COMMANDS:
            self.put(address, value)

    def _can_hold(self, address: Address, value: int) -> bool:
        (number,) = struct.unpack(">f", value.to_bytes(4))
        image = self._identity
        columns, rows = image.columns, image.rows
        check = {
            Address.WIDTH: _SMALLEST_IMAGE <= value <= columns - self.word(Address.OFFSET_X),
            Address.HEIGHT: _SMALLEST_IMAGE <= value <= rows - self.word(Address.OFFSET_Y),
            Address.OFFSET_X: value <= columns - self.word(Address.WIDTH),
            Address.OFFSET_Y: value <= rows - self.word(Address.HEIGHT),
            Address.PIXEL_FORMAT: value in (MONO8, MONO16),
            Address.ACQUISITION_MODE: value <= 2,
            Address.FRAME_COUNT: 1 <= value <= 0xFFFF,
            Address.FRAME_RATE: 0.1 <= number <= 1000,
            Address.TRIGGER_MODE: value <= 1,
            Address.TRIGGER_SOURCE: value <= 1,
            Address.TRIGGER_ACTIVATION: value == 0,
            Address.TRIGGER_SELECTOR: value == 0,
            Address.EXPOSURE_TIME: image.integration_time_s is not None and 1 <= number <= 10_000,
            Address.CONTROL_PRIVILEGE: value <= 3,
            Address.STREAM_PORT: value <= 0xFFFF,
            Address.PACKET_SIZE: _SMALLEST_PACKET <= value & 0xFFFF <= _LARGEST_PACKET and value % 4 == 0,
        }
        return check.get(address, True)

    def _fill(self, identity: Identity) -> None:
        ip = int(IPv4Address(identity.address))
        words = {
            Address.VERSION: 0x0001_0002,
            Address.DEVICE_MODE: 1 << 31 | 1,  # big-endian registers, UTF-8
            Address.MAC_HIGH: 0x0200,  # an address without an owner
            Address.MAC_LOW: ip,
            Address.IP_CAPABILITY: 1 << 0 | 1 << 2,
            Address.IP_CONFIGURATION: 1 << 0 | 1 << 2,
            Address.IP_ADDRESS: ip,
            Address.SUBNET_MASK: 0xFF00_0000,
            Address.INTERFACES: 1,
            Address.STREAM_CHANNELS: 1,
            Address.GVCP_CAPABILITY: _CAN,
            Address.HEARTBEAT_TIMEOUT: 3000,
            Address.PACKET_SIZE: 1400,
            Address.SENSOR_WIDTH: identity.columns,
            Address.SENSOR_HEIGHT: identity.rows,
            Address.WIDTH: identity.columns,
            Address.HEIGHT: identity.rows,
            Address.PIXEL_FORMAT: MONO16,
            Address.HIGHEST_VALUE: identity.highest_value,
            Address.IS_ROLLING: int(identity.is_rolling),
            Address.FRAME_COUNT: 1,
            Address.HAS_EXPOSURE_TIME: int(identity.integration_time_s is not None),
        }
        for address, value in words.items():
            self.put(address, value)
        self.put_long(Address.TICK_FREQUENCY_HIGH, identity.timestamp_frequency_hz)
        self.put_number(Address.FRAME_RATE, 30.0)
        self.put_number(Address.EXPOSURE_TIME, (identity.integration_time_s or 0.0) * 1e6)
        self.put_number(Address.TEMPERATURE, 35.0)
        texts = {
            Address.MANUFACTURER: SIMULATED_VENDOR,
            Address.MODEL: identity.model,
            Address.DEVICE_VERSION: "1.0",
            Address.MANUFACTURER_INFO: "simulated camera of the digital twin",
            Address.SERIAL_NUMBER: identity.serial_number,
            Address.FIRST_URL: f"Local:{_XML_NAME};{XML_ADDRESS:X};{len(self._xml):X}",
        }
        for address, text in texts.items():
            size = _TEXTS[address]
            self._memory[address : address + size] = text.encode()[: size - 1].ljust(size, b"\0")


_WORDS = frozenset(Address) | {
    word for first, size in _TEXTS.items() for word in range(first, first + size, 4)
}  # fmt: skip


def _is_there(address: int) -> bool:
    """Whether there is a register; what the standard reserves among the first of them reads as 0."""
    return address in _WORDS or 0 <= address < DISCOVERY_BYTES
