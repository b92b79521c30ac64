"""Which edge is the reference where a wheel wanders too much for one recording to tell: that of another, by the slots' pattern.

Both recordings show the same slots, each made a little beside its place. Counted from the wrong edge, half a turn on, the pattern
of one does not lie on that of the other.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from irtiming.records.choices import Choices, ReferenceEdge
from irtiming.records.recording import Recording
from irtiming.records.rig import Rig
from irtiming.records.wheel_track import WheelTrack
from irtiming.reduce.wheel import wheel_angles

_EDGES: tuple[ReferenceEdge, ReferenceEdge] = ("first", "second")
_APART, _TIMES = (
    25.0,
    4.0,
)  # by which the pattern must go worse with the other edge: more in chi-square, and so many times


def clear_first(recordings: Iterable[Recording]) -> list[Recording]:
    """The same recordings, those whose own timestamps tell the reference edge before those whose do not.

    Parameters
    ----------
    recordings
        Of one wheel.
    """
    return sorted(recordings, key=lambda one: not wheel_angles.tells_reference(one))


def named(recording: Recording, others: Sequence[WheelTrack], *, rig: Rig, choices: Choices) -> Choices:
    """The choices with the reference edge that other recordings tell, where this one's timestamps do not.

    Parameters
    ----------
    recording, rig, choices
        To be reduced.
    others
        Tracks of recordings of the same wheel. Where their slots do not decide, choices stay as they are.
    """
    if not others or choices.reference_edge != "automatic" or wheel_angles.tells_reference(recording):
        return choices
    misfits = [_misfit(wheel_angles.track(recording, rig, reference_edge=edge), others) for edge in _EDGES]
    better, worse = sorted(misfits)
    if worse - better < _APART or worse < _TIMES * better:
        return choices
    return replace(choices, reference_edge=_EDGES[misfits.index(better)])


def _misfit(track: WheelTrack, others: Sequence[WheelTrack]) -> float:
    """Chi-square of its slots about the mean of the others', which are as many."""
    weights = np.array([one.u_slot_deviation_rad**-2.0 for one in others if _is_learned(one, track)])
    if not weights.size or not np.any(track.slot_deviation_rad):
        return 0.0
    known = np.array([one.slot_deviation_rad for one in others if _is_learned(one, track)])
    mean = np.sum(weights * known, axis=0) / weights.sum(axis=0)
    variance = track.u_slot_deviation_rad**2 + 1 / weights.sum(axis=0)
    return float(np.sum((track.slot_deviation_rad - mean) ** 2 / variance))


def _is_learned(other: WheelTrack, track: WheelTrack) -> bool:
    return other.slot_deviation_rad.size == track.slot_deviation_rad.size and bool(np.any(other.slot_deviation_rad))
