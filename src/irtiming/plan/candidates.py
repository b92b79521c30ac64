"""All trigger schemes within limits, counted without listing them, and listed best first.

A scheme is three integers (N, K, delta): T = N delta and C = K delta with N and K coprime. For a given N the
limits of T leave an interval of delta, those of C leave an interval of K, and for each coprime pair (N, K)
the delta that are left form one arithmetic progression, because T = N delta is a multiple of the S control
slots exactly if delta is a multiple of S / gcd(N, S). So a search visits some thousand pairs where T and C
alone would be some hundred million.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from heapq import heapify, heappop, heappush
from math import ceil, floor, gcd, lcm
from typing import NamedTuple, final

from irtiming.errors import PlanError
from irtiming.plan.sampling import nearest_ticks
from irtiming.records.trigger_plan import Wish, Wishes

MOST_PAIRS = 500_000
"""Pairs (N, K) that a search visits at most; wider limits are refused, never cut."""


class Span(NamedTuple):
    """Limits of a number of ticks or samples, and the value that is wanted; exact, both ends belong to it."""

    lowest: Fraction
    wanted: Fraction
    highest: Fraction

    @property
    def first(self) -> int:
        """Smallest whole number within."""
        return max(1, ceil(self.lowest))

    @property
    def last(self) -> int:
        """Largest whole number within; below `first` if there is none."""
        return floor(self.highest)


@final
@dataclass(frozen=True, kw_only=True)
class Limits:
    """Wishes for one wheel speed in ticks: T, C, N, control slots S and the longest N C (None: no limit)."""

    turn: Span
    camera: Span
    samples: Span
    control_slots: int
    longest_ticks: int | None


class Pair(NamedTuple):
    """Coprime N and K, and every delta that goes with them: ``first``, ``first + stride``, .. ``last``."""

    samples_per_turn: int
    samples_per_frame: int
    first: int
    last: int
    stride: int


class Candidate(NamedTuple):
    """One scheme; sorts by preference: used tolerance times a common scale, length of run, T, C; ticks."""

    scaled_tolerance: int
    run_ticks: int
    turn_ticks: int
    camera_ticks: int


def limits_in_ticks(wishes: Wishes, wheel_rate_hz: Wish) -> Limits:
    """Limits of T, C and N in ticks for one of the wheel speeds.

    Raises
    ------
    PlanError
        If the longest extra trigger delay alone takes more than the time between two corrections.
    """
    longest = None
    if wishes.longest_uninterrupted_s is not None:
        delay = max(nearest_ticks(time, wishes.clock_frequency_hz) for time in wishes.trigger_delays_s)
        longest = floor(wishes.longest_uninterrupted_s * wishes.clock_frequency_hz) - delay
        if longest < 1:
            raise PlanError(
                f"the trigger delay of {float(max(wishes.trigger_delays_s)):g} s does not fit into the "
                f"{float(wishes.longest_uninterrupted_s):g} s between two corrections; shorten it or "
                "correct less often"
            )
    samples = wishes.samples_per_turn
    return Limits(
        turn=_period(wheel_rate_hz, wishes.clock_frequency_hz),
        camera=_period(wishes.frame_rate_hz, wishes.clock_frequency_hz),
        samples=Span(samples.lowest, samples.wanted, samples.highest),
        control_slots=wishes.control_slots,
        longest_ticks=longest,
    )


def pairs(limits: Limits) -> Iterator[Pair]:
    """Every coprime (N, K) that leaves at least one delta within the limits.

    Raises
    ------
    PlanError
        If more than `MOST_PAIRS` would have to be visited.
    """
    visited = 0
    for samples in range(limits.samples.first, min(limits.samples.last, limits.turn.last) + 1):
        stride = limits.control_slots // gcd(samples, limits.control_slots)
        shortest = -(-limits.turn.first // samples)
        longest = limits.turn.last // samples
        visited += 1
        if shortest <= longest:
            frames = range(-(-limits.camera.first // longest), limits.camera.last // shortest + 1)
            visited += len(frames)
        if visited > MOST_PAIRS:
            raise PlanError(
                f"{limits.samples.first} .. {limits.samples.last} samples per turn leave more than "
                f"{MOST_PAIRS} pairs of T/delta and C/delta to look at; narrow the limits of samples or rates"
            )
        if shortest <= longest:
            for per_frame in frames:
                if gcd(samples, per_frame) == 1:
                    first = max(shortest, -(-limits.camera.first // per_frame))
                    last = min(longest, limits.camera.last // per_frame)
                    if limits.longest_ticks is not None:
                        last = min(last, limits.longest_ticks // (samples * per_frame))
                    first, last = -(-first // stride) * stride, last // stride * stride
                    if first <= last:
                        yield Pair(samples, per_frame, first, last, stride)


def count(limits: Limits) -> int:
    """Number of admissible schemes, exact; no scheme is listed for it.

    Raises
    ------
    PlanError
        If more than `MOST_PAIRS` pairs would have to be visited.
    """
    return sum((pair.last - pair.first) // pair.stride + 1 for pair in pairs(limits))


@final
class UsedTolerance:
    """How far a scheme is from the wishes: the used shares of the three tolerances, added.

    The share of T is 0 at the wanted turn and 1 at either limit, linear in between; so for C and N. Sums lie
    in [0, 3]. The numbers are integers in units of 1 / ``scale``.
    """

    def __init__(self, limits: Limits) -> None:
        lines = [_two_lines(span) for span in (limits.turn, limits.camera, limits.samples)]
        self.scale = lcm(*(number.denominator for vee in lines for line in vee for number in line))
        self._turn, self._camera, self._samples = (
            tuple((int(slope * self.scale), int(offset * self.scale)) for slope, offset in vee) for vee in lines
        )

    def of(self, pair: Pair, interval: int) -> Candidate:
        """The scheme with this pair and this delta, in ticks."""
        turn, camera = pair.samples_per_turn * interval, pair.samples_per_frame * interval
        used = sum(
            max(slope * value + offset for slope, offset in vee)
            for vee, value in (
                (self._turn, turn),
                (self._camera, camera),
                (self._samples, pair.samples_per_turn),
            )
        )
        return Candidate(used, pair.samples_per_turn * camera, turn, camera)


def turning_points(pair: Pair, limits: Limits) -> set[int]:
    """The delta of a pair next to the wanted turn and the wanted camera period: one is the pair's best."""
    points = set()
    for wanted in (limits.turn.wanted / pair.samples_per_turn, limits.camera.wanted / pair.samples_per_frame):
        below = floor(wanted / pair.stride) * pair.stride
        points |= {min(max(point, pair.first), pair.last) for point in (below, below + pair.stride)}
    return points


