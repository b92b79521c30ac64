"""rig.toml, written back from a rig: in millimetres, degrees and microseconds."""

from pathlib import Path

from irtiming.archive.json_file import write_atomically
from irtiming.archive.rig_file import LATENCIES, SI
from irtiming.records.rig import CameraOptics, Latency, LightGates, Measured, Rig, WindowTail


def write_rig(rig: Rig, path: str | Path) -> None:
    """Write a rig as rig.toml, in millimetres and degrees; an existing file is replaced.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    write_atomically(rig_text(rig), path)


def rig_text(rig: Rig) -> str:
    """What rig.toml says of a rig, in millimetres and degrees."""
    edges = rig.wheel.cutout_edges_rad
    wheel = [f"control_slots = {rig.wheel.control_slots}", f'rotation = "{rig.wheel.rotation}"']
    if edges is not None:
        wheel.append(f"cutout_edges_rad = [{', '.join(_toml(edge.value) for edge in edges)}]")
        if any(edge.standard_uncertainty for edge in edges):
            numbers = ", ".join(_toml(edge.standard_uncertainty) for edge in edges)
            wheel.append(f"cutout_edges_u_rad = [{numbers}]")
    sections = [
        ["[wheel]", *wheel],
        ["[beams]", *_beam_lines(rig.light_gates)],
        [
            "[mask]",
            *_lines("opening_angle", "deg", number=rig.mask_opening.opening_angle_rad),
            *_lines("centre_angle", "deg", number=rig.mask_opening.centre_angle_rad),
        ],
        ["[latency]", *_latency_lines(rig.latency or Latency())],
        ["[clock]", *([] if rig.clock is None else _plain_lines("relative_error", rig.clock.relative_error))],
        ["[camera]", *_camera_lines(rig.camera)],
    ]
    sections = [lines for lines in sections if len(lines) > 1]
    return "\n\n".join("\n".join(lines) for lines in sections) + "\n"


def _beam_lines(gates: LightGates) -> list[str]:
    offset, height_m = gates.lateral_offset_m, gates.height_m
    return [
        *_lines("half_separation", "mm", number=gates.half_separation_m),
        *_lines("height_difference", "mm", number=gates.height_difference_m),
        f"whole_slots_between = {gates.whole_slots_between}",
        *([] if offset is None else _lines("lateral_offset", "mm", number=offset)),
        *([] if height_m is None else [f"height_mm = {_toml(height_m / SI['mm'])}"]),
    ]


def _latency_lines(latency: Latency) -> list[str]:
    stated = {name: getattr(latency, f"{name}_s") for name in LATENCIES}
    lines = [
        line for name, number in stated.items() if number is not None for line in _lines(name, "us", number=number)
    ]
    common_s = latency.gates_common_u_s
    return lines if common_s is None else [*lines, f"gates_common_u_us = {_toml(common_s / SI['us'])}"]


def _camera_lines(camera: CameraOptics) -> list[str]:
    u_s = camera.integration_time_u_s
    return [
        *([] if camera.distortion is None else _plain_lines("distortion", camera.distortion)),
        *([] if u_s is None else [f"integration_time_u_us = {_toml(u_s / SI['us'])}"]),
        *([] if camera.window_tail is None else _tail_lines(camera.window_tail)),
        *([] if camera.frame_memory is None else _plain_lines("frame_memory", camera.frame_memory)),
        *_lens_lines(camera),
        *([] if camera.roll_rad is None else _lines("roll", "deg", number=camera.roll_rad)),
    ]


def _lens_lines(camera: CameraOptics) -> list[str]:
    focal, centre, calibration = camera.focal_length_px, camera.lens_centre_px, camera.calibration
    lines = [] if focal is None else _stated("focal_length", focal.value, focal.standard_uncertainty)
    if centre is not None:
        lines += _stated("lens_centre", [one.value for one in centre], centre[0].standard_uncertainty)
    if calibration is not None:
        matrix = (*calibration.focal_length_px, *calibration.centre_px)
        k1, *others = calibration.coefficients
        lines += [
            f"camera_matrix = {_toml([one.value for one in matrix])}",
            f"camera_matrix_u = {_toml([one.standard_uncertainty for one in matrix])}",
            f"distortion_coefficients = {_toml([k1.value, *others])}",
            f"distortion_coefficients_u = {_toml(k1.standard_uncertainty)}",
        ]
    return lines


def _stated(name: str, value: float | list[float], u: float) -> list[str]:
    return [f"{name}_px = {_toml(value)}", *([f"{name}_u_px = {_toml(u)}"] if u else [])]


def _tail_lines(tail: WindowTail) -> list[str]:
    return [*_plain_lines("window_tail", tail.share), f"window_tail_us = {_toml(tail.time_constant_s / SI['us'])}"]


def _plain_lines(name: str, number: Measured) -> list[str]:
    u = number.standard_uncertainty
    return [f"{name} = {_toml(number.value)}", *([f"{name}_u = {_toml(u)}"] if u else [])]


def _lines(name: str, unit: str, *, number: Measured) -> list[str]:
    lines = [f"{name}_{unit} = {_toml(number.value / SI[unit])}"]
    if number.standard_uncertainty:
        lines.append(f"{name}_u_{unit} = {_toml(number.standard_uncertainty / SI[unit])}")
    return lines


def _toml(number: float | list[float]) -> str:
    if isinstance(number, list):
        return f"[{', '.join(map(_toml, number))}]"
    return repr(float(f"{number:.15g}"))
