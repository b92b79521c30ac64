"""rig.toml: what a person measured on the rig, checked and brought to SI units, and written back."""

import math
from pathlib import Path
from typing import Any, cast, final

from irtiming.archive.result_file import write_atomically
from irtiming.archive.toml_file import read_table, shown
from irtiming.errors import ArchiveError, GeometryError
from irtiming.records.rig import CameraOptics, LightGates, MaskOpening, Measured, Rig, Rotation, Wheel

_MM = 1e-3
_DEG = math.pi / 180
_KEYS = {
    "wheel": ("control_slots", "rotation", "cutout_edges_rad", "cutout_edges_u_rad"),
    "beams": (
        "half_separation_mm", "half_separation_u_mm", "height_difference_mm", "height_difference_u_mm",
        "whole_slots_between",
    ),
    "mask": ("opening_angle_deg", "opening_angle_u_deg", "centre_angle_deg", "centre_angle_u_deg"),
    "camera": ("distortion", "distortion_u"),
}  # fmt: skip
_ROTATIONS = ("clockwise", "counterclockwise")
_FROM_IDEAL_DEG = 10.0
_LARGEST = 1e12
_SMALLEST_HALF_SEPARATION_MM = 1.0
_LARGEST_MM = 1000.0
_HALF_TURN_TOLERANCE_RAD = 1e-3
_DISTORTIONS = (-0.14, 0.5)  # beyond, one number does not describe a lens


def read_rig(path: str | Path) -> Rig:
    """Rig described by a rig.toml file, in SI units.

    Millimetres and degrees become metres and radians. A number without its ``_u_`` companion counts as exact.
    A single ``cutout_edges_u_rad`` applies to all four edges. Without ``[wheel]`` the wheel has 100 control
    slots and turns clockwise; without ``cutout_edges_rad`` the record holds None. Without ``[camera]`` the lens is not known.

    Raises
    ------
    ArchiveError
        If the file cannot be read, is no TOML, misses a key, has an unknown one, or a value of another type.
    GeometryError
        If a number is out of its range, or the mask opening is so wide that there is no plateau.
    """
    where = Path(path)
    table, sha256 = read_table(where, _KEYS, what="rig.toml")
    for name in ("beams", "mask"):
        if name not in table:
            raise ArchiveError(f"{where}: section [{name}] is missing; measure the rig and write it there")
    rig = Rig(
        wheel=_wheel(_Section(where, "wheel", table=table)),
        light_gates=_light_gates(_Section(where, "beams", table=table), _Section(where, "wheel", table=table)),
        mask_opening=_mask_opening(_Section(where, "mask", table=table)),
        camera=_camera(_Section(where, "camera", table=table)),
        source=str(where),
        sha256=sha256,
    )
    _refuse_no_plateau(rig, where)
    return rig


