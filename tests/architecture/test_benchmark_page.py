"""The figures that ``make bench`` keeps: picked out of what the benchmarks print, and shown on the page."""

import json
import re
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "reference" / "benchmarks.md"


@pytest.fixture(scope="module")
def bench():
    """The script, which has no ending by which Python would know it."""
    loader = SourceFileLoader("bench", str(ROOT / "scripts" / "bench"))
    module = module_from_spec(spec_from_loader("bench", loader))
    loader.exec_module(module)
    return module


def _line(day, value, *, load=0.1, machine="A"):
    where = {"processor": machine, "cores": 2, "memory_gib": 8, "python": "3.11"}
    one = {"figures": {"counting against plain NumPy": value}, "seconds": 1.0, "load": [load, 0.0]}
    return {
        "date": f"2026-01-{day:02}T00:00:00",
        "commit": f"c{day}",
        "machine": where,
        "form": "short",
        "benchmarks": {"counting": one},
    }


def test_figures_are_those_that_a_benchmark_prints(bench):
    """Oracle: by hand; the last lines of benchmarks/counting.py, of two sizes."""
    text = (
        "our count           1.00 GB/s   10.0% of the read bandwidth\n"
        "our count          12.34 GB/s   81.5% of the read bandwidth\n"
        "correct-and-count   1.30 GB/s   ours is 9.5 times faster\n"
    )
    found = bench.figures_in(text, bench.BENCHMARKS["counting"])
    assert found == {"counting against memory bandwidth": 81.5, "counting against plain NumPy": 9.5}
    assert bench.figures_in("Traceback", bench.BENCHMARKS["counting"]) == {}


def test_every_benchmark_is_there_and_may_be_asked_for_so(bench):
    """Oracle: the files; each option that is passed is one of the file's, and each figure has a name of its own."""
    names = [name for one in bench.BENCHMARKS.values() for name, _, _ in one.figures]
    assert len(set(names)) == len(names)
    for one in bench.BENCHMARKS.values():
        text = (ROOT / "benchmarks" / one.path).read_text()
        for word in (*one.short, *one.long):
            if word.startswith("--"):
                name = re.escape(word[2:])
                assert re.search(rf'"(--)?{name}"', text), f"{one.path}: {word}"


def test_the_page_shows_the_newest_and_what_was_before_by_machine(bench):
    """Oracle: by hand."""
    page = bench.page([_line(1, 9.0), _line(2, 9.5, load=1.7), _line(3, 4.0, machine="B")])
    assert "## A, 2 cores, 8 GiB: short form" in page
    assert "| counting against plain NumPy | 9.5 | times | 1.7 | c2 | 2026-01-02 | 9 |" in page
    assert "| counting against plain NumPy | 4 | times | 0.1 | c3 | 2026-01-03 |  |" in page


def test_the_page_is_that_of_the_history(bench):
    """Oracle: the history; if this fails, run scripts/bench --page."""
    assert PAGE.read_text() == bench.page(map(json.loads, bench.HISTORY.read_text().splitlines()))
