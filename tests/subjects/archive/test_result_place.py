"""Places where a result should go."""

import pytest

from irtiming.archive.json_file import require_place
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
