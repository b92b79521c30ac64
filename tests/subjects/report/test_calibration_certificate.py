"""Certificates: what stands on the page is what the result says, in every language, and where ISO/IEC 17025 wants it."""

import re
from dataclasses import replace
from datetime import date
from math import sqrt
from pathlib import Path

import pytest
from certificates_by_hand import EVERY_KEY, EXAMPLE, form, result_file, sheet
from lxml import html as lxml_html

import irtiming.report.calibration as package
from irtiming.archive.certificate_file import RULES, read_certificate_file
from irtiming.archive.limits_file import LimitsFile
from irtiming.errors import ArchiveError
from irtiming.records.analysis import Analysis
from irtiming.records.camera_frame import CameraIdentity
from irtiming.report.calibration import conditions, page
from irtiming.report.calibration.content import collect
from irtiming.report.calibration.decision import judged
from irtiming.report.calibration.numbers import small, stated
from irtiming.report.calibration.rows import VERDICTS
from irtiming.report.catalogue import entries
from irtiming.report.language import translated
from irtiming.report.meanings import meaning

REFERENCE = EXAMPLE.parents[1] / "docs" / "reference" / "certificate.md"
GERMAN = {english for _, english in entries("de")}
ONE = CameraIdentity(vendor="Maker", model="A320", serial_number="0815", firmware="2.1", address="")


def _page(analysis: Analysis, **changes):
    return lxml_html.fromstring(page.html(sheet(analysis, **changes), beside=EXAMPLE.parent).encode())


def _text(element) -> str:
    return " ".join(element.text_content().split())


@pytest.mark.parametrize(
    ("place", "language", "words"),
    [
        ({"temperature": "23 C", "temperature_u_k": 0.5}, "en", "(23.0 ± 1.0) °C (k = 2)"),
        ({"temperature": "23 C", "temperature_u_k": 0.06}, "de", "(23,00 ± 0,12) °C (k = 2)"),
        ({"temperature": "23 C", "temperature_u_k": None}, "en", "23 °C"),
        ({"humidity_percent": 45.0, "humidity_u_percent": 2.5}, "en", "(45.0 ± 5.0) % (k = 2) relative humidity"),
    ],
)
def test_the_air_has_its_expanded_uncertainty(analysis: Analysis, place, language, words) -> None:
    """Oracle: by hand; ± stands before expanded uncertainties on the whole page, twice the standard ones, to two digits."""
    told = sheet(analysis, place=place, certificate={"language": language})
    assert words in conditions.environment(told).replace("\u202f", " ")


@pytest.mark.parametrize(("u_s", "words"), [(None, "250 µs"), (7.4e-6, "250 µs ± 15 µs (k = 2)")])
def test_an_integration_time_has_the_digits_of_its_uncertainty(analysis: Analysis, u_s, words) -> None:
    """Oracle: by hand; twice the 7.4 us that rig.toml states, and no more digits than that has."""
    rig = replace(analysis.rig, camera=replace(analysis.rig.camera, integration_time_u_s=u_s))
    told = sheet(replace(analysis, rig=rig))
    found = dict(conditions.of(told, told.results[0]))["integration time as stated"]
    assert found.replace("\u202f", " ") == words


def test_the_headline_has_value_u_and_k(analysis: Analysis) -> None:
    """Oracle: the hand-made result: 400 us with u = 30 us, k = 2.00, so U = 60 us; five relative delays but the reference."""
    found = _page(analysis)
    headline = _text(found.find_class("headline")[0])
    assert "trigger delay" in headline
    assert "400 µs U = 60 µs (k = 2.00)" in headline.replace("\u202f", " ")
    rows = [_text(row) for row in found.xpath("//section[@id='results']//tbody/tr")]
    assert sum(row.startswith("relative delay, set") for row in rows) == 4
    assert _text(found.get_element_by_id("number")) == "No. 2026-0815"


