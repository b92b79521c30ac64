"""Languages: the catalogue is whole and sound, and a language holds only where it was asked for."""

import ast
import json
import re
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, date, datetime
from gettext import GNUTranslations
from html import escape
from io import BytesIO
from pathlib import Path
from string import Formatter

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

import irtiming.report as package
from irtiming.errors import ArchiveError, UnitError
from irtiming.records.analysis import Analysis
from irtiming.records.choices import Language
from irtiming.records.frame_events import FrameEvent
from irtiming.report import catalogue, certificate, event_words, language, sheet
from irtiming.report.language import day, decimal, finding_title, localised, several, t, translated, writing_in
from irtiming.report.meanings import SIGN
from results_by_hand import english_words_in

REPORT = Path(package.__file__).parent
CATALOGUES = REPORT / "catalogues"
GERMAN = {english for _, english in catalogue.entries("de")}


def _places(text: str) -> list[tuple[str, str]]:
    """Names of the places in braces; how a number is written may differ."""
    return sorted({name for _, name, _, _ in Formatter().parse(text) if name is not None})


def test_the_catalogue_is_sound() -> None:
    """Oracle: the file; no text twice, none empty, and the same places in both languages."""
    found = list(catalogue.parsed((CATALOGUES / "de.po").read_text(encoding="utf-8")))
    keys = [(one.context, one.english) for one in found]
    assert [key for key in set(keys) if keys.count(key) > 1] == []
    for one in found[1:]:
        assert one.english.strip()
        assert all(text.strip() for text in one.translations), one.english
        assert {tuple(_places(text)) for text in one.translations} == {tuple(_places(one.english))}, one.english


def test_a_catalogue_reads_as_the_tools_of_gettext_compile_it(tmp_path: Path) -> None:
    """Oracle: msgfmt, where it is installed."""
    try:
        subprocess.run(["msgfmt", "-o", tmp_path / "de.mo", CATALOGUES / "de.po"], check=True, capture_output=True)
    except FileNotFoundError:
        pytest.skip("msgfmt is not installed")
    theirs = GNUTranslations(BytesIO((tmp_path / "de.mo").read_bytes()))
    ours = catalogue.catalogue("de")
    for one in catalogue.entries("de").values():
        if one.english and not one.context:
            assert ours.gettext(one.english) == theirs.gettext(one.english)


def test_plural_context_and_long_texts_are_read() -> None:
    """Oracle: entries by hand, as gettext writes them."""
    text = (
        '# said of files\nmsgid "{n} file"\nmsgid_plural "{n} files"\nmsgstr[0] "{n} Datei"\nmsgstr[1] "{n} Dateien"\n\n'
        'msgctxt "finding"\nmsgid ""\n"a-"\n"code"\nmsgstr "Befund \\"x\\""\n\nmsgid "untold"\nmsgstr ""\n'
    )
    head = (
        'msgid ""\nmsgstr "Content-Type: text/plain; charset=UTF-8\\nPlural-Forms: nplurals=2; plural=(n != 1);\\n"\n'
    )
    found = {(one.context, one.english): one for one in catalogue.parsed(head + text)}
    made = GNUTranslations(BytesIO(catalogue.compiled(found)))
    assert [made.ngettext("{n} file", "{n} files", n) for n in (1, 2)] == ["{n} Datei", "{n} Dateien"]
    assert made.pgettext("finding", "a-code") == 'Befund "x"'
    assert made.gettext("untold") == "untold"


@pytest.mark.parametrize("line", ["msgid no quotes", '"before any keyword"', "msgid 7"])
def test_what_is_no_catalogue_is_refused_with_its_line(line: str) -> None:
    """Oracle: one line by hand that the format does not have."""
    with pytest.raises(ArchiveError, match="line 1 of the catalogue is"):
        list(catalogue.parsed(line))


