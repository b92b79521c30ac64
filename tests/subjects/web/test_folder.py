"""Names of files that come from a browser."""

import pytest

from irtiming.errors import ArchiveError
from irtiming.web.folder import Folder


@pytest.fixture
def folder(tmp_path):
    """A folder with a file in it, a hidden one, and links that lead out."""
    (tmp_path / "secret.nxs").write_text("outside")
    root = tmp_path / "lab"
    (root / "monday").mkdir(parents=True)
    (root / "monday" / "run.nxs").write_text("inside")
    (root / ".hidden.nxs").write_text("hidden")
    (root / "link.nxs").symlink_to(tmp_path / "secret.nxs")
    (root / "way-out").symlink_to(tmp_path)
    (root / "loop").symlink_to(root / "loop")
    return Folder(root)


@pytest.mark.parametrize(
    "name",
    [
        "", ".", "..", "../secret.nxs", "monday/../../secret.nxs", "/etc/passwd", "monday//run.nxs", "link.nxs",
        "way-out/secret.nxs", "loop", ".hidden.nxs", "monday/./run.nxs", "..\\secret.nxs", "monday\\run.nxs", "a\0b", "a\nb",
        "x" * 5000, "~/.ssh/id", "%2e%2e/secret.nxs/../..",
    ],
)  # fmt: skip
def test_no_name_leads_out_of_the_folder(folder, name):
    """Oracle: the refusal; none of these names is one that the library lists."""
    with pytest.raises(ArchiveError, match="choose one that the library lists|not there"):
        folder.existing(name)


def test_names_of_files_that_are_there(folder):
    """Oracle: the files on the disk; what is hidden or a link is not listed."""
    assert folder.existing("monday/run.nxs").read_text() == "inside"
    assert [folder.name_of(path) for path in folder.files(".nxs")] == ["monday/run.nxs"]


@pytest.mark.parametrize(
    ("given", "made"),
    [
        ("run.nxs", "run.nxs"),
        ("../../up.nxs", "up.nxs"),
        ("..", "file"),
        ("C:\\data\\scan 1.seq", "scan-1.seq"),
        (".bashrc", "bashrc"),
        ("a;rm -rf.nxs", "a-rm--rf.nxs"),
    ],
)
def test_a_new_file_gets_a_plain_name_of_its_own(folder, given, made):
    """Oracle: names written by hand; a second file of the name gets a number, and nothing is overwritten."""
    first = folder.free(given)
    assert folder.name_of(first) == made
    first.touch()
    assert folder.free(given) != first


def test_files_that_belong_together_have_one_stem(folder):
    """Oracle: by hand; a report is left of an analysis that was broken off, so neither it nor its result takes that name."""
    (folder.root / "day.html").touch()
    result = folder.free("day.json", beside=(".html",))
    assert (folder.name_of(result), result.with_suffix(".html").exists()) == ("day-2.json", False)
    assert folder.name_of(folder.free("day.json")) == "day.json"
