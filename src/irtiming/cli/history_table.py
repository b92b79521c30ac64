"""A camera's history in the terminal."""

from collections.abc import Sequence

from rich.console import Console

from irtiming.archive.register.entries import KnownCamera
from irtiming.cli.drawn_table import print_table
from irtiming.cli.screen import say
from irtiming.report.blocks import Table, of_tables
from irtiming.report.sections import history as section
from irtiming.session.history import History


def show(history: History, screen: Console) -> None:
    """Drift first, then every result."""
    if not history.drifts:
        say("no drift yet: that takes results of two days at one setting", screen)
    for table in of_tables(section.drift(history.drifts), section.results(history.points)):
        print_table(table, screen)


def show_cameras(cameras: Sequence[KnownCamera], screen: Console) -> None:
    """Every camera that the register knows."""
    rows = tuple((one.serial_number, one.model or "–", str(one.n_results)) for one in cameras)
    print_table(Table(title="Cameras", columns=("serial number", "model", "results"), align="llr", rows=rows), screen)
