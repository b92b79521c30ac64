"""Places where a result should go."""

import os
import stat
import subprocess
import sys
from pathlib import Path
from threading import Thread

import pytest

from irtiming.archive.json_file import require_place, write_atomically
from irtiming.archive.live.finish import require_free_name
from irtiming.archive.whole_file import whole_file
from irtiming.archive.writer import RecordingWriter
from irtiming.errors import ArchiveError


def test_a_file_in_a_folder_is_a_place(tmp_path):
    """Oracle: by hand; neither the check nor its result leaves anything behind."""
    require_place(tmp_path / "result.json")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("name", "says"), [(".", "is a folder"), ("absent/result.json", "there is no folder")])
def test_no_place_is_refused_before_the_work(tmp_path, name, says):
    """Oracle: by hand."""
    with pytest.raises(ArchiveError, match=says):
        require_place(tmp_path / name)


def test_a_pipe_is_written_to_and_stays_one(tmp_path):
    """Oracle: by hand; what comes out at its other end."""
    pipe, heard = tmp_path / "pipe", []
    os.mkfifo(pipe)
    listener = Thread(target=lambda: heard.append(pipe.read_text()))
    listener.start()
    write_atomically("{}\n", pipe)
    listener.join(5)
    assert heard == ["{}\n"]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_a_device_is_no_file_to_replace(full_device):
    """Oracle: by hand; the node of a device that is always full is what it was before, whatever is to be written."""
    before = full_device.stat().st_rdev
    require_place(full_device)
    with pytest.raises(ArchiveError, match="No space left"):
        write_atomically("{}\n", full_device)
    with pytest.raises(ArchiveError, match="is no file but a device or a pipe"):
        require_place(full_device, is_text=False)
    with pytest.raises(ArchiveError, match="is no file but a device or a pipe"), whole_file(full_device):
        pass
    with pytest.raises(ArchiveError, match="is no file but a device or a pipe"):
        RecordingWriter(full_device, overwrite=True)
    assert full_device.stat().st_rdev == before
    assert list(full_device.parent.iterdir()) == [full_device]


def test_a_pipe_takes_no_whole_file(tmp_path):
    """Oracle: by hand; nobody listens, and nobody need."""
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ArchiveError, match="is no file but a device or a pipe"), whole_file(tmp_path / "pipe"):
        pass


@pytest.mark.parametrize("is_there", [True, False])
def test_a_link_is_followed_and_stays(tmp_path, is_there):
    """Oracle: by hand; the file at its end is the new one, in another folder, and nothing lies beside either."""
    (tmp_path / "far").mkdir()
    link, far = tmp_path / "link", tmp_path / "far" / "file"
    if is_there:
        far.write_text("old")
    link.symlink_to(far)
    write_atomically("new", link)
    assert (far.read_text(), link.readlink()) == ("new", far)
    assert [sorted(one.name for one in folder.iterdir()) for folder in (tmp_path, far.parent)] == [
        ["far", "link"],
        ["file"],
    ]


_TO_STREAM = """
import sys
from irtiming.archive.json_file import require_place, write_atomically
print("words")
require_place(sys.argv[1])
write_atomically("text", sys.argv[1])
"""


@pytest.mark.parametrize("name", ["-", "stdout", "link"])
def test_the_file_of_the_standard_output_is_written_to_as_it_stands(tmp_path, name):
    """Oracle: by hand; what a shell's >> had in the file is there still, and so is a link that leads to /proc/self/fd/1."""
    (tmp_path / "stdout").write_text("before\n")
    (tmp_path / "link").symlink_to("/proc/self/fd/1")
    with (tmp_path / "stdout").open("a") as file:
        subprocess.run([sys.executable, "-c", _TO_STREAM, name], cwd=tmp_path, stdout=file, check=True)
    assert (tmp_path / "stdout").read_text() == "before\nwords\ntext"
    assert (tmp_path / "link").is_symlink()
    assert len(list(tmp_path.iterdir())) == 2


def test_the_standard_output_takes_text_alone(tmp_path, monkeypatch):
    """Oracle: by hand; no file is called -."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ArchiveError, match="^-: is the standard output, which takes text alone; name a file"):
        require_place("-", is_text=False)
    with pytest.raises(ArchiveError, match="^-: is the standard output"), whole_file("-"):
        pass
    with pytest.raises(ArchiveError, match="^-: is the standard output"):
        require_free_name(Path("-"))
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def full_device(tmp_path):
    """A node of the device that is always full, of our own: nothing under /dev is risked."""
    if os.geteuid():
        pytest.skip("only root makes device nodes")
    node = tmp_path / "full"
    try:
        os.mknod(node, 0o600 | stat.S_IFCHR, os.makedev(1, 7))
        node.open("wb").close()
    except OSError as error:
        pytest.skip(f"no device nodes here: {error}")
    return node
