"""From the tracks of all recordings of a rig to the calibration of its wheel."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, final

import numpy as np

from irtiming.errors import ReductionError
from irtiming.physics import slot_orders
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.choices import ReferenceEdge
from irtiming.records.recording import Recording
from irtiming.records.rig import Rig
from irtiming.records.wheel_calibration import SlotsAtSpeed, WheelCalibration
from irtiming.records.wheel_track import WheelTrack
from irtiming.reduce.wheel.slot_ripple import separate
from irtiming.reduce.wheel.slot_table import SlotTable
from irtiming.reduce.wheel.slots_on_track import table_of, with_slots
from irtiming.reduce.wheel.wheel_angles import track

_SAME_SPEED = 1.01
_SIGNIFICANCE = 1e-6
_RATIO_OF_A_WARNING = 3.0  # chi-square per degree of freedom
_SHARE_OF_A_WARNING = 0.05  # of the slots' rms deviation; less does not matter
_NO_RIPPLE_BEYOND = 10  # orders; a torque of a higher one hardly moves the wheel


class WheelRun(Protocol):
    """What a calibration needs of a recording."""

    @property
    def name(self) -> str:
        """For messages."""
        ...

    @property
    def sha256(self) -> str:
        """Of its file; tells that it is the same recording."""
        ...

    @property
    def track(self) -> WheelTrack:
        """With its own slots, learned or equal."""
        ...


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Run:
    name: str
    sha256: str
    track: WheelTrack


def from_recordings(
    recordings: Iterable[Recording], rig: Rig, *, reference_edge: ReferenceEdge = "automatic"
) -> WheelCalibration:
    """Calibration from the timestamps of recordings of any camera at any speeds; frames are not touched.

    Parameters
    ----------
    recordings
        Of one wheel. Taken one after the other.
    rig
        Number of slots, and of whole slots between the gates.
    reference_edge
        As for `irtiming.reduce.wheel_angles.track`; to be named for a single recording only.

    Raises
    ------
    ReductionError
        If a recording's wheel angles cannot be determined, a recording is given twice, or there are no slots to learn.
    """
    runs: list[_Run] = []
    for recording in recordings:
        where = recording.source or recording.name
        if recording.sha256 and recording.sha256 in [run.sha256 for run in runs]:
            raise ReductionError(f"{where} is given twice (sha256 {recording.sha256[:12]}…); name each recording once")
        if runs and reference_edge != "automatic":
            raise ReductionError(
                f"the {reference_edge} application edge was named as reference, which may be another edge in {where} than in "
                f"{runs[0].name}; name it for one recording at a time"
            )
        try:
            found = track(recording, rig, reference_edge=reference_edge)
        except ReductionError as error:
            error.add_note(f"in {where}")
            raise
        runs.append(_Run(name=recording.name, sha256=recording.sha256, track=found))
    if not runs:
        raise ReductionError("no recording given; name at least one recording file")
    return calibrate(runs)


def calibrate(runs: Sequence[WheelRun], *, before: WheelCalibration | None = None) -> WheelCalibration:
    """Slots, ripple and register of a wheel, pooled over recordings of any speeds.

    Parameters
    ----------
    runs
        Recordings of one wheel; those with fewer than 9 turns tell nothing of the slots.
    before
        An earlier calibration of the same wheel. Its recordings count once; where it contradicts these, it is left out
        with a warning.

    Raises
    ------
    ReductionError
        If there are no slots to learn, or numbers of slots differ.
    """
    _refuse_other_rings(runs, before)
    known = before.sha256 if before else ()
    new = [run for run in runs if run.track.has_learned_slots and not (run.sha256 and run.sha256 in known)]
    own, warnings = _by_speed([_at_speed(run.track) for run in new])
    if before is not None and (doubt := _contradiction(own, before.speeds)):
        alone = calibrate(runs)
        return replace(alone, warnings=(doubt, *alone.warnings))
    earlier = before.speeds if before else ()
    if not own and not earlier:
        raise ReductionError(
            f"none of {', '.join(run.name for run in runs)} holds the 9 turns that are needed to learn the slots; record longer"
        )
    merged, more = _by_speed([*earlier, *own])
    speeds, apart = _of_one_wheel(merged)
    slots, ripple = separate(speeds)
    standing = [run.track for run in runs if stands_on(run.track, speeds)] or [run.track for run in runs]
    tracks = [with_slots(one, slots) for one in standing]
    separation, u_separation = _gate_separation(tracks, slots)
    edges, u_edges = _application_edges(tracks, slots)
    if edges is None and before is not None:
        edges, u_edges = before.application_edges_rad, before.u_application_edges_rad
    return WheelCalibration(
        slot_deviation_rad=slots.deviation_rad,
        order_variance_rad2=slots.order_variance_rad2,
        ripple=ripple,
        speeds=speeds,
        gate_separation_rad=separation,
        u_gate_separation_rad=u_separation,
        application_edges_rad=edges,
        u_application_edges_rad=u_edges,
        names=(*(before.names if before else ()), *(run.name for run in new)),
        sha256=(*(before.sha256 if before else ()), *(run.sha256 for run in new)),
        warnings=tuple(dict.fromkeys([*(before.warnings if before else ()), *warnings, *more, *apart])),
    )


def stands_on(found: WheelTrack, speeds: Sequence[SlotsAtSpeed]) -> bool:
    """Whether a track's own slots went into these, or it has none."""
    hz = found.angular_frequency_rad_per_s / TURN
    return not found.has_learned_slots or any(_is_same_speed(hz, one.rotation_speed_hz) for one in speeds)


