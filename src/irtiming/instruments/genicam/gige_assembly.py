"""Frames out of the packets of a GigE Vision stream, in order, with every loss counted."""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from irtiming.errors import InstrumentRefused
from irtiming.instruments.genicam.frame_numbers import FrameNumbers
from irtiming.records.camera_frame import CameraFrame

_HEADER, _EXTENDED_HEADER, _EXTENDED = 8, 20, 0x80
_LEADER, _TRAILER, _DATA = 1, 2, 3
_LEADER_BYTES = 24
_IMAGE, _IMAGE_WITH_CHUNKS = 0x0001, 0x4001
_ERROR = 0x8000
_PATIENCE_S = {True: 0.1, False: 0.02}  # with packets that are asked for again, and with packets out of order
_STALLED_S = 0.5
_ASK_AGAIN_S, _MOST_REQUESTS = 0.03, 3
_FARTHEST = 1000  # frames that may be lost in one go; a packet that says more is not of this stream
_STILL_KEPT = 8  # frames of which a camera may still have every packet

Bytes = NDArray[np.uint8]
Ints = NDArray[np.int64]


@final
@dataclass(frozen=True, kw_only=True)
class MissingPackets:
    """Packets ``first`` to ``last`` of a block, which did not come; ``is_extended`` if the stream has numbers of 64 bits."""

    block: int
    first: int
    last: int
    is_extended: bool


Deliver = Callable[[CameraFrame, int], None]
AskAgain = Callable[[MissingPackets], None]


@dataclass(kw_only=True)
class _Block:
    """A frame in the making.

    ``has`` tells of each packet of pixels, from packet 1 on, whether it came; ``asked`` of each packet, from the leader on,
    whether it was asked for again.
    """

    number: int
    is_extended: bool
    pixels: Bytes
    has: NDArray[np.bool_]
    asked: NDArray[np.bool_]
    touched_s: float
    timestamp_ticks: int | None = None
    has_trailer: bool = False
    requests: int = 0
    requested_s: float = 0.0
    resent: int = 0
    gone: set[int] = field(default_factory=set)

    def missing(self, *, is_over: bool) -> list[int]:
        """Packets that should have come by now; packet 0 is the leader."""
        lacking = np.flatnonzero(~self.has)
        if not is_over:
            came = np.flatnonzero(self.has)
            lacking = lacking[lacking < came[-1]] if came.size else lacking[:0]
        return ([0] if self.timestamp_ticks is None else []) + [int(i) + 1 for i in lacking]

    @property
    def is_whole(self) -> bool:
        return self.timestamp_ticks is not None and bool(self.has.all())

    @property
    def has_nothing(self) -> bool:
        return self.timestamp_ticks is None and not self.has_trailer and not self.has.any()


