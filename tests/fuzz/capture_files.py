"""Captures of logic analysers, stamps of frames, and arrays."""

import io
import struct
import tempfile
import zipfile
from pathlib import Path

import numpy as np
from target import OF_TEXT, Target, in_file, require_sane

from irtiming.archive import layout
from irtiming.archive.captures.streams import captured_ticks
from irtiming.archive.npz_file import read_arrays
from irtiming.archive.reference_file import read_reference
from irtiming.archive.stamps_file import read_stamps
from irtiming.errors import IrTimingError


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
            require_sane(error)


def _npz() -> list[bytes]:
    memory, frames = io.BytesIO(), np.ones((3, 4, 6), np.uint16)
    temperatures = {"low_temperature_k": np.float64(288), "high_temperature_k": np.float64(303)}
    np.savez_compressed(memory, frames=frames, low=frames, high=frames + 3, **temperatures)
    return [memory.getvalue()]


TARGETS = {
    "value change dump": Target(seeds=_vcds, take=in_file("a.vcd", _capture), changes=OF_TEXT),
    "table": Target(seeds=_tables, take=in_file("a.csv", _capture), changes=OF_TEXT),
    "stamps": Target(seeds=_stamps, take=in_file("a.csv", read_stamps), changes=OF_TEXT),
    "sigrok session": Target(seeds=_sessions, take=in_file("a.sr", _capture)),
    "saleae": Target(seeds=_saleae, take=_take_saleae),
    "npz": Target(
        seeds=_npz, take=in_file("a.npz", lambda path: read_arrays(path, ["frames", "low", "high"]), read_reference)
    ),
}