def _is_same_speed(one_hz: float, other_hz: float) -> bool:
    return 1 / _SAME_SPEED < one_hz / other_hz < _SAME_SPEED


def _at_speed(found: WheelTrack) -> SlotsAtSpeed:
    table = table_of(found)
    known = found.edge_angle_rad[np.isfinite(found.edge_angle_rad)]
    return SlotsAtSpeed(
        rotation_speed_hz=found.angular_frequency_rad_per_s / TURN,
        n_turns=int((known[-1] - known[0]) / TURN),
        deviation_rad=table.deviation_rad,
        order_variance_rad2=table.order_variance_rad2,
    )


def _by_speed(tables: Iterable[SlotsAtSpeed]) -> tuple[tuple[SlotsAtSpeed, ...], list[str]]:
    """One table per speed, slowest first, and what does not fit together."""
    groups: list[list[SlotsAtSpeed]] = []
    for table in sorted(tables, key=lambda one: one.rotation_speed_hz):
        if groups and table.rotation_speed_hz < _SAME_SPEED * groups[-1][0].rotation_speed_hz:
            groups[-1].append(table)
        else:
            groups.append([table])
    merged = [_mean(group) for group in groups]
    return tuple(table for table, _ in merged), [text for _, text in merged if text]


def _mean(tables: list[SlotsAtSpeed]) -> tuple[SlotsAtSpeed, str]:
    """Weighted mean of tables at one speed; where they scatter more than their variances say, these are widened."""
    if len(tables) == 1:
        return tables[0], ""
    tables = _evened(tables)
    slots, _ = separate(tables)
    n_slots = slots.deviation_rad.size
    chi_square = sum(
        slot_orders.chi_square(one.deviation_rad - slots.deviation_rad, one.order_variance_rad2).sum() for one in tables
    )
    freedom = (len(tables) - 1) * slot_orders.degrees_of_freedom(n_slots).sum()
    turns = np.array([one.n_turns for one in tables])
    speed_hz = float(np.average([one.rotation_speed_hz for one in tables], weights=turns))
    merged = SlotsAtSpeed(
        rotation_speed_hz=speed_hz,
        n_turns=int(turns.sum()),
        deviation_rad=slots.deviation_rad,
        order_variance_rad2=slots.order_variance_rad2 * max(1.0, chi_square / freedom),
    )
    beside = max(_rms(one.deviation_rad - slots.deviation_rad) for one in tables)
    if not _is_beyond_chance(chi_square, freedom) or beside < _SHARE_OF_A_WARNING * _rms(slots.deviation_rad):
        return merged, ""
    return merged, (
        f"the recordings at {speed_hz:.3g} Hz show different slots: they scatter {np.sqrt(chi_square / freedom):.0f} times as "
        "much as each by itself; check that all are of one wheel, mounted alike, with the same reference edge"
    )


def _evened(tables: list[SlotsAtSpeed]) -> list[SlotsAtSpeed]:
    """The tables with variances that fall with the order in the same way, each at its own level.

    The variance of a single order is known from few turns only. Weights that follow its chance would prefer the recordings
    in which it came out too small.
    """
    variance = np.array([one.order_variance_rad2[1:] for one in tables])
    if not np.all(variance > 0):
        return tables
    level = np.exp(np.log(variance).mean(axis=1, keepdims=True))
    shape = np.mean(variance / level, axis=0)
    return [
        replace(one, order_variance_rad2=np.concatenate([[0.0], own * shape]))
        for one, own in zip(tables, level, strict=True)
    ]


def _is_beyond_chance(chi_square: float, freedom: float) -> bool:
    return bool(chi_square > _RATIO_OF_A_WARNING * freedom and slot_orders.p_value(chi_square, freedom) < _SIGNIFICANCE)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _refuse_other_rings(runs: Sequence[WheelRun], before: WheelCalibration | None) -> None:
    sizes = {run.name: run.track.slot_deviation_rad.size for run in runs}
    if before is not None:
        sizes = {"the wheel calibration": before.slot_deviation_rad.size} | sizes
    if len(set(sizes.values())) > 1:
        stated = ", ".join(f"{name}: {size}" for name, size in sizes.items())
        raise ReductionError(
            f"numbers of control slots differ ({stated}); a calibration serves one wheel only: make one for this wheel"
        )


