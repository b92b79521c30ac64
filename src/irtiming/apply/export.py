"""The numbers of `apply.handover` as files that other programs read; each says its event and sign, and what it lacks."""

import json
from collections.abc import Callable, Iterator, Mapping
from typing import Literal

from irtiming.apply.handover import HandOver, Number
from irtiming.errors import EstimationError
from irtiming.records.application import Program
from irtiming.records.frame_events import NOUNS


def format_for(program: Program) -> Literal["JSON", "YAML"]:
    """Of the file that a program reads."""
    return "JSON" if program in ("basalt", "gyroflow", "android") else "YAML"


def text_for(program: Program, given: HandOver) -> str:
    """The file for a program.

    Raises
    ------
    EstimationError
        If that program has no number for what this camera has.
    """
    return _WRITERS[program](given)


def _kalibr(given: HandOver) -> str:
    """Camera chain of Kalibr.

    Its wiki, page "yaml formats", says of timeshift_cam_imu: "timeshift between camera and IMU timestamps in seconds (t_imu =
    t_cam + shift)"; its reader (kalibr_common/ConfigReader.py) takes a float alone.
    """
    notes = [
        *_common(given, given.middle_row, "the middle of the image"),
        "sign: t_imu = t_cam + timeshift_cam_imu: the shift is the effective moment minus the stamp; it holds where the IMU is",
        "stamped by the clock that stamps the frames: add what is between the two clocks",
        "merge these lines into cam0 of the camera chain that holds intrinsics and T_cam_imu",
    ]
    lines = ["cam0:", f"  timeshift_cam_imu: {_float(given.middle_row.value_s)}  # s, u = {_u(given.middle_row)}"]
    if given.is_rolling:
        notes.append(
            "the chain of a camera and an IMU has no rolling shutter: line_delay is what Kalibr's own calibration of rolling"
        )
        notes.append("shutters calls LineDelay, s from row to row; other readers leave it out")
        lines.append(f"  line_delay: {_float(given.row_delay.value_s)}  # s, u = {_u(given.row_delay)}")
    return _yaml(notes, [*lines, *_resolution(given)])


def _openvins(given: HandOver) -> str:
    """Kalibr's chain as OpenVINS reads it.

    ``timeshift_cam_imu`` of cam0 becomes ``calib_camimu_dt`` (VioManagerOptions.h), which is added to the camera's times.
    """
    notes = [
        *_common(given, given.middle_row, "the middle of the image"),
        "sign: t_imu = t_cam + t_off, the same as Kalibr's; set calib_cam_timeoffset: false to keep it as it is",
        "for kalibr_imucam_chain.yaml, beside intrinsics and T_imu_cam",
    ]
    if given.is_rolling:
        notes.append(f"OpenVINS has no rolling shutter: rows are up to {_half(given)} off")
    lines = ["cam0:", f"  timeshift_cam_imu: {_float(given.middle_row.value_s)}  # s, u = {_u(given.middle_row)}"]
    return "%YAML:1.0\n" + _yaml(notes, [*lines, *_resolution(given)])


def _vins(given: HandOver) -> str:
    """Lines for the configuration of VINS-Mono and VINS-Fusion.

    It says "readed image clock + td = real image clock (IMU clock)" and "rolling shutter read out time per frame";
    projection_td_factor.cpp counts rows from ROW / 2, so td is that of the middle.
    """
    notes = [
        *_common(given, given.middle_row, "the middle of the image, from which VINS counts rows"),
        "sign: image stamp + td = time of the IMU's clock",
        "VINS-Mono has rolling_shutter and rolling_shutter_tr (first row to one past the last, s); VINS-Fusion reads td alone",
    ]
    lines = [
        "estimate_td: 0",
        f"td: {_float(given.middle_row.value_s)}  # s, u = {_u(given.middle_row)}",
        f"rolling_shutter: {int(given.is_rolling)}",
        f"rolling_shutter_tr: {_float(given.readout.value_s)}  # s, u = {_u(given.readout)}",
    ]
    return "%YAML:1.0\n" + _yaml(notes, lines)


