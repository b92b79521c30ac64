"""What one result says of a camera at one setting: the point of a series over settings, of a campaign, and of a history."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import Literal, final

from irtiming.records.frame_events import FrameEvent
from irtiming.records.recording import CameraType, ReadoutMode

SettingName = Literal[
    "integration_time", "frame_period", "internal_delay_set", "sensor_temperature", "region_first_row", "rows", "gain_setting",
]  # fmt: skip
SETTINGS: Mapping[SettingName, tuple[str, str]] = {
    "integration_time": ("integration time", "s"),
    "frame_period": ("time between frames", "s"),
    "internal_delay_set": ("internal delay set", "s"),
    "sensor_temperature": ("FPA temperature", "K"),
    "region_first_row": ("first row of the region", "1"),
    "rows": ("rows of the region", "1"),
    "gain_setting": ("gain setting", ""),
}
"""Settings on which a timing may depend: what to call each, and its unit; none for words."""

_SAME = 1e-3  # relative


def is_same_setting(one: float | str | None, other: float | str | None) -> bool:
    """Whether two values of a setting are one: words that are equal, numbers that are nearly so, or both not known."""
    if isinstance(one, float | int) and isinstance(other, float | int):
        return abs(one - other) <= _SAME * max(abs(one), abs(other))
    return one == other


@final
@dataclass(frozen=True, kw_only=True)
class CameraKey:
    """Which camera a result is of, as far as it says; two that differ in any of these are never taken together."""

    manufacturer: str
    model: str
    serial_number: str
    camera_type: CameraType
    readout_mode: ReadoutMode
    event: FrameEvent = "trigger"

    @property
    def name(self) -> str:
        """What to call it."""
        return " ".join(word for word in (self.model, self.serial_number) if word) or "camera without a name"

    @property
    def kind(self) -> "CameraKey":
        """The same of all cameras that differ from it in their serial number alone."""
        return replace(self, serial_number="")


@final
@dataclass(frozen=True, kw_only=True)
class PointParameter:
    """A measurand of a point: value, its uncertainty, and what each input that other points have too adds to it, with sign.

    ``degrees_of_freedom`` is inf where u is well known, ``expanded_uncertainty`` U = k u; ``event`` is what the time ends with.
    """

    value: float
    standard_uncertainty: float
    unit: str
    expanded_uncertainty: float
    degrees_of_freedom: float = float("inf")
    event: str = ""
    common: Mapping[str, float] = field(default_factory=dict)


@final
@dataclass(frozen=True, kw_only=True)
class SettingPoint:
    """A result as one point.

    ``label`` says where it comes from. ``settings`` has those that are known, numbers in SI units or words. ``start_time`` is ISO
    8601 of its first recording, or empty; ``findings`` are codes of what the analysis warned of.
    """

    label: str
    camera: CameraKey
    settings: Mapping[SettingName, float | str]
    parameters: Mapping[str, PointParameter]
    start_time: str = ""
    n_recordings: int = 1
    findings: tuple[str, ...] = ()
    simulated: bool = False


def utc(start_time: str) -> datetime | None:
    """A time of ISO 8601, which is UTC where it says no other; None where the text is none."""
    try:
        when = datetime.fromisoformat(start_time)
        return (when if when.tzinfo else when.replace(tzinfo=UTC)).astimezone(UTC)
    except (ValueError, OverflowError):
        return None


def in_time(start_time: str) -> tuple[datetime, str]:
    """By what times of ISO 8601 are sorted, whatever zone each is told in; text that is none comes first."""
    return utc(start_time) or datetime.min.replace(tzinfo=UTC), start_time


def agree(one: SettingPoint, other: SettingPoint, *, besides: SettingName | None = None) -> bool:
    """Whether two results have the same settings, but for one that is named and the FPA temperature, which sways.

    Parameters
    ----------
    one, other
        Of one camera.
    besides
        What may differ.
    """
    names = (set(one.settings) | set(other.settings)) - {besides, "sensor_temperature"}
    return all(is_same_setting(one.settings.get(name), other.settings.get(name)) for name in names)


def groups(
    points: Iterable[SettingPoint], *, besides: SettingName | None = None, of_kind: bool = False
) -> list[list[SettingPoint]]:
    """Results of one camera at one setting together; cameras, settings and results in the order in which they come.

    Parameters
    ----------
    points
        Of any cameras.
    besides
        A setting that may differ within a group.
    of_kind
        Whether cameras of one kind, of whatever serial numbers, are taken together.
    """
    found: dict[CameraKey, list[list[SettingPoint]]] = {}
    for one in points:
        same_camera = found.setdefault(one.camera.kind if of_kind else one.camera, [])
        mine = next((group for group in same_camera if agree(group[0], one, besides=besides)), None)
        same_camera.append([one]) if mine is None else mine.append(one)
    return [group for each in found.values() for group in each]