def test_what_no_recording_says_is_shown_as_missing(analysis: Analysis) -> None:
    """Oracle: the words given; what the laboratory states in its place is marked, and a contradiction is refused."""
    cells = _page(analysis).xpath("//table[@id='item']//td")
    assert [_text(cell) for cell in cells] == ["not in the recordings"] * 4 + ["IR-17"]
    told = collect([result_file(analysis, camera=replace(ONE, serial_number=""))], form(item={"serial_number": "77"}))
    assert (told.items[0].words["serial_number"], told.items[0].stated) == ("77", ("serial_number",))
    with pytest.raises(ArchiveError, match=r"\[item\] model = 'B1', the recordings of result.json say 'A320'"):
        collect([result_file(analysis, camera=ONE)], form(item={"model": "B1"}))


def test_every_budget_adds_up(any_camera: Analysis) -> None:
    """Oracle: GUM 5.1.2: the squares of the contributions |c| u(x) add up to u squared; 24 and 18 us make 30 us."""
    rows = sheet(any_camera).results[0].measurands
    assert {row.name for row in rows} >= {"trigger_delay"}
    for row in rows:
        if row.name == "relative_delay" or row.name == "trigger_delay":
            assert sqrt(sum(line.contribution**2 for line in row.budget)) == pytest.approx(row.u, rel=1e-6), row.name
        assert all(line.contribution == pytest.approx(line.sensitivity * line.u) for line in row.budget)
        assert row.expanded == pytest.approx(row.coverage_factor * row.u)


@pytest.mark.parametrize(
    ("value", "limits", "rule", "outcome"),
    [
        (400, (None, 450), "simple acceptance", "pass"),
        (451, (None, 450), "simple acceptance", "fail"),
        (400, (None, 461), "guard band", "pass"),
        (400, (None, 450), "guard band", "conditionalPass"),
        (451, (None, 450), "guard band", "conditionalFail"),
        (511, (None, 450), "guard band", "fail"),
        (400, (350, 461), "guard band", "conditionalPass"),
        (339, (400, None), "guard band", "fail"),
    ],
)
def test_the_decision_rules(value: float, limits: tuple, rule: str, outcome: str) -> None:
    """Oracle: ILAC-G8:09/2019, figures of 4.2.1 and 4.2.3, by hand with U = 60."""
    said = judged(value, u=30, expanded=60, degrees_of_freedom=float("inf"), limits=limits, rule=rule)
    assert said.outcome == outcome


def test_the_probability_of_conformity() -> None:
    """Oracle: tables of the normal distribution and of Student's t, one u inside: 84.13 %, with 3 degrees of freedom 80.45 %."""
    given = {"u": 30.0, "expanded": 60.0, "limits": (None, 430.0), "rule": "guard band"}
    assert judged(400, degrees_of_freedom=float("inf"), **given).probability == pytest.approx(0.84134, abs=1e-5)
    assert judged(400, degrees_of_freedom=3, **given).probability == pytest.approx(0.80450, abs=1e-5)


def test_numbers_on_paper() -> None:
    """Oracle: by hand; two digits of U, the value to the same place, a comma in German."""
    assert stated(400.04e-6, 59.96e-6, language="en") == ("400\u202fµs", "60\u202fµs")
    assert stated(2.07225e-3, 7.615e-5, language="de") == ("2,072\u202fms", "0,076\u202fms")
    assert small(1.6e-14, "s", language="en", digits=2) == "1.6 · 10⁻¹⁴\u202fs"
    assert small(0.0530516, "s/rad", language="de") == "0,0531\u202fs/rad"


def test_each_item_of_the_standard_stands_where_the_table_says(analysis: Analysis) -> None:
    """Oracle: the table in the documentation; 7.8.2.1 a to p, 7.8.2.2, 7.8.4.1 a to f, 7.8.4.3, 7.8.8 of ISO/IEC 17025:2017."""
    rows = re.findall(
        r"^\| (7\.8\.\S+(?: [a-p])?) \|.*\| ([^|]+) \| `([^`]+)` \|$", REFERENCE.read_text(), flags=re.MULTILINE
    )
    wanted = [f"7.8.2.1 {letter}" for letter in "abcdefghijklmnop"] + ["7.8.2.2"]
    wanted += [f"7.8.4.1 {letter}" for letter in "abcdef"] + ["7.8.4.3", "7.8.8"]
    assert [item for item, _, _ in rows] == wanted
    found = _page(analysis, **EVERY_KEY)
    for item, places, _ in rows:
        for place in re.findall(r"`#([a-z]+)`", places):
            assert len(_text(found.get_element_by_id(place))) > 3, (item, place)


