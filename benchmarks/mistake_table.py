"""Mistakes that a laboratory makes: each changes a sound recording, or what rig.toml says of a sound rig.

A mistake is a function of a `Case` that gives another one. Its docstring says what happened; `harmless` ones leave every number
right, and must raise no doubt.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias, final

import numpy as np

from irtiming.archive.frame_stack import ArrayFrames
from irtiming.records.recording import NonuniformityReference, Recording
from irtiming.records.rig import CameraOptics, Latency, Measured, Rig

Camera: TypeAlias = Literal["photon", "microbolometer"]
BOTH: tuple[Camera, ...] = ("photon", "microbolometer")
Pixels: TypeAlias = np.ndarray[Any, Any]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A recording, what its rig.toml says, and other recordings of the same rig to go with it; ``other`` makes them."""

    recording: Recording
    rig: Rig
    other: Callable[[str], Recording]
    together: tuple[Recording, ...] = ()

    @property
    def frames(self) -> Pixels:
        """A copy as numbers, shape (frame, row, column)."""
        return self.recording.frames.pick(list(range(self.recording.frames.shape[0]))).astype(np.float64)

    @property
    def half(self) -> int:
        """The middle of the run."""
        return self.recording.frames.shape[0] // 2

    def told(self, **changed: Any) -> "Case":
        """With other words about the recording."""
        return replace(self, recording=replace(self.recording, **changed))

    def seen(self, frames: Pixels, **changed: Any) -> "Case":
        """With other frames."""
        highest = 2**self.recording.bit_depth - 1
        stack = ArrayFrames(np.clip(np.rint(frames), 0, highest).astype(np.uint16))
        return self.told(frames=stack, **changed)

    def beams(self, **changed: Any) -> "Case":
        return replace(self, rig=replace(self.rig, light_gates=replace(self.rig.light_gates, **changed)))

    def mask(self, **changed: Any) -> "Case":
        return replace(self, rig=replace(self.rig, mask_opening=replace(self.rig.mask_opening, **changed)))

    def wheel(self, **changed: Any) -> "Case":
        return replace(self, rig=replace(self.rig, wheel=replace(self.rig.wheel, **changed)))

    def references(self, change: Callable[[Pixels, Pixels], tuple[Pixels, Pixels]]) -> "Case":
        """With other non-uniformity references."""
        given: NonuniformityReference | None = self.recording.nonuniformity
        assert given is not None
        low, high = change(given.low_dn, given.high_dn)
        return self.told(nonuniformity=replace(given, low_dn=low, high_dn=high, low_frames=None, high_frames=None))


Mistake: TypeAlias = Callable[[Case], Case]
ON_TRUST = {
    "mask-angle-2-degrees-off": "[mask] centre_angle_deg",
    "whole-slots-one-more": "whole_slots_between",
    "whole-slots-one-less": "whole_slots_between",
    "whole-slots-none": "whole_slots_between",
    "whole-slots-twice": "whole_slots_between",
    "height-difference-8-for-5.5-mm": "height_difference_mm",
    "height-difference-8-for-5.5-mm-height-by-ruler": "height_difference_mm",
    "half-separation-is-whole": "half_separation_mm",
    "separation-and-height-difference-exchanged": "half_separation_mm",
    "lateral-offset-1-mm": "lateral_offset_mm",
    "latency-of-application-gate-200-us": "[latency]",
    "latency-of-gates-ms-for-us": "[latency]",
    "latency-of-trigger-1-ms": "[latency]",
    "latency-of-trigger-minus-1-ms": "[latency]",
    "trigger-stamped-at-its-other-edge-1-ms": "that the trigger is stamped at the edge",
    "trigger-stamped-at-its-other-edge-100-us": "that the trigger is stamped at the edge",
    "gates-on-another-counter-10-ms": "by the counter that stamps the gates",
    "control-gate-of-wrong-polarity": "that the control gate stamps the edge",
    "control-gate-stamped-1-ms-late": "that the control gate stamps the edge",
    "set-delay-1-ms-not-set": "trigger_delay_time_set",
    "set-delay-100-us-not-set": "trigger_delay_time_set",
    "set-delay-of-other-sign": "trigger_delay_time_set",
    "clock-and-wheel-speed-1.7-percent-off": "clock_frequency",
    "count-time-500-for-250-us": "count_time",
    "count-time-200-for-250-us": "count_time",
}
"""Mistakes that a recording at one wheel speed cannot show, with the words by which the result lists them as taken on trust."""

