"""Files for other programs: their own parsers where one can be had, their signs by hand; and the plain words."""

import importlib.util
import json
from pathlib import Path
from types import SimpleNamespace
from typing import get_args

import numpy as np
import pytest
import yaml
from made_up_result import BOLOMETER, COOLED, made_up_result

from irtiming.apply import camera_timing, export, handover
from irtiming.archive.result_file import write_result
from irtiming.archive.result_model import RigValue
from irtiming.errors import EstimationError, UnitError
from irtiming.records.application import Program
from irtiming.session import hand_over

ROLLING = made_up_result("microbolometer", "rolling", BOLOMETER)
UPWARDS = made_up_result("microbolometer", "rolling", BOLOMETER | {"row_delay": (-4e-5, 2e-7)})
MIDDLE_S = 4e-3 - 5e-3 + 59.5 * 4e-5
"""Of the rolling camera, by hand: delay minus time constant plus half of the 120 rows."""


def _given(result, **late):
    return handover.of_camera(camera_timing.of_result(result), **late)


def _yaml_of(program, given):
    """As PyYAML reads it, which is Kalibr's reader; the line of OpenCV's dialect is OpenVINS's and VINS's own."""
    text = export.text_for(program, given)
    lines = [line for line in text.splitlines() if not line.startswith(("%YAML", "---"))]
    return yaml.safe_load("\n".join(lines))


@pytest.mark.parametrize("program", ["kalibr", "openvins"])
def test_the_shift_of_a_camera_chain_has_kalibr_s_sign(program):
    """Oracle: t_imu = t_cam + shift by hand: an event seen 1.38 ms after its stamp; its reader wants a float."""
    chain = _yaml_of(program, _given(ROLLING))["cam0"]
    assert isinstance(chain["timeshift_cam_imu"], float)
    assert chain["timeshift_cam_imu"] == pytest.approx(MIDDLE_S, abs=1e-9)
    assert chain["resolution"] == [160, 120]
    if program == "kalibr":
        assert chain["line_delay"] == pytest.approx(4e-5)


def test_an_independent_estimate_of_the_offset_agrees():
    """Oracle: angular rates of an IMU and of a lagging rolling camera, both stepped; their offset by cross-correlation."""
    given = _given(ROLLING)
    fine_s = np.arange(0, 30, 1e-4)
    rng = np.random.default_rng(5)
    rate = np.convolve(rng.normal(size=fine_s.size), np.hanning(8001) / 4000, mode="same")  # slow against the lag
    lagged, per_step = np.zeros_like(rate), 1e-4 / 5e-3
    for n in range(1, rate.size):  # trapezoids of the lag
        seen = (rate[n] + rate[n - 1]) / 2
        lagged[n] = (lagged[n - 1] * (1 - per_step / 2) + seen * per_step) / (1 + per_step / 2)
    stamps_s = np.arange(1, 29, 1 / 50)
    camera = np.interp(
        stamps_s + 4e-3 + 59.5 * 4e-5, fine_s, lagged
    )  # read after its stamp, in the middle of the image
    shifts_s = np.arange(-6e-3, 6e-3, 1e-5)
    likeness = [np.corrcoef(np.interp(stamps_s + shift, fine_s, rate), camera)[0, 1] for shift in shifts_s]
    assert shifts_s[int(np.argmax(likeness))] == pytest.approx(given.middle_row.value_s, abs=3 * given.middle_row.u_s)


def test_vins_gets_td_of_the_middle_and_the_readout():
    """Oracle: by hand; image stamp + td = IMU's clock, rows from ROW / 2, readout of 120 rows."""
    found = _yaml_of("vins", _given(ROLLING))
    assert found["td"] == pytest.approx(MIDDLE_S, abs=1e-9)
    assert found["rolling_shutter"] == 1
    assert found["rolling_shutter_tr"] == pytest.approx(120 * 4e-5)
    snapshot = _yaml_of("vins", _given(made_up_result("photon", "snapshot", COOLED)))
    assert snapshot["rolling_shutter"] == 0
    assert snapshot["td"] == pytest.approx(5.25e-4, abs=1e-9)