def test_everything_that_is_said_has_its_german() -> None:
    """Oracle: the template and the constants of the package; each text that is printed is in the catalogue."""
    template = (Path(package.__file__).parent / "certificate.html").read_text()
    texts = set(re.findall(r't\("([^"]+)"\)', template)) | set(re.findall(r'fact\("([^"]+)"', template))
    texts |= {*conditions.PLACES.values(), *RULES.values(), *conditions.METHODS.values(), *VERDICTS.values()}
    texts |= {*conditions.KINDS.values(), conditions.TRACEABILITY, conditions.NOT_TRACEABLE}
    assert sorted(texts - GERMAN) == []
    assert len(texts) > 80


def test_events_of_every_camera_have_their_german(any_camera: Analysis) -> None:
    """Oracle: the meanings that results print, and the labels of the conditions."""
    for row in sheet(any_camera).results[0].measurands:
        for text in (row.event, row.sign, *(line.source for line in row.budget), row.name.replace("_", " ")):
            assert text is None or text in GERMAN, text
    assert meaning("trigger_delay", any_camera).event in GERMAN
    told = sheet(any_camera)
    for label, _ in conditions.of(told, told.results[0]):
        assert translated(label, "de") != label


def test_a_german_certificate_is_german(analysis: Analysis) -> None:
    """Oracle: the words of DIN EN ISO/IEC 17025 and of the GUM, a decimal comma, a day with dots."""
    found = _page(analysis, certificate={"language": "de"})
    text = _text(found)
    assert found.get("lang") == "de"
    for words in ("Kalibrierschein", "Erweiterungsfaktor", "Auftraggeber", "24.11.2026", "2,00", "Schutzabstand"):
        assert words in text
    labels = [_text(cell) for cell in found.xpath("//th[@scope='col'] | //dt | //h2 | //caption")]
    assert not [label for label in labels if re.search(r"\b(the|of|and|certificate|results)\b", label)]


def test_a_specimen_says_so(analysis: Analysis) -> None:
    """Oracle: one recording that says it; a mark of accreditation is not printed on a specimen."""
    simulated = replace(analysis, recordings=tuple(replace(one, is_simulated=True) for one in analysis.recordings))
    found = _page(simulated, laboratory={"accreditation_mark": "mark.png"})
    assert found.find_class("simulated")[0].get("data-mark") == "SIMULATED"
    assert "specimen without any validity" in _text(found.get_element_by_id("simulated"))
    assert "simulated" in _text(found.get_element_by_id("traceability"))
    assert found.xpath("//img") == []
    assert not _page(analysis).find_class("simulated")


def test_markup_of_others_is_text(analysis: Analysis) -> None:
    """Oracle: a finding with markup in it, and a customer's name with some."""
    found = _page(analysis, customer={"name": "<script>alert(1)</script>"})
    assert found.xpath("//script") == []
    assert "<script>alert(1)</script>" in _text(found.get_element_by_id("customer"))


