"""`irtiming explain`: a result in plain words."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.screen import say


def explain(result: Annotated[Path, typer.Argument(help="Result of irtiming analyse --json.")]) -> None:
    """Say in plain words what a result means: how old a picture is, and how a moving edge leans in it."""
    from irtiming.session import hand_over

    for sentence in hand_over.explain(result):
        say(sentence)