def test_basalt_gets_whole_nanoseconds_that_are_added():
    """Oracle: t_ns += cam_time_offset_ns by hand; all in value0, as cereal reads it."""
    found = json.loads(export.text_for("basalt", _given(ROLLING)))
    assert found["value0"] == {"cam_time_offset_ns": round(1e9 * MIDDLE_S)}
    assert any("do not add it" in note for note in found["notes"])


def test_orb_slam3_gets_what_it_has_and_the_shift_as_a_note():
    """Oracle: the keys of its settings; 33 ms are 30 frames per second; it has no key for a time offset."""
    found = _yaml_of("orbslam3", _given(ROLLING))
    assert found == {"File.version": "1.0", "Camera.width": 160, "Camera.height": 120, "Camera.fps": 30}
    text = export.text_for("orbslam3", _given(ROLLING))
    assert f"add {MIDDLE_S:.12f} s to the stamp of each frame" in text


@pytest.mark.parametrize(
    ("result", "model"), [(ROLLING, "Full"), (made_up_result("photon", "snapshot", COOLED), "Disabled")]
)
def test_metashape_gets_lines_that_python_takes(result, model):
    """Oracle: Python's parser, and a stand-in for its document: the model of every sensor."""
    sensors = [SimpleNamespace(rolling_shutter=None) for _ in range(2)]
    document = SimpleNamespace(chunk=SimpleNamespace(sensors=sensors))
    stand_in = SimpleNamespace(
        app=SimpleNamespace(document=document),
        Shutter=SimpleNamespace(Model=SimpleNamespace(Full="Full", Disabled="Disabled")),
    )
    text = export.text_for("metashape", _given(result)).replace("import Metashape\n", "")
    exec(compile(text, "metashape.py", "exec"), {"Metashape": stand_in})
    assert [one.rolling_shutter for one in sensors] == [model, model]


REMEMBERING = made_up_result("photon", "snapshot", COOLED | {"pixel_memory": (2e-3, 5e-4)})
"""Holds 0.2 % of the frame before, which was 33 ms earlier: 66 us, u = 16.5 us."""


def test_a_share_of_the_frame_before_is_named_wherever_the_effective_moment_stands():
    """Oracle: by hand, 0.2 % of 33 ms; the middle of integration is 525 us after the edge, the effective moment 459 us."""
    given = _given(REMEMBERING)
    assert given.middle_row.value_s == pytest.approx(5.25e-4 - 6.6e-5, abs=1e-12)
    assert given.middle_row.u_s == pytest.approx(np.hypot(3e-7, 1.65e-5), rel=1e-9)
    assert (given.frames_back.value_s, given.frames_back.u_s) == pytest.approx((6.6e-5, 1.65e-5), rel=1e-9)
    assert "middle of integration, less 66.0 us, u = 16.5 us, for the share of" in export.text_for("kalibr", given)


def test_a_filter_s_share_counts_every_frame_before():
    """Oracle: a geometric series by hand; 4 % of the frame before, and of the one before that ..., are k / (1 - k) frames."""
    given = _given(made_up_result("microbolometer", "rolling", BOLOMETER | {"recursive_filter": (0.04, 1e-4)}))
    assert given.frames_back.value_s == pytest.approx(0.04 / 0.96 * 0.033, rel=1e-9)
    assert given.frames_back.u_s == pytest.approx(1e-4 / 0.96**2 * 0.033, rel=1e-9)


def _with_periods(result, *periods_s, folder):
    path, (one, *_) = folder / "several.json", result.inputs
    inputs = [one.model_copy(update={"frame_period": period_s}) for period_s in periods_s]
    write_result(result.model_copy(update={"inputs": inputs}).model_dump(mode="json"), path)
    return path


