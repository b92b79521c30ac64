"""`irtiming verify`: check recordings before they are analysed, every complaint at once."""

from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from irtiming.archive.json_file import require_places, write_json
from irtiming.archive.rig_file import read_rig
from irtiming.cli.progress import shown
from irtiming.cli.screen import say
from irtiming.errors import one_line
from irtiming.records.finding import Finding

_STYLES = {"ok": "green", "info": "dim", "warning": "yellow", "doubt": "bold magenta", "error": "bold red"}


def verify(
    files: Annotated[list[Path], typer.Argument(help="Recordings to check.", metavar="FILE...")],
    rig: Annotated[
        Path | None, typer.Option(metavar="FILE", help="rig.toml: what the frames show is held against it.")
    ] = None,
    json: Annotated[Path | None, typer.Option("--json", help="Write all findings there.", metavar="OUT")] = None,
) -> None:
    """Check recordings and list everything that is wrong with them, with its cure.

    Exit status 0 if no file has an error (warnings may remain), 2 otherwise.
    """
    from irtiming.archive.verify import verify as verify_file

    screen = Console()
    require_places({"JSON": [json]}, inputs=[*files, rig])
    stated = None if rig is None else read_rig(rig)
    results: dict[Path, list[Finding]] = {}
    for path in files:
        with shown("frames") as progress:
            results[path] = verify_file(path, progress=partial(progress, escape(path.name)), rig=stated)
        _show(path, results[path], screen=screen)
    failed = [path for path, findings in results.items() if _has_error(findings)]
    if json is not None:
        write_json({"files": [_entry(path, findings) for path, findings in results.items()]}, json)
    if failed:
        raise typer.Exit(2)


def _has_error(findings: list[Finding]) -> bool:
    return any(finding.severity == "error" for finding in findings)


def _entry(path: Path, findings: list[Finding]) -> dict[str, object]:
    return {"file": str(path), "ok": not _has_error(findings), "findings": [asdict(f) for f in findings]}


def _show(path: Path, findings: list[Finding], *, screen: Console) -> None:
    if not screen.is_terminal:
        for finding in findings:
            line = f"{finding.severity}: {path}: {finding.sentence()}"
            say(" ".join(line.split()), screen)
        return
    table = Table(title=escape(str(path)), title_justify="left", show_lines=False)
    for heading in ("", "where", "what", "what to do"):
        table.add_column(heading, overflow="fold")
    for finding in findings:
        style = _STYLES[finding.severity]
        cells = (finding.where, finding.what, finding.cure)
        table.add_row(f"[{style}]{finding.severity}[/]", *(escape(one_line(cell)) for cell in cells))
    screen.print(table)
