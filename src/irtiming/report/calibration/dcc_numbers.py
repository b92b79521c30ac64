"""Quantities of D-SI 2.1.0: value, unit, expanded uncertainty with its coverage factor."""

import re
from decimal import Decimal
from math import erf, isfinite, sqrt
from xml.etree import ElementTree as Xml

from irtiming.report.budget import COVERAGE_PERCENT

SI = "https://ptb.de/si"
UNITS = {
    "s": r"\second", "1": r"\one", "": r"\one", "K": r"\kelvin", "Hz": r"\hertz", "m": r"\metre", "rad": r"\radian",
    "s/s": r"\one", "s/1": r"\second", "s/m": r"\second\per\metre", "s/rad": r"\second\per\radian", "s/": r"\second",
    "s/px": r"\second",
}  # fmt: skip
"""Units of this program, and what D-SI calls them."""

_FORBIDDEN = re.compile("[^\\t\\n\\r\\x20-\\ud7ff\\ue000-\\ufffd\\U00010000-\\U0010ffff]")
_WITHIN_U = {"rectangular": 1 / sqrt(3)}
_ONE_SIGMA = erf(1 / sqrt(2))


def printable(text: str) -> str:
    """The text without what XML 1.0 does not allow (2.2)."""
    return _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", text)


def decimal(value: float) -> str:
    """A number as D-SI writes it: never an infinity, the exponent with a capital E."""
    text = f"{value:.12g}" if isfinite(value) else "0"
    return text.replace("e", "E")


def real(
    value: float, unit: str, *, u: float | None = None, k: float = 1.0, distribution: str = "normal", label: str = "",
) -> Xml.Element:  # fmt: skip
    """``si:real`` of a value; with ``si:expandedUnc`` of U = k u where a standard uncertainty ``u`` is given.

    Parameters
    ----------
    value, unit
        SI value, and its unit as this program writes it.
    u, k, distribution
        Standard uncertainty, coverage factor (1, or of the usual coverage probability), and distribution.
    label
        Name of the quantity for programs.
    """
    found = Xml.Element(f"{{{SI}}}real")

    def add(parent: Xml.Element, name: str, text: str) -> None:
        Xml.SubElement(parent, f"{{{SI}}}{name}").text = text

    if label:
        add(found, "label", printable(label))
    add(found, "value", decimal(value))
    add(found, "unit", UNITS.get(unit, r"\one"))
    if u is not None:
        wide = Xml.SubElement(found, f"{{{SI}}}expandedUnc")
        add(wide, "uncertainty", decimal(k * u))
        add(wide, "coverageFactor", _factor(k))
        within_u = _WITHIN_U.get(distribution, _ONE_SIGMA)
        add(wide, "coverageProbability", f"{within_u if k == 1 else COVERAGE_PERCENT / 100:.6g}")
        add(wide, "distribution", distribution)
    return found


def _factor(k: float) -> str:
    """Without exponent, at least 1."""
    return f"{max(1.0, k):f}".rstrip("0").rstrip(".") if k < 1e6 else format(Decimal(k), "f")
