"""Frames' own times against the triggers that are said to have made them: what cannot belong together is refused."""

from pathlib import Path

import numpy as np

from irtiming.archive.frames.source import FrameFacts
from irtiming.errors import ArchiveError
from irtiming.records.arrays import Array, Ticks
from irtiming.units import counted, readable_time

_LEAST_FRAMES = 10
_WRONG_RATE = 0.01
"""No clock of a camera or a computer is wrong by more."""

_LIKE = 0.02
"""Of a trigger's interval: frames that come as often as triggers, but for some that were lost."""

_AROUND = 5
"""Frames before and behind a place; the median of so many forgets those that were stamped late."""

_NEAR_WHOLE = 0.2
"""Of a trigger's interval: how near to whole ones a step must be, else a clock was set meanwhile."""


def require_same_triggers(source: Path, facts: FrameFacts, *, numbers: Ticks, triggers_s: Array) -> None:
    """Refuse frames that other triggers made; frames whose file tells no times of their own pass.

    Parameters
    ----------
    source, facts
        The file, and what it tells of its frames.
    numbers
        Index of each frame's trigger, shape (n_frame,).
    triggers_s
        Times of all triggers, shape (n_trigger,), rising, s.

    Raises
    ------
    ArchiveError
        If the frames' own times run at another rate than their triggers, or whole triggers were left out between two frames.
    """
    if facts.times_s is None or facts.time_scale in ("", "first frame") or numbers.size < _LEAST_FRAMES:
        return
    if numbers[-1] >= triggers_s.size:
        return  # refused for their number
    made_s = triggers_s[numbers]
    times_s, made_s = facts.times_s - facts.times_s[0], made_s - made_s[0]
    usual_s, interval_s = (float(np.median(np.diff(each))) for each in (times_s, made_s))
    step_s = facts.time_step_s or 0.0
    is_like = abs(usual_s - interval_s) <= _LIKE * interval_s + step_s and interval_s > 4 * step_s
    if is_like and (at := _left_out(times_s - made_s, interval_s)) is not None:
        raise ArchiveError(
            f"frame {at[0]} comes {counted(at[1], 'trigger')} later by its own time than the frames before it: frames were lost "
            "there, and those behind would get wrong triggers; record again, or convert it to .npy and write each frame's number "
            "into the .npy.json as frame_id",
            where=str(source),
        )
    if abs(float(times_s[-1] - made_s[-1])) > _WRONG_RATE * made_s[-1] + interval_s + 2 * step_s:
        usual, interval = (readable_time(float(f"{each:.5g}")) for each in (usual_s, interval_s))
        raise ArchiveError(
            f"its frames are {usual} apart by their own times and last {times_s[-1]:.3f} s, their triggers {interval} and "
            f"{made_s[-1]:.3f} s: these triggers did not make them, or not every frame was kept; give the frames and the edges "
            "of one run",
            where=str(source),
        )


def _left_out(late_s: Array, interval_s: float) -> tuple[int, int] | None:
    """First frame behind a step by whole triggers that lasts, and by how many; None where there is none."""
    medians = np.median(np.lib.stride_tricks.sliding_window_view(late_s, _AROUND), axis=1)
    steps = (medians[_AROUND:] - medians[:-_AROUND]) / interval_s
    n_lost = np.rint(steps)
    for place in np.flatnonzero((n_lost >= 1) & (np.abs(steps - n_lost) < _NEAR_WHOLE)):
        near = late_s[place : place + 2 * _AROUND]  # the step is in the middle of what the two medians see
        frame = int(place + np.argmax(np.diff(near))) + 1
        lasts = (np.median(late_s[frame:]) - np.median(late_s[:frame])) / interval_s
        if lasts > n_lost[place] - 0.5:
            return frame, int(n_lost[place])
    return None
