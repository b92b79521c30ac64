"""A campaign in the terminal: verdict, what is broken, and the first tables of its page."""

from rich.console import Console

from irtiming.cli.drawn_table import print_table
from irtiming.cli.screen import say, warn
from irtiming.report import campaign_page
from irtiming.report.blocks import Table
from irtiming.report.sections import campaign as sections
from irtiming.session.campaign import Done
from irtiming.units import counted

_MOST = 25


def show(done: Done, screen: Console) -> None:
    """What a person wants to know first; the rest is in the files that are named."""
    verdict = campaign_page.verdict(done.campaign)
    screen.print(verdict.number, style="bold", markup=False)
    for text in (verdict.sentence, *verdict.remarks):
        say(text, screen)
    for text in campaign_page.doubts(done.campaign):
        warn(text, screen)
    made = [sections.repeatability(done.campaign)]
    if len(done.campaign.lines) <= _MOST:
        made.append(sections.cameras(done.campaign))
    for section in made:
        for block in () if section is None else section.blocks:
            if isinstance(block, Table):
                print_table(block, screen)
    if done.n_registered is not None:
        say(f"register: {done.n_registered} new of {counted(len(done.campaign.points), 'result')}", screen)
    for path in done.files:
        say(str(path), screen)
