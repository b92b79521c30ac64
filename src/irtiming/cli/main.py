"""The command line: one command per stage of the measurement.

Exit status: 0 done, 2 unusable input with one line on standard error that says what is, what must be and what to do, 130
stopped by Ctrl-C, 143 by SIGTERM.
"""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, redirect_stdout
from importlib import metadata
from typing import Annotated, NoReturn

import typer

from irtiming.cli.analyse_command import analyse
from irtiming.cli.apply_command import app as apply
from irtiming.cli.calibrate_wheel_command import calibrate_wheel
from irtiming.cli.camera_command import camera
from irtiming.cli.campaign_command import campaign
from irtiming.cli.certificate_command import certificate
from irtiming.cli.clock_command import clock
from irtiming.cli.convert_command import convert
from irtiming.cli.demo_command import demo
from irtiming.cli.discover_command import discover
from irtiming.cli.doctor_command import doctor
from irtiming.cli.explain_command import explain
from irtiming.cli.export_vcd_command import export_vcd
from irtiming.cli.gateware_command import app as gateware
from irtiming.cli.history_command import history
from irtiming.cli.import_capture_command import import_capture
from irtiming.cli.info_command import info
from irtiming.cli.interrupt import Interrupt, heeded, ignore, say_nothing, say_nothing_of_dropped
from irtiming.cli.latency_command import app as latency
from irtiming.cli.plan_command import plan
from irtiming.cli.record_command import record
from irtiming.cli.recover_command import recover
from irtiming.cli.rig_command import rig
from irtiming.cli.series_command import series
from irtiming.cli.serve_command import serve
from irtiming.cli.simulate_command import simulate
from irtiming.cli.verify_command import verify
from irtiming.errors import IrTimingError, one_line

app = typer.Typer(
    name="irtiming",
    help="Measure the timing of a thermal infrared camera with a chopper wheel and a blackbody.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)
COMMANDS = (
    discover, doctor, camera, plan, rig, record, recover, simulate, verify, calibrate_wheel, clock, analyse, series, campaign,
    history, explain, certificate, import_capture, export_vcd, info, convert, serve, demo,
)  # fmt: skip
for command in COMMANDS:
    app.command()(command)
app.add_typer(apply)
app.add_typer(latency)
app.add_typer(gateware)


@app.callback(invoke_without_command=True)
def irtiming(
    version: Annotated[bool, typer.Option("--version", is_eager=True, help="Print it and end.")] = False,
) -> None:
    """Measure the timing of a thermal infrared camera with a chopper wheel and a blackbody."""
    if version:
        print(f"irtiming {metadata.version('irtiming')}")  # noqa: T201
        raise typer.Exit


_STANDARD_OUTPUT = ("-", "/dev/stdout")
_OF_TYPER = 130  # what it makes of a KeyboardInterrupt, without a word


def run() -> None:
    """Run the command line; what the user can cure ends in one line and exit status 2."""
    interrupt = Interrupt()
    try:
        for number in heeded():
            signal.signal(number, interrupt)
        sys.unraisablehook = say_nothing_of_dropped
        with _words_aside(sys.argv[1:]):
            app()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # whoever read the output has enough of it
    except (IrTimingError, OSError) as error:
        notes = "".join(f" ({note})" for note in getattr(error, "__notes__", ()))
        _end(f"{error}{notes}", 2 if interrupt.heard is None else interrupt.exit_status)
    except MemoryError:
        _end("there is not enough memory for this; give fewer recordings at once, or free memory", 2)
    except (ImportError, SystemError):  # what a library makes of Ctrl-C that came while it was loaded
        if interrupt.number is None:
            raise
        _stop(interrupt)
    except KeyboardInterrupt:
        _stop(interrupt)
    except SystemExit as ending:
        if ending.code == _OF_TYPER:
            _stop(interrupt)
        raise
    finally:
        ignore()  # it is over; Ctrl-C would only disturb the last words


@contextmanager
def _words_aside(arguments: list[str]) -> Iterator[None]:
    """Where ``-`` is to be written, as in ``--json -``, the standard output is that alone, and words go to standard error."""
    asked = any(one.rpartition("=")[2] in _STANDARD_OUTPUT for one in arguments)
    with redirect_stdout(sys.stderr) if asked else nullcontext():
        yield


def _stop(interrupt: Interrupt) -> NoReturn:
    sys.unraisablehook = say_nothing  # objects that the signal left half made cannot be taken down in order
    _end("stopped; files not yet finished were removed or end in .part", interrupt.exit_status)


def _end(message: str, status: int) -> NoReturn:
    ignore()
    print(f"irtiming: {one_line(message)}", file=sys.stderr)  # noqa: T201
    sys.exit(status)