def _basalt(given: HandOver) -> str:
    """Calibration of Basalt (calibration.hpp), as cereal writes it: all in ``value0``, the offset in whole ns.

    Its estimators say "curr_frame->t_ns += calib.cam_time_offset_ns", which gives the sign; in several versions
    (src/vi_estimator/keypoint_vio.cpp, later sqrt_keypoint_vio.cpp) that line stands as a comment, and the offset does nothing.
    """
    notes = [
        *_common(given, given.middle_row, "the middle of the image"),
        "sign: frame t_ns + cam_time_offset_ns = time of the IMU's clock",
        "several versions of Basalt read this offset and do not add it (the line in vi_estimator is a comment): add it to t_ns "
        "of the frames there, or to the stamps beforehand",
        "put this number into value0 of the calibration that holds intrinsics and T_imu_cam",
    ]
    if given.is_rolling:
        notes.append(f"Basalt has no rolling shutter: rows are up to {_half(given)} off")
    content: dict[str, object] = {
        "value0": {"cam_time_offset_ns": round(1e9 * given.middle_row.value_s)},
        "notes": notes,
    }
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _orbslam3(given: HandOver) -> str:
    """Settings of ORB-SLAM3, file version 1.0.

    It has neither an offset of the camera's clock nor a rolling shutter (src/Settings.cc reads none): the stamps that are given
    with the frames are taken to be those of the IMU's clock.
    """
    notes = [
        *_common(given, given.middle_row, "the middle of the image"),
        f"ORB-SLAM3 has no time offset: add {_float(given.middle_row.value_s)} s to the stamp of each frame before it gets them "
        "(times.txt, header.stamp, or irtiming apply time)",
        "sign: stamp + that = time of the IMU's clock",
        "merge these lines into the settings that hold Camera1.fx and IMU.T_b_c1",
    ]
    if given.is_rolling:
        notes.append(f"it has no rolling shutter: rows are up to {_half(given)} off")
    lines = ['File.version: "1.0"']
    if given.rows and given.columns:
        lines += [f"Camera.width: {given.columns}", f"Camera.height: {given.rows}"]
    if given.frame_period_s:
        lines.append(f"Camera.fps: {max(1, round(1 / given.frame_period_s))}")
    return "%YAML:1.0\n---\n" + _yaml(notes, lines)


def _metashape(given: HandOver) -> str:
    """Lines for the Python console of Agisoft Metashape.

    Its API knows Sensor.rolling_shutter, one of Metashape.Shutter.Model: with Full it finds the camera's motion during the
    readout of each picture by itself. It takes neither a readout time nor an offset.
    """
    model = "Full" if given.is_rolling else "Disabled"
    notes = [
        *_common(given, given.middle_row, "the middle of the image"),
        "a delay has no place there: the positions of the pictures (Reference pane, EXIF, CSV) must be those at the effective "
        f"moment, {1e3 * given.middle_row.value_s:+.4f} ms after the stamp",
        "sign: positive is later than the stamp",
    ]
    if given.is_rolling:
        notes.append(
            f"a readout time has no place there either: {1e3 * given.readout.value_s:+.4f} ms, first row to one past the last, "
            f"u = {1e3 * given.readout.u_s:.2g} ms; the motion during it is estimated anew for each picture"
        )
    lines = ["import Metashape", "for sensor in Metashape.app.document.chunk.sensors:",
             f"    sensor.rolling_shutter = Metashape.Shutter.Model.{model}"]  # fmt: skip
    return _yaml(notes, lines)


