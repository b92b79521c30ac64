"""certificate.toml from the fields of a page: a section for each, and whatever else the laboratory writes below them."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import final


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


def as_toml(values: Mapping[str, str], more: str) -> str:
    """The file.

    Parameters
    ----------
    values
        By name of the field; empty ones are left out.
    more
        Further sections, as they stand.
    """
    parts = []
    for section in _OWN:
        lines = [
            f"{one.key} = {_written(values[one.name], is_day=one.is_day)}"
            for group in FIELDS.values()
            for one in group
            if one.section == section and values.get(one.name, "").strip()
        ]
        parts.append("\n".join(["[[person]]" if section == "person" else f"[{section}]", *lines]))
    return "\n\n".join([*parts, more.strip()]) + "\n"


def rest_of(text: str) -> str:
    """Sections of a file that the page has no fields for, as they stand; of several persons, those after the first."""
    sections = re.split(r"(?m)^(?=\[)", text)
    kept, persons = [], 0
    for one in sections:
        name = re.match(r"\[+\s*([\w-]+)", one)
        if name is None:
            continue
        persons += name[1] == "person"
        if name[1] not in _OWN or (name[1] == "person" and persons > 1):
            kept.append(one.rstrip())
    return "\n\n".join(kept) + "\n"


def _written(text: str, *, is_day: bool) -> str:
    plain = text.strip()
    return plain if is_day and re.fullmatch(r"\d{4}-\d\d-\d\d", plain) else json.dumps(plain, ensure_ascii=False)
