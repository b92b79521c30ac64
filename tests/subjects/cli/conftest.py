"""Commands as typed, in terminals of two widths."""

import pytest
import typer
from typer.testing import CliRunner

from irtiming.cli.plan_command import plan


def _typed(columns):
    """A function that runs `irtiming plan` in a terminal of so many columns."""
    app = typer.Typer()
    app.command()(plan)
    runner = CliRunner(env={"COLUMNS": str(columns)})
    return lambda *words: runner.invoke(app, [str(word) for word in words])


@pytest.fixture
def run():
    """Return a function that runs `irtiming plan` in a terminal of 100 columns."""
    return _typed(100)


@pytest.fixture
def narrow():
    """The same in a terminal of 80 columns."""
    return _typed(80)
