"""What rig.toml states beside angles, as numbers that all recordings share; and what it leaves out, said aloud.

Latencies and the clock's error are taken off where the wheel's angles are made (`irtiming.physics.latency`); what is left of each
is a shared number about zero with the uncertainty that rig.toml states. What rig.toml does not state is corrected by nothing and,
but for the clock, is in no uncertainty: then there is a finding, and the result names it beside its first number.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.estimate.shared_numbers import SharedNumber
from irtiming.physics import latency
from irtiming.physics.latency import USUAL_CLOCK, USUAL_TAIL
from irtiming.physics.wheel import TURN
from irtiming.records import sources
from irtiming.records.estimate import EDGE_DELAYS, RecordingFit
from irtiming.records.finding import Finding
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Latency, LightGates, Measured, Rig, WindowTail
from irtiming.records.wheel_geometry import WheelGeometry
from irtiming.records.wheel_track import WheelTrack

CLOCK = "clock_error"
EVENT_SOURCE = "scatter of the frames' stamps"
_EXACT = Measured(0.0)
_NEAR_WHOLE = 0.01  # slots: nearer, neither slots nor eyes are even enough
_SAME_SPEED = 1.02
_CONTRADICTS = 4.0  # standard uncertainties
_TIMES = (*EDGE_DELAYS, "integration_time", "time_constant", "row_delay")


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RigErrors:
    """What is known of a rig beside its angles.

    Parameters
    ----------
    shared
        What is left of latencies and clock, with their priors.
    clock
        Relative error of the clock, which the recordings' times already know, and its standard uncertainty.
    u_window_s
        Of the integration time that the recordings state; None where unknown.
    window_tail
        What is known of what comes after the window; None of a camera without one.
    is_window_on_trust
        Whether the start counts on a length that recordings state and rig.toml does not vouch for, and on nothing after it.
    frame_memory
        Share of the frame before in each frame; None where the frames alone tell it.
    findings
        What rig.toml leaves out, or states without an uncertainty.
    not_held
        What the uncertainty of an absolute delay therefore does not include, in words.
    """

    shared: tuple[SharedNumber, ...] = ()
    clock: Measured = _EXACT
    u_window_s: float | None = None
    window_tail: WindowTail | None = None
    is_window_on_trust: bool = False
    frame_memory: Measured | None = None
    findings: tuple[Finding, ...] = ()
    not_held: tuple[str, ...] = ()


def of(
    recordings: Sequence[ReducedRecording], fits: Sequence[RecordingFit], *, rig: Rig, geometry: WheelGeometry
) -> RigErrors:
    """What rig.toml knows of latencies, clock and integration time.

    Parameters
    ----------
    recordings, fits
        In the same order; their speeds, and the sizes of their times, which a clock makes wrong in proportion.
    rig
        As measured by its owner.
    geometry
        How the gates' angle follows from their distance.
    """
    clock = USUAL_CLOCK if rig.clock is None else rig.clock.relative_error
    shared = [
        *_latencies(recordings, rig.latency, geometry),
        *_event_grids(recordings),
        *_clock(recordings, fits, clock),
    ]
    speeds = [fit.angular_frequency_rad_per_s for fit in fits]
    several = speeds_differ(speeds)
    missing = [words for name, words in _LATENCIES.items() if getattr(rig.latency or Latency(), f"{name}_s") is None]
    not_held = [f"latency of {_listed(missing)}"] if missing else []
    if rig.light_gates.lateral_offset_m is None and not several:
        not_held.append(sources.BEAM_OFFSET)
    return RigErrors(
        shared=tuple(shared),
        clock=clock,
        u_window_s=rig.camera.integration_time_u_s,
        window_tail=_tail(recordings, rig),
        is_window_on_trust=_is_window_on_trust(recordings, rig),
        frame_memory=rig.camera.frame_memory,
        findings=(
            *_of_latency(rig.latency, missing),
            *_of_registers([one.track for one in recordings], rig.latency),
            *_of_slots([one.track for one in recordings], rig),
            *_of_clock(rig),
            *_of_tail(recordings, rig),
            *_of_offset(rig.light_gates, several=several),
        ),
        not_held=tuple(not_held),
    )


def _tail(recordings: Sequence[ReducedRecording], rig: Rig) -> WindowTail | None:
    """What is known of what comes after the window of a photon camera."""
    return (rig.camera.window_tail or USUAL_TAIL) if recordings[0].camera_type == "photon" else None


def _is_window_on_trust(recordings: Sequence[ReducedRecording], rig: Rig) -> bool:
    """Whether recordings state the length of a window of which rig.toml says nothing."""
    is_stated = recordings[0].integration_time_s is not None
    return is_stated and latency.window_tail(rig.camera) is None


def _of_tail(recordings: Sequence[ReducedRecording], rig: Rig) -> list[Finding]:
    if _tail(recordings, rig) is None or rig.camera.window_tail is not None or _is_window_on_trust(recordings, rig):
        return []
    usual = USUAL_TAIL
    return [
        Finding(
            code="window-tail-not-stated",
            severity="info",
            what="rig.toml states no window_tail: nothing is taken to come after the window, with u = "
            f"{100 * usual.share.standard_uncertainty:.2g} % of all that the camera takes in, over "
            f"{1e3 * usual.time_constant_s:g} ms, in the budgets of trigger_delay and integration_time",
            cure="measure it with a pulse of light, and state [camera] window_tail and window_tail_u; "
            "exposure_midpoint_delay does not depend on it",
        )
    ]


def _latencies(
    recordings: Sequence[ReducedRecording], given: Latency | None, geometry: WheelGeometry
) -> list[SharedNumber]:
    """What each latency is beyond its stated value, s."""
    tracks = [one.track for one in recordings]
    registers = [t.register_rad_per_s or t.angular_frequency_rad_per_s for t in tracks]
    effects = [
        latency.effects_s(
            angular_frequency_rad_per_s=track.angular_frequency_rad_per_s,
            register_rad_per_s=register,
            gates_rad_per_s=float(np.mean(registers)),
            per_separation=geometry.gates.sensitivity[0],
        )
        for track, register in zip(tracks, registers, strict=True)
    ]
    late = given or Latency()
    in_common_s = late.gates_common_u_s or 0.0
    found = []
    for name, source in sources.LATENCIES.items():
        number: Measured | None = getattr(late, f"{name}_s")
        common_s = in_common_s if name in _GATES else 0.0
        if number is not None and number.standard_uncertainty > common_s:
            u = float(np.sqrt(number.standard_uncertainty**2 - common_s**2))
            found.append(_latency(name, [effect[name] for effect in effects], u=u, source=source))
    if in_common_s > 0:
        both = [sum(effect[name] for name in _GATES) for effect in effects]
        found.append(_latency("gates", both, u=in_common_s, source=sources.BOTH_GATES))
    return found


def _latency(name: str, effects: Sequence[float], *, u: float, source: str) -> SharedNumber:
    by_recording = [dict.fromkeys(EDGE_DELAYS, effect) for effect in effects]
    return SharedNumber(name=f"latency_{name}", effects=by_recording, u=u, source=source, kind="B", measured=(u, "s"))


def _event_grids(recordings: Sequence[ReducedRecording]) -> list[SharedNumber]:
    """By how much the grid through the stamps of each recording may lie beside its place, s; none of triggers or strobes."""
    found = []
    for place, one in enumerate(recordings):
        u = 0.0 if one.events is None else one.events.u_grid_s
        if u > 0:
            effects = [dict.fromkeys(EDGE_DELAYS, 1.0) if k == place else {} for k in range(len(recordings))]
            found.append(SharedNumber(name=f"event_grid_{place}", effects=effects, u=u, source=EVENT_SOURCE, kind="A"))
    return found


def _clock(recordings: Sequence[ReducedRecording], fits: Sequence[RecordingFit], clock: Measured) -> list[SharedNumber]:
    """What the clock's relative error is beyond its stated value: it makes every time as much too long."""
    u = clock.standard_uncertainty
    if u <= 0:
        return []
    effects = []
    for one, fit in zip(recordings, fits, strict=True):
        sizes = {name: fit.estimate.value(name) for name in _TIMES if name in fit.estimate}
        effects.append({"integration_time": one.integration_time_s or 0.0} | sizes)
    return [SharedNumber(name=CLOCK, unit="1", effects=effects, u=u, source=sources.CLOCK, kind="B", measured=(u, "1"))]


