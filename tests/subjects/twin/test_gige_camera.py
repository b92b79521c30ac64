"""The simulated GigE Vision camera: bytes of the standard by hand, and the clients of other people."""

import os
import shutil
import socket
import struct
import subprocess
import threading
import time
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import InstrumentError
from irtiming.twin.devices.camera_faults import CameraFaults
from irtiming.twin.devices.gige_camera import CameraTraits, GigeCamera
from irtiming.twin.devices.gige_stream import Block, Packets
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.live_camera import LiveCamera
from irtiming.twin.scene import microbolometer_scene, paper_scene

CLOCK_HZ = 48_000_000
PERIOD = 960_000  # 50 Hz
ROWS, COLUMNS = 32, 40
WIDTH, HEIGHT, OFFSET_X, FORMAT = 0x8008, 0x800C, 0x8010, 0x8018
START, STOP, TRIGGER_MODE, TRIGGER_SOURCE = 0x8104, 0x8108, 0x8114, 0x8118
CCP, HEARTBEAT, PORT, SCPS, SCDA = 0xA00, 0x938, 0xD00, 0xD04, 0xD18
_NUMBERS = count(os.getpid() % 50 * 4 + 2)


class Bench:
    """A camera at an address of its own, before a wheel that turns by itself, and a line that triggers by hand."""

    def __init__(self, *, scene=None, **options):
        scene = scene or paper_scene(ROWS, COLUMNS)
        number = next(_NUMBERS)
        self.address = f"127.{os.getpid() % 199 + 2}.{number // 250}.{number % 250 + 1}"
        self.wheel = DrivenWheel(scene, clock_frequency_hz=CLOCK_HZ, seed=3)
        self.live = LiveCamera(scene, self.wheel, clock_frequency_hz=CLOCK_HZ, seed=11)
        self.camera = GigeCamera(self.live, self.address, **options)
        self._is_over = threading.Event()
        self._turner = threading.Thread(target=self._turn)

    def __enter__(self):
        self.live.__enter__()
        self.camera.__enter__()
        self._turner.start()
        return self

    def __exit__(self, *error):
        self._is_over.set()
        self._turner.join()
        self.camera.__exit__(*error)
        self.live.__exit__(*error)

    def _turn(self):
        cycle = 0
        while not self._is_over.wait(0.004):
            cycle += 4 * CLOCK_HZ // 1000
            self.wheel.turn(cycle, slot_period_cycles=160_000)

    def pull(self, n):
        """Trigger n frames; cycles of the edges."""
        first = self.wheel.turned_until_cycle + PERIOD
        edges = first + PERIOD * np.arange(n)
        self.live.trigger(edges)
        return edges


class Client:
    """Speaks GVCP and hears GVSP by hand."""

    def __init__(self, address):
        self.address = address
        self.control, self.stream = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        for one in (self.control, self.stream):
            one.bind(("127.0.0.1", 0))
            one.settimeout(3)
        self.identifier = 0

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.control.close()
        self.stream.close()

    def ask(self, command, content=b"", *, flags=1):
        """Status, command of the answer, and its content."""
        self.identifier += 1
        message = struct.pack(">BBHHH", 0x42, flags, command, len(content), self.identifier) + content
        self.control.sendto(message, (self.address, 3956))
        answer, sender = self.control.recvfrom(2048)
        assert sender == (self.address, 3956)
        status, acknowledged, size, identifier = struct.unpack(">HHHH", answer[:8])
        assert (size, identifier) == (len(answer) - 8, self.identifier)
        return status, acknowledged, answer[8:]

    def write(self, address, value):
        return self.ask(0x82, struct.pack(">II", address, value))[0]

    def read(self, address):
        status, _, content = self.ask(0x80, struct.pack(">I", address))
        assert status == 0
        return int.from_bytes(content)

    def take_control(self, *, line=True):
        host = struct.unpack(">I", socket.inet_aton("127.0.0.1"))[0]
        wanted = [(CCP, 2), (SCDA, host), (PORT, self.stream.getsockname()[1]), (SCPS, 576)]
        for address, value in [*wanted, (TRIGGER_MODE, 1), (TRIGGER_SOURCE, int(line))]:
            assert self.write(address, value) == 0

    def packets(self, *, quiet_s=0.25, wait_s=None):
        """What arrives until it is quiet, the first within ``wait_s``: (status, block, kind, packet, content)."""
        found = []
        while True:
            self.stream.settimeout(wait_s if wait_s and not found else quiet_s)
            try:
                packet = self.stream.recv(20_000)
            except TimeoutError:
                return found
            status, block, word = struct.unpack(">HHI", packet[:8])
            found.append((status, block, word >> 24, word & 0xFFFFFF, packet[8:]))


