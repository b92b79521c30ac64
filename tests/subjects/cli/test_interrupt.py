"""Ctrl-C or SIGTERM that a library drops: it is raised again where the work next tells how far it is."""

import io
import signal
import sys
from contextlib import suppress

import pytest
from rich.console import Console

from irtiming.cli import main
from irtiming.cli.interrupt import SIGNALS, Interrupt, heeded, ignore, raise_dropped, say_nothing_of_dropped
from irtiming.cli.progress import shown


@pytest.fixture
def handled():
    handler = Interrupt()
    before = {number: signal.signal(number, handler) for number in SIGNALS}
    yield handler
    for number, earlier in before.items():
        signal.signal(number, earlier)


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("is_terminal", [False, True])
def test_what_was_dropped_is_raised_at_the_next_report(handled, is_terminal, number):
    """Oracle: a library that swallows what is raised within it, as numba does where it loads a kernel."""
    console = Console(file=io.StringIO(), force_terminal=is_terminal)
    with pytest.raises(KeyboardInterrupt), shown("frames", console) as told:  # noqa: PT012 - what comes before must pass
        told("run", 1, 3)
        with suppress(KeyboardInterrupt):
            signal.raise_signal(number)
        told("run", 2, 3)
    assert handled.exit_status == {signal.SIGINT: 130, signal.SIGTERM: 143}[number]


def test_nothing_is_raised_where_nothing_was_pressed_or_another_handler_is_set(handled):
    """Oracle: by hand."""
    raise_dropped()
    with pytest.raises(KeyboardInterrupt):
        handled(signal.SIGINT, None)
    ignore()
    assert not heeded()
    raise_dropped()


def test_what_python_itself_drops_is_remembered_without_a_word(handled, capsys, monkeypatch):
    """Oracle: a destructor in which Ctrl-C is pressed, whose exception Python drops and would print; another is printed still."""

    class Mortal:
        def __init__(self, act):
            self.act = act

        def __del__(self):
            self.act()

    monkeypatch.setattr(sys, "unraisablehook", say_nothing_of_dropped)
    Mortal(lambda: signal.raise_signal(signal.SIGINT))
    assert capsys.readouterr().err == ""
    with pytest.raises(KeyboardInterrupt):
        raise_dropped()
    Mortal(lambda: 1 / 0)
    assert "ZeroDivisionError" in capsys.readouterr().err


def test_what_a_library_makes_of_it_while_it_is_loaded_is_no_traceback(handled, capsys, monkeypatch):
    """Oracle: the documented exit status; an extension of SciPy raises an ImportError for what is raised while it begins."""

    def loading():
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise ImportError("initialization failed") from None

    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    monkeypatch.setattr(main, "app", loading)
    with pytest.raises(SystemExit) as ending:
        main.run()
    assert ending.value.code == 130
    assert capsys.readouterr().err.startswith("irtiming: stopped")


def test_what_a_stopped_program_left_half_made_says_nothing_at_its_end(handled, capsys, monkeypatch):
    """Oracle: the one line of an ending; a destructor that fails is what Ctrl-C leaves of an object that was being made."""

    class HalfMade:
        def __del__(self):
            self.never_set.close()

    left = [HalfMade()]

    def stopped():
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    monkeypatch.setattr(main, "app", stopped)
    with pytest.raises(SystemExit) as ending:
        main.run()
    left.clear()
    said = capsys.readouterr().err
    assert ending.value.code == 130
    assert said.startswith("irtiming: stopped")
    assert said.count("\n") == 1


def test_a_library_that_cannot_be_loaded_is_no_interrupt(handled, monkeypatch):
    """Oracle: the error of the library itself, without any signal."""

    def loading():
        raise ImportError("no such file")

    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    monkeypatch.setattr(main, "app", loading)
    with pytest.raises(ImportError, match="no such file"):
        main.run()
