"""`archive.rig_file`: rig.toml in, SI out; every wrong number or key with its cure."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from irtiming.archive.rig_file import read_rig
from irtiming.archive.rig_writer import write_rig
from irtiming.errors import ArchiveError, GeometryError, IrTimingError
from irtiming.records.rig import Clock, Measured

RIG = """
[wheel]
control_slots = 100
rotation = "clockwise"
cutout_edges_rad = [0.0, 1.5710, 3.1423, 4.7134]
cutout_edges_u_rad = 1e-4

[beams]
half_separation_mm = 13.0
half_separation_u_mm = 0.05
height_difference_mm = 5.5
whole_slots_between = 9

[mask]
opening_angle_deg = 75
centre_angle_deg = -90.0
centre_angle_u_deg = 0.03
"""


def test_a_rig_is_read_in_si_units(tmp_path: Path) -> None:
    """Oracle: the numbers of the text, converted by hand."""
    path = tmp_path / "rig.toml"
    path.write_text(RIG)
    rig = read_rig(path)
    assert rig.wheel.control_slots == 100
    assert rig.wheel.rotation == "clockwise"
    assert rig.wheel.cutout_edges_rad is not None
    assert [edge.value for edge in rig.wheel.cutout_edges_rad] == [0.0, 1.5710, 3.1423, 4.7134]
    assert {edge.standard_uncertainty for edge in rig.wheel.cutout_edges_rad} == {1e-4}
    assert rig.light_gates.half_separation_m.value == pytest.approx(0.013, rel=1e-15)
    assert rig.light_gates.half_separation_m.standard_uncertainty == pytest.approx(50e-6)
    assert rig.light_gates.height_difference_m == Measured(pytest.approx(5.5e-3), 0.0)
    assert rig.light_gates.whole_slots_between == 9
    assert rig.mask_opening.opening_angle_rad.value == pytest.approx(math.radians(75))
    assert rig.mask_opening.centre_angle_rad.value == pytest.approx(-math.pi / 2)
    assert rig.mask_opening.centre_angle_rad.standard_uncertainty == pytest.approx(math.radians(0.03))
    assert (rig.source, len(rig.sha256)) == (str(path), 64)


def test_what_may_be_left_out_gets_its_default(tmp_path: Path) -> None:
    """Oracle: the documented defaults."""
    path = tmp_path / "rig.toml"
    path.write_text("[beams]" + RIG.split("[beams]")[1])
    rig = read_rig(path)
    assert (rig.wheel.control_slots, rig.wheel.rotation, rig.wheel.cutout_edges_rad) == (100, "clockwise", None)


def test_a_lens_may_be_stated(tmp_path: Path) -> None:
    """Oracle: the numbers of the text; without them few lenses are excluded; written and read again."""
    path = tmp_path / "rig.toml"
    path.write_text(RIG)
    assert read_rig(path).camera.distortion is None
    for text, expected in (("distortion_u = 0.002", Measured(-0.05, 0.002)), ("", Measured(-0.05))):
        path.write_text(f"{RIG}\n[camera]\ndistortion = -0.05\n{text}\n")
        rig = read_rig(path)
        assert rig.camera.distortion == expected
        write_rig(rig, tmp_path / "again.toml")
        assert read_rig(tmp_path / "again.toml").camera == rig.camera


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("distortion = -0.3", r"\[camera\] distortion = -0.3; it must be from -0.14 to 0.5"),
        ("distortion_u = 0.1", r"\[camera\] distortion_u stands without distortion; add distortion or take it out"),
        ("distortion = 0\ndistortion_u = -1", "a standard uncertainty must be 0 or more"),
        ("distorsion = 0.1", "did you mean 'distortion'"),
    ],
)
def test_a_wrong_lens_is_refused(tmp_path: Path, text: str, message: str) -> None:
    """Oracle: the message, with its cure."""
    path = tmp_path / "rig.toml"
    path.write_text(f"{RIG}\n[camera]\n{text}\n")
    with pytest.raises(IrTimingError, match=message):
        read_rig(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[latency]\napplication_gate_us = 11936.1", "-10000 to 10000 us: a latency in microseconds"),
        ("[latency]\ntrigger_us = -20000", "trigger_us = -20000 us; it must be from -10000 to"),
        ("[camera]\nwindow_tail = 1.5", "window_tail = 1.5; it must be 0 or more and less than 1: a share"),
        ("[camera]\nframe_memory = -1", "frame_memory = -1; it must be more than -1 and less than 1: the share"),
    ],
)
def test_the_limits_of_an_optional_number_are_stated(tmp_path: Path, text: str, message: str) -> None:
    """Oracle: a number above its upper limit is not below its lower one; the limits and hints of the model."""
    path = tmp_path / "rig.toml"
    path.write_text(f"{RIG}\n{text}\n")
    with pytest.raises(GeometryError) as error:
        read_rig(path)
    assert message in str(error.value)


def test_a_written_rig_is_the_rig(tmp_path: Path) -> None:
    """Oracle: reading back; numbers agree to one part in 10^14."""
    (tmp_path / "rig.toml").write_text(RIG.replace("1e-4", "[0, 1e-4, 2e-4, 3e-4]"))
    rig = read_rig(tmp_path / "rig.toml")
    write_rig(rig, tmp_path / "again.toml")
    again = read_rig(tmp_path / "again.toml")
    assert again.wheel == rig.wheel
    for part, names in (
        ("light_gates", ("half_separation_m", "height_difference_m")),
        ("mask_opening", ("opening_angle_rad", "centre_angle_rad")),
    ):
        for name in names:
            was, now = getattr(getattr(rig, part), name), getattr(getattr(again, part), name)
            assert now.value == pytest.approx(was.value, rel=1e-14)
            assert now.standard_uncertainty == pytest.approx(was.standard_uncertainty, rel=1e-14)


EDGES = "[0.0, 1.5710, 3.1423, 4.7134]"
BAD_RIGS = [
    ("control_slots", "control_slot", "[wheel] control_slot is not a key", "did you mean 'control_slots'?"),
    ("[beams]", "[beam]", "[beam] is not a section", "did you mean 'beams'?"),
    ("[beams]", "[zzz]", "[zzz] is not a section", "the sections are wheel, beams, mask"),
    ("half_separation_mm", "half_seperation_mm", "[beams] half_seperation_mm", "did you mean 'half_separation_mm'?"),
    ("half_separation_u_mm", "half_separation_mm_u", "half_separation_mm_u is not a key", "did you mean 'half_s"),
    ("whole_slots_between = 9", "", "[beams] whole_slots_between is missing", "measure it and write it there"),
    ("opening_angle_deg = 75", "", "[mask] opening_angle_deg is missing", "measure it"),
    ("control_slots = 100", "control_slots = 1", "control_slots = 1;", "from 2 to 10000"),
    ("control_slots = 100", "control_slots = 100.5", "control_slots is 100.5", "a whole number"),
    ("control_slots = 100", "control_slots = true", "control_slots is True", "a whole number"),
    ('"clockwise"', '"left"', "rotation is 'left'", "'clockwise' or 'counterclockwise'"),
    ('"clockwise"', "1", "rotation is 1", "as the camera sees the wheel"),
    ('"clockwise"', '["clockwise"]', "rotation is ['clockwise']", "as the camera sees the wheel"),
    (EDGES, "[0.0, 1.57, 3.14]", "cutout_edges_rad is [0.0, 1.57, 3.14]", "four angles"),
    (EDGES, "[0.1, 1.57, 3.1423, 4.71]", "cutout_edges_rad[0] = 0.1 rad", "0 by definition"),
    (EDGES, "[0, 90, 180, 270]", "cutout_edges_rad[1] = 90 rad", "within 10 deg of 1.5708 rad"),
    (EDGES, "[0, 3.1423, 1.571, 4.71]", "cutout_edges_rad[1] = 3.1423 rad", "ascending"),
    (EDGES, "[0, 1.57, 3.13, 4.71]", "cutout_edges_rad[2] = 3.13 rad", "at least pi"),
    (EDGES, '[0, "1.57", 3.1423, 4.71]', "cutout_edges_rad[1] is '1.57'", "a number"),
    ("1e-4", "[1e-4, 1e-4]", "cutout_edges_u_rad is [0.0001, 0.0001]", "a list of four"),
    ("1e-4", "-1e-4", "cutout_edges_u_rad = -0.0001 rad", "0 or more"),
    (f"cutout_edges_rad = {EDGES}\n", "", "cutout_edges_u_rad stands without cutout_edges_rad", "take it out"),
    ("= 13.0", "= 0.0", "half_separation_mm = 0 mm", "greater than 1 mm"),
    ("= 13.0", "= 0.013", "half_separation_mm = 0.013 mm", "in millimetres"),
    ("= 13.0", "= -13.0", "half_separation_mm = -13 mm", "from 0 to 1000 mm"),
    ("= 13.0", "= 13000.0", "half_separation_mm = 13000 mm", "check the unit"),
    ("= 13.0", "= true", "half_separation_mm is True", "it must be a number"),
    ("= 13.0", "= nan", "half_separation_mm = nan", "finite"),
    ("= 13.0", f"= {10**400}", "half_separation_mm", "finite"),
    ("= 13.0", "= 2026-01-01", "half_separation_mm is datetime.date(2026, 1, 1)", "a number"),
    ("= 0.05", "= inf", "half_separation_u_mm = inf", "finite"),
    ("= 0.05", "= -0.05", "half_separation_u_mm = -0.05", "0 or more"),
    ("= 5.5", "= -5.5", "height_difference_mm = -5.5 mm", "from 0 to 1000 mm"),
    ("between = 9", "between = -1", "whole_slots_between = -1", "from 0 to 49"),
    ("between = 9", "between = 50", "whole_slots_between = 50", "from 0 to 49"),
    ("= 75", "= 0", "opening_angle_deg = 0 deg", "greater than 0"),
    ("= 75", "= 400", "opening_angle_deg = 400 deg", "from 0 to 360 deg"),
    ("= 75", "= 90", "opening_angle_deg = 90 deg leaves no plateau", "89.94 deg; use a narrower mask"),
    ("= -90.0", "= -270.0", "centre_angle_deg = -270 deg", "from -180 to 360 deg"),
    ("[mask]", "[mask", "is not valid TOML", "correct that place"),
    ("[wheel]", "wheel = 3\n[other]", "wheel is 3", "it must be a section [wheel]"),
]


@pytest.mark.parametrize(("old", "new", "what", "cure"), BAD_RIGS)
def test_a_wrong_rig_is_refused_in_one_line(tmp_path: Path, old: str, new: str, what: str, cure: str) -> None:
    """Oracle: the ranges of the format; the line names file, key, value and cure."""
    path = tmp_path / "rig.toml"
    assert old in RIG
    path.write_text(RIG.replace(old, new, 1))
    with pytest.raises(IrTimingError) as caught:
        read_rig(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert what in message
    assert cure in message
    assert "\n" not in message


def test_a_missing_section_is_named(tmp_path: Path) -> None:
    """Oracle: the text without [mask]."""
    path = tmp_path / "rig.toml"
    path.write_text(RIG.split("[mask]")[0])
    with pytest.raises(ArchiveError, match=r"section \[mask\] is missing; measure the rig"):
        read_rig(path)


def test_a_mask_as_wide_as_an_ideal_cutout_has_no_plateau(tmp_path: Path) -> None:
    """Oracle: ideal edges leave sectors of 90 deg."""
    path = tmp_path / "rig.toml"
    path.write_text("[beams]" + RIG.split("[beams]")[1].replace("= 75", "= 90.0"))
    with pytest.raises(GeometryError, match=r"no plateau.*narrowest sector, 90 deg"):
        read_rig(path)


def test_a_file_that_cannot_be_read_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Oracle: the state of the file, made by hand."""
    (tmp_path / "latin.toml").write_bytes(b"# M\xfcnchen\n")
    for name, fragment in {
        "none.toml": "does not exist; name the rig.toml",
        "": "is a folder; name the rig.toml in it",
        "latin.toml": "is not UTF-8 text (byte 3); save it as UTF-8",
    }.items():
        with pytest.raises(ArchiveError) as caught:
            read_rig(tmp_path / name)
        assert f"{tmp_path / name}: {fragment}" in str(caught.value)

    def refuse(*_: object) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(ArchiveError, match=r"cannot be read \(Permission denied\); check its permissions"):
        read_rig(tmp_path / "latin.toml")


