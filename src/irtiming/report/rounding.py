"""Numbers as people read them: two digits of the uncertainty, the value to the same place, one unit for both."""

from math import isfinite

from irtiming.report.language import decimal, with_unit

_UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))
_MINUS = "\N{MINUS SIGN}"


def time_unit(size_s: float) -> tuple[float, str]:
    """Factor to seconds and name of the unit in which a time of this size has one to three digits before the point."""
    for factor, name in _UNITS:
        if abs(size_s) >= factor:
            return factor, name
    return _UNITS[2] if size_s == 0 else _UNITS[-1]


def places(uncertainty: float, *, digits: int = 2) -> int:
    """Decimal places that show so many digits of an uncertainty; negative where it is rounded to tens.

    The uncertainty is rounded first: 9.96 has the two digits 10, and none after the point.
    """
    return digits - 1 - int(f"{uncertainty:.{digits - 1}e}".split("e")[1])


def fixed(value: float, decimals: int) -> str:
    """Value with so many decimals, or rounded to tens and hundreds where negative; with a true minus sign."""
    text = f"{round(value, decimals):.{max(decimals, 0)}f}"
    if not text.strip("-0."):
        text = text.lstrip("-")
    return decimal(text)


def significant(value: float, *, digits: int = 2) -> str:
    """Value with so many significant digits and no exponent."""
    return "0" if value == 0 else fixed(value, places(abs(value), digits=digits))


def time_text(value_s: float, u_s: float | None = None) -> str:
    """A time with its standard uncertainty and unit: ``"373 ± 31 µs"``.

    Parameters
    ----------
    value_s, u_s
        s; without an uncertainty (None, 0 or not finite) the value is given with six digits.
    """
    if u_s is None or not isfinite(u_s) or u_s <= 0:
        factor, unit = time_unit(value_s)
        return with_unit(decimal(f"{value_s / factor:.6g}"), unit)
    factor, unit = time_unit(max(abs(value_s), u_s))
    decimals = places(u_s / factor)
    return with_unit(f"{fixed(value_s / factor, decimals)} ± {fixed(u_s / factor, decimals)}", unit)


def value_text(value: float, u: float | None = None, *, unit: str = "s") -> str:
    """A number with its standard uncertainty: a time as `time_text` gives it, an angle in µrad, a share in per cent."""
    if unit == "s":
        return time_text(value, u)
    factor, name = (1e-6, "µrad") if unit == "rad" else (1e-2, "%")
    if u is None or not isfinite(u) or u <= 0:
        return with_unit(decimal(f"{value / factor:.6g}"), name)
    decimals = places(u / factor)
    return with_unit(f"{fixed(value / factor, decimals)} ± {fixed(u / factor, decimals)}", name)


def uncertainty_text(u_s: float) -> str:
    """An uncertainty alone, two digits and unit, in µs down to 10 ns: ``"31 µs"``, ``"0.47 µs"``; a dash for none."""
    if not isfinite(u_s) or u_s <= 0:
        return "–"
    factor, unit = (1e-6, "µs") if 1e-8 <= u_s < 1e-6 else time_unit(u_s)
    return with_unit(significant(u_s / factor), unit)


def in_unit(value_s: float, u_s: float, *, unit_s: float) -> str:
    """Value in a given unit, without its name, to the place of the second digit of its uncertainty."""
    if not isfinite(u_s) or u_s <= 0:
        return decimal(f"{value_s / unit_s:.6g}")
    return fixed(value_s / unit_s, places(u_s / unit_s))


def signed(value_s: float, u_s: float, *, unit_s: float) -> str:
    """As :func:`in_unit`, with a sign in front of both positive and negative values."""
    text = in_unit(value_s, u_s, unit_s=unit_s)
    return text if text.startswith(_MINUS) or not text.strip("0.,") else f"+{text}"
