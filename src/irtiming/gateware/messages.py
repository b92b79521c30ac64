"""What goes over the serial line between a computer and the trigger generator, byte by byte.

======== ===== =========================================================================================
message  bytes content, numbers little-endian
======== ===== =========================================================================================
command  10    A5, operation, tag, address, value (4), check sum (2); computer to generator
reply    10    5A, refusal, tag, address, value (4), check sum (2); one for every command that arrives whole
record   12    C3, channels and loss bit, number (2), time (6), check sum (2); events of one clock cycle
======== ===== =========================================================================================

The tag is any byte of the computer's; the reply repeats it. The reply to a write holds the value that the register has
afterwards (a refused one: the value that it kept), so that every write is read back. The check sum is the CRC-16 with
polynomial 0x1021 that starts at 0xFFFF (CRC-16/IBM-3740) over all bytes before it. A command that is not whole after 24 bit
times of silence is forgotten; one with a wrong check sum gets no reply.
"""

import struct
from binascii import crc_hqx
from dataclasses import dataclass
from enum import IntEnum
from typing import final

from irtiming.gateware.register_map import LOSS

COMMAND_START, REPLY_START, RECORD_START = 0xA5, 0x5A, 0xC3
COMMAND_BYTES, REPLY_BYTES, RECORD_BYTES = 10, 10, 12
BITS_PER_BYTE = 10
"""On the line: a start bit, eight of data, a stop bit."""

SILENCE_BITS = 24
"""Bit times without a byte after which a broken command is forgotten."""


class Operation(IntEnum):
    """What a command asks for."""

    READ = 0
    WRITE = 1


@final
@dataclass(frozen=True, kw_only=True)
class CommandMessage:
    """Read or write one register; ``value`` is 0 for a read."""

    operation: int
    tag: int
    address: int
    value: int = 0


@final
@dataclass(frozen=True, kw_only=True)
class ReplyMessage:
    """Answer to one command; ``refusal`` as in `register_map.Refusal`."""

    refusal: int
    tag: int
    address: int
    value: int


@final
@dataclass(frozen=True, kw_only=True)
class RecordMessage:
    """Events of one clock cycle: ``channels`` as in `register_map.Channel`, time of the 48-bit counter.

    ``number`` counts records from 0 after ARM, modulo 65536. ``is_after_loss`` says that records were lost right before.
    """

    channels: int
    number: int
    time_ticks: int
    is_after_loss: bool


def check_sum(data: bytes) -> int:
    """CRC-16/IBM-3740 of the bytes."""
    return crc_hqx(data, 0xFFFF)


def pack_command(message: CommandMessage) -> bytes:
    """Ten bytes."""
    body = struct.pack("<BBBBI", COMMAND_START, message.operation, message.tag, message.address, message.value)
    return body + struct.pack("<H", check_sum(body))


def pack_reply(message: ReplyMessage) -> bytes:
    """Ten bytes."""
    body = struct.pack("<BBBBI", REPLY_START, message.refusal, message.tag, message.address, message.value)
    return body + struct.pack("<H", check_sum(body))


def pack_record(message: RecordMessage) -> bytes:
    """Twelve bytes."""
    channels = message.channels | (LOSS if message.is_after_loss else 0)
    body = struct.pack("<BBH", RECORD_START, channels, message.number) + message.time_ticks.to_bytes(6, "little")
    return body + struct.pack("<H", check_sum(body))


def unpack_command(data: bytes) -> CommandMessage | None:
    """The command in these ten bytes, None where they are none."""
    if len(data) != COMMAND_BYTES or data[0] != COMMAND_START or not _is_whole(data):
        return None
    _, operation, tag, address, value = struct.unpack("<BBBBI", data[:-2])
    return CommandMessage(operation=operation, tag=tag, address=address, value=value)


def unpack_reply(data: bytes) -> ReplyMessage | None:
    """The reply in these ten bytes, None where they are none."""
    if len(data) != REPLY_BYTES or data[0] != REPLY_START or not _is_whole(data):
        return None
    _, refusal, tag, address, value = struct.unpack("<BBBBI", data[:-2])
    return ReplyMessage(refusal=refusal, tag=tag, address=address, value=value)


def unpack_record(data: bytes) -> RecordMessage | None:
    """The record in these twelve bytes, None where they are none."""
    if len(data) != RECORD_BYTES or data[0] != RECORD_START or not _is_whole(data):
        return None
    _, channels, number = struct.unpack("<BBH", data[:4])
    return RecordMessage(
        channels=channels & ~LOSS,
        number=number,
        time_ticks=int.from_bytes(data[4:10], "little"),
        is_after_loss=bool(channels & LOSS),
    )


def _is_whole(data: bytes) -> bool:
    return bool(check_sum(data[:-2]) == int.from_bytes(data[-2:], "little"))
