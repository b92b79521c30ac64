"""A camera of the twin at a network address: the device's side of GigE Vision 1.2, its control (GVCP) and its images.

One client may have control; it loses it when it is silent for longer than its heartbeat time-out. What a client reads
and writes stands in `irtiming.twin.devices.gige_registers`, what it is sent in `irtiming.twin.devices.gige_stream`.
"""

import select
import socket
import struct
from collections.abc import Callable
from dataclasses import dataclass, replace
from ipaddress import IPv4Address
from queue import SimpleQueue
from threading import Event, Lock, Thread
from time import monotonic
from types import TracebackType
from typing import Self, TypeAlias, final

import numpy as np

from irtiming.errors import InstrumentError
from irtiming.records.arrays import Pixels
from irtiming.twin.devices.camera_faults import CameraFaults
from irtiming.twin.devices.gige_registers import (
    DO_NOT_FRAGMENT,
    FIRE_TEST_PACKET,
    MONO8,
    Address,
    Identity,
    Refusal,
    RefusedError,
    Registers,
)
from irtiming.twin.devices.gige_stream import Block, Route, Stream
from irtiming.twin.live_camera import LiveCamera, LiveFrame

PORT = 3956
_KEY = 0x42
_WANTS_ACKNOWLEDGE = 0x01
_DISCOVERY, _FORCE_IP, _RESEND = 0x0002, 0x0004, 0x0040
_READ_REGISTERS, _WRITE_REGISTERS, _READ_MEMORY, _WRITE_MEMORY = 0x0080, 0x0082, 0x0084, 0x0086
_LONGEST_READ = 536
_POLL_S = 0.05
_QUEUE_POLL_S = 0.002
_MOST_QUEUED = 8
_EXCLUSIVE, _CONTROL = 1 << 0, 1 << 1
_LATCH, _RESET = 1 << 1, 1 << 0
_CONTINUOUS, _SINGLE_FRAME = 0, 1

Client: TypeAlias = tuple[str, int]


@final
@dataclass(frozen=True, kw_only=True)
class CameraTraits:
    """What differs from camera to camera of one kind.

    Its timestamp counter begins at ``counter_start_ticks`` and is ``clock_error`` (relative) faster than the trigger
    generator's clock. ``link_bits_per_s`` is the speed of its network. Without triggers a frame's stamp is ``stamp_after_s`` and
    some normal jitter after it begins; None: when its integration, or row 0, begins. ``speed`` is that of the rig's time.
    """

    serial_number: str = "TWIN0001"
    timestamp_frequency_hz: int = 1_000_000_000
    clock_error: float = 7e-6
    counter_start_ticks: int = 5_000_000_000
    link_bits_per_s: float = 1e9
    stamp_after_s: float | None = None
    stamp_jitter_s: float = 0.0
    speed: float = 1.0


