"""Captures of logic analysers: each format, and what is wrong with damaged ones."""

import struct
import zipfile
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from irtiming.archive.captures.capture import PICOSECONDS, Capture
from irtiming.archive.captures.reading import read_capture
from irtiming.errors import ArchiveError

RATE_HZ = 24_000_000
LAST = 4799
NAMES = ("D0", "D1", "D2")
CODES = '!"#'
INITIAL = (0, 1, 0)
SAMPLES = ((100, 148, 2500, 2548), (7, 50, 1000, 1500, 4700), (7, 4799))
"""Samples in which each line had changed."""

SIGROK_VCD = b"""$date Sat Nov 21 21:12:32 2026 $end
$version libsigrok 0.5.2 $end
$comment
  Acquisition with 3/8 channels at 24 MHz
$end
$timescale 100 ps $end
$scope module libsigrok $end
$var wire 1 ! D0 $end
$var wire 1 " D1 $end
$var wire 1 # D2 $end
$upscope $end
$enddefinitions $end
#0 0! 1" 0#
"""


def _levels() -> np.ndarray:
    """Level of each line in each sample, shape (sample, line)."""
    sample = np.arange(LAST + 1)
    return np.array([(np.searchsorted(at, sample, "right") + i) % 2 for at, i in zip(SAMPLES, INITIAL, strict=True)]).T


def _as_vcd(path: Path) -> None:
    """As sigrok writes it: in units of 100 ps, several changes in a row."""
    rows = [SIGROK_VCD]
    levels = _levels()
    for sample in sorted({at for line in SAMPLES for at in line}):
        time = round(Fraction(sample, RATE_HZ) * 10**10)
        changed = [f"{levels[sample, i]}{CODES[i]}" for i in range(3) if sample in SAMPLES[i]]
        rows.append(f"#{time} {' '.join(changed)}\n".encode())
    path.write_bytes(b"".join([*rows, b"#2000000\n"]))


def _as_csv(path: Path) -> None:
    """As Logic 2 writes it: a row for each change."""
    rows = ["Time [s],D0,D1,D2", "0.000000000,0,1,0"]
    levels = _levels()
    changed = sorted({at for line in SAMPLES for at in line})
    rows += [f"{at / RATE_HZ:.12f},{levels[at, 0]},{levels[at, 1]},{levels[at, 2]}" for at in changed]
    path.write_text("\n".join(rows) + "\n")


def _as_samples(path: Path) -> None:
    """A table with every sample, in microseconds, separated by semicolons, with a comment."""
    rows = ["# a comment", "Time (us);D0;D1;D2"]
    rows += [f"{i / RATE_HZ * 1e6:.6f};{a};{b};{c}" for i, (a, b, c) in enumerate(_levels())]
    path.write_text("\n".join(rows))


def _as_saleae(path: Path, *, version: int) -> None:
    path.mkdir()
    for channel, (initial, samples) in enumerate(zip(INITIAL, SAMPLES, strict=True)):
        bounds = (0.0, LAST / RATE_HZ)
        head = struct.pack("<8sii", b"<SALEAE>", version, 0)
        if version == 0:
            head += struct.pack("<IddQ", initial, *bounds, len(samples))
        else:
            head += struct.pack("<QIdddQ", 1, initial, float(RATE_HZ), *bounds, len(samples))
        data = struct.pack(f"<{len(samples)}d", *(at / RATE_HZ for at in samples))
        (path / f"digital_{channel}.bin").write_bytes(head + data)


