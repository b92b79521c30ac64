"""Numbers on a certificate: value and expanded uncertainty to the same place, a decimal comma where the language has one."""

from math import isfinite

from irtiming.records.choices import Language
from irtiming.report.language import localised
from irtiming.report.rounding import fixed, places, significant, time_unit

_UNITS = {"1": "1", "": "", "K": "K", "rad": "rad", "m": "m", "px": "px", "Hz": "Hz"}
_LEAST_NAMED_S = 1e-11
_NARROW = "\N{NARROW NO-BREAK SPACE}"


def with_unit(number: str, unit: str) -> str:
    """A narrow space that does not break between them (ISO 80000-1)."""
    return f"{number}{_NARROW}{unit}" if unit not in ("", "1") else number


def stated(value: float, expanded: float, *, language: Language) -> tuple[str, str]:
    """Value and expanded uncertainty of a time, s, as text with unit, both to the second digit of the latter.

    The uncertainty is rounded as numbers are (GUM 7.2.6); both stand in the unit that suits the value.
    """
    factor, unit = time_unit(max(abs(value), expanded))
    if not (isfinite(expanded) and expanded > 0):
        return with_unit(localised(f"{value / factor:.6g}", language), unit), "–"
    decimals = places(expanded / factor)
    both = (fixed(one / factor, decimals) for one in (value, expanded))
    first, second = (with_unit(localised(text, language), unit) for text in both)
    return first, second


def plain(size: float, unit: str, *, language: Language) -> str:
    """A size that was chosen, with no more digits than it needs: ``"25 ms"``, ``"30.303 Hz"``."""
    factor, unit = time_unit(size) if unit == "s" else (1.0, unit)
    return with_unit(localised(f"{size / factor:.6g}", language), unit)


def small(size: float, unit: str, *, language: Language, digits: int = 3) -> str:
    """A size with so many digits and its unit; a time in the unit that suits it, others with a power of ten if need be."""
    if not isfinite(size):
        return "–"
    if unit == "s" and abs(size) >= _LEAST_NAMED_S:
        factor, unit = time_unit(size)
        return with_unit(localised(significant(size / factor, digits=digits), language), unit)
    if size and not 1e-3 <= abs(size) < 1e5:
        mantissa, exponent = f"{size:.{digits - 1}e}".split("e")
        power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{mantissa.replace('-', '−')} · 10{power}"
    else:
        text = significant(size, digits=digits)
    return with_unit(localised(text, language), _UNITS.get(unit, unit))
