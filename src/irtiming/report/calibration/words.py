"""The words of a certificate in other languages than English: a small catalogue, English text to its translation."""

import json
from datetime import date
from functools import cache
from importlib.resources import files

from irtiming.archive.certificate_file import Language


@cache
def catalogue(language: Language) -> dict[str, str]:
    """Every text that has a translation; English has none."""
    if language == "en":
        return {}
    text = files("irtiming.report.calibration").joinpath(f"words-{language}.json").read_text(encoding="utf-8")
    return dict(json.loads(text))


def translated(text: str, language: Language) -> str:
    """The text in the language; in English where the catalogue does not have it."""
    return catalogue(language).get(text, text)


@cache
def finding_titles(language: Language) -> dict[str, str]:
    """What a finding says in one sentence without its numbers, by its code; none for English, which says it with them."""
    if language == "en":
        return {}
    text = files("irtiming.report.calibration").joinpath(f"findings-{language}.json").read_text(encoding="utf-8")
    return dict(json.loads(text))


def day(when: date, language: Language) -> str:
    """A day as it is written: ISO 8601, in German with dots."""
    return when.strftime("%d.%m.%Y") if language == "de" else when.isoformat()
