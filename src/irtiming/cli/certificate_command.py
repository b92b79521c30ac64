"""``irtiming certificate``: results in, a certificate out that can be handed over."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.archive.json_file import require_places
from irtiming.cli.options import in_options
from irtiming.errors import UnitError
from irtiming.records.choices import Language


@in_options
def certificate(
    result: Annotated[list[Path] | None, typer.Argument(help="Results of irtiming analyse --json.")] = None,
    form: Annotated[
        Path | None,
        typer.Option(
            "--with", metavar="TOML", help="Laboratory, customer, dates, equipment, limits: certificate.toml."
        ),
    ] = None,
    out: Annotated[
        list[Path] | None,
        typer.Option("--out", "-o", metavar="OUT", help="Write it as .pdf, .html or .xml (a DCC); repeatable."),
    ] = None,
    crate: Annotated[
        Path | None,
        typer.Option(metavar="ZIP", help="Write all that repeats the analysis, recordings too, as one RO-Crate."),
    ] = None,
    language: Annotated[Language | None, typer.Option(help="Of the certificate; else as in certificate.toml.")] = None,
    check: Annotated[
        Path | None,
        typer.Option(metavar="XML", help="Read a certificate in XML back instead, and say what it certifies."),
    ] = None,
    json: Annotated[Path | None, typer.Option(metavar="OUT", help="With --check: write that as JSON.")] = None,
) -> None:
    """Calibration certificate of a camera from results of its analysis.

    ISO/IEC 17025, 7.8: for people as PDF/A or HTML, for programs as Digital Calibration Certificate. What no recording
    knows stands in certificate.toml.
    """
    from irtiming.cli.certificate_table import show_checked, show_made
    from irtiming.session import certificate as session

    if check is not None:
        if result or form or out or crate:
            raise UnitError("--check reads a certificate and writes none; leave results, --with, --out and --crate out")
        require_places({"JSON": [json]}, inputs=[check])
        return show_checked(session.check(check), json=json)
    if not result or form is None:
        raise UnitError(
            "a certificate needs results and --with certificate.toml, such as irtiming certificate result.json --with "
            "certificate.toml --out cert.pdf; or --check cert.xml"
        )
    if json is not None:
        raise UnitError("--json goes with --check only; leave it out, the certificate for programs is --out cert.xml")
    order = session.CertificateOrder(
        results=tuple(result), form=form, out=tuple(out or ()), crate=crate, language=language
    )
    return show_made(session.certify(order), [*order.out, *([crate] if crate else [])])