def test_the_example_rigs_are_read(shared_recordings: Path) -> None:
    """Oracle: the beams of the example rigs are 9 whole slots apart, their masks 75 deg wide."""
    for path in shared_recordings.glob("*/rig.toml"):
        rig = read_rig(path)
        assert rig.light_gates.whole_slots_between == 9
        assert rig.mask_opening.opening_angle_rad.value == pytest.approx(math.radians(75))


_LABORATORY = """
[beams]
half_separation_mm = 13.0
height_difference_mm = 5.5
whole_slots_between = 9
height_mm = 47
lateral_offset_mm = -0.1
lateral_offset_u_mm = 0.05
[mask]
opening_angle_deg = 75.0
centre_angle_deg = -90.0
[latency]
application_gate_us = 5.0
application_gate_u_us = 0.3
trigger_us = 0.8
[clock]
relative_error = 1.2e-5
relative_error_u = 5e-6
[camera]
integration_time_u_us = 15.0
"""


def test_what_a_laboratory_measures_besides_is_read_and_written_back(tmp_path: Path) -> None:
    """Oracle: the numbers above in SI units by hand; written and read again they are the same."""
    path, again = tmp_path / "rig.toml", tmp_path / "again.toml"
    path.write_text(_LABORATORY)
    rig = read_rig(path)
    assert rig.light_gates.height_m == pytest.approx(0.047)
    assert rig.light_gates.lateral_offset_m == Measured(pytest.approx(-1e-4), pytest.approx(5e-5))
    assert rig.latency is not None
    assert rig.latency.application_gate_s == Measured(pytest.approx(5e-6), pytest.approx(3e-7))
    assert rig.latency.control_gate_s is None
    assert rig.latency.trigger_s == Measured(pytest.approx(8e-7), 0.0)
    assert rig.clock == Clock(relative_error=Measured(1.2e-5, 5e-6))
    assert rig.camera.integration_time_u_s == pytest.approx(15e-6)
    write_rig(rig, again)
    assert replace(read_rig(again), source="", sha256="") == replace(rig, source="", sha256="")


