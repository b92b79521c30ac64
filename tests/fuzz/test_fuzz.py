"""Hostile inputs, eight seconds of them over all parts of the program that take any; an hour of them by ``make fuzz``."""

import pytest
from fuzzer import fuzz, input_of
from targets import TARGETS


def test_only_our_own_errors_come_out() -> None:
    """Oracle: the class of whatever is raised; the system's word on time, memory and crashes of another process."""
    report = fuzz(seconds=8, seed=20261123, most_each=1000)
    assert report.finds == []
    assert set(report.n_inputs) == set(TARGETS)
    assert report.n_inputs.total() > 5 * len(TARGETS)


@pytest.mark.parametrize("target", TARGETS)
def test_the_seeds_themselves_are_taken(target: str) -> None:
    """Oracle: what is not refused at all exercises the parts behind the door; every seed is one that the program takes."""
    TARGETS[target].take(TARGETS[target].seeds()[0])


def test_inputs_are_the_same_for_the_same_seed() -> None:
    """Oracle: a find must be there again."""
    for target in ("recording", "result.json", "GigE Vision"):
        assert input_of(target, 50, 3) == input_of(target, 50, 3) != input_of(target, 50, 4)
