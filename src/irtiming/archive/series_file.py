"""plan.toml: what a laboratory wants recorded, checked key by key and brought to SI units."""

import math
import re
from collections.abc import Callable
from difflib import get_close_matches
from pathlib import Path
from string import Formatter
from typing import Any, final

from irtiming.archive.toml_file import read_table, shown
from irtiming.errors import ArchiveError, UnitError
from irtiming.records.recording import USUAL_READOUT, CameraType, ReadoutMode
from irtiming.records.series_plan import (
    MEASURANDS,
    BlackbodyWishes,
    CameraWishes,
    DeviceAddresses,
    ReferenceTime,
    ReferenceWishes,
    SeriesPlan,
    StopWishes,
    TriggerWishes,
    WiringWishes,
)  # fmt: skip
from irtiming.units import kelvin, readable_time, seconds

DEFAULT_NAME = "{utc}_{camera}_{speed}_{delay}_r{run}.nxs"
"""Pattern of the names of recordings."""

NAME_FIELDS = ("utc", "camera", "speed", "delay", "run", "temperature")
"""What may stand in braces in a pattern."""

_WISHES = (
    "wheel_hz", "frame_hz", "samples", "delays", "repeats", "frame_hz_exact", "tolerance", "control_slots",
    "between_corrections", "clock_hz",
)  # fmt: skip
_KEYS = {
    "devices": ("camera", "trigger_generator", "chopper", "blackbody", "speed"),
    "camera": ("type", "readout_mode", "integration_time", "bit_depth", "features", "serial_number", "correction"),
    "wiring": ("falling", "glitch_filter", "camera_pulse", "camera_input"),
    "series": ("plan", *_WISHES),
    "blackbody": ("temperature", "settle_within", "tolerance"),
    "references": ("low", "high", "frames", "when", "file", "command"),
    "stop": ("chopper", "uncertainty"),
    "files": ("name",),
}
_TYPES: tuple[CameraType, ...] = ("photon", "microbolometer")
_READOUTS: tuple[ReadoutMode, ...] = ("snapshot", "rolling")
_TIMES: tuple[ReferenceTime, ...] = ("before", "after", "both")
_KELVIN = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*(K|mK)\s*")


def read_series(path: str | Path) -> SeriesPlan:
    """Series described by a plan.toml file, in SI units; paths in it count from its own folder.

    Raises
    ------
    ArchiveError
        If the file cannot be read, is no TOML, misses a key, has an unknown one, or a value that cannot be. One line: file,
        section, key, what is, what to do.
    """
    where = Path(path)
    table, sha256 = read_table(where, _KEYS, what="plan.toml")
    for name in ("devices", "camera", "series"):
        if name not in table:
            raise ArchiveError(f"{where}: section [{name}] is missing; write it there")
    sections = {name: _Section(where, name, table=table) for name in _KEYS}
    camera = _camera(sections["camera"])
    plan = SeriesPlan(
        devices=_devices(sections["devices"]),
        camera=camera,
        wiring=_wiring(sections["wiring"]),
        plan_file=_plan_file(sections["series"], where),
        triggers=_triggers(sections["series"]),
        blackbody=_blackbody(sections["blackbody"]) if "blackbody" in table else None,
        references=_references(sections["references"], where) if "references" in table else None,
        stop=_stop(sections["stop"]),
        file_name=_file_name(sections["files"]),
        source=str(where),
        sha256=sha256,
    )
    _refuse_contradictions(plan, sections)
    return plan


