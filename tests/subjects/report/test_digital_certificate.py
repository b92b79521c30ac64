"""The Digital Calibration Certificate: valid, read by another program, read back, and carried inside the PDF."""

import gc
import io
import os
import re
from dataclasses import replace
from pathlib import Path

import pytest
from certificates_by_hand import EVERY_KEY, EXAMPLE, form, result_file, sheet
from lxml import etree

from irtiming.archive.certificate_check import check_certificate
from irtiming.errors import ArchiveError
from irtiming.records.analysis import Analysis
from irtiming.records.camera_frame import CameraIdentity
from irtiming.report.calibration import dcc, page
from irtiming.report.calibration.content import collect
from irtiming.report.calibration.dcc_numbers import decimal, real

ROOT = Path(__file__).parents[3]
NAMES = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}
ONE = CameraIdentity(vendor="Maker & Söhne", model="A320", serial_number="0815", firmware="2.1", address="")

_BY_HAND = ("trigger delay falling", "trigger delay rising")
"""Their hand-made budgets lack what each has of its own, 4 and 3 us, which is rightly told."""


@pytest.fixture(scope="module")
def schema() -> etree.XMLSchema:
    """The schema of PTB, which is not part of the project; tests skip where it is absent."""
    path = Path(os.environ.get("IRTIMING_SHARED", ROOT.parent / "shared")) / "dcc" / "dcc.xsd"
    if not path.is_file():
        pytest.skip(f"no {path}; set IRTIMING_SHARED to the folder that holds dcc/dcc.xsd")
    return etree.XMLSchema(etree.parse(path))


@pytest.mark.parametrize("language", ["en", "de"])
def test_the_certificate_is_valid(any_camera: Analysis, schema: etree.XMLSchema, language: str) -> None:
    """Oracle: dcc.xsd 3.1.2 with D-SI 2.1.0, by lxml; the example, and every key that may be left out."""
    for changes in ({}, EVERY_KEY):
        said = {**changes, "certificate": {**changes.get("certificate", {}), "language": language}}
        root = etree.fromstring(dcc.xml(sheet(any_camera, **said), page="<html></html>").encode())
        assert schema.validate(root), schema.error_log


def test_the_shortest_certificate_is_valid(analysis: Analysis, schema: etree.XMLSchema) -> None:
    """Oracle: the schema; everything is left out that may be, and the result is simulated and of two cameras."""
    empty = {"limit": [], "equipment": [], "place": {"temperature": None, "temperature_u_k": None, "name": None}}
    simulated = replace(analysis, recordings=tuple(replace(one, is_simulated=True) for one in analysis.recordings))
    files = [
        result_file(simulated, "a.json", camera=ONE),
        result_file(analysis, "b.json", camera=replace(ONE, serial_number="9")),
    ]
    told = collect(files, form(item={"description": None, "owner_number": None, "condition": None}, **empty))
    root = etree.fromstring(dcc.xml(told).encode())
    assert schema.validate(root), schema.error_log
    assert len(root.findall(".//dcc:item", NAMES)) == 2
    assert root.find(".//dcc:statement[@id='simulated']", NAMES) is not None


@pytest.mark.parametrize(("distribution", "share"), [("normal", 0.682689), ("rectangular", 0.57735)])
def test_u_alone_covers_what_its_distribution_has_within_it(distribution: str, share: float) -> None:
    """Oracle: GUM 4.3.7 and G.1.3: 1 / sqrt(3) = 57.74 % of a rectangle lie within u of it, 68.27 % of a Gaussian."""
    found = real(0.0, "s", u=1e-6, distribution=distribution)
    assert found.findtext("si:expandedUnc/si:coverageProbability", namespaces=NAMES) == f"{share:g}"


def test_another_reader_gets_value_u_k_and_unit(analysis: Analysis) -> None:
    """Oracle: the hand-made numbers, read by XPath alone: 400 us, U = 2.00 x 30 us, 95.45 %; relative delays with their clock."""
    root = etree.fromstring(dcc.xml(collect([result_file(analysis, camera=ONE)], form())).encode())
    real = root.xpath("//dcc:result/dcc:data/dcc:quantity/si:real[si:label='trigger_delay']", namespaces=NAMES)[0]
    value, unit = (real.findtext(f"si:{name}", namespaces=NAMES) for name in ("value", "unit"))
    names = ("uncertainty", "coverageFactor", "coverageProbability")
    wide, k, probability = (float(real.findtext(f"si:expandedUnc/si:{name}", namespaces=NAMES)) for name in names)
    assert (float(value), unit) == (pytest.approx(400e-6, rel=1e-9), r"\second")
    assert k == pytest.approx(2.0, abs=1e-3)
    assert wide == pytest.approx(k * 30e-6, rel=1e-6)
    assert probability == pytest.approx(0.9545)
    relative = root.xpath("//dcc:quantity/si:real[si:label='relative_delay']/si:value/text()", namespaces=NAMES)
    assert [float(text) for text in relative] == pytest.approx([0.025001, 0.049998, 0.075003, 0.099996], rel=1e-6)
    assert root.xpath("string(//dcc:item/dcc:identifications/dcc:identification/dcc:value)", namespaces=NAMES) == "0815"
    assert root.xpath("string(//dcc:item/dcc:manufacturer/dcc:name/dcc:content)", namespaces=NAMES) == "Maker & Söhne"
    assert root.xpath("string(//dcc:metaData/dcc:conformity)", namespaces=NAMES) == "pass"


