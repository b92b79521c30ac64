"""Catalogues of translations: the PO files beside this one, read as they are, so that nothing is compiled or kept twice."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from gettext import GNUTranslations, NullTranslations
from importlib.resources import files
from io import BytesIO
from struct import pack
from typing import final

from irtiming.errors import ArchiveError
from irtiming.records.choices import Language

_CONTEXT, _PLURAL = "\x04", "\x00"  # in a MO file, between context and text, and between the forms of a number
_MAGIC, _HEAD = 0x950412DE, 28


@final
@dataclass(kw_only=True)
class Entry:
    """One text of a catalogue: its English, and its translation, or one for each form of a number."""

    fields: dict[str, str] = field(default_factory=dict)

    @property
    def english(self) -> str:
        """What the program says."""
        return self.fields.get("msgid", "")

    @property
    def context(self) -> str:
        """What kind of text it is, where its English alone does not tell; else empty."""
        return self.fields.get("msgctxt", "")

    @property
    def translations(self) -> tuple[str, ...]:
        """One, or one for each form of a number."""
        return tuple(text for name, text in self.fields.items() if name.startswith("msgstr"))


@cache
def catalogue(language: Language) -> NullTranslations:
    """The translations of a language; none for English, in which the program is written."""
    return NullTranslations() if language == "en" else GNUTranslations(BytesIO(compiled(entries(language))))


def entries(language: Language) -> Mapping[tuple[str, str], Entry]:
    """All texts of a language's PO file by context and English; the first, "", is the file's head."""
    source = files("irtiming.report").joinpath("catalogues", f"{language}.po")
    return {(one.context, one.english): one for one in parsed(source.read_text(encoding="utf-8"))}


def parsed(text: str) -> Iterator[Entry]:
    """Entries of a PO file; comments are left out.

    Raises
    ------
    ArchiveError
        If a line is none of a PO file.
    """
    entry, name = Entry(), ""
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.startswith("#"):
            continue
        word, _, quoted = ("", "", line) if line.startswith('"') else line.partition(" ")
        starts = word == "msgctxt" or (word == "msgid" and name != "msgctxt")
        if starts and entry.fields:
            yield entry
            entry = Entry()
        name = word or name
        try:
            entry.fields[name] = ("" if word else entry.fields[name]) + json.loads(quoted)
        except (ValueError, KeyError, TypeError) as error:
            raise ArchiveError(
                f"line {number} of the catalogue is '{line:.60}', must be a keyword and a text in quotes"
            ) from error
    if entry.fields:
        yield entry


def compiled(found: Mapping[tuple[str, str], Entry]) -> bytes:
    """The same as a MO file has it, for the standard library; a text without a translation is left out."""
    pairs = sorted(
        (_key(one).encode(), _PLURAL.join(one.translations).encode()) for one in found.values() if all(one.translations)
    )
    texts, table = b"", [b"", b""]
    at = _HEAD + 16 * len(pairs)
    for side in (0, 1):
        for pair in pairs:
            table[side] += pack("<2I", len(pair[side]), at + len(texts))
            texts += pair[side] + b"\0"
    head = pack("<7I", _MAGIC, 0, len(pairs), _HEAD, _HEAD + 8 * len(pairs), 0, 0)
    return head + table[0] + table[1] + texts


def _key(one: Entry) -> str:
    plural = one.fields.get("msgid_plural")
    return (
        (one.context + _CONTEXT if one.context else "") + one.english + (_PLURAL + plural if plural is not None else "")
    )
