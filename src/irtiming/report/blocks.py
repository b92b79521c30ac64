"""What a page is made of: tables of plain text cells, for page and terminal alike, figures, and sections of both."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar, final

import numpy as np

from irtiming.report.language import t
from irtiming.report.rounding import significant

MS, US = 1e-3, 1e-6
MRAD, DEG = 1e-3, float(np.pi / 180)
_T = TypeVar("_T")


@final
@dataclass(frozen=True, kw_only=True)
class Table:
    """Title, head and rows of cells; ``align`` has one letter per column, l, c or r; ``note`` stands below."""

    title: str
    columns: tuple[str, ...]
    align: str
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def __post_init__(self) -> None:
        widths = {len(self.columns), len(self.align), *(len(row) for row in self.rows)}
        if len(widths) != 1:
            raise ValueError(
                f"table '{self.title}' has rows of {sorted(widths)} cells; all must have as many as its head"
            )


@final
@dataclass(frozen=True, kw_only=True)
class Panel:
    """A figure as SVG text that stands alone, its title and its caption."""

    title: str
    caption: str
    svg: str


@final
@dataclass(frozen=True, kw_only=True)
class Section:
    """Part of the page: tables and figures under one heading."""

    title: str
    blocks: tuple[Table | Panel, ...]


def of_tables(*tables: Table) -> tuple[Table, ...]:
    """Those that have rows."""
    return tuple(table for table in tables if table.rows)


def micro(value_s: float) -> str:
    """An uncertainty in µs without its unit; a dash for none."""
    return "–" if not np.isfinite(value_s) or value_s <= 0 else significant(value_s / US)


def common(items: Iterable[_T], text: Callable[[_T], str]) -> str:
    """What the items have in common, or the first, the last and how many differ."""
    texts = list(dict.fromkeys(text(item) for item in items))
    if len(texts) == 1:
        return texts[0]
    return t("{first} … {last} ({n} different)", first=texts[0], last=texts[-1], n=len(texts))
