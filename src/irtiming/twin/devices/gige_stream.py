"""Images as packets of the GigE Vision streaming protocol (GVSP) with 16-bit block identifiers, and their way to a client."""

import socket
import struct
import sys
from collections import OrderedDict
from dataclasses import dataclass
from threading import Lock
from time import monotonic, sleep
from typing import final

from irtiming.twin.devices.camera_faults import CameraFaults

_HEADERS = 20 + 8 + 8  # IP, UDP, GVSP
_UDP_HEADERS = 20 + 8
_LEADER, _TRAILER, _DATA = 1, 2, 3
_IMAGE = 1
_UNAVAILABLE = 0x800C
_KEPT_FRAMES = 16
_IP_MTU_DISCOVER, _DO_FRAGMENT, _DO_NOT_FRAGMENT = 10, 0, 2
_LAST_BLOCK = 0xFFFF
_SHORTEST_SLEEP_S = 5e-4
_MADE_UP_S = 1e-3
"""Of a sleep that lasted too long so much is made up for: the bytes of this time fit into any receiver's buffer."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Block:
    """An image on its way. ``pixels`` are its bytes; the offset is that of its first pixel on the detector."""

    number: int
    timestamp: int
    pixel_format: int
    width: int
    height: int
    offset_x: int
    offset_y: int
    pixels: bytes

    @property
    def block_id(self) -> int:
        """16 bits: after 65535 comes 1."""
        return self.number % _LAST_BLOCK + 1


@final
@dataclass(frozen=True, kw_only=True)
class Route:
    """Where packets go, how large they are with all headers, and how long the camera waits after each, s."""

    host: str
    port: int
    packet_bytes: int
    delay_s: float = 0.0
    is_fragmented: bool = True

    @property
    def data_bytes(self) -> int:
        """Image bytes in a packet."""
        return self.packet_bytes - _HEADERS


@final
class Packets:
    """All packets of a block: 0 the leader, then the data, at last the trailer."""

    def __init__(self, block: Block, data_bytes: int) -> None:
        self._block, self._data_bytes = block, data_bytes
        self._n_data = -(-len(block.pixels) // data_bytes)

    @property
    def count(self) -> int:
        """With leader and trailer."""
        return self._n_data + 2

    def packet(self, packet_id: int) -> bytes:
        """The UDP payload of one packet."""
        block = self._block
        if packet_id == 0:
            time = struct.pack(">HHQ", 0, _IMAGE, block.timestamp & (2**64 - 1))
            size = (block.pixel_format, block.width, block.height, block.offset_x, block.offset_y)
            return _header(block.block_id, _LEADER, 0) + time + struct.pack(">5IHH", *size, 0, 0)
        if packet_id == self._n_data + 1:
            return _header(block.block_id, _TRAILER, packet_id) + struct.pack(">HHI", 0, _IMAGE, block.height)
        first = (packet_id - 1) * self._data_bytes
        return _header(block.block_id, _DATA, packet_id) + block.pixels[first : first + self._data_bytes]


@final
class Stream:
    """The camera's one stream channel: sends blocks at the speed of a link and keeps the last for resends."""

    def __init__(self, address: str, *, link_bits_per_s: float, faults: CameraFaults) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4 << 20)
        self._socket.bind((address, 0))
        self._link_bits_per_s, self._faults = link_bits_per_s, faults
        self._kept: OrderedDict[int, Packets] = OrderedDict()
        self._lock = Lock()
        self._free_at_s = 0.0
        self._resends = 0

    @property
    def port(self) -> int:
        """From which packets come."""
        return int(self._socket.getsockname()[1])

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()

    def forget(self) -> None:
        """Drop what was kept for resends."""
        with self._lock:
            self._kept.clear()

    def test_packet(self, route: Route) -> None:
        """One packet of the route's size, which tells a client whether it gets through."""
        if sys.platform == "linux":
            how = _DO_FRAGMENT if route.is_fragmented else _DO_NOT_FRAGMENT
            self._socket.setsockopt(socket.IPPROTO_IP, _IP_MTU_DISCOVER, how)
        self._put(_header(0, _DATA, 0).ljust(route.packet_bytes - _UDP_HEADERS, b"\0"), route)

    def send(self, block: Block, route: Route, *, is_lost: bool = False) -> None:
        """Send a whole block.

        Parameters
        ----------
        block
            The image.
        route
            Where to.
        is_lost
            Whether nothing of it arrives, now or later.
        """
        if is_lost:
            return
        packets = Packets(block, route.data_bytes)
        with self._lock:
            self._kept[block.block_id] = packets
            while len(self._kept) > _KEPT_FRAMES:
                self._kept.popitem(last=False)
        every = list(range(packets.count))
        harmed = self._faults.arriving(every, index=(block.number, 0)) if self._faults.harms_packets else every
        self._free_at_s = max(self._free_at_s, monotonic())
        for packet_id in harmed:
            self._put(packets.packet(packet_id), route)
            self._pace(route)

    def resend(self, block_id: int, wanted: range, *, route: Route) -> None:
        """Send packets of a block once more; those that are no longer kept are said to be gone.

        Parameters
        ----------
        block_id
            Of the block.
        wanted
            Packet identifiers.
        route
            Where to.
        """
        with self._lock:
            packets = self._kept.get(block_id)
        if packets is None:
            for packet_id in wanted[:64]:
                self._put(_header(block_id, _DATA, packet_id, status=_UNAVAILABLE), route)
            return
        self._resends += 1
        there = range(wanted.start, min(wanted.stop, packets.count))
        for packet_id in self._faults.arriving(list(there), index=(block_id, self._resends)):
            self._put(packets.packet(packet_id), route)

    def _put(self, packet: bytes, route: Route) -> None:
        try:
            self._socket.sendto(packet, (route.host, route.port))
        except OSError:
            return  # no one listens any more, or the packet is too large for the way

    def _pace(self, route: Route) -> None:
        """Wait as long as the packet takes on the link, or let several such times come together."""
        now = monotonic()
        self._free_at_s = max(self._free_at_s, now - _MADE_UP_S)
        self._free_at_s += 8 * route.packet_bytes / self._link_bits_per_s + route.delay_s
        if self._free_at_s - now >= _SHORTEST_SLEEP_S:
            sleep(self._free_at_s - now)


def _header(block_id: int, kind: int, packet_id: int, *, status: int = 0) -> bytes:
    return struct.pack(">HHI", status, block_id, kind << 24 | packet_id & 0xFFFFFF)
