"""What is fuzzed: for each kind of input some small valid ones, and the part of the program that takes them.

`FOUND` are inputs that once did harm; they are tried first, always.
"""

import io
import random
import struct
import tempfile
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any, get_args
from xml.etree import ElementTree

import frame_files
import h5py
import mutations
import numpy as np

from irtiming.acquire.journal import Journal
from irtiming.apply import camera_timing, export, handover
from irtiming.archive import layout
from irtiming.archive.captures.streams import captured_ticks
from irtiming.archive.certificate_check import check_certificate
from irtiming.archive.certificate_file import read_certificate_file
from irtiming.archive.npz_file import read_arrays
from irtiming.archive.plan_file import read_plan
from irtiming.archive.reader import read, read_acquisition, read_truth
from irtiming.archive.reference_file import read_reference
from irtiming.archive.result_file import read_result
from irtiming.archive.rig_file import read_rig
from irtiming.archive.series_file import read_series
from irtiming.archive.stamps_file import read_stamps
from irtiming.archive.timestamps_file import read_timestamps
from irtiming.archive.verify import verify
from irtiming.archive.wheel_calibration_file import read_wheel_calibration
from irtiming.errors import InstrumentError, IrTimingError
from irtiming.gateware.event_model import Latencies
from irtiming.gateware.messages import RecordMessage, ReplyMessage, pack_record, pack_reply
from irtiming.instruments.ci_sr800r import SR800R
from irtiming.instruments.generator.message_stream import MessageStream
from irtiming.instruments.generator.timestamp_stream import TimestampStream
from irtiming.instruments.genicam.frame_numbers import FrameNumbers
from irtiming.instruments.genicam.gige_assembly import FrameAssembly
from irtiming.instruments.genicam.gige_discovery import _identity
from irtiming.instruments.thorlabs_mc2000b import MC2000B
from irtiming.instruments.visa_line import Speech, TextAdapter
from irtiming.records.application import Program
from irtiming.report.calibration import dcc, page
from irtiming.report.calibration.content import ResultFile, Sheet, collect

EXAMPLES = Path(__file__).parents[2] / "examples"


@dataclass(frozen=True, kw_only=True)
class Target:
    """``take`` does with an input what the program does; only the project's own errors may come out."""

    seeds: Callable[[], list[bytes]]
    take: Callable[[bytes], object]
    changes: tuple[mutations.Mutation, ...] = (mutations.of_bytes,)


def _in_file(name: str, *takes: Callable[[Path], object]) -> Callable[[bytes], object]:
    """All of ``takes`` on a file with the input; what one refuses the next one gets all the same."""

    def take(data: bytes) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            path.write_bytes(data)
            for one in takes:
                try:
                    one(path)
                except IrTimingError as error:
                    _require_sane(error)

    return take


def _require_sane(error: IrTimingError) -> None:
    said = str(error)
    assert len(said) < 2100, f"a message of {len(said)} characters"
    assert said.isprintable(), f"a message with control characters: {said!r:.200}"


def _recording() -> bytes:
    memory, rng = io.BytesIO(), np.random.default_rng(1)
    with h5py.File(memory, "w") as file:
        _fill(file, rng)
    return memory.getvalue()


def _fill(file: h5py.File, rng: np.random.Generator) -> None:
    turn, period, n_frames = 16_384_000, 1_622_016, 12
    camera = file.create_group("entry/instrument/camera")
    camera["type"], camera["readout_mode"] = np.bytes_("photon"), "snapshot"
    camera["vendor"] = "somebody"
    frames = rng.integers(1000, 9000, (n_frames, 4, 6), dtype=np.uint16)
    camera.create_dataset("data", data=frames, chunks=(1, 4, 6), compression="gzip")
    camera["count_time"], camera["bit_depth_readout"] = 250e-6, 14
    camera["count_time"].attrs["units"] = "s"
    camera["frame_number"], camera["frame_status"] = np.arange(n_frames), np.zeros(n_frames, "u1")
    camera["frame_timestamp"], camera["timestamp_frequency"] = 1000 + 33 * np.arange(n_frames), 1e3
    file["entry/instrument/chopper/rotation_speed"] = 3.0
    lines = file.create_group("entry/instrument/trigger_generator")
    lines["clock_frequency"] = 49_152_000
    lines["camera_trigger"] = 23_384_000 + period * np.arange(n_frames)
    lines.create_dataset(
        "control_slot", data=7_000_000 + turn // 100 * np.arange(301), chunks=(50,), compression="gzip"
    )
    lines["application_slot"] = 7_000_005 + turn // 2 * np.arange(7)
    lines["camera_period"], lines["wheel_period"] = period, turn
    lines["lost_after"] = np.empty(0, "i8")
    file["entry/truth/trigger_delay_s"] = 4e-4
    file["entry/acquisition/chopper_blade"] = "MC1F100"
    for name, level in (("low", 1500), ("high", 8000)):
        frames = rng.integers(level, level + 40, (3, 4, 6), "u2")
        stack = file.create_dataset(f"entry/nonuniformity_reference/{name}", data=frames)
        stack.attrs["temperature"] = 288.15 if name == "low" else 303.15