@final
class FrameAssembly:
    """Puts packets where they belong. For one thread; the image has 16 bits per pixel, its bytes little end first."""

    def __init__(
        self,
        *,
        shape: tuple[int, int],
        packet_bytes: int,
        numbers: FrameNumbers,
        deliver: Deliver,
        ask_again: AskAgain | None,
    ) -> None:
        self._shape = shape
        self._bytes = 2 * shape[0] * shape[1]
        self._share = packet_bytes - _HEADER  # bytes of pixels in every packet but the last
        self._deliver, self._ask_again = deliver, ask_again
        self._blocks: dict[int, _Block] = {}
        self._next_id = 0
        self._has_share = False
        self.numbers = numbers

    def take(self, packets: Bytes, lengths: NDArray[np.uint32], *, now_s: float) -> None:
        """Packets as they came.

        Parameters
        ----------
        packets
            Shape (packet, byte); kept by the caller.
        lengths
            Bytes that count, shape (packet,).
        now_s
            Monotonic clock.

        Raises
        ------
        InstrumentRefused
            If the camera sends something else than what it was set to.
        """
        is_extended = bool(packets[0, 4] & _EXTENDED)
        header = _EXTENDED_HEADER if is_extended else _HEADER
        usable = (lengths >= header) & ((packets[:, 4] & _EXTENDED) == (packets[0, 4] & _EXTENDED))
        if not usable.all():
            packets, lengths = packets[usable], lengths[usable]
        if is_extended:
            numbers, ids = packets[:, 8:16].view(">u8")[:, 0], packets[:, 16:20].view(">u4")[:, 0].astype(np.int64)
        else:
            numbers = packets[:, 2:4].view(">u2")[:, 0]
            ids = packets[:, 4:8].view(">u4")[:, 0].astype(np.int64) & 0xFFFFFF
        borders = [0, *(np.flatnonzero(numbers[1:] != numbers[:-1]) + 1).tolist(), len(packets)]
        for begin, end in itertools.pairwise(borders):
            if begin < end:
                part = slice(begin, end)
                self._take_part(
                    int(numbers[begin]), ids[part], packets[part], lengths[part].astype(np.int64) - header, now_s
                )
        self.settle(now_s=now_s)

    def settle(self, *, now_s: float) -> None:
        """Hand over what is whole or can no longer become so, and ask again for what is missing.

        Parameters
        ----------
        now_s
            Monotonic clock.
        """
        while self._blocks:
            frame_id = min(self._blocks)
            block = self._blocks[frame_id]
            if not block.is_whole and not self._is_hopeless(frame_id, block, now_s):
                break
            self._hand_over(frame_id, self._blocks.pop(frame_id), now_s)
        if self._ask_again is not None:
            for frame_id, block in self._blocks.items():
                self._ask(frame_id, block, now_s)

    def finish(self, *, now_s: float) -> None:
        """Hand over everything, whole or not: no more packets will come.

        Parameters
        ----------
        now_s
            Monotonic clock.
        """
        for frame_id in sorted(self._blocks):
            self._hand_over(frame_id, self._blocks.pop(frame_id), now_s)

    @property
    def is_empty(self) -> bool:
        """Whether no frame is in the making."""
        return not self._blocks

    def _take_part(self, number: int, ids: Ints, packets: Bytes, lengths: Ints, now_s: float) -> None:
        """Packets of one block; ``lengths`` without header."""
        is_extended = bool(packets[0, 4] & _EXTENDED)
        header = _EXTENDED_HEADER if is_extended else _HEADER
        kinds, statuses = packets[:, 4] & 0xF, packets[:, 0:2].view(">u2")[:, 0]
        good = statuses < _ERROR
        leaders = np.flatnonzero((kinds == _LEADER) & (lengths >= _LEADER_BYTES) & good)
        data = (kinds == _DATA) & good
        self._learn_share(ids[data], lengths[data])
        block = self._block(number, is_extended=is_extended, is_led=leaders.size > 0, now_s=now_s)
        if block is None:
            return
        block.touched_s = now_s
        for leader in leaders:
            self._read_leader(block, packets[leader, header : header + _LEADER_BYTES].tobytes())
        block.has_trailer |= bool(((kinds == _TRAILER) & good).any())
        block.gone |= set(ids[~good].tolist())
        n = block.has.size
        last = self._bytes - (n - 1) * self._share
        fits = (lengths == self._share) | ((ids == n) & (lengths >= last))
        fits &= data & (ids >= 1) & (ids <= n)
        if not fits.any():
            return
        rows = ids[fits] - 1
        block.resent += int(np.count_nonzero(block.asked[rows + 1] & ~block.has[rows]))
        grid = block.pixels.reshape(n, self._share)
        pieces = (
            packets[:, header : header + self._share] if fits.all() else packets[fits, header : header + self._share]
        )
        if rows[-1] - rows[0] == rows.size - 1 and bool((rows[1:] > rows[:-1]).all()):
            grid[rows[0] : rows[-1] + 1] = pieces
            block.has[rows[0] : rows[-1] + 1] = True
        else:
            grid[rows] = pieces
            block.has[rows] = True

    def _learn_share(self, ids: Ints, lengths: Ints) -> None:
        """From the first packet of pixels: some cameras put less into a packet than its size allows."""
        if self._has_share or not (ids == 1).any():
            return
        share = int(lengths[ids == 1][0])
        if share <= 0:
            return
        self._has_share = True
        if share != min(self._share, self._bytes):
            self._share = min(share, self._bytes)
            self._blocks = {
                k: self._new_block(b.number, is_extended=b.is_extended, now_s=b.touched_s, like=b)
                for k, b in self._blocks.items()
            }

    def _new_block(self, number: int, *, is_extended: bool, now_s: float, like: _Block | None = None) -> _Block:
        n = math.ceil(self._bytes / self._share)
        return _Block(
            number=number,
            is_extended=is_extended,
            pixels=np.empty(n * self._share, np.uint8),
            has=np.zeros(n, np.bool_),
            asked=np.zeros(n + 1, np.bool_),
            touched_s=now_s,
            timestamp_ticks=like.timestamp_ticks if like is not None else None,
        )

    def _block(self, number: int, *, is_extended: bool, is_led: bool, now_s: float) -> _Block | None:
        """The block of this number; None for one that was handed over, or is not of this stream."""
        frame_id = self.numbers.frame_id(number, is_wide=is_extended)
        if frame_id < self._next_id or (frame_id >= self._next_id + _FARTHEST and not is_led):
            return None
        self.numbers.saw(number, frame_id=frame_id)
        if frame_id not in self._blocks:
            self._expect_before(frame_id, is_extended=is_extended, now_s=now_s)
            self._blocks[frame_id] = self._new_block(number, is_extended=is_extended, now_s=now_s)
        return self._blocks[frame_id]

    def _expect_before(self, frame_id: int, *, is_extended: bool, now_s: float) -> None:
        """Frames of which nothing has come, so that they are asked for as a whole."""
        if self._ask_again is None:
            return
        for lost in range(max(self._next_id, frame_id - _STILL_KEPT), frame_id):
            if lost not in self._blocks:
                number = self.numbers.number_of(lost, is_wide=is_extended)
                self._blocks[lost] = self._new_block(number, is_extended=is_extended, now_s=now_s)

    def _read_leader(self, block: _Block, leader: bytes) -> None:
        kind = int.from_bytes(leader[2:4], "big")
        pixel_bits = leader[13]
        columns, rows = int.from_bytes(leader[16:20], "big"), int.from_bytes(leader[20:24], "big")
        if kind not in (_IMAGE, _IMAGE_WITH_CHUNKS) or pixel_bits != 16 or (rows, columns) != self._shape:
            raise InstrumentRefused(
                f"the camera sends {columns} x {rows} pixels of {pixel_bits} bits (payload type {kind:#06x}), but was set "
                f"to {self._shape[1]} x {self._shape[0]} of 16; arm it again"
            )
        block.timestamp_ticks = int.from_bytes(leader[4:12], "big")

    def _is_over(self, frame_id: int, block: _Block) -> bool:
        return block.has_trailer or self.numbers.newest_id > frame_id

    def _is_hopeless(self, frame_id: int, block: _Block, now_s: float) -> bool:
        idle_s = now_s - block.touched_s
        if not self._is_over(frame_id, block):
            return idle_s > _STALLED_S
        if block.gone and block.gone.issuperset(block.missing(is_over=True)):
            return True
        return idle_s > _PATIENCE_S[self._ask_again is not None]

    def _ask(self, frame_id: int, block: _Block, now_s: float) -> None:
        """A new gap at once, and all that are left some time later."""
        missing = [i for i in block.missing(is_over=self._is_over(frame_id, block)) if i not in block.gone]
        is_due = block.requests < _MOST_REQUESTS and now_s - block.requested_s > _ASK_AGAIN_S
        wanted = missing if is_due else [i for i in missing if not block.asked[i]]
        if not wanted or self._ask_again is None:
            return
        if is_due:
            block.requests, block.requested_s = block.requests + 1, now_s
        block.asked[wanted] = True
        breaks = [i for i in range(1, len(wanted)) if wanted[i] != wanted[i - 1] + 1]
        for begin, end in zip([0, *breaks], [*breaks, len(wanted)], strict=True):
            first, last = wanted[begin], wanted[end - 1]
            self._ask_again(MissingPackets(block=block.number, first=first, last=last, is_extended=block.is_extended))

    def _hand_over(self, frame_id: int, block: _Block, now_s: float) -> None:
        if not block.has.all():
            block.pixels.reshape(block.has.size, self._share)[~block.has] = 0
        self._next_id = frame_id + 1
        if block.has_nothing:
            return
        frame = CameraFrame(
            pixels=block.pixels[: self._bytes].view("<u2").reshape(self._shape),
            frame_id=frame_id,
            device_timestamp_ticks=block.timestamp_ticks or 0,
            host_time_s=now_s,
            packets_missing=int(np.count_nonzero(~block.has)) + (block.timestamp_ticks is None),
        )
        self._deliver(frame, block.resent)
