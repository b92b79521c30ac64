"""Captures and arrays that lie or have no end: refused in one line, before memory is spent on them."""

import os
import struct
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from irtiming.archive.captures import bounds, sigrok, vcd
from irtiming.archive.captures.reading import read_capture
from irtiming.archive.npz_file import read_arrays
from irtiming.errors import ArchiveError

VCD = b"$timescale 1 ns $end\n$var wire 1 ! D0 $end\n$enddefinitions $end\n#0 0!\n"


def _sigrok(
    *, unitsize: str = "1", rate: str = "24 MHz", extra: str = "", probe: str = "probe1"
) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        rows = ["[device 1]", f"samplerate={rate}", f"unitsize={unitsize}", f"{probe}=D0", "capturefile=logic-1", extra]
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("metadata", "\n".join(rows))
            archive.writestr("logic-1-1", b"\0\1" * 50)

    return write


def _bytes(content: bytes) -> Callable[[Path], None]:
    return lambda path: path.write_bytes(content) and None


def _saleae(count: int) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        path.mkdir()
        head = struct.pack("<8siiIddQ", b"<SALEAE>", 0, 0, 0, 0.0, 1.0, count)
        (path / "digital_0.bin").write_bytes(head + bytes(80))

    return write


LIES: dict[str, tuple[Callable[[Path], None], str]] = {
    "a size that is a digit but no number": (_sigrok(unitsize="²"), "has no device with probes, samplerate and unitsize"),
    "a size of 400 digits": (_sigrok(unitsize="9" * 400), "has no device with probes, samplerate and unitsize"),
    "samples of a terabyte": (_sigrok(unitsize="100000000"), "has samples of 100000000 bytes"),
    "a rate of 5000 digits": (_sigrok(rate="9" * 5000 + " Hz"), "has no device with probes, samplerate and unitsize"),
    "a probe of 5000 digits": (_sigrok(probe="probe" + "1" * 5000), "has no device with probes"),
    "metadata that unpack into 8 MB": (_sigrok(extra="x=" + " " * 8_000_000), "bytes of metadata, at most 1048576"),
    "a line without end": (_bytes(VCD + b"1!" * 40_000 + b"\n"), "has a line of more than 65536 characters"),
    "a header without end": (_bytes(b"$comment\n" + b"x\n" * 600_000), "has a header of more than 1048576 bytes"),
    "a time of 5000 digits": (_bytes(VCD + b"#" + b"9" * 5000 + b" 1!\n"), "among its changes; export the capture again"),
    "a time beyond 63 bits": (_bytes(VCD + b"#9223372036854775808 1!\n"), "more than 63 bits cannot be meant"),
    "a row without end": (_bytes(b"Time [s],D0\n0," + b"0" * 70_000 + b"\n"), "has a line of more than 65536 characters"),
    "2^60 changes": (_saleae(2**60), "changes more than 16777216 times"),
}  # fmt: skip


@pytest.mark.parametrize("name", LIES)
def test_a_capture_that_lies_is_refused(tmp_path: Path, name: str) -> None:
    """Oracle: by hand, what each lies about; the memory that Python counts."""
    write, fragment = LIES[name]
    path = tmp_path / "capture"
    write(path)
    tracemalloc.start()
    try:
        with pytest.raises(ArchiveError) as raised:
            read_capture(path, ["D0"])
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert fragment in str(raised.value)
    assert "\n" not in str(raised.value)
    assert len(str(raised.value)) < 300
    assert most < 40e6


@pytest.mark.parametrize("kind", ["vcd", "sigrok"])
def test_a_line_that_never_rests(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    """Oracle: by hand; 99 changes in 100 samples, and a bound of 99 or of 98."""
    path = tmp_path / "capture"
    if kind == "vcd":
        path.write_bytes(VCD + b"".join(b"#%d %d!\n" % (i, i % 2) for i in range(1, 100)))
    else:
        _sigrok()(path)
    for most in (99, 98):
        for module in (bounds, vcd, sigrok):
            monkeypatch.setattr(module, "MOST_CHANGES", most)
        if most == 99:
            assert read_capture(path, ["D0"]).lines["D0"].changes.size == 99
        else:
            with pytest.raises(ArchiveError, match="changes more than 98 times"):
                read_capture(path, ["D0"])


def test_a_pipe_is_no_capture(tmp_path: Path) -> None:
    """Oracle: opening it would wait for ever."""
    os.mkfifo(tmp_path / "capture.vcd")
    with pytest.raises(ArchiveError, match="is no file but a device or a pipe"):
        read_capture(tmp_path / "capture.vcd", ["D0"])


def test_arrays_that_unpack_into_too_much(tmp_path: Path) -> None:
    """Oracle: a thousandfold by zlib on zeros; and frames of a camera, which are noise."""
    path = tmp_path / "frames.npz"
    noise = np.random.default_rng(1).integers(0, 2**14, (10, 30, 40)).astype(np.uint16)
    np.savez_compressed(path, frames=noise, other=np.zeros(10**6))
    np.testing.assert_array_equal(read_arrays(path, ["frames", "low"])["frames"], noise)
    with pytest.raises(ArchiveError, match="'other' unpacks from .* into 8000128 bytes; it may be 200 times as many"):
        read_arrays(path, ["frames", "other"])


def test_arrays_that_say_more_than_they_have(tmp_path: Path) -> None:
    """Oracle: the header of 10^12 numbers in front of none."""
    path = tmp_path / "frames.npz"
    with zipfile.ZipFile(path, "w") as archive, archive.open("frames.npy", "w") as file:
        np.lib.format.write_array_header_1_0(
            file, {"descr": "<u2", "fortran_order": False, "shape": (10**6, 10**3, 10**3)}
        )
    with pytest.raises(
        ArchiveError, match=r"'frames' says that it is uint16 \(1000000, 1000, 1000\), but has 128 bytes"
    ):
        read_arrays(path, ["frames"])