def test_a_language_holds_only_where_it_was_asked_for() -> None:
    """Oracle: words by hand; another thread, and what comes after, stay English."""
    with writing_in("de"), ThreadPoolExecutor(1) as other:
        assert (t("page"), decimal("1.5"), several(2, "recording")) == ("Seite", "1,5", "2 Aufzeichnungen")
        assert other.submit(t, "page").result() == "page"
        with writing_in("en"):
            assert (t("page"), decimal("1.5"), several(1, "recording")) == ("page", "1.5", "1 recording")
    assert t("page") == "page"
    with pytest.raises(ZeroDivisionError), writing_in("de"):
        raise ZeroDivisionError
    assert t("page") == "page"


def test_a_language_that_nobody_translated_is_refused() -> None:
    """Oracle: the languages there are."""
    with pytest.raises(UnitError, match="language is 'fr', must be en or de"), writing_in("fr"):  # type: ignore[arg-type]
        pass


def test_numbers_in_a_text_have_the_decimal_mark_of_the_language() -> None:
    """Oracle: by hand; text that stands in a place is not touched."""
    with writing_in("de"):
        assert t("{part:.1f} of {file}", part=2.5, file="a.nxs") == "2,5 of a.nxs"
    assert t("{part:.1f} of {file}", part=2.5, file="a.nxs") == "2.5 of a.nxs"


@pytest.mark.parametrize(
    ("text", "english", "german"),
    [
        ("-47.2", "\N{MINUS SIGN}47.2", "\N{MINUS SIGN}47,2"),
        ("-0.89 (-1.5)", "\N{MINUS SIGN}0.89 (\N{MINUS SIGN}1.5)", "\N{MINUS SIGN}0,89 (\N{MINUS SIGN}1,5)"),
        ("+0.5", "+0.5", "+0,5"),
        ("2e-13", "2e-13", "2e-13"),
        ("3-5", "3-5", "3-5"),
    ],
)
def test_a_number_has_a_true_minus_sign(text: str, english: str, german: str) -> None:
    """Oracle: by hand (ISO 80000-1); hyphens within a range, a day or an exponent stay."""
    assert (localised(text, "en"), localised(text, "de")) == (english, german)


def test_days_and_findings() -> None:
    """Oracle: by hand; English says a finding with its numbers, and has no title for it."""
    assert (day(date(2026, 1, 31), "de"), day(date(2026, 1, 31), "en")) == ("31.01.2026", "2026-01-31")
    assert finding_title("edges-disagree", "de") == "Die vier Flanken des Rades widersprechen einander"
    assert finding_title("edges-disagree", "en") == ""
    assert finding_title("no-such-code", "de") == ""


def _literals() -> Iterator[tuple[str, str]]:
    """Every text that the package gives to the catalogue as it stands, with its file."""
    for path in sorted(REPORT.rglob("*.py")):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(call, ast.Call):
                continue
            name = getattr(call.func, "attr", getattr(call.func, "id", ""))
            texts = [one.value for one in call.args if isinstance(one, ast.Constant)]
            if name in ("t", "translated", "heads"):
                yield from ((path.name, text) for text in (texts if name == "heads" else texts[:1]) if text)
            elif name == "several":
                yield from ((path.name, f"{{n}} {text}") for text in texts if isinstance(text, str))
    for path in sorted(REPORT.rglob("*.html")):
        for text in re.findall(r'\b(?:t|fact)\("((?:[^"\\]|\\.)*)"', path.read_text(encoding="utf-8")):
            yield path.name, text


def test_every_text_of_report_and_certificate_has_its_german() -> None:
    """Oracle: the source; each text that is written out there is in the catalogue."""
    found = list(_literals())
    assert len(found) > 500
    assert sorted({one for one in found if one[1] not in GERMAN}) == []


