"""Files that are written whole or not at all. Oracle: what lies in the folder afterwards."""

from pathlib import Path

import pytest

from irtiming.archive.json_file import write_atomically
from irtiming.archive.whole_file import final_name, whole_file
from irtiming.archive.writer import RecordingWriter
from irtiming.errors import ArchiveError


def test_it_takes_the_place_of_the_file_when_the_block_ends(tmp_path: Path) -> None:
    """Oracle: the file's text before and after the end of the block."""
    target = tmp_path / "a.csv"
    target.write_text("old")
    with whole_file(target) as part:
        part.write_text("new")
        assert target.read_text() == "old"
        assert final_name(part) == target
    assert target.read_text() == "new"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_nothing_is_left_of_a_block_that_raises(tmp_path: Path, error: type[BaseException]) -> None:
    """Oracle: the old text and nothing beside it."""
    target = tmp_path / "a.csv"
    target.write_text("old")
    with pytest.raises(error), whole_file(target) as part:
        _break_off(part, error)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_what_the_system_says_is_one_line(tmp_path: Path) -> None:
    """Oracle: the system's own words for error 28, with the file's name."""
    said = r"a\.csv: cannot be written \(No space left on device\)"
    with pytest.raises(ArchiveError, match=said), whole_file(tmp_path / "a.csv") as part:
        _break_off(part, OSError(28, "No space left on device"))


def test_an_interrupted_recording_of_that_name_stays(tmp_path: Path) -> None:
    """Oracle: ``run.nxs.part`` of a run that broke off, the only copy of its frames, reads as before."""
    interrupted = tmp_path / "run.nxs.part"
    interrupted.write_text("frames")
    write_atomically("new", tmp_path / "run.nxs")
    with whole_file(tmp_path / "run.nxs") as part:
        part.write_text("newer")
    with pytest.raises(ArchiveError, match="never called"), RecordingWriter(tmp_path / "run.nxs", overwrite=True):
        pass
    assert interrupted.read_text() == "frames"


def _break_off(part: Path, error: BaseException | type[BaseException]) -> None:
    part.write_text("half")
    raise error
