"""`irtiming info` and `irtiming convert`, as they are typed."""

import hashlib
import json

import numpy as np
import pytest
from typer.testing import CliRunner

from irtiming.cli.main import app
from irtiming.errors import ArchiveError

STACK = np.arange(3 * 20 * 30, dtype=np.uint16).reshape(3, 20, 30)
FACTS = {"integration_time_s": 250e-6, "times_s": [1.0, 1.5, 2.0], "time_scale": "camera clock"}


def _run(*options):
    done = CliRunner().invoke(app, list(map(str, options)))
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output


@pytest.fixture
def stack(tmp_path):
    """File of frames with facts beside it."""
    np.save(tmp_path / "a.npy", STACK)
    (tmp_path / "a.npy.json").write_text(json.dumps(FACTS))
    return tmp_path / "a.npy"


def test_info_says_what_is_in_a_file(stack, tmp_path):
    """Oracle: the array and the facts that were written; the checksum of the first frame's bytes by hashlib."""
    said = _run("info", stack, "--json", tmp_path / "o.json")
    assert "frames: 3\nrows: 20\ncolumns: 30\ndtype: uint16\n" in said
    assert "frame times: from 1.000000 s to 2.000000 s, every 500 ms (camera clock)" in said
    found = json.loads((tmp_path / "o.json").read_text())
    assert {name: found[name] for name in ("frames", "rows", "columns", "dtype")} == {
        "frames": 3, "rows": 20, "columns": 30, "dtype": "uint16",
    }  # fmt: skip
    assert found["first_frame_sha256"] == hashlib.sha256(STACK[0].tobytes()).hexdigest()
    assert found["integration_time"] == {"value": 250e-6, "unit": "s"}
    assert found["frame_times"]["values"] == FACTS["times_s"]


def test_convert_there_and_back(stack, tmp_path):
    """Oracle: the array; no file of an unfinished step stays."""
    said = _run("convert", stack, tmp_path / "b.tif") + _run("convert", tmp_path / "b.tif", tmp_path / "c.npy")
    assert np.array_equal(np.load(tmp_path / "c.npy"), STACK)
    assert json.loads((tmp_path / "c.npy.json").read_text())["times_s"] == FACTS["times_s"]
    assert f"{tmp_path / 'b.tif'}: written" in said
    assert not list(tmp_path.glob("*.part"))


def test_what_cannot_be_is_refused(stack, tmp_path):
    """Oracle: the messages; the command line makes one line and exit status 2 of them."""
    stack.write_bytes(stack.read_bytes()[:-1])
    for options in (("info", stack), ("convert", stack, tmp_path / "b.tif"), ("info", tmp_path / "none.tif")):
        with pytest.raises(ArchiveError, match="cut short|does not exist") as refused:
            _run(*options)
        assert "\n" not in str(refused.value)
    assert not (tmp_path / "b.tif").exists()
    with pytest.raises(ArchiveError, match="another file of this command"):
        _run("convert", stack, stack)


@pytest.mark.parametrize("is_there", [True, False])
@pytest.mark.parametrize(
    ("name", "out"), [("a.npy", "a.npy.json"), ("a.raw", "a.json"), ("a.raw", "a.raw.json"), ("folder", "folder/a.npy")]
)
def test_a_file_that_is_read_with_the_frames_is_not_overwritten(tmp_path, name, out, is_there):
    """Oracle: by hand; facts beside the frames, written or still to be written there, and a frame of a folder, are as before."""
    for path in (tmp_path / "a.npy", tmp_path / "folder" / "a.npy"):
        path.parent.mkdir(exist_ok=True)
        np.save(path, STACK)
    (tmp_path / "a.raw").write_bytes(STACK.tobytes())
    facts = {"a.npy.json": FACTS, "a.json": {"rows": 20, "columns": 30}, "a.raw.json": {"rows": 20, "columns": 30}}
    for beside, content in facts.items():
        (tmp_path / beside).write_text(json.dumps(content))
    if out in facts and not is_there:
        (tmp_path / out).unlink()
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(ArchiveError, match="is another file of this command and would be overwritten"):
        _run("info", tmp_path / name, "--json", tmp_path / out)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_a_missing_file_of_a_folder_is_told(tmp_path):
    """Oracle: by hand; the files that were left out, of many the first five."""
    for n in range(40):
        if n != 15:
            np.save(tmp_path / f"f_{n:04d}.npy", STACK[:1])
    assert "frame numbers: 0 to 39, 1 missing: 15\n" in _run("info", tmp_path)
    for n in range(20, 27):
        (tmp_path / f"f_{n:04d}.npy").unlink()
    assert "frame numbers: 0 to 39, 8 missing: 15, 20, 21, 22, 23, ...\n" in _run("info", tmp_path)


def test_frame_numbers_that_do_not_rise_are_told(stack, tmp_path):
    """Oracle: by hand; a counter of two bits."""
    (tmp_path / "a.npy.json").write_text(json.dumps(FACTS | {"frame_id": [2, 3, 0]}))
    assert "frame numbers: 2 to 0, not rising\n" in _run("info", stack)
