"""Numbers put into a rig.toml that a person wrote."""

import pytest

from irtiming.archive.rig_file import read_rig
from irtiming.archive.rig_update import clock_lines, latency_lines, update
from irtiming.errors import ArchiveError
from irtiming.records.rig import Clock, Latency, Measured

TEXT = """# my rig
[beams]
half_separation_mm = 13.0
height_difference_mm = 5.5
whole_slots_between = 9

[clock]   # crystal
relative_error = 0.0  # guessed

[mask]
opening_angle_deg = 75.0
centre_angle_deg = -90.0
"""


@pytest.fixture
def rig(tmp_path):
    """A rig.toml of a person."""
    path = tmp_path / "rig.toml"
    path.write_text(TEXT)
    return path


def test_a_number_is_replaced_and_everything_else_stays(rig):
    """Oracle: the text with one line changed and one added by hand."""
    update(rig, "clock", numbers=clock_lines(Clock(relative_error=Measured(1.25e-5, 3e-9))))
    assert rig.read_text() == TEXT.replace(
        "relative_error = 0.0  # guessed\n", "relative_error = 1.250000e-05  # guessed\nrelative_error_u = 3.00e-09\n"
    )
    assert read_rig(rig).clock == Clock(relative_error=Measured(1.25e-5, 3e-9))


def test_a_section_that_is_not_there_is_added(rig):
    """Oracle: what was put in is read back; the rest of the text is as it was."""
    latency = Latency(application_gate_s=Measured(5e-6, 0.3e-6))
    update(rig, "latency", numbers=latency_lines(latency))
    assert rig.read_text().startswith(TEXT)
    found = read_rig(rig).latency
    assert found.application_gate_s.value == pytest.approx(5e-6)
    assert found.application_gate_s.standard_uncertainty == pytest.approx(0.3e-6)
    assert found.control_gate_s is None


def test_a_file_that_cannot_take_it_is_left_as_it_is(rig):
    """Oracle: the text before; a relative error of 1 is refused by the reader."""
    with pytest.raises(ArchiveError, match="paste the lines yourself"):
        update(rig, "clock", numbers={"relative_error": "1.0"})
    assert rig.read_text() == TEXT
