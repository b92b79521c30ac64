"""The noise of a pixel, from frames of a scene in which not everything moves."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from irtiming.physics import robust


def noise_of(frames: NDArray[Any]) -> float:
    """Standard deviation of a pixel's noise, in the units of the frames.

    Of two estimates the lower one counts, since what moves and what has structure only adds: differences of three frames in
    succession, and differences of neighbouring rows and columns of what changed between two frames; medians over all pixels.

    Parameters
    ----------
    frames
        Shape (n_frame, row, column), three or more; fewer: 0, as nothing tells noise from scene.

    Notes
    -----
    Second differences of three white numbers have the variance 1 + 4 + 1; the mixed difference over rows and columns of the
    difference of two frames has 2 * 4. A median of 0 (most pixels repeat to the count) gives the least that rounding leaves:
    1/sqrt(12).
    """
    if len(frames) < 3:
        return 0.0
    values = np.asarray(frames, dtype=np.float32)
    second = values[:-2] - 2 * values[1:-1] + values[2:]
    change = np.diff(values, axis=0)
    mixed = np.diff(np.diff(change, axis=1), axis=2)
    both = [robust.spread(one) / count**0.5 for one, count in ((second, 6), (mixed, 8)) if one.size]
    rounding = 12**-0.5 if np.issubdtype(frames.dtype, np.integer) else 0.0
    return max(min(both), rounding)
