"""Frames as makers' programs write them: small files made by hand or by libraries of others, and real ones where they are."""

import hashlib
import os
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
from makers_files import FRAMES, TIMES_S, WRITERS, expected, fff

from irtiming.archive.frames.opening import open_frames
from irtiming.errors import ArchiveError

_ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def foreign():
    """Folder with real files of makers; tests skip where it is absent."""
    folder = Path(os.environ.get("IRTIMING_SHARED", _ROOT.parent / "shared")) / "foreign"
    if not folder.is_dir():
        pytest.skip(f"no files of makers in {folder}")
    return folder


def _all(source):
    blocks = np.concatenate([block.copy() for _, block in source.blocks()])
    assert np.array_equal(source.pick([source.shape[0] - 1, 0]), blocks[[-1, 0]])
    assert blocks.dtype.name == source.facts.dtype
    return blocks


@pytest.mark.parametrize("name", WRITERS)
def test_frames_come_out_as_they_were_put_in(name, tmp_path):
    """Oracle: the array that was written by hand after the format's description, or by its library."""
    WRITERS[name](tmp_path / name)
    found, wanted = _all(open_frames(tmp_path / name)), expected(name)
    if found.dtype == np.float32:
        assert np.abs(found - wanted).max() < 1e-4  # K; the table of the file is of single precision
    else:
        assert np.array_equal(found, wanted)


def test_times_come_out_as_they_were_put_in(tmp_path):
    """Oracle: the times that were written, each in the steps of its format."""
    steps = {
        "a.ptw": (TIMES_S, 1e-6),
        "a.irb": ((45_000.5 - 25_569) * 86_400 + np.array([0, 0.04]), 1e-5),
        "a.seq": (np.repeat(1_541_416_483.084, 3), 1e-3),
        "norpix.seq": (1_700_000_000.250017 + np.arange(5), 1e-6),
        "a.hcc": (1_700_000_000.25 + np.arange(5), 1e-6),
        "a.mkv": (0.04 * np.arange(5), 1e-9),
    }
    for name, (times_s, step_s) in steps.items():
        WRITERS[name](tmp_path / name)
        found = open_frames(tmp_path / name).facts.times_s
        assert found is not None, name
        assert np.abs(found - times_s).max() < step_s, name


def test_midnight_is_passed(tmp_path):
    """Oracle: the law that times rise; 200 frames of a day's last second are followed by the next day's first."""
    WRITERS["a.ptw"](tmp_path / "a.ptw")
    content, stride = bytearray((tmp_path / "a.ptw").read_bytes()), 1016 + FRAMES[0].nbytes
    for i in range(5):
        at = 3476 + i * stride
        content[at + 80 : at + 84] = bytes([59, 23, 99, 59]) if i < 3 else bytes([0, 0, i, 0])
    (tmp_path / "a.ptw").write_bytes(content)
    times_s = open_frames(tmp_path / "a.ptw").facts.times_s
    assert times_s is not None
    assert times_s[3] - times_s[2] < 0.1
    assert times_s[3] > 86_400


def test_integration_times_and_cameras(tmp_path):
    """Oracle: what was written."""
    for name in ("a.ptw", "a.hcc", "a.fits"):
        WRITERS[name](tmp_path / name)
        assert open_frames(tmp_path / name).facts.integration_time_s == pytest.approx(250e-6, rel=1e-6)
    serials = {"a.ptw": "012275", "a.seq": "0815", "a.irb": "1214718"}
    for name, serial in serials.items():
        WRITERS[name](tmp_path / name)
        camera = open_frames(tmp_path / name).facts.camera
        assert camera is not None
        assert camera.serial_number == serial


