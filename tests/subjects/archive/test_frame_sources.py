"""Frames of files that other programs write: each file is made by a library that shares nothing with the package."""

import json
import struct
from contextlib import nullcontext
from importlib.metadata import EntryPoint

import h5py
import numpy as np
import pytest
import tifffile

from irtiming.archive.frames.opening import open_frames, reader_of, readers
from irtiming.archive.frames.source import FrameFacts, FrameReader, Frames
from irtiming.errors import ArchiveError

STACK = np.random.default_rng(3).integers(0, 2**14, (7, 24, 30), dtype=np.uint16)


def _all(source):
    """Every frame of a source, block by block, and picked."""
    blocks = np.concatenate([block.copy() for _, block in source.blocks()])
    picked = source.pick([source.shape[0] - 1, 0])
    assert np.array_equal(picked, blocks[[-1, 0]])
    assert blocks.shape == source.shape
    assert blocks.dtype.name == source.facts.dtype
    return blocks


def _pages(path):
    with tifffile.TiffWriter(path) as writer:
        for frame in STACK:
            writer.write(frame, contiguous=False)


def _hdf5(path):
    with h5py.File(path, "w") as file:
        file["measurement/counts"] = STACK
        file["measurement/dark"] = STACK[:2]


def _raw(path):
    path.write_bytes(b"12" + b"".join(frame.astype(">u2").tobytes() + b"gap" for frame in STACK))
    told = {"rows": 24, "columns": 30, "byte_order": "big", "header_bytes": 2, "between_frames_bytes": 3}
    told |= {"integration_time_s": 250e-6, "times_s": [0.1 * i for i in range(7)], "time_scale": "camera clock"}
    path.with_suffix(".json").write_text(json.dumps(told))


def _envi(path, interleave):
    axes = {"bsq": (0, 1, 2), "bil": (1, 0, 2), "bip": (1, 2, 0)}[interleave]
    path.write_bytes(b"x" * 10 + STACK.astype(">u2").transpose(axes).tobytes())
    head = "ENVI\nsamples = 30\nlines = 24\nbands = 7\nheader offset = 10\ndata type = 12\n"
    head += (
        f"interleave = {interleave}\nbyte order = 1\nfps = 50\nsensor type = some camera\ndescription = {{\nlines\n}}\n"
    )
    path.with_suffix(".hdr").write_text(head)


WRITERS = {
    "stack.tif": lambda path: tifffile.imwrite(path, STACK),
    "big-endian.tif": lambda path: tifffile.imwrite(path, STACK, byteorder=">", imagej=True),
    "packed.tif": lambda path: tifffile.imwrite(
        path, STACK, bigtiff=True, compression="zlib", photometric="minisblack"
    ),
    "pages.tif": _pages,
    "array.npy": lambda path: np.save(path, STACK.astype(">u2")),
    "arrays.npz": lambda path: np.savez_compressed(path, frames=STACK),
    "other.h5": _hdf5,
    "bare.raw": _raw,
    "lines.bsq": lambda path: _envi(path, "bsq"),
    "lines.bil": lambda path: _envi(path, "bil"),
    "lines.bip": lambda path: _envi(path, "bip"),
}


@pytest.mark.parametrize("name", WRITERS)
def test_frames_come_out_as_they_were_put_in(name, tmp_path):
    """Oracle: the array that an independent writer was given."""
    WRITERS[name](tmp_path / name)
    source = open_frames(tmp_path / name)
    assert np.array_equal(_all(source), STACK)
    assert source.facts.dtype == "uint16"


@pytest.mark.parametrize("kind", ["uint8", "int16", "float32", "float64"])
def test_other_types_of_pixels_stay_what_they_are(kind, tmp_path):
    """Oracle: the array that was written; bytes and temperatures are read like counts."""
    values = (STACK % 200).astype(kind)
    np.save(tmp_path / "a.npy", values)
    tifffile.imwrite(tmp_path / "a.tif", values)
    for name in ("a.npy", "a.tif"):
        source = open_frames(tmp_path / name)
        assert source.facts.dtype == kind
        assert np.array_equal(_all(source), values)


def test_a_folder_is_read_in_the_order_of_its_numbers(tmp_path):
    """Oracle: the array whose frames were written one by one; frame 10 comes after frame 2."""
    many = np.concatenate([STACK, STACK[::-1]])
    for i, frame in enumerate(many):
        tifffile.imwrite(tmp_path / f"frame{i}.tif", frame)
    assert np.array_equal(_all(open_frames(tmp_path)), many)