def test_frame_periods_that_plans_for_several_speeds_have_are_one(tmp_path):
    """Oracle: by hand, 0.2 % of 33.1 ms, the mean of 33.0 ms and 33.2 ms, before 525 us."""
    said = " ".join(hand_over.explain(_with_periods(REMEMBERING, 0.033, 0.0332, folder=tmp_path)))
    assert "459 ± 17 µs" in said


def test_a_share_of_a_frame_that_was_at_no_one_time_before_is_refused(tmp_path):
    """Oracle: by hand; recordings at 33 and 34 ms have no one frame before; the share is 4 u, so 525 us would be 4 u wrong."""
    path = _with_periods(REMEMBERING, 0.033, 0.034, folder=tmp_path)
    with pytest.raises(
        EstimationError, match=r"periods that differ \(30.303 Hz, 29.412 Hz\): .* give frame_hz, the frame rate"
    ):
        hand_over.explain(path)
    with pytest.raises(
        EstimationError, match="frame_hz is 25 Hz, must be that of a recording of the result: 30.303 Hz, 29.412"
    ):
        hand_over.explain(path, frame_hz=25.0)


@pytest.mark.parametrize(("period_s", "words"), [(0.033, "459 ± 17 µs"), (0.034, "457 ± 17 µs")])
def test_a_share_counts_at_the_frame_rate_at_which_the_camera_is_used(tmp_path, period_s, words):
    """Oracle: by hand; 0.2 % of either frame period before 525 us, a quarter of that uncertain; export says the same."""
    path = _with_periods(REMEMBERING, 0.033, 0.034, folder=tmp_path)
    assert words in " ".join(hand_over.explain(path, frame_hz=1 / period_s))
    order = hand_over.ExportOrder(result=path, program="ros2", out=tmp_path / "out.yaml", frame_hz=1 / period_s)
    assert hand_over.hand_over(order).middle_row.value_s == pytest.approx(525e-6 - 0.002 * period_s)


def test_a_share_that_may_be_none_is_named_as_left_out(tmp_path):
    """Oracle: by hand; a share of 1 u at 33 and 34 ms: 525 us stay, and the words say what is not held."""
    doubtful = made_up_result("photon", "snapshot", COOLED | {"pixel_memory": (5e-4, 5e-4)})
    said = " ".join(hand_over.explain(_with_periods(doubtful, 0.033, 0.034, folder=tmp_path)))
    assert "525.0" in said
    assert "Not counted is the pixel memory of 0.05 % (u = 0.05 %), the share of the frame before in each frame" in said
    assert "since it was not stated: pixel" not in said
    counted = " ".join(hand_over.explain(_with_periods(doubtful, 0.033, 0.034, folder=tmp_path), frame_hz=1 / 0.033))
    assert "508 ± 17 µs" in counted  # 0.05 % of 33 ms before 525 us, and as uncertain
    assert "Not counted" not in counted


def test_a_latency_of_the_stamps_is_taken_off():
    """Oracle: by hand; stamps 2 ms after the trigger edge, 30 us sure."""
    given = _given(ROLLING, stamp_latency_s=2e-3, stamp_latency_u_s=3e-5)
    alone = _given(ROLLING)
    assert given.middle_row.value_s == pytest.approx(MIDDLE_S - 2e-3)
    assert given.middle_row.u_s == pytest.approx(np.hypot(alone.middle_row.u_s, 3e-5))


@pytest.mark.parametrize("u_s", [-3e-5, float("nan")])
def test_no_standard_uncertainty_is_negative(u_s):
    """Oracle: its definition, GUM 2.3.1; at the boundary, 0, a latency is exact."""
    hand_over.ExportOrder(result=Path("r"), program="vins", out=Path("o"), stamp_latency_u_s=0.0)
    with pytest.raises(UnitError, match="stamp_latency_u_s is .*, must be 0 or more"):
        hand_over.ExportOrder(result=Path("r"), program="vins", out=Path("o"), stamp_latency_u_s=u_s)


