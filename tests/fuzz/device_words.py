"""What devices say: trigger generator, camera, blackbody and chopper."""

import io
import struct
import zipfile
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from target import OF_TEXT, Target, require_sane

from irtiming.errors import InstrumentError
from irtiming.gateware.event_model import Latencies
from irtiming.gateware.messages import RecordMessage, ReplyMessage, pack_record, pack_reply
from irtiming.instruments.ci_sr800r import SR800R
from irtiming.instruments.generator.message_stream import MessageStream
from irtiming.instruments.generator.timestamp_stream import TimestampStream
from irtiming.instruments.genicam.frame_numbers import FrameNumbers
from irtiming.instruments.genicam.gige_assembly import FrameAssembly
from irtiming.instruments.genicam.gige_control import parse_place, unpacked
from irtiming.instruments.genicam.gige_discovery import _identity
from irtiming.instruments.thorlabs_mc2000b import MC2000B, _read
from irtiming.instruments.visa_line import Pace, Speech, TextAdapter
from irtiming.twin.devices.camera_faults import CameraFaults
from irtiming.twin.devices.console import obey


def _line(data: bytes) -> None:
    """The generator's bytes, to messages and timestamps."""
    messages, stamps = MessageStream(), TimestampStream(counter_ticks=0)
    n_records = 0
    for at in range(0, len(data), 7):
        for message in messages.feed(data[at : at + 7]):
            if isinstance(message, RecordMessage):
                stamps.add(message)
                n_records += 1
    stamps.close(records_written=n_records, records_lost=0)
    stamps.timestamps(
        clock_frequency_hz=48_000_000, latencies=Latencies(input_cycles=2, output_cycles=1, filter_cycles=5)
    )


def _messages() -> list[bytes]:
    records = [
        RecordMessage(channels=1 << i % 7, number=i, time_ticks=1000 * i, is_after_loss=False) for i in range(30)
    ]
    reply = ReplyMessage(refusal=0, tag=3, address=7, value=123)
    return [b"".join(map(pack_record, records)) + pack_reply(reply)]


def _packets() -> list[bytes]:
    """Three frames of 4 x 6 pixels as a GigE Vision camera sends them, each packet behind its length."""
    found = []
    for number in range(1, 4):
        pixels = bytes(range(48))
        leader = struct.pack(">HHQIIIIIHH", 0, 1, 1000 * number, 0x01100007, 6, 4, 0, 0, 0, 0)
        contents = [(1, 0, leader), (3, 1, pixels[:24]), (3, 2, pixels[24:]), (2, 3, struct.pack(">HHI", 0, 1, 4))]
        found += [struct.pack(">HHI", 0, number, kind << 24 | packet) + content for kind, packet, content in contents]
    return [b"".join(struct.pack(">H", len(packet)) + packet for packet in found)]


def _assembled(data: bytes) -> None:
    packets, lengths, at = np.zeros((40, 64), np.uint8), np.zeros(40, np.uint32), 0
    for row in range(40):
        length = min(int.from_bytes(data[at : at + 2], "big"), 64, max(0, len(data) - at - 2))
        packets[row, :length] = np.frombuffer(data[at + 2 : at + 2 + length], np.uint8)
        lengths[row], at = length, at + 2 + length
    made: list[Any] = []
    assembly = FrameAssembly(
        shape=(4, 6),
        packet_bytes=32,
        numbers=FrameNumbers(),
        deliver=lambda frame, _: made.append(frame),
        ask_again=lambda _: None,
    )
    try:
        for part in (slice(0, 7), slice(7, 20), slice(20, 40)):
            assembly.take(packets[part], lengths[part], now_s=0.1 * part.start)
        assembly.finish(now_s=10.0)
    except InstrumentError as error:
        require_sane(error)
    assert len(made) < 5000


