"""Camera by the Aravis library: GigE Vision on fast links, and USB3 Vision."""

import ctypes
import struct
import time
from contextlib import AbstractAsyncContextManager
from threading import Event, Thread
from typing import Any, final

import numpy as np

from irtiming.errors import InstrumentError, InstrumentRefused, InstrumentSilent
from irtiming.instruments.frame_queue import FrameQueue
from irtiming.instruments.genicam import aravis_library as arv
from irtiming.instruments.genicam.aravis_library import call, library
from irtiming.instruments.genicam.camera import GenicamCamera, connected_by
from irtiming.instruments.genicam.features import Features
from irtiming.instruments.genicam.frame_numbers import FrameNumbers
from irtiming.records.arrays import Pixels
from irtiming.records.camera_frame import CameraFrame, CameraIdentity, CameraSetup

_STALE_CONTROL_S = 4.0  # a program that died keeps control until its heartbeat is missed
_TICK_FREQUENCY, _LIFE_SIGN = 0x093C, 0x0000
_BUFFER_BYTES, _FEWEST_BUFFERS, _MOST_BUFFERS = 64 * 2**20, 16, 200
_WAIT_US, _QUIET_S = 20_000, 0.2
_NANOSECONDS_HZ = 1e9
_SENT = (arv.SUCCESS, arv.TIMED_OUT, arv.MISSING_PACKETS, arv.WRONG_PACKET)


def connected(address: str) -> AbstractAsyncContextManager[GenicamCamera]:
    """Camera of the Aravis library, for the length of an ``async with`` block.

    Parameters
    ----------
    address
        In the network such as ``"192.168.0.7"``, at USB the name that ``irtiming discover`` gives.

    Raises
    ------
    InstrumentError
        On entry, if the library is not there, nothing answers, or another program controls the camera.
    """
    return connected_by(lambda: AravisLink(address))


def listed() -> list[tuple[str, CameraIdentity]]:
    """Cameras that the library finds, each with its protocol, such as ``"GigEVision"`` or ``"USB3Vision"``.

    Raises
    ------
    InstrumentError
        If the library is not there.
    """
    found = library()
    found.arv_update_device_list()
    cameras = []
    for i in range(found.arv_get_n_devices()):
        protocol = arv.text(found.arv_get_device_protocol(i))
        is_network = protocol == "GigEVision"  # by its name the library may choose a network that no frame takes
        where = arv.text(found.arv_get_device_address(i) if is_network else found.arv_get_device_id(i))
        identity = CameraIdentity(
            vendor=arv.text(found.arv_get_device_vendor(i)),
            model=arv.text(found.arv_get_device_model(i)),
            serial_number=arv.text(found.arv_get_device_serial_nbr(i)),
            firmware="",
            address=f"aravis:{where}",
        )
        cameras.append((protocol, identity))
    return cameras