def test_each_item_of_the_standard_stands_in_the_xml(analysis: Analysis) -> None:
    """Oracle: the paths in the table of the documentation, by XPath."""
    root = etree.fromstring(dcc.xml(sheet(analysis, **EVERY_KEY)).encode())
    text = (ROOT / "docs" / "reference" / "certificate.md").read_text()
    paths = re.findall(r"^\| 7\.8\..* \| `([A-Za-z/]+)` \|$", text, flags=re.MULTILINE)
    assert len(paths) == 25
    for path in paths:
        found = root.findall("/".join(f"dcc:{name}" for name in path.split("/")), NAMES)
        assert any("".join(one.itertext()).strip() for one in found), path


def test_a_certificate_is_read_back(any_camera: Analysis, tmp_path: Path) -> None:
    """Oracle: what was certified; nothing is wrong with it, and nobody has signed it."""
    told = collect([result_file(any_camera, camera=ONE)], form())
    path = tmp_path / "cert.xml"
    path.write_text(dcc.xml(told))
    found = check_certificate(path)
    assert (found.number, found.is_signed, found.is_simulated) == ("2026-0815", False, False)
    assert [one for one in found.problems if not one.startswith(_BY_HAND)] == []
    assert found.items == ("Maker & Söhne A320 0815 IR-17",)
    wanted = [(row.name, row.value, row.expanded) for row in told.results[0].measurands]
    assert [one.label for one in found.quantities] == [name for name, _, _ in wanted]
    assert [one.value for one in found.quantities] == pytest.approx([value for _, value, _ in wanted], rel=1e-9)
    assert [one.expanded for one in found.quantities] == pytest.approx([wide for _, _, wide in wanted], rel=1e-9)


def test_a_certificate_that_was_changed_is_told(analysis: Analysis, tmp_path: Path) -> None:
    """Oracle: one uncertainty halved by hand, which the budget then contradicts; and a part taken out."""
    text = dcc.xml(sheet(analysis))
    wide = re.search(r"<si:label>trigger_delay</si:label>.*?<si:uncertainty>([^<]+)<", text, flags=re.DOTALL)[1]
    path = tmp_path / "cert.xml"
    halved = text.replace(wide, decimal(float(wide) / 2), 1)
    path.write_text(halved.replace("<dcc:uniqueIdentifier>2026-0815", "<dcc:uniqueIdentifier>7"))
    found = check_certificate(path)
    assert found.number == "7"
    assert any(one.startswith("trigger delay: the budget adds up to 3e-05, but U / k is 1.5") for one in found.problems)
    path.write_text(re.sub(r"<dcc:respPersons>.*?</dcc:respPersons>", "", text, flags=re.DOTALL))
    problems = [one for one in check_certificate(path).problems if not one.startswith(_BY_HAND)]
    assert problems == ["administrativeData/respPersons/respPerson is missing"]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is not XML"),
        (b"{}", "is not XML"),
        (b"%PDF-1.7 ...", "is the certificate for people"),
        (b"<a/>", "is no Digital Calibration Certificate but <a>"),
        (b'<!DOCTYPE a [<!ENTITY b "bbbb">]><a>&b;</a>', "declares a document type"),
        (b"<a>" * 100_000, "is not XML"),
        (b'<digitalCalibrationCertificate xmlns="https://ptb.de/dcc"/>', ""),
    ],
)
def test_what_is_no_certificate_is_refused(tmp_path: Path, content: bytes, said: str) -> None:
    """Oracle: files by hand; one line that says what it is, or a certificate with everything missing."""
    path = tmp_path / "cert.xml"
    path.write_bytes(content)
    if not said:
        assert len(check_certificate(path).problems) == 8
        return
    with pytest.raises(ArchiveError, match=re.escape(said)) as caught:
        check_certificate(path)
    assert "\n" not in str(caught.value)


@pytest.mark.filterwarnings(
    "ignore::pytest.PytestUnraisableExceptionWarning", "ignore::ResourceWarning", "ignore:HarfBuzz"
)
def test_the_pdf_carries_fonts_bookmarks_pages_and_the_xml(analysis: Analysis) -> None:
    """Oracle: pypdf: PDF/A-3u in its metadata, A4, page x of y, one bookmark for each section, the XML as it was given."""
    try:
        import weasyprint  # noqa: F401
    except (ImportError, OSError) as missing:
        pytest.skip(f"needs WeasyPrint and the library Pango: {missing}")
    pypdf = pytest.importorskip("pypdf")
    from irtiming.report.calibration import pdf

    told = sheet(analysis)
    made = pdf.pdf(
        page.html(told, beside=EXAMPLE.parent, fonts=pdf.font_css()), attachments={"certificate.xml": b"<a/>"}
    )
    reader = pypdf.PdfReader(io.BytesIO(made))
    assert re.search(rb'pdfaid:part(="|>)3', made) or b"pdfaid" in reader.trailer["/Root"]["/Metadata"].get_data()
    size = reader.pages[0].mediabox
    assert (round(float(size.width) * 25.4 / 72), round(float(size.height) * 25.4 / 72)) == (210, 297)
    texts = [one.extract_text() for one in reader.pages]
    assert all(f"page {k} / {len(texts)}" in text for k, text in enumerate(texts, 1))
    assert "Annex: evidence" in texts[2]
    assert "Annex: evidence" not in texts[0] + texts[1]
    assert {"Results", "Conditions of measurement"} <= {
        one.title for one in reader.outline if not isinstance(one, list)
    }
    assert reader.attachments["certificate.xml"] == [b"<a/>"]
    fonts = {
        str(font.get_object()["/BaseFont"]) for one in reader.pages for font in one["/Resources"]["/Font"].values()
    }
    assert {re.sub(r"^/[A-Z]{6}\+", "", font) for font in fonts} == {"Sheet", "Sheet-Bold"}
    gc.collect()  # WeasyPrint leaves a file open, which is told now and not in another test
