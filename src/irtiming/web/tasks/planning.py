"""A series foretold, and the shortest series for an uncertainty that is wanted."""

from typing import Any

from irtiming.plan.sampling import wheel_rate_hz
from irtiming.records.series_plan import TriggerWishes
from irtiming.report.rounding import uncertainty_text
from irtiming.session.camera import Described
from irtiming.session.expectation import ExpectOrder, expect
from irtiming.session.plan import PlanOrder as SessionOrder
from irtiming.session.plan import Proposed
from irtiming.session.plan import plan as plan_series
from irtiming.units import readable_time
from irtiming.web.orders import PlanOrder
from irtiming.web.work import Line

_CLOCK_HZ = "48000000"


def foretell(line: Line, order: PlanOrder) -> dict[str, Any]:
    """What the series should tell, its schemes, and its sampling order as SVG."""
    found = expect(ExpectOrder(wishes=_wishes(order), camera=_described(order), rig=order.rig))
    proposal = found.proposal
    clock = proposal.plan.clock_frequency_hz
    return {
        "duration": readable_time(float(f"{proposal.duration_s:.3g}")),
        "uncertainties": [
            [one.name.replace("_", " "), uncertainty_text(one.standard_uncertainty_s), one.largest_part.source]
            for one in proposal.uncertainties
        ],
        "schemes": [
            [
                f"{float(wheel_rate_hz(one, clock)):.5g}",
                f"{clock / one.camera_period_ticks:.5g}",
                str(one.samples_per_turn),
            ]
            for one in proposal.plan.schemes
        ],
        "assumptions": list(found.assumptions),
        "picture": found.picture,
    }


def shortest(line: Line, order: PlanOrder) -> list[list[Any]]:
    """The shortest measurements for what is wanted: wheel speeds, runs of each, how long they last, what they reach."""
    wishes = TriggerWishes(clock_hz=_CLOCK_HZ, wheel_hz=(), frame_hz=order.frame_hz, samples=order.samples)
    found = plan_series(
        SessionOrder(wishes=wishes, wanted=(order.wanted,), camera=_described(order), rig=order.rig, most=6)
    )
    if not isinstance(found, Proposed):
        return []
    clock = found.setting.clock_frequency_hz
    return [
        [
            [f"{float(wheel_rate_hz(scheme, clock)):.4g}" for scheme in one.plan.schemes],
            list(one.runs_of_each),
            readable_time(float(f"{one.duration_s:.3g}")),
            uncertainty_text(one.uncertainties[0].standard_uncertainty_s),
        ]
        for one in found.found.best
    ]


def _wishes(order: PlanOrder) -> TriggerWishes:
    return TriggerWishes(
        clock_hz=_CLOCK_HZ, wheel_hz=order.wheel_hz, frame_hz=order.frame_hz, samples=order.samples, repeats=order.runs
    )


def _described(order: PlanOrder) -> Described:
    said: dict[str, Any] = {
        "camera": order.camera,
        "readout": order.readout,
        "noise": order.noise_k,
        "contrast": order.contrast_k,
    }
    said["integration_time_s" if order.camera == "photon" else "time_constant_s"] = order.window_or_lag_s
    return Described(**said)
