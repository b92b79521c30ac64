"""Text to exact numbers: "30.303" is 30303/1000 and nothing near it."""

import re
from fractions import Fraction
from math import isqrt

from irtiming.errors import PlanError, UnitError
from irtiming.records.trigger_plan import Wish

_DECIMAL = r"[-+]?(?:[0-9]{1,60}\.?[0-9]{0,60}|\.[0-9]{1,60})(?:[eE][-+]?[0-9]{1,2})?"
_NUMBER = re.compile(rf"\s*({_DECIMAL})(?:\s*/\s*([0-9]{{1,60}}))?\s*")
_TIME = re.compile(rf"\s*({_DECIMAL})\s*([a-zµ]*)\s*")
_SECONDS = {
    "": Fraction(1), "s": Fraction(1), "ms": Fraction(1, 10**3), "us": Fraction(1, 10**6),
    "µs": Fraction(1, 10**6), "ns": Fraction(1, 10**9), "min": Fraction(60), "h": Fraction(3600),
}  # fmt: skip


def exact_number(text: str, name: str) -> Fraction:
    """Positive fraction from text such as ``"30.303"``, ``"3"``, ``"4.9152e7"`` or ``"1000/33"``.

    Raises
    ------
    UnitError
        If the text is not a number; ``name`` says in the message what it should have been.
    PlanError
        If it is zero or negative.
    """
    match = _NUMBER.fullmatch(text)
    if match is None or (match[2] is not None and int(match[2]) == 0):
        raise UnitError(f"{name} is '{text}', which is not a number; write it such as 3, 30.303 or 1000/33")
    number = Fraction(match[1]) / int(match[2] or 1)
    if number <= 0:
        raise PlanError(f"{name} is {text.strip()}, but must be greater than 0")
    return number


def whole_number(text: str, name: str) -> int:
    """Positive integer from text such as ``"100"`` or ``"49.152e6"``.

    Raises
    ------
    UnitError
        If the text is not a number, or not a whole one.
    PlanError
        If it is zero or negative.
    """
    number = exact_number(text, name)
    if number.denominator != 1:
        raise UnitError(f"{name} is {text.strip()}, but must be a whole number; the nearest is {max(1, round(number))}")
    return number.numerator


def exact_seconds(text: str, name: str) -> Fraction:
    """Seconds, exact, from text such as ``"25 ms"``, ``"20 min"`` or ``"0"``.

    Raises
    ------
    UnitError
        If the text is not a number followed by s, ms, us, ns, min or h; only zero needs no unit.
    PlanError
        If it is negative.
    """
    match = _TIME.fullmatch(text)
    if match is None or match[2] not in _SECONDS:
        raise UnitError(f"{name} is '{text}', which is not a time; write it such as '25 ms', '250 us' or '20 min'")
    if not match[2] and Fraction(match[1]) != 0:
        raise UnitError(f"{name} is '{text}', which has no unit; write it such as '{match[1]} ms'")
    if Fraction(match[1]) < 0:
        raise PlanError(f"{name} is {text.strip()}, but must not be negative")
    return Fraction(match[1]) * _SECONDS[match[2]]


def ratio(text: str, name: str) -> Fraction:
    """Share from text such as ``"1%"`` or ``"0.01"``; from 0 up to, not including, 1.

    Raises
    ------
    UnitError
        If the text is not a number, with or without a percent sign.
    PlanError
        If it is negative, or 100 % or more.
    """
    digits = text.strip()
    percent = digits.endswith("%")
    match = _NUMBER.fullmatch(digits.removesuffix("%"))
    if match is None or match[2] is not None:
        raise UnitError(f"{name} is '{text}', which is not a share; write it such as 1% or 0.01")
    share = Fraction(match[1]) / (100 if percent else 1)
    if not 0 <= share < 1:
        raise PlanError(f"{name} is {text.strip()}, but must be at least 0 and below 100%; write it such as 1% or 0.01")
    return share


def wish_around(wanted: Fraction, tolerance: Fraction) -> Wish:
    """Wish whose limits lie a relative ``tolerance`` below and above what is wanted; 0 makes it exact."""
    return Wish(wanted=wanted, lowest=wanted * (1 - tolerance), highest=wanted * (1 + tolerance))


def as_text(number: Fraction) -> str:
    """Exact text that `exact_number` reads back: ``"30.303"`` if decimals end soon, else ``"1000/33"``."""
    if number * 10**9 % 1:
        return f"{number.numerator}/{number.denominator}"
    whole, part = divmod(abs(number.numerator) * 10**9 // number.denominator, 10**9)
    sign = "-" if number < 0 else ""
    return f"{sign}{whole}.{part:09d}".rstrip("0").rstrip(".")


def is_prime(number: int) -> bool:
    """Whether a positive integer has no divisor but 1 and itself; by trial division, for samples per turn."""
    return number > 1 and all(number % divisor for divisor in range(2, isqrt(number) + 1))
