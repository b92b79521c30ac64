"""Stream channel of a GigE Vision camera: the socket, the size of its packets, and the thread that receives."""

import socket
import struct
import time
from contextlib import suppress
from threading import Event, Thread
from typing import final

from irtiming.errors import InstrumentError
from irtiming.instruments.frame_queue import FrameQueue
from irtiming.instruments.genicam.frame_numbers import FrameNumbers
from irtiming.instruments.genicam.gige_assembly import FrameAssembly, MissingPackets
from irtiming.instruments.genicam.gige_control import GVCP_PORT, GigeControl, local_address
from irtiming.instruments.genicam.gige_datagrams import datagrams, enlarge_queue
from irtiming.records.camera_frame import CameraFrame

_HOST_PORT, _PACKET_SIZE, _DESTINATION = 0x0D00, 0x0D04, 0x0D18
_FIRE_TEST, _DO_NOT_FRAGMENT, _SIZE_MASK = 1 << 31, 1 << 30, 0xFFFF
_IP_AND_UDP_BYTES = 28  # the size of a packet counts them, a datagram does not
_SIZES = (9000, 8192, 4096, 2048)  # tried from the first to the last
_USUAL_SIZE, _SMALLEST_SIZE = 1500, 576
_TEST_S, _TESTS = 0.05, 2
_QUIET_S, _LONGEST_DRAIN_S = 0.1, 2.0
_RESEND_KEY, _RESEND_COMMAND, _EXTENDED_FLAG = 0x42, 0x0040, 0x10


@final
class GigeStream:
    """One acquisition's stream, from `open` to `close`; all calls block."""

    def __init__(self, control: GigeControl) -> None:
        self._control = control
        self._local = local_address(control.address)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((self._local, 0))
        self.queue_bytes = enlarge_queue(self._socket)
        self.packet_size = 0
        self._requests = 0
        self._thread: Thread | None = None
        self._no_more = Event()

    def open(self) -> None:
        """Tell the camera where to send, and find the largest packets that pass.

        Raises
        ------
        InstrumentError
            If the camera does not take it.
        """
        self._control.set_register(_DESTINATION, struct.unpack(">I", socket.inet_aton(self._local))[0])
        self._control.set_register(_HOST_PORT, self._socket.getsockname()[1])
        found = self._control.register(_PACKET_SIZE) & _SIZE_MASK
        self.packet_size = self._largest_that_passes() or self._untested(found)
        if self._set_size(self.packet_size, 0) != self.packet_size:
            self.packet_size = self._control.register(_PACKET_SIZE) & _SIZE_MASK
        if self.packet_size <= _IP_AND_UDP_BYTES + 20:
            raise InstrumentError(
                f"{self._control.name} says that its packets have {self.packet_size} bytes; that cannot be"
            )

    def start(self, shape: tuple[int, int], *, queue: FrameQueue, numbers: FrameNumbers) -> None:
        """Receive frames into a queue from now on.

        Parameters
        ----------
        shape
            Rows and columns.
        queue
            Ended if the stream fails.
        numbers
            Of this acquisition.
        """

        def deliver(frame: CameraFrame, packets_resent: int) -> None:
            queue.put(frame, packets_resent=packets_resent)

        ask_again = self._ask_again if self._control.can_resend() else None
        size = self.packet_size - _IP_AND_UDP_BYTES
        assembly = FrameAssembly(shape=shape, packet_bytes=size, numbers=numbers, deliver=deliver, ask_again=ask_again)
        self._forget_waiting()
        name = f"stream of {self._control.name}"
        self._thread = Thread(target=self._receive, args=(assembly, queue), name=name, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Receive what is on its way until the stream is quiet, and close the channel; again does no harm."""
        self._no_more.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        with suppress(InstrumentError):
            if self._socket.fileno() >= 0:
                self._control.set_register(_HOST_PORT, 0)
        self._socket.close()

    def _receive(self, assembly: FrameAssembly, queue: FrameQueue) -> None:
        failure: InstrumentError | None = None
        try:
            self._receive_until_quiet(assembly)
        except InstrumentError as error:
            failure = error
        except OSError as error:
            failure = InstrumentError(f"the stream of {self._control.name} broke ({error}); arm it again")
        assembly.finish(now_s=time.monotonic())
        queue.end(failure)

    def _receive_until_quiet(self, assembly: FrameAssembly) -> None:
        reader = datagrams(self._socket, longest=self.packet_size, sender=self._control.address)
        last_s = told_s = time.monotonic()
        was_told = False
        while True:
            count = reader.receive()
            now_s = time.monotonic()
            if count:
                last_s = now_s
                assembly.take(reader.packets[:count], reader.lengths[:count], now_s=now_s)
            else:
                assembly.settle(now_s=now_s)
            if self._no_more.is_set():
                told_s, was_told = (told_s, True) if was_told else (now_s, True)
                is_quiet = assembly.is_empty and now_s - max(last_s, told_s) > _QUIET_S
                if is_quiet or now_s - told_s > _LONGEST_DRAIN_S:
                    return

    def _largest_that_passes(self) -> int | None:
        """By test packets; None for a camera that sends none."""
        if not self._passes(_USUAL_SIZE):
            return None
        return next((size for size in _SIZES if self._passes(size)), _USUAL_SIZE)

    def _passes(self, size: int) -> bool:
        for _ in range(_TESTS):
            if self._set_size(size, _FIRE_TEST | _DO_NOT_FRAGMENT) != size:
                return False
            if self._has_come(size - _IP_AND_UDP_BYTES):
                return True
        return False

    def _set_size(self, size: int, flags: int) -> int | None:
        """The size that the camera then holds; None where it denies."""
        try:
            self._control.set_register(_PACKET_SIZE, size | flags)
            return self._control.register(_PACKET_SIZE) & _SIZE_MASK
        except InstrumentError:
            return None

    def _has_come(self, length: int) -> bool:
        until = time.monotonic() + _TEST_S
        while (left := until - time.monotonic()) > 0:
            self._socket.settimeout(left)
            try:
                packet, (address, _) = self._socket.recvfrom(65536)
                if len(packet) == length and address == self._control.address:
                    return True
            except TimeoutError:
                return False
        return False

    def _untested(self, found: int) -> int:
        """Jumbo packets where nothing lies between, else the camera's own size if every network takes it."""
        if self._local.startswith("127."):
            return _SIZES[0]
        return found if _SMALLEST_SIZE <= found <= _USUAL_SIZE else _USUAL_SIZE

    def _forget_waiting(self) -> None:
        """What came before the acquisition, such as test packets."""
        self._socket.settimeout(0)
        with suppress(BlockingIOError):
            while True:
                self._socket.recv(65536)

    def _ask_again(self, missing: MissingPackets) -> None:
        """From the stream's own socket, so that no other request has to wait; no answer is due but the packets."""
        self._requests = self._requests % 0xFFFF + 1
        if missing.is_extended:
            content = struct.pack(">HHIIQ", 0, 0, missing.first, missing.last, missing.block)
        else:
            content = struct.pack(">HHII", 0, missing.block, missing.first, missing.last)
        flags = _EXTENDED_FLAG if missing.is_extended else 0
        header = struct.pack(">BBHHH", _RESEND_KEY, flags, _RESEND_COMMAND, len(content), self._requests)
        with suppress(OSError):
            self._socket.sendto(header + content, (self._control.address, GVCP_PORT))
