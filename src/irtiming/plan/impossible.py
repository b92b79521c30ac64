"""Wishes that no trigger scheme meets: which constraint fails, and the nearest wish that works."""

from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, floor
from typing import Literal, final

from irtiming.errors import PlanError
from irtiming.plan.candidates import (
    Candidate,
    Limits,
    Span,
    UsedTolerance,
    pairs,
    turning_points,
    without_uninterrupted_limit,
)
from irtiming.plan.wishes import as_text

_Wish = Literal["turn", "camera", "samples"]
_ALL: tuple[_Wish, ...] = ("samples", "turn", "camera")
_WIDENINGS = (Fraction(1, 10), Fraction(1, 2), Fraction(9, 10), Fraction(15))
"""How far, relative to what is wanted, a wish is let go in search of one that works."""


@final
@dataclass(frozen=True, kw_only=True)
class _Nearest:
    distance: Fraction
    scheme: Candidate
    changed: tuple[_Wish, ...]


def complaint(limits: Limits, clock_frequency_hz: int) -> str:
    """One line on limits that admit no scheme: what was wished, which constraint fails, what would work.

    Parameters
    ----------
    limits
        Limits in ticks that admit no scheme.
    clock_frequency_hz
        To speak of rates instead of periods; Hz.
    """
    wished = (
        f"no trigger scheme has a wheel rate of {_rates(limits.turn, clock_frequency_hz)}, a frame rate of "
        f"{_rates(limits.camera, clock_frequency_hz)} and {_samples(limits.samples)} samples per turn"
    )
    free = without_uninterrupted_limit(limits)
    shortest = min((pair.samples_per_turn * pair.samples_per_frame * pair.first for pair in pairs(free)), default=None)
    if shortest is not None and limits.longest_ticks is not None:
        return wished + _too_long(shortest, limits.longest_ticks, clock_frequency_hz)
    return f"{wished}: {_reason(free, clock_frequency_hz)}; {_cure(limits, clock_frequency_hz)}"


def _too_long(shortest_ticks: int, longest_ticks: int, clock_frequency_hz: int) -> str:
    needed = Fraction(ceil(Fraction(shortest_ticks, clock_frequency_hz) * 10**6), 10**6)
    left = Fraction(floor(Fraction(longest_ticks, clock_frequency_hz) * 10**6), 10**6)
    missing = Fraction(ceil(Fraction(shortest_ticks - longest_ticks, clock_frequency_hz) * 10**6), 10**6)
    return (
        f" and fits between two non-uniformity corrections: the shortest run lasts {as_text(needed)} s, but "
        f"{as_text(left)} s are left; leave {as_text(missing)} s more or ask for fewer samples per turn"
    )


def _reason(limits: Limits, clock_frequency_hz: int) -> str:
    """The first constraint, in the order of dependence, that nothing satisfies."""
    turn, camera, samples, slots = limits.turn, limits.camera, limits.samples, limits.control_slots
    if turn.last < slots:
        return (
            f"T would be shorter than one tick for each of {slots} control slots, so that the wheel can turn "
            f"at {as_text(Fraction(clock_frequency_hz, slots))} Hz at most"
        )
    if turn.last // slots * slots < turn.first:
        return f"no T within {_ends(turn)} ticks is a multiple of the {slots} control slots"
    if camera.last < camera.first:
        return f"no whole C lies within {_ends(camera)} ticks"
    if samples.last < samples.first:
        return f"no whole number of samples lies within {_ends(samples)}"
    if turn.last < samples.first:
        return f"a turn has only {turn.last} ticks, and cannot have more samples"
    if next(pairs(replace(limits, control_slots=1)), None) is not None:
        return f"T would have to be no multiple of the {slots} control slots"
    low, high = camera.lowest / turn.highest, camera.highest / turn.lowest
    numbers = range(samples.first, min(samples.last, turn.last) + 1)
    if not any(ceil(number * low) <= floor(number * high) for number in numbers):
        return (
            f"C/delta would be {_decimal(numbers[0] * low)} .. {_decimal(numbers[-1] * high)} samples per "
            "frame and never a whole number"
        )
    return "T/delta and C/delta would share a factor, so that samples are left out, or delta would not be whole"