def test_what_is_not_stated_is_none(tmp_path: Path) -> None:
    """Oracle: a rig.toml without the sections says nothing of them, which is not the same as zero."""
    path = tmp_path / "rig.toml"
    path.write_text(_LABORATORY.split("height_mm")[0] + "[mask]" + _LABORATORY.split("[mask]")[1].split("[latency]")[0])
    rig = read_rig(path)
    assert (rig.latency, rig.clock, rig.light_gates.lateral_offset_m, rig.camera.integration_time_u_s) == (None,) * 4


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("relative_error = 1.2e-5", "relative_error_u stands without relative_error"),
        ("application_gate_us = 5.0\n", "application_gate_u_us stands without application_gate_us"),
    ],
)
def test_an_uncertainty_without_its_number_is_refused(tmp_path: Path, line: str, complaint: str) -> None:
    """Oracle: a companion without its key is a slip."""
    path = tmp_path / "rig.toml"
    path.write_text(_LABORATORY.replace(line, ""))
    with pytest.raises(ArchiveError) as error:
        read_rig(path)
    assert complaint in str(error.value) or "relative_error is missing" in str(error.value)


_CALIBRATED = """
camera_matrix = [735.2, 734.8, 321.5, 237.25]
camera_matrix_u = [1.5, 1.6, 0.8, 0.9]
distortion_coefficients = [-0.21, 0.13, 0.002, -0.003]
distortion_coefficients_u = 0.01
region_origin_px = [240, 180]
"""


