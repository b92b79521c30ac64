"""One page of HTML that stands alone: verdict and warnings first, then tables and figures."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, final

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from irtiming.report.blocks import Section
from irtiming.report.language import day, language, several, t
from irtiming.report.sections.inputs import versions


@final
@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The answer: the numbers in large type, the sentence that says what they are, and what to know beside them.

    ``number`` is the first, ``outside`` what its uncertainty does not hold, ``doubted`` that it is in doubt, where it is;
    ``further`` are those that stand below it.
    """

    number: str
    sentence: str
    remarks: tuple[str, ...]
    further: tuple[str, ...] = ()
    outside: str = ""
    doubted: str = ""


@final
@dataclass(frozen=True, kw_only=True)
class Warned:
    """What a reader should know, in one sentence of the program; ``title`` says it first in another language than English.

    ``is_doubt``: a number may be wrong by more than its uncertainty says.
    """

    text: str
    title: str = ""
    is_doubt: bool = False


@final
@dataclass(frozen=True, kw_only=True)
class Certificate:
    """The report in both its forms: the page as HTML text, and the result as plain data for JSON."""

    page: str
    result: dict[str, Any]


@final
@dataclass(frozen=True, kw_only=True)
class Content:
    """Everything on a page: its heading, and below it verdict, warnings and sections in this order."""

    heading: str
    verdict: Verdict
    warnings: tuple[Warned, ...]
    sections: tuple[Section, ...]


def render(content: Content, *, created: datetime | None = None) -> str:
    """HTML text without any link to the outside.

    Parameters
    ----------
    content
        What to print.
    created
        Date to print; now, where none is given.
    """
    when = created or datetime.now(UTC)
    environment = Environment(
        loader=PackageLoader("irtiming.report", "."),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html").render(
        heading=content.heading,
        verdict=content.verdict,
        warnings=content.warnings,
        t=t,
        several=several,
        language=language(),
        sections=content.sections,
        created=f"{day(when.date(), language())} {when.strftime('%H:%M %Z')}".strip(),
        version=versions().get("irtiming", ""),
    )
