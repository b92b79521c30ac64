"""Stamps of frames in CSV: read to the nanosecond, and what is no stamp refused."""

from pathlib import Path

import numpy as np
import pytest

from irtiming.archive.stamps_file import read_stamps
from irtiming.errors import ArchiveError


def _written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "stamps.csv"
    path.write_text(text)
    return path


def test_nanoseconds_of_a_date_are_kept(tmp_path):
    """Oracle: by hand; a float of all the seconds since 1970 would round to 0.2 us."""
    path = _written(tmp_path, "# a camera\nseq,stamp_ns,note\n4,1700000000000000001,a\n6,1700000000033000002,b\n")
    found = read_stamps(path)
    assert found.origin_s == 1_700_000_000
    assert found.time_s == pytest.approx([1e-9, 0.033000002], abs=1e-12)
    assert found.numbers.tolist() == [4, 6]
    assert found.column == "stamp_ns"


def test_the_column_and_its_unit_may_be_named(tmp_path):
    """Oracle: by hand."""
    path = _written(tmp_path, "host,t_s,camera\n1,2,30\n4,5,60\n")
    assert np.array_equal(read_stamps(path).time_s, [0, 3])
    assert np.allclose(read_stamps(path, column="camera", unit="ms").time_s, [0.03, 0.06])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "0 columns end in a unit (_s, _ms, _us, _ns) among none"),
        ("a_s,b_s\n1,2\n", "2 columns end in a unit"),
        ("frame;t_s\n1;2,5\n", "has semicolons in its line of names and no comma; columns must be separated by commas"),
        ("frame\tt_s\n1\t2\n", "has tabs in its line of names"),
        ("t_s\n", "has no stamps"),
        ("t_s\n1\nx\n", "data line 2 has 'x', must be a number"),
        ("t_s\n1e10\n", "data line 1 has 1e10, which is no stamp"),
        ("t_s\n1e999999999\n", "which is no stamp"),
        ("t_s\nnan\n", "data line 1 has nan, which is no stamp"),
        ("t_s,seq\n1,7\n2,7\n", "column 'seq' numbers frames and must rise, data line 2 has 7 after 7"),
        ("t_s,seq\n1,7\n2,7.5\n", "data line 2 has 7.5, which numbers no frame"),
        ("t_s,a\n1\n", "data line 1 has 1 values, there are 2 columns"),
        ("t_s\n1\0\n", "is no CSV"),
        ("t_s\n" + "1" * 70000, "is no CSV"),
    ],
)
def test_what_is_no_file_of_stamps_is_refused(tmp_path, text, said):
    """Oracle: the words of each refusal, with the file before them."""
    path = _written(tmp_path, text)
    with pytest.raises(ArchiveError) as caught:
        read_stamps(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)


def test_a_column_without_unit_or_name_is_refused(tmp_path):
    """Oracle: the words."""
    path = _written(tmp_path, "t\n1\n")
    with pytest.raises(ArchiveError, match="does not say its unit"):
        read_stamps(path, column="t")
    with pytest.raises(ArchiveError, match="'h' is no unit of stamps; give s, ms, us, ns"):
        read_stamps(path, column="t", unit="h")
    with pytest.raises(ArchiveError, match="has no column 'u'; it has t"):
        read_stamps(path, column="u")
    with pytest.raises(ArchiveError, match="does not exist"):
        read_stamps(tmp_path / "none.csv")


@pytest.mark.parametrize(("unit", "is_taken"), [("s", True), ("ms", False), ("ns", False)])
def test_a_unit_may_not_contradict_the_name(tmp_path, unit, is_taken):
    """Oracle: by hand; stamp_s are seconds, whatever is said besides."""
    path = _written(tmp_path, "stamp_s\n1\n")
    if is_taken:
        assert read_stamps(path, column="stamp_s", unit=unit).origin_s == 1
        return
    with pytest.raises(ArchiveError, match=f"column 'stamp_s' says that its unit is s, {unit} was given"):
        read_stamps(path, column="stamp_s", unit=unit)