@pytest.mark.parametrize(("result", "direction"), [(ROLLING, "TopToBottom"), (UPWARDS, "BottomToTop")])
def test_gyroflow_gets_milliseconds_and_a_direction(result, direction):
    """Oracle: by hand, 120 rows of 40 us; the direction by its own names."""
    profile = json.loads(export.text_for("gyroflow", _given(result)))
    assert profile["frame_readout_time"] == pytest.approx(4.8)
    assert profile["frame_readout_direction"] == direction
    assert profile["calib_dimension"] == {"w": 160, "h": 120}


def test_opendronemap_gets_whole_milliseconds_or_nothing():
    """Oracle: its own option takes positive whole numbers; 4.8 ms are 5."""
    assert _yaml_of("opendronemap", _given(ROLLING)) == {"rolling-shutter": True, "rolling-shutter-readout": 5}
    assert "turn the pictures by 180 degrees" in export.text_for("opendronemap", _given(UPWARDS))
    with pytest.raises(EstimationError, match="reads all rows at once"):
        export.text_for("opendronemap", _given(made_up_result("photon", "snapshot", COOLED)))
    fast = made_up_result("microbolometer", "rolling", BOLOMETER | {"row_delay": (1e-6, 1e-8)})
    with pytest.raises(EstimationError, match=r"takes 0\.120 ms: leave it out"):
        export.text_for("opendronemap", _given(fast))


def test_android_gets_start_of_exposure_and_skew():
    """Oracle: by hand, in ns; the skew goes to one past the last row."""
    numbers = COOLED | {"row_delay": (1e-5, 1e-8)}
    found = json.loads(export.text_for("android", _given(made_up_result("photon", "rolling", numbers))))
    assert found["sensor_timestamp_minus_stamp_ns"] == 400_000
    assert found["SENSOR_EXPOSURE_TIME"] == 250_000
    assert found["SENSOR_ROLLING_SHUTTER_SKEW"] == 1_200_000
    assert "pixels lag and have no exposure" in json.loads(export.text_for("android", _given(ROLLING)))["event"]


def test_opencv_reads_its_numbers():
    """Oracle: OpenCV's dialect begins with %YAML:1.0; numbers as PyYAML reads the rest."""
    text = export.text_for("opencv", _given(ROLLING))
    assert text.startswith("%YAML:1.0\n---\n")
    found = _yaml_of("opencv", _given(ROLLING))
    assert found["row_delay_s"] == pytest.approx(4e-5)
    assert found["u_row_delay_s"] == pytest.approx(2e-7)
    assert found["time_constant_s"] == pytest.approx(5e-3)


@pytest.mark.parametrize("program", get_args(Program))
def test_every_file_says_event_validity_and_what_is_not_held(program):
    """Oracle: the words; a lag of 5 ms keeps 99 % up to 0.1425 / (2 pi tau) = 4.54 Hz, and SIMULATED comes first."""
    result = ROLLING.model_copy(update={"not_in_uncertainty": ["the weather"], "simulated": True})
    text = export.text_for(program, _given(result))
    for words in (
        "effective moment (reading minus time constant) of the middle of the image",
        "up to 4.54 Hz",
        "the weather",
    ):
        assert words in text
    assert "SIMULATED" in text


def test_names_of_a_camera_cannot_leave_their_place():
    """Oracle: a serial number with a line break and a quote stays one text of one line."""
    result = made_up_result("microbolometer", "rolling", BOLOMETER, serial_number='7"\nshift_ns: 9')
    found = _yaml_of("ros2", _given(result))["effective_stamps"]["ros__parameters"]
    assert found["serial_number"] == "7shift_ns: 9"
    assert found["shift_ns"] == round(1e9 * MIDDLE_S)


