"""Ticks, seconds and text: the one place where numbers get or lose their unit."""

import math
import re
from collections.abc import Sequence

from irtiming.errors import UnitError

_FACTORS = {
    "": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9,
    "min": 60.0, "h": 3600.0,
}  # fmt: skip
ZERO_CELSIUS_K = 273.15
_COLDEST_K, _HOTTEST_K = 150.0, 1000.0
_TEMPERATURE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(K|C|°C|degC)\s*")
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zµ]*)\s*")


def seconds(text: str) -> float:
    """Seconds from text such as ``"250 us"``, ``"25ms"``, ``"0"`` or ``"20 min"``.

    Raises
    ------
    UnitError
        If the text is not a number followed by s, ms, us, ns, min or h; only zero needs no unit.
    """
    match = _QUANTITY.fullmatch(text)
    if match is None or match[2] not in _FACTORS:
        raise UnitError(f"'{text}' is not a time; write a number and s, ms, us, ns, min or h, such as '250 us'")
    if not match[2] and float(match[1]) != 0:
        raise UnitError(f"'{text}' has no unit; write s, ms, us, ns, min or h behind it, such as '{match[1]} ms'")
    found = float(match[1]) * _FACTORS[match[2]]
    if not math.isfinite(found):
        raise UnitError(f"'{text}' is longer than any time that a number can hold; check it")
    return found


def require_uncertainty(u: float, *, of: float | None, fields: tuple[str, str]) -> None:
    """Refuse a standard uncertainty that cannot be one.

    Parameters
    ----------
    u
        The standard uncertainty.
    of
        The number that it belongs to, in the same unit; None where not given.
    fields
        What both are called: the number, its uncertainty.

    Raises
    ------
    UnitError
        If it is negative or no number, or belongs to a number that was not given.
    """
    of_name, name = fields
    if not u >= 0:
        raise UnitError(f"{{{name}}} is {u:g}, must be 0 or more: it is a standard uncertainty", name)
    if u > 0 and of is None:
        raise UnitError(
            f"{{{name}}} is the standard uncertainty of {{{of_name}}}, which is not given; give both, or none", *fields
        )


def kelvin(text: str) -> float:
    """Kelvin from text such as ``"303 K"`` or ``"30 °C"`` (or C, degC).

    Raises
    ------
    UnitError
        If the text is no number followed by K or C, or no temperature from 150 K to 1000 K.
    """
    match = _TEMPERATURE.fullmatch(text)
    if match is None:
        raise UnitError(f"'{text}' is not a temperature; write a number and K or C, such as '303 K' or '30 C'")
    value = float(match[1]) + (0.0 if match[2] == "K" else ZERO_CELSIUS_K)
    if not _COLDEST_K <= value <= _HOTTEST_K:
        raise UnitError(
            f"'{text}' is {value:g} K, must lie between {_COLDEST_K:g} K and {_HOTTEST_K:g} K; check the unit"
        )
    return value


def ticks_to_seconds(ticks: int, clock_frequency_hz: float) -> float:
    """Duration of a whole number of clock ticks, in seconds."""
    return ticks / clock_frequency_hz


def plain_integer(text: str) -> int | None:
    """Number that is written in nine digits or fewer; None of anything else, such as a raised two, which is a digit to Python."""
    return int(text) if re.fullmatch("[0-9]{1,9}", text) else None


def counted(n: int, noun: str) -> str:
    """So many of something: ``"1 recording"``, ``"2 recordings"``."""
    return f"{n} {noun}{'' if n == 1 else 's'}"


def first_of(texts: Sequence[str], *, most: int) -> str:
    """The first of them, and whether there are more: ``"1, 2, 3 and so on"``."""
    return ", ".join(texts[:most]) + (" and so on" if len(texts) > most else "")


def readable_time(time_s: float) -> str:
    """Seconds as people read them: ``"250 us"``, ``"33 s"``, ``"11 min"``."""
    size = abs(time_s)
    if size == 0:
        return "0 s"
    if size >= 300:
        return f"{time_s / 60:.4g} min"
    for limit, factor, unit in ((1, 1, "s"), (1e-3, 1e3, "ms"), (1e-6, 1e6, "µs")):
        if size >= limit:
            return f"{time_s * factor:.6g} {unit}"
    return f"{time_s * 1e9:.4g} ns"
