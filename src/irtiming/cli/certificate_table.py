"""What a certificate says, as lines for a terminal."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from irtiming.archive.certificate_check import CheckedCertificate
from irtiming.archive.json_file import write_json
from irtiming.cli.screen import say
from irtiming.errors import ArchiveError
from irtiming.report.calibration.content import Sheet
from irtiming.report.calibration.rows import VERDICTS, measurand


def show_made(sheet: Sheet, written: Sequence[Path]) -> None:
    """What leads the certificate, and the files."""
    screen = Console()
    number = sheet.form.certificate.number
    for one in sheet.results:
        for row in one.headline:
            shown = measurand(row, "en")
            verdict = f": {VERDICTS[row.conformity.outcome]}" if row.conformity else ""
            say(f"{shown['name']} = {shown['value']}, U = {shown['expanded']} (k = {shown['k']}){verdict}", screen)
    if sheet.is_simulated:
        say("SIMULATED: no camera made the frames, and the certificate says so", screen)
    missing = [name.replace("_", " ") for item in sheet.items for name, word in item.words.items() if word is None]
    if missing:
        say(f"not in the recordings, and shown as missing: {', '.join(dict.fromkeys(missing))}", screen)
    for path in written:
        say(f"certificate {number}: {path}", screen)


def show_checked(found: CheckedCertificate, *, json: Path | None) -> None:
    """What it certifies.

    Raises
    ------
    ArchiveError
        If it does not agree with itself.
    """
    if json is not None:
        write_json(asdict(found), json)
    screen = Console()
    say(f"certificate {found.number} of {found.laboratory} for {found.customer}", screen)
    for item in found.items:
        say(f"item: {item}", screen)
    table = Table("measurand", "value", "U", "k", "unit", "conformity", box=None, pad_edge=False)
    for one in found.quantities:
        k = f"{one.coverage_factor:.2f}"
        table.add_row(one.name, f"{one.value:.9g}", f"{one.expanded:.3g}", k, one.unit, one.conformity or "–")
    screen.print(table)
    if found.is_simulated:
        say("SIMULATED: a specimen without validity", screen)
    say("it holds a signature, which was not verified" if found.is_signed else "it is not signed", screen)
    if found.problems:
        raise ArchiveError(
            f"the certificate does not agree with itself: {'; '.join(found.problems)}; ask its laboratory"
        )
