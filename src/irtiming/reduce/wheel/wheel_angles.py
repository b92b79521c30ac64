"""From the ticks of both light gates to the wheel angle at any moment (Schatz 2023, 2.4 and 2.5)."""

from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics import latency
from irtiming.physics.covariance import hac_covariance
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Ticks
from irtiming.records.choices import ReferenceEdge
from irtiming.records.recording import Recording
from irtiming.records.rig import Rig
from irtiming.records.wheel_track import WheelTrack
from irtiming.reduce.wheel.edge_train import EdgeTrain, number_edges
from irtiming.reduce.wheel.slot_table import SlotTable, equal_slots, learn_slots

_OF_A_MEDIAN = float(np.sqrt(np.pi / 2))  # its standard deviation over that of a mean
_NEIGHBOURS = 4  # half turns whose scatter may be correlated
_LONGEST_BRIDGE = 3  # control slots; frames in a longer gap have no angle


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Gates:
    """Edges of both gates, numbered; times of the reference edge; number of the first control edge after it, modulo a turn.

    ``slots`` as they stand, from the first control edge on.
    """

    control: EdgeTrain
    application: EdgeTrain
    reference_ticks: Array
    first: int
    slots: SlotTable


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Register:
    """Control edges placed on the wheel: slot index and whole turns of each edge, and the table of the slots."""

    slot: Ticks
    turn: Ticks
    table: SlotTable


def track(
    recording: Recording, rig: Rig, *, slots: Literal["learned", "equal"] = "learned",
    reference_edge: ReferenceEdge = "automatic",
) -> WheelTrack:  # fmt: skip
    """Wheel angle at each control-slot edge.

    Parameters
    ----------
    recording
        Its ticks; frames are not touched.
    rig
        Number of slots, and of whole slots between the gates.
    slots
        ``"equal"`` takes the slots as regular, as published; ``"learned"`` measures them from the same timestamps.
    reference_edge
        Which application edge is the zero; automatic takes the one that precedes the longer interval.

    Raises
    ------
    ReductionError
        If a gate's edges cannot be numbered, the gates contradict each other, or the reference edge cannot be determined.

    Notes
    -----
    Learned slots know the latencies and the clock that rig.toml states (`irtiming.physics.latency`); equal ones, as published, do
    not.
    With the paper's rotation the control gate comes before the application gate on an edge's way, so slot j passes it
    at theta = alpha_j - dbeta. The first slot after the reference edge is number floor(dbeta / pitch) + 1.
    """
    return _track(recording, rig, _gates(recording, rig, reference_edge), learned=slots == "learned")


def both_tracks(
    recording: Recording, rig: Rig, *, reference_edge: ReferenceEdge = "automatic"
) -> tuple[WheelTrack, WheelTrack]:
    """Tracks with learned and with equal slots; parameters and errors as for `track`."""
    gates = _gates(recording, rig, reference_edge)
    return _track(recording, rig, gates, learned=True), _track(recording, rig, gates, learned=False)


def _gates(recording: Recording, rig: Rig, reference_edge: ReferenceEdge) -> _Gates:
    refuse_lost_timestamps(recording)
    n_slots = rig.wheel.control_slots
    turn_ticks = recording.clock_frequency_hz / recording.rotation_speed_hz
    control = number_edges(recording.control_slot_ticks, period_ticks=turn_ticks / n_slots, name="control_slot")
    application = _application(recording)
    reference = _reference_edges(application, reference_edge)
    late = latency.stated(rig.latency).register_s * recording.rotation_speed_hz * n_slots
    slots = learn_slots(control, n_slots)
    first = _first_slot_after(reference, control, slots, late_slots=late)
    return _Gates(control=control, application=application, reference_ticks=reference, first=first, slots=slots)


def refuse_lost_timestamps(recording: Recording) -> None:
    """Nothing, if every timestamp of the recording arrived as far as is known.

    Raises
    ------
    ReductionError
        If not, with the time of the first loss in seconds from the first trigger.
    """
    lost, triggers = recording.lost_after_ticks, recording.camera_trigger_ticks
    if lost is None or lost.size == 0:
        return
    after_s = float(lost[0] - triggers[0]) / recording.clock_frequency_hz
    more = f" and {lost.size - 1} times more" if lost.size > 1 else ""
    raise ReductionError(
        f"timestamps were lost {after_s:.6f} s after the first trigger{more}: records of the trigger generator never arrived, "
        "so the wheel's angles have a hole there; record again"
    )


