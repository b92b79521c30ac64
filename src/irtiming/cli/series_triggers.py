"""Runs of a series: from the plan that it names, or found now for its wishes."""

from fractions import Fraction
from pathlib import Path

from irtiming.cli.plan_json import read_plan
from irtiming.errors import PlanError
from irtiming.records.series_plan import SeriesPlan, TriggerWishes
from irtiming.records.trigger_plan import TriggerPlan, Wish, Wishes

_DOUBLE = (Fraction(1, 2), Fraction(2))


def triggers_of(plan: SeriesPlan, *, clock_frequency_hz: int) -> TriggerPlan:
    """Runs in order.

    Parameters
    ----------
    plan
        Names a plan of ``irtiming plan --json``, or says what to wish for.
    clock_frequency_hz
        Of the trigger generator: wishes without a clock of their own are met with it.

    Raises
    ------
    PlanError
        If the plan cannot be read, or no scheme meets the wishes.
    """
    if plan.triggers is None:
        return read_plan(Path(plan.plan_file))
    from irtiming.plan.schedule import schedule
    from irtiming.plan.search import search

    wishes = _wishes(plan.triggers, clock_frequency_hz)
    return schedule(search(wishes, most=1).best[0].schemes, wishes)


def _wishes(asked: TriggerWishes, clock_frequency_hz: int) -> Wishes:
    from irtiming.plan.wishes import exact_number, exact_seconds, ratio, whole_number, wish_around

    share = ratio(asked.tolerance, "tolerance")
    samples = exact_number(asked.samples, "samples")
    low, high = _DOUBLE if asked.frame_hz_exact else (1 - share, 1 + share)
    return Wishes(
        clock_frequency_hz=whole_number(asked.clock_hz, "clock_hz") if asked.clock_hz else clock_frequency_hz,
        wheel_rates_hz=tuple(wish_around(exact_number(text, "wheel_hz"), share) for text in asked.wheel_hz),
        frame_rate_hz=wish_around(
            exact_number(asked.frame_hz, "frame_hz"), Fraction(0) if asked.frame_hz_exact else share
        ),
        samples_per_turn=Wish(wanted=samples, lowest=samples * low, highest=samples * high),
        control_slots=whole_number(asked.control_slots, "control_slots"),
        longest_uninterrupted_s=(
            exact_seconds(asked.between_corrections, "between_corrections") if asked.between_corrections else None
        ),
        trigger_delays_s=tuple(exact_seconds(text, "delays") for text in asked.delays),
        repeats=whole_number(asked.repeats, "repeats"),
    )


def chosen_runs(text: str, n_runs: int) -> set[int]:
    """Numbers from text such as ``"1,3-5"``.

    Raises
    ------
    PlanError
        If it cannot be read, or the series has no such run.
    """
    chosen: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdigit() or (dash and not last.isdigit()):
            raise PlanError(f"--runs '{text}' cannot be read; write numbers such as 1,3-5")
        chosen |= set(range(int(first), int(last if dash else first) + 1))
    strangers = sorted(number for number in chosen if not 1 <= number <= n_runs)
    if strangers or not chosen:
        raise PlanError(
            f"--runs '{text}' asks for run {strangers[0] if strangers else 'none'}, the series has runs 1 to {n_runs}"
        )
    return chosen