_GATES = ("application_gate", "control_gate")
_LATENCIES = {"application_gate": "application gate", "control_gate": "control gate", "trigger": "trigger path"}


def speeds_differ(speeds: Sequence[float]) -> bool:
    """Whether wheel speeds differ by enough to tell an angle from a delay."""
    return max(speeds) > _SAME_SPEED * min(speeds)


def _listed(words: Sequence[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else words[0]


def _of_latency(given: Latency | None, missing: Sequence[str]) -> list[Finding]:
    found = []
    if missing:
        found.append(
            Finding(
                code="latency-not-stated",
                severity="doubt",
                what=f"rig.toml states no latency of {_listed(missing)}: by what edges are late the delay is too long, and its "
                "uncertainty does not include that",
                cure="measure it and state it in [latency]",
            )
        )
    numbers = {words: getattr(given or Latency(), f"{name}_s") for name, words in _LATENCIES.items()}
    exact = [words for words, number in numbers.items() if number is not None and number.standard_uncertainty == 0]
    if exact:
        found.append(
            _without_u(
                code="latency-without-uncertainty", what=f"latency of {_listed(exact)}", key="[latency] ..._u_us"
            )
        )
    return found


def _of_registers(tracks: Sequence[WheelTrack], given: Latency | None) -> list[Finding]:
    """Where the gates seem further apart at one wheel speed than at another: one of them is later than rig.toml says.

    Recordings whose gate distances agree within their jitter share one, and say nothing of it.
    """
    speeds = [track.angular_frequency_rad_per_s for track in tracks]
    slots = [track.slot_deviation_rad for track in tracks]
    is_apart = all(track.register_rad_per_s is None for track in tracks)
    if not speeds_differ(speeds) or not is_apart or any(np.any(one != slots[0]) for one in slots):
        return []
    late_s = float(np.polyfit(speeds, [track.gate_separation_rad for track in tracks], 1)[0])
    known = given or Latency()
    stated = [number for number in (known.application_gate_s, known.control_gate_s) if number is not None]
    if abs(late_s) <= _CONTRADICTS * float(np.hypot.reduce([0.0, *(number.standard_uncertainty for number in stated)])):
        return []
    first, second = ("application gate", "control gate") if late_s > 0 else ("control gate", "application gate")
    return [
        Finding(
            code="gates-late-apart",
            severity="doubt",
            what=f"the gates seem {'further' if late_s > 0 else 'less far'} apart the faster the wheel turns: edges of the "
            f"{first} are {1e6 * abs(late_s):.2g} µs later against those of the {second} than rig.toml says",
            cure="measure both gates' latencies (irtiming latency gates) and state them in [latency]",
        )
    ]


def _of_slots(tracks: Sequence[WheelTrack], rig: Rig) -> list[Finding]:
    """Where the beams stand so near to a whole number of slots that two people may count different ones, and no ruler tells."""
    pitch_rad = TURN / rig.wheel.control_slots
    apart = float(np.mean([track.gate_separation_rad for track in tracks])) / pitch_rad
    beside = apart - round(apart)
    if rig.light_gates.height_m is not None or abs(beside) >= _NEAR_WHOLE:
        return []
    between = rig.light_gates.whole_slots_between
    other = between + 1 if beside < 0 else between - 1
    wrong_s = pitch_rad / min(track.angular_frequency_rad_per_s for track in tracks)
    return [
        Finding(
            code="gates-near-whole-slots",
            severity="doubt",
            what=f"the beams are {apart:.3f} slots apart with [beams] whole_slots_between = {between}: so near to a whole number "
            f"that {other} may be right, and the delay wrong by a good part of {1e3 * wrong_s:.2f} ms",
            cure="measure the application beam's depth below the axle by a ruler and state it as [beams] height_mm: it tells",
        )
    ]


def _of_clock(rig: Rig) -> list[Finding]:
    if rig.clock is None:
        return [
            Finding(
                code="clock-not-stated",
                severity="info",
                what="rig.toml states no [clock]: a crystal within 50 ppm is taken for granted, which is in the budget",
                cure="irtiming clock measures it with a pulse per second",
            )
        ]
    if rig.clock.relative_error.standard_uncertainty > 0:
        return []
    return [
        _without_u(code="clock-without-uncertainty", what="relative error of the clock", key="[clock] relative_error_u")
    ]


def _of_offset(beams: LightGates, *, several: bool) -> list[Finding]:
    if beams.lateral_offset_m is None:
        beside = (
            "; several wheel speeds distinguish it from a delay"
            if several
            else ", and 0.1 mm is about 2 mrad: 100 µs at a wheel speed of 3 Hz"
        )
        return [
            Finding(
                code="lateral-offset-not-stated",
                severity="info" if several else "doubt",
                what="rig.toml states no lateral_offset_u_mm: the light beams are trusted to lie as far to the left as to the "
                f"right of the axle{beside}",
                cure="state [beams] lateral_offset_mm and lateral_offset_u_mm, or record at several speeds",
            )
        ]
    if beams.lateral_offset_m.standard_uncertainty > 0:
        return []
    return [
        _without_u(
            code="lateral-offset-without-uncertainty",
            what="lateral offset of the beams",
            key="[beams] lateral_offset_u_mm",
        )
    ]


def _without_u(*, code: str, what: str, key: str) -> Finding:
    return Finding(
        code=code,
        severity="warning",
        what=f"rig.toml states the {what} without an uncertainty: it counts as exact, and u of the delay is too small",
        cure=f"state {key}",
    )