MISTAKES: dict[str, tuple[Mistake, tuple[Camera, ...], bool]] = {}
"""By name: the mistake, whose camera makes it, whether it is harmless."""


def mistake(*cameras: Camera, harmless: bool = False, name: str = "") -> Callable[[Mistake], Mistake]:
    """Put a function into the table."""

    def put(made: Mistake) -> Mistake:
        MISTAKES[name or made.__name__.strip("_").replace("_", "-")] = (made, cameras or BOTH, harmless)
        return made

    return put


def put(name: str, made: Mistake, *cameras: Camera, harmless: bool = False) -> None:
    """Put one line into the table."""
    mistake(*cameras, harmless=harmless, name=name)(made)


def scaled(number: Measured, factor: float) -> Measured:
    return replace(number, value=number.value * factor)


def added(number: Measured, more: float) -> Measured:
    return replace(number, value=number.value + more)


def ticks_of(case: Case, seconds: float) -> int:
    return round(seconds * case.recording.clock_frequency_hz)


# --- nothing, or nothing that matters ------------------------------------------------------------------------------------


put("none", lambda c: c, harmless=True)


@mistake(harmless=True)
def frames_lost_and_numbered(c: Case) -> Case:
    """Ten frames lost, and the numbers say which."""
    kept = np.setdiff1d(np.arange(2 * c.half), [7, 50, 51, 120, 200, 201, 202, 333, 400, 480])
    return c.seen(c.frames[kept], frame_number=kept)


@mistake(harmless=True)
def last_frames_lost(c: Case) -> Case:
    """The last five frames lost."""
    return c.seen(c.frames[:-5], frame_number=np.arange(2 * c.half - 5))


@mistake(harmless=True)
def two_control_slots_lost(c: Case) -> Case:
    """Two edges of the control gate were not stamped."""
    return c.told(control_slot_ticks=np.delete(c.recording.control_slot_ticks, [1000, 1707]))


put("ruler-height-stated", lambda c: c.beams(height_m=47.3e-3), harmless=True)
put("camera-rolled-by-hand-1-px", lambda c: c.seen(np.roll(c.frames, 1, axis=2)), "microbolometer", harmless=True)


# --- triggers and frames -------------------------------------------------------------------------------------------------


def _shifted(c: Case, by: int) -> Case:
    """Each frame is given the trigger ``by`` before its own."""
    n = 2 * c.half
    frames = c.frames[by:] if by > 0 else c.frames[:by]
    numbers = np.arange(n - abs(by)) if by > 0 else np.arange(-by, n)
    return c.seen(frames, frame_number=numbers)


put("first-trigger-missed-renumbered", lambda c: _shifted(c, 1))
put("first-two-triggers-missed-renumbered", lambda c: _shifted(c, 2))
put("ten-triggers-missed-renumbered", lambda c: _shifted(c, 10))
put("frame-numbers-count-from-one", lambda c: _shifted(c, -1))


def _lost(c: Case, at: list[int]) -> Case:
    frames = np.delete(c.frames, at, axis=0)
    return c.seen(frames, frame_number=np.arange(len(frames)))


put("frame-lost-in-the-middle-renumbered", lambda c: _lost(c, [c.half]))
put("frame-lost-near-the-end-renumbered", lambda c: _lost(c, [2 * c.half - 30]))
put("five-frames-lost-renumbered", lambda c: _lost(c, [60, 150, 260, 340, 450]))


