"""`irtiming gateware firmware`: the trigger generator as files for a microcontroller board."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from irtiming.cli.screen import say
from irtiming.session.firmware import write_firmware


def firmware(
    into: Annotated[
        Path, typer.Option("--into", help="Folder for the files; made if it is not there.", metavar="FOLDER")
    ],
) -> None:
    """Write the firmware that makes a trigger generator of a Raspberry Pi Pico or Pico 2.

    The board needs MicroPython; then copy the .py files to it. README.md among the files says how.
    """
    screen = Console()
    for path in write_firmware(into):
        say(str(path), screen)
