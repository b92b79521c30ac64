"""A series over settings in the terminal: the page's tables."""

from rich.console import Console

from irtiming.cli.drawn_table import print_table
from irtiming.cli.screen import say, warn
from irtiming.records.setting_series import CameraSeries
from irtiming.report import series_page
from irtiming.report.blocks import Table
from irtiming.report.sections import over_settings


def show(series: tuple[CameraSeries, ...], screen: Console) -> None:
    """Verdict and doubts first, then slopes, internal delays and points of each camera."""
    verdict = series_page.verdict(series)
    screen.print(verdict.number, style="bold", markup=False)
    say(verdict.sentence, screen)
    for text in over_settings.doubts(series):
        warn(text, screen)
    for one in over_settings.sections(series):
        for block in one.blocks:
            if isinstance(block, Table) and block.rows:
                print_table(block, screen)
