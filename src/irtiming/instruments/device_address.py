"""Addresses of devices, ``"scheme:rest"``, and the drivers behind the schemes: built in, or entry points of plug-ins."""

from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any, final

from irtiming.errors import InstrumentError

CAMERAS, CHOPPERS, BLACKBODIES = "irtiming.cameras", "irtiming.choppers", "irtiming.blackbodies"
_BUILT_IN = {
    CAMERAS: {
        "gige": "irtiming.instruments.genicam.gige_vision_camera:connected",
        "aravis": "irtiming.instruments.genicam.aravis_camera:connected",
    },
    CHOPPERS: {"mc2000b": "irtiming.instruments.thorlabs_mc2000b:connected"},
    BLACKBODIES: {"sr800r": "irtiming.instruments.ci_sr800r:connected"},
}
_NOUNS = {CAMERAS: "camera", CHOPPERS: "chopper", BLACKBODIES: "blackbody"}


@final
@dataclass(frozen=True, kw_only=True)
class Driver:
    """A driver under its scheme; ``entry_point`` is None where it cannot be loaded, and ``load_error`` says why."""

    scheme: str
    distribution: str
    entry_point: EntryPoint | None
    load_error: str = ""


def drivers(group: str) -> tuple[Driver, ...]:
    """All drivers of a group, loaded to see whether they can be.

    Parameters
    ----------
    group
        `CAMERAS`, `CHOPPERS` or `BLACKBODIES`, or another entry-point group.

    Returns
    -------
    One for each scheme, in the order of the alphabet.
    """
    return tuple(_tried(point) for _, point in sorted(_entry_points(group).items()))


def connect(group: str, address: str) -> AbstractAsyncContextManager[Any]:
    """Device at an address, for the length of an ``async with`` block; nothing is opened before it is entered.

    Parameters
    ----------
    group
        `CAMERAS`, `CHOPPERS` or `BLACKBODIES`, or another entry-point group.
    address
        Scheme, colon, and what the driver understands, such as ``"gige:192.168.0.7"``.

    Raises
    ------
    InstrumentError
        If the address has no scheme, the scheme is unknown, or its driver cannot be loaded.
    """
    points = _entry_points(group)
    scheme, colon, rest = address.partition(":")
    noun = _NOUNS.get(group, "device")
    known = ", ".join(f"{name}:..." for name in sorted(points)) or "none; install a driver"
    if not colon or scheme not in points:
        what = f"no driver {scheme!r}" if colon else "no driver"
        raise InstrumentError(f"{noun} address {address!r} names {what}; addresses that can be used: {known}")
    if not rest:
        raise InstrumentError(f"{noun} address {address!r} ends after the colon; say where the device is")
    try:
        return points[scheme].load()(rest)
    except (ImportError, AttributeError) as error:
        raise InstrumentError(f"the driver of {address} cannot be loaded: {_reason(error)}") from error


def _entry_points(group: str) -> dict[str, EntryPoint]:
    """Built-in ones first; a plug-in cannot take their names, so that an address means the same everywhere."""
    found = {point.name: point for point in entry_points(group=group)}
    own = {name: EntryPoint(name=name, value=value, group=group) for name, value in _BUILT_IN.get(group, {}).items()}
    return found | own


def _tried(point: EntryPoint) -> Driver:
    distribution = point.dist.name if point.dist is not None else "irtiming"
    try:
        point.load()
    except Exception as error:
        return Driver(scheme=point.name, distribution=distribution, entry_point=None, load_error=_reason(error))
    return Driver(scheme=point.name, distribution=distribution, entry_point=point)


def _reason(error: Exception) -> str:
    """One line; for a package that is not installed, the cure."""
    text = " ".join(str(error).split()) or type(error).__name__
    if isinstance(error, ModuleNotFoundError) and not (error.name or "").startswith("irtiming"):
        return f"{text}; pip install 'irtiming[rig]'"
    return text
