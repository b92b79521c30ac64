"""Wheel speeds for a camera that runs free, as a person asks for them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from irtiming.archive.json_file import require_places, write_json
from irtiming.archive.rig_file import read_rig
from irtiming.errors import PlanError
from irtiming.plan.assumptions import assumed
from irtiming.plan.free_running import FreeSpeed, even_speed, predicted
from irtiming.plan.prediction import Setting
from irtiming.session.camera import Described, camera
from irtiming.session.plan_json import predicted_as_json

USUAL_HZ = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)
_SHORTEST_S, _LONGEST_S = 1e-5, 10.0
_FEWEST, _MOST = 100, 100_000
_CLOCK_HZ = 49_152_000  # nothing depends on it: no tick of it is chosen


@final
@dataclass(frozen=True, kw_only=True)
class FreePlanOrder:
    """What is known of the camera, and where to seek: within a share ``around`` of each of ``wheel_hz``.

    ``free_running_s`` is its period, ``samples`` are the frames in a run. ``tolerance`` is relative, by how much rate and
    period may be off together. Camera and rig are for the uncertainties to expect.
    """

    free_running_s: float
    samples: int = 1000
    wheel_hz: tuple[float, ...] = USUAL_HZ
    around: float = 0.05
    tolerance: float = 1e-4
    camera: Described
    rig: Path | None = None
    json: Path | None = None

    def __post_init__(self) -> None:
        if not _SHORTEST_S <= self.free_running_s <= _LONGEST_S:
            raise PlanError(
                f"{{free_running_s}} is {self.free_running_s:g} s; it must be from {_SHORTEST_S:g} to {_LONGEST_S:g} s",
                "free_running_s",
            )
        if not _FEWEST <= self.samples <= _MOST:
            raise PlanError(f"{{samples}} is {self.samples}; it must be from {_FEWEST} to {_MOST}", "samples")
        for rate in self.wheel_hz:
            if not 0.01 <= rate <= 1e4:
                raise PlanError(f"{{wheel_hz}} is {rate:g} Hz; it must be from 0.01 to 10000 Hz", "wheel_hz")


@final
@dataclass(frozen=True, kw_only=True)
class FreePlanned:
    """Speeds, the most even first; one for each rate that was asked for."""

    speeds: tuple[FreeSpeed, ...]
    order: FreePlanOrder

    def as_json(self) -> dict[str, Any]:
        """The same as plain data."""
        return {
            "period": {"value": self.order.free_running_s, "unit": "s"},
            "frames": self.order.samples,
            "speeds": [
                {
                    "rotation_speed": {"value": one.wheel_rate_hz, "unit": "Hz"},
                    "largest_gap": one.largest_gap,
                    "is_even": one.is_even,
                    "predicted_uncertainty": predicted_as_json(one.uncertainties),
                }
                for one in self.speeds
            ],
        }


def plan(order: FreePlanOrder) -> FreePlanned:
    """Even wheel speeds near those that were asked for, with what a run at each should tell.

    Raises
    ------
    IrTimingError
        If a file cannot be read or written, or the camera cannot be.
    """
    require_places({"JSON": [order.json]}, inputs=[order.rig])
    described = camera(order.camera)
    rig = assumed(None if order.rig is None else read_rig(order.rig), described)
    setting = Setting(camera=described, rig=rig, clock_frequency_hz=_CLOCK_HZ)
    found = []
    for rate in order.wheel_hz:
        limits = rate * (1 - order.around), rate * (1 + order.around)
        one = even_speed(limits, period_s=order.free_running_s, frames=order.samples, tolerance=order.tolerance)
        found.append(
            predicted(setting, one, period_s=order.free_running_s, frames=order.samples) if one.is_even else one
        )
    planned = FreePlanned(speeds=tuple(sorted(found, key=lambda one: one.largest_gap)), order=order)
    if order.json is not None:
        write_json(planned.as_json(), order.json)
    return planned