def _track(recording: Recording, rig: Rig, gates: _Gates, *, learned: bool) -> WheelTrack:
    control, n_slots = gates.control, rig.wheel.control_slots
    late = latency.stated(rig.latency if learned else None)
    clock_error = rig.clock.relative_error.value if learned and rig.clock is not None else 0.0
    clock_hz = recording.clock_frequency_hz * (1 + clock_error)
    register = _register(gates, rig, learned=learned)
    table = register.table
    alpha = TURN * (register.turn + register.slot / n_slots) + table.deviation_rad[register.slot]
    at_reference = np.interp(gates.reference_ticks, control.ticks, alpha, left=np.nan, right=np.nan)
    separations = _circular(at_reference[np.isfinite(at_reference)])
    duration_s = (control.ticks[-1] - control.ticks[0]) / clock_hz
    omega = float(alpha[-1] - alpha[0]) / duration_s
    separation = float(separations.mean()) - omega * late.register_s
    ahead = omega * late.slots_s
    u_mean = separations.std(ddof=1) / np.sqrt(separations.size)
    ticks, angle = _break_long_gaps(control, alpha - separation + ahead)
    edges, u_edges = _application_edges(recording, ticks, angle)
    return WheelTrack(
        edge_ticks=ticks,
        edge_angle_rad=angle,
        clock_frequency_hz=clock_hz,
        angular_frequency_rad_per_s=omega,
        gate_separation_rad=separation,
        u_gate_separation_rad=float(np.hypot(u_mean, table.u_register_rad)),
        slot_deviation_rad=table.deviation_rad,
        u_slot_deviation_rad=table.u_deviation_rad,
        order_variance_rad2=table.order_variance_rad2,
        application_edges_rad=edges,
        u_application_edges_rad=u_edges,
        findings=control.findings("control_slot", recording=recording.name)
        + gates.application.findings("application_slot", recording=recording.name),
        ahead_rad=ahead,
        clock_relative_error=clock_error,
    )


def frame_trigger_ticks(recording: Recording) -> Ticks:
    """Nominal trigger of each frame, shape (n_frame,), ticks: a lost frame skips its trigger.

    Raises
    ------
    ReductionError
        If a frame number points outside the triggers.
    """
    n_triggers = recording.camera_trigger_ticks.size
    if (
        recording.frame_number.size
        and not 0 <= recording.frame_number.min() <= recording.frame_number.max() < n_triggers
    ):
        raise ReductionError(
            f"frame_number runs from {recording.frame_number.min()} to {recording.frame_number.max()}, but there are "
            f"{n_triggers} camera triggers; a frame must belong to a recorded trigger"
        )
    return recording.camera_trigger_ticks[recording.frame_number]


def tells_reference(recording: Recording) -> bool:
    """Whether the timestamps tell which half turn is longer; so too where they tell nothing, which another error says.

    Parameters
    ----------
    recording
        Its ticks.
    """
    try:
        return not _longer_half(_application(recording)).is_hidden
    except ReductionError:
        return True


def _application(recording: Recording) -> EdgeTrain:
    turn_ticks = recording.clock_frequency_hz / recording.rotation_speed_hz
    ticks = recording.application_slot_ticks
    return number_edges(ticks, period_ticks=turn_ticks / 2, name="application_slot", tolerance=0.1)


@final
@dataclass(frozen=True, kw_only=True)
class _LongerHalf:
    """By how much the half turn after an even edge is longer, its standard uncertainty, and the mean of all, ticks."""

    difference: float
    u_difference: float
    half_turn: float

    @property
    def is_hidden(self) -> bool:
        """Whether it is less than a tick or 3 of its standard uncertainties."""
        return abs(self.difference) <= max(3 * self.u_difference, 1.0)


def _longer_half(application: EdgeTrain) -> _LongerHalf:
    """Each half turn is held against the mean of the one before and the one after it.

    So a wheel that slowly wanders does not blur the difference.
    """
    after = np.diff(application.ticks).astype(float)
    whole = np.diff(application.number) == 1
    among = whole[:-2] & whole[1:-1] & whole[2:]
    sign = np.where(application.number[1:-2] % 2 == 0, 1.0, -1.0)
    longer = (sign * (after[1:-1] - (after[:-2] + after[2:]) / 2))[among]
    if longer.size < 2:
        raise ReductionError(
            f"only {application.ticks.size} application edges: both half turns must be recorded at least twice; record longer"
        )
    difference, n = float(longer.mean()), longer.size
    spread = hac_covariance((longer - difference)[:, None], n_neighbours=min(_NEIGHBOURS, n - 1), is_circular=False)
    return _LongerHalf(
        difference=difference, u_difference=float(np.sqrt(spread[0, 0])) / (n - 1), half_turn=float(after[whole].mean())
    )


