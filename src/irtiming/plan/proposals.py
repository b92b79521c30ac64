"""From targets to the shortest measurements that should reach them: wheel speeds, runs of each, and what limits the result.

For every set of up to four wheel speeds the runs are given out one by one, each to the speed where it brings the worst target
down most per second, until all targets are met. A run is lcm(T, C) of the best scheme of its speed (`plan.search`), once for
each set delay.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations
from typing import final

import numpy as np

from irtiming.errors import PlanError
from irtiming.inference.information import NOISE
from irtiming.plan.information import RunInformation
from irtiming.plan.prediction import RELATIVE, Setting, sizes_s, uncertainties
from irtiming.plan.sampling import run_period_ticks
from irtiming.plan.schedule import plan_duration_s, schedule
from irtiming.plan.search import search
from irtiming.plan.targets import Target
from irtiming.plan.wishes import wish_around
from irtiming.records import sources
from irtiming.records.camera_description import PhotonCamera
from irtiming.records.prediction import PredictedUncertainty
from irtiming.records.trigger_plan import TriggerPlan, TriggerScheme, Wishes
from irtiming.units import readable_time

USUAL_SPEEDS_HZ = (2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50)
MOST_SPEEDS = 4
MOST_RUNS = 100
"""Runs of one wheel speed and set delay that a proposal has at most."""


@final
@dataclass(frozen=True, kw_only=True)
class Proposal:
    """A plan that should reach all targets: ``runs_of_each`` of its schemes and set delays, and what is predicted of it."""

    plan: TriggerPlan
    runs_of_each: tuple[int, ...]
    duration_s: float
    uncertainties: tuple[PredictedUncertainty, ...]


@final
@dataclass(frozen=True, kw_only=True)
class Reach:
    """The smallest uncertainties that some wheel speeds can reach with `MOST_RUNS` of each."""

    wheel_rates_hz: tuple[float, ...]
    uncertainties: tuple[PredictedUncertainty, ...]


@final
@dataclass(frozen=True, kw_only=True)
class Proposals:
    """The shortest first; ``one_speed`` is the best that a single wheel speed can do for the first target."""

    best: tuple[Proposal, ...]
    one_speed: Reach


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Speed:
    """A scheme, what one of its runs tells, and how long that takes for all set delays, s."""

    scheme: TriggerScheme
    wheel_rate_hz: float
    run: RunInformation
    seconds: float


def usual_speeds(tolerance: Fraction = Fraction(1, 100)) -> Wishes:
    """Wishes for the scheme of Schatz 2023, section 2.3, at any of the usual wheel speeds."""
    return Wishes(
        clock_frequency_hz=49_152_000,
        wheel_rates_hz=tuple(wish_around(Fraction(rate), tolerance) for rate in USUAL_SPEEDS_HZ),
        frame_rate_hz=wish_around(Fraction(30_303, 1000), tolerance),
        samples_per_turn=wish_around(Fraction(1000), tolerance),
    )


def propose(setting: Setting, wishes: Wishes, *, targets: Sequence[Target], most: int = 10) -> Proposals:
    """Shortest plans that should reach every target.

    Parameters
    ----------
    setting
        Camera and rig.
    wishes
        Each of the wheel rates may be used; repeats are chosen here.
    targets
        Standard uncertainties, s.
    most
        How many plans to give, at least 1.

    Raises
    ------
    PlanError
        If no scheme is admissible, or a target is out of reach: the message says how near it can be come, what limits it, and
        what would do.
    """
    n_delays = len(wishes.trigger_delays_s)
    speeds = _speeds(setting, wishes)
    search_for = _Search(speeds=speeds, targets=tuple(targets), n_delays=n_delays)
    alone = search_for.reach(1)
    ranked = search_for.ranked(most)
    if not ranked:
        raise PlanError(_out_of_reach(search_for, setting=setting, wishes=wishes))
    return Proposals(best=tuple(_proposal(found, search_for, wishes=wishes) for found in ranked), one_speed=alone)


def foretell(setting: Setting, wishes: Wishes, *, names: Sequence[str]) -> Proposal:
    """What ``wishes.repeats`` runs at each of the wheel rates should reach, whatever that is.

    Parameters
    ----------
    setting
        Camera and rig.
    wishes
        All wheel rates that have a scheme are used.
    names
        Parameters to foretell, of `parameters_of` the camera.

    Raises
    ------
    PlanError
        If no wheel rate has a scheme.
    """
    speeds = _speeds(setting, wishes)
    anything = tuple(Target(name=name, standard_uncertainty_s=float("inf")) for name in names)
    search_for = _Search(speeds=speeds, targets=anything, n_delays=len(wishes.trigger_delays_s))
    found = _Found(order=(0.0, 0.0), speeds=speeds, runs=(wishes.repeats,) * len(speeds))
    return _proposal(found, search_for, wishes=wishes)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Found:
    """Runs of each speed; sorts by duration, then by how far below the targets it comes."""

    order: tuple[float, float]
    speeds: tuple[_Speed, ...]
    runs: tuple[int, ...]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Search:
    """All sets of wheel speeds against the targets."""

    speeds: tuple[_Speed, ...]
    targets: tuple[Target, ...]
    n_delays: int

    @property
    def names(self) -> tuple[str, ...]:
        """Of the targets."""
        return tuple(target.name for target in self.targets)

    def worst(self, speeds: Sequence[_Speed], runs: Sequence[int]) -> float:
        """Largest predicted uncertainty over its target."""
        found = sizes_s(_pairs(speeds, runs), self.names, n_delays=self.n_delays)
        return max(found[target.name] / target.standard_uncertainty_s for target in self.targets)

    def sets(self, n_speeds: int | None = None) -> Iterator[tuple[_Speed, ...]]:
        """Sets of wheel speeds, small ones first."""
        sizes = range(1, min(MOST_SPEEDS, len(self.speeds)) + 1) if n_speeds is None else (n_speeds,)
        for size in sizes:
            yield from combinations(self.speeds, size)

    def reach(self, n_speeds: int) -> Reach:
        """The set of so many speeds that comes nearest to the targets with as many runs as may be."""
        best = min(self.sets(n_speeds), key=lambda chosen: self.worst(chosen, [MOST_RUNS] * n_speeds))
        found = uncertainties(_pairs(best, [MOST_RUNS] * n_speeds), self.names, n_delays=self.n_delays)
        return Reach(wheel_rates_hz=tuple(speed.wheel_rate_hz for speed in best), uncertainties=found)

    def ranked(self, most: int) -> list[_Found]:
        """The shortest sets of runs that reach all targets."""
        found: list[_Found] = []
        for chosen in self.sets():
            longest = found[most - 1].order[0] if len(found) >= most else float("inf")
            if self._seconds(chosen, [1] * len(chosen)) > longest or self.worst(chosen, [MOST_RUNS] * len(chosen)) > 1:
                continue
            one = self._shared_out(chosen, longest)
            if one is not None:
                found = sorted([*found, one], key=lambda each: each.order)[:most]
        return found

    def _shared_out(self, chosen: tuple[_Speed, ...], longest_s: float) -> _Found | None:
        """Runs given out one by one until the targets are met; None if that takes too long."""
        runs = [1] * len(chosen)
        worst = self.worst(chosen, runs)
        while worst > 1:
            trials = []
            for k, speed in enumerate(chosen):
                if runs[k] < MOST_RUNS:
                    more = [n + (place == k) for place, n in enumerate(runs)]
                    then = self.worst(chosen, more)
                    trials.append(((worst - then) / speed.seconds, k, then))
            if not trials:
                return None
            _, k, worst = max(trials)
            runs[k] += 1
            if self._seconds(chosen, runs) > longest_s:
                return None
        return _Found(order=(self._seconds(chosen, runs), worst), speeds=chosen, runs=tuple(runs))

    @staticmethod
    def _seconds(chosen: Sequence[_Speed], runs: Sequence[int]) -> float:
        """Duration, to two digits: what is nearly as short and better comes first."""
        return float(f"{sum(n * speed.seconds for n, speed in zip(runs, chosen, strict=True)):.2g}")


def _pairs(speeds: Sequence[_Speed], runs: Sequence[int]) -> list[tuple[RunInformation, int]]:
    return [(speed.run, n) for speed, n in zip(speeds, runs, strict=True)]


def _speeds(setting: Setting, wishes: Wishes) -> tuple[_Speed, ...]:
    """Wheel speeds that have a scheme and, for a photon camera, plateaus that last longer than the integration."""
    found, refused = list[_Speed](), list[PlanError]()
    clock, delays = wishes.clock_frequency_hz, wishes.trigger_delays_s
    of_clock = {sources.CLOCK: setting.rig.u_clock * float(max(delays) - min(delays))}
    for rate in wishes.wheel_rates_hz:
        try:
            _check_plateau(setting, float(rate.wanted))
            (scheme,) = search(replace(wishes, wheel_rates_hz=(rate,)), most=1).best[0].schemes
        except PlanError as error:
            refused.append(error)
            continue
        run = setting.one_run(scheme)
        ticks = sum(run_period_ticks(scheme) + delay * clock for delay in delays)
        found.append(
            _Speed(
                scheme=scheme,
                wheel_rate_hz=clock / scheme.turn_period_ticks,
                run=replace(run, beside={**run.beside, RELATIVE: of_clock}),
                seconds=float(Fraction(ticks) / clock),
            )
        )
    if not found:
        raise refused[0]
    return tuple(found)


def _check_plateau(setting: Setting, wheel_rate_hz: float) -> None:
    if not isinstance(setting.camera, PhotonCamera) or setting.camera.readout_mode == "rolling":
        return
    model = setting.rig.model
    arcs = np.diff([*model.cutout_edges_rad, model.cutout_edges_rad[0] + 2 * np.pi])
    plateau = float(arcs.min()) - model.opening_angle_rad
    longest_s = plateau / (2 * np.pi * wheel_rate_hz)
    if setting.camera.integration_time_s > longest_s:
        raise PlanError(
            f"at {wheel_rate_hz:g} Hz the mask is wholly open for {readable_time(longest_s)}, but must be for the integration "
            f"time of {readable_time(setting.camera.integration_time_s)}; turn the wheel more slowly"
        )


def _proposal(found: _Found, search_for: _Search, *, wishes: Wishes) -> Proposal:
    plans = [
        schedule((speed.scheme,), replace(wishes, repeats=n)) for speed, n in zip(found.speeds, found.runs, strict=True)
    ]
    whole = TriggerPlan(
        clock_frequency_hz=wishes.clock_frequency_hz,
        schemes=tuple(speed.scheme for speed in found.speeds),
        runs=tuple(run for plan in plans for run in plan),
    )
    return Proposal(
        plan=whole,
        runs_of_each=found.runs,
        duration_s=float(plan_duration_s(whole)),
        uncertainties=uncertainties(_pairs(found.speeds, found.runs), search_for.names, n_delays=search_for.n_delays),
    )


def _out_of_reach(search_for: _Search, *, setting: Setting, wishes: Wishes) -> str:
    """What is missed, by how much, why, and what would do."""
    reaches = [search_for.reach(n) for n in range(1, min(MOST_SPEEDS, len(search_for.speeds)) + 1)]
    nearest = min(reaches, key=lambda reach: _missed(reach, search_for.targets)[0])
    _, target, found = _missed(nearest, search_for.targets)
    part = found.largest_part
    speeds = speeds_text(nearest.wheel_rates_hz)
    return (
        f"{target.name} = {_short(target.standard_uncertainty_s)} cannot be reached: at best "
        f"{_short(found.standard_uncertainty_s)} with {speeds} and {MOST_RUNS} runs of each, of which {part.source} makes "
        f"{_short(part.standard_uncertainty_s)}; {_cure(search_for, part.source, setting=setting, wishes=wishes)}"
    )


def _missed(reach: Reach, targets: Sequence[Target]) -> tuple[float, Target, PredictedUncertainty]:
    """The target that is missed most, by which factor, and what is predicted for it."""
    ratios = [
        (found.standard_uncertainty_s / target.standard_uncertainty_s, k)
        for k, (found, target) in enumerate(zip(reach.uncertainties, targets, strict=True))
    ]
    ratio, k = max(ratios)
    return ratio, targets[k], reach.uncertainties[k]


def _cure(search_for: _Search, source: str, *, setting: Setting, wishes: Wishes) -> str:
    """A set of wheel speeds that reaches the targets, where there is one, else what makes the largest part smaller."""
    asked = {round(speed.wheel_rate_hz) for speed in search_for.speeds}
    if asked != set(USUAL_SPEEDS_HZ):
        wider = replace(wishes, wheel_rates_hz=usual_speeds().wheel_rates_hz)
        try:
            other = replace(search_for, speeds=_speeds(setting, wider))
        except PlanError:
            return "allow other wheel speeds"
        found = other.ranked(1)
        if found:
            (first,) = found
            why = "" if source == NOISE else "an angle error looks like a delay at one wheel speed and not at several: "
            return (
                f"{why}take {speeds_text([speed.wheel_rate_hz for speed in first.speeds])} and {sum(first.runs)} runs"
            )
    if source == NOISE:
        return "take more pixels, more contrast or more frames per turn"
    return f"make the part smaller ({source}), or ask for less"


def speeds_text(rates_hz: Sequence[float]) -> str:
    """Wheel speeds in words: ``"3 and 12 Hz"``."""
    texts = [f"{rate:.3g}" for rate in rates_hz]
    return f"{', '.join(texts[:-1])} and {texts[-1]} Hz" if len(texts) > 1 else f"{texts[0]} Hz"


def _short(time_s: float) -> str:
    return readable_time(float(f"{time_s:.2g}"))
