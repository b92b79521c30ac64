"""Places where a result should go."""

import os
import stat
from pathlib import Path
from threading import Thread

import pytest

from irtiming.archive.json_file import require_place, write_atomically
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


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_device_is_no_file_to_replace():
    """Oracle: by hand; the device node, full, is what it was before."""
    before = Path("/dev/full").stat().st_rdev
    with pytest.raises(ArchiveError, match="No space left"):
        write_atomically("{}\n", "/dev/full")
    assert Path("/dev/full").stat().st_rdev == before
