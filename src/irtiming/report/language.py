"""The language that reports and certificates are written in: texts by catalogue, numbers with its decimal mark.

Everything is written in English unless it is written within `writing_in`.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import date
from string import Formatter
from typing import Any, final, get_args

from irtiming.errors import UnitError
from irtiming.records.choices import Language
from irtiming.records.words import require_word
from irtiming.report.catalogue import catalogue

_NUMBER, _WORD = re.compile(r"[0-9]+(?:\.[0-9]+)?"), re.compile(r"[a-z]{2,}")
_HYPHEN = re.compile(
    r"(?<![\w.,-])-(?=\d)"
)  # that stands for a minus sign: before a number, and not within a word or a day
_NARROW = "\N{NARROW NO-BREAK SPACE}"
_language: ContextVar[Language] = ContextVar("language", default="en")


@contextmanager
def writing_in(language: Language) -> Iterator[None]:
    """Within, texts and numbers are in this language; only for who entered it, not for other threads or tasks.

    Raises
    ------
    UnitError
        If there is no such language.
    """
    require_word("language", language, known=get_args(Language), error=UnitError)
    token = _language.set(language)
    try:
        yield
    finally:
        _language.reset(token)


def language() -> Language:
    """In which is written here."""
    return _language.get()


def t(text: str, **values: object) -> str:
    """A text in the language, with values in the places that it names in braces.

    Parameters
    ----------
    text
        In English, as the catalogue has it; stays as it is where the catalogue does not have it.
    values
        Text, or numbers that the place says how to write: ``t("{n} of {share:.1f} %", n=3, share=2.5)``.
    """
    found = translated(text, language())
    return _Places().vformat(found, (), values) if values else found


def with_numbers(text: str) -> str:
    """A text that was made elsewhere with its numbers in it, which the catalogue leaves open: ``"cutout edge {}"``."""
    found = [decimal(number) for number in _NUMBER.findall(text)]
    known = _NUMBER.sub("{}", text)
    return (t(known) if _WORD.search(known) else known).format(*found)


def heads(*texts: str) -> tuple[str, ...]:
    """Several texts in the language: the head of a table."""
    return tuple(t(text) for text in texts)


def several(number: int, thing: str) -> str:
    """Number and noun, the noun in the plural where it belongs: ``"1 recording"``, ``"2 recordings"``."""
    form = catalogue(language()).ngettext(f"{{n}} {thing}", f"{{n}} {thing}s", number)
    return form.format(n=number)


def translated(text: str, to: Language) -> str:
    """A text in a language; in English where the catalogue does not have it."""
    return catalogue(to).gettext(text) if text else ""


def finding_title(code: str, to: Language) -> str:
    """What a finding says in one sentence without its numbers; empty in English, which says it with them."""
    found = catalogue(to).pgettext("finding", code)
    return "" if found == code else found


def day(when: date, to: Language) -> str:
    """A day as it is written: ISO 8601, in German with dots."""
    return when.strftime("%d.%m.%Y") if to == "de" else when.isoformat()


def localised(text: str, to: Language) -> str:
    """A number as text with the decimal mark of a language, a true minus sign, and in German a space before %."""
    text = _HYPHEN.sub("\N{MINUS SIGN}", text)
    return re.sub(r"(?<=\d)%", f"{_NARROW}%", text.replace(".", ",")) if to == "de" else text


def decimal(text: str) -> str:
    """A number as text with the decimal mark of the language in which is written here."""
    return localised(text, language())


def with_unit(number: str, unit: str) -> str:
    """Number and unit, in German with a narrow space that does not break between them (DIN 1301-1)."""
    return f"{number}{_NARROW if language() == 'de' else ' '}{unit}"


def with_capital(text: str) -> str:
    """A text that begins a sentence."""
    return text[:1].upper() + text[1:]


@final
class _Places(Formatter):
    """Fills the places of a text; a number gets the decimal mark of the language."""

    def format_field(self, value: Any, format_spec: str) -> Any:
        """One value as its place says."""
        written = super().format_field(value, format_spec)
        return decimal(written) if isinstance(value, int | float) else written