@final
class _Section:
    """One table of the file, asked for values key by key; every complaint names file, section and key."""

    def __init__(self, path: Path, name: str, *, table: dict[str, Any]) -> None:
        self._place = f"{path}: [{name}]"
        self._values: dict[str, Any] = table.get(name, {})

    def has(self, key: str) -> bool:
        """Whether the file has the key."""
        return key in self._values

    def wrong(self, key: str, what: str, *, cure: str) -> ArchiveError:
        """Error about a value."""
        return ArchiveError(f"{self._place} {key} {what}; {cure}")

    def text(self, key: str, *, default: str | None = None, example: str = "") -> str:
        """Text of a key; without a default it is required."""
        value = self._values.get(key, default)
        if value is None:
            raise self.wrong(key, "is missing", cure=f'write {key} = "{example}"')
        if not isinstance(value, str) or (not value.strip() and default is None):
            raise self.wrong(key, f"is {shown(value)}", cure=f'it must be text, such as "{example}"')
        return value

    def flag(self, key: str) -> bool:
        """Truth of a key, false where it is absent."""
        value = self._values.get(key, False)
        if not isinstance(value, bool):
            raise self.wrong(key, f"is {shown(value)}", cure="it must be true or false")
        return value

    def count(self, key: str, limits: tuple[int, int], *, default: int) -> int:
        """Whole number within limits, both allowed."""
        value = self._values.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.wrong(key, f"is {shown(value)}", cure="it must be a whole number")
        if not limits[0] <= value <= limits[1]:
            raise self.wrong(key, f"= {value}", cure=f"it must be from {limits[0]} to {limits[1]}")
        return value

    def time(self, key: str, limits: tuple[float, float], *, default: float) -> float:
        """Seconds from text such as ``"250 us"``."""
        if not self.has(key):
            return default
        value = self._converted(key, self._values[key], of=seconds)
        if not limits[0] <= value <= limits[1]:
            least, most = (readable_time(limit) for limit in limits)
            raise self.wrong(
                key, f"= {readable_time(value)}", cure=f"it must be from {least} to {most}: check the unit"
            )
        return value

    def temperatures(self, key: str) -> tuple[float, ...]:
        """Kelvin from text such as ``"60 C"``, or from a list of such texts."""
        values = self.several(key)
        if not values:
            raise self.wrong(key, "is missing", cure=f'write {key} = "60 C"')
        return tuple(self._converted(key, value, of=kelvin) for value in values)

    def several(self, key: str) -> list[Any]:
        """Entries of a list; one value alone is a list of one, and an absent key none."""
        value = self._values.get(key, [])
        return value if isinstance(value, list) else [value]

    def exact(self, key: str, value: Any) -> str:
        """Text of a number that was written in TOML or as text; ``30.303`` stays 30.303 and nothing near it."""
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise self.wrong(key, f"is {shown(value)}", cure="it must be a number, or one in quotes")
        return value if isinstance(value, str) else repr(value)

    def entries(self, key: str) -> dict[str, Any]:
        """Entries of an inline table, none where it is absent."""
        value = self._values.get(key, {})
        if not isinstance(value, dict):
            raise self.wrong(key, f"is {shown(value)}", cure="it must be a table, such as {Name = value}")
        return value

    def time_of(self, key: str, value: Any) -> float:
        """Positive time in an inline table."""
        time_s: float = self._converted(key, value, of=seconds)
        if not time_s > 0:
            raise self.wrong(key, f"= {shown(value)}", cure="it must be more than 0")
        return time_s

    def _converted(self, key: str, value: Any, *, of: Callable[[str], float]) -> float:
        if not isinstance(value, str):
            raise self.wrong(key, f"is {shown(value)}", cure="it must be text with a unit, such as "
                             + ('"250 us"' if of is seconds else '"60 C"'))  # fmt: skip
        try:
            return of(value)
        except UnitError as error:
            raise self.wrong(key, "cannot be read", cure=str(error)) from error


def _devices(section: _Section) -> DeviceAddresses:
    speed = section.exact("speed", section.several("speed")[0]) if section.has("speed") else "1"
    try:
        factor = float(speed)
    except ValueError:
        factor = math.nan
    if not 1e-3 <= factor <= 1e3:
        raise section.wrong("speed", f"is {speed}", cure="it must be from 0.001 to 1000; leave it out for a real rig")
    return DeviceAddresses(
        camera=section.text("camera", example="gige:192.168.0.7"),
        trigger_generator=section.text("trigger_generator", example="/dev/ttyUSB1"),
        chopper=section.text("chopper", example="mc2000b:/dev/ttyUSB0") if section.has("chopper") else None,
        blackbody=section.text("blackbody", example="sr800r:/dev/ttyS0") if section.has("blackbody") else None,
        speed=factor,
    )


