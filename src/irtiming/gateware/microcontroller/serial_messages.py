"""The bytes of the serial line: check sum, replies, records, and the reader of commands.

Runs on MicroPython and on CPython. Tests hold it against irtiming.gateware.messages byte for byte.
"""

import struct
from array import array

COMMAND_START, REPLY_START, RECORD_START = 0xA5, 0x5A, 0xC3
COMMAND_BYTES = 10
SILENCE_MS = 50  # USB has no bit times: a command that is not whole after so long without a byte is forgotten
_CARRIAGE_RETURN, _CONTROL_C = 0x0D, 0x03


def _table_entry(byte: int) -> int:
    crc = byte << 8
    for _ in range(8):
        crc = (crc << 1 ^ 0x1021) & 0xFFFF if crc & 0x8000 else crc << 1
    return crc


_TABLE = array("H", [_table_entry(byte) for byte in range(256)])


def check_sum(data: bytes) -> int:
    """CRC-16/IBM-3740 of the bytes."""
    crc = 0xFFFF
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ _TABLE[crc >> 8 ^ byte]
    return crc


def pack_reply(*, refusal: int, tag: int, address: int, value: int) -> bytes:
    """Ten bytes."""
    body = struct.pack("<BBBBI", REPLY_START, refusal, tag, address, value)
    return body + struct.pack("<H", check_sum(body))


def pack_record(*, channels: int, number: int, time: int) -> bytes:
    """Twelve bytes; the loss bit is one of ``channels``."""
    body = struct.pack("<BBHIH", RECORD_START, channels, number, time & 0xFFFFFFFF, time >> 32)
    return body + struct.pack("<H", check_sum(body))


class CommandReader:
    """Finds the commands in what arrives; ``garbled`` counts those that broke off or whose check sum was wrong."""

    def __init__(self):
        self.garbled = 0
        self._part = bytearray()
        self._last_ms = 0
        self._skipped = 0

    def feed(self, byte: int, now_ms: int) -> "tuple[int, int, int, int] | None":
        """Take one byte; give operation, tag, address and value once a command is whole.

        Raises
        ------
        KeyboardInterrupt
            On Control-C after a carriage return outside of a command: how programs that copy files to a board stop it.
        """
        self.idle(now_ms)
        self._last_ms = now_ms
        part = self._part
        if not part and byte != COMMAND_START:
            if byte == _CONTROL_C and self._skipped == _CARRIAGE_RETURN:
                raise KeyboardInterrupt
            self._skipped = byte
            return None
        self._skipped = 0
        part.append(byte)
        if len(part) < COMMAND_BYTES:
            return None
        message, self._part = bytes(part), bytearray()
        _, operation, tag, address, value, found = struct.unpack("<BBBBIH", message)
        if found != check_sum(message[:-2]):
            self.garbled += 1
            return None
        return operation, tag, address, value

    def idle(self, now_ms: int) -> None:
        """Forget a command that broke off. ``now_ms`` may wrap at a power of two, as MicroPython's clock does."""
        if self._part and (now_ms - self._last_ms) & 0x3FFFFFFF > SILENCE_MS:
            self.garbled += 1
            self._part = bytearray()
