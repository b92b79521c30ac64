"""Plan a measurement."""

from typing import Any

from irtiming.interface.wishes import several, sorted_into
from irtiming.records.series_plan import TriggerWishes
from irtiming.session import plan as session
from irtiming.session.camera import Described
from irtiming.session.plan import Planned, PlanOrder, Proposed


def plan(**wishes: Any) -> Planned | Proposed:
    """Trigger schemes that meet the wishes, or the shortest measurements that should reach what is wanted.

    Parameters
    ----------
    wishes
        Fields of `TriggerWishes`, `Described` and `PlanOrder`, by name, as in ``irtiming plan``: ``clock_hz=49152000``,
        ``wheel_hz=(3,)``, ``frame_hz="30.303"``, ``samples=1000``; or ``wanted={"trigger_delay": "0.5 us"}``. Numbers are taken
        as they are written.

    Returns
    -------
    With ``options`` (best first) or, where something is ``wanted``, ``found``; ``best``, the runs to record; ``as_json()``.

    Raises
    ------
    PlanError
        If a wish is not known or cannot be read, or nothing meets all of them.
    """
    of_triggers, of_camera, of_order = sorted_into(wishes, TriggerWishes, Described, PlanOrder)
    usual: dict[str, Any] = {"wheel_hz": (), "frame_hz": "", "samples": ""}
    wanted = of_order.pop("wanted", ())
    texts = [f"{name}={size}" for name, size in wanted.items()] if isinstance(wanted, dict) else several(wanted)
    order = PlanOrder(
        **of_order,
        wanted=tuple(texts),
        wishes=TriggerWishes(**usual | {name: _written(value, name) for name, value in of_triggers.items()}),
        camera=Described(**of_camera),
    )
    return session.plan(order)


def _written(value: Any, name: str) -> Any:
    """As a person writes it in a command: numbers exactly, lists of them where there may be several."""
    if name in ("wheel_hz", "delays"):
        return tuple(map(str, several(value)))
    if value is None or isinstance(value, bool):
        return value
    return tuple(None if one is None else str(one) for one in value) if isinstance(value, tuple) else str(value)