def _times_beyond_chance(new: SlotsAtSpeed, old: SlotsAtSpeed, *, turned_slots: int = 0) -> float:
    """By how much two tables differ, as a multiple of chance; 0 where that is no more than chance or does not matter.

    At the same speed all orders are compared, at different ones those that no ripple reaches.
    """
    first = 1 if _is_same_speed(new.rotation_speed_hz, old.rotation_speed_hz) else _NO_RIPPLE_BEYOND + 1
    beside = np.roll(new.deviation_rad, turned_slots) - old.deviation_rad
    variance = new.order_variance_rad2 + old.order_variance_rad2
    chi_square = slot_orders.chi_square(beside, variance)[first:].sum()
    freedom = slot_orders.degrees_of_freedom(beside.size)[first:].sum()
    if _rms(beside) < _SHARE_OF_A_WARNING * _rms(old.deviation_rad) or not _is_beyond_chance(chi_square, freedom):
        return 0.0
    return float(np.sqrt(chi_square / freedom))


def _contradiction(own: Sequence[SlotsAtSpeed], before: Sequence[SlotsAtSpeed]) -> str:
    """What to say if the recordings show other slots than an earlier calibration; empty if they fit."""
    for new in own:
        for old in before:
            times = _times_beyond_chance(new, old)
            if times:
                return (
                    f"the wheel calibration does not fit the recordings at {new.rotation_speed_hz:.3g} Hz: their slots differ by "
                    f"{1e3 * _rms(new.deviation_rad - old.deviation_rad):.3f} mrad rms, {times:.0f} times as much as chance "
                    f"explains; {_why(new, old)} It is left out, the recordings' own slots are used"
                )
    return ""


def _of_one_wheel(speeds: tuple[SlotsAtSpeed, ...]) -> tuple[tuple[SlotsAtSpeed, ...], list[str]]:
    """The speeds whose slots agree with those at the speed of most turns, and what to say of the others."""
    main = max(speeds, key=lambda one: one.n_turns)
    apart = [one for one in speeds if one is not main and _times_beyond_chance(one, main)]
    return tuple(one for one in speeds if one not in apart), [
        f"the recordings at {one.rotation_speed_hz:.3g} Hz show other slots than those at {main.rotation_speed_hz:.3g} Hz, in "
        f"orders that no ripple reaches; {_why(one, main)} Each keeps its own slots"
        for one in apart
    ]


def _why(new: SlotsAtSpeed, old: SlotsAtSpeed) -> str:
    """The likely reason for a contradiction: slots that fit after half a turn are those of the same wheel."""
    if _times_beyond_chance(new, old, turned_slots=new.deviation_rad.size // 2):
        return "another wheel?"
    return "they fit after half a turn: the reference edge was chosen differently, check it with --reference-edge."


def _gate_separation(tracks: Sequence[WheelTrack], slots: SlotTable) -> tuple[float, float]:
    """Mean over the recordings; the register is common to all, only the rest averages out."""
    each = np.array([t.gate_separation_rad for t in tracks])
    own_2 = np.array([t.u_gate_separation_rad**2 for t in tracks]) - slots.u_register_rad**2
    u_mean_2 = float(np.sum(np.maximum(own_2, 0.0))) / each.size**2
    if each.size > 1:
        u_mean_2 = max(u_mean_2, float(each.var(ddof=1)) / each.size)
    return float(each.mean()), float(np.sqrt(u_mean_2 + slots.u_register_rad**2))


_FourAngles = tuple[float, float, float, float]


def _application_edges(tracks: Sequence[WheelTrack], slots: SlotTable) -> tuple[_FourAngles | None, _FourAngles | None]:
    """Mean over the recordings that have them; the uncertainty of the slots beside two edges is common to all."""
    found = [
        (t.application_edges_rad, t.u_application_edges_rad) for t in tracks if t.application_edges_rad is not None
    ]
    if not found:
        return None, None
    angles, u = np.array([edges for edges, _ in found]), np.array([u_edges for _, u_edges in found], dtype=float)
    u_mean_2 = np.sum(u**2, axis=0) / len(found) ** 2
    if len(found) > 1:
        u_mean_2 = np.maximum(u_mean_2, angles.var(axis=0, ddof=1) / len(found))
    beside_2 = 2 * float(slots.u_deviation_rad[0]) ** 2 * np.array([0.0, 1.0, 1.0, 1.0])
    a, b, c, d = (float(angle) for angle in angles.mean(axis=0))
    u_a, u_b, u_c, u_d = (float(value) for value in np.sqrt(u_mean_2 + beside_2))
    return (a, b, c, d), (u_a, u_b, u_c, u_d)
