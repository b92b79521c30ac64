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
)  # of chi-square: by how much, and how many times, the pattern must go worse with the other edge


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
    """Chi-square of its slots about the mean of as many that others learned; 0 where there is nothing to compare."""
    n_slots = track.slot_deviation_rad.size
    learned = [one for one in others if one.has_learned_slots and one.slot_deviation_rad.size == n_slots]
    if not learned or not track.has_learned_slots:
        return 0.0
    known, u = (
        np.array([getattr(one, name) for one in learned]) for name in ("slot_deviation_rad", "u_slot_deviation_rad")
    )
    weight = np.sum(u**-2.0, axis=0)
    off = track.slot_deviation_rad - np.sum(known * u**-2.0, axis=0) / weight
    return float(np.sum(off**2 / (track.u_slot_deviation_rad**2 + 1 / weight)))
