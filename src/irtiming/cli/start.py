"""The first steps of the program: until its parts are loaded Ctrl-C ends it at once, since nothing was begun yet."""

import os
import signal
from typing import NoReturn

from irtiming.cli.interrupt import exit_status, heeded


def run() -> None:
    """Load the command line and run it."""
    for number in heeded():
        signal.signal(number, _end_at_once)
    from irtiming.cli.main import run as run_command

    run_command()


def _end_at_once(number: int, _: object) -> NoReturn:
    os.write(2, b"irtiming: stopped before it had begun; nothing was written\n")
    os._exit(exit_status(number))
