"""Whether values pile up at one number, as where the range of a camera, or of a file, ends."""

import numpy as np

from irtiming.errors import ReductionError
from irtiming.records.arrays import Mask
from irtiming.records.recording import Recording

_FRAMES = 24
_MOST = 0.05
"""Of the opening's values: noise of a step or more spreads even the plateaus of a wheel over more numbers than twenty."""

_UNLIKE = 5.0
"""Shares of the two ends: without any noise both plateaus are single numbers, and nothing is clipped."""


def refuse(recording: Recording, opening: Mask) -> None:
    """Nothing, if the largest and the smallest value of the opening are as rare as the others.

    Parameters
    ----------
    recording
        Some of its frames are read again.
    opening
        Shape (row, column); pixels that see the wheel.

    Raises
    ------
    ReductionError
        If many values are exactly the largest or the smallest of all, with that number.
    """
    frames = np.linspace(0, recording.frames.shape[0] - 1, _FRAMES).astype(int)
    values = recording.frames.pick([int(frame) for frame in frames])[:, opening]
    values = values[:, np.ptp(values, axis=0) > 0]  # a dead pixel is no end of a range
    if not values.size:
        return
    largest, smallest = (float(np.mean(values == end)) for end in (values.max(), values.min()))
    if max(largest, smallest) <= _MOST or min(largest, smallest) > max(largest, smallest) / _UNLIKE:
        return
    name, end = ("largest", values.max()) if largest > smallest else ("smallest", values.min())
    raise ReductionError(
        f"{recording.name}: {max(largest, smallest):.0%} of the opening's values are {end} DN, the {name} of all, at most "
        f"{_MOST:.0%} may be: they are clipped; choose another integration time or range, and save all bits"
    )