def _cure(limits: Limits, clock_frequency_hz: int) -> str:
    """The nearest wish that works: one wish changed if one suffices, an exact one only if no other does."""
    exact = tuple(name for name in _ALL if _span(limits, name).lowest == _span(limits, name).highest)
    loose = tuple(name for name in _ALL if name not in exact)
    for changes in ([(name,) for name in loose], [(name,) for name in exact], [loose], [_ALL]):
        found = [near for names in changes if names and (near := _nearest(limits, names)) is not None]
        if found:
            near = min(found, key=lambda each: (each.distance, each.scheme))
            return f"the nearest that works is {_describe(near, clock_frequency_hz)}"
    return "and no wish near it works either, so widen several limits at once"


def _nearest(limits: Limits, names: tuple[_Wish, ...]) -> _Nearest | None:
    for widening in _WIDENINGS:
        wider = limits
        for name in names:
            span = _span(limits, name)
            wide = Span(
                min(span.lowest, max(Fraction(1), span.wanted * (1 - widening))),
                span.wanted,
                max(span.highest, span.wanted * (1 + widening)),
            )
            wider = _with_span(wider, name, wide)
        try:
            found = _closest(wider, limits, names)
        except PlanError:  # too many pairs to look at: no advice from here
            return None
        if found is not None:
            return found
    return None


def _closest(wider: Limits, limits: Limits, names: tuple[_Wish, ...]) -> _Nearest | None:
    used = UsedTolerance(wider)
    best = None
    for pair in pairs(wider):
        for interval in turning_points(pair, wider):
            scheme = used.of(pair, interval)
            values = {
                "turn": scheme.turn_ticks,
                "camera": scheme.camera_ticks,
                "samples": pair.samples_per_turn,
            }
            wanted = {name: _span(limits, name).wanted for name in names}
            distance = sum((abs(values[name] / wanted[name] - 1) for name in names), Fraction(0))
            if best is None or (distance, scheme) < (best.distance, best.scheme):
                best = _Nearest(distance=distance, scheme=scheme, changed=names)
    return best


def _describe(near: _Nearest, clock_frequency_hz: int) -> str:
    turn, camera = near.scheme.turn_ticks, near.scheme.camera_ticks
    texts = {
        "turn": f"a wheel rate of {_exact_rate(turn, clock_frequency_hz)}",
        "camera": f"a frame rate of {_exact_rate(camera, clock_frequency_hz)}",
        "samples": f"{near.scheme.run_ticks // camera} samples per turn",
    }
    rest = f"(T = {turn}, C = {camera} ticks)"
    return f"{' and '.join(texts[name] for name in near.changed)} {rest}"


def _span(limits: Limits, name: _Wish) -> Span:
    return {"turn": limits.turn, "camera": limits.camera, "samples": limits.samples}[name]


def _with_span(limits: Limits, name: _Wish, span: Span) -> Limits:
    if name == "turn":
        return replace(limits, turn=span)
    return replace(limits, camera=span) if name == "camera" else replace(limits, samples=span)


def _exact_rate(ticks: int, clock_frequency_hz: int) -> str:
    rate = Fraction(clock_frequency_hz, ticks)
    text = as_text(rate)
    return f"{text} Hz" if "/" not in text else f"{text} Hz ({float(rate):.6g})"


def _rates(span: Span, clock_frequency_hz: int) -> str:
    if span.lowest == span.highest:
        return f"exactly {as_text(clock_frequency_hz / span.wanted)} Hz"
    return f"{_decimal(clock_frequency_hz / span.highest)} .. {_decimal(clock_frequency_hz / span.lowest)} Hz"


def _samples(span: Span) -> str:
    if span.last < span.first:
        return _ends(span)
    return f"{span.first} .. {span.last}" if span.first < span.last else f"{span.first}"


def _ends(span: Span) -> str:
    low, high = _decimal(span.lowest), _decimal(span.highest)
    return f"{low} .. {high}" if low != high else low


def _decimal(number: Fraction) -> str:
    return f"{float(number):.10g}"
