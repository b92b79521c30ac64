"""A Digital Calibration Certificate read back: what it certifies, and whether it agrees with itself."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite, sqrt
from pathlib import Path
from typing import final
from xml.etree import ElementTree as Xml

from irtiming.errors import ArchiveError

_DCC, _SI, _DS = "{https://ptb.de/dcc}", "{https://ptb.de/si}", "{http://www.w3.org/2000/09/xmldsig#}"
_CURE = "give a certificate that irtiming certificate --out cert.xml wrote"
_MOST_BYTES = 2**27
_CLOSE = 1e-6
_NEEDED = (
    "administrativeData/coreData/uniqueIdentifier", "administrativeData/coreData/beginPerformanceDate",
    "administrativeData/items/item", "administrativeData/calibrationLaboratory/contact/name/content",
    "administrativeData/customer/name/content", "administrativeData/respPersons/respPerson",
    "measurementResults/measurementResult/results/result",
)  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class CertifiedQuantity:
    """One result: value and expanded uncertainty in a D-SI unit, ``name`` as people read it, ``label`` as programs do."""

    name: str
    label: str
    value: float
    expanded: float
    coverage_factor: float
    unit: str
    conformity: str


@final
@dataclass(frozen=True, kw_only=True)
class CheckedCertificate:
    """What a certificate says.

    ``problems`` is where it is not as it must be, one line each; ``is_signed`` says that it holds a signature.
    """

    number: str
    laboratory: str
    customer: str
    items: tuple[str, ...]
    quantities: tuple[CertifiedQuantity, ...]
    is_simulated: bool
    is_signed: bool
    problems: tuple[str, ...]


def check_certificate(path: str | Path) -> CheckedCertificate:
    """Read a certificate back. A signature is found, not verified.

    Raises
    ------
    ArchiveError
        If the file cannot be read, or is no Digital Calibration Certificate.
    """
    root = _root(Path(path))
    results = list(_path(root, "measurementResults/measurementResult/results/result"))
    quantities = tuple(found for one in results for found in _quantities(one))
    problems = [f"{place} is missing" for place in _NEEDED if next(_path(root, place), None) is None]
    problems += [text for one in results for text in _disagreements(one)]
    if root.get("schemaVersion") != "3.1.2":
        problems.append(f"schemaVersion is {root.get('schemaVersion')!r}, must be '3.1.2'")
    return CheckedCertificate(
        number=_text(root, "administrativeData/coreData/uniqueIdentifier"),
        laboratory=_text(root, "administrativeData/calibrationLaboratory/contact/name/content"),
        customer=_text(root, "administrativeData/customer/name/content"),
        items=tuple(_item(one) for one in _path(root, "administrativeData/items/item")),
        quantities=quantities,
        is_simulated=any(
            one.get("id") == "simulated" for one in _path(root, "administrativeData/statements/statement")
        ),
        is_signed=root.find(f".//{_DS}Signature") is not None,
        problems=tuple(problems),
    )


def _root(path: Path) -> Xml.Element:
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be read ({error.strerror}); {_CURE}") from error
    if content[:5] == b"%PDF-" or b"<html" in content[:2000].lower():
        raise ArchiveError(f"{path}: is the certificate for people; the XML can be checked: {_CURE}")
    if len(content) > _MOST_BYTES or b"<!DOCTYPE" in content[:4096] or b"<!ENTITY" in content:
        raise ArchiveError(f"{path}: is too large, or declares a document type, which no certificate does; {_CURE}")
    try:
        root = Xml.fromstring(content)
    except (Xml.ParseError, ValueError, LookupError) as error:
        raise ArchiveError(f"{path}: is not XML ({error}); {_CURE}") from error
    if root.tag != f"{_DCC}digitalCalibrationCertificate":
        raise ArchiveError(f"{path}: is no Digital Calibration Certificate but <{root.tag[:60]}>; {_CURE}")
    return root


def _path(parent: Xml.Element, path: str) -> Iterator[Xml.Element]:
    return parent.iterfind("/".join(f"{_DCC}{name}" for name in path.split("/")))


def _text(parent: Xml.Element, path: str) -> str:
    return " ".join((one.text or "").strip() for one in _path(parent, path))


def _item(item: Xml.Element) -> str:
    words = (
        _text(item, "manufacturer/name/content"),
        _text(item, "model"),
        _text(item, "identifications/identification/value"),
    )
    return " ".join(word for word in words if word)


def _quantities(result: Xml.Element) -> Iterator[CertifiedQuantity]:
    """The measurand of each result; correlations carry no uncertainty and are left out."""
    for quantity in _path(result, "data/quantity"):
        real = quantity.find(f"{_SI}real")
        if real is None or real.find(f"{_SI}expandedUnc") is None:
            continue
        yield CertifiedQuantity(
            name=_text(quantity, "name/content"),
            label=_si(real, "label"),
            value=_number(real, "value"),
            expanded=_number(real, "expandedUnc/uncertainty"),
            coverage_factor=_number(real, "expandedUnc/coverageFactor"),
            unit=_si(real, "unit"),
            conformity=_text(quantity, "measurementMetaData/metaData/conformity"),
        )


def _si(real: Xml.Element, path: str) -> str:
    found = real.find("/".join(f"{_SI}{name}" for name in path.split("/")))
    return "" if found is None else (found.text or "").strip()


def _number(real: Xml.Element, path: str) -> float:
    try:
        return float(_si(real, path))
    except ValueError:
        return inf


def _disagreements(result: Xml.Element) -> Iterator[str]:
    """Numbers that are none, and a budget whose contributions do not add up to the uncertainty (GUM, 5.1.2)."""
    parts = []
    for line in _path(result, "data/list/list"):
        for quantity in _path(line, "quantity"):
            real = quantity.find(f"{_SI}real")
            if real is not None and quantity.get("refType") == "irtiming_contribution":
                parts.append(_number(real, "value"))
    for one in _quantities(result):
        if not all(map(isfinite, (one.value, one.expanded, one.coverage_factor))) or one.coverage_factor < 1:
            yield f"{one.name}: value, uncertainty or coverage factor is no number"
            continue
        total, u = sqrt(sum(part**2 for part in parts)), one.expanded / one.coverage_factor
        if parts and abs(total - u) > _CLOSE * max(total, u):
            yield f"{one.name}: the budget adds up to {total:.6g}, but U / k is {u:.6g}"