def test_a_digit_that_is_no_number_orders_nothing(tmp_path):
    """Oracle: the raised two is a digit to Python and no number; a number of 5000 digits is none that Python makes."""
    (tmp_path / "few").mkdir()
    for name, frame in zip(("frame²a", "frame²b"), STACK, strict=False):
        tifffile.imwrite(tmp_path / "few" / f"{name}.tif", frame)
    assert np.array_equal(_all(open_frames(tmp_path / "few")), STACK[:2])
    long, short = "9" * 200, "10"
    for name, frame in zip((short, long), STACK, strict=False):
        np.save(tmp_path / f"{name}.npy", frame[np.newaxis])
    assert np.array_equal(_all(open_frames(tmp_path)), STACK[:2])


@pytest.mark.parametrize(
    ("names", "numbers"),
    [
        (["f_0007", "f_0008", "f_0010", "f_0011"], [7, 8, 10, 11]),
        (["run2-9", "run2-10", "run2-11"], [9, 10, 11]),
        (["f0", "f1", "f3"], [0, 1, 3]),
        (["f0", "f2", "f4", "f5"], None),
        (["t1000", "t1033", "t1066", "t1067"], None),  # milliseconds
        (["a1-101500", "a2-101501", "a3-101503"], None),  # a count and a time of day
        (["a1", "b2", "c3"], None),
        (["f", "g1"], None),
        (["f1" + "0" * 18, "f1" + "0" * 17 + "1", "f1" + "0" * 17 + "2"], None),  # more than 64 bits hold
    ],
)
def test_the_number_in_a_name_is_that_of_the_frame(tmp_path, names, numbers):
    """Oracle: by hand; where it is not plain which number counts frames, none does."""
    for name in names:
        np.save(tmp_path / f"{name}.npy", STACK[:1])
    found = open_frames(tmp_path).facts.frame_id
    assert (None if found is None else found.tolist()) == numbers


def test_two_files_of_one_number_are_refused(tmp_path):
    """Oracle: by hand; nobody can say which is the frame."""
    for name in ("f1", "f2", "f02"):
        np.save(tmp_path / f"{name}.npy", STACK[:1])
    with pytest.raises(ArchiveError, match=r"has two files with one number, f0?2\.npy and f0?2\.npy; take one"):
        open_frames(tmp_path)


def test_pictures_are_frames(tmp_path):
    """Oracle: the array; PGM written by hand after its description, PNG by imagecodecs."""
    imagecodecs = pytest.importorskip("imagecodecs")
    (tmp_path / "a.pgm").write_bytes(b"P5\n# made\n30 24\n16383\n" + STACK[0].astype(">u2").tobytes())
    (tmp_path / "b.png").write_bytes(imagecodecs.png_encode(STACK[1]))
    assert np.array_equal(_all(open_frames(tmp_path / "a.pgm")), STACK[:1])
    assert np.array_equal(_all(open_frames(tmp_path / "b.png")), STACK[1:2])


def test_facts_beside_a_raw_file_are_taken(tmp_path):
    """Oracle: the JSON that was written."""
    _raw(tmp_path / "a.raw")
    facts = open_frames(tmp_path / "a.raw").facts
    assert facts.integration_time_s == 250e-6
    assert facts.times_s is not None
    assert facts.times_s.tolist() == [0.1 * i for i in range(7)]
    assert facts.time_scale == "camera clock"


def test_what_a_recording_tells(hand_made):
    """Oracle: the numbers that the fixture writes with plain h5py."""
    facts = open_frames(hand_made()).facts
    assert facts.integration_time_s == 250e-6
    assert facts.bit_depth == 14
    assert facts.trigger_times_s is not None
    assert facts.trigger_times_s[0] == (7_000_000 + 16_384_000) / 49_152_000
    assert facts.frame_period_s == 1_622_016 / 49_152_000


def _cut(path):
    content = path.read_bytes()
    path.write_bytes(content[: len(content) - 1000])


