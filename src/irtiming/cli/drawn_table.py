"""Tables of the report in the terminal: no number is broken there; a table that is wider goes on below, with its first column.

Text is broken between words, a heading too, but not between a number and its unit. A word of more than `_LONGEST` letters may be.
"""

import re
import textwrap
from collections.abc import Sequence
from dataclasses import replace

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table as RichTable

from irtiming.report.blocks import Table

_SHORT = 24  # letters of a column whose cells stay in one line
_LONGEST = 40
_ALIGN = {"l": "left", "c": "center", "r": "right"}
_WITHIN = re.compile(r"(?<=\d) (?=\S{1,3}(?:[\s,;)]|$))|(?<=±) | (?=±)")  # number and unit, value and u
_STAYS = "\N{NO-BREAK SPACE}"


def print_table(table: Table, console: Console) -> None:
    """One table of the report, with its note beneath.

    Parameters
    ----------
    table
        Of cells that may be longer than a line.
    console
        Whose width decides where they are broken.
    """
    first, *others = _parts(table, console.width)
    console.print(_drawn(first if not others else replace(first, note=""), console.width))
    for other in others:
        console.print(_drawn(replace(other, title="", note=""), console.width))
    if others and table.note:
        console.print(table.note, markup=False, highlight=False)


def _drawn(table: Table, width: int) -> RichTable:
    drawn = RichTable(title=table.title or None, title_justify="left", box=box.SIMPLE_HEAD, caption=table.note or None)
    drawn.caption_justify = "left"
    widths: Sequence[int | None] = _widths(table, width) or [None] * len(table.columns)
    for column, align, letters in zip(table.columns, table.align, widths, strict=True):
        drawn.add_column(_wrapped(column, letters), justify=_ALIGN[align], overflow="fold", width=letters)  # type: ignore[arg-type]
    for row in table.rows:
        drawn.add_row(*(escape(_wrapped(cell, letters)) for cell, letters in zip(row, widths, strict=True)))
    return drawn


def _parts(table: Table, width: int) -> list[Table]:
    """The table, or several with its first column each, of as many further columns as there is room for."""
    n = len(table.columns)
    fitting = next((k for k in range(n, 2, -1) if _widths(_picked(table, range(k)), width)), 2)
    if fitting >= n:
        return [table]
    rest = _picked(table, [0, *range(fitting, n)])
    return [_picked(table, range(fitting)), *_parts(rest, width)]


def _picked(table: Table, columns: range | list[int]) -> Table:
    rows = tuple(tuple(row[k] for k in columns) for row in table.rows)
    heads, align = tuple(table.columns[k] for k in columns), "".join(table.align[k] for k in columns)
    return replace(table, columns=heads, align=align, rows=rows)


def _widths(table: Table, width: int) -> list[int] | None:
    """Letters of each column, the widest narrowed until all have room; None where they have none.

    Numbers stay whole; short text does, but for the last column, as long as all have room.
    """
    cells = [[row[k] for row in table.rows] for k in range(len(table.columns))]
    whole = [max(map(len, column), default=0) for column in cells]
    words = [min(_LONGEST, _longest_word(column)) for column in cells]
    least = [line if align == "r" else word for line, word, align in zip(whole, words, table.align, strict=True)]
    lines = [line if line <= _SHORT else word for line, word in zip(whole[:-1], least[:-1], strict=True)]
    heads = [_longest_word([head]) for head in table.columns]
    found = [max(map(len, (head, *column))) for head, column in zip(table.columns, cells, strict=True)]
    room = width - 3 * len(found) - 1
    options = (_narrowed(found, list(map(max, each, heads)), room=room) for each in ([*lines, least[-1]], least))
    return next(filter(None, options), None)


def _narrowed(letters: Sequence[int], least: Sequence[int], *, room: int) -> list[int] | None:
    found = list(letters)
    while sum(found) > room:
        wide = [k for k, many in enumerate(found) if many > least[k]]
        if not wide:
            return None
        found[max(wide, key=found.__getitem__)] -= 1
    return found


def _longest_word(texts: Sequence[str]) -> int:
    return max((len(word) for text in texts for word in _WITHIN.sub(_STAYS, text).split(" ")), default=0)


def _wrapped(text: str, letters: int | None) -> str:
    """The text in lines of so many letters."""
    if letters is None:
        return text
    return "\n".join(textwrap.wrap(_WITHIN.sub(_STAYS, text), letters, break_on_hyphens=False)).replace(_STAYS, " ")
