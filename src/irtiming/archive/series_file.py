"""plan.toml: what a laboratory wants recorded, checked key by key and brought to SI units."""

import math
import re
from pathlib import Path
from string import Formatter
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from irtiming.archive.typed_file import Exact, OneOrSeveral, Part, PositiveTime, Temperature, read_toml, seconds_within
from irtiming.archive.typed_misfit import FileKind, choice, shown
from irtiming.records.frame_events import FrameEvent
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

DEFAULT_NAME = "{utc}_{camera}_{speed}_{delay}_r{run}.nxs"
"""Pattern of the names of recordings."""

NAME_FIELDS = ("utc", "camera", "speed", "delay", "run", "temperature")
"""What may stand in braces in a pattern."""

_KIND = FileKind(name="plan.toml")
_KELVIN = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*(K|mK)\s*")


def _filled(text: str) -> str:
    if not text.strip():
        raise ValueError(f"is '{text}'; it must be text")
    return text


def _speed(text: str) -> str:
    try:
        factor = float(text)
    except ValueError:
        factor = math.nan
    if not 1e-3 <= factor <= 1e3:
        raise ValueError(f"is {text}; it must be from 0.001 to 1000; leave it out for a real rig")
    return text


def _difference_k(text: object) -> float:
    match = _KELVIN.fullmatch(text) if isinstance(text, str) else None
    tolerance_k = math.nan if match is None else float(match[1]) * (1e-3 if match[2] == "mK" else 1.0)
    if not 0 < tolerance_k <= 10:
        raise ValueError(f"is {shown(text)}; it must be a difference up to 10 K, such as '0.1 K'")
    return tolerance_k


def _measured(wanted: dict[str, float]) -> dict[str, float]:
    for name in wanted:
        if name not in MEASURANDS:
            raise ValueError(f".{name} is nothing that is measured; {choice(name, MEASURANDS)}")
    return wanted


def _pattern(pattern: str) -> str:
    try:
        names = [name for _, name, _, _ in Formatter().parse(pattern) if name is not None]
    except ValueError as error:
        raise ValueError(f"is '{pattern}'; its braces do not match ({error})") from error
    if strangers := [name for name in names if name not in NAME_FIELDS]:
        raise ValueError(f"has {{{strangers[0]}}}; {choice(strangers[0], NAME_FIELDS)}")
    if "run" not in names:
        raise ValueError(f"is '{pattern}'; it must have {{run}} in it, so that no two files have one name")
    if not pattern.endswith(".nxs") or "/" in pattern or "\\" in pattern:
        raise ValueError(f"is '{pattern}'; it must be a name without folder that ends in .nxs")
    return pattern


Text = Annotated[str, AfterValidator(_filled)]


class _Devices(Part):
    camera: Text = Field(description="address", examples=["gige:192.168.0.7"])
    trigger_generator: Text = Field(description="serial port", examples=["/dev/ttyUSB1"])
    chopper: Text | None = Field(None, description="address", examples=["mc2000b:/dev/ttyUSB0"])
    blackbody: Text | None = Field(None, description="address", examples=["sr800r:/dev/ttyS0"])
    speed: Annotated[Exact, AfterValidator(_speed)] = Field(
        "1", description="simulated seconds in one of this computer"
    )


class _Camera(Part):
    type: CameraType = Field(description="kind of camera", examples=["photon"])
    readout_mode: ReadoutMode | None = Field(None, description="default: as is usual for the type")
    integration_time: Annotated[float, seconds_within(1e-9, 10.0)] | None = Field(
        None, description="of a photon camera"
    )
    bit_depth: int | None = Field(None, ge=1, le=16, description="default: that of the camera's pixel format")
    features: dict[str, str | bool | int | float] = Field(
        {},
        description="features by their names of GenICam SFNC, set in this order",
        json_schema_extra={"each": "it must be text, a number, true or false"},
    )
    serial_number: str = Field("", description="the camera must say the same; default: any will do")
    correction: str = Field("", description="command by which the camera corrects its non-uniformity")
    frame_event: FrameEvent = Field("trigger", description="what delays count from; other than a trigger: it runs free")

    @model_validator(mode="after")
    def _refuse_integration_time(self) -> "_Camera":
        if self.integration_time is not None and self.type != "photon":
            beside = f"integration_time stands beside type = '{self.type}'"
            raise ValueError(f"{beside}; only a photon camera has one; take it out")
        return self

    def record(self) -> CameraWishes:
        """The same for an acquisition; features as text."""
        texts = {name: str(v).lower() if isinstance(v, bool) else str(v) for name, v in self.features.items()}
        return CameraWishes(
            camera_type=self.type,
            readout_mode=self.readout_mode or USUAL_READOUT[self.type],
            integration_time_s=self.integration_time,
            bit_depth=self.bit_depth,
            features=tuple(texts.items()),
            serial_number=self.serial_number,
            correction=self.correction,
            frame_event=self.frame_event,
        )