def _reference_edges(application: EdgeTrain, choice: ReferenceEdge) -> Array:
    """Times of the reference edge, the one before the longer half turn, ticks."""
    found = _longer_half(application)
    if choice == "automatic" and found.is_hidden:
        raise ReductionError(
            f"the two half turns differ by {abs(found.difference):.0f} of {found.half_turn:.0f} ticks, which is less than a tick "
            f"or 3 of its standard uncertainties ({found.u_difference:.0f} ticks): the reference edge cannot be determined; "
            "record longer or name it with --reference-edge first|second, or give a recording of the same wheel along that does"
        )
    parity = {"automatic": int(found.difference < 0), "first": 0, "second": 1}[choice]
    return application.ticks[application.number % 2 == parity].astype(float)


def _first_slot_after(reference: Array, control: EdgeTrain, slots: SlotTable, *, late_slots: float) -> int:
    """Number, modulo the slots per turn, of the first control edge after the reference edge; the same in every turn.

    It is the first on the even grid that the slots stand about: one that is made late does not come before an edge that lies
    between two of that grid. ``late_slots``: by how much the reference edge is timestamped later than the control edges.
    """
    n_slots = slots.deviation_rad.size
    place = control.number + slots.deviation_rad[control.number % n_slots] * n_slots / TURN
    phase = np.interp(reference, control.ticks, place, left=np.nan, right=np.nan) - late_slots
    phase = phase[np.isfinite(phase)]
    if phase.size == 0:
        raise ReductionError(
            "no reference edge lies between the first and the last control-slot edge; both gates must be recorded "
            "over the same time"
        )
    middle = _circular(TURN * phase / n_slots) * n_slots / TURN
    stray = np.abs(middle - np.median(middle))
    if stray.max() > 0.5:
        at = int(np.argmax(stray > 0.5))
        raise ReductionError(
            f"turn {at} of the application gate comes {middle[at] - np.median(middle):+.2f} control slots beside the "
            f"others, at most 0.5 can be jitter: {n_slots} slots per turn must hold; an edge was lost or added where "
            "it cannot be traced, or [wheel] control_slots is wrong"
        )
    return int(np.floor(np.median(middle))) + 1


def _circular(angle_rad: Array) -> Array:
    """Angles moved by whole turns next to their common direction, which is in [0, 2 pi)."""
    centre = np.angle(np.mean(np.exp(1j * angle_rad))) % TURN
    return centre + np.mod(angle_rad - centre + np.pi, TURN) - np.pi


def _register(gates: _Gates, rig: Rig, *, learned: bool) -> _Register:
    n_slots = rig.wheel.control_slots
    position = gates.control.number - gates.first + rig.light_gates.whole_slots_between + 1 + n_slots
    slot, turn = position % n_slots, position // n_slots
    table = equal_slots(n_slots)
    if learned:
        own, start = gates.slots, int(slot[0])
        table = SlotTable(deviation_rad=np.roll(own.deviation_rad, start), order_variance_rad2=own.order_variance_rad2)
    return _Register(slot=slot, turn=turn, table=table)


def _break_long_gaps(control: EdgeTrain, angle: Array) -> tuple[Ticks, Array]:
    """Insert an unknown angle into gaps too long to bridge, so that no frame there gets one."""
    gaps = np.flatnonzero(np.diff(control.number) > _LONGEST_BRIDGE) + 1
    middle = (control.ticks[gaps - 1] + control.ticks[gaps]) // 2
    return np.insert(control.ticks, gaps, middle), np.insert(angle, gaps, np.nan)


_FourAngles = tuple[float, float, float, float]


def _application_edges(
    recording: Recording, ticks: Ticks, angle: Array
) -> tuple[_FourAngles | None, _FourAngles | None]:
    """Mean angle of the four edges at the application gate relative to edge 0, where all four were recorded."""
    if recording.application_edge_ticks is None:
        return None, None
    passed = np.interp(recording.application_edge_ticks, ticks, angle, left=np.nan, right=np.nan)
    passed = passed[np.isfinite(passed)]
    quarter = np.rint(passed / (TURN / 4)).astype(int)
    beside = passed - quarter * (TURN / 4)
    groups = [beside[quarter % 4 == i] for i in range(4)]
    if min(group.size for group in groups) < 2:
        return None, None
    mean = [float(np.median(group)) for group in groups]
    u_mean = [_OF_A_MEDIAN * float(group.std(ddof=1) / np.sqrt(group.size)) for group in groups]
    a, b, c, d = (i * TURN / 4 + mean[i] - mean[0] for i in range(4))
    u_b, u_c, u_d = (float(np.hypot(u_mean[0], u)) for u in u_mean[1:])
    return (a, b, c, d), (u_mean[0], u_b, u_c, u_d)