def _blocks(packets):
    """Leader and image of each block, by its identifier."""
    blocks = {}
    for _, block, kind, packet, content in packets:
        found = blocks.setdefault(block, SimpleNamespace(data={}, leader=None, trailer=None))
        if kind == 1:
            fields = struct.unpack(">HHQ5IHH", content)
            names = ("payload", "timestamp", "pixel_format", "width", "height", "offset_x", "offset_y")
            found.leader = SimpleNamespace(**dict(zip(names, fields[1:8], strict=True)))
        elif kind == 2:
            found.trailer = struct.unpack(">HHI", content)
        else:
            found.data[packet] = content
    for found in blocks.values():
        found.pixels = np.frombuffer(b"".join(found.data[k] for k in sorted(found.data)), "<u2")
    return blocks


@pytest.fixture
def bench():
    with Bench() as made:
        yield made


@pytest.fixture
def client(bench):
    with Client(bench.address) as made:
        yield made


def _wait(condition, *, limit_s=5.0):
    until = time.monotonic() + limit_s
    while not condition() and time.monotonic() < until:
        time.sleep(0.01)
    assert condition()


def test_discovery_tells_who_it_is(bench, client):
    """Oracle: offsets of the discovery acknowledge in the standard (1.2, 14.3)."""
    status, acknowledged, content = client.ask(0x0002, flags=0x11)
    assert (status, acknowledged, len(content)) == (0, 0x0003, 248)
    assert struct.unpack(">HH", content[:4]) == (1, 2)
    assert socket.inet_ntoa(content[36:40]) == bench.address
    texts = [content[at : at + size].split(b"\0")[0] for at, size in ((72, 32), (104, 32), (216, 16))]
    assert texts == [b"irtiming", b"Twin photon camera", b"TWIN0001"]


def test_discovery_by_broadcast_on_the_loopback_interface(bench, client):
    """Oracle: the sender of one of the answers is the camera."""
    client.control.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
    client.control.sendto(bytes.fromhex("4211000200000001"), ("127.255.255.255", 3956))
    senders = set()
    while bench.address not in senders:
        senders.add(client.control.recvfrom(2048)[1][0])


def test_registers_read_and_write_as_the_standard_says(client):
    """Oracle: commands and status codes of the standard (1.2, 14.4 to 14.7 and 15.2), by hand."""
    assert client.read(WIDTH) == COLUMNS
    assert client.write(WIDTH, 20) == 0x8006  # no control yet
    client.take_control()
    assert client.ask(0x82, struct.pack(">4I", WIDTH, 20, OFFSET_X, 8)) == (0, 0x83, struct.pack(">HH", 0, 2))
    status, acknowledged, content = client.ask(0x80, struct.pack(">3I", WIDTH, OFFSET_X, HEIGHT))
    assert (status, acknowledged, struct.unpack(">3I", content)) == (0, 0x81, (20, 8, ROWS))
    assert client.ask(0x86, struct.pack(">I16s", 0xE8, b"on the bench")) == (0, 0x87, struct.pack(">HH", 0, 16))
    status, acknowledged, content = client.ask(0x84, struct.pack(">IHH", 0xE8, 0, 16))
    assert (status, acknowledged, content) == (0, 0x85, struct.pack(">I16s", 0xE8, b"on the bench"))
    assert client.write(WIDTH, COLUMNS) == 0x8002  # more than is left behind the offset
    assert client.write(0x48, 1) == 0x8004
    assert client.write(0x7FFC, 1) == 0x8003
    assert client.write(WIDTH + 1, 1) == 0x8005
    assert client.ask(0x84, struct.pack(">IHH", 0xE8, 0, 6))[0] == 0x8005
    assert client.ask(0x84, struct.pack(">IHH", 0xE8, 0, 2000))[0] == 0x8002
    assert client.ask(0x00C0)[0] == 0x8001
    assert client.ask(0x80, b"\0\0")[0] == 0x800E