def _of_hdf5(rng: random.Random, seed: bytes, _: object) -> bytes:
    """The recording with datasets, attributes and groups in whose places others stand."""
    memory, numbers = io.BytesIO(seed), np.random.default_rng(rng.randrange(2**32))
    with h5py.File(memory, "r+") as file:
        for _ in range(rng.choice((1, 1, 2, 4))):
            with suppress(
                OSError, RuntimeError, ValueError, TypeError, LookupError
            ):  # what HDF5 itself refuses is no change
                _change(file, rng, numbers)
    return memory.getvalue()


def _change(file: h5py.File, rng: random.Random, numbers: np.random.Generator) -> None:
    paths = _paths(file)
    path, other = rng.choice(paths), rng.choice(paths)
    match rng.randrange(6):
        case 0:
            file[path].attrs[rng.choice(("units", "temperature", "irtiming_layout"))] = _value(rng, numbers)
        case 1:
            del file[path]
        case 2 if not path.startswith(other) and not other.startswith(path):
            del file[path]
            file[path] = file[other]
        case 3 if isinstance(file[path], h5py.Dataset) and file[path].ndim == 1 and file[path].dtype.kind in "iuf":
            values, attributes = file[path][()], dict(file[path].attrs)
            place = rng.randrange(len(values)) if len(values) else 0
            odd = rng.choice((0, -1, 2**62, 2**63 - 1)) % 2 ** (8 * values.itemsize - 1)
            values[place:] = odd if rng.random() < 0.5 else values[:1].sum()
            del file[path]
            file[path] = values
            file[path].attrs.update(attributes)
        case _:
            value = _value(rng, numbers)
            del file[path]
            file[path] = value


def _paths(file: h5py.File) -> list[str]:
    found: list[str] = []
    file.visit(found.append)
    return found


def _value(rng: random.Random, numbers: np.random.Generator) -> Any:
    shape = tuple(rng.choice((0, 1, 1, 2, 12, 40)) for _ in range(rng.choice((0, 0, 1, 1, 2, 3))))
    match rng.randrange(4):
        case 0:
            text = rng.choice(("", "photon", "snapshot", "ticks", "s", "\ud7ff", "x" * 3000, "\x1b[31m"))
            return text if rng.random() < 0.5 else np.full(shape, text.encode("utf-8", "replace"))
        case 1:
            value = rng.choice((0.0, -1.0, 1e308, 5e-324, np.nan, np.inf, 3.0))
            return np.full(shape, value, dtype=rng.choice(("f4", "f8")))
        case 2:
            kind = rng.choice(("i1", "u1", "i4", "u2", "i8", "u8", "bool"))
            return np.full(shape, rng.choice((0, 1, 127)), dtype=kind)
        case _:
            return (
                numbers.integers(-(2**62), 2**62, shape)
                if rng.random() < 0.5
                else np.sort(numbers.integers(0, 10**9, shape or (1,)))
            )


def _look_at(path: Path) -> None:
    found = read(path)
    for stack in (found.frames, *([found.nonuniformity.low_frames] if found.nonuniformity else [])):
        for _ in stack.blocks():
            pass


def _verified(path: Path) -> None:
    for finding in verify(path):
        assert len(finding.sentence()) < 2100
        assert finding.sentence().isprintable()


def _exported(path: Path) -> None:
    from irtiming.archive.vcd_export import write_vcd

    write_vcd(read_timestamps(path), path.with_suffix(".vcd"))


def _capture(path: Path) -> None:
    lines = {layout.CAMERA_TRIGGER: "D0", layout.CONTROL_SLOT: "!D1", layout.APPLICATION_EDGES: "D2"}
    captured_ticks(path, lines, shortest_s=1e-7)