@final
class GigeCamera:
    """Serves a camera at an address, port 3956, while its ``with`` block runs; many fit into 127.0.0.0/8.

    Parameters
    ----------
    camera
        Its detector; its own ``with`` block must enclose this one's.
    address
        IPv4 address of this computer.
    traits
        Of this specimen.
    faults
        What goes wrong; may be changed at any time.

    Raises
    ------
    InstrumentError
        If the address is in use or none of this computer's.
    """

    def __init__(
        self,
        camera: LiveCamera,
        address: str = "127.0.0.2",
        *,
        traits: CameraTraits | None = None,
        faults: CameraFaults | None = None,
    ) -> None:
        self.faults = faults or CameraFaults()
        self._camera, self._address, self._traits = camera, address, traits or CameraTraits()
        detector = camera.scene.detector
        identity = Identity(
            address=address,
            serial_number=self._traits.serial_number,
            model="Twin microbolometer" if camera.integration_time_s is None else "Twin photon camera",
            rows=detector.rows,
            columns=detector.columns,
            highest_value=round(min(2.0**detector.bits - 1, detector.saturation_dn)),
            is_rolling=camera.is_rolling,
            integration_time_s=camera.integration_time_s,
            timestamp_frequency_hz=self._traits.timestamp_frequency_hz,
        )
        self._registers = Registers(identity)
        self._random = np.random.default_rng(self._traits.counter_start_ticks)
        self._client: Client | None = None
        self._heard_at_s = 0.0
        self._timestamp_zero_s = 0.0
        self._acquisition: _Acquisition | None = None
        self._lock = Lock()
        self._frames: SimpleQueue[tuple[_Acquisition, LiveFrame] | None] = SimpleQueue()
        self._is_over = Event()
        self._failure: BaseException | None = None
        self._sockets = _listening(address)
        self._stream = Stream(address, link_bits_per_s=self._traits.link_bits_per_s, faults=self.faults)
        self._registers.put(Address.STREAM_SOURCE_PORT, self._stream.port)
        self._threads = [
            Thread(target=self._watched, args=(work,), name=f"GigE {work.__name__}")
            for work in (self._answer, self._send)
        ]

    @property
    def address(self) -> str:
        """Where clients find it."""
        return self._address

    def __enter__(self) -> Self:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop()
        self._is_over.set()
        self._frames.put(None)
        for thread in self._threads:
            thread.join()
        for one in self._sockets:
            one.close()
        self._stream.close()
        if self._failure is not None and error is None:
            raise self._failure

    def timestamp_at(self, cycle: int) -> int:
        """The camera's counter at a cycle of the trigger generator's, ticks; 0 if it has no clock."""
        if not self.faults.has_timestamps:
            return 0
        since_s = cycle / self._camera.clock_frequency_hz - self._timestamp_zero_s
        start = self._traits.counter_start_ticks if self._timestamp_zero_s == 0 else 0
        return start + round(since_s * (1 + self._traits.clock_error) * self._traits.timestamp_frequency_hz)

    def _watched(self, work: Callable[[], None]) -> None:
        try:
            work()
        except BaseException as error:
            self._failure = error

    def _answer(self) -> None:
        """Commands, one after the other, and the heartbeat."""
        while not self._is_over.is_set():
            ready, _, _ = select.select(self._sockets, [], [], _POLL_S)
            for one in ready:
                message, client = one.recvfrom(2048)
                answer = None if self.faults.unplugged else self._obey(message, client)
                if answer is not None:
                    self._sockets[0].sendto(answer, client)
            silent_s = monotonic() - self._heard_at_s
            if self._client is not None and silent_s > 1e-3 * self._registers.word(Address.HEARTBEAT_TIMEOUT):
                self._lose_control()

    def _obey(self, message: bytes, client: Client) -> bytes | None:
        """Do what a datagram asks for; its answer, if it wants one."""
        if len(message) < 8 or message[0] != _KEY:
            return None
        _, flags, command, size, identifier = struct.unpack(">BBHHH", message[:8])
        content = message[8:]
        if client == self._client:
            self._heard_at_s = monotonic()
        try:
            if len(content) != size or identifier == 0:
                raise RefusedError(Refusal.INVALID_HEADER)
            found, status = self._do(command, content, client), 0
        except RefusedError as refusal:
            found, status = b"", int(refusal.status)
        if command in (_RESEND, _FORCE_IP) or not flags & _WANTS_ACKNOWLEDGE:
            return None
        return struct.pack(">HHHH", status, command + 1, len(found), identifier) + found

    def _do(self, command: int, content: bytes, client: Client) -> bytes:
        if command == _DISCOVERY:
            return self._registers.discovery()
        if command == _RESEND:
            self._resend(content, client)
            return b""
        if command == _READ_REGISTERS and content and len(content) % 4 == 0:
            self._check_may_read(client)
            return b"".join(self._registers.read(address, 4) for (address,) in struct.iter_unpack(">I", content))
        if command == _READ_MEMORY and len(content) == 8:
            self._check_may_read(client)
            address, count = struct.unpack(">I2xH", content)
            if not 0 < count <= _LONGEST_READ:
                raise RefusedError(Refusal.INVALID_PARAMETER)
            return content[:4] + self._registers.read(address, count)
        if command == _WRITE_REGISTERS and content and len(content) % 8 == 0:
            pairs = list(struct.iter_unpack(">II", content))
            for address, value in pairs:
                self._write(address, value, client)
            return struct.pack(">HH", 0, len(pairs))
        if command == _WRITE_MEMORY and len(content) > 4 and len(content) % 4 == 0:
            first = int.from_bytes(content[:4])
            for index, (value,) in enumerate(struct.iter_unpack(">I", content[4:])):
                self._write(first + 4 * index, value, client)
            return struct.pack(">HH", 0, len(content) - 4)
        known = command in (_READ_REGISTERS, _READ_MEMORY, _WRITE_REGISTERS, _WRITE_MEMORY)
        raise RefusedError(Refusal.INVALID_HEADER if known else Refusal.NOT_IMPLEMENTED)

    def _check_may_read(self, client: Client) -> None:
        if self._registers.word(Address.CONTROL_PRIVILEGE) & _EXCLUSIVE and client != self._client:
            raise RefusedError(Refusal.ACCESS_DENIED)

    def _write(self, address: int, value: int, client: Client) -> None:
        if client != self._client and (address != Address.CONTROL_PRIVILEGE or self._client is not None):
            raise RefusedError(Refusal.ACCESS_DENIED)
        self._registers.write(address, value, is_acquiring=self._acquisition is not None)
        if address == Address.CONTROL_PRIVILEGE:
            self._client, self._heard_at_s = (client, monotonic()) if value & (_EXCLUSIVE | _CONTROL) else (None, 0.0)
            if self._client is None:
                self._lose_control()
        elif address == Address.TIMESTAMP_CONTROL:
            self._control_timestamp(value)
        elif address == Address.ACQUISITION_START and value:
            self._start()
        elif address == Address.ACQUISITION_STOP and value:
            self._stop()
        elif address == Address.TRIGGER_SOFTWARE and value:
            self._camera.trigger_now()
        elif address == Address.PACKET_SIZE and value & FIRE_TEST_PACKET and (route := self._route()):
            self._stream.test_packet(route)

    def _lose_control(self) -> None:
        self._client = None
        self._registers.put(Address.CONTROL_PRIVILEGE, 0)
        self._stop()
        self._registers.put(Address.STREAM_PORT, 0)

    def _control_timestamp(self, value: int) -> None:
        now = self._camera.cycle_now(speed=self._traits.speed)
        if value & _LATCH:
            self._registers.put_long(Address.TIMESTAMP_HIGH, self.timestamp_at(now))
        if value & _RESET:
            self._timestamp_zero_s = now / self._camera.clock_frequency_hz

    def _route(self) -> Route | None:
        word, port = self._registers.word, self._registers.word(Address.STREAM_PORT) & 0xFFFF
        if not port:
            return None
        size = word(Address.PACKET_SIZE)
        return Route(
            host=str(IPv4Address(word(Address.STREAM_ADDRESS))),
            port=port,
            packet_bytes=size & 0xFFFF,
            delay_s=word(Address.PACKET_DELAY) / self._traits.timestamp_frequency_hz,
            is_fragmented=not size & DO_NOT_FRAGMENT,
        )

    def _start(self) -> None:
        if self._acquisition is not None:
            return
        word = self._registers.word
        mode = word(Address.ACQUISITION_MODE)
        several = 1 if mode == _SINGLE_FRAME else word(Address.FRAME_COUNT)
        acquisition = _Acquisition(most_frames=None if mode == _CONTINUOUS else several)
        self._stream.forget()
        with self._lock:
            self._acquisition = acquisition
        is_triggered = word(Address.TRIGGER_MODE) == 1
        self._camera.begin(
            lambda frame: self._queue(acquisition, frame),
            trigger="none" if not is_triggered else "line" if word(Address.TRIGGER_SOURCE) == 1 else "software",
            frame_rate_hz=self._registers.number(Address.FRAME_RATE),
            integration_time_s=self._exposure_time_s(),
        )

    def _exposure_time_s(self) -> float | None:
        """As a client set it; the detector's own number has more digits."""
        own_s = self._camera.integration_time_s
        asked_s = self._registers.number(Address.EXPOSURE_TIME) * 1e-6
        return None if own_s is None or abs(asked_s - own_s) < 1e-6 * own_s else asked_s

    def _stop(self) -> None:
        with self._lock:
            was, self._acquisition = self._acquisition, None
        if was is not None:
            self._camera.end()

    def _resend(self, content: bytes, client: Client) -> None:
        route = self._route()
        allowed = route is not None and client[0] in (route.host, self._client[0] if self._client else "")
        if route is None or not allowed or not self.faults.resend_honoured or len(content) < 12:
            return
        _, block_id, first, last = struct.unpack(">HHII", content[:12])
        first, last = first & 0xFFFFFF, last & 0xFFFFFF
        self._stream.resend(block_id, range(first, last + 1), route=route)

    def _queue(self, acquisition: "_Acquisition", frame: LiveFrame) -> None:
        """Wait where the link is slower than the frames: whoever triggers, and with it the rig's time, then waits too."""
        while self._frames.qsize() >= _MOST_QUEUED and self._acquisition is acquisition:
            if self._is_over.wait(_QUEUE_POLL_S):
                return
        self._frames.put((acquisition, frame))

    def _send(self) -> None:
        """Frames as they come, with what may go wrong with them."""
        while (taken := self._frames.get()) is not None:
            acquisition, frame = taken
            number, faults = frame.moment.number, self.faults
            if number in faults.triggers_missed:
                continue
            if faults.frozen and acquisition.last is not None:
                frame = LiveFrame(moment=frame.moment, pixels=acquisition.last)
            acquisition.last = frame.pixels
            for is_spurious in (False, True) if number in faults.frames_spurious else (False,):
                with self._lock:
                    if self._acquisition is not acquisition:
                        break
                if is_spurious:
                    later = replace(frame.moment, start_cycle=frame.moment.end_cycle)
                    frame = LiveFrame(moment=later, pixels=frame.pixels)
                self._send_one(acquisition, frame, is_lost=number in faults.frames_lost and not is_spurious)

    def _send_one(self, acquisition: "_Acquisition", frame: LiveFrame, *, is_lost: bool) -> None:
        route = self._route()
        number = acquisition.sent
        acquisition.sent += 1
        if route is not None and not self.faults.unplugged:
            self._stream.send(self._block(frame, number), route, is_lost=is_lost)
        if acquisition.sent == acquisition.most_frames:
            self._stop()

    def _block(self, frame: LiveFrame, number: int) -> Block:
        word = self._registers.word
        width, height = word(Address.WIDTH), word(Address.HEIGHT)
        column, row = word(Address.OFFSET_X), word(Address.OFFSET_Y)
        pixel_format = word(Address.PIXEL_FORMAT)
        pixels = frame.pixels[row : row + height, column : column + width]
        return Block(
            number=number,
            timestamp=self.timestamp_at(self._stamped_cycle(frame)),
            pixel_format=pixel_format,
            width=width,
            height=height,
            offset_x=column,
            offset_y=row,
            pixels=self._eight_bits(pixels) if pixel_format == MONO8 else pixels.astype("<u2", copy=False).tobytes(),
        )

    def _stamped_cycle(self, frame: LiveFrame) -> int:
        after_s = self._traits.stamp_after_s
        if after_s is None or self._registers.word(Address.TRIGGER_MODE) == 1:
            return frame.moment.start_cycle
        late_s = after_s + self._traits.stamp_jitter_s * self._random.standard_normal()
        return frame.moment.trigger_cycle + round(late_s * self._camera.clock_frequency_hz)

    def _eight_bits(self, pixels: Pixels) -> bytes:
        shift = max(self._camera.scene.detector.bits - 8, 0)
        return np.minimum(pixels >> shift, 255).astype(np.uint8).tobytes()


@final
class _Acquisition:
    """What is between the commands to start and to stop: how many frames it may have, those sent, and the last."""

    def __init__(self, *, most_frames: int | None) -> None:
        self.most_frames = most_frames
        self.sent = 0
        self.last: Pixels | None = None


def _listening(address: str) -> list[socket.socket]:
    """Sockets for commands: the camera's own, and where there is one that of broadcasts on the loopback interface."""
    own = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        own.bind((address, PORT))
    except OSError as error:
        own.close()
        raise InstrumentError(
            f"cannot serve a camera at {address} port {PORT} ({error.strerror}); take an address of this computer at "
            "which no other camera is served, such as 127.0.0.3"
        ) from error
    everybody = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        everybody.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if not address.startswith("127."):
            raise OSError
        everybody.bind(("127.255.255.255", PORT))
    except OSError:
        everybody.close()
        return [own]
    return [own, everybody]