class _Said:
    """A channel at whose other end a device has said it all beforehand."""

    def __init__(self, data: bytes) -> None:
        self._left = data

    def send(self, data: bytes) -> None:
        self._piece, _, self._left = self._left.partition(b"\n")

    def receive(self, timeout_s: float) -> bytes:
        piece, self._piece = getattr(self, "_piece", b"") if timeout_s else b"", b""
        return piece

    def close(self) -> None:
        pass


def _told(kind: Any, names: tuple[str, ...], speech: dict[str, Any], **options: Any) -> Callable[[bytes], object]:
    def take(data: bytes) -> None:
        spoken = Speech(baud=9600, reply_s=0.001, **speech)
        device = kind(TextAdapter(_Said(data), spoken, line="fuzz"), **options)
        device._pace = device._stable_pace = Pace(0.0)
        for name in names:
            try:
                _read(device, name)
            except InstrumentError as error:
                require_sane(error)

    return take


_BLACKBODY = ("greeting", "temperature_degc", "target_degc", "is_stable", "bit_error")
_CHOPPER = ("identity", "blade", "reference", "output", "harmonic_multiplier", "is_enabled", "input_hz", "says_locked")


def _camera_answers() -> list[bytes]:
    texts = (
        b"maker".ljust(32, b"\0")
        + b"model".ljust(32, b"\0")
        + b"1.0".ljust(32, b"\0")
        + bytes(48)
        + b"123".ljust(16, b"\0")
    )
    return [struct.pack(">HHHH", 0, 3, 248, 1) + bytes(72) + texts + bytes(16)]


def _described(data: bytes) -> None:
    """Where a camera's description is, and the description itself."""
    for take in (lambda: parse_place(data.split(b"\0")[0].decode("ascii", errors="replace")), lambda: unpacked(data)):
        try:
            take()
        except InstrumentError as error:
            require_sane(error)


def _descriptions() -> list[bytes]:
    found = [b"Local:Camera.zip;10000;2a0", b"<RegisterDescription/>"]
    for packed in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA):
        memory = io.BytesIO()
        with zipfile.ZipFile(memory, "w", packed) as archive:
            archive.writestr("camera.xml", "<RegisterDescription>" + "<Node/>" * 40 + "</RegisterDescription>")
        found.append(memory.getvalue())
    return found


def _console(data: bytes) -> None:
    """What somebody says to the simulated rig, and what it answers."""
    bench: Any = SimpleNamespace(
        faults={"camera": CameraFaults()}, view=SimpleNamespace(), chopper=SimpleNamespace(lose_lock=lambda share: None)
    )
    assert "\n" not in obey(bench, data.decode(errors="replace").strip())


TARGETS = {
    "trigger generator": Target(seeds=_messages, take=_line),
    "GigE Vision": Target(seeds=_packets, take=_assembled),
    "camera's answer": Target(seeds=_camera_answers, take=lambda data: _identity(data, "127.0.0.1")),
    "camera's description": Target(seeds=_descriptions, take=_described),
    "blackbody": Target(
        seeds=lambda: [b"IRTIMING\r\n25.000\r\n30.0\r\n1\r\nOK\r\n" * 3, b"\xaa\x01\x00\n"],
        take=_told(SR800R, _BLACKBODY, {"quiet_s": 0.0}, speed=1e6), round=8,
    ),
    "chopper": Target(
        seeds=lambda: [b"".join(b"%s?\r%s\r> \n" % (name, value) for name, value in (
            (b"id", b"THORLABS MC2000B"), (b"blade", b"5"), (b"ref", b"0"), (b"output", b"2"), (b"nharmonic", b"1"),
            (b"enable", b"1"), (b"input", b"300.0"), (b"locked", b"1")))],
        take=_told(MC2000B, _CHOPPER, {"ends": ">"}, gap_s=0.0), round=8,
    ),
    "console of the rig": Target(
        seeds=lambda: [b"fault camera.packets_lost_per_mille=3.5", b"fault camera.frames_lost=3,4 5", b"lose-lock 0.02"],
        take=_console, changes=OF_TEXT,
    ),
}  # fmt: skip
