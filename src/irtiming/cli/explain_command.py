"""`irtiming explain`: a result in plain words."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import FrameRate, in_options
from irtiming.cli.screen import say


@in_options
def explain(
    result: Annotated[Path, typer.Argument(help="Result of irtiming analyse --json.")], frame_hz: FrameRate = None
) -> None:
    """Say in plain words what a result means: how old a picture is, and how a moving edge leans in it."""
    from irtiming.session import hand_over

    for sentence in hand_over.explain(result, frame_hz=frame_hz):
        say(sentence)
