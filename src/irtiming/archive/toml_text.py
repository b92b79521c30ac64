"""A TOML file as text that a person wrote: its sections and their statements, each as it stands."""

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True, kw_only=True)
class Statement:
    """Its keys, none of a comment or an empty line, and its lines."""

    keys: tuple[str, ...]
    text: str


@final
@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of a file: its name, empty before the first one, the line of its heading, and the lines below it."""

    name: str
    heading: str
    body: str

    def statements(self) -> Iterator[Statement]:
        """Each of them, the last left out if it does not end."""
        held = ""
        for line in self.body.splitlines(keepends=True):
            held += line
            try:
                found = tomllib.loads(held)
            except (ValueError, RecursionError):  # goes on in the next line
                continue
            yield Statement(keys=tuple(found), text=held)
            held = ""

    def has(self, key: str) -> bool:
        """Whether a statement gives the key."""
        return any(key in one.keys for one in self.statements())


def sections(text: str) -> Iterator[Section]:
    """All of them in order; text before the first heading is one too."""
    for one in re.split(r"(?m)^(?=\[)", text):
        name = re.match(r"\[+\s*([\w-]+)", one)
        heading, line_end, body = one.partition("\n") if name else ("", "", one)
        yield Section(name=name[1] if name else "", heading=heading + line_end, body=body)
