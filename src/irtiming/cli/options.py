"""From options to records and back: an option is a field of a record, without the unit of a time or a temperature."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from irtiming.errors import IrTimingError
from irtiming.units import kelvin, seconds

_UNITS = {"_s": seconds, "_k": kelvin}
_OTHER = {"wanted": "--for"}

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
