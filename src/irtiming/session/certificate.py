"""A certificate made of results: for people on paper or screen, for programs as XML, with its evidence as one crate."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from irtiming.archive.certificate_check import CheckedCertificate, check_certificate
from irtiming.archive.certificate_file import CertificateFile, read_certificate_file
from irtiming.archive.json_file import require_places, write_atomically
from irtiming.archive.result_file import read_result
from irtiming.archive.suffixes import SUFFIXES
from irtiming.errors import ArchiveError
from irtiming.records.choices import Language
from irtiming.report.calibration import dcc, page, pdf
from irtiming.report.calibration.content import ResultFile, Sheet, collect
from irtiming.session import crate


@final
@dataclass(frozen=True, kw_only=True)
class CertificateOrder:
    """What a person wants certified: results, what to print beside them, and the files to write.

    ``language`` is that of certificate.toml where it is None.
    """

    results: tuple[Path, ...]
    form: Path
    out: tuple[Path, ...]
    crate: Path | None = None
    language: Language | None = None

    def __post_init__(self) -> None:
        for path in self.out:
            if path.suffix.lower() not in SUFFIXES["certificate"]:
                raise ArchiveError(f"{path}: a certificate is written as .pdf, .html or .xml; name it so")
        if self.crate is not None and self.crate.suffix.lower() != ".zip":
            raise ArchiveError(f"{self.crate}: a crate is a .zip; name it so")
        if not self.out and self.crate is None:
            raise ArchiveError("nothing is to be written; give {out} cert.pdf, cert.html or cert.xml", "out")


def certify(order: CertificateOrder) -> Sheet:
    """Write the certificate in every form that is wanted; gives what stands on it.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, results and certificate.toml contradict each other, or WeasyPrint is missing.
    """
    require_places({"certificate": order.out}, files=[order.crate], inputs=[*order.results, order.form])
    form = _in_language(read_certificate_file(order.form), order.language)
    sheet = collect(read_results(order.results), form, called=str(order.form))
    made = {path: _made(sheet, path.suffix.lower(), beside=order.form.parent) for path in order.out}
    for path, content in made.items():
        write_atomically(content, path)
    if order.crate is not None:
        crate.write(sheet, order.crate, results=order.results, form=order.form, certificates=made)
    return sheet


def check(path: Path) -> CheckedCertificate:
    """Read a certificate in XML back.

    Raises
    ------
    ArchiveError
        If it is no certificate.
    """
    return check_certificate(path)


def read_results(paths: Sequence[Path]) -> list[ResultFile]:
    """Results with the checksums of their files.

    Raises
    ------
    ArchiveError
        If one cannot be read, or is given twice.
    """
    found: list[ResultFile] = []
    for path in paths:
        result = read_result(path)
        sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
        same = next((one.name for one in found if one.sha256 == sha256), None)
        if same is not None:
            raise ArchiveError(f"{path} and {same} are the same result; give each once")
        found.append(ResultFile(name=path.name, sha256=sha256, content=result))
    return found


def _in_language(form: CertificateFile, language: Language | None) -> CertificateFile:
    if language is None:
        return form
    return form.model_copy(update={"certificate": form.certificate.model_copy(update={"language": language})})


def _made(sheet: Sheet, suffix: str, *, beside: Path) -> str | bytes:
    """One form of the certificate; the PDF carries the XML inside, the XML the page."""
    if suffix == ".html":
        return page.html(sheet, beside=beside)
    as_xml = dcc.xml(sheet, page=page.html(sheet, beside=beside))
    if suffix == ".xml":
        return as_xml
    return pdf.pdf(
        page.html(sheet, beside=beside, fonts=pdf.font_css()), attachments={"certificate.xml": as_xml.encode()}
    )