def _as_sigrok(path: Path, *, unit_bytes: int = 1, bits: tuple[int, ...] = (0, 1, 2), piece: int = 1001) -> None:
    """Pieces that end within a sample, lines that may lie in any byte, and other lines that never rest."""
    noise = np.random.default_rng(1).integers(0, 256, (LAST + 1, unit_bytes), dtype=np.uint8)
    for bit, level in zip(bits, _levels().T, strict=True):
        noise[:, bit // 8] &= np.uint8(255 - (1 << bit % 8))
        noise[:, bit // 8] |= (level << bit % 8).astype(np.uint8)
    data = noise.tobytes()
    rows = ["[global]", "sigrok version=0.5.2", "", "[device 1]", "capturefile=logic-1", "total probes=16"]
    rows += ["samplerate=24 MHz", "total analog=0", *(f"probe{b + 1}=D{i}" for i, b in enumerate(bits))]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("version", "2")
        archive.writestr("metadata", "\n".join([*rows, f"unitsize={unit_bytes}", ""]))
        for number, at in enumerate(range(0, len(data), piece), start=1):
            archive.writestr(f"logic-1-{number}", data[at : at + piece])


FORMATS: dict[str, Callable[[Path], None]] = {
    "vcd": _as_vcd,
    "csv of changes": _as_csv,
    "csv of samples": _as_samples,
    "saleae 0": lambda path: _as_saleae(path, version=0),
    "saleae 1": lambda path: _as_saleae(path, version=1),
    "sigrok": _as_sigrok,
    "sigrok, two bytes": lambda path: _as_sigrok(path, unit_bytes=2, bits=(3, 8, 15)),
}


def _in_samples(capture: Capture) -> list[list[int]]:
    per_count = RATE_HZ / capture.counts_per_second
    return [[round(count * per_count) for count in capture.lines[name].changes.tolist()] for name in NAMES]


def _refused_or_read(path: Path) -> Capture | ArchiveError:
    try:
        return read_capture(path, NAMES)
    except ArchiveError as error:
        return error


@pytest.mark.parametrize("kind", FORMATS)
def test_each_format_gives_the_lines_that_were_written(kind, tmp_path):
    """Oracle: the samples above, to the sample."""
    path = tmp_path / "capture"
    FORMATS[kind](path)
    capture = read_capture(path, NAMES)
    assert _in_samples(capture) == [list(line) for line in SAMPLES]
    assert tuple(capture.lines[name].initial for name in NAMES) == INITIAL
    assert round(capture.begin * RATE_HZ / capture.counts_per_second) == 0
    assert round(capture.end * RATE_HZ / capture.counts_per_second) in (LAST, LAST + 1)
    tells_rate = {"vcd", "saleae 1", "sigrok", "sigrok, two bytes"}
    assert capture.sample_rate_hz == (RATE_HZ if kind in tells_rate else None)


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("wanted", [("D2",), ("D1", "D1"), ("2", "D0")])
def test_lines_can_be_named_by_number_and_alone(kind, wanted, tmp_path):
    """Oracle: the samples above."""
    path = tmp_path / "capture"
    FORMATS[kind](path)
    capture = read_capture(path, wanted)
    assert set(capture.lines) == set(wanted)
    for name in wanted:
        counts = capture.lines[name].changes.tolist()
        assert [round(c * RATE_HZ / capture.counts_per_second) for c in counts] == list(SAMPLES[int(name[-1])])


@pytest.mark.parametrize("kind", FORMATS)
def test_a_line_that_is_not_there_is_told_with_those_that_are(kind, tmp_path):
    """Oracle: one line that names the wrong line and a right one."""
    path = tmp_path / "capture"
    FORMATS[kind](path)
    with pytest.raises(ArchiveError, match=r"'D9' is no line of the capture; name one of .*[ l]?'?(D|Channel )0'"):
        read_capture(path, ["D0", "D9"])


@pytest.mark.parametrize("kind", FORMATS)
def test_a_capture_that_is_cut_anywhere_is_refused_or_ends_early(kind, tmp_path):
    """Oracle: the lines that were written; what is read of a cut file is their beginning, never anything else."""
    path = tmp_path / "capture"
    FORMATS[kind](path)
    target = path / "digital_1.bin" if path.is_dir() else path
    whole = target.read_bytes()
    refused = 0
    for keep in range(0, len(whole) - 1, max(1, len(whole) // 150)):
        target.write_bytes(whole[:keep])
        capture = _refused_or_read(path)
        if isinstance(capture, ArchiveError):
            refused += 1
            assert "\n" not in str(capture)
            assert str(path) in str(capture)
            continue
        assert not kind.startswith(("sigrok", "saleae"))  # those tell how long they are
        for found, line in zip(_in_samples(capture), SAMPLES, strict=True):
            assert found == list(line[: len(found)])
    assert refused > 10


@pytest.mark.parametrize("kind", FORMATS)
def test_a_damaged_byte_never_ends_in_a_traceback(kind, tmp_path):
    """Oracle: only ArchiveError may be raised; 150 bytes are changed, one at a time."""
    path = tmp_path / "capture"
    FORMATS[kind](path)
    target = path / "digital_1.bin" if path.is_dir() else path
    whole = bytearray(target.read_bytes())
    random = np.random.default_rng(2)
    refused = 0
    for at in random.integers(0, len(whole), 150).tolist():
        damaged = whole.copy()
        damaged[at] ^= int(random.integers(1, 256))
        target.write_bytes(damaged)
        capture = _refused_or_read(path)
        if isinstance(capture, ArchiveError):
            refused += 1
            assert "\n" not in str(capture)
    assert refused > 0


def _vcd(body: str, *, head: str = "") -> str:
    return f"$timescale 1 us $end\n$var wire 1 ! D0 $end\n{head}$enddefinitions $end\n{body}"


BUS = '$var wire 4 " D1 $end\n'
NUMPY = b"\x93NUMPY\x01\x00v\x00{'descr': '<u2'}"


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", "is empty \\(0 bytes\\)"),
        (NUMPY, "is no capture that can be read"),
        ("hello\n", "begins with 'hello', which is no table"),
        ("<SALEAE>....", "give the folder that holds all of them"),
        (_vcd("#0\n0!\n#5\nx!\n#9\n1!\n"), "line 'D0' was not recorded at 5 µs: data were lost there"),
        (_vcd("#0\n#5\n1!\n"), "line 'D0' was not recorded at 0 s"),
        (_vcd("#0\n0!\n#5\n$dumpoff\nx!\n$end\n#7\n$dumpon\n1!\n$end\n"), "was not recorded at 5 µs"),
        (_vcd("#0\n0!\n#5\n1!\n#4\n0!\n"), "its times go back at 5 µs"),
        (_vcd("#0\n0!\n#5\n1!"), "ends in the middle of a line: the file is cut short"),
        (_vcd("#0\n0!\nfoo\n#5\n1!\n"), "holds 'foo' among its changes"),
        (_vcd(f"#0\n0!\n#{10**19}\n1!\n"), "more than 63 bits"),
        (_vcd("#0\nb0000 \"\n", head=BUS).replace("D0", "X").replace("D1", "D0"), "is a bus of 4 lines"),
        ("$timescale 1 us $end\n$var wire 1 ! D0 $end\n", "has no \\$enddefinitions: the file is cut short"),
        ("$var wire 1 ! D0 $end\n$enddefinitions $end\n#0\n0!\n", "has no \\$timescale"),
        ("$timescale 7 parsec $end\n$enddefinitions $end\n", "is no value change dump"),
        ("Time [s],D0\n0.0,0\n0.5,X\n1.0,1\n", "line 'D0' was not recorded at 500 ms"),
        ("Time [s],D1,D0\n0.0,0,1\n0.5,1", "has 2 of 3 columns"),
        ("Time [s],D0\n0.0,0\n0.5,3.3\n", "line 'D0' is '3.3' in a row; a level must be 0 or 1"),
        ("Time [s],D0\n0.0,0\n2026-11-21T21:00,1\n", "has '2026-11-21T21:00' as a time"),
        ("Time [s],D0\n0.0,0\nnan,1\n", "has 'nan' as a time"),
        ("Time [s],D0\n0.0,0\n0.5,1\n0.4,0\n", "its times go back at 500 ms"),
        ("Time [s],D0\n", "has no rows"),
        ("D0,D1\n0,1\n", "has 'D0' as first column; it must be the time"),
        ("Time [weeks],D0\n0,1\n", "has 'Time \\[weeks\\]' as first column"),
        ("; CSV generated by libsigrok 0.5.2\nnanoseconds,logic\n41,1\n", "give the .sr file"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_capture_is_told_in_one_line(content, says, tmp_path):
    """Oracle: the message for each way in which a file can be wrong."""
    path = tmp_path / "capture"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ArchiveError, match=says):
        read_capture(path, ["D0"])


def test_a_gap_between_samples_is_told_with_its_time(tmp_path):
    """Oracle: sample 3000 of 24 MHz left out, at 125 µs."""
    path = tmp_path / "samples.csv"
    _as_samples(path)
    rows = path.read_text().split("\n")
    path.write_text("\n".join(rows[: 2 + 3000] + rows[2 + 3001 :]))
    with pytest.raises(ArchiveError, match="was not recorded at 125 µs: data were lost there"):
        read_capture(path, NAMES)


def test_a_second_chunk_of_saleae_is_a_gap(tmp_path):
    """Oracle: the end of the first chunk, 1.5 s."""
    head = struct.pack("<8siiQ", b"<SALEAE>", 1, 0, 2)
    chunk = struct.pack("<IdddQd", 0, 1e6, 0.0, 1.5, 1, 0.7)
    (tmp_path / "digital_0.bin").write_bytes(head + chunk + struct.pack("<IdddQ", 0, 1e6, 1.7, 2.0, 0))
    with pytest.raises(ArchiveError, match=r"line 'D0' was not recorded at 1\.5 s"):
        read_capture(tmp_path, ["D0"])


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (struct.pack("<8sii", b"<SALEAE>", 2, 0), "is of version 2 and type 0"),
        (struct.pack("<8sii", b"<SALEAE>", 0, 1), "is of version 0 and type 1"),
        (struct.pack("<8siiQ", b"<SALEAE>", 1, 0, 0), "holds no data"),
        (b"<SALEAE>", "ends within its header"),
        (b"something else..", "is no raw binary export"),
        (struct.pack("<8siiIddQdd", b"<SALEAE>", 0, 0, 0, 0.0, 1.0, 2, 0.6, 0.5), "its times go back at 600 ms"),
        (struct.pack("<8siiIddQd", b"<SALEAE>", 0, 0, 0, 0.0, 1.0, 1, np.nan), "times that cannot be"),
        (struct.pack("<8siiIddQd", b"<SALEAE>", 0, 0, 0, 0.0, 1.0, 1, 1e300), "time that cannot be"),
        (struct.pack("<8siiIddQd", b"<SALEAE>", 0, 0, 7, 0.0, 1.0, 1, 0.5), "level, rate or time that cannot be"),
        (
            struct.pack("<8siiIddQd", b"<SALEAE>", 0, 0, 0, 0.0, 1.0, 2, 0.5),
            "holds 1 of 2 changes: the file is cut short",
        ),
    ],
)
def test_what_is_wrong_with_a_saleae_file_is_told_in_one_line(data, says, tmp_path):
    """Oracle: the message for each way in which a file can be wrong."""
    (tmp_path / "digital_0.bin").write_bytes(data)
    with pytest.raises(ArchiveError, match=says):
        read_capture(tmp_path, ["D0"])


@pytest.mark.parametrize(
    ("inside", "says"),
    [
        ({"meta.json": "{}"}, "is a session of Saleae's Logic 2"),
        ({"other": ""}, "is a ZIP but no sigrok session"),
        ({"metadata": "[device 1]\nsamplerate=fast\nprobe1=D0\nunitsize=1\n"}, "has no device with probes"),
        ({"metadata": "no section\n"}, "has metadata that cannot be read"),
        ({"metadata": "[device 1]\nsamplerate=1 MHz\nprobe9=D0\nunitsize=1\n"}, "has more probes than bits"),
        ({"metadata": "[device 1]\nsamplerate=1 MHz\nprobe1=D0\nunitsize=1\n"}, "holds no data 'logic-1'"),
        ({"metadata": "[device 1]\nsamplerate=1 MHz\nprobe1=D0\nunitsize=1\n", "logic-1-1": b""}, "holds no samples"),
        (
            {"metadata": "[device 1]\nsamplerate=1 MHz\nprobe1=D0\nunitsize=1\n", "logic-1-1": b"0", "logic-1-3": b"0"},
            "lacks its piece of data 'logic-1-2': data were lost there",
        ),
        (
            {"metadata": "[device 1]\nsamplerate=1 MHz\nprobe1=D0\nunitsize=2\n", "logic-1": b"000"},
            "ends within a sample of 2 bytes",
        ),
    ],
)
def test_what_is_wrong_with_a_sigrok_session_is_told_in_one_line(inside, says, tmp_path):
    """Oracle: the message for each way in which a file can be wrong."""
    path = tmp_path / "capture.sr"
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in inside.items():
            archive.writestr(name, data)
    with pytest.raises(ArchiveError, match=says):
        read_capture(path, ["D0"])


def test_files_that_are_not_there(tmp_path):
    """Oracle: the messages for a missing file and a folder of something else."""
    with pytest.raises(ArchiveError, match="does not exist"):
        read_capture(tmp_path / "nothing.vcd", ["D0"])
    with pytest.raises(ArchiveError, match=r"is a folder without digital_0\.bin"):
        read_capture(tmp_path, ["D0"])


def test_lines_of_one_name_in_two_scopes_are_told_apart(tmp_path):
    """Oracle: by hand; the short name stands for two lines, the long ones for one each."""
    path = tmp_path / "capture.vcd"
    scopes = '$scope module a $end\n$var wire 1 ! D0 $end\n$upscope $end\n$scope module b $end\n$var wire 1 " D0 $end\n'
    path.write_text(f'$timescale 1 ns $end\n{scopes}$upscope $end\n$enddefinitions $end\n#0 0! 0"\n#7 1"\n')
    assert read_capture(path, ["b.D0"]).lines["b.D0"].changes.tolist() == [7]
    assert read_capture(path, ["a.D0"]).lines["a.D0"].changes.tolist() == []
    with pytest.raises(ArchiveError, match="'D0' is no line of the capture; name one of 'a.D0', 'b.D0'"):
        read_capture(path, ["D0"])


def test_a_table_without_names_counts_its_columns_from_zero(tmp_path):
    """Oracle: by hand; times in seconds become picoseconds."""
    path = tmp_path / "capture.csv"
    path.write_text("0.0\t0\t1\n0.25\t1\t1\n0.5\t1\t0\n")
    capture = read_capture(path, ["D0", "D1"])
    assert capture.counts_per_second == PICOSECONDS
    assert [line.changes.tolist() for line in capture.lines.values()] == [[250_000_000_000], [500_000_000_000]]


def test_a_run_of_33_s_in_a_table_keeps_its_nanoseconds(tmp_path):
    """Oracle: the whole nanoseconds that were written, up to 33 s."""
    at = np.cumsum(np.random.default_rng(3).integers(1_000, 3_000_000, 22_000))
    path = tmp_path / "capture.csv"
    rows = [f"{t // 10**9}.{t % 10**9:09d},{i % 2}" for i, t in enumerate(at.tolist(), start=1)]
    path.write_text("\n".join(["Time [s],Channel 0", "0.000000000,0", *rows, ""]))
    assert at[-1] > 30 * 10**9
    assert np.array_equal(read_capture(path, ["D0"]).lines["D0"].changes, 1000 * at)
