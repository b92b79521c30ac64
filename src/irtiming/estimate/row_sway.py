"""Contrast that sways while the wheel turns: what all row sums together show of it, and the row sums without it.

A camera whose gain goes with its temperature shows the same light larger or smaller. Neighbours along the wheel's angle were
taken at other times, so a sway looks like residuals with structure. It is a smooth curve of few numbers that all row sums share.
"""

from collections.abc import Sequence

import numpy as np

from irtiming.inference import drifting_levels
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.row_timing import RowTimingFit

_FEWEST_FRAMES = 100  # of a stretch


def relative_gain(fit: RowTimingFit, *, trigger_ticks: Ticks, segment: Ticks) -> Array:
    """Gain of each frame over its mean, as an earlier fit found it or leaves it over.

    Parameters
    ----------
    fit
        Whose residuals show it.
    trigger_ticks, segment
        Of all frames of the recording, shape (n,); between two shutter events gains are the fit's own.

    Returns
    -------
    Shape (n,); 1 on average over the frames of each stretch, and 1 throughout where it does not change.
    """
    if fit.relative_gain is not None:
        return fit.relative_gain
    weight = fit.noise**-2.0 / np.sum(fit.noise**-2.0)
    moving, seen = fit.model @ weight, fit.fraction @ weight
    gain = np.ones(trigger_ticks.size)
    for number in np.unique(segment):
        part = segment == number
        kept = part & fit.kept
        if np.count_nonzero(kept) >= _FEWEST_FRAMES:
            own = part[fit.kept]
            place = trigger_ticks / max(1, int(np.ptp(trigger_ticks[kept])))
            place = place - place[kept][0]
            found = drifting_levels.choose(seen[own], moving[own], shapes=np.zeros((own.sum(), 0)), place=place[kept])
            gain[part] = np.interp(place[part], place[kept], found.relative_gain)
    return gain


def steadied(row_sums: Array, expected: Array, *, gain: Array, stretches: Sequence[Mask]) -> Array:
    """Row sums as if the gain had not changed.

    Parameters
    ----------
    row_sums, expected
        Shape (n, n_row); DN, and what the rows show at gain and offset of their own, which they have in each stretch.
    gain
        Relative one of each frame, shape (n,).
    stretches
        Frames between two shutter events, each of shape (n,).

    Returns
    -------
    Shape (n, n_row).
    """
    found = row_sums.copy()
    for part in stretches:
        if np.ptp(gain[part]) > 0:
            found[part] -= (gain[part] - 1)[:, None] * _contrast(row_sums[part], expected[part], gain[part])
    return found


def _contrast(row_sums: Array, expected: Array, gain: Array) -> Array:
    """What rows at a steady gain show over their offset, DN; shapes as for `steadied`, of one stretch."""
    seen = expected * gain[:, None]
    centred = seen - seen.mean(axis=0)
    scale = np.einsum("ny,ny->y", centred, row_sums - row_sums.mean(axis=0)) / np.einsum("ny,ny->y", centred, centred)
    return np.asarray(scale * expected)