class _Wiring(Part):
    falling: Annotated[list[str], OneOrSeveral()] = Field(
        [], description="lines whose falling edge counts", examples=["control_slot"]
    )
    glitch_filter: Annotated[float, seconds_within(0.0, 1e-3)] = Field(
        0.0, description="takes nothing off the timestamps", json_schema_extra={"default": "0 s"}
    )
    camera_pulse: Annotated[float, seconds_within(1e-7, 1.0)] = Field(
        1e-3, description="shorter than the camera's period", json_schema_extra={"default": "1 ms"}
    )
    camera_input: bool = Field(False, description="whether what the camera sends back is recorded")
    spare: bool = Field(False, description="whether the spare input is recorded, such as a pulse per second")


class _Series(Part):
    plan: Text | None = Field(None, description="file of irtiming plan --json", examples=["plan.json"])
    wheel_hz: Annotated[list[Exact], OneOrSeveral()] = Field([], description="speeds of the wheel")
    frame_hz: Exact | None = Field(None, description="frame rate; a fraction in quotes is exact")
    samples: Exact | None = Field(None, description="samples per turn")
    delays: Annotated[list[Exact], OneOrSeveral()] = Field(["0 s"], description="set in the trigger generator")
    repeats: Exact = "1"
    frame_hz_exact: bool = Field(False, description="whether no other frame rate will do")
    tolerance: Exact = Field("1%", description="how far wheel and frame rate may be from the wish")
    control_slots: Exact = Field("100", description="of the wheel")
    between_corrections: Exact | None = Field(None, description="longest time between two corrections of the camera")
    clock_hz: Exact | None = Field(None, description="a series for another clock is refused")

    @model_validator(mode="after")
    def _need_one_of_both(self) -> "_Series":
        wishes = [name for name in _Series.model_fields if name in self.model_fields_set and name != "plan"]
        if self.plan is not None and wishes:
            raise ValueError(f"plan stands beside {wishes[0]}; name a plan, or wish for one here, not both")
        if self.plan is None:
            for name in ("wheel_hz", "frame_hz", "samples"):
                if not getattr(self, name):
                    cure = 'write it there, or plan = "plan.json" of irtiming plan --json'
                    raise ValueError(f"{name} is missing; {cure}")
        return self

    def record(self) -> TriggerWishes | None:
        """The wishes, None where a plan is named."""
        if self.plan is not None:
            return None
        wishes = self.model_dump(exclude={"plan", "wheel_hz", "delays"})
        return TriggerWishes(wheel_hz=tuple(self.wheel_hz), delays=tuple(self.delays) or ("0 s",), **wishes)


class _Blackbody(Part):
    temperature: Annotated[list[Temperature], Field(min_length=1), OneOrSeveral()] = Field(
        description="all runs come again for each", examples=["60 C"]
    )
    settle_within: Annotated[float, seconds_within(1.0, 86400.0)] = Field(
        1800.0, json_schema_extra={"default": "30 min"}
    )
    tolerance: Annotated[float, BeforeValidator(_difference_k, json_schema_input_type=str)] = Field(
        0.1,
        description="how near it must be before a run, and how far it may go during one",
        json_schema_extra={"default": "0.1 K"},
    )