def _camera(section: _Section) -> CameraWishes:
    kind = section.text("type", example="photon")
    if kind not in _TYPES:
        raise section.wrong("type", f"is '{kind}'", cure=_choice(kind, _TYPES))
    readout = section.text("readout_mode", default=USUAL_READOUT[kind])
    if readout not in _READOUTS:
        raise section.wrong("readout_mode", f"is '{readout}'", cure=_choice(readout, _READOUTS))
    integrates = section.has("integration_time")
    if integrates and kind != "photon":
        raise section.wrong(
            "integration_time", f"stands beside type = '{kind}'", cure="only a photon camera has one; take it out"
        )
    features = []
    for name, value in section.entries("features").items():
        if isinstance(value, list | dict):
            raise section.wrong(
                f"features.{name}", f"is {shown(value)}", cure="it must be text, a number, true or false"
            )
        features.append((name, str(value).lower() if isinstance(value, bool) else str(value)))
    return CameraWishes(
        camera_type=kind,
        readout_mode=readout,
        integration_time_s=section.time("integration_time", (1e-9, 10.0), default=0.0) if integrates else None,
        bit_depth=section.count("bit_depth", (1, 16), default=16) if section.has("bit_depth") else None,
        features=tuple(features),
        serial_number=section.text("serial_number", default=""),
        correction=section.text("correction", default=""),
    )


def _wiring(section: _Section) -> WiringWishes:
    falling = section.several("falling")
    if not all(isinstance(line, str) for line in falling):
        raise section.wrong(
            "falling", f"is {shown(falling)}", cure='it must be a list of lines, such as ["control_slot"]'
        )
    return WiringWishes(
        falling=tuple(falling),
        glitch_filter_s=section.time("glitch_filter", (0.0, 1e-3), default=0.0),
        camera_pulse_s=section.time("camera_pulse", (1e-7, 1.0), default=1e-3),
        camera_input=section.flag("camera_input"),
    )


def _plan_file(section: _Section, path: Path) -> str:
    inline = [key for key in _WISHES if section.has(key)]
    if section.has("plan") and inline:
        raise section.wrong("plan", f"stands beside {inline[0]}", cure="name a plan, or wish for one here, not both")
    return str(path.parent / section.text("plan", example="plan.json")) if section.has("plan") else ""


def _triggers(section: _Section) -> TriggerWishes | None:
    if section.has("plan"):
        return None
    needed = {key: section.several(key) for key in ("wheel_hz", "frame_hz", "samples")}
    for key, values in needed.items():
        if not values:
            raise section.wrong(key, "is missing", cure='write it there, or plan = "plan.json" of irtiming plan --json')

    def one(key: str, default: str) -> str:
        return section.exact(key, section.several(key)[0]) if section.several(key) else default

    delays = section.several("delays")
    return TriggerWishes(
        wheel_hz=tuple(section.exact("wheel_hz", value) for value in needed["wheel_hz"]),
        frame_hz=one("frame_hz", ""),
        samples=one("samples", ""),
        delays=tuple(section.exact("delays", value) for value in delays) or ("0 s",),
        repeats=one("repeats", "1"),
        frame_hz_exact=section.flag("frame_hz_exact"),
        tolerance=one("tolerance", "1%"),
        control_slots=one("control_slots", "100"),
        between_corrections=one("between_corrections", "") or None,
        clock_hz=one("clock_hz", "") or None,
    )


