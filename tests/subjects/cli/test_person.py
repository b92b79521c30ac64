"""Whoever sits at the terminal: the first Ctrl-C or SIGTERM asks for a clean end, the second one is as it was before."""

import asyncio
import io
import signal
from pathlib import Path

import pytest
from rich.console import Console

from irtiming.archive.series_file import read_series
from irtiming.cli.interrupt import Interrupt
from irtiming.cli.person import Person
from irtiming.cli.progress import shown

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.mark.parametrize(("number", "exit_status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_the_second_signal_breaks_off(signals_as_before, number, exit_status):
    """Oracle: by hand; the handler that was there before remembers the second one alone."""
    plan = read_series(EXAMPLES / "cooled.plan.toml")
    notes = Console(file=io.StringIO())
    signal.signal(number, interrupt := Interrupt())

    async def recorded(person):
        with person.listening():
            signal.raise_signal(number)
            await asyncio.sleep(0.05)
            assert person.is_leaving()
            assert interrupt.number is None
            assert interrupt.exit_status == exit_status
            signal.raise_signal(number)

    with shown("frames", notes) as told, pytest.raises(KeyboardInterrupt):
        asyncio.run(recorded(Person(plan, told=told, notes=notes, is_silent=True)))
    assert interrupt.exit_status == exit_status
    assert signal.getsignal(number) is interrupt
    assert "Ctrl-C again breaks it off" in notes.file.getvalue()