def test_a_calibration_of_others_is_read(tmp_path: Path) -> None:
    """Oracle: the numbers of the text, the region's origin taken off the lens centre; written and read again they are alike."""
    path = tmp_path / "rig.toml"
    path.write_text(f"{RIG}\n[camera]\n{_CALIBRATED}")
    rig = read_rig(path)
    lens = rig.camera.calibration
    assert lens is not None
    assert lens.focal_length_px == (Measured(735.2, 1.5), Measured(734.8, 1.6))
    assert lens.centre_px == (Measured(81.5, 0.8), Measured(57.25, 0.9))
    assert lens.coefficients == (Measured(-0.21, 0.01), 0.13, 0.002, -0.003, 0.0)
    write_rig(rig, tmp_path / "again.toml")
    assert read_rig(tmp_path / "again.toml").camera == rig.camera


def test_what_is_known_of_a_lens_is_read(tmp_path: Path) -> None:
    """Oracle: the numbers of the text; written and read again they are alike."""
    path = tmp_path / "rig.toml"
    path.write_text(f"{RIG}\n[camera]\nfocal_length_px = 735.0\nfocal_length_u_px = 15\nlens_centre_px = [81.5, 57]\n")
    rig = read_rig(path)
    assert rig.camera.focal_length_px == Measured(735.0, 15.0)
    assert rig.camera.lens_centre_px == (Measured(81.5), Measured(57.0))
    write_rig(rig, tmp_path / "again.toml")
    assert read_rig(tmp_path / "again.toml").camera == rig.camera