def _blackbody(section: _Section) -> BlackbodyWishes:
    tolerance = section.text("tolerance", default="0.1 K")
    match = _KELVIN.fullmatch(tolerance)
    tolerance_k = math.nan if match is None else float(match[1]) * (1e-3 if match[2] == "mK" else 1.0)
    if not 0 < tolerance_k <= 10:
        raise section.wrong(
            "tolerance", f"is '{tolerance}'", cure="it must be a difference up to 10 K, such as '0.1 K'"
        )
    return BlackbodyWishes(
        temperatures_k=section.temperatures("temperature"),
        settle_within_s=section.time("settle_within", (1.0, 86400.0), default=1800.0),
        tolerance_k=tolerance_k,
    )


def _references(section: _Section, path: Path) -> ReferenceWishes:
    if section.has("file"):
        others = [key for key in ("low", "high", "frames", "when", "command") if section.has(key)]
        if others:
            raise section.wrong(
                "file", f"stands beside {others[0]}", cure="take them from a file, or record them, not both"
            )
        return ReferenceWishes(file=str(path.parent / section.text("file", example="earlier.nxs")))
    low, high = section.temperatures("low")[0], section.temperatures("high")[0]
    if not low < high:
        raise section.wrong("low", f"is {low:g} K, high {high:g} K", cure="low must be the colder one")
    when = section.text("when", default="before")
    if when not in _TIMES:
        raise section.wrong("when", f"is '{when}'", cure=_choice(when, _TIMES))
    return ReferenceWishes(
        low_k=low,
        high_k=high,
        frames=section.count("frames", (2, 10_000), default=50),
        when=when,
        command=section.text("command", default=""),
    )


def _stop(section: _Section) -> StopWishes:
    wanted = section.entries("uncertainty")
    for name in wanted:
        if name not in MEASURANDS:
            raise section.wrong(f"uncertainty.{name}", "is nothing that is measured", cure=_choice(name, MEASURANDS))
    return StopWishes(
        chopper=section.flag("chopper"),
        uncertainty_s=tuple((name, section.time_of(f"uncertainty.{name}", value)) for name, value in wanted.items()),
    )


def _file_name(section: _Section) -> str:
    pattern = section.text("name", default=DEFAULT_NAME)
    try:
        names = [name for _, name, _, _ in Formatter().parse(pattern) if name is not None]
    except ValueError as error:
        raise section.wrong("name", f"is '{pattern}'", cure=f"its braces do not match ({error})") from error
    strangers = [name for name in names if name not in NAME_FIELDS]
    if strangers:
        raise section.wrong("name", f"has {{{strangers[0]}}}", cure=_choice(strangers[0], NAME_FIELDS))
    if "run" not in names:
        raise section.wrong(
            "name", f"is '{pattern}'", cure="it must have {run} in it, so that no two files have one name"
        )
    if not pattern.endswith(".nxs") or "/" in pattern or "\\" in pattern:
        raise section.wrong("name", f"is '{pattern}'", cure="it must be a name without folder that ends in .nxs")
    return pattern


def _refuse_contradictions(plan: SeriesPlan, sections: dict[str, _Section]) -> None:
    if plan.blackbody is not None and plan.devices.blackbody is None:
        raise sections["blackbody"].wrong(
            "temperature", "is asked for, but [devices] names no blackbody", cure="name it, or leave this section out"
        )
    if plan.references is not None and plan.camera.camera_type != "photon":
        raise sections["references"].wrong(
            "low",
            "is for a photon camera only",
            cure="a microbolometer camera has a shutter of its own; leave this section out",
        )
    if plan.references is not None and not plan.references.file and plan.devices.blackbody is None:
        raise sections["references"].wrong(
            "low", "needs a blackbody that can be set", cure="name it in [devices], or take the references from a file"
        )
    if plan.stop.chopper and plan.devices.chopper is None:
        raise sections["stop"].wrong(
            "chopper", "is true, but [devices] names no chopper", cure="name it, or leave this out"
        )


def _choice(word: str, known: tuple[str, ...]) -> str:
    near = get_close_matches(word.lower(), known, n=1)
    return f"it must be {' or '.join(known)}" + (f", did you mean '{near[0]}'?" if near else "")