@mistake()
def frame_twice_in_the_middle_renumbered(c: Case) -> Case:
    """One frame was delivered twice, and the last did not fit in."""
    frames = np.insert(c.frames, c.half, c.frames[c.half], axis=0)[:-1]
    return c.seen(frames)


@mistake()
def frame_lost_and_another_won(c: Case) -> Case:
    """Frames 200 to 299 are one late, the others right."""
    frames = c.frames
    frames[200:300] = frames[201:301]
    return c.seen(frames)


@mistake()
def frames_reversed(c: Case) -> Case:
    """Last frame first."""
    return c.seen(c.frames[::-1])


@mistake()
def two_frames_exchanged(c: Case) -> Case:
    """Two frames that followed each other came in the other order, ten times."""
    frames = c.frames
    for k in range(20, 500, 50):
        frames[[k, k + 1]] = frames[[k + 1, k]]
    return c.seen(frames)


@mistake()
def every_tenth_frame_repeated(c: Case) -> Case:
    """The camera shows the frame before once in ten."""
    frames = c.frames
    frames[10::10] = frames[9:-1:10]
    return c.seen(frames)


@mistake()
def triggers_jump_by_1_ms(c: Case) -> Case:
    """From the middle on the timestamps of the triggers are 1 ms late, which contradicts camera_period."""
    ticks = c.recording.camera_trigger_ticks.copy()
    ticks[c.half :] += ticks_of(c, 1e-3)
    return c.told(camera_trigger_ticks=ticks)


