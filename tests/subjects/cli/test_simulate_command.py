"""What `irtiming simulate` makes for each kind of camera, and what it refuses."""

import json
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from irtiming.archive import reader
from irtiming.cli.main import app
from irtiming.errors import IrTimingError

_SMALL = ("--rows", "24", "--columns", "32", "--frames", "40")


def _simulate(folder: Path, *options: str) -> dict[str, object]:
    done = CliRunner().invoke(app, ["simulate", str(folder), *options])
    if done.exception is not None:
        raise done.exception
    return json.loads((folder / "truth.json").read_text())


def test_microbolometer_gets_what_was_asked(tmp_path: Path) -> None:
    """Oracle: the options, in SI units; a negative time may stand behind an option."""
    truth = _simulate(
        tmp_path, "--camera", "microbolometer", *_SMALL, "--time-constant", "6 ms", "--row-delay", "-40 us",
        "--trigger-delay", "3.9 ms", "--nuc-at", "0.9 s", "--nuc-at", "0.1 s", "--drift-dn-per-s", "-0.5",
        "--delay", "25 ms",
    )  # fmt: skip
    assert truth["camera"] == "microbolometer"
    assert truth["time_constant_s"] == pytest.approx(6e-3)
    assert truth["row_delay_s"] == pytest.approx(-40e-6)
    assert truth["trigger_delay_s"] == pytest.approx(3.9e-3)
    assert truth["shutter_start_s"] == [0.1, 0.9]
    assert truth["drift_per_second_dn"] == -0.5
    recording = reader.read(tmp_path / "bolo-3Hz-25ms.nxs")
    assert (recording.camera_type, recording.readout_mode) == ("microbolometer", "rolling")
    assert recording.frames.shape == (40, 24, 32)
    assert recording.trigger_delay_time_set_s == 0.025


def test_what_is_not_said_is_drawn(tmp_path: Path) -> None:
    """Oracle: the paper's numbers within five tolerances, not exactly; other with another seed."""
    one, other = (
        _simulate(tmp_path / seed, "--camera", "microbolometer", *_SMALL, "--seed", seed) for seed in ("1", "2")
    )
    for name, value, tolerance in (
        ("time_constant_s", 4.819e-3, 3e-4),
        ("trigger_delay_s", 3.872e-3, 3e-4),
        ("row_delay_s", 38.76e-6, 1e-6),
    ):
        assert one[name] == pytest.approx(value, abs=5 * tolerance)
        assert value != one[name] != other[name]


def test_each_defect_has_its_option(tmp_path: Path) -> None:
    """Oracle: what was asked for, in SI units, in truth.json; rig.toml tells nothing of it."""
    truth = _simulate(
        tmp_path, *_SMALL, "--late-application-gate", "5 us", "--late-control-gate", "3 us", "--late-trigger", "0.8 us",
        "--clock-ppm", "-50", "--lateral-offset-mm", "-0.1", "--tilt-deg", "1.4", "-1.1", "--focal-length-px", "600",
        "--lens-centre-px", "3", "-5", "--distortion", "-0.03", "--blur-rows-px", "0.55", "--blur-columns-px", "0.95",
        "--blur-turn-deg", "-30", "--blur-growth", "0.7",
        "--glare", "0.03", "--glare-px", "4", "--glare-shape", "gaussian", "--blade", "-0.012", "--sway", "0.03",
        "--references-anew", "--exponent", "0.9", "--filter", "0.06", "--averaged-frames", "2", "--memory", "0.005",
        "--rise", "10 us", "--fall", "5 us",
        "--tail", "0.04", "--tail-time", "0.2 ms", "--count-time-error", "-12.5 us", "--nuc-at", "0.6 s",
    )  # fmt: skip
    wanted = {
        "late_application_gate_s": 5e-6, "late_control_gate_s": 3e-6, "late_trigger_s": 0.8e-6,
        "clock_relative_error": -50e-6, "lateral_offset_m": -0.1e-3, "tilt_about_row_rad": math.radians(1.4),
        "tilt_about_column_rad": math.radians(-1.1), "focal_length_px": 600, "lens_centre_row_px": 3,
        "lens_centre_column_px": -5, "distortion": -0.03, "blur_rows_px": 0.55, "blur_columns_px": 0.95,
        "blur_turn_rad": math.radians(-30), "blur_growth": 0.7,
        "glare_share": 0.03, "glare_px": 4, "blade_share": -0.012, "sway_share": 0.03, "references_anew": True,
        "exponent": 0.9,
        "filter_share": 0.06, "averaged_frames": 2, "memory_share": 0.005, "rise_s": 10e-6, "fall_s": 5e-6,
        "tail_share": 0.04, "tail_s": 0.2e-3, "count_time_error_s": -12.5e-6,
    }  # fmt: skip
    assert {name: truth[name] for name in wanted} == pytest.approx(wanted)
    assert truth["glare_shape"] == "gaussian"
    assert truth["shutter_start_s"] == [0.6]
    written = (tmp_path / "rig.toml").read_text()
    assert "[latency]" not in written
    assert "[clock]" not in written


