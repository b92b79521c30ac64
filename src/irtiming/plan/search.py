"""From wishes to every admissible trigger scheme, ranked, best first.

**Admissible** is a scheme, integers T and C in ticks of the clock, if

1. f / T lies within the limits of the wheel rate and T is a multiple of the control slots, so that T' is
whole;
2. f / C lies within the limits of the frame rate: those of the camera; an exact frame rate leaves one C;
3. N = T / delta with delta = gcd(T, C) lies within the limits of samples per turn. N and K = C / delta are
then
   coprime, and a run visits each sample of the turn exactly once;
4. a run, lcm(T, C) = N C ticks, and the longest extra trigger delay fit between two non-uniformity
corrections.

**Ranked** are schemes by how much of its tolerance each wish has to give: the share of the way from the
wanted turn T to its limit, plus that of C, plus that of N, as exact fractions. So a limit is also a weight:
who allows samples per turn to vary by a half and the wheel by 1 % gets a wheel that is nearly right before a
number of samples that is. A scheme that meets all wishes exactly uses 0 and comes first. Equal schemes are
ordered by the duration of the run, then T, then C.

Nothing is rounded and nothing admissible is left out: `Options.n_options` counts all, even where fewer are
listed.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import final

from irtiming.errors import PlanError
from irtiming.plan.candidates import Candidate, Limits, UsedTolerance, best_first, count, limits_in_ticks
from irtiming.plan.impossible import complaint
from irtiming.records.trigger_plan import TriggerScheme, Wishes

MOST_COMPARED = 100_000
"""Schemes per wheel speed that are compared to find common camera periods, best first."""


@final
@dataclass(frozen=True, kw_only=True)
class Option:
    """One scheme for each wheel speed, and the tolerance they use together: 0 is all as wished."""

    schemes: tuple[TriggerScheme, ...]
    used_tolerance: Fraction


@final
@dataclass(frozen=True, kw_only=True)
class Options:
    """What a search found.

    ``best`` holds the first options in order of rank, ``n_options`` says how many there are in all,
    ``n_schemes`` how many admissible schemes each wheel speed has by itself. ``is_complete`` is False if,
    with several wheel speeds, only the best `MOST_COMPARED` schemes of each were compared: ``n_options`` is
    then a lower bound, but no option was missed that uses less tolerance than the last scheme compared.
    """

    best: tuple[Option, ...]
    n_options: int
    n_schemes: tuple[int, ...]
    shares_camera_period: bool
    is_complete: bool


def search(wishes: Wishes, *, most: int = 1000) -> Options:
    """Every admissible scheme for the wishes, ranked; the module says what both words mean.

    Several wheel speeds make options of one camera period C with, at this C, the best scheme of each speed.
    Where no C serves all speeds the only option is the best scheme of each, and ``shares_camera_period`` is
    False.

    Parameters
    ----------
    wishes
        Exact numbers with their limits; Hz, s and counts.
    most
        How many options to list, at least 1.

    Returns
    -------
    The first ``most`` options and how many there are.

    Raises
    ------
    PlanError
        If no scheme is admissible: the message names the constraint and the nearest wish that works. Also if
        the limits are so wide that the search would visit too many pairs (N, K).
    """
    if most < 1:
        raise PlanError(f"{most} schemes are asked for, but a search lists at least 1")
    limits = tuple(limits_in_ticks(wishes, rate) for rate in wishes.wheel_rates_hz)
    numbers = tuple(count(each) for each in limits)
    for each, number in zip(limits, numbers, strict=True):
        if number == 0:
            raise PlanError(complaint(each, wishes.clock_frequency_hz))
    if len(limits) > 1:
        return _several_speeds(limits, numbers, most)
    scale = UsedTolerance(limits[0]).scale
    best = tuple(
        Option(schemes=(_scheme(found, limits[0]),), used_tolerance=Fraction(found.scaled_tolerance, scale))
        for found in islice(best_first(limits[0]), most)
    )
    return Options(best=best, n_options=numbers[0], n_schemes=numbers, shares_camera_period=True, is_complete=True)


def _several_speeds(limits: tuple[Limits, ...], numbers: tuple[int, ...], most: int) -> Options:
    best_by_camera_period: list[dict[int, Candidate]] = []
    for each in limits:
        best: dict[int, Candidate] = {}
        for found in islice(best_first(each), MOST_COMPARED):
            best.setdefault(found.camera_ticks, found)
        best_by_camera_period.append(best)
    common = set(best_by_camera_period[0]).intersection(*best_by_camera_period[1:])
    choices = [tuple(best[period] for best in best_by_camera_period) for period in common]
    if not choices:
        choices = [tuple(next(iter(best.values())) for best in best_by_camera_period)]
    scales = [UsedTolerance(each).scale for each in limits]
    ranked = sorted(
        (
            sum(
                (Fraction(found.scaled_tolerance, scale) for found, scale in zip(choice, scales, strict=True)),
                Fraction(0),
            ),
            sum(found.run_ticks for found in choice),
            choice,
        )
        for choice in choices
    )
    options = tuple(
        Option(
            schemes=tuple(_scheme(found, each) for found, each in zip(choice, limits, strict=True)),
            used_tolerance=used,
        )
        for used, _, choice in ranked[:most]
    )
    return Options(
        best=options,
        n_options=len(choices),
        n_schemes=numbers,
        shares_camera_period=bool(common),
        is_complete=max(numbers) <= MOST_COMPARED,
    )


def _scheme(found: Candidate, limits: Limits) -> TriggerScheme:
    return TriggerScheme(
        turn_period_ticks=found.turn_ticks,
        camera_period_ticks=found.camera_ticks,
        control_slots=limits.control_slots,
    )
