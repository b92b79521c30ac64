"""A certificate on paper: PDF/A with bookmarks, fonts embedded, by WeasyPrint."""

import base64
import logging
from importlib import import_module
from pathlib import Path
from typing import Any

from irtiming.errors import ArchiveError

_FONTS = {400: "DejaVuSans.ttf", 700: "DejaVuSans-Bold.ttf"}
VARIANT = "pdf/a-3u"


def font_css() -> str:
    """CSS with the fonts inside: those that matplotlib brings along, the same on every computer."""
    import matplotlib as mpl

    folder = Path(mpl.get_data_path()) / "fonts" / "ttf"
    faces = []
    for weight, name in _FONTS.items():
        content = base64.b64encode((folder / name).read_bytes()).decode()
        source = f'url("data:font/ttf;base64,{content}")'
        faces.append(f'@font-face {{ font-family: "Sheet"; font-weight: {weight}; src: {source}; }}\n')
    return "".join(faces)


def pdf(page: str, *, attachments: dict[str, bytes]) -> bytes:
    """PDF/A of an HTML page.

    Parameters
    ----------
    page
        HTML with `font_css` in its style.
    attachments
        Files to carry inside, by name, such as the certificate as XML.

    Raises
    ------
    ArchiveError
        If WeasyPrint, or a library that it needs, is not installed.
    """
    weasyprint = _weasyprint()
    logging.getLogger("weasyprint").setLevel(logging.CRITICAL)
    inside = [
        weasyprint.Attachment(string=content, name=name, description=name, relationship="Data")
        for name, content in attachments.items()
    ]
    nothing_outside = weasyprint.urls.URLFetcher(allowed_protocols=["data"])
    document = weasyprint.HTML(string=page, url_fetcher=nothing_outside)
    return bytes(document.write_pdf(pdf_variant=VARIANT, attachments=inside))


def _weasyprint() -> Any:
    try:
        return import_module("weasyprint")
    except (ImportError, OSError) as error:
        raise ArchiveError(
            f"a PDF needs WeasyPrint and the library Pango ({type(error).__name__}: {error}); pip install "
            "'irtiming[certificate]', Debian: apt-get install libpango-1.0-0 libpangoft2-1.0-0; or write .html"
        ) from error
