"""Results in the terminal, by the report's tables."""

from dataclasses import replace
from functools import partial

from rich.console import Console
from rich.markup import escape

from irtiming.cli.drawn_table import print_table
from irtiming.records.analysis import Analysis
from irtiming.records.frame_events import FrameEvent
from irtiming.report import event_words
from irtiming.report.blocks import Table, of_tables
from irtiming.report.meanings import METHOD_NAMES, SIGN, has_pixel_sums
from irtiming.report.meanings import event as event_text
from irtiming.report.result import doubts
from irtiming.report.sections import parameters, relative_delays, two_constants, uncertainty
from irtiming.report.verdict import verdict

_STYLES = {"error": "bold red", "doubt": "bold magenta", "warning": "yellow"}


def print_result(analysis: Analysis, console: Console) -> None:
    """Verdict, doubts and warnings first, then the parameters, the relative delays and the budget."""
    event = event_words.event_of(analysis)
    console.print(f"[bold]{escape(event_words.text(verdict(analysis).sentence, event))}[/bold]")
    for one in doubts(analysis):
        text = escape(event_words.text(one.sentence(), event))
        console.print(f"[{_STYLES[one.severity]}]{one.severity}:[/] {text}", highlight=False)
    separate = [] if analysis.two_constants is None else [_first(two_constants.constants(analysis.two_constants), 3)]
    delays = _first(relative_delays.combined_delays(analysis), 5)
    ours = replace(delays, rows=tuple(row for row in delays.rows if row[1] != "–"), note=relative_delays.note(analysis))
    whole = uncertainty.budget(analysis)
    budget = _first(whole, len(whole.columns) - 2)
    for table in of_tables(parameters.parameters(analysis), *separate, ours, budget):
        print_table(_worded(table, event), console)


def _worded(table: Table, event: FrameEvent) -> Table:
    """The same with the event's own words."""
    worded = partial(event_words.text, event=event)
    return replace(
        table,
        title=worded(table.title),
        columns=tuple(map(worded, table.columns)),
        rows=tuple(tuple(map(worded, row)) for row in table.rows),
        note=worded(table.note),
    )


def print_demonstration(analysis: Analysis, truth_s: dict[str, float], *, console: Console) -> None:
    """What was found of a simulated camera beside the truth, and beside the paper's Table 1 where it is one like the paper's."""
    if not has_pixel_sums(analysis):
        print_table(parameters.beside_the_truth(analysis, truth_s), console)
        return
    true = truth_s["trigger_delay"]
    print_table(relative_delays.beside_the_paper(analysis), console)
    what = f"{event_text('trigger_delay', analysis)}; {SIGN}"
    console.print(f"true trigger delay of the simulated camera ({what}): {1e6 * true:.2f} µs", highlight=False)
    for result in relative_delays.results(analysis):
        value, u = parameters.entries(result)["trigger_delay"]
        console.print(
            f"  {METHOD_NAMES[result.method].split(' (')[0] + ':':<14}{1e6 * value:8.2f} ± {1e6 * u:.2f} µs, off by "
            f"{1e6 * (value - true):+.2f} µs = {(value - true) / u:+.1f} u",
            highlight=False,
        )


def _first(table: Table, n: int) -> Table:
    """The first columns: a terminal has no room for more."""
    rows = tuple(row[:n] for row in table.rows)
    note = table.note.partition(" Sensitivity:")[0]  # of a column that is left out
    return replace(table, columns=table.columns[:n], align=table.align[:n], rows=rows, note=note)
