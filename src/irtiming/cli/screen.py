"""Lines on the screen, and the names that fields of records have there."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from rich.console import Console
from rich.markup import escape

from irtiming.errors import IrTimingError
from irtiming.units import kelvin, seconds

_UNITS = ("_k", "_s")
_OTHER = {"wanted": "--for", "drift_dn_per_s": "--drift-dn-per-s"}

_Given = ParamSpec("_Given")
_Found = TypeVar("_Found")


def say(text: str, screen: Console | None = None) -> None:
    """One line exactly as it is, however long; on standard output where no screen is named."""
    (screen or Console()).print(text, markup=False, highlight=False, soft_wrap=True)


def warn(text: str, screen: Console) -> None:
    """A warning, broken into lines as the screen has room."""
    screen.print(f"[yellow]warning:[/yellow] {escape(text)}", highlight=False)


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


def time_s(text: str | None) -> float | None:
    """Seconds of an option, where it is given."""
    return None if text is None else seconds(text)


def temperature_k(text: str | None) -> float | None:
    """Kelvin of an option, where it is given."""
    return None if text is None else kelvin(text)


def _option(field: str) -> str:
    """The option for a field: without the unit of temperatures and times, which are text with a unit there."""
    name = next((field.removesuffix(unit) for unit in _UNITS if field.endswith(unit)), field)
    return _OTHER.get(field, f"--{name.replace('_', '-')}")