def test_what_is_no_command_has_no_answer(client):
    """Oracle: silence after a wrong key, a short datagram and a command without acknowledge; then the camera answers."""
    read_version = "0004000100000000"
    for message in ("4301" + "0080" + read_version, "42", "4200" + "0080" + read_version):
        client.control.sendto(bytes.fromhex(message), (client.address, 3956))
    client.control.settimeout(0.2)
    with pytest.raises(TimeoutError):
        client.control.recv(100)
    assert client.read(HEIGHT) == ROWS


def test_one_client_has_control_until_its_heartbeat_stops(bench, client):
    """Oracle: the standard: status ACCESS_DENIED for others; after 0.5 s of silence control is free and the stream ends."""
    client.take_control()
    assert client.write(HEARTBEAT, 500) == 0
    assert client.write(START, 1) == 0
    with Client(bench.address) as other:
        assert other.write(CCP, 2) == 0x8006
        assert other.write(WIDTH, 20) == 0x8006
        assert other.read(CCP) == 2
        for _ in range(4):
            time.sleep(0.2)
            assert client.read(CCP) == 2  # a heartbeat
        _wait(lambda: other.read(CCP) == 0, limit_s=2.0)
        assert other.read(PORT) == 0
        other.take_control()
        assert client.write(WIDTH, 20) == 0x8006
        assert other.write(CCP, 1) == 0
        assert client.ask(0x80, struct.pack(">I", WIDTH))[0] == 0x8006  # exclusive: not even reading