def test_the_validity_of_one_moment_is_that_of_the_lag():
    """Oracle: a sine of that frequency through small steps of the lag loses 1 % and shifts by what is stated."""
    found = _given(ROLLING).validity
    time_s = np.arange(0, 12 / found.frequency_hz, 2e-5)
    wave, lagged = np.sin(2 * np.pi * found.frequency_hz * time_s), np.zeros(time_s.size)
    for n in range(1, time_s.size):
        lagged[n] = lagged[n - 1] + ((wave[n] + wave[n - 1]) / 2 - lagged[n - 1]) * 2e-5 / 5e-3
    late = slice(-int(6 / found.frequency_hz / 2e-5), None)
    turning = np.exp(-2j * np.pi * found.frequency_hz * time_s[late])
    ratio = (lagged[late] @ turning) / (wave[late] @ turning)
    assert abs(ratio) == pytest.approx(0.99, abs=5e-4)
    shift_s = -np.angle(ratio) / (2 * np.pi * found.frequency_hz)
    assert 5e-3 - shift_s == pytest.approx(found.shift_s, abs=1.5e-5)


def _example():
    path = Path(__file__).parents[3] / "examples" / "ros2_effective_stamps.py"
    spec = importlib.util.spec_from_file_location("ros2_effective_stamps", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_ros_example_shifts_stamps_exactly():
    """Oracle: by hand, across a second and before 1970."""
    example = _example()
    assert example.effective_stamp(1_700_000_000, 999_999_999, shift_ns=2) == (1_700_000_001, 1)
    assert example.effective_stamp(5, 1, shift_ns=-3) == (4, 999_999_998)
    assert example.row_stamps(1000, rows=3, row_delay_ns=-10.0) == [1010, 1000, 990]
    with pytest.raises(ValueError, match="lies before 0"):
        example.effective_stamp(0, 1, shift_ns=-3)


def _explained(tmp_path, result):
    content = result.model_dump(mode="json")
    write_result(
        {key: value for key, value in content.items() if key not in ("format", "version")}, tmp_path / "result.json"
    )
    return "\n".join(hand_over.explain(tmp_path / "result.json"))


def test_a_rolling_camera_in_plain_words(tmp_path):
    """Oracle: by hand; 119 rows of 40 us are 4.76 ms, by which an edge at 100 px/s leans 0.48 px."""
    words = _explained(tmp_path, ROLLING)
    assert "The middle row of your frame shows the world as it was 1.380 ± 0.033 ms after the trigger edge." in words
    assert "the bottom row shows the world 4.760 ± 0.024 ms later than the top row" in words
    assert "leans by 45°, 119 px from top to bottom; one that moves at 100 px/s leans by 0.48 px" in words
    assert "time constant of 5.0000 ± 0.0060 ms: 15.000 ± 0.018 ms after a sudden change it shows 95 % of it" in words
    assert "Rows are read from the bottom to the top" in _explained(tmp_path, UPWARDS)


def test_a_cooled_camera_in_plain_words(tmp_path):
    """Oracle: by hand; a window of 250 us about 525 us, with the uncertainty that rig.toml states."""
    words = _explained(tmp_path, made_up_result("photon", "snapshot", COOLED))
    assert "Your frame shows the world as it was 525.00 ± 0.30 µs after the trigger edge." in words
    assert "It is a mean over 250 µs:" in words
    stated = made_up_result("photon", "snapshot", COOLED)
    values = [RigValue(name="camera.integration_time_u", value=7.4e-6, unit="s")]
    stated = stated.model_copy(update={"rig": stated.rig.model_copy(update={"values": values})})
    assert "It is a mean over 250.0 ± 7.4 µs:" in _explained(tmp_path, stated)
    old = made_up_result("microbolometer", "snapshot", {"trigger_delay": (2e-3, 1e-5), "time_constant": (5e-3, 1e-5)})
    assert "3.000 ± 0.014 ms before the trigger edge" in _explained(tmp_path, old)