@pytest.mark.parametrize(
    "name", ["stack.tif", "packed.tif", "array.npy", "arrays.npz", "other.h5", "bare.raw", "lines.bil"]
)
def test_a_file_that_is_cut_is_refused_in_one_line(name, tmp_path):
    """Oracle: the class of the error and the name of the file in its one line."""
    WRITERS[name](tmp_path / name)
    _cut(tmp_path / name)
    with pytest.raises(ArchiveError, match=name) as caught:
        _all(open_frames(tmp_path / name))
    assert "\n" not in str(caught.value)


def test_sizes_that_a_file_cannot_hold_are_refused_before_anything_is_made(tmp_path):
    """Oracle: the size of the file; 2 EB are declared."""
    head = "{'descr': '<u2', 'fortran_order': False, 'shape': (4000000, 500000, 500000)}".ljust(117).encode() + b"\n"
    (tmp_path / "a.npy").write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + b"12")
    with pytest.raises(ArchiveError, match="4000000 frames of 500000 x 500000"):
        open_frames(tmp_path / "a.npy")


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.txt", b"hello", "is no file of frames that is known"),
        ("a.tif", b"", "is empty"),
        ("a.npy", b"\x93NUMPY\x01\x00", "cannot be read as NumPy"),
        ("a.nxs", b"\x89HDF\r\n\x1a\n" + bytes(100), "a.nxs"),
    ],
)
def test_what_is_no_file_of_frames_is_refused(name, content, says, tmp_path):
    """Oracle: the message says what is wrong."""
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ArchiveError, match=says):
        open_frames(tmp_path / name)


def test_colours_are_refused(tmp_path):
    """Oracle: three values for a pixel are no counts of a detector."""
    tifffile.imwrite(tmp_path / "a.tif", np.zeros((20, 30, 3), np.uint8), photometric="rgb")
    with pytest.raises(ArchiveError, match="3 values for each pixel"):
        open_frames(tmp_path / "a.tif")


def test_a_format_is_told_from_the_content_not_from_the_name(tmp_path):
    """Oracle: the reader that takes it."""
    tifffile.imwrite(tmp_path / "a.npy", STACK)
    assert reader_of(tmp_path / "a.npy") is readers()["tiff"]


def test_pages_that_turn_in_a_circle_are_refused(tmp_path):
    """Oracle: the last page's link, by hand; a library would follow it for ever."""
    _pages(tmp_path / "a.tif")
    with tifffile.TiffFile(tmp_path / "a.tif") as tiff:
        offsets = [page.offset for page in tiff.pages]
        last = offsets[-1] + 2 + 12 * len(tiff.pages[-1].tags)
    content = bytearray((tmp_path / "a.tif").read_bytes())
    struct.pack_into("<I", content, last, offsets[2])
    (tmp_path / "a.tif").write_bytes(content)
    with pytest.raises(ArchiveError, match="turn in a circle behind page 6"):
        open_frames(tmp_path / "a.tif")


def test_three_frames_that_tifffile_takes_for_colours_are_frames(tmp_path):
    """Oracle: the array; tifffile writes three frames as planes of one picture, and says their shape."""
    with pytest.warns(DeprecationWarning, match="stored as RGB"):
        tifffile.imwrite(tmp_path / "a.tif", STACK[:3])
    assert np.array_equal(_all(open_frames(tmp_path / "a.tif")), STACK[:3])


def test_a_reader_of_another_package_is_found_and_takes_no_format_away(tmp_path, monkeypatch):
    """Oracle: entry points as an installed package has them; a name of ours stays ours."""
    theirs = EntryPoint(name="theirs", value="test_frame_sources:THEIRS", group="irtiming.frames")
    ours = EntryPoint(name="tiff", value="test_frame_sources:THEIRS", group="irtiming.frames")
    monkeypatch.setattr("irtiming.archive.frames.opening.entry_points", lambda group: [theirs, ours])
    readers.cache_clear()
    try:
        (tmp_path / "a.new").write_bytes(b"NEW FORMAT")
        assert open_frames(tmp_path / "a.new").shape == (1, 2, 3)
        assert readers()["tiff"].title == "TIFF"
    finally:
        readers.cache_clear()


def _open_theirs(path):
    facts = FrameFacts(format="theirs", frames=1, rows=2, columns=3, dtype="uint8")
    return Frames(path, facts, lambda: nullcontext(lambda first, count: np.zeros((count, 2, 3), np.uint8)))


THEIRS = FrameReader(title="theirs", takes=lambda _, begin: begin.startswith(b"NEW"), open=_open_theirs)
