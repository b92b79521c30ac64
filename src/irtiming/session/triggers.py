"""Runs of a series: from the plan that it names, or found now for its wishes."""

from fractions import Fraction

from irtiming.archive import layout
from irtiming.archive.plan_file import read_plan
from irtiming.errors import PlanError
from irtiming.plan.schedule import schedule
from irtiming.plan.search import search
from irtiming.plan.wishes import as_text, exact_number, exact_seconds, ratio, whole_number
from irtiming.records.series_plan import SeriesPlan, TriggerWishes
from irtiming.records.trigger_plan import TriggerPlan, Wish, Wishes
from irtiming.units import plain_integer

_DOUBLE = (Fraction(1, 2), Fraction(2))
"""Limits of the samples per turn, relative, where an exact frame rate leaves little choice."""


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
        return read_plan(plan.plan_file)
    wishes = exact(plan.triggers, clock_frequency_hz=clock_frequency_hz)
    return schedule(search(wishes, most=1).best[0].schemes, wishes)


def exact(asked: TriggerWishes, *, clock_frequency_hz: int) -> Wishes:
    """Wishes in exact numbers; those without a clock of their own are for this one.

    Raises
    ------
    UnitError
        If a text is no number.
    PlanError
        If a number cannot be wished for.
    """
    share = ratio(asked.tolerance, "the tolerance")
    wheel = share if asked.wheel_tolerance is None else ratio(asked.wheel_tolerance, "the wheel tolerance")
    around, pause = (1 - share, 1 + share), asked.between_corrections
    frame = _wish(asked.frame_hz, asked.frame_hz_limits, around, name="the frame rate")
    samples = _DOUBLE if asked.frame_hz_exact else around
    return Wishes(
        clock_frequency_hz=(
            whole_number(asked.clock_hz, "the clock frequency in Hz") if asked.clock_hz else clock_frequency_hz
        ),
        wheel_rates_hz=tuple(
            _wish(text, (None, None), (1 - wheel, 1 + wheel), name="the wheel rate") for text in asked.wheel_hz
        ),
        frame_rate_hz=_exactly(frame) if asked.frame_hz_exact else frame,
        samples_per_turn=_wish(asked.samples, asked.samples_limits, samples, name="samples per turn"),
        control_slots=whole_number(asked.control_slots, "the number of control slots"),
        longest_uninterrupted_s=None if pause is None else exact_seconds(pause, "the time between corrections"),
        trigger_delays_s=tuple(map(_delay, asked.delays)),
        repeats=whole_number(asked.repeats, "the number of repeats"),
    )


def _delay(text: str) -> Fraction:
    """Delay that a recording can hold, s."""
    delay_s, longest_s = exact_seconds(text, "the trigger delay"), layout.TRIGGER_DELAY_TIME_SET.highest
    if delay_s > longest_s:
        raise PlanError(
            f"the trigger delay is {text.strip()}, must be at most {longest_s:g} s, the longest that a recording holds"
        )
    return delay_s


def _exactly(wish: Wish) -> Wish:
    return Wish(wanted=wish.wanted, lowest=wish.wanted, highest=wish.wanted)


def _wish(
    text: str, limits: tuple[str | None, str | None], factors: tuple[Fraction, Fraction], *, name: str
) -> Wish:  # fmt: skip
    """A wish within its limits; those that are not stated lie a factor below and above what is wanted."""
    wanted = exact_number(text, name)
    lowest, highest = (
        wanted * factor if limit is None else exact_number(limit, f"the limit of {name}")
        for limit, factor in zip(limits, factors, strict=True)
    )
    if not lowest <= wanted <= highest:
        raise PlanError(
            f"{name} is {as_text(wanted)}, outside its limits {as_text(lowest)} .. {as_text(highest)}; "
            f"the nearest within is {as_text(lowest if wanted < lowest else highest)}"
        )
    return Wish(wanted=wanted, lowest=lowest, highest=highest)


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
        begin, end = plain_integer(first), plain_integer(last if dash else first)
        if begin is None or end is None:
            raise PlanError(f"--runs '{text}' cannot be read; write numbers such as 1,3-5")
        chosen |= {begin, end, *range(begin, min(end, n_runs) + 1)} if begin <= end else set()
    strangers = sorted(number for number in chosen if not 1 <= number <= n_runs)
    if strangers or not chosen:
        raise PlanError(
            f"--runs '{text}' asks for run {strangers[0] if strangers else 'none'}, the series has runs 1 to {n_runs}"
        )
    return chosen
