"""Number the edges of one light gate: find the missing, the doubled and the spurious ones."""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.records.arrays import Ticks
from irtiming.records.finding import Finding
from irtiming.units import counted

_LOCK = 8  # edges in a row that must be regular before the numbering starts
_SHARE_LIMIT = 0.02  # of the edges may be missing or spurious; beyond, the gate or its wiring is at fault


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeTrain:
    """Edges that fit the rhythm of the wheel.

    ``number`` counts the openings of the ring that passed since the first kept edge: a step of 2 is a missing edge.
    Shapes (n_edge,).
    """

    ticks: Ticks
    number: Ticks
    n_missing: int
    n_spurious: int

    def findings(self, name: str, *, recording: str) -> tuple[Finding, ...]:
        """What is odd about this gate of a recording; empty when every edge was in its place."""
        if not self.n_missing and not self.n_spurious:
            return ()
        what = (
            f"{name}: {counted(self.n_missing, 'edge')} missing (bridged by interpolation), "
            f"{self.n_spurious} doubled or spurious (dropped), of {self.ticks.size}"
        )
        return (Finding(code="edges-out-of-place", severity="warning", recording=recording, what=what),)


def number_edges(edge_ticks: Ticks, *, period_ticks: float, name: str, tolerance: float = 0.25) -> EdgeTrain:
    """Number the edges of a ring that passes a gate about every ``period_ticks``.

    Parameters
    ----------
    edge_ticks
        Shape (n,), ticks, in order of arrival.
    period_ticks
        Nominal distance between edges, from the rotation speed.
    name
        Of the channel, for messages.
    tolerance
        Largest deviation of an edge from its expected place, as a share of the period.

    Raises
    ------
    ReductionError
        If the edges run backwards, are too few, come at another rhythm than the rotation speed says, or more than 2 %
        of them are missing or spurious.
    """
    if edge_ticks.size < _LOCK:
        raise ReductionError(
            f"{name} holds {edge_ticks.size} edges, at least {_LOCK} are needed; "
            "check that the light gate is connected and the wheel turns"
        )
    steps = np.diff(edge_ticks)
    if np.any(steps < 0):
        at = int(np.argmax(steps < 0))
        raise ReductionError(
            f"{name} runs backwards after edge {at} ({edge_ticks[at]} -> {edge_ticks[at + 1]} ticks); timestamps must "
            "be values of one unwrapped counter in order of arrival"
        )
    regular = np.abs(steps / period_ticks - 1) < tolerance
    if regular.all():
        return EdgeTrain(ticks=edge_ticks, number=np.arange(edge_ticks.size), n_missing=0, n_spurious=0)
    seed = _first_run(regular, _LOCK - 1)
    if seed is None:
        raise ReductionError(_no_rhythm(steps, period_ticks, tolerance=tolerance, name=name))
    seed += _LOCK // 2  # an end of the run may be one of a doubled pair; its middle is not
    period = float(np.median(steps[regular]))
    ahead = _follow(edge_ticks[seed:], period, tolerance, name=name)
    behind = _follow(-edge_ticks[seed::-1], period, tolerance, name=name)
    numbers = {seed - i: -n for i, n in behind.items()} | {seed + i: n for i, n in ahead.items()}
    kept = np.array(sorted(numbers))
    number = np.array([numbers[i] for i in kept])
    train = EdgeTrain(
        ticks=edge_ticks[kept],
        number=number - number[0],
        n_missing=int(number[-1] - number[0] + 1 - kept.size),
        n_spurious=int(edge_ticks.size - kept.size),
    )
    _refuse_ruins(train, edge_ticks.size, name)
    return train


def _no_rhythm(steps: Ticks, period_ticks: float, *, tolerance: float, name: str) -> str:
    """Why edges that are ``steps`` (n - 1,) apart have no regular run, and what to do."""
    usual = float(np.median(steps))
    cure = (
        f"edges are missing, doubled or spurious among the {steps.size + 1} there are: check the light gate, its cable and "
        "threshold, and record longer"
        if abs(usual / period_ticks - 1) < tolerance
        else "correct rotation_speed or check the wheel's lock"
    )
    return (
        f"{name} comes every {usual:.0f} ticks (median) with no {_LOCK} regular edges in a row, the rotation speed asks for "
        f"{period_ticks:.0f}; {cure}"
    )


def _first_run(flags: np.ndarray, length: int) -> int | None:
    """Index of the first ``length`` true flags in a row."""
    runs = np.convolve(flags.astype(int), np.ones(length, int), "valid")
    found = np.flatnonzero(runs == length)
    return int(found[0]) if found.size else None


def _follow(ticks: Ticks, period: float, tolerance: float, *, name: str) -> dict[int, int]:
    """Index -> number of the edges that keep the rhythm, following it from the first edge on.

    A last few edges that do not fit are spurious; more of them mean that the rhythm is lost.
    """
    numbers, at, i = {0: 0}, 0, 0
    while True:
        since = ticks[i + 1 : i + _LOCK] - ticks[i]
        turns = np.rint(since / period)
        miss = np.abs(since / period - turns)
        candidates = np.flatnonzero((turns >= 1) & (miss < tolerance))
        if candidates.size == 0:
            if since.size < _LOCK - 1:
                return numbers
            raise ReductionError(
                f"{name} loses its rhythm after tick {abs(int(ticks[i]))}: the next edges come after "
                f"{', '.join(f'{s / period:.2f}' for s in since)} periods; check the light gate and the wheel's lock"
            )
        nearest = turns == turns[candidates[0]]
        best = int(np.argmin(np.where(nearest, miss, np.inf)))
        step = int(turns[best])
        period += 0.1 * (float(since[best]) / step - period)
        i, at = i + 1 + best, at + step
        numbers[i] = at


def _refuse_ruins(train: EdgeTrain, n_edges: int, name: str) -> None:
    wrong = train.n_missing + train.n_spurious
    if wrong > max(3, _SHARE_LIMIT * n_edges):
        raise ReductionError(
            f"{name}: {counted(train.n_missing, 'edge')} missing and {train.n_spurious} doubled or spurious of {n_edges}, "
            f"at most {_SHARE_LIMIT:.0%} can be repaired; check the light gate, its cable and threshold, and record again"
        )