@pytest.mark.parametrize("name", WRITERS)
def test_a_cut_file_is_refused_in_one_line(name, tmp_path):
    """Oracle: the class of the error; two fifths of the file are gone, and cuts within headers are tried too."""
    WRITERS[name](tmp_path / name)
    content = (tmp_path / name).read_bytes()
    for left in (5, 100, 1500, len(content) * 3 // 5 + 7):
        (tmp_path / name).write_bytes(content[:left])
        with pytest.raises(ArchiveError, match=name) as caught:
            _all(open_frames(tmp_path / name))
        assert "\n" not in str(caught.value)


def test_a_packed_picture_may_be_shorter_than_its_record_by_some_padding(tmp_path):
    """Oracle: a CSQ of a FLIR T1030sc, whose last record ends four bytes behind the file; its picture is whole."""
    one = fff("<", "jpeg-ls")
    place = one.index(struct.pack("<2H", 1, 0)) + 16
    length = struct.unpack_from("<I", one, place)[0]
    info = one[64 + 64 + length :]
    moved = bytearray(one[: 64 + 64] + info + one[64 + 64 : 64 + 64 + length])
    struct.pack_into("<2I", moved, place - 4, 128 + len(info), length + 4)
    struct.pack_into("<I", moved, place + 32 - 4, 128)
    (tmp_path / "a.csq").write_bytes(moved)
    assert np.array_equal(_all(open_frames(tmp_path / "a.csq")), FRAMES[:1])


def test_a_reader_whose_library_is_missing_names_the_cure(tmp_path, monkeypatch):
    """Oracle: the extra of the package."""
    WRITERS["a.fits"](tmp_path / "a.fits")
    monkeypatch.setitem(sys.modules, "astropy.io", None)
    monkeypatch.setitem(sys.modules, "astropy", None)
    with pytest.raises(ArchiveError, match=r"FITS.* astropy.*pip install 'irtiming\[frames\]'"):
        open_frames(tmp_path / "a.fits")


def test_a_video_that_loses_something_is_refused(tmp_path):
    """Oracle: a video of MPEG-4 pictures, by PyAV."""
    import av

    with av.open(str(tmp_path / "a.mkv"), "w") as container:
        stream = container.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = 32, 24, "yuv420p"
        frame = av.VideoFrame.from_ndarray((FRAMES[0] >> 6).astype(np.uint8), format="gray").reformat(format="yuv420p")
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    with pytest.raises(ArchiveError, match="loses what the camera saw"):
        open_frames(tmp_path / "a.mkv")


def _sha256(frame):
    return hashlib.sha256(np.ascontiguousarray(frame)).hexdigest()


def test_a_real_ptw(foreign):
    """Oracle: pyradi's ryptw.py, which gave these numbers and the same values in all 100 frames; times within its millisecond."""
    source = open_frames(foreign / "PyradiSampleMWIR.ptw")
    facts = source.facts
    assert (*facts.shape, facts.dtype, facts.bit_depth) == (100, 64, 69, "uint16", 14)
    assert _sha256(source.pick([0])[0]) == "ad8cf473e6b939d8250f1be0a5775bbdaff8b4a1ef4b9126080925658ee34eb3"
    assert facts.integration_time_s == pytest.approx(500e-6, rel=1e-6)
    assert facts.frame_period_s == pytest.approx(0.01, rel=1e-6)
    assert facts.camera is not None
    assert (facts.camera.model, facts.camera.serial_number) == ("Jade", "012275")
    assert facts.times_s is not None
    assert facts.times_s[0] == pytest.approx(17 * 3600 + 15 * 60 + 27.788, abs=1e-3)
    assert np.abs(np.diff(facts.times_s) - 0.03).max() < 5e-5  # regular once microseconds are taken


def test_a_real_fff(foreign):
    """Oracle: flirpy's fff.py, which gave the same values, time stamp and size; the serial number after ExifTool."""
    source = open_frames(foreign / "frame_000000.fff")
    facts = source.facts
    assert (*facts.shape, facts.dtype) == (1, 512, 640, "uint16")
    assert _sha256(source.pick([0])[0]) == "0868740d7414ce78e11a56877bd9ee37e17a633f5111396b17be87122bdfcba4"
    assert facts.times_s is not None
    assert facts.times_s[0] == pytest.approx(1_541_416_483.084, abs=1e-6)
    assert facts.camera is not None
    assert (facts.camera.model, facts.camera.serial_number) == ("Duo Pro R", "8340357")


@pytest.mark.parametrize(
    ("name", "shape", "sha256", "model"),
    [
        ("AA011400.irb", (1, 480, 640), "e1c339b289d397b4652c202f50ef1b851213b923dab7031b2cca718b3de10b5b", "VARIOCAM"),
        (
            "image.irb",
            (1, 768, 1024),
            "18eef62b935fe1c5ad82ad3a9d8f0a346a10e1e8c25334c25748f24db3c70a44",
            "VARIOCAM_HD",
        ),
    ],
)
def test_a_real_irb(name, shape, sha256, model, foreign):
    """Oracle: the reader of jonathanschilling/irb, followed pixel by pixel in plain Python: the same bits in seven files."""
    source = open_frames(foreign / name)
    assert (*source.shape, source.facts.dtype, source.facts.unit) == (*shape, "float32", "K")
    assert _sha256(source.pick([0])[0]) == sha256
    assert source.facts.camera is not None
    assert source.facts.camera.model == model
