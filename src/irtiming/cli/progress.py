"""Progress of long work: a Rich bar on a terminal, plain lines elsewhere."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from irtiming.cli.interrupt import raise_dropped


class Told(Protocol):
    """What the work calls as it goes on: its name, steps done and steps in all."""

    def __call__(self, name: str, done: int, total: int, /) -> None:
        """Say how far the named piece of work is."""
        ...


@contextmanager
def shown(unit: str, console: Console | None = None) -> Iterator[Told]:
    """Show each named piece of work while the block runs; Ctrl-C that got lost in it is raised again.

    Parameters
    ----------
    unit
        What is counted, such as ``"frames"``.
    console
        Where to; standard error by default, so that standard output holds results only.
    """
    console = console or Console(stderr=True)
    if not console.is_terminal:
        yield _plain_lines(unit, console)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn(unit))
    with Progress(*columns, TimeElapsedColumn(), TimeRemainingColumn(), console=console) as progress:
        tasks: dict[str, int] = {}

        def step(name: str, done: int, total: int, /) -> None:
            raise_dropped()
            if name not in tasks:
                tasks[name] = int(progress.add_task(escape(name), total=total))
            progress.update(progress.tasks[tasks[name]].id, completed=done, total=total)

        yield step


def _plain_lines(unit: str, console: Console) -> Told:
    """One line when a piece of work starts to report and one when it is done."""
    begun: set[str] = set()

    def step(name: str, done: int, total: int, /) -> None:
        raise_dropped()
        if done >= total or name not in begun:
            begun.add(name)
            console.print(f"{name}: {done} of {total} {unit}", highlight=False, soft_wrap=True, markup=False)

    return step