def _vcds() -> list[bytes]:
    head = b"$comment\n Acquisition with 3/8 channels at 24 MHz\n$end\n$timescale 100 ps $end\n$scope module l $end\n"
    lines = b"".join(b"$var wire 1 %c D%d $end\n" % (33 + i, i) for i in range(3))
    body = b"".join(b"#%d %d%c\n" % (1000 * i, i // 3 % 2, 33 + i % 3) for i in range(1, 40))
    return [head + lines + b'$upscope $end\n$enddefinitions $end\n#0 0! 1" 0#\n' + body + b"#90000\n"]


def _tables() -> list[bytes]:
    rows = [f"{i * 1e-6:.7f},{i % 2},{i // 2 % 2},{i // 4 % 2}" for i in range(60)]
    plain = "\n".join(["Time [s],D0,D1,D2", *rows]).encode() + b"\n"
    return [plain, plain.replace(b",", b";"), b"\n".join(plain.split(b"\n")[1:]).replace(b",", b"\t")]


def _stamps() -> list[bytes]:
    lines = [f"{i},{1_700_000_000_000_000_000 + 33_000_000 * i},x" for i in range(20)]
    return ["\n".join(["# a camera", "seq,stamp_ns,note", *lines]).encode(), b"t_s\n0.1\n0.2\n"]


def _hand_over(path: Path) -> None:
    given = handover.of_camera(camera_timing.of_result(read_result(path)))
    for program in get_args(Program):
        with suppress(IrTimingError):
            export.text_for(program, given)


def _sessions() -> list[bytes]:
    found = []
    for packed in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        memory = io.BytesIO()
        rows = ["[global]", "[device 1]", "capturefile=logic-1", "samplerate=24 MHz", "unitsize=1"]
        with zipfile.ZipFile(memory, "w", packed) as archive:
            archive.writestr("metadata", "\n".join([*rows, "probe1=D0", "probe2=D1", "probe3=D2"]))
            for piece in (1, 2):
                archive.writestr(f"logic-1-{piece}", bytes(i % 8 for i in range(100)))
        found.append(memory.getvalue())
    return found


def _saleae() -> list[bytes]:
    times = struct.pack("<6d", *(1e-6 * i for i in range(1, 7)))
    return [
        struct.pack("<8siiIddQ", b"<SALEAE>", 0, 0, 0, 0.0, 1e-3, 6) + times,
        struct.pack("<8siiQIdddQ", b"<SALEAE>", 1, 0, 1, 0, 24e6, 0.0, 1e-3, 6) + times,
    ]


def _take_saleae(data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for channel in range(3):
            (Path(folder) / f"digital_{channel}.bin").write_bytes(data)
        try:
            _capture(Path(folder))
        except IrTimingError as error:
            _require_sane(error)


def _npz() -> list[bytes]:
    memory, frames = io.BytesIO(), np.ones((3, 4, 6), np.uint16)
    temperatures = {"low_temperature_k": np.float64(288), "high_temperature_k": np.float64(303)}
    np.savez_compressed(memory, frames=frames, low=frames, high=frames + 3, **temperatures)
    return [memory.getvalue()]


@cache
def _documents() -> dict[str, bytes]:
    """A plan, a wheel calibration, a result and a journal, written by the program itself where it is cheap."""
    from documents import documents

    return documents()


def _certified(path: Path) -> Sheet:
    """A certificate of a result, as a page and as XML."""
    form = read_certificate_file(EXAMPLES / "certificate.toml")
    sheet = collect([ResultFile(name=path.name, sha256="0" * 64, content=read_result(path))], form)
    ElementTree.fromstring(dcc.xml(sheet, page=page.html(sheet, beside=path.parent)))
    return sheet


@cache
def _certificate() -> bytes:
    """Of the result among the documents."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "r.json"
        path.write_bytes(_documents()["result"])
        return dcc.xml(_certified(path)).encode()


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
        _require_sane(error)
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


def _told(kind: Any, names: tuple[str, ...], **options: Any) -> Callable[[bytes], object]:
    def take(data: bytes) -> None:
        speech = Speech(baud=9600, reply_s=0.0, quiet_s=0.0, ends="\r>" if kind is MC2000B else "\r\n")
        device = kind(TextAdapter(_Said(data), speech, line="fuzz"), **options)
        for name in names:
            try:
                getattr(device, name)
            except InstrumentError as error:
                _require_sane(error)

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


_TOML = (mutations.of_words, mutations.of_words, mutations.of_bytes)
_JSON = (mutations.of_json, mutations.of_json, mutations.of_bytes)

TARGETS = {
    "recording": Target(
        seeds=lambda: [_recording()],
        take=_in_file("a.nxs", _verified, _look_at, read_truth, read_acquisition, _exported, frame_files.looked_at),
        changes=(mutations.of_bytes, _of_hdf5),
    ),
    "value change dump": Target(seeds=_vcds, take=_in_file("a.vcd", _capture), changes=_TOML),
    "table": Target(seeds=_tables, take=_in_file("a.csv", _capture), changes=_TOML),
    "stamps": Target(seeds=_stamps, take=_in_file("a.csv", read_stamps), changes=_TOML),
    "sigrok session": Target(seeds=_sessions, take=_in_file("a.sr", _capture)),
    "saleae": Target(seeds=_saleae, take=_take_saleae),
    "npz": Target(
        seeds=_npz, take=_in_file("a.npz", lambda path: read_arrays(path, ["frames", "low", "high"]), read_reference)
    ),
    "rig.toml": Target(
        seeds=lambda: [path.read_bytes() for path in sorted(EXAMPLES.glob("*.rig.toml"))],
        take=_in_file("rig.toml", read_rig), changes=_TOML,
    ),
    "plan.toml": Target(
        seeds=lambda: [path.read_bytes() for path in sorted(EXAMPLES.glob("*.plan.toml"))],
        take=_in_file("plan.toml", read_series), changes=_TOML,
    ),
    "wheel.json": Target(
        seeds=lambda: [_documents()["wheel"]], take=_in_file("wheel.json", read_wheel_calibration), changes=_JSON
    ),
    "result.json": Target(
        seeds=lambda: [_documents()["result"]], take=_in_file("r.json", read_result, _hand_over), changes=_JSON
    ),
    "certificate.toml": Target(
        seeds=lambda: [(EXAMPLES / "certificate.toml").read_bytes()],
        take=_in_file("certificate.toml", read_certificate_file), changes=_TOML,
    ),
    "certificate of a result": Target(
        seeds=lambda: [_documents()["result"]], take=_in_file("r.json", _certified), changes=_JSON
    ),
    "certificate.xml": Target(
        seeds=lambda: [_certificate()], take=_in_file("certificate.xml", check_certificate), changes=_TOML
    ),
    "plan.json": Target(seeds=lambda: [_documents()["plan"]], take=_in_file("p.json", read_plan), changes=_JSON),
    "journal": Target(
        seeds=lambda: [_documents()["journal"]],
        take=_in_file("series.json", lambda path: Journal.opened(path.parent, digest="d", n_runs=2)),
        changes=_JSON,
    ),
    "trigger generator": Target(seeds=_messages, take=_line),
    "GigE Vision": Target(seeds=_packets, take=_assembled),
    "camera's answer": Target(seeds=_camera_answers, take=lambda data: _identity(data, "127.0.0.1")),
    "blackbody": Target(
        seeds=lambda: [b"IRTIMING\r\n25.000\r\n30.0\r\n1\r\nOK\r\n" * 3, b"\xaa\x01\x00\n"],
        take=_told(SR800R, _BLACKBODY, speed=1e6)
    ),
    "chopper": Target(
        seeds=lambda: [b"".join(b"%s?\r%s\r> \n" % (name, value) for name, value in (
            (b"id", b"THORLABS MC2000B"), (b"blade", b"5"), (b"ref", b"0"), (b"output", b"2"), (b"nharmonic", b"1"),
            (b"enable", b"1"), (b"input", b"300.0"), (b"locked", b"1")))],
        take=_told(MC2000B, _CHOPPER, gap_s=0.0),
    ),
}  # fmt: skip

TARGETS |= {
    f"frames {ending}": Target(
        seeds=partial(frame_files.seeds_of, ending),
        take=_in_file(f"a{ending}", frame_files.beside if ending in frame_files.TEXTS else frame_files.looked_at),
        changes=_TOML if ending in frame_files.TEXTS else (mutations.of_bytes,),
    )
    for ending in frame_files.ENDINGS
}

FOUND: dict[str, list[bytes]] = {
    "rig.toml": [b"a = " + b"9" * 5000, b"a = " + b"[" * 5000],
    "result.json": [b'{"a": ' + b"9" * 5000 + b"}", b"[" * 100_000],
    "frames .pgm": [b"P5" + b"\n# " * 100 + b"?"],
}
"""Inputs that did harm once."""
