"""The wheel calibration as a JSON file: what a measurement of the wheel hands to later analyses."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from irtiming.archive.json_file import write_json
from irtiming.archive.typed_file import Number, Part, read_json
from irtiming.archive.typed_misfit import FileKind
from irtiming.physics import slot_orders
from irtiming.records.arrays import Array, read_only
from irtiming.records.wheel_calibration import SlotsAtSpeed, SpeedRipple, WheelCalibration

FORMAT = "irtiming wheel calibration"
VERSION = 1
_KIND = FileKind(
    name="wheel calibration", format=FORMAT, version=VERSION, cure="write it anew with irtiming calibrate-wheel"
)

_NotNegative = Annotated[float, Field(ge=0, le=1e12)]
_Positive = Annotated[float, Field(gt=0, le=1e12)]
_FourNumbers = Annotated[list[Number], Field(min_length=4, max_length=4)]


class _Recording(Part):
    name: str
    sha256: str


class _Speed(Part):
    rotation_speed_hz: _Positive
    n_turns: int = Field(ge=1, le=10**12)
    deviation_rad: list[Number]
    order_variance_rad2: list[_NotNegative]


class _Ripple(Part):
    reference_speed_hz: _Positive
    deviation_rad: list[Number]
    order_variance_rad2: list[_NotNegative]
    order_chance: list[_NotNegative]
    chance: Number


class WheelFile(Part):
    """The file as it is written; lists of angles have one entry per control slot, those of variances one per order."""

    format: str
    version: int
    control_slots: int = Field(ge=2, le=100_000)
    gate_separation_rad: Number
    u_gate_separation_rad: _Positive
    application_edges_rad: _FourNumbers | None = Field(json_schema_extra={"must": "it must have 4 entries"})
    u_application_edges_rad: _FourNumbers | None = Field(json_schema_extra={"must": "it must have 4 entries"})
    recordings: list[_Recording]
    warnings: list[str]
    orders: list[dict[str, Any]] = Field(description="amplitude and phase of each order, for people; not read back")
    slot_deviation_rad: list[Number]
    order_variance_rad2: list[_NotNegative]
    ripple: _Ripple | None = Field(json_schema_extra={"must": "it must be an object or null"})
    speeds: list[_Speed] = Field(
        min_length=1, json_schema_extra={"must": "it must hold the slots at one speed or more"}
    )

    @model_validator(mode="after")
    def _check(self) -> "WheelFile":
        if (self.application_edges_rad is None) != (self.u_application_edges_rad is None):
            raise ValueError("application_edges_rad and u_application_edges_rad must both be given or both be null")
        slots, orders = self.control_slots, self.control_slots // 2 + 1
        parts = {"": self, "ripple: ": self.ripple} | {f"speeds[{i}]: ": one for i, one in enumerate(self.speeds)}
        for place, part in parts.items():
            for key in ("slot_deviation_rad", "deviation_rad", "order_variance_rad2", "order_chance"):
                size, found = slots if "deviation" in key else orders, getattr(part, key, None)
                if found is not None and len(found) != size:
                    says = f"has {len(found)} entries, must have {size} for this number of control slots"
                    raise ValueError(f"{place}{key} {says}")
        return self


def write_wheel_calibration(wheel: WheelCalibration, path: str | Path) -> None:
    """Write a calibration as JSON; an existing file is replaced only when the new one is complete.

    Beside what `read_wheel_calibration` takes back, the file lists amplitude and phase of each order, for its reader.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    n_slots = wheel.slot_deviation_rad.size
    ripple = wheel.ripple
    content = {
        "format": FORMAT,
        "version": VERSION,
        "control_slots": n_slots,
        "gate_separation_rad": wheel.gate_separation_rad,
        "u_gate_separation_rad": wheel.u_gate_separation_rad,
        "application_edges_rad": wheel.application_edges_rad,
        "u_application_edges_rad": wheel.u_application_edges_rad,
        "recordings": [
            {"name": name, "sha256": checksum} for name, checksum in zip(wheel.names, wheel.sha256, strict=True)
        ],
        "warnings": wheel.warnings,
        "orders": _orders(wheel),
        "slot_deviation_rad": wheel.slot_deviation_rad,
        "order_variance_rad2": wheel.order_variance_rad2,
        "ripple": None if ripple is None else asdict(ripple),
        "speeds": [asdict(speed) for speed in wheel.speeds],
    }
    write_json(content, path)


def _orders(wheel: WheelCalibration) -> list[dict[str, Any]]:
    """For people and other programs; not read back."""
    n_slots = wheel.slot_deviation_rad.size
    amplitude, phase = (
        slot_orders.amplitude_rad(wheel.slot_deviation_rad),
        slot_orders.phase_rad(wheel.slot_deviation_rad),
    )
    u = slot_orders.u_amplitude_rad(wheel.order_variance_rad2, n_slots)
    return [
        {
            "order": order,
            "amplitude_rad": amplitude[order],
            "u_amplitude_rad": u[order],
            "phase_rad": phase[order],
            "is_separable_from_ripple": wheel.ripple is not None,
        }
        for order in range(1, amplitude.size)
    ]


def read_wheel_calibration(path: str | Path) -> WheelCalibration:
    """Calibration in a file that `write_wheel_calibration` has written, every value checked.

    Raises
    ------
    ArchiveError
        If the file cannot be read, is no wheel calibration, misses a key, has an unknown one, or a value of another type,
        length or size.
    """
    file = read_json(Path(path), WheelFile, kind=_KIND)
    edges, u_edges = file.application_edges_rad, file.u_application_edges_rad
    ripple = file.ripple
    return WheelCalibration(
        slot_deviation_rad=_array(file.slot_deviation_rad),
        order_variance_rad2=_array(file.order_variance_rad2),
        ripple=None if ripple is None else SpeedRipple(**_arrays(ripple)),
        speeds=tuple(SlotsAtSpeed(**_arrays(one)) for one in file.speeds),
        gate_separation_rad=file.gate_separation_rad,
        u_gate_separation_rad=file.u_gate_separation_rad,
        application_edges_rad=None if edges is None else (edges[0], edges[1], edges[2], edges[3]),
        u_application_edges_rad=None if u_edges is None else (u_edges[0], u_edges[1], u_edges[2], u_edges[3]),
        names=tuple(one.name for one in file.recordings),
        sha256=tuple(one.sha256 for one in file.recordings),
        warnings=tuple(file.warnings),
    )


def _array(values: list[float]) -> Array:
    return read_only(np.array(values, dtype=np.float64))


def _arrays(part: Part) -> dict[str, Any]:
    """The values of a part, lists as arrays."""
    return {key: _array(value) if isinstance(value, list) else value for key, value in part}
