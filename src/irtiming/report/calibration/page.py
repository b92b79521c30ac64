"""A certificate as one page of HTML that stands alone: for a screen, and for paper."""

import base64
from importlib.resources import files
from pathlib import Path
from typing import Any, final

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from irtiming.archive.certificate_file import RULES
from irtiming.errors import ArchiveError
from irtiming.records.choices import Language
from irtiming.report.calibration import conditions, rows
from irtiming.report.calibration.content import NAMED, MeasuredItem, Sheet
from irtiming.report.language import day, finding_title, translated
from irtiming.report.sections.inputs import versions

_KINDS = {".png": "image/png", ".svg": "image/svg+xml", ".jpg": "image/jpeg"}
_MOST_BYTES = 2**20


def html(sheet: Sheet, *, beside: Path, fonts: str = "") -> str:
    """HTML text without any link to the outside.

    Parameters
    ----------
    sheet
        What to print.
    beside
        Folder of certificate.toml, where the accreditation mark lies.
    fonts
        CSS of embedded fonts; none for a screen, which has its own.

    Raises
    ------
    ArchiveError
        If the accreditation mark cannot be used.
    """
    environment = Environment(
        loader=PackageLoader("irtiming.report.calibration", "."), autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    text = Text(sheet.language)
    style = files("irtiming.report.calibration").joinpath("certificate.css").read_text(encoding="utf-8")
    return environment.get_template("certificate.html").render(
        t=text.of, day=text.day, sheet=sheet, form=sheet.form, language=sheet.language, named=_named(),
        css=Markup(fonts + style.replace("PAGE", text.of("page"))), mark=_mark(sheet, beside),
        version=versions().get("irtiming", ""), results=[_result(sheet, one) for one in sheet.results], **_texts(sheet, text),
    )  # fmt: skip


@final
class Text:
    """Texts and days in one language."""

    def __init__(self, language: Language) -> None:
        self.language = language

    def of(self, text: str) -> str:
        """Translated."""
        return translated(text, self.language)

    def day(self, when: Any) -> str:
        """A day as it is written."""
        return day(when, self.language)


def _named() -> list[tuple[str, str]]:
    return [(name, name.replace("_", " ")) for name in NAMED]


def _texts(sheet: Sheet, text: Text) -> dict[str, Any]:
    """Everything that is said once."""
    form, first, last = sheet.form, sheet.first_day, sheet.last_day
    place = f"{text.of(conditions.PLACES[form.place.kind])}{f': {form.place.name}' if form.place.name else ''}"
    outside = dict.fromkeys(one for each in sheet.results for one in each.result.not_in_uncertainty)
    traced = text.of(conditions.NOT_TRACEABLE) if sheet.is_simulated else ""
    return {
        "issued": text.day(form.certificate.issued),
        "received": text.day(form.dates.received) if form.dates.received else "",
        "measured": text.day(first) if first == last else f"{text.day(first)} – {text.day(last)}",
        "place": place,
        "outside": "; ".join(text.of(one) for one in outside),
        "doubts": [
            {"title": title, "text": what}
            for title, what in dict.fromkeys(
                (finding_title(found.code, sheet.language), found.what)
                for each in sheet.results
                for found in each.result.findings
                if found.severity in ("warning", "doubt")
            )
        ],
        "conformity": rows.conformity(sheet),
        "rule": text.of(RULES[form.decision.rule]),
        "environment": conditions.environment(sheet),
        "method": text.of(conditions.method(sheet)),
        "traceability": traced
        or (form.traceability.statement if form.traceability else text.of(conditions.TRACEABILITY)),
    }


def _result(sheet: Sheet, one: MeasuredItem) -> dict[str, Any]:
    name = sheet.items[one.item].name
    return {
        "heading": f"{name} · {one.file.name}" if name else one.file.name,
        "headline": [rows.measurand(row, sheet.language) for row in one.headline],
        "rows": [rows.measurand(row, sheet.language) for row in one.measurands],
        "bounds": rows.bounds(one.result, sheet.language),
        "conditions": conditions.of(sheet, one),
        "correlation": rows.correlation(one, sheet.language),
        "findings": [
            {"severity": found.severity, "code": found.code, "text": _finding_text(found),
             "title": finding_title(found.code, sheet.language)}
            for found in one.result.findings
        ],
        "rig": rows.rig(one.result, sheet.language),
        "rig_sha256": one.result.rig.sha256,
        "files": rows.files(one),
        "software": ", ".join(f"{name} {version}" for name, version in one.result.software.items()),
    }  # fmt: skip


def _finding_text(found: Any) -> str:
    """The finding in one line."""
    place = f"{found.recording}: " if found.recording else ""
    return f"{place}{found.what}{f'; {found.cure}' if found.cure else ''}"


def _mark(sheet: Sheet, beside: Path) -> str:
    """The accreditation mark as text to embed; none on a specimen."""
    name = sheet.form.laboratory.accreditation_mark
    if name is None or sheet.is_simulated:
        return ""
    path = beside / name
    kind = _KINDS.get(path.suffix.lower())
    if kind is None:
        raise ArchiveError(f"{path}: the accreditation mark must be a PNG, JPEG or SVG; convert it")
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
    except OSError as error:
        raise ArchiveError(
            f"{path}: the accreditation mark cannot be read ({error.strerror}); correct its name"
        ) from error
    if len(content) > _MOST_BYTES:
        raise ArchiveError(f"{path}: the accreditation mark has more than {_MOST_BYTES} bytes; give a smaller picture")
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
