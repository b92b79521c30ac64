"""Whole image rows that are dead: stuck at their values, or a copy of the row beside them.

A dead row that crosses the opening looks like an edge of it. So it is told by what no live row does, wherever it lies: nearly
none of its pixels ever changes, or nearly all of them are, in every frame, those of the row above. Of two rows that are alike one
is the copy, and nothing tells which: neither is used.
"""

from dataclasses import replace
from typing import TypeVar

import numpy as np
from scipy import ndimage

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, ComplexArray, Mask, Pixels
from irtiming.records.recording import Recording
from irtiming.reduce.nonuniformity import Correction

Values = TypeVar("Values", Array, ComplexArray, Pixels)

_FRAMES = 16  # all over the recording
_NEARLY_ALL = 0.9  # of the pixels of a row
_LIVE = 0.5  # of the pixels: a usual row has fewer that are still, or alike, in all these frames
_MOST_COPIES = 0.2  # of the rows: where more are alike, the camera makes its images so
_WIDEST_GAP = 5  # dead rows beside each other, over which the rows above and below tell what they would show


def marked(correct: Correction, recording: Recording) -> Correction:
    """The correction with all pixels of dead rows bad.

    Parameters
    ----------
    correct
        Of the whole image.
    recording
        Some of its frames are read.
    """
    return replace(correct, bad=correct.bad | find(recording)[:, None])


def find(recording: Recording) -> Mask:
    """Rows that are stuck, or like a row beside them, in frames all over the recording, shape (row,).

    None where pixels hardly have noise, for then live ones are still, and alike, too.

    Parameters
    ----------
    recording
        Some of its frames are read.
    """
    n_frames = recording.frames.shape[0]
    raw = recording.frames.pick(np.unique(np.linspace(0, n_frames - 1, _FRAMES).astype(int)).tolist())
    still = np.mean(np.all(raw == raw[0], axis=0), axis=1)
    alike = np.mean(raw[:, 1:] == raw[:, :-1], axis=(0, 2))
    stuck, copies = (share >= _NEARLY_ALL for share in (still, alike))
    dead = stuck if np.median(still) < _LIVE else np.zeros_like(stuck)
    if np.median(alike) < _LIVE and copies.mean() < _MOST_COPIES:
        dead = dead | np.append(copies, False) | np.append(False, copies)
    return np.asarray(dead)


def of(bad: Mask) -> Mask:
    """Rows that have no good pixel, shape (row,); ``bad`` has shape (row, column)."""
    return np.asarray(bad.all(axis=1))


def filled(image: Values, dead: Mask) -> Values:
    """What dead rows would show: between the nearest live rows above and below, on a straight line.

    Parameters
    ----------
    image
        Shape (..., row, column), of any type of number.
    dead
        Shape (row,); where all are, the image stays as it is.
    """
    if not dead.any() or dead.all():
        return image
    live, full = np.flatnonzero(~dead), image.copy()
    for row in np.flatnonzero(dead).tolist():
        near = np.concatenate([live[live < row][-1:], live[live > row][:1]])
        first, last = int(near[0]), int(near[-1])
        share = (row - first) / max(last - first, 1)
        full[..., row, :] = (1 - share) * image[..., first, :] + share * image[..., last, :]
    return full


def refuse_wide_gaps(bad: Mask, mask: Mask, *, name: str) -> None:
    """Refuse an opening that is crossed by more dead rows beside each other than the rows around them can make up for.

    Parameters
    ----------
    bad, mask
        Bad pixels and the opening, shape (row, column).
    name
        Of the recording.

    Raises
    ------
    ReductionError
        With the rows' numbers.
    """
    gaps, _ = ndimage.label(of(bad))
    crossing = np.flatnonzero((gaps > 0) & mask.any(axis=1))
    if not crossing.size or np.bincount(gaps)[gaps[crossing]].max() <= _WIDEST_GAP:
        return
    raise ReductionError(
        f"{name}: image rows {', '.join(map(str, crossing))} of the opening are dead: stuck at their values, or copies of a row "
        f"beside them; at most {_WIDEST_GAP} beside each other can be done without; move the opening to where all rows are live"
    )
