"""Tables of the report in a terminal."""

from io import StringIO

import pytest
from rich.console import Console

from irtiming.cli.drawn_table import print_table
from irtiming.report.blocks import Table

POINTS = Table(
    title="2 results of a camera",
    columns=("result", "integration time", "time between frames", "internal delay set", "rows of the region",
             "trigger delay ± u", "exposure midpoint delay ± u"),
    align="lrrrrrr",
    rows=(
        ("cooled-3.00002Hz-0ms.nxs", "250 µs", "32.222 ms", "0 µs", "60", "325.1 ± 40.2 µs", "450 ± 40 µs"),
        ("cooled-3.00002Hz-0ms.nxs", "250 µs", "32.222 ms", "50 µs", "60", "382 ± 40 µs", "−0.056 ± 0.099 %"),
    ),
    note="What the results have in common cancels in their differences; it stands in the covariance of all of them together.",
)  # fmt: skip


def _printed(table: Table, width: int) -> str:
    screen = StringIO()
    print_table(table, Console(file=screen, width=width))
    return screen.getvalue()


@pytest.mark.parametrize("width", [60, 80, 100, 200])
def test_no_cell_of_numbers_and_no_word_of_a_head_is_broken(width):
    """Oracle: each cell as it was given stands in one line, and every word of a head whole; no line is longer than the screen."""
    text = _printed(POINTS, width)
    assert max(map(len, text.splitlines())) <= width
    assert all(cell in text for row in POINTS.rows for cell in row[1:])
    assert {word for head in POINTS.columns for word in head.split()} <= set(text.split())


def test_a_table_that_is_too_wide_goes_on_below_with_its_first_column():
    """Oracle: counted by hand; the title and the note stand once, and a wide screen has the table in one piece."""
    narrow, wide = _printed(POINTS, 80), _printed(POINTS, 200)
    assert (narrow.count("cooled-3"), wide.count("cooled-3")) == (4, 2)
    assert narrow.count("2 results of a camera") == narrow.count("What the results have in common") == 1
    assert "\nWhat the results have in common cancels in their differences; it stands in the" in narrow


def test_text_is_broken_between_words_and_not_before_a_unit():
    """Oracle: by hand; 9 letters hold '250 µs,' and '32.222 ms'."""
    table = Table(title="", columns=("setting", "what"), align="ll", rows=(("250 µs, 32.222 ms and more", "w" * 40),))
    lines = [line.split("   ")[0].strip() for line in _printed(table, 56).splitlines()]
    assert [line for line in lines if line][-3:] == ["250 µs,", "32.222 ms", "and more"]
