"""The wheel calibration as a JSON file: what a measurement of the wheel hands to later analyses."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, final

import numpy as np

from irtiming.archive.result_file import write_result
from irtiming.errors import ArchiveError
from irtiming.physics import slot_orders
from irtiming.records.arrays import Array, read_only
from irtiming.records.wheel_calibration import SlotsAtSpeed, SpeedRipple, WheelCalibration

FORMAT = "irtiming wheel calibration"
VERSION = 1
_MOST_SLOTS = 100_000
_LARGEST = 1e12
_CURE = "write it anew with irtiming calibrate-wheel"
_KEYS = (
    "format", "version", "control_slots", "slot_deviation_rad", "order_variance_rad2", "orders", "ripple", "speeds",
    "gate_separation_rad", "u_gate_separation_rad", "application_edges_rad", "u_application_edges_rad", "recordings", "warnings",
)  # fmt: skip
_RIPPLE_KEYS = ("reference_speed_hz", "deviation_rad", "order_variance_rad2", "order_chance", "chance")
_SPEED_KEYS = ("rotation_speed_hz", "n_turns", "deviation_rad", "order_variance_rad2")


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
        "ripple": None if ripple is None else {key: getattr(ripple, key) for key in _RIPPLE_KEYS},
        "speeds": [{key: getattr(speed, key) for key in _SPEED_KEYS} for speed in wheel.speeds],
    }
    write_result(content, path)


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
    where = Path(path)
    top = _Part(str(where), _table_in(where))
    top.require_format()
    top.require_keys(_KEYS)
    n_slots = top.whole("control_slots", least=2, most=_MOST_SLOTS)
    n_orders = n_slots // 2 + 1
    edges, u_edges = top.four("application_edges_rad"), top.four("u_application_edges_rad")
    if (edges is None) != (u_edges is None):
        raise top.wrong("application_edges_rad", "and u_application_edges_rad must both be given or both be null")
    recordings = [one.require_keys(("name", "sha256")) for one in top.parts("recordings")]
    speeds = tuple(
        SlotsAtSpeed(
            rotation_speed_hz=one.number("rotation_speed_hz", positive=True),
            n_turns=one.whole("n_turns", least=1, most=10**12),
            deviation_rad=one.array("deviation_rad", n_slots),
            order_variance_rad2=one.array("order_variance_rad2", n_orders, least=0.0),
        )
        for one in (part.require_keys(_SPEED_KEYS) for part in top.parts("speeds"))
    )
    if not speeds:
        raise top.wrong("speeds", "is empty, must hold the slots at one speed or more")
    return WheelCalibration(
        slot_deviation_rad=top.array("slot_deviation_rad", n_slots),
        order_variance_rad2=top.array("order_variance_rad2", n_orders, least=0.0),
        ripple=_ripple(top, n_slots),
        speeds=speeds,
        gate_separation_rad=top.number("gate_separation_rad"),
        u_gate_separation_rad=top.number("u_gate_separation_rad", positive=True),
        application_edges_rad=edges,
        u_application_edges_rad=u_edges,
        names=tuple(one.text("name") for one in recordings),
        sha256=tuple(one.text("sha256") for one in recordings),
        warnings=top.texts("warnings"),
    )


def _ripple(top: "_Part", n_slots: int) -> SpeedRipple | None:
    part = top.part("ripple")
    if part is None:
        return None
    part.require_keys(_RIPPLE_KEYS)
    n_orders = n_slots // 2 + 1
    return SpeedRipple(
        reference_speed_hz=part.number("reference_speed_hz", positive=True),
        deviation_rad=part.array("deviation_rad", n_slots),
        order_variance_rad2=part.array("order_variance_rad2", n_orders, least=0.0),
        order_chance=part.array("order_chance", n_orders, least=0.0),
        chance=part.number("chance"),
    )


def _table_in(path: Path) -> Mapping[str, Any]:
    try:
        content = json.loads(path.read_bytes())
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be read ({error.strerror or error}); check its name") from error
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise ArchiveError(f"{path}: is not valid JSON ({error}); {_CURE}") from error
    if not isinstance(content, dict):
        raise ArchiveError(f"{path}: holds a {type(content).__name__}, must be a wheel calibration; {_CURE}")
    return content


def _is_number(value: Any) -> bool:
    """Whether it is a number of a size that can be reckoned with."""
    return isinstance(value, int | float) and not isinstance(value, bool) and -_LARGEST < value < _LARGEST


@final
class _Part:
    """An object of the file, asked for values key by key; every complaint names file and key."""

    def __init__(self, place: str, values: Mapping[str, Any]) -> None:
        self._place, self._values = place, values

    def wrong(self, key: str, what: str) -> ArchiveError:
        """Error about one value."""
        return ArchiveError(f"{self._place}: {key} {what}; {_CURE}")

    def require_format(self) -> None:
        """Refuse another kind of file, and one of a later version."""
        if self._values.get("format") != FORMAT:
            raise ArchiveError(f"{self._place}: is no wheel calibration (its format must be '{FORMAT}'); {_CURE}")
        if self.whole("version", least=1, most=10**6) > VERSION:
            raise self.wrong("version", f"is {self._values['version']}, this irtiming knows {VERSION}: update it, or")

    def require_keys(self, keys: tuple[str, ...]) -> "_Part":
        """Refuse unknown keys and missing ones."""
        unknown, missing = sorted(set(self._values) - set(keys)), [key for key in keys if key not in self._values]
        if unknown:
            raise self.wrong(unknown[0], "is unknown")
        if missing:
            raise self.wrong(missing[0], "is missing")
        return self

    def number(self, key: str, *, positive: bool = False) -> float:
        """A finite number."""
        value: Any = self._values.get(key)
        if not _is_number(value):
            raise self.wrong(key, f"is {value!r:.60}, must be a number")
        if positive and value <= 0:
            raise self.wrong(key, f"is {value}, must be positive")
        return float(value)

    def whole(self, key: str, *, least: int, most: int) -> int:
        """A whole number between limits."""
        value = self._values.get(key)
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise self.wrong(key, f"is {value!r:.60}, must be a whole number from {least} to {most}")
        return value

    def text(self, key: str) -> str:
        """A text."""
        value = self._values.get(key)
        if not isinstance(value, str):
            raise self.wrong(key, f"is {value!r:.60}, must be text")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """A list of texts."""
        values = self._list(key)
        if not all(isinstance(value, str) for value in values):
            raise self.wrong(key, "must be a list of texts")
        return tuple(values)

    def array(self, key: str, size: int, *, least: float = -math.inf) -> Array:
        """Finite numbers, shape (size,), none below ``least``."""
        values = self._list(key)
        if not all(map(_is_number, values)):
            raise self.wrong(key, "must be a list of numbers")
        if len(values) != size:
            raise self.wrong(key, f"has {len(values)} entries, must have {size} for this number of control slots")
        array = np.array(values, dtype=np.float64)
        if np.any(array < least):
            raise self.wrong(key, f"holds {array.min():g}, must not be below {least:g}")
        return read_only(array)

    def four(self, key: str) -> tuple[float, float, float, float] | None:
        """Four numbers, or null."""
        if self._values.get(key) is None:
            return None
        a, b, c, d = (float(value) for value in self.array(key, 4))
        return (a, b, c, d)

    def part(self, key: str) -> "_Part | None":
        """An object, or null."""
        value = self._values.get(key)
        if value is None:
            return None
        if not isinstance(value, dict):
            raise self.wrong(key, f"is {value!r:.60}, must be an object or null")
        return _Part(f"{self._place}: {key}", value)

    def parts(self, key: str) -> list["_Part"]:
        """A list of objects."""
        values = self._list(key)
        if not all(isinstance(value, dict) for value in values):
            raise self.wrong(key, "must be a list of objects")
        return [_Part(f"{self._place}: {key}[{i}]", value) for i, value in enumerate(values)]

    def _list(self, key: str) -> list[Any]:
        value = self._values.get(key)
        if not isinstance(value, list):
            raise self.wrong(key, f"is {value!r:.60}, must be a list")
        return value