class _References(Part):
    low: Temperature | None = Field(None, description="the colder one", examples=["25 C"])
    high: Temperature | None = Field(None, description="the warmer one", examples=["60 C"])
    frames: int = Field(50, ge=2, le=10_000, description="at each temperature")
    when: ReferenceTime = "before"
    command: str = Field("", description="moves wheel and mask; run with remove or insert as last word")
    file: Text | None = Field(None, description="recording or references of another series", examples=["earlier.nxs"])

    @model_validator(mode="after")
    def _need_one_of_both(self) -> "_References":
        others = [name for name in _References.model_fields if name in self.model_fields_set and name != "file"]
        if self.file is not None:
            if others:
                raise ValueError(f"file stands beside {others[0]}; take them from a file, or record them, not both")
            return self
        for name in ("low", "high"):
            if getattr(self, name) is None:
                raise ValueError(f'{name} is missing; write {name} = "60 C"')
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise ValueError(f"low is {self.low:g} K, high {self.high:g} K; low must be the colder one")
        return self

    def record(self, folder: Path) -> ReferenceWishes:
        """The same for an acquisition."""
        if self.file is not None:
            return ReferenceWishes(file=str(folder / self.file))
        return ReferenceWishes(
            low_k=self.low, high_k=self.high, frames=self.frames, when=self.when, command=self.command
        )


class _Stop(Part):
    chopper: bool = Field(False, description="whether the wheel is stopped after the series")
    uncertainty: Annotated[dict[str, PositiveTime], AfterValidator(_measured)] = Field(
        {}, description="standard uncertainties at which the series ends, named as in the result"
    )


class _Files(Part):
    name: Annotated[str, AfterValidator(_pattern)] = Field(
        DEFAULT_NAME, description="pattern of the names of recordings"
    )


class PlanFile(Part):
    """plan.toml as it is written: times and temperatures are text with a unit, SI once they are read."""

    devices: _Devices
    camera: _Camera
    wiring: _Wiring = _Wiring()
    series: _Series
    blackbody: _Blackbody | None = None
    references: _References | None = None
    stop: _Stop = _Stop()
    files: _Files = _Files()

    @model_validator(mode="after")
    def _refuse_contradictions(self) -> "PlanFile":
        references, has_blackbody = self.references, self.devices.blackbody is not None
        if self.blackbody and not has_blackbody:
            what = "[blackbody] temperature is asked for, but [devices] names no blackbody"
            cure = "name it, or leave this section out"
        elif references and self.camera.type != "photon":
            what = "[references] low is for a photon camera only"
            cure = "a microbolometer camera has a shutter of its own; leave this section out"
        elif references and references.file is None and not has_blackbody:
            what = "[references] low needs a blackbody that can be set"
            cure = "name it in [devices], or take the references from a file"
        elif self.stop.chopper and self.devices.chopper is None:
            what, cure = "[stop] chopper is true, but [devices] names no chopper", "name it, or leave this out"
        else:
            return self
        raise ValueError(f"{what}; {cure}")


def read_series(path: str | Path) -> SeriesPlan:
    """Series described by a plan.toml file, in SI units; paths in it count from its own folder.

    Raises
    ------
    ArchiveError
        If the file cannot be read, is no TOML, misses a key, has an unknown one, or a value that cannot be. One line: file,
        section, key, what is, what to do.
    """
    where = Path(path)
    file, sha256 = read_toml(where, PlanFile, kind=_KIND)
    devices, wiring, blackbody = file.devices, file.wiring, file.blackbody
    return SeriesPlan(
        devices=DeviceAddresses(**devices.model_dump(exclude={"speed"}), speed=float(devices.speed)),
        camera=file.camera.record(),
        wiring=WiringWishes(
            falling=tuple(wiring.falling),
            glitch_filter_s=wiring.glitch_filter,
            camera_pulse_s=wiring.camera_pulse,
            camera_input=wiring.camera_input or file.camera.frame_event == "strobe",
            spare=wiring.spare,
        ),
        plan_file="" if file.series.plan is None else str(where.parent / file.series.plan),
        triggers=file.series.record(),
        blackbody=None
        if blackbody is None
        else BlackbodyWishes(
            temperatures_k=tuple(blackbody.temperature),
            settle_within_s=blackbody.settle_within,
            tolerance_k=blackbody.tolerance,
        ),
        references=None if file.references is None else file.references.record(where.parent),
        stop=StopWishes(chopper=file.stop.chopper, uncertainty_s=tuple(file.stop.uncertainty.items())),
        file_name=file.files.name,
        source=str(where),
        sha256=sha256,
    )