def test_a_laboratory_is_drawn_but_for_what_is_asked(tmp_path: Path) -> None:
    """Oracle: rig.toml has the sections; the filter is the one that was asked for, the rest another with another seed."""
    one, other = (
        _simulate(
            tmp_path / seed, "--camera", "microbolometer", *_SMALL, "--laboratory", "--filter", "0.11", "--seed", seed
        )
        for seed in ("1", "2")
    )
    assert one["filter_share"] == other["filter_share"] == 0.11
    assert one["glare_share"] != other["glare_share"] != 0
    written = (tmp_path / "1" / "rig.toml").read_text()
    assert all(word in written for word in ("[latency]", "[clock]", "lateral_offset_u_mm", "application_gate_u_us"))


def test_a_laboratory_without_what_was_asked_to_be_none(tmp_path: Path) -> None:
    """Oracle: the options; a value that is none anyhow is asked for all the same, and all else is as the seed draws it."""
    lab = (*_SMALL, "--laboratory", "--seed", "1")
    none = (
        "--glare", "0", "--tilt-deg", "0", "0", "--late-trigger", "0 us", "--clock-ppm", "0", "--lateral-offset-mm", "0",
        "--lens-centre-px", "0", "0", "--distortion", "0", "--blur-px", "0.7", "--blur-growth", "0",
    )  # fmt: skip
    drawn, asked = _simulate(tmp_path / "drawn", *lab), _simulate(tmp_path / "asked", *lab, *none)
    moved = {name for name, value in asked.items() if value != drawn[name] and "beta" not in name}  # of the beams
    assert moved == {
        "glare_share", "tilt_about_row_rad", "tilt_about_column_rad", "late_trigger_s", "clock_relative_error",
        "lateral_offset_m", "lens_centre_row_px", "lens_centre_column_px", "distortion", "blur_rows_px", "blur_columns_px",
        "blur_growth",
    }  # fmt: skip
    assert {asked[name] for name in moved if not name.startswith("blur_")} == {0}
    assert (asked["blur_rows_px"], asked["blur_columns_px"], asked["blur_growth"]) == (0.7, 0.7, 0)


def test_photon_camera_is_the_default(tmp_path: Path) -> None:
    """Oracle: an integration time of 250 us unless said, a delay that was said."""
    assert _simulate(tmp_path / "a", *_SMALL)["integration_time_s"] == 250e-6
    truth = _simulate(tmp_path / "b", *_SMALL, "--integration-time", "1 ms", "--trigger-delay", "420 us")
    assert (truth["camera"], truth["integration_time_s"]) == ("photon", 1e-3)
    assert truth["trigger_delay_s"] == pytest.approx(420e-6)