def test_a_page_for_everyone(analysis: Analysis) -> None:
    """Oracle: WCAG: landmarks, one h1, a caption and scoped headers for each table."""
    found = _page(analysis, **EVERY_KEY)
    assert len(found.xpath("//h1")) == len(found.xpath("//main")) == len(found.xpath("//header")) == 1
    assert all(table.xpath("./caption") and table.xpath(".//th[@scope]") for table in found.xpath("//table"))
    assert all(found.xpath(f"//*[@id='{one.get('aria-labelledby')}']") for one in found.xpath("//section"))
    assert not [a for a in found.xpath("//@src | //@href") if not a.startswith("data:")]
    style = found.xpath("//style")[0].text
    assert "prefers-color-scheme: dark" in style
    assert "max-width: 40em" in style


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"dates": {"measured": None}}, "the recordings do not say when they were made; state [dates] measured"),
        (
            {"dates": {"measured": [date(2026, 11, 30)]}},
            "the last day of measurement, 2026-11-30, is later than 2026-11-24",
        ),
        ({"dates": {"received": date(2026, 11, 22)}}, "[dates] received, 2026-11-22, is later than 2026-11-20"),
        (
            {"limit": [{"parameter": "trigger_dealy", "upper": "1 ms"}]},
            "a [[limit]] of 'trigger_dealy', which was not measured",
        ),
        (
            {
                "item": {"serial_number": "A12"},
                "limit": [{"parameter": "trigger_delay", "upper": "1 ms", "serial_number": "A21"}],
            },
            "a [[limit]] of the camera with serial_number = 'A21', which the certificate is not of; it is of A12",
        ),
        (
            {"laboratory": {"accreditation_mark": "mark.txt"}},
            "mark.txt: the accreditation mark must be a PNG, JPEG or SVG",
        ),
        ({"laboratory": {"accreditation_mark": "mark.png"}}, "mark.png: the accreditation mark cannot be read"),
    ],
)
def test_what_cannot_be_is_refused(analysis: Analysis, changes: dict, said: str) -> None:
    """Oracle: one thing changed in an order that is good; one line that says it."""
    with pytest.raises(ArchiveError) as caught:
        _page(analysis, **changes)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("rule", RULES)
def test_campaign_and_certificate_word_a_decision_rule_alike(analysis: Analysis, rule: str) -> None:
    """Oracle: a law; what limits.toml says of a rule stands on a certificate that is judged by it."""
    limits = {"decision": {"rule": rule}, "limit": [{"parameter": "trigger_delay", "upper": "1 ms"}]}
    assert LimitsFile.model_validate(limits).rule_in_words in _text(_page(analysis, **limits))


@pytest.mark.parametrize("own_first", [False, True])
def test_the_own_limit_of_a_camera_counts_before_the_one_for_all(analysis: Analysis, own_first: bool) -> None:
    """Oracle: by hand; 400 us fails 300 us and keeps 1 ms, and only the laboratory says that the camera is A12."""
    limits = [
        {"parameter": "trigger_delay", "upper": "1 ms"},
        {"parameter": "trigger_delay", "upper": "300 us", "serial_number": "A12"},
    ]
    told = sheet(analysis, item={"serial_number": "A12"}, limit=limits[::-1] if own_first else limits)
    row = next(one for one in told.results[0].measurands if one.name == "trigger_delay")
    assert row.limits == (None, pytest.approx(300e-6))
    assert row.conformity is not None
    assert row.conformity.outcome == "fail"


def test_days_of_measurement_are_those_of_the_recordings(analysis: Analysis) -> None:
    """Oracle: two starts by hand, the earlier one last."""
    starts = ["2026-11-20T09:00:00+00:00"] * (len(analysis.recordings) - 1) + ["2026-11-19T23:59:00+00:00"]
    timed = tuple(replace(one, start_time=start) for one, start in zip(analysis.recordings, starts, strict=True))
    told = collect([result_file(replace(analysis, recordings=timed))], form(dates={"measured": None}))
    assert (told.first_day, told.last_day) == (date(2026, 11, 19), date(2026, 11, 20))


@pytest.mark.parametrize(
    ("measured", "issued", "said"),
    [
        ((20, 20), 24, None),
        ((21, 21), 24, None),
        ((19, 21), 24, None),
        ((20, 20), 20, None),
        (
            (22, 23),
            24,
            "says 2026-11-22 to 2026-11-23, the recordings were made from 2026-11-20 to 2026-11-20, which must be",
        ),
        (
            (10, 18),
            24,
            "[dates] measured says 2026-11-10 to 2026-11-18, the recordings were made from",
        ),
        ((10, 20), 24, "[dates] measured says 2026-11-10 to 2026-11-20, the recordings were made from"),
        ((20, 24), 24, "[dates] measured says 2026-11-20 to 2026-11-24, the recordings were made from"),
        ((19, 19), 19, None),
        ((18, 18), 18, "[dates] measured says 2026-11-18 to 2026-11-18, the recordings were made from"),
        (None, 19, "the last day of measurement, 2026-11-20, is later than 2026-11-19"),
    ],
)
def test_days_that_contradict_the_recordings_are_refused(
    analysis: Analysis, measured: tuple[int, int] | None, issued: int, said: str | None
) -> None:
    """Oracle: by hand; all recordings are of 20 November, and a day is left for time zones."""
    timed = tuple(replace(one, start_time="2026-11-20T09:00:00+00:00") for one in analysis.recordings)
    days = None if measured is None else [date(2026, 11, day) for day in measured]
    stated = form(dates={"measured": days, "received": None}, certificate={"issued": date(2026, 11, issued)})
    files = [result_file(replace(analysis, recordings=timed))]
    if said is None:
        assert collect(files, stated).days_stated
        return
    with pytest.raises(ArchiveError) as caught:
        collect(files, stated)
    assert said in str(caught.value)