@mistake()
def triggers_stamped_by_the_computer(c: Case) -> Case:
    """Triggers are stamped to the millisecond."""
    step = ticks_of(c, 1e-3)
    return c.told(camera_trigger_ticks=c.recording.camera_trigger_ticks // step * step)


@mistake()
def triggers_jitter_by_200_us(c: Case) -> Case:
    """Each trigger is stamped up to 200 us late."""
    late = np.random.default_rng(1).integers(0, ticks_of(c, 200e-6), c.recording.camera_trigger_ticks.size)
    return c.told(camera_trigger_ticks=c.recording.camera_trigger_ticks + late)


def _later(c: Case, seconds: float, *streams: str) -> Case:
    more = ticks_of(c, seconds)
    return c.told(**{name: getattr(c.recording, name) + more for name in streams})


_GATES = ("control_slot_ticks", "application_slot_ticks", "application_edge_ticks")
put("trigger-stamped-at-its-other-edge-1-ms", lambda c: _later(c, 1e-3, "camera_trigger_ticks"))
put("trigger-stamped-at-its-other-edge-100-us", lambda c: _later(c, 100e-6, "camera_trigger_ticks"))
put("gates-on-another-counter-10-ms", lambda c: _later(c, 10e-3, *_GATES))
put("control-gate-stamped-1-ms-late", lambda c: _later(c, 1e-3, "control_slot_ticks"))


def _from_half(c: Case, seconds: float, *streams: str) -> Case:
    at = c.recording.camera_trigger_ticks[c.half]
    changed = {}
    for name in streams:
        ticks = getattr(c.recording, name).copy()
        ticks[ticks > at] += ticks_of(c, seconds)
        changed[name] = ticks
    return c.told(**changed)


put("disk-slips-on-its-axle-10-mrad", lambda c: _from_half(c, 10e-3 / 18.85, *_GATES))
put("counter-loses-a-second", lambda c: _from_half(c, -1.0, *_GATES, "camera_trigger_ticks"))
put("gates-counter-slips-2-ms", lambda c: _from_half(c, 2e-3, *_GATES))


@mistake()
def counter_of_32_bits_wraps(c: Case) -> Case:
    """The counter begins anew in the middle of the run."""
    at = int(c.recording.camera_trigger_ticks[c.half])
    names = (*_GATES, "camera_trigger_ticks")
    return c.told(
        **{name: (getattr(c.recording, name) - at) % 2**32 for name in names if getattr(c.recording, name) is not None}
    )


@mistake()
def trigger_before_the_run_stamped(c: Case) -> Case:
    """A trigger before the camera was armed was stamped, and frames are counted from it."""
    ticks = c.recording.camera_trigger_ticks
    return c.told(camera_trigger_ticks=np.insert(ticks, 0, ticks[0] - (ticks[1] - ticks[0])))


@mistake()
def every_second_trigger_without_frame(c: Case) -> Case:
    """The camera takes every second trigger, and nobody numbered the frames."""
    return c.seen(c.frames[::2], frame_number=np.arange(c.half))


# --- gates, wheel, clock -------------------------------------------------------------------------------------------------


@mistake()
def lines_of_gates_exchanged(c: Case) -> Case:
    """The two light gates' cables are exchanged."""
    one = c.recording
    return c.told(control_slot_ticks=one.application_slot_ticks, application_slot_ticks=one.control_slot_ticks)


@mistake()
def application_slot_holds_edges_1_and_3(c: Case) -> Case:
    """The application gate's polarity is wrong."""
    edges, slots = c.recording.application_edge_ticks, c.recording.application_slot_ticks
    if edges is not None:
        return c.told(application_slot_ticks=np.setdiff1d(edges, slots))
    quarter = np.diff(slots) // 2
    return c.told(application_slot_ticks=slots[:-1] + quarter)


@mistake()
def control_gate_of_wrong_polarity(c: Case) -> Case:
    """The control gate stamps the other edge of each slot, half a pitch away."""
    ticks = c.recording.control_slot_ticks
    return c.told(control_slot_ticks=(ticks[:-1] + ticks[1:]) // 2)


@mistake()
def one_control_slot_blocked(c: Case) -> Case:
    """One slot of the ring is full of dirt."""
    ticks = c.recording.control_slot_ticks
    return c.told(control_slot_ticks=ticks[np.arange(ticks.size) % 100 != 17])


@mistake()
def control_slots_bounce(c: Case) -> Case:
    """Thirty slots were stamped twice within 20 us."""
    ticks = c.recording.control_slot_ticks
    again = ticks[50:3050:100] + ticks_of(c, 20e-6)
    return c.told(control_slot_ticks=np.sort(np.concatenate([ticks, again])))


@mistake()
def control_gate_jitters_by_50_us(c: Case) -> Case:
    """Slots are stamped late by chance."""
    ticks = c.recording.control_slot_ticks
    late = np.random.default_rng(2).integers(0, ticks_of(c, 50e-6), ticks.size)
    return c.told(control_slot_ticks=ticks + late)


@mistake()
def application_edge_lost(c: Case) -> Case:
    """One edge of the application gate was not stamped."""
    return c.told(application_slot_ticks=np.delete(c.recording.application_slot_ticks, 30))


put("clock-50-for-49.152-MHz", lambda c: c.told(clock_frequency_hz=50e6))
put("clock-49.2-for-49.152-MHz", lambda c: c.told(clock_frequency_hz=49.2e6))
put("clock-24.576-for-49.152-MHz", lambda c: c.told(clock_frequency_hz=24.576e6))
put("clock-and-wheel-speed-1.7-percent-off", lambda c: c.told(clock_frequency_hz=50e6, rotation_speed_hz=3.0517578))
put("wheel-speed-3.1-for-3-Hz", lambda c: c.told(rotation_speed_hz=3.1))
put("wheel-speed-3.01-for-3-Hz", lambda c: c.told(rotation_speed_hz=3.01))
put("wheel-speed-of-two-cutouts-6-Hz", lambda c: c.told(rotation_speed_hz=6.0))
put("wheel-speed-180-per-minute", lambda c: c.told(rotation_speed_hz=180.0))
put("control-slots-99", lambda c: c.wheel(control_slots=99))
put("control-slots-50", lambda c: c.wheel(control_slots=50))
put("control-slots-200", lambda c: c.wheel(control_slots=200))
put(
    "rotation-other-way",
    lambda c: c.wheel(rotation="counterclockwise" if c.rig.wheel.rotation == "clockwise" else "clockwise"),
)


def _edges(c: Case, change: Callable[[np.ndarray[Any, Any]], Any]) -> Case:
    given = c.rig.wheel.cutout_edges_rad
    assert given is not None
    a, b, d, e = (float(one) for one in change(np.array([one.value for one in given])))
    u = given[0].standard_uncertainty
    return c.wheel(cutout_edges_rad=(Measured(a, u), Measured(b, u), Measured(d, u), Measured(e, u)))


put("edges-of-rig-in-degrees", lambda c: _edges(c, np.degrees))
put("edges-of-rig-counted-backwards", lambda c: _edges(c, lambda a: np.sort((2 * math.pi - a) % (2 * math.pi))))
put("edge-1-of-rig-wrong-by-0.1-rad", lambda c: _edges(c, lambda a: a + np.array([0, 0.1, 0, 0])))
put("edge-1-of-rig-wrong-by-10-mrad", lambda c: _edges(c, lambda a: a + np.array([0, 0.01, 0, 0])))
put("edges-1-and-3-of-rig-wrong-by-10-mrad", lambda c: _edges(c, lambda a: a + np.array([0, 0.01, 0, 0.01])))


# --- rig.toml ------------------------------------------------------------------------------------------------------------

put(
    "mask-angle-10-degrees-off",
    lambda c: c.mask(centre_angle_rad=added(c.rig.mask_opening.centre_angle_rad, math.radians(10))),
)
put(
    "mask-angle-minus-10-degrees-off",
    lambda c: c.mask(centre_angle_rad=added(c.rig.mask_opening.centre_angle_rad, math.radians(-10))),
)
put(
    "mask-angle-2-degrees-off",
    lambda c: c.mask(centre_angle_rad=added(c.rig.mask_opening.centre_angle_rad, math.radians(2))),
)
put("mask-angle-of-other-sign", lambda c: c.mask(centre_angle_rad=scaled(c.rig.mask_opening.centre_angle_rad, -1)))
put(
    "mask-angle-from-the-vertical",
    lambda c: c.mask(centre_angle_rad=added(c.rig.mask_opening.centre_angle_rad, math.pi / 2)),
)
put(
    "mask-angle-radians-for-degrees",
    lambda c: c.mask(centre_angle_rad=scaled(c.rig.mask_opening.centre_angle_rad, math.radians(1))),
)
put("mask-opening-half-of-it", lambda c: c.mask(opening_angle_rad=scaled(c.rig.mask_opening.opening_angle_rad, 0.5)))
put(
    "mask-opening-70-for-75-degrees",
    lambda c: c.mask(opening_angle_rad=scaled(c.rig.mask_opening.opening_angle_rad, 70 / 75)),
)
put("whole-slots-one-more", lambda c: c.beams(whole_slots_between=c.rig.light_gates.whole_slots_between + 1))
put("whole-slots-one-less", lambda c: c.beams(whole_slots_between=c.rig.light_gates.whole_slots_between - 1))
put(
    "whole-slots-one-more-height-by-ruler",
    lambda c: c.beams(whole_slots_between=c.rig.light_gates.whole_slots_between + 1, height_m=47.3e-3),
)
put("whole-slots-none", lambda c: c.beams(whole_slots_between=0))
put("whole-slots-twice", lambda c: c.beams(whole_slots_between=2 * c.rig.light_gates.whole_slots_between))
put(
    "height-difference-8-for-5.5-mm",
    lambda c: c.beams(height_difference_m=scaled(c.rig.light_gates.height_difference_m, 8 / 5.5)),
)
put(
    "height-difference-8-for-5.5-mm-height-by-ruler",
    lambda c: c.beams(height_difference_m=Measured(8e-3, 5e-5), height_m=47.3e-3),
)
put(
    "height-difference-of-other-sign",
    lambda c: c.beams(height_difference_m=scaled(c.rig.light_gates.height_difference_m, -1)),
)
put("half-separation-is-whole", lambda c: c.beams(half_separation_m=scaled(c.rig.light_gates.half_separation_m, 2)))
put(
    "half-separation-is-whole-height-by-ruler",
    lambda c: c.beams(half_separation_m=scaled(c.rig.light_gates.half_separation_m, 2), height_m=47.3e-3),
)
put("half-separation-in-metres", lambda c: c.beams(half_separation_m=scaled(c.rig.light_gates.half_separation_m, 1000)))
put(
    "height-difference-in-metres",
    lambda c: c.beams(height_difference_m=scaled(c.rig.light_gates.height_difference_m, 1000)),
)
put(
    "separation-and-height-difference-exchanged",
    lambda c: c.beams(
        half_separation_m=c.rig.light_gates.height_difference_m, height_difference_m=c.rig.light_gates.half_separation_m
    ),
)
put("lateral-offset-1-mm", lambda c: c.beams(lateral_offset_m=Measured(1e-3, 5e-5)))


def _latency(c: Case, **late_us: float) -> Case:
    given = c.rig.latency or Latency()
    changed = {f"{name}_s": Measured(us * 1e-6, 0.3e-6) for name, us in late_us.items()}
    return replace(c, rig=replace(c.rig, latency=replace(given, **changed)))


put("latency-of-gates-ms-for-us", lambda c: _latency(c, application_gate=5000.0, control_gate=3000.0))
put("latency-of-application-gate-200-us", lambda c: _latency(c, application_gate=200.0))
put("latency-of-trigger-1-ms", lambda c: _latency(c, trigger=1000.0))
put("latency-of-trigger-minus-1-ms", lambda c: _latency(c, trigger=-1000.0))


def _optics(c: Case, **changed: Any) -> Case:
    optics: CameraOptics = replace(c.rig.camera, **changed)
    return replace(c, rig=replace(c.rig, camera=optics))


put("distortion-of-other-sign-0.1", lambda c: _optics(c, distortion=Measured(0.1, 0.002)))
put("memory-stated-20-percent", lambda c: _optics(c, frame_memory=Measured(0.2, 0.001)))
put("set-delay-1-ms-not-set", lambda c: c.told(trigger_delay_time_set_s=1e-3))
put("set-delay-100-us-not-set", lambda c: c.told(trigger_delay_time_set_s=100e-6))
put("set-delay-25-ms-not-set", lambda c: c.told(trigger_delay_time_set_s=25e-3))
put("set-delay-of-other-sign", lambda c: c.told(trigger_delay_time_set_s=-1e-3))
put("count-time-500-for-250-us", lambda c: c.told(integration_time_s=500e-6), "photon")
put("count-time-200-for-250-us", lambda c: c.told(integration_time_s=200e-6), "photon")
put("count-time-250-ms", lambda c: c.told(integration_time_s=0.25), "photon")
put("count-time-5-ms", lambda c: c.told(integration_time_s=5e-3), "photon")
put("count-time-250-ns", lambda c: c.told(integration_time_s=250e-9), "photon")
put(
    "photon-camera-called-microbolometer",
    lambda c: c.told(camera_type="microbolometer", readout_mode="rolling"),
    "photon",
)
put("snapshot-called-rolling", lambda c: c.told(readout_mode="rolling"), "photon")
put("rolling-called-snapshot", lambda c: c.told(readout_mode="snapshot"), "microbolometer")
put(
    "microbolometer-called-photon-camera",
    lambda c: c.told(camera_type="photon", readout_mode="rolling", integration_time_s=250e-6),
    "microbolometer",
)
put(
    "microbolometer-called-snapshot-photon-camera",
    lambda c: c.told(camera_type="photon", readout_mode="snapshot", integration_time_s=250e-6),
    "microbolometer",
)