@pytest.fixture
def unknown(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """Texts that were asked for in German and that the catalogue does not have."""
    missing: set[str] = set()

    def watched(text: str, to: Language) -> str:
        missing.update({text} if to == "de" and text and text not in GERMAN else ())
        return translated(text, to)

    monkeypatch.setattr(language, "translated", watched)
    return missing


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures as their words alone, which takes no time."""

    def words(drawn: Figure, *, title: str) -> str:
        texts = {one.get_text() for one in drawn.findobj(Text)} | {title}
        return "<svg>" + "".join(f"<text>{escape(text)}</text>" for text in sorted(texts)) + "</svg>"

    monkeypatch.setattr(sheet, "svg", words)


@pytest.mark.usefixtures("written")
def test_a_german_report_is_german_from_verdict_to_axis(any_camera: Analysis, unknown: set[str]) -> None:
    """Oracle: the catalogue has all that was asked of it, and no text on the page has one of the commonest English words."""
    page = certificate.report(any_camera, written_in="de").page
    assert unknown == set()
    assert english_words_in(page) == set()
    assert '<html lang="de">' in page
    assert re.search(r"\d,\d+ ± \d,\d+\N{NARROW NO-BREAK SPACE}(ms|µs)", page)


@pytest.mark.usefixtures("sketched")
def test_an_english_report_is_the_same_before_and_after_a_german_one(analysis: Analysis) -> None:
    """Oracle: the page that is made without any language, byte for byte; the result has no language."""
    when = datetime(2026, 11, 24, 12, 0, tzinfo=UTC)
    before = certificate.report(analysis, created=when)
    german = certificate.report(analysis, created=when, written_in="de")
    after = certificate.report(analysis, created=when, written_in="en")
    assert before.page == after.page
    assert "2026-11-24 12:00 UTC" in before.page
    assert "24.11.2026 12:00 UTC" in german.page
    assert german.page != before.page
    assert json.dumps(german.result) == json.dumps(before.result) == json.dumps(after.result)


@pytest.mark.parametrize("event", ["strobe", "stamp", "arrival"])
def test_german_of_a_camera_that_runs_free_speaks_of_no_trigger(event: FrameEvent) -> None:
    """Oracle: every German text that speaks of the trigger edge or its delay, with the event's own words in their place."""
    texts = [one.translations[0] for (context, _), one in catalogue.entries("de").items() if not context]
    told = [
        text for text in texts if re.search(r"\bder Triggerflanke|\bTriggerverzögerung\b|Latenz des Triggerwegs", text)
    ]
    assert len(told) > 15
    for text in told:
        said = event_words.text(text, event, said_in="de")
        assert not re.search(r"Triggerflanke|Triggerverzögerung\b|Triggerweg", said), said


def test_numbers_at_an_axis_have_the_decimal_mark_of_the_language() -> None:
    """Oracle: by hand; letters are paths, but each is told in a comment."""
    told = {}
    for to in ("en", "de"):
        with writing_in(to), sheet.style():
            drawn = sheet.figure(height_in=1.0)
            axes = drawn.subplots()
            axes.plot([0.25, 0.75], [1e-4, 1.0])
            axes.set_xticks([0.25, 0.75])
            axes.set_yscale("log")
            told[to] = re.findall(r"<!-- (.*?) -->", sheet.svg(drawn, title="numbers"))
    assert {"0.25", "0.75"} <= set(told["en"])
    assert {"0,25", "0,75"} <= set(told["de"])
    assert len(told["en"]) == len(told["de"])


@pytest.mark.parametrize("event", ["strobe", "stamp", "arrival"])
def test_a_certificate_of_a_camera_that_runs_free_is_german(event: FrameEvent) -> None:
    """Oracle: what a result says of the trigger, in the event's own words; each is in the catalogue."""
    said = (
        "trigger delay",
        SIGN,
        "latency of the trigger path",
        "latency of application gate, control gate and trigger path",
    )
    for text in said:
        told = event_words.text(text, event)
        assert told != text
        assert told in GERMAN
