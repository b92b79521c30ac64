"""From options to records and back: an option is a field of a record, without the unit of a time or a temperature.

Options that several commands have stand here too.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, ParamSpec, TypeVar

import typer

from irtiming.errors import IrTimingError, UnitError
from irtiming.records.choices import ReferenceEdge
from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.units import kelvin, seconds

RigFile = Annotated[Path, typer.Option(help="What was measured on the rig (rig.toml).")]
Edge = Annotated[
    ReferenceEdge,
    typer.Option(help="Which application edge is the angle zero; automatic: before the longer half turn."),
]
Duration = Annotated[
    str | None, typer.Option(metavar="TIME", help="End after this, such as '10 min'; else Ctrl-C ends it.")
]
FrameRate = Annotated[
    float | None,
    typer.Option(min=1e-2, max=1e5, help="Frame rate at which you use the camera, Hz; for a result of several."),
]
ArrayCamera = Annotated[CameraType | None, typer.Option(help="Kind of camera; for frames alone.")]
ArrayReadout = Annotated[
    ReadoutMode | None,
    typer.Option(help="How it is read, if not as usual (photon cameras at once, others row by row); for frames alone."),
]
ArrayIntegration = Annotated[
    str | None,
    typer.Option(metavar="TIME", help="Of a photon camera, such as '250 us'; for frames alone."),
]
ArrayBits = Annotated[
    int | None,
    typer.Option(min=1, max=16, help="Bits of a pixel value, if the file does not tell; for frames alone."),
]

_UNITS = {"_s": seconds, "_k": kelvin}
_OTHER = {"wanted": "--for"} | {
    f"{name}_share": f"--{name}" for name in ("glare", "blade", "sway", "filter", "memory", "tail")
}
"""Options whose names are not those of their fields."""


_Given = ParamSpec("_Given")
_Found = TypeVar("_Found")
_Record = TypeVar("_Record")


def filled(record: type[_Record], given: Mapping[str, Any], **more: Any) -> _Record:
    """A record of the options that were given; text of a time or temperature is read, a list becomes a tuple.

    Parameters
    ----------
    record
        A dataclass; a field that no option gives has its default.
    given
        Options by name, None where not given; those that are no field of the record are left alone.
    more
        Fields that are no option, or another one.

    Raises
    ------
    IrTimingError
        If a text cannot be read, or the record refuses what was given.
    """
    options = {field.name: given.get(_bare(field.name)) for field in fields(record)}  # type: ignore[arg-type]
    return record(**{name: _read(name, value) for name, value in options.items() if value is not None} | more)


def _read(field: str, value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_read(field, one) for one in value)
    if isinstance(value, float) and not math.isfinite(value):
        raise UnitError(f"{_option(field)} is {value}, must be a finite number")
    unit = field.removeprefix(_bare(field))
    return _UNITS[unit](value) if unit and isinstance(value, str) else value


def _bare(field: str) -> str:
    unit = field[-2:]
    return field.removesuffix(unit) if unit in _UNITS and not field.endswith("_per_s") else field


def in_options(command: Callable[_Given, _Found]) -> Callable[_Given, _Found]:
    """The same command, whose complaints about a record name the options that its fields were given by."""

    @wraps(command)
    def run(*args: _Given.args, **options: _Given.kwargs) -> _Found:
        try:
            return command(*args, **options)
        except IrTimingError as error:
            error.call_fields(_option)
            raise

    return run


def _option(field: str) -> str:
    return _OTHER.get(field, f"--{_bare(field).replace('_', '-')}")
