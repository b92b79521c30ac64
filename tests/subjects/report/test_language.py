"""Languages: the catalogue is whole and sound, and a language holds only where it was asked for."""

import subprocess
from concurrent.futures import ThreadPoolExecutor
from datetime import date
from gettext import GNUTranslations
from io import BytesIO
from pathlib import Path
from string import Formatter

import pytest

import irtiming.report as package
from irtiming.errors import ArchiveError
from irtiming.report import catalogue
from irtiming.report.language import day, decimal, finding_title, several, t, writing_in

CATALOGUES = Path(package.__file__).parent / "catalogues"


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


def test_numbers_in_a_text_have_the_decimal_mark_of_the_language() -> None:
    """Oracle: by hand; text that stands in a place is not touched."""
    with writing_in("de"):
        assert t("{part:.1f} of {file}", part=2.5, file="a.nxs") == "2,5 of a.nxs"
    assert t("{part:.1f} of {file}", part=2.5, file="a.nxs") == "2.5 of a.nxs"


def test_days_and_findings() -> None:
    """Oracle: by hand; English says a finding with its numbers, and has no title for it."""
    assert (day(date(2026, 1, 31), "de"), day(date(2026, 1, 31), "en")) == ("31.01.2026", "2026-01-31")
    assert finding_title("edges-disagree", "de") == "Die vier Flanken des Rades widersprechen einander"
    assert finding_title("edges-disagree", "en") == ""
    assert finding_title("no-such-code", "de") == ""
