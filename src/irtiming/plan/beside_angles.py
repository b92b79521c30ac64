"""Errors of a rig that no recording tells: latencies and the clock go into what is sought as they are, at any speed."""

from collections.abc import Collection, Mapping
from typing import TypeAlias

import numpy as np

from irtiming.physics.latency import USUAL_CLOCK, window_tail
from irtiming.physics.response.integration_window import tail_delay_s, tails
from irtiming.records import sources
from irtiming.records.camera_description import Camera, PhotonCamera
from irtiming.records.result import Contribution
from irtiming.records.rig import Latency, Rig

Beside: TypeAlias = Mapping[str, Mapping[str, float]]
"""What each source adds to the standard uncertainty of each parameter, s: by parameter, then by source."""

_DELAYS = ("trigger_delay", "exposure_midpoint_delay")
_UNDETERMINED = (*sources.LATENCIES.values(), sources.BOTH_GATES, sources.CLOCK)
_OF_WINDOW = (sources.WINDOW, sources.TAIL)


def of_rig(rig: Rig, camera: Camera) -> Beside:
    """What latencies and clock will add before anything is recorded.

    Parameters
    ----------
    rig
        As measured. Of the light gates the application gate's latency counts whole, as it does where the register of the slots is
        each recording's own; at one speed the control gate takes nearly half of it over, which angles hide.
    camera
        The sizes of its times, which a clock makes wrong in proportion.
    """
    late = rig.latency or Latency()
    numbers = {"application_gate": late.application_gate_s, "trigger": late.trigger_s}
    of_delay = {
        sources.LATENCIES[name]: number.standard_uncertainty for name, number in numbers.items() if number is not None
    }
    sizes = {name: getattr(camera, f"{name}_s", None) for name in ("time_constant", "row_delay", "integration_time")}
    u_clock = clock_u(rig)
    of_times = {name: {sources.CLOCK: abs(size) * u_clock} for name, size in sizes.items() if size}
    tail = window_tail(rig.camera)
    if isinstance(camera, PhotonCamera) and camera.readout_mode == "rolling" and tail is not None:
        late_s = [
            part.share.standard_uncertainty * tail_delay_s(camera.integration_time_s, part.time_constant_s)
            for part in tails(tail).values()
        ]
        of_times["trigger_delay"] = of_delay | {sources.TAIL: float(np.linalg.norm(late_s))}
    return dict.fromkeys(_DELAYS, of_delay) | of_times


def clock_u(rig: Rig) -> float:
    """Standard uncertainty of the clock's relative error."""
    return (USUAL_CLOCK if rig.clock is None else rig.clock.relative_error).standard_uncertainty


def of_budget(lines: tuple[Contribution, ...], *, told: Collection[str]) -> Beside:
    """The same after an analysis, which knows all recordings' registers.

    Parameters
    ----------
    lines
        Its budget.
    told
        Sources, of the window's length and tail, that are among what the recordings tell.
    """
    counted = (*_UNDETERMINED, *(source for source in _OF_WINDOW if source not in told))
    chosen = [line for line in lines if line.source in counted]
    names = {name for line in chosen for name in line.standard_uncertainty}
    return {name: {line.source: line.standard_uncertainty.get(name, 0.0) for line in chosen} for name in names}
