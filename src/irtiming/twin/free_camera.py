"""A camera that runs free: frames by its own clock, its strobe and stamps, and their arrival at a computer with its clock.

Times are in seconds from the moment that would be the first trigger. Three clocks stand beside that: the counter of the light
gates, the camera's, and the computer's.
"""

from typing import Any

import numpy as np

from irtiming.records.arrays import Array, Ticks
from irtiming.records.frame_events import FrameEvent
from irtiming.twin.clockwork import first_tick_after
from irtiming.twin.free_running import FreeRunning
from irtiming.twin.noise import generator
from irtiming.twin.scene import Scene, TriggerGenerator

_RATE = 20e-6
_ONE_TICK_S = 1e-6
"""Steps in which the computer's clock goes."""


def draw_free(event: FrameEvent, *, seed: int) -> FreeRunning:
    """A camera that runs free, with clocks that are a little off and a way to the computer of its own; the same for a seed."""
    random = generator(seed, "rig", index=7)
    return FreeRunning(
        event=event,
        rate_error=float(random.normal(0.0, _RATE)),
        phase=float(random.uniform()),
        strobe_after_s=float(random.uniform(0.0, 1e-3)),
        stamp_after_s=float(random.uniform(0.0, 2e-3)),
        computer_rate_error=float(random.normal(0.0, _RATE)),
        computer_zero_s=float(random.uniform(1e3, 1e5)),
    )


def begun_s(trigger: TriggerGenerator, free: FreeRunning | None, *, number: Array | Ticks) -> Array:
    """When the frames with these numbers begin, counted from what would be the first trigger, s, shape as ``number``."""
    if free is None:
        return np.asarray(number * trigger.camera_period_ticks / trigger.true_frequency_hz)
    period_s = trigger.camera_period_ticks / trigger.clock_frequency_hz / (1 + free.rate_error)
    return np.asarray((free.phase + number) * period_s)


def delay_s(free: FreeRunning, *, exposed_after_s: float) -> float:
    """True delay from the event, s: the median one where events scatter; the exposure comes so much after the frame begins."""
    if free.event == "strobe":
        return exposed_after_s - free.strobe_after_s
    return exposed_after_s - (free.stamp_after_s if free.event == "stamp" else usual_latency_s(free))


def usual_latency_s(free: FreeRunning) -> float:
    """Median of the time from a frame's begin to its arrival, s: of the mixture of usual ways and hiccups."""
    from scipy.optimize import brentq  # which takes half a second to load, and most rigs have another camera
    from scipy.special import gammainc

    hiccups_s = np.linspace(0.0, free.hiccup_s, 2001)

    def share_before(late_s: Any) -> Any:
        return gammainc(free.arrival_shape, np.maximum(late_s, 0.0) / free.arrival_scale_s)

    def beyond_half(late_s: float) -> float:
        with_hiccup = float(np.mean(share_before(late_s - hiccups_s)))
        return (1 - free.hiccup_share) * float(share_before(late_s)) + free.hiccup_share * with_hiccup - 0.5

    return free.arrival_shortest_s + float(brentq(beyond_half, 0.0, 1.0, xtol=1e-10))


def observed(scene: Scene, free: FreeRunning, *, kept: Ticks, seed: int) -> dict[str, Any]:
    """What such a camera and its computer add to a recording, by the recording's own names.

    Parameters
    ----------
    scene, free
        The rig as it truly is, and the camera's own clocks.
    kept
        Shape (n_frame,): numbers of the frames that arrive.
    seed
        Fixes jitter, latencies and exchanges.
    """
    trigger, random = scene.trigger, generator(seed, "free camera")
    n = trigger.n_triggers
    every = np.arange(-free.frames_before, n + free.frames_after)
    strobes = (
        begun_s(trigger, free, number=every)
        + free.strobe_after_s
        + free.strobe_jitter_s * random.standard_normal(every.size)
    )
    begun = begun_s(trigger, free, number=np.arange(n))
    stamped = begun + free.stamp_after_s + free.stamp_jitter_s * random.standard_normal(n)
    late = free.arrival_shortest_s + free.arrival_scale_s * random.standard_gamma(free.arrival_shape, n)
    late += np.where(random.random(n) < free.hiccup_share, random.uniform(0, free.hiccup_s, n), 0.0)
    computer = np.maximum.accumulate(_computer_s(free, begun + late))
    values: dict[str, Any] = {
        "frame_event": free.event,
        "camera_trigger_ticks": np.zeros(0, np.int64),
        "camera_period_ticks": None,
        "frame_id": kept.copy(),
        "frame_timestamp_ticks": _camera_ticks(free, stamped)[kept],
        "timestamp_frequency_hz": free.timestamp_frequency_hz,
        "frame_host_time_s": computer[kept],
    }  # fmt: skip
    if free.event == "strobe":
        values["camera_input_ticks"] = first_tick_after(strobes, trigger)
    ends = float(begun[0]) - 0.2, float(begun[-1]) + 0.2
    before, read, after = _exchanges(free, ends, random=random)
    values |= {
        "counter_exchange_before_s": before,
        "counter_exchange_ticks": first_tick_after(read, trigger),
        "counter_exchange_after_s": after,
    }
    if free.event == "stamp":
        before, read, after = _exchanges(free, ends, random=random)
        values |= {
            "camera_exchange_before_s": before,
            "camera_exchange_ticks": _camera_ticks(free, read),
            "camera_exchange_after_s": after,
        }
    return values


def _computer_s(free: FreeRunning, time_s: Array) -> Array:
    """The computer's clock, in its steps."""
    exact = free.computer_zero_s + time_s * (1 + free.computer_rate_error)
    return np.asarray(np.floor(exact / _ONE_TICK_S) * _ONE_TICK_S)


def _camera_ticks(free: FreeRunning, time_s: Array) -> Ticks:
    ticks = np.floor(time_s * (1 + free.rate_error) * free.timestamp_frequency_hz).astype(np.int64)
    return ticks + free.camera_zero_ticks


def _exchanges(
    free: FreeRunning, ends: tuple[float, float], *, random: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Computer's clock, moment of the reading, computer's clock again: a short way there and another back, shapes (n,)."""
    asked = np.sort(random.uniform(*ends, free.n_exchanges))
    there, back = (
        free.exchange_shortest_s + free.exchange_scale_s * random.standard_gamma(1.0, asked.size) for _ in range(2)
    )
    return _computer_s(free, asked), asked + there, _computer_s(free, asked + there + back) + _ONE_TICK_S
