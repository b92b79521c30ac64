"""From the bytes of a serial line, whole or damaged, to the messages that are in them."""

from collections.abc import Iterator
from typing import TypeAlias, final

from irtiming.gateware.messages import (
    RECORD_BYTES,
    RECORD_START,
    REPLY_BYTES,
    REPLY_START,
    RecordMessage,
    ReplyMessage,
    unpack_record,
    unpack_reply,
)

Message: TypeAlias = ReplyMessage | RecordMessage

_LENGTH = {REPLY_START: REPLY_BYTES, RECORD_START: RECORD_BYTES}


@final
class MessageStream:
    """Finds messages in bytes that arrive in pieces of any size.

    A message begins with its start byte, has the length that belongs to it and a check sum that fits. Where one of
    them is wrong, only the start byte is passed over: the next message may begin right behind it, in the place of
    bytes that were dropped.
    """

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._skipped = 0

    @property
    def skipped_bytes(self) -> int:
        """Bytes so far that belong to no message."""
        return self._skipped

    def feed(self, data: bytes) -> list[Message]:
        """Messages that are whole with these bytes, in order.

        Parameters
        ----------
        data
            What came over the line after the bytes of the last call.
        """
        self._bytes += data
        return list(self._whole())

    def _whole(self) -> Iterator[Message]:
        while self._bytes:
            length = _LENGTH.get(self._bytes[0])
            if length is None:
                self._skip(1)
                continue
            if len(self._bytes) < length:
                return
            data = bytes(self._bytes[:length])
            message = unpack_reply(data) if data[0] == REPLY_START else unpack_record(data)
            if message is None:
                self._skip(1)
                continue
            del self._bytes[:length]
            yield message

    def _skip(self, n_bytes: int) -> None:
        del self._bytes[:n_bytes]
        self._skipped += n_bytes
