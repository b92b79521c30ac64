"""When each run is made: repeats, trigger delays and wheel speeds between non-uniformity corrections."""

from fractions import Fraction
from math import floor

from irtiming.errors import PlanError
from irtiming.plan.sampling import nearest_ticks, run_period_ticks
from irtiming.records.trigger_plan import PlannedRun, TriggerPlan, TriggerScheme, Wishes


def schedule(schemes: tuple[TriggerScheme, ...], wishes: Wishes) -> TriggerPlan:
    """Put the repeats of each wheel speed and each extra delay into unbroken runs between corrections.

    Repeats follow each other without a gap: after lcm(T, C) ticks wheel and camera stand as at the start, so
    the camera trigger simply goes on. Repeats of one delay stay in one run, one recording, if they fit
    between two corrections at all; otherwise they are shared as evenly as possible between as few runs as
    possible. The camera is corrected before the first run, and again whenever the next run would not end in
    time. Time between runs, to change a delay or a wheel speed, is not counted.

    Parameters
    ----------
    schemes
        One per wheel speed, in the order in which they are measured.
    wishes
        Repeats, delays and the longest uninterrupted time.

    Returns
    -------
    Runs in order: wheel speed by wheel speed, delay by delay.

    Raises
    ------
    PlanError
        If one single run and its delay do not fit between two corrections.
    """
    longest = _longest_ticks(wishes)
    runs: list[PlannedRun] = []
    used: int | None = None
    for scheme in schemes:
        for delay_s in wishes.trigger_delays_s:
            delay = nearest_ticks(delay_s, wishes.clock_frequency_hz)
            for repeats in _shares(wishes.repeats, _repeats_that_fit(scheme, delay, wishes)):
                length = run_length_ticks(scheme, repeats=repeats, trigger_delay_ticks=delay)
                is_late = used is None or (longest is not None and used + length > longest)
                used = length if used is None or is_late else used + length
                runs.append(
                    PlannedRun(scheme=scheme, trigger_delay_ticks=delay, repeats=repeats, is_after_correction=is_late)
                )
    return TriggerPlan(clock_frequency_hz=wishes.clock_frequency_hz, schemes=schemes, runs=tuple(runs))


def run_length_ticks(scheme: TriggerScheme, *, repeats: int, trigger_delay_ticks: int) -> int:
    """Ticks from the first nominal trigger to the end of the last frame: repeats lcm(T, C) + delay."""
    return repeats * run_period_ticks(scheme) + trigger_delay_ticks


def plan_duration_s(plan: TriggerPlan) -> Fraction:
    """Time that all runs of a plan take, without corrections and without changes between them; exact, s."""
    ticks = sum(
        run_length_ticks(run.scheme, repeats=run.repeats, trigger_delay_ticks=run.trigger_delay_ticks) for run in plan
    )
    return Fraction(ticks, plan.clock_frequency_hz)


def _longest_ticks(wishes: Wishes) -> int | None:
    if wishes.longest_uninterrupted_s is None:
        return None
    return floor(wishes.longest_uninterrupted_s * wishes.clock_frequency_hz)


def _repeats_that_fit(scheme: TriggerScheme, delay_ticks: int, wishes: Wishes) -> int:
    longest = _longest_ticks(wishes)
    if longest is None:
        return wishes.repeats
    fitting = (longest - delay_ticks) // run_period_ticks(scheme)
    if fitting < 1:
        needed = Fraction(
            run_length_ticks(scheme, repeats=1, trigger_delay_ticks=delay_ticks), wishes.clock_frequency_hz
        )
        raise PlanError(
            f"one run and its trigger delay last {float(needed):.6g} s, but only "
            f"{float(Fraction(longest, wishes.clock_frequency_hz)):.6g} s lie between two non-uniformity "
            "corrections; correct less often or take fewer samples per turn"
        )
    return fitting


def _shares(repeats: int, most: int) -> list[int]:
    """Repeats split into as few parts of at most ``most`` as will do, evenly, larger ones first."""
    parts = -(-repeats // most)
    small, larger = divmod(repeats, parts)
    return [small + 1] * larger + [small] * (parts - larger)