def test_the_description_names_every_feature_and_each_can_be_read(client):
    """Oracle: EMVA's GenApi, which parses the XML and reads each feature through the registers."""
    genapi = pytest.importorskip("genicam.genapi")
    _, _, content = client.ask(0x84, struct.pack(">IHH", 0x200, 0, 512))
    name, address, size = content[4:].split(b"\0")[0].decode().split(";")
    assert name.startswith("Local:")
    first, size = int(address, 16), int(size, 16)
    chunks = [
        client.ask(0x84, struct.pack(">IHH", first + at, 0, min(512, -(-(size - at) // 4) * 4)))[2][4:]
        for at in range(0, size, 512)
    ]
    client.take_control()

    class Port(genapi.AbstractPort):
        def read(self, address, length):
            return client.ask(0x84, struct.pack(">IHH", address, 0, length))[2][4:]

        def write(self, address, value):
            assert client.write(address, int.from_bytes(bytes(value))) == 0

        def get_access_mode(self):
            return genapi.EAccessMode.RW

    nodes, port = genapi.NodeMap(), Port()
    nodes.load_xml_from_string(b"".join(chunks)[:size].decode())
    nodes.connect(port, "Device")
    names = (
        "DeviceVendorName DeviceModelName DeviceSerialNumber DeviceFirmwareVersion DeviceVersion Width Height WidthMax "
        "HeightMax OffsetX OffsetY PixelFormat PayloadSize AcquisitionMode AcquisitionFrameRate TriggerSelector TriggerMode "
        "TriggerSource TriggerActivation ExposureTime GevSCPSPacketSize GevTimestampTickFrequency TLParamsLocked "
        "DeviceTemperature GevHeartbeatTimeout GevCCP PixelDynamicRangeMax SensorShutterMode"
    )
    values = {name: getattr(nodes, name).value for name in names.split()}
    assert values["PayloadSize"] == ROWS * COLUMNS * 2
    assert values["ExposureTime"] == pytest.approx(250.0)
    assert (values["TriggerSource"], values["TriggerMode"], values["PixelFormat"]) == ("Line1", "On", "Mono16")
    assert values["GevTimestampTickFrequency"] == 1_000_000_000
    assert (values["GevSCPSPacketSize"], values["PixelDynamicRangeMax"]) == (576, 16383)
    nodes.ExposureTime.value = 100.0
    nodes.Width.value = 16
    nodes.GevSCPSPacketSize.value = 1500
    assert (nodes.ExposureTime.value, nodes.Width.value, client.read(SCPS)) == (100.0, 16, 1500)
    nodes.GevTimestampControlLatch.execute()
    assert nodes.GevTimestampValue.value >= 5_000_000_000


def test_images_come_as_the_standard_says(bench, client):
    """Oracle: leader, data and trailer of the standard (1.2, 22 to 24) by hand; block 1 again after a stop."""
    client.take_control()
    detector = bench.live.scene.detector
    for _ in range(2):
        assert client.write(START, 1) == 0
        assert client.write(WIDTH, 20) == 0x8004  # locked
        bench.pull(3)
        packets = client.packets(wait_s=10)
        assert client.write(STOP, 1) == 0
        per_packet = 576 - 36
        n = -(-ROWS * COLUMNS * 2 // per_packet)
        assert [(p[1], p[3]) for p in packets] == [(block, k) for block in (1, 2, 3) for k in range(n + 2)]
        assert {len(p[4]) for p in packets if p[2] == 3} == {per_packet, ROWS * COLUMNS * 2 - (n - 1) * per_packet}
        blocks = _blocks(packets)
        for block in blocks.values():
            leader = block.leader
            assert (leader.payload, leader.pixel_format) == (1, 0x01100007)
            assert (leader.width, leader.height, leader.offset_x, leader.offset_y) == (COLUMNS, ROWS, 0, 0)
            assert block.trailer == (0, 1, ROWS)
            assert block.pixels.size == ROWS * COLUMNS
            assert detector.saturation_dn >= block.pixels.max() > block.pixels.min() > 0
        period_ns = np.diff([blocks[k].leader.timestamp for k in (1, 2, 3)])
        assert period_ns == pytest.approx(20e6 * (1 + 7e-6), abs=6 * 50 * 2)  # jitter of the camera


def test_a_part_of_the_image_and_eight_bits(bench, client):
    """Oracle: counting the bytes; values of 14 bits shifted by six."""
    client.take_control()
    for address, value in ((WIDTH, 20), (HEIGHT, 16), (OFFSET_X, 4), (FORMAT, 0x01080001)):
        assert client.write(address, value) == 0
    client.write(START, 1)
    bench.pull(1)
    block = _blocks(client.packets(wait_s=10))[1]
    assert (block.leader.width, block.leader.height, block.leader.offset_x) == (20, 16, 4)
    data = np.frombuffer(block.pixels.tobytes(), np.uint8)
    assert data.size == 320
    scene = bench.live.scene.radiance
    assert scene.level_dn(scene.wheel_k) / 64 * 0.5 < data.mean() < scene.level_dn(scene.blackbody_k) / 64 * 1.1


def test_block_identifiers_wrap_to_one():
    """Oracle: the standard: 16 bits, 0 is never used."""
    block = {
        "timestamp": 0,
        "pixel_format": 0,
        "width": 2,
        "height": 2,
        "offset_x": 0,
        "offset_y": 0,
        "pixels": b"12345678",
    }
    identifiers = [Block(number=number, **block).block_id for number in (0, 65533, 65534, 65535, 2 * 65535)]
    assert identifiers == [1, 65534, 65535, 1, 1]
    packets = Packets(Block(number=65534, **block), 5)
    assert [packets.packet(k)[2:4] for k in range(packets.count)] == [b"\xff\xff"] * 4


def test_packets_are_sent_again_on_demand(bench, client):
    """Oracle: the bytes of the first time; for a block that never was, the status PACKET_UNAVAILABLE."""
    client.take_control()
    client.write(START, 1)
    bench.pull(1)
    first = client.packets(wait_s=10)
    client.stream.sendto(struct.pack(">BBHHHHHII", 0x42, 0, 0x40, 12, 9, 0, 1, 2, 3), (bench.address, 3956))
    assert client.packets(wait_s=10) == first[2:4]
    client.stream.sendto(struct.pack(">BBHHHHHII", 0x42, 0, 0x40, 12, 9, 0, 7, 2, 2), (bench.address, 3956))
    ((status, block, _, packet, content),) = client.packets(wait_s=10)
    assert (status, block, packet, content) == (0x800C, 7, 2, b"")
    bench.camera.faults.resend_honoured = False
    client.stream.sendto(struct.pack(">BBHHHHHII", 0x42, 0, 0x40, 12, 9, 0, 1, 2, 3), (bench.address, 3956))
    assert client.packets() == []


def test_a_test_packet_has_the_size_that_is_asked_for(bench, client):
    """Oracle: the packet size less 28 bytes of IP and UDP headers."""
    client.take_control()
    for size in (576, 1500, 9000):
        assert client.write(SCPS, 1 << 31 | 1 << 30 | size) == 0
        assert len(client.stream.recv(20_000)) == size - 28
        assert client.read(SCPS) == 1 << 30 | size
    assert client.write(SCPS, 9004) == 0x8002


def test_triggers_and_frames_that_are_missed_lost_or_too_many(bench, client):
    """Oracle: by hand: of eight triggers no. 1 is missed (no gap), block of no. 3 is lost, after no. 5 comes another."""
    faults = bench.camera.faults
    faults.triggers_missed, faults.frames_lost, faults.frames_spurious = frozenset({1}), frozenset({3}), frozenset({5})
    client.take_control()
    client.write(START, 1)
    bench.pull(8)
    blocks = _blocks(client.packets(wait_s=10))
    assert sorted(blocks) == [1, 2, 4, 5, 6, 7, 8]
    since_ms = {k: (block.leader.timestamp - blocks[1].leader.timestamp) / 1e6 for k, block in blocks.items()}
    assert [round(since_ms[k] / 20) for k in (2, 4, 5, 7, 8)] == [2, 4, 5, 6, 7]
    assert np.array_equal(blocks[5].pixels, blocks[6].pixels)


def test_a_frozen_camera_without_clock_repeats_itself(bench, client):
    """Oracle: equality of the pixels, and 0."""
    client.take_control()
    client.write(START, 1)
    bench.pull(2)
    moving = _blocks(client.packets(wait_s=10))
    bench.camera.faults.frozen, bench.camera.faults.has_timestamps = True, False
    bench.pull(2)
    frozen = _blocks(client.packets(wait_s=10))
    assert not np.array_equal(moving[1].pixels, moving[2].pixels)
    assert all(np.array_equal(frozen[k].pixels, moving[2].pixels) for k in (3, 4))
    assert [frozen[k].leader.timestamp for k in (3, 4)] == [0, 0]


def test_an_unplugged_camera_is_silent(bench, client):
    """Oracle: no answer and no packet, and both again when it is plugged in."""
    client.take_control()
    client.write(START, 1)
    bench.camera.faults.unplugged = True
    bench.pull(2)
    assert client.packets() == []
    client.control.settimeout(0.2)
    with pytest.raises(TimeoutError):
        client.read(WIDTH)
    bench.camera.faults.unplugged = False
    client.control.settimeout(3)
    _wait(lambda: client.read(WIDTH) == COLUMNS)


def test_packets_come_to_harm_as_often_as_is_asked_for_and_the_same_with_the_same_seed():
    """Oracle: binomial standard deviation over 20000 packets."""
    every, n = list(range(200)), 20_000
    harm = {"packets_lost_per_mille": 50.0, "packets_doubled_per_mille": 20.0, "packets_late_per_mille": 30.0}
    arrived = [CameraFaults(seed=4, **harm).arriving(every, index=(block, 0)) for block in range(100)]
    again = [CameraFaults(seed=4, **harm).arriving(every, index=(block, 0)) for block in range(100)]
    assert arrived == again != [CameraFaults(seed=5, **harm).arriving(every, index=(block, 0)) for block in range(100)]
    lost = n - sum(len(set(packets)) for packets in arrived)
    doubled = sum(len(packets) - len(set(packets)) for packets in arrived)
    late = sum(int(np.count_nonzero(np.diff(packets) < 0)) for packets in arrived)
    assert abs(lost - 1000) < 4 * np.sqrt(1000)
    assert abs(doubled - 0.95 * 400) < 4 * np.sqrt(400)
    assert 300 < late < 700
    assert CameraFaults().arriving(every, index=(0, 0)) == every


def test_an_address_in_use_or_of_another_computer_is_refused_in_one_line(bench):
    """Oracle: the message names address, port and what to do."""
    for address in (bench.address, "198.51.100.7"):
        with pytest.raises(InstrumentError, match=rf"^cannot serve a camera at {address} port 3956 .*; take .*$"):
            GigeCamera(bench.live, address)


def test_a_microbolometer_has_no_exposure_time_and_a_clock_of_its_own():
    """Oracle: registers by hand; a clock of 125 MHz that runs 100 ppm fast and began at 7."""
    traits = CameraTraits(timestamp_frequency_hz=125_000_000, clock_error=1e-4, counter_start_ticks=7)
    with Bench(scene=microbolometer_scene(ROWS, COLUMNS), traits=traits) as bench, Client(bench.address) as client:
        assert client.read(0x8128) == 0
        assert client.read(0x8020) == 1
        assert client.read(0x940) == 125_000_000
        assert bench.camera.timestamp_at(CLOCK_HZ) == 7 + 125_012_500
        client.take_control()
        assert client.write(0x8124, struct.unpack(">I", struct.pack(">f", 100.0))[0]) == 0x8002
        client.write(START, 1)
        bench.pull(1)
        assert _blocks(client.packets(wait_s=10))[1].leader.timestamp > 7


def test_its_client_in_pygigevision_and_genicam_streams_from_it(bench):
    """Oracle: pyGigEVision and EMVA's GenApi: all frames whole and in order, pixels as delivered to the stream."""
    gigevision, genapi = pytest.importorskip("pyGigEVision"), pytest.importorskip("genicam.genapi")
    camera = gigevision.GVCPClient(bench.address)
    camera.connect()
    receiver = gigevision.GVSPReceiver(
        local_ip="127.0.0.1", packet_size=1400 - 28, camera_ip=bench.address, max_queue=100
    )
    try:
        _, address, size = camera.read_mem(0x200, 512).split(b"\0")[0].decode().split(";")

        class Port(genapi.AbstractPort):
            def read(self, address, length):
                return bytes(camera.read_mem(address, length))

            def write(self, address, value):
                camera.write_reg(address, int.from_bytes(bytes(value)))

            def get_access_mode(self):
                return genapi.EAccessMode.RW

        nodes, port = genapi.NodeMap(), Port()
        nodes.load_xml_from_string(camera.read_mem(int(address, 16), int(size, 16)).decode())
        nodes.connect(port, "Device")
        nodes.TriggerMode.value, nodes.TriggerSource.value = "On", "Line1"
        nodes.GevSCPSPacketSize.value = 1400
        nodes.GevSCDA.value, nodes.GevSCPHostPort.value = 0x7F000001, receiver.port
        receiver.start()
        nodes.AcquisitionStart.execute()
        bench.pull(20)
        found = [receiver.get_frame_with_info(timeout=3) for _ in range(20)]
        nodes.AcquisitionStop.execute()
    finally:
        receiver.close()
        camera.disconnect()
    assert [info["block_id"] for _, info in found] == list(range(1, 21))
    assert all(info["complete"] and frame.shape == (ROWS, COLUMNS) for frame, info in found)
    assert bench.live.scene.radiance.level_dn(280) < np.mean([frame.mean() for frame, _ in found]) < 16383


def _run(*command):
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not installed (Debian: aravis-tools, aravis-tools-cli)")
    return subprocess.run(command, capture_output=True, text=True, timeout=30, check=False).stdout


def test_aravis_lists_and_sets_its_features(bench):
    """Oracle: Aravis' command line tool."""
    values = _run("arv-tool-0.8", "-a", bench.address, "values")
    for line in ("'DeviceModelName' = 'Twin photon camera'", "'PayloadSize' = 2560 B", "'ExposureTime' = 250 us"):
        assert line in values
    names = "TriggerMode=On TriggerSource=Line1 Width=20 PayloadSize AcquisitionFrameRate=121"
    told = _run("arv-tool-0.8", "-a", bench.address, "control", *names.split())
    assert "TriggerSource = Line1" in told
    assert "PayloadSize = 1280 B" in told
    assert "AcquisitionFrameRate = 121 Hz" in told


@pytest.mark.parametrize("per_mille", [0.0, 100.0], ids=["whole", "lossy"])
def test_aravis_streams_from_it_and_gets_lost_packets_again(bench, per_mille):
    """Oracle: Aravis' own counters: no frame fails, however many packets were lost and sent again.

    How many frames come in two seconds is the machine's business; where it is busy it gets five, then twenty.
    """
    bench.camera.faults.packets_lost_per_mille = per_mille
    for seconds in (2, 5, 20):
        told = _run(
            "arv-camera-test-0.8", "-n", bench.address, f"--duration={seconds}", "-f", "50", "-i", "220", "-j", "never",
            "-q", "2.0", "-p", "100", "-m", "2000",
        )  # fmt: skip
        numbers = dict(line.split("=") for line in told.replace(" ", "").splitlines() if line.startswith("n_"))
        if int(numbers["n_completed_buffers"]) >= 8:
            break
    assert int(numbers["n_completed_buffers"]) >= 8
    assert int(numbers["n_failures"]) <= 1  # the last frame may be under way
    assert per_mille == 0 or int(numbers["n_resent_packets"]) > 0