def _gyroflow(given: HandOver) -> str:
    """Lens profile of Gyroflow (src/core/lens_profile.rs).

    ``frame_readout_time`` is in ms with a direction of its own; stamps are of the middle row: in
    src/core/stabilization/frame_transform.rs rows begin at the stamp minus half of the readout.
    """
    note = " ".join(
        [
            *_common(given, given.middle_row, "the middle of the image"),
            "A profile has no delay: enter as sync offset that the middle row shows the scene "
            f"{1e3 * given.middle_row.value_s:+.3f} ms after the stamp. frame_readout_time: ms from the first row to one past "
            "the last; versions that know no frame_readout_direction want it negative from the bottom up. Gyroflow reads no "
            "profile without a calibrated lens: put these fields into the profile of yours.",
        ]
    )
    content = {
        "name": f"{given.camera or 'camera'} timing by irtiming",
        "note": note,
        "calibrated_by": "irtiming",
        "camera_model": given.camera,
        "frame_readout_time": round(1e3 * abs(given.readout.value_s), 6),
        "frame_readout_direction": "BottomToTop" if given.readout.value_s < 0 else "TopToBottom",
        **({"calib_dimension": {"w": given.columns, "h": given.rows}} if given.rows and given.columns else {}),
        "timing": {
            "frame_readout_time_u": 1e3 * given.readout.u_s,
            "middle_row_after_stamp": 1e3 * given.middle_row.value_s,
            "middle_row_after_stamp_u": 1e3 * given.middle_row.u_s,
            "unit": "ms",
        },
    }
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _opendronemap(given: HandOver) -> str:
    """Options of OpenDroneMap, as its settings.yaml takes them.

    Its manual says of rolling-shutter-readout: "Override the rolling shutter readout time for your camera sensor (in
    milliseconds)", a positive whole number.

    Raises
    ------
    EstimationError
        If the camera is no rolling one, or takes less than a millisecond.
    """
    if not given.is_rolling:
        raise EstimationError(
            "OpenDroneMap has one number, the readout of a rolling shutter; this camera reads all rows at once"
        )
    milliseconds = 1e3 * abs(given.readout.value_s)
    whole = round(milliseconds)
    if whole < 1:
        raise EstimationError(
            f"OpenDroneMap takes whole milliseconds of readout, 1 or more; this camera takes {milliseconds:.3f} ms: leave it out"
        )
    notes = [
        *_common(given, given.middle_row, "the middle of the image"),
        f"readout: {milliseconds:.4f} ms, u = {1e3 * given.readout.u_s:.2g} ms, first row to one past the last; taken whole",
        "a delay has no place there: correct the times of the positions (EXIF, geo.txt) by the effective moment",
    ]
    if given.readout.value_s < 0:
        notes.append(
            "rows are read from the bottom up, for which ODM has no word: turn the pictures by 180 degrees first"
        )
    return _yaml(notes, ["rolling-shutter: true", f"rolling-shutter-readout: {whole}"])


def _android(given: HandOver) -> str:
    """Terms of android.hardware.camera2.CaptureResult, in ns.

    Its reference says of SENSOR_TIMESTAMP: "Time at start of exposure of first row of the image sensor active array", and of
    SENSOR_ROLLING_SHUTTER_SKEW: "Duration between the start of exposure for the first row of the image sensor, and the start
    of exposure for one past the last row".
    """
    begin = given.exposure_start
    if begin is None:
        begin = given.first_row
        words = "the pixels lag and have no exposure: the effective moment of row 0 stands for its start, with an exposure of 0"
    else:
        words = "start of integration of row 0"
    content = {
        "event": words,
        "sign": "SENSOR_TIMESTAMP = stamp + sensor_timestamp_minus_stamp_ns; positive: later than the stamp",
        "sensor_timestamp_minus_stamp_ns": round(1e9 * begin.value_s),
        "sensor_timestamp_minus_stamp_u_ns": 1e9 * begin.u_s,
        "SENSOR_EXPOSURE_TIME": round(1e9 * (given.integration.value_s if given.integration else 0.0)),
        "SENSOR_ROLLING_SHUTTER_SKEW": round(1e9 * abs(given.readout.value_s)),
        "SENSOR_ROLLING_SHUTTER_SKEW_u_ns": 1e9 * given.readout.u_s,
        "rows_from_the_bottom_up": given.readout.value_s < 0,
        "notes": [*_common(given, given.middle_row, "the middle of the image")],
    }  # fmt: skip
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _opencv(given: HandOver) -> str:
    """Numbers by name as ``cv::FileStorage`` reads them; OpenCV itself has no words for timing, so these are the project's."""
    lines = []
    for name, number in (
        ("first_row_after_stamp", given.first_row), ("middle_row_after_stamp", given.middle_row), ("row_delay", given.row_delay),
        ("readout", given.readout),
    ):  # fmt: skip
        lines += [f"{name}_s: {_float(number.value_s)}", f"u_{name}_s: {_float(number.u_s)}"]
    if given.integration is not None:
        lines.append(f"integration_time_s: {_float(given.integration.value_s)}")
    if given.validity is not None:
        lines.append(f"time_constant_s: {_float(given.validity.time_constant_s)}")
    notes = [*_common(given, given.middle_row, "the middle of the image"), "sign: positive is later than the stamp"]
    return "%YAML:1.0\n---\n" + _yaml(notes, lines)


