"""Results in the terminal: the report's tables, drawn with Rich."""

from dataclasses import replace

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table as RichTable

from irtiming.measurement import Analysis, RollingAnalysis
from irtiming.records.two_constants import TwoConstantsResult
from irtiming.report import certificate, rolling_tables, tables, two_constant_tables
from irtiming.report.tables import Table

_ALIGN = {"l": "left", "c": "center", "r": "right"}


def print_result(analysis: Analysis | RollingAnalysis, console: Console) -> None:
    """Verdict and warnings first, then the parameters, the relative delays and the budget."""
    console.print(f"[bold]{escape(certificate.verdict(analysis).sentence)}[/bold]")
    for text in analysis.warnings:
        console.print(f"[yellow]warning:[/yellow] {escape(text)}", highlight=False)
    if isinstance(analysis, RollingAnalysis):
        separate = _separate(analysis.two_constants)
        shown: tuple[Table, ...] = (
            _short(rolling_tables.parameters(analysis)), *separate, rolling_tables.relative_delays(analysis),
        )  # fmt: skip
        budget = rolling_tables.budget(analysis)
    else:
        shown = (_without(tables.parameters(analysis), "k"), _ours(tables.relative_delays(analysis)))
        budget = tables.budget(analysis)
    for table in (*shown, budget):
        if table.rows:
            print_table(table, console)


def print_demonstration(analysis: Analysis | RollingAnalysis, truth_s: dict[str, float], *, console: Console) -> None:
    """What was found of a simulated camera, beside the paper's Table 1 and the truth."""
    if isinstance(analysis, RollingAnalysis):
        print_table(rolling_tables.beside_the_truth(analysis, truth_s), console)
    else:
        _print_demo(analysis, truth_s["trigger_delay"], console)


def _print_demo(analysis: Analysis, truth_s: float, console: Console) -> None:
    """Our deviations by both methods beside the paper's Table 1, and the absolute delay beside the truth."""
    print_table(tables.beside_the_paper(analysis), console)
    console.print(
        f"true trigger delay of the simulated camera ({tables.REFERENCE_EVENTS['trigger_delay']}; {tables.SIGN}): "
        f"{1e6 * truth_s:.2f} µs",
        highlight=False,
    )
    for words, result in (("pixel sums", analysis.best), ("as published", analysis.as_published)):
        k = result.estimate.names.index("trigger_delay")
        value, u = result.estimate.values[k], result.estimate.standard_uncertainties[k]
        console.print(
            f"  {words + ':':<14}{1e6 * value:8.2f} ± {1e6 * u:.2f} µs, off by {1e6 * (value - truth_s):+.2f} µs = "
            f"{(value - truth_s) / u:+.1f} u",
            highlight=False,
        )


def _separate(found: TwoConstantsResult | None) -> tuple[Table, ...]:
    """Constants of substrate and scene, where somebody asked for them; without the columns that a terminal has no room for."""
    if found is None:
        return ()
    table = two_constant_tables.constants(found)
    rows = tuple(row[:3] for row in table.rows)
    return (replace(table, columns=table.columns[:3], align=table.align[:3], rows=rows),)


def _short(table: Table) -> Table:
    """With the signs in the note: a terminal has no room for their column."""
    rows = tuple(row[:-1] for row in table.rows)
    signs = " ".join(f"{row[0]}: {row[-1]}." for row in table.rows)
    return replace(
        table, columns=table.columns[:-1], align=table.align[:-1], rows=rows, note=f"{table.note} Signs: {signs}"
    )


def _without(table: Table, column: str) -> Table:
    """Without a column that a terminal has no room for."""
    keep = [k for k, name in enumerate(table.columns) if name != column]
    rows = tuple(tuple(row[k] for k in keep) for row in table.rows)
    return replace(
        table, columns=tuple(table.columns[k] for k in keep), align="".join(table.align[k] for k in keep), rows=rows
    )


def _ours(table: Table) -> Table:
    """Table 1 without the paper's columns, which a terminal has no room for, and its delays that were not measured."""
    rows = tuple(row[:5] for row in table.rows if row[1] != "–")
    return replace(table, columns=table.columns[:5], align=table.align[:5], rows=rows, note=tables.RELATIVE_NOTE)


def print_table(table: Table, console: Console) -> None:
    """One table of the report, with its note beneath."""
    drawn = RichTable(title=table.title, title_justify="left", box=box.SIMPLE_HEAD, caption=table.note or None)
    drawn.caption_justify = "left"
    for column, align in zip(table.columns, table.align, strict=True):
        drawn.add_column(column, justify=_ALIGN[align], overflow="fold")  # type: ignore[arg-type]
    for row in table.rows:
        drawn.add_row(*(escape(cell) for cell in row))
    console.print(drawn)