def test_a_rolling_photon_camera_gets_what_was_asked(tmp_path: Path) -> None:
    """Oracle: the options, in SI units; references only if they are not put off."""
    options = ("--readout", "rolling", *_SMALL, "--row-delay", "60 us", "--integration-time", "4 ms")
    truth = _simulate(tmp_path / "a", *options)
    assert (truth["camera"], truth["readout_mode"], truth["row_delay_s"]) == ("photon", "rolling", pytest.approx(60e-6))
    recordings = [reader.read(tmp_path / "a" / "cmos-3Hz-0ms.nxs")]
    _simulate(tmp_path / "b", *options, "--reference-frames", "0")
    recordings.append(reader.read(tmp_path / "b" / "cmos-3Hz-0ms.nxs"))
    for recording in recordings:
        assert (recording.camera_type, recording.readout_mode) == ("photon", "rolling")
        assert recording.integration_time_s == pytest.approx(4e-3)
    assert [recording.nonuniformity is None for recording in recordings] == [False, True]


def test_a_snapshot_camera_with_lag_gets_what_was_asked(tmp_path: Path) -> None:
    """Oracle: the options, in SI units; no row delay in the truth."""
    options = (
        "--camera",
        "microbolometer",
        "--readout",
        "snapshot",
        "--time-constant",
        "6 ms",
        "--drift-dn-per-s",
        "2",
    )
    truth = _simulate(tmp_path, *_SMALL, *options)
    assert (truth["camera"], truth["readout_mode"], truth["time_constant_s"]) == ("microbolometer", "snapshot", 6e-3)
    assert "row_delay_s" not in truth
    recording = reader.read(tmp_path / "lagging-3Hz-0ms.nxs")
    assert (recording.camera_type, recording.readout_mode) == ("microbolometer", "snapshot")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--camera", "microbolometer", "--readout", "snapshot", "--row-delay", "1 us"), "or take --readout rolling"),
        (("--readout", "rolling", "--time-constant", "5 ms"), "--time-constant with --camera photon"),
        (("--camera", "microbolometer", "--reference-frames", "5"), "--reference-frames with --camera microbolometer"),
        (("--readout", "rolling", "--integration-time", "33 ms"), "longer than the camera period of 25 ms"),
        (("--row-delay", "1 us"), "--row-delay with --camera photon"),
        (
            ("--scene-time-constant", "9 ms", "--time-constant", "5 ms"),
            "--time-constant, --scene-time-constant with --camera photon",
        ),
        (("--camera", "microbolometer", "--integration-time", "1 ms"), "--integration-time with --camera microbol"),
        (("--camera", "microbolometer", "--nuc-at", "2 s"), "2 s lies outside the run of 1 s"),
        (("--camera", "microbolometer", "--nuc-at", "1 s", "--nuc-at", "1.2 s"), "not overlap"),
        (("--camera", "microbolometer", "--row-delay", "-2 ms"), "takes 48 ms, longer than the camera period"),
        (("--camera", "microbolometer", "--time-constant", "0 s"), "time constant of '0 s'"),
        (("--camera", "microbolometer", "--trigger-delay", "-1 ms"), "trigger delay of '-1 ms'"),
        (("--camera", "microbolometer", "--drift-dn-per-s", "nan"), "--drift-dn-per-s is nan"),
        (("--delay", "99h"), "a delay of '5940 min'"),
        (("--delay", "1e400 s"), "longer than any time"),
        (("--mask-offset-mm", "1e9"), "a mask offset of 1e+09 mm"),
        (("--mask-offset-mm", "nan"), "a mask offset of nan mm"),
        (("--integration-time", "0 s"), "integration time of '0 s'"),
        (("--camera", "microbolometer", "--tail", "0.02"), "which has none"),
        (("--filter", "1.5"), "a filter of 1.5"),
        (("--blade", "3"), "--blade of 3"),
    ],
)
def test_what_makes_no_sense_is_refused_and_nothing_is_left(
    tmp_path: Path, options: tuple[str, ...], says: str
) -> None:
    """Oracle: the message names the option; no file is written."""
    with pytest.raises(IrTimingError, match=".") as refused:
        _simulate(tmp_path / "new", *_SMALL, *options)
    assert says in str(refused.value)
    assert not (tmp_path / "new").exists()
