"""Ask and answer with a trigger generator: one register at a time, every reply matched, every silence bounded."""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from time import monotonic_ns
from typing import final

from irtiming.errors import InstrumentError, InstrumentRefused, InstrumentSilent
from irtiming.gateware.messages import CommandMessage, Operation, RecordMessage, ReplyMessage, pack_command
from irtiming.gateware.register_map import ADDRESS, REGISTERS, Refusal
from irtiming.instruments.generator.message_stream import Message, MessageStream
from irtiming.instruments.serial_line import Line

_TAGS = 256
_REGISTER = {register.name: register for register in REGISTERS}
_WORDS = {
    Refusal.UNKNOWN_REGISTER: "it has no such register; update the device or this program",
    Refusal.READ_ONLY: "the register can only be read",
    Refusal.BUSY: "it is measuring; stop it first",
    Refusal.BAD_VALUE: "it does not take this value now",
    Refusal.NOT_ARMED: "it is not armed; arm it first",
}


@final
@dataclass(frozen=True, kw_only=True)
class Patience:
    """How long a reply is waited for, how often a command without one is sent, and how often progress is asked for."""

    reply_s: float = 0.3
    tries: int = 4
    poll_s: float = 0.2


@final
class RegisterLink:
    """The registers of the device at the other end of a line.

    A command that gets no reply is sent again, so only what may be done twice goes through here unasked: reading, and
    writing a value. Records go to ``on_record`` as they arrive, also while a reply is waited for.
    """

    def __init__(self, line: Line, *, on_record: Callable[[RecordMessage], None], patience: Patience) -> None:
        self._line = line
        self._on_record = on_record
        self._patience = patience
        self._stream = MessageStream()
        self._tag = monotonic_ns() % _TAGS  # a reply to an earlier program is hardly taken for one to this
        self._waiting: dict[tuple[int, int], asyncio.Future[ReplyMessage]] = {}
        self._gone: InstrumentError | None = None
        self._reader = asyncio.create_task(self._read_line())

    @property
    def name(self) -> str:
        """Of the port, for messages."""
        return self._line.name

    @property
    def patience(self) -> Patience:
        """As it was given."""
        return self._patience

    @property
    def gone(self) -> InstrumentError | None:
        """What was said when the line vanished, None while it is there."""
        return self._gone

    async def read(self, name: str) -> int:
        """Value of a register.

        Raises
        ------
        InstrumentSilent
            If no reply comes, or the line is gone.
        InstrumentRefused
            If the device does not know the register.
        """
        reply = await self._ask(Operation.READ, name)
        if reply.refusal:
            raise self._refused(f"reading {name}", reply)
        return reply.value

    async def write(self, name: str, value: int) -> None:
        """Set a register; the reply must hold the value.

        Raises
        ------
        InstrumentSilent
            If no reply comes, or the line is gone.
        InstrumentRefused
            If the value is out of the register's range, or the device refuses it or keeps another one.
        """
        register = _REGISTER[name]
        if not register.lowest <= value <= register.highest:
            raise InstrumentRefused(
                f"{name} = {value} cannot be set; it must lie between {register.lowest} and {register.highest} {register.unit}"
            )
        reply = await self._ask(Operation.WRITE, name, value)
        if reply.refusal:
            raise self._refused(f"{name} = {value}", reply)
        if register.access == "setting" and reply.value != value:
            raise InstrumentRefused(
                f"{self.name} holds {name} = {reply.value} after {value} was written; check line and device"
            )

    async def command(self, value: int) -> Refusal | None:
        """Write COMMAND once.

        Returns
        -------
        The device's refusal, `Refusal.NONE` where it obeyed, or None where no reply came: whether it did is then to be
        found out.
        """
        reply = await self._sent(Operation.WRITE, "COMMAND", value, tries=1)
        return None if reply is None else _refusal(reply)

    async def close(self) -> None:
        """Give the line back."""
        self._reader.cancel()
        with suppress(asyncio.CancelledError):
            await self._reader
        await self._line.close()

    async def _ask(self, operation: Operation, name: str, value: int = 0) -> ReplyMessage:
        skipped = self._stream.skipped_bytes
        reply = await self._sent(operation, name, value, tries=self._patience.tries)
        if reply is not None:
            return reply
        noise = self._stream.skipped_bytes - skipped
        heard = f"; {noise} bytes came that are no message, which suggests noise or another device" if noise else ""
        raise InstrumentSilent(
            f"{self.name} does not answer: {self._patience.tries} times to {operation.name.lower()} {name} got no reply within "
            f"{self._patience.reply_s:g} s{heard}; check that it is a trigger generator, its power and its cable"
        )

    async def _sent(self, operation: Operation, name: str, value: int, *, tries: int) -> ReplyMessage | None:
        """Send a command until a reply comes; a late one to an earlier try is as good."""
        waiting: asyncio.Future[ReplyMessage] = asyncio.get_running_loop().create_future()
        keys: list[tuple[int, int]] = []
        try:
            for _ in range(tries):
                if self._gone is not None:
                    raise self._gone
                self._tag = (self._tag + 1) % _TAGS
                keys.append((self._tag, ADDRESS[name]))
                self._waiting[keys[-1]] = waiting
                message = CommandMessage(operation=operation, tag=self._tag, address=ADDRESS[name], value=value)
                self._line.write(pack_command(message))
                await asyncio.wait([waiting], timeout=self._patience.reply_s)
                if waiting.done():
                    return waiting.result()
        finally:
            for key in keys:
                self._waiting.pop(key, None)
        return None

    async def _read_line(self) -> None:
        try:
            while True:
                self._take(self._stream.feed(await self._line.read()))
        except InstrumentError as error:
            self._gone = error
            for waiting in self._waiting.values():
                if not waiting.done():
                    waiting.set_exception(error)

    def _take(self, messages: list[Message]) -> None:
        for message in messages:
            if isinstance(message, RecordMessage):
                self._on_record(message)
                continue
            waiting = self._waiting.get((message.tag, message.address))
            if waiting is not None and not waiting.done():
                waiting.set_result(message)

    def _refused(self, what: str, reply: ReplyMessage) -> InstrumentRefused:
        words = _WORDS[_refusal(reply)]
        return InstrumentRefused(f"{self.name} refuses {what}: {words}")


def _refusal(reply: ReplyMessage) -> Refusal:
    """A code that this program does not know counts as a bad value."""
    known = {refusal.value for refusal in Refusal}
    return Refusal(reply.refusal) if reply.refusal in known else Refusal.BAD_VALUE