def best_first(limits: Limits) -> Iterator[Candidate]:
    """Every admissible scheme, the best first.

    Used tolerance is convex in delta, so each pair is followed outwards from its best delta in both
    directions, and a heap merges the pairs: the first schemes of an astronomical number cost no more than the
    number of pairs.

    Raises
    ------
    PlanError
        If more than `MOST_PAIRS` pairs would have to be visited.
    """
    used = UsedTolerance(limits)
    heap = []
    for pair in pairs(limits):
        best, start = min((used.of(pair, point), point) for point in turning_points(pair, limits))
        heap.append((best, start, 0, pair))
    heapify(heap)
    while heap:
        candidate, interval, direction, pair = heappop(heap)
        yield candidate
        for step in (-1, 1) if direction == 0 else (direction,):
            following = interval + step * pair.stride
            if pair.first <= following <= pair.last:
                heappush(heap, (used.of(pair, following), following, step, pair))


def without_uninterrupted_limit(limits: Limits) -> Limits:
    """The same limits, with all the time in the world between two corrections."""
    return replace(limits, longest_ticks=None)


def _period(rate_hz: Wish, clock_frequency_hz: int) -> Span:
    clock = Fraction(clock_frequency_hz)
    return Span(clock / rate_hz.highest, clock / rate_hz.wanted, clock / rate_hz.lowest)


def _two_lines(span: Span) -> tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]]:
    """Slope and offset of the share used below and above the wanted value; flat where there is no room."""
    lines = []
    for limit in (span.lowest, span.highest):
        room = limit - span.wanted
        slope = 1 / room if room else Fraction(0)
        lines.append((slope, -slope * span.wanted))
    return lines[0], lines[1]