@final
class AravisLink:
    """One camera, opened by the library; its features are read by GenApi from the camera's own description."""

    heartbeat_s = 1.0

    def __init__(self, address: str) -> None:
        self.name = f"camera {address}"
        self._camera: Any = call("arv_camera_new", address.encode(), camera=self.name)
        if not self._camera:
            raise InstrumentSilent(f"{self.name} does not answer; irtiming discover lists those that do")
        self._device = library().arv_camera_get_device(self._camera)
        self.is_network = bool(library().arv_camera_is_gv_device(self._camera))
        self.first_number = 1 if self.is_network else 0
        self._stream: _Stream | None = None
        self._is_gone = False
        try:
            self._take_control()
            length = ctypes.c_size_t()
            place = library().arv_device_get_genicam_xml(self._device, ctypes.byref(length))
            description = ctypes.string_at(place, length.value).decode("utf-8-sig", errors="replace")
            self.features = Features(description, registers=self, name=self.name)
            self.identity = self._identity(address)
            self.tick_frequency_hz = self._tick_frequency_hz()
        except BaseException:
            library().g_object_unref(self._camera)
            raise

    def read(self, address: int, length: int) -> bytes:
        """Bytes of the camera's memory.

        Parameters
        ----------
        address
            Of the first byte.
        length
            Bytes.
        """
        self._require_there()
        if self._is_register(address, length):
            value = ctypes.c_uint32()
            call("arv_device_read_register", self._device, address, ctypes.byref(value), camera=self.name)
            return struct.pack(">I", value.value)
        content = ctypes.create_string_buffer(length)
        call("arv_device_read_memory", self._device, address, length, content, camera=self.name)
        return content.raw

    def write(self, address: int, data: bytes) -> None:
        """Set bytes of the camera's memory.

        Parameters
        ----------
        address
            Of the first byte.
        data
            What it shall hold.
        """
        self._require_there()
        if self._is_register(address, len(data)):
            value = struct.unpack(">I", data)[0]
            call("arv_device_write_register", self._device, address, value, camera=self.name)
            return
        call("arv_device_write_memory", self._device, address, len(data), data, camera=self.name)

    def require_control(self) -> None:
        """Nothing, if the camera answers and this program still controls it.

        Raises
        ------
        InstrumentSilent
            If not.
        """
        try:
            self.read(_LIFE_SIGN, 4)
        except InstrumentSilent:
            self._is_gone = True  # whatever is asked from now on would only wait
            raise
        if self.is_network and not library().arv_gv_device_is_controller(self._device):
            raise InstrumentSilent(f"{self.name} no longer knows that this program controls it; connect again")

    def start_stream(self, setup: CameraSetup, *, queue: FrameQueue, numbers: FrameNumbers) -> None:
        """Receive frames into the queue from now on.

        Parameters
        ----------
        setup
            Of the armed camera.
        queue
            Ended if the stream fails.
        numbers
            Of this acquisition.

        Raises
        ------
        InstrumentError
            If the library cannot open the stream.
        """
        payload = call("arv_camera_get_payload", self._camera, camera=self.name)
        if payload < 2 * setup.rows * setup.columns:
            raise InstrumentRefused(f"{self.name} says that a frame has {payload} bytes, too few for its pixels")
        if self.is_network:  # a packet socket, which administrators get, loses what comes before its thread is up
            library().arv_gv_device_set_stream_options(self._device, arv.ONLY_ORDINARY_SOCKETS)
        opened = call("arv_camera_create_stream", self._camera, None, None, camera=self.name)
        if self.is_network:
            arv.make_patient(opened)
        self._stream = _Stream(opened, self, payload=payload, shape=(setup.rows, setup.columns))
        self._stream.start(queue, numbers)

    def stop_stream(self) -> None:
        """Receive what is on its way and end the queue; again does no harm."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def release(self) -> None:
        """Give the camera back; again does no harm."""
        self.stop_stream()
        if self._camera:
            self.features.close()
            library().g_object_unref(self._camera)
            self._camera = None

    def _require_there(self) -> None:
        if self._is_gone:
            raise InstrumentSilent(f"{self.name} does not answer; check its cable and power, and connect again")

    def _is_register(self, address: int, length: int) -> bool:
        """In the network 32 bits go as a register: not every camera takes them as memory."""
        return self.is_network and length == 4 and address % 4 == 0

    def _take_control(self) -> None:
        """The library opens a camera that another program controls, to look at it only."""
        until = time.monotonic() + _STALE_CONTROL_S
        while self.is_network and not library().arv_gv_device_is_controller(self._device):
            if time.monotonic() > until:
                raise InstrumentRefused(f"{self.name} is controlled by another program; end that program")
            time.sleep(0.5)
            try:
                call("arv_gv_device_take_control", self._device, camera=self.name)
            except InstrumentSilent:
                raise
            except InstrumentError:
                continue

    def _identity(self, address: str) -> CameraIdentity:
        def feature(*names: str) -> str:
            return next((self.features.read(name) for name in names if self.features.has(name)), "")

        return CameraIdentity(
            vendor=feature("DeviceVendorName"),
            model=feature("DeviceModelName"),
            serial_number=feature("DeviceSerialNumber", "DeviceID"),
            firmware=feature("DeviceFirmwareVersion", "DeviceVersion"),
            address=f"aravis:{address}",
        )

    def _tick_frequency_hz(self) -> float:
        """The library gives nanoseconds for a clock whose frequency it knows; at USB the camera itself does."""
        has_clock = not self.is_network or any(self.read(_TICK_FREQUENCY, 4) + self.read(_TICK_FREQUENCY + 4, 4))
        return _NANOSECONDS_HZ if has_clock else 0.0


@final
class _Stream:
    """Buffers of the library and the thread that empties them."""

    def __init__(self, opened: Any, link: AravisLink, *, payload: int, shape: tuple[int, int]) -> None:
        self._stream, self._name, self._payload, self._shape = opened, link.name, payload, shape
        self._is_network = link.is_network
        self._no_more = Event()
        self._thread: Thread | None = None
        self._resent = self._missing = 0
        count = min(max(_BUFFER_BYTES // payload, _FEWEST_BUFFERS), _MOST_BUFFERS)
        for _ in range(count):
            buffer = library().arv_buffer_new_allocate(payload)
            self._blank(buffer)
            library().arv_stream_push_buffer(self._stream, buffer)

    def start(self, queue: FrameQueue, numbers: FrameNumbers) -> None:
        self._thread = Thread(target=self._receive, args=(queue, numbers), name=f"stream of {self._name}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._no_more.set()
        if self._thread is not None:
            self._thread.join()
        library().g_object_unref(self._stream)

    def _receive(self, queue: FrameQueue, numbers: FrameNumbers) -> None:
        failure: InstrumentError | None = None
        quiet_since_s: float | None = None
        while quiet_since_s is None or time.monotonic() - quiet_since_s < _QUIET_S:
            buffer = library().arv_stream_timeout_pop_buffer(self._stream, _WAIT_US)
            if self._no_more.is_set() and (buffer or quiet_since_s is None):
                quiet_since_s = time.monotonic()
            if not buffer:
                continue
            try:
                self._take(buffer, queue, numbers)
            except InstrumentError as error:
                failure = error
                break
            finally:
                self._blank(buffer)
                library().arv_stream_push_buffer(self._stream, buffer)
        queue.end(failure)

    def _take(self, buffer: Any, queue: FrameQueue, numbers: FrameNumbers) -> None:
        status = library().arv_buffer_get_status(buffer)
        if status in (arv.SIZE_MISMATCH, arv.UNKNOWN_PAYLOAD):
            raise InstrumentRefused(f"{self._name} sends something else than what it was set to; arm it again")
        if status not in _SENT:
            return  # given back by the library, not sent by the camera
        number = library().arv_buffer_get_frame_id(buffer)
        if number == 0 and self._is_network and status != arv.SUCCESS:
            return  # its leader is lost, and with it which frame it is: the next one shows the gap
        frame_id = numbers.frame_id(number, is_wide=number >= 2**16)
        if frame_id <= numbers.newest_id:
            return
        numbers.saw(number, frame_id=frame_id)
        frame = CameraFrame(
            pixels=self._pixels(buffer, is_whole=status == arv.SUCCESS),
            frame_id=frame_id,
            device_timestamp_ticks=library().arv_buffer_get_timestamp(buffer),
            host_time_s=time.monotonic(),
            packets_missing=0 if status == arv.SUCCESS else max(self._more("n_missing_packets"), 1),
        )
        queue.put(frame, packets_resent=self._more("n_resent_packets"))

    def _pixels(self, buffer: Any, *, is_whole: bool) -> Pixels:
        rows, columns = self._shape
        if is_whole:
            held = library().arv_buffer_get_image_height(buffer), library().arv_buffer_get_image_width(buffer)
            if held != self._shape:
                raise InstrumentRefused(
                    f"{self._name} sends {held[1]} x {held[0]} pixels, but was set to {columns} x {rows}; arm it again"
                )
        length = ctypes.c_size_t()
        place = library().arv_buffer_get_data(buffer, ctypes.byref(length))
        content = np.frombuffer(ctypes.string_at(place, 2 * rows * columns), "<u2")
        return content.reshape(self._shape)

    def _blank(self, buffer: Any) -> None:
        """What does not arrive in the next frame shall be 0, not the frame before."""
        length = ctypes.c_size_t()
        place = library().arv_buffer_get_data(buffer, ctypes.byref(length))
        ctypes.memset(place, 0, self._payload)

    def _more(self, counter: str) -> int:
        """Packets since the last call: the library counts them for the whole stream, and as missing all after the first gap."""
        total: int = library().arv_stream_get_info_uint64_by_name(self._stream, counter.encode())
        before = self._resent if counter == "n_resent_packets" else self._missing
        if counter == "n_resent_packets":
            self._resent = total
        else:
            self._missing = total
        return total - before