@pytest.mark.parametrize(("due", "is_refused"), [(19, True), (20, False), (None, False)])
def test_equipment_must_have_been_calibrated_on_the_last_day(
    analysis: Analysis, due: int | None, is_refused: bool
) -> None:
    """Oracle: by hand; a calibration holds on the day on which the next is due, and not on the one after."""
    timed = tuple(replace(one, start_time="2026-11-20T09:00:00+00:00") for one in analysis.recordings)
    files = [result_file(replace(analysis, recordings=timed))]
    stated = form(dates={"measured": None, "received": None}, certificate={"issued": date(2026, 11, 20)})
    wheel = stated.equipment[0].model_copy(update={"due": None if due is None else date(2026, 11, due)})
    stated = stated.model_copy(update={"equipment": [wheel]})
    if not is_refused:
        assert collect(files, stated).last_day == date(2026, 11, 20)
        return
    with pytest.raises(ArchiveError, match=f"{wheel.name} was due for calibration on 2026-11-19, before the last day"):
        collect(files, stated)


def test_recordings_that_say_no_day_leave_it_to_the_laboratory(analysis: Analysis) -> None:
    """Oracle: by hand; one of them is of 20 November, a further day of the others is not contradicted."""
    timed = tuple(
        replace(one, start_time="" if k else "2026-11-20T09:00:00+00:00") for k, one in enumerate(analysis.recordings)
    )
    files = [result_file(replace(analysis, recordings=timed))]
    stated = {"measured": [date(2026, 11, 10), date(2026, 11, 20)], "received": None}
    assert collect(files, form(dates=stated)).first_day == date(2026, 11, 10)


def test_two_cameras_on_one_certificate(analysis: Analysis, rolling: Analysis) -> None:
    """Oracle: the serial numbers given; without them nobody can tell the cameras apart, and it is refused."""
    files = [
        result_file(analysis, "a.json", camera=ONE),
        result_file(rolling, "b.json", camera=replace(ONE, serial_number="9")),
    ]
    told = collect(files, form(item=[{"serial_number": "9", "owner_number": "IR-9"}, {"serial_number": "0815"}]))
    assert [item.words["serial_number"] for item in told.items] == ["0815", "9"]
    assert [item.form.owner_number for item in told.items] == [None, "IR-9"]
    assert [one.item for one in told.results] == [0, 1]
    assert [row.name for row in told.results[1].headline] == ["trigger_delay", "time_constant", "row_delay"]
    judged_one = collect(
        files, form(item=[], limit=[{"parameter": "trigger_delay", "upper": "1 ms", "serial_number": "9"}])
    )
    assert [one.headline[0].conformity and one.headline[0].conformity.outcome for one in judged_one.results] == [
        None,
        "fail",
    ]
    with pytest.raises(ArchiveError, match=r"a.json names no serial number, and the results are of several cameras"):
        collect([result_file(analysis, "a.json"), result_file(rolling, "b.json")], form())


def test_a_day_as_it_is_written_elsewhere_is_refused_with_one_that_is_right(tmp_path: Path) -> None:
    """Oracle: by hand; a date in TOML stands without quotes."""
    text = (Path(__file__).parents[3] / "examples" / "certificate.toml").read_text()
    (tmp_path / "certificate.toml").write_text(re.sub(r"issued = \S+", 'issued = "24.11.2026"', text))
    with pytest.raises(ArchiveError, match="is '24.11.2026'; it must be a day without quotes, such as 2026-11-24"):
        read_certificate_file(tmp_path / "certificate.toml")