def write_rig(rig: Rig, path: str | Path) -> None:
    """Write a rig as rig.toml, in millimetres and degrees; an existing file is replaced.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    edges = rig.wheel.cutout_edges_rad
    wheel = [f"control_slots = {rig.wheel.control_slots}", f'rotation = "{rig.wheel.rotation}"']
    if edges is not None:
        wheel.append(f"cutout_edges_rad = [{', '.join(_toml(edge.value) for edge in edges)}]")
        if any(edge.standard_uncertainty for edge in edges):
            numbers = ", ".join(_toml(edge.standard_uncertainty) for edge in edges)
            wheel.append(f"cutout_edges_u_rad = [{numbers}]")
    beams = [
        *_lines("half_separation", "mm", number=rig.light_gates.half_separation_m),
        *_lines("height_difference", "mm", number=rig.light_gates.height_difference_m),
        f"whole_slots_between = {rig.light_gates.whole_slots_between}",
    ]
    mask = [
        *_lines("opening_angle", "deg", number=rig.mask_opening.opening_angle_rad),
        *_lines("centre_angle", "deg", number=rig.mask_opening.centre_angle_rad),
    ]
    sections = [["[wheel]", *wheel], ["[beams]", *beams], ["[mask]", *mask]]
    if rig.camera != CameraOptics():
        lens = rig.camera.distortion
        stated = [f"distortion_u = {_toml(lens.standard_uncertainty)}"] if lens.standard_uncertainty else []
        sections.append(["[camera]", f"distortion = {_toml(lens.value)}", *stated])
    write_atomically("\n\n".join("\n".join(lines) for lines in sections) + "\n", path)


@final
class _Section:
    """One table of the file, asked for values key by key; every complaint names file, section and key."""

    def __init__(self, path: Path, name: str, *, table: dict[str, Any]) -> None:
        self._place = f"{path}: [{name}]"
        self._values: dict[str, Any] = table.get(name, {})

    def wrong(self, key: str, what: str, *, cure: str) -> ArchiveError:
        """Error about the kind of a value."""
        return ArchiveError(f"{self._place} {key} {what}; {cure}")

    def impossible(self, key: str, what: str, *, cure: str) -> GeometryError:
        """Error about the size of a value."""
        return GeometryError(f"{self._place} {key} {what}; {cure}")

    def get(self, key: str, *, default: Any = None) -> Any:
        """Value of a key; without a default it is required."""
        if key in self._values:
            return self._values[key]
        if default is None:
            raise self.wrong(key, "is missing", cure="measure it and write it there")
        return default

    def has(self, key: str) -> bool:
        """True if the file has the key."""
        return key in self._values

    def number(self, key: str, value: Any) -> float:
        """Finite float of a value that stands at a key."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.wrong(key, f"is {shown(value)}", cure="it must be a number")
        if not abs(value) <= _LARGEST:
            raise self.impossible(key, f"= {shown(value)}", cure="it must be a finite number")
        return float(value)

    def count(self, key: str, limits: tuple[int, int], *, default: int | None = None) -> int:
        """Whole number within limits, both allowed."""
        value = self.get(key, default=default)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.wrong(key, f"is {shown(value)}", cure="it must be a whole number")
        if not limits[0] <= value <= limits[1]:
            raise self.impossible(key, f"= {value}", cure=f"it must be from {limits[0]} to {limits[1]}")
        return value

    def uncertainty(self, key: str, value: Any) -> float:
        """Standard uncertainty, in the unit of the file."""
        u = self.number(key, value)
        if u < 0:
            raise self.impossible(key, f"= {u:g}", cure="a standard uncertainty must be 0 or more")
        return u

    def measured(self, name: str, unit: str, *, limits: tuple[float, float]) -> Measured:
        """Number ``name_unit`` and its companion ``name_u_unit``, in SI; limits in the unit of the file."""
        key, companion = f"{name}_{unit}", f"{name}_u_{unit}"
        value = self.number(key, self.get(key))
        if not limits[0] <= value <= limits[1]:
            raise self.impossible(
                key,
                f"= {value:g} {unit}",
                cure=f"it must be from {limits[0]:g} to {limits[1]:g} {unit}, check the unit",
            )
        u = self.uncertainty(companion, self.get(companion, default=0.0))
        factor = _MM if unit == "mm" else _DEG
        return Measured(value * factor, u * factor)


def _wheel(section: _Section) -> Wheel:
    rotation = section.get("rotation", default="clockwise")
    if rotation not in _ROTATIONS:
        words = f"it must be '{_ROTATIONS[0]}' or '{_ROTATIONS[1]}', as the camera sees the wheel"
        raise section.wrong("rotation", f"is {shown(rotation)}", cure=words)
    return Wheel(
        control_slots=_control_slots(section),
        rotation=cast("Rotation", rotation),
        cutout_edges_rad=_cutout_edges(section),
    )


def _control_slots(section: _Section) -> int:
    return section.count("control_slots", (2, 10000), default=100)