def _ros2(given: HandOver) -> str:
    """Parameters of the node in examples/ros2_effective_stamps.py.

    sensor_msgs/Image says: "Header timestamp should be acquisition time of image".
    """
    notes = [
        *_common(given, given.middle_row, "the middle of the image"),
        "sign: the node adds shift_ns to header.stamp; the stamp then is the effective moment",
    ]
    lines = [
        "effective_stamps:",
        "  ros__parameters:",
        f"    shift_ns: {round(1e9 * given.middle_row.value_s)}",
        f"    shift_u_ns: {_float(1e9 * given.middle_row.u_s)}",
        f"    row_delay_ns: {_float(1e9 * given.row_delay.value_s)}",
        f'    serial_number: "{_plain(given.serial_number)}"',
    ]
    return _yaml(notes, lines)


_WRITERS: Mapping[Program, Callable[[HandOver], str]] = {
    "kalibr": _kalibr, "openvins": _openvins, "vins": _vins, "basalt": _basalt, "orbslam3": _orbslam3, "gyroflow": _gyroflow,
    "opendronemap": _opendronemap, "metashape": _metashape, "android": _android, "opencv": _opencv, "ros2": _ros2,
}  # fmt: skip


def _common(given: HandOver, event: Number, where: str) -> Iterator[str]:
    """What every file says: event, its number, what stands for a lag, and what uncertainties do not include."""
    if given.simulated:
        yield "SIMULATED: the result is not of a real camera"
    yield f"camera: {_plain(given.camera) or 'model not stated'}, serial number {_plain(given.serial_number) or 'not stated'}"
    kind = "reading minus time constant" if given.validity is not None else "middle of integration"
    if given.frames_back is not None:
        kind += f", less {1e6 * given.frames_back.value_s:.1f} us, u = {_u(given.frames_back)}, for the share of the frame before"
    yield f"event: effective moment ({kind}) of {where}, {1e3 * event.value_s:+.4f} ms after the stamp, u = {_u(event)} (k = 1)"
    if given.event != "trigger":
        yield f"stamp: {NOUNS[given.event]}, from which the camera was measured running free; another stamp needs its latency"
    if given.validity is not None:
        yield (
            f"there is no word for the time constant, {1e3 * given.validity.time_constant_s:.3f} ms: one moment stands for the "
            f"lag up to {given.validity.frequency_hz:.2f} Hz, where amplitudes lose 1 % and the shift "
            f"{1e6 * given.validity.shift_s:.0f} us"
        )
    if given.not_counted:
        yield f"not counted, as the recordings' frame periods differ: {given.not_counted}, of the frame before"
    for words in given.not_in_uncertainty:
        yield f"not in the uncertainties: {_plain(words)}"


def _yaml(notes: list[str], lines: list[str]) -> str:
    return "".join(f"# {note}\n" for note in notes) + "\n".join(lines) + "\n"


def _resolution(given: HandOver) -> list[str]:
    return [f"  resolution: [{given.columns}, {given.rows}]"] if given.rows and given.columns else []


def _float(value: float) -> str:
    """A number that every YAML reader takes as one with a fraction: with a point and no exponent."""
    return f"{value:.12f}"


def _u(number: Number) -> str:
    return f"{1e6 * number.u_s:.3g} us"


def _half(given: HandOver) -> str:
    return f"{500 * abs(given.readout.value_s):.2f} ms"


def _plain(text: str) -> str:
    """What a camera says of itself, without what would end a comment or a text in quotes."""
    return "".join(letter for letter in text if letter.isprintable() and letter not in '"\\')[:80]
