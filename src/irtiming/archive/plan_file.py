"""The runs of a measurement as ``irtiming plan --json`` writes them."""

from pathlib import Path
from typing import Any

from irtiming.archive.typed_file import json_of
from irtiming.errors import ArchiveError, PlanError
from irtiming.records.trigger_plan import PlannedRun, TriggerPlan, TriggerScheme

_CURE = "name a file that irtiming plan --json wrote"
_COUNTS = ("turn_period_ticks", "camera_period_ticks", "control_slots", "trigger_delay_ticks", "repeats")


def read_plan(path: str | Path) -> TriggerPlan:
    """The plan in a file that ``irtiming plan --json`` wrote.

    Raises
    ------
    PlanError
        If the file cannot be read, or holds no plan.
    """
    try:
        content = json_of(Path(path), what="plan of irtiming plan --json", cure=_CURE)
        runs = tuple(_run(run) for run in content["plan"]["runs"])
        clock = content["clock_frequency_hz"]
    except ArchiveError as error:
        raise PlanError(str(error)) from error
    except KeyError as error:
        raise PlanError(f"{path} holds no plan: {error} is missing; {_CURE}") from error
    except (ValueError, TypeError) as error:
        raise PlanError(f"{path} holds no plan; {_CURE}") from error
    if not isinstance(clock, int) or not runs:
        raise PlanError(f"{path} holds {len(runs)} runs for a clock of {clock!r} Hz; {_CURE}")
    return TriggerPlan(clock_frequency_hz=clock, schemes=tuple(dict.fromkeys(run.scheme for run in runs)), runs=runs)


def _run(run: dict[str, Any]) -> PlannedRun:
    turn, camera, slots, delay, repeats = (run[name] for name in _COUNTS)
    if not all(type(number) is int for number in (turn, camera, slots, delay, repeats)):
        raise TypeError("a run is made of whole numbers")
    return PlannedRun(
        scheme=TriggerScheme(turn_period_ticks=turn, camera_period_ticks=camera, control_slots=slots),
        trigger_delay_ticks=delay,
        repeats=repeats,
        is_after_correction=bool(run["is_after_correction"]),
    )
