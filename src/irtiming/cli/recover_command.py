"""`irtiming recover`: finish a recording that was interrupted."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.screen import say


def recover(
    part: Annotated[Path, typer.Argument(help="Interrupted recording, NAME.nxs.part.", metavar="FILE")],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Recording to make; if not given, NAME.nxs.", metavar="OUT")
    ] = None,
    keep: Annotated[bool, typer.Option("--keep", help="Leave the interrupted file there.")] = False,
    trust: Annotated[
        bool,
        typer.Option(
            "--trust",
            help="Let it be analysed: it is known that no trigger and no frame was missed at the beginning.",
        ),
    ] = False,
) -> None:
    """Make a finished recording of one that was interrupted: all frames and timestamps that reached the disk.

    A program that was killed could not prove which trigger made which frame; analysis refuses such a recording unless --trust
    is said. The interrupted file is not altered, and removed when the new one is on the disk. --out on another disk helps
    where the disk is full. 'irtiming verify' says what is in either file.
    """
    from functools import partial

    from rich.markup import escape

    from irtiming.archive.live.recovery import recover as recover_file
    from irtiming.archive.verify import verify
    from irtiming.cli.progress import shown

    with shown("frames") as progress:
        finished = recover_file(part, out, keep=keep, trust=trust, progress=partial(progress, escape(part.name)))
    for finding in verify(finished):
        say(f"{finished}: {finding.severity}: {finding.sentence()}")
