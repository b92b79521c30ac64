"""certificate.toml from the fields of a page: a section for each, and whatever else the laboratory writes below them."""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import final

from irtiming.archive.toml_text import sections


@final
@dataclass(frozen=True, kw_only=True)
class Field:
    """A field of the page: section and key in certificate.toml, and what it is called; ``is_day`` is written without quotes."""

    section: str
    key: str
    label: str
    is_day: bool = False

    @property
    def name(self) -> str:
        """Of the field among all."""
        return f"{self.section}.{self.key}"


_ADDRESS = {
    "name": "Name", "street": "Street", "postcode": "Postcode", "city": "City", "country": "Country (two letters)",
    "email": "E-mail",
}  # fmt: skip
FIELDS = {
    "Certificate": (
        Field(section="certificate", key="number", label="Number"),
        Field(section="certificate", key="issued", label="Issued (day)", is_day=True),
        Field(section="certificate", key="language", label="Language (en or de)"),
        Field(section="certificate", key="order", label="The customer's order"),
        Field(section="person", key="name", label="Signed by"),
        Field(section="person", key="role", label="Role"),
    ),
    "Laboratory": tuple(Field(section="laboratory", key=key, label=label) for key, label in _ADDRESS.items()),
    "Customer": tuple(Field(section="customer", key=key, label=label) for key, label in _ADDRESS.items()),
}
"""Fields by the heading that they stand under."""

MORE = """\
[item]
description = "thermal infrared camera"

[place]
name = "laboratory"
temperature = "23 C"

# [[equipment]]
# name = "chopper wheel"
# certificate = "2026-0101"

# [[limit]]
# parameter = "trigger_delay"
# upper = "1 ms"
"""
"""What else may stand there, to begin with."""

_OWN = ("certificate", "laboratory", "customer", "person")
_OF_ONE = ("replaces", "amendment")
"""Keys of one certificate alone: they would be wrong on the next."""


def as_toml(values: Mapping[str, str], more: str) -> str:
    """The file.

    Parameters
    ----------
    values
        By name of the field; empty ones are left out.
    more
        Further sections, as they stand. What is in one that the page has fields of goes below these; persons with a name are
        further ones.
    """
    beside: dict[str, str] = {}
    others = []
    for one in sections(more):
        if one.name not in _OWN or one.name in beside or (one.name == "person" and one.has("name")):
            others.append(one.heading + one.body)
        else:
            beside[one.name] = one.body.strip()
    parts = []
    for section in _OWN:
        lines = [
            f"{one.key} = {_written(values[one.name], is_day=one.is_day)}"
            for one in _fields_of(section)
            if values.get(one.name, "").strip()
        ]
        lines += [beside[section]] if beside.get(section) else []
        parts.append("\n".join(["[[person]]" if section == "person" else f"[{section}]", *lines]))
    return "\n\n".join([*parts, "".join(others).strip()]) + "\n"


def rest_of(text: str) -> str:
    """What a file says that the page has no fields for, as it stands, but for what was said of one certificate alone."""
    kept, persons = [], 0
    for one in sections(text):
        persons += one.name == "person"
        if not one.name:
            continue
        if one.name not in _OWN or (one.name == "person" and persons > 1):
            kept.append((one.heading + one.body).rstrip())
            continue
        known = {field.key for field in _fields_of(one.name)}.union(_OF_ONE)
        told = [each for each in one.statements() if each.keys and not known.intersection(each.keys)]
        rest = "".join(each.text for each in told)
        if rest:
            kept.append((one.heading + rest).rstrip())
    return "\n\n".join(kept) + "\n"


def _fields_of(section: str) -> Iterator[Field]:
    return (one for group in FIELDS.values() for one in group if one.section == section)


def _written(text: str, *, is_day: bool) -> str:
    plain = text.strip()
    return plain if is_day and re.fullmatch(r"\d{4}-\d\d-\d\d", plain) else json.dumps(plain, ensure_ascii=False)
