"""Plans as plain data, and files written for them."""

from pathlib import Path
from typing import Any

from irtiming.records.trigger_plan import PlannedRun, TriggerPlan, TriggerScheme


def plan_as_json(plan: TriggerPlan) -> dict[str, Any]:
    """Runs of a plan in order, its duration, and which sample of the turn each trigger takes."""
    from irtiming.plan.sampling import sampling_order
    from irtiming.plan.schedule import plan_duration_s, run_length_ticks

    clock = plan.clock_frequency_hz
    runs = [
        {
            "turn_period_ticks": run.scheme.turn_period_ticks,
            "camera_period_ticks": run.scheme.camera_period_ticks,
            "control_slots": run.scheme.control_slots,
            "trigger_delay_ticks": run.trigger_delay_ticks,
            "trigger_delay_s": run.trigger_delay_ticks / clock,
            "repeats": run.repeats,
            "is_after_correction": run.is_after_correction,
            "duration_s": run_length_ticks(run.scheme, repeats=run.repeats, trigger_delay_ticks=run.trigger_delay_ticks)
            / clock,
        }
        for run in plan
    ]
    return {
        "runs": runs,
        "duration_s": float(plan_duration_s(plan)),
        "sampling_orders": [sampling_order(scheme).tolist() for scheme in plan.schemes],
    }


def scheme_as_json(scheme: TriggerScheme, clock_frequency_hz: int) -> dict[str, Any]:
    """Numbers of one scheme: ticks exactly, rates and duration as float and as fraction."""
    from irtiming.plan import sampling

    wheel = sampling.wheel_rate_hz(scheme, clock_frequency_hz)
    camera = sampling.frame_rate_hz(scheme, clock_frequency_hz)
    duration = sampling.run_duration_s(scheme, clock_frequency_hz)
    return {
        "turn_period_ticks": scheme.turn_period_ticks,
        "control_slot_period_ticks": scheme.control_slot_period_ticks,
        "camera_period_ticks": scheme.camera_period_ticks,
        "sampling_interval_ticks": scheme.sampling_interval_ticks,
        "samples_per_turn": scheme.samples_per_turn,
        "samples_per_frame": scheme.samples_per_frame,
        "control_slots": scheme.control_slots,
        "triggers_to_neighbour": sampling.triggers_to_neighbour(scheme),
        "wheel_rate_hz": float(wheel),
        "wheel_rate_hz_exact": str(wheel),
        "frame_rate_hz": float(camera),
        "frame_rate_hz_exact": str(camera),
        "run_duration_s": float(duration),
        "run_duration_s_exact": str(duration),
    }


def read_plan(path: Path) -> TriggerPlan:
    """The plan in a file that `irtiming plan --json` wrote.

    Raises
    ------
    PlanError
        If the file cannot be read, or holds no plan.
    """
    from json import loads

    from irtiming.errors import PlanError

    cure = "name a file that irtiming plan --json wrote"
    try:
        content = loads(path.read_text(encoding="utf-8"))
        runs = tuple(_run(run) for run in content["plan"]["runs"])
        clock = content["clock_frequency_hz"]
    except OSError as error:
        raise PlanError(f"{path} cannot be read ({error.strerror}); {cure}") from error
    except KeyError as error:
        raise PlanError(f"{path} holds no plan: {error} is missing; {cure}") from error
    except (ValueError, TypeError) as error:
        raise PlanError(f"{path} holds no plan; {cure}") from error
    if not isinstance(clock, int) or not runs:
        raise PlanError(f"{path} holds {len(runs)} runs for a clock of {clock!r} Hz; {cure}")
    return TriggerPlan(clock_frequency_hz=clock, schemes=tuple(dict.fromkeys(run.scheme for run in runs)), runs=runs)


def _run(run: dict[str, Any]) -> PlannedRun:
    turn, camera, slots, delay, repeats = (
        run[name]
        for name in ("turn_period_ticks", "camera_period_ticks", "control_slots", "trigger_delay_ticks", "repeats")
    )
    if not all(type(number) is int for number in (turn, camera, slots, delay, repeats)):
        raise TypeError("a run is made of whole numbers")
    return PlannedRun(
        scheme=TriggerScheme(turn_period_ticks=turn, camera_period_ticks=camera, control_slots=slots),
        trigger_delay_ticks=delay,
        repeats=repeats,
        is_after_correction=bool(run["is_after_correction"]),
    )


def write(path: Path, content: str | dict[str, Any]) -> None:
    """Write a drawing, or data as JSON.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    from json import dumps

    from irtiming.errors import ArchiveError

    text = content if isinstance(content, str) else dumps(content, indent=1) + "\n"
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ArchiveError(
            f"{path} cannot be written ({error.strerror}); give a path in a folder that exists"
        ) from error