def test_a_roll_is_read_in_degrees_and_written_again(tmp_path):
    """Oracle: pi / 15 rad are 12 degrees; one by eye has no uncertainty."""
    path = tmp_path / "rig.toml"
    for text, expected in (
        ("roll_deg = 12\nroll_u_deg = 0.3", Measured(math.pi / 15, math.pi / 600)),
        ("roll_deg = -90", Measured(-math.pi / 2)),
        ("", None),
    ):
        path.write_text(f"{RIG}\n[camera]\n{text}\n")
        rig = read_rig(path)
        if expected is None:
            assert rig.camera.roll_rad is None
        else:
            assert rig.camera.roll_rad.value == pytest.approx(expected.value)
            assert rig.camera.roll_rad.standard_uncertainty == pytest.approx(expected.standard_uncertainty)
        write_rig(rig, tmp_path / "again.toml")
        again = read_rig(tmp_path / "again.toml").camera.roll_rad
        assert (again is None) == (expected is None)
        assert again is None or again.value == pytest.approx(expected.value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("camera_matrix = [735.2, 0, 80, 60]", "fx and fy must be greater than 0 px"),
        ("camera_matrix = [735.2, 735, 80]", "it must be a list of four numbers: fx, fy, cx, cy"),
        ("distortion_coefficients = [-0.2, 0.1, 0, 0]", "distortion_coefficients stands without camera_matrix"),
        ("camera_matrix = [735, 735, 80, 60]\ndistortion = 0.1", "distortion stands beside camera_matrix"),
        ("lens_centre_px = [80]", "it must be a list of two numbers, column and row"),
        ("focal_length_px = -3", r"focal_length_px = -3; it must be"),
        ("roll_deg = 200", r"\[camera\] roll_deg = 200 deg; it must be from -180 to 180 deg"),
        ("roll_u_deg = 0.2", r"\[camera\] roll_u_deg stands without roll_deg"),
    ],
)
def test_half_a_calibration_is_refused(tmp_path: Path, text: str, message: str) -> None:
    """Oracle: the cure that names the key."""
    path = tmp_path / "rig.toml"
    path.write_text(f"{RIG}\n[camera]\n{text}\n")
    with pytest.raises(IrTimingError, match=message):
        read_rig(path)