def _cutout_edges(section: _Section) -> tuple[Measured, Measured, Measured, Measured] | None:
    key, companion = "cutout_edges_rad", "cutout_edges_u_rad"
    if not section.has(key):
        if section.has(companion):
            raise section.wrong(companion, f"stands without {key}", cure=f"add {key} or take it out")
        return None
    values = section.get(key)
    if not isinstance(values, list) or len(values) != 4:
        raise section.wrong(key, f"is {shown(values)}", cure="it must be a list of four angles, alpha_0 to alpha_3")
    u = section.get(companion, default=0.0)
    if isinstance(u, list) and len(u) != 4:
        raise section.wrong(companion, f"has {len(u)} entries", cure="it must be one number, or a list of four")
    uncertainties = u if isinstance(u, list) else [u] * 4
    edges = []
    for index in range(4):
        place = f"{key}[{index}]"
        angle = section.number(place, values[index])
        ideal = index * math.pi / 2
        if index == 0 and angle != 0:
            raise section.impossible(
                place, f"= {angle:g} rad", cure="alpha_0 is 0 by definition; subtract it from all four"
            )
        if abs(angle - ideal) > _FROM_IDEAL_DEG * _DEG:
            raise section.impossible(
                place,
                f"= {angle:g} rad",
                cure=f"it must be within {_FROM_IDEAL_DEG:g} deg of {ideal:.4f} rad, in ascending order",
            )
        if index == 2 and angle < math.pi - _HALF_TURN_TOLERANCE_RAD:
            raise section.impossible(
                place,
                f"= {angle:g} rad",
                cure="it must be at least pi: edge 0 is the one before the longer half turn",
            )
        edges.append(Measured(angle, section.uncertainty(f"{companion}[{index}]", uncertainties[index])))
    return edges[0], edges[1], edges[2], edges[3]


def _light_gates(section: _Section, wheel: _Section) -> LightGates:
    most = (_control_slots(wheel) - 1) // 2
    gates = LightGates(
        half_separation_m=section.measured("half_separation", "mm", limits=(0.0, _LARGEST_MM)),
        height_difference_m=section.measured("height_difference", "mm", limits=(0.0, _LARGEST_MM)),
        whole_slots_between=section.count("whole_slots_between", (0, most)),
    )
    half_mm = 1e3 * gates.half_separation_m.value
    if half_mm < _SMALLEST_HALF_SEPARATION_MM:
        cure = f"it must be greater than {_SMALLEST_HALF_SEPARATION_MM:g} mm: half the beams' distance, in millimetres"
        raise section.impossible("half_separation_mm", f"= {half_mm:g} mm", cure=cure)
    return gates


def _mask_opening(section: _Section) -> MaskOpening:
    opening = MaskOpening(
        opening_angle_rad=section.measured("opening_angle", "deg", limits=(0.0, 360.0)),
        centre_angle_rad=section.measured("centre_angle", "deg", limits=(-180.0, 360.0)),
    )
    if opening.opening_angle_rad.value == 0:
        raise section.impossible("opening_angle_deg", "= 0 deg", cure="it must be greater than 0")
    return opening


def _camera(section: _Section) -> CameraOptics:
    key, companion = "distortion", "distortion_u"
    if not section.has(key):
        if section.has(companion):
            raise section.wrong(companion, f"stands without {key}", cure=f"add {key} or take it out")
        return CameraOptics()
    value = section.number(key, section.get(key))
    if not _DISTORTIONS[0] <= value <= _DISTORTIONS[1]:
        raise section.impossible(
            key,
            f"= {value:g}",
            cure=f"it must be from {_DISTORTIONS[0]:g} to {_DISTORTIONS[1]:g}: k in r_d = r_u (1 + k r_u^2), in half diagonals "
            "of the image",
        )
    return CameraOptics(distortion=Measured(value, section.uncertainty(companion, section.get(companion, default=0.0))))


def _refuse_no_plateau(rig: Rig, path: Path) -> None:
    edges = rig.wheel.cutout_edges_rad
    angles = [index * math.pi / 2 for index in range(4)] if edges is None else [edge.value for edge in edges]
    sectors = [after - before for before, after in zip(angles, [*angles[1:], 2 * math.pi], strict=True)]
    narrowest = min(sectors)
    opening = rig.mask_opening.opening_angle_rad.value
    if opening >= narrowest:
        raise GeometryError(
            f"{path}: [mask] opening_angle_deg = {opening / _DEG:g} deg leaves no plateau: it must "
            f"be narrower than the wheel's narrowest sector, {narrowest / _DEG:.4g} deg; use a narrower mask"
        )


def _lines(name: str, unit: str, *, number: Measured) -> list[str]:
    factor = _MM if unit == "mm" else _DEG
    lines = [f"{name}_{unit} = {_toml(number.value / factor)}"]
    if number.standard_uncertainty:
        lines.append(f"{name}_u_{unit} = {_toml(number.standard_uncertainty / factor)}")
    return lines


def _toml(number: float) -> str:
    return repr(float(f"{number:.15g}"))
