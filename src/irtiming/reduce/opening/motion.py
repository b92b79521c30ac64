r"""Whether the opening stays where it is in the image, in all parts of a run.

A camera, or a mask, that is not fastened creeps, jumps or turns. In each part of the run every pixel has a contrast of its own:
the amplitude of the wave with which the two cutouts pass. Where the opening is moved by d, the contrast a of the run becomes

.. math:: a(x - d) \approx a(x) - d \cdot \nabla a(x)

so d is the amount of the contrast's slopes in that of a part, beside the contrast itself, whose gain may drift. What a few frames
leave of waves of higher order is alike for all pixels that are covered at the same time, so pixels of the same phase are taken
for one observation in the uncertainty of d: a jackknife that leaves out one cluster at a time (Efron and Stein, Annals of
Statistics 9 (1981) 586).

Levels that sway while frames visit the wheel's angles slowly change the contrast of some phases and not of others. By a share s
of the contrast that looks like a move of the border by s times its width, which no pixels' scatter tells: so much is no doubt.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import final

import numpy as np
from scipy import ndimage

from irtiming.records.arrays import Array, ComplexArray, Mask, Pixels, Ticks
from irtiming.records.finding import Finding
from irtiming.records.reduced import Opening
from irtiming.records.rig import Rig
from irtiming.reduce import kernels, passing_wave
from irtiming.reduce.opening import wheel_contrast
from irtiming.reduce.passing_wave import PASSING

_PARTS = 4
_ORDERS = (1, 2, 3, 4, *range(6, 15, 2))  # waves a turn: of two cutouts, and what tells them apart
_CORNERS = tuple(range(16, 49, 2))  # of the whole run, since a part has too few frames for them
_FRAMES_PER_NUMBER = 2.5
_CLUSTERS = 24
_ROUNDS = 4
_FEWEST_PIXELS = 60
_MARGIN_PX = 3  # beyond the blurred border
_SWAY = 0.1  # of the contrast: by as much levels may sway within a part
_FAR = 6.0
"""Standard uncertainties: of a few ten clusters, with Student's t, less than once in 10 000 runs by chance."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Places:
    """Where the opening lies in each part of a run, from where it lies on average.

    ``moved_px`` (n_part, 2) along rows downwards and columns to the right; ``covariance_px2`` (n_part, 2, 2); ``first_frame``
    where each part begins; ``radius_px`` from the wheel's axle to the opening, as the phases of neighbours tell it; ``border_px``
    how far its blurred border reaches beyond it.
    """

    first_frame: tuple[int, ...]
    moved_px: Array
    covariance_px2: Array
    radius_px: float
    border_px: int

    def between(self, first: int, last: int) -> tuple[Array, float]:
        """By how much the opening moved from one part to another, shape (2,), px, and how many standard uncertainties that is."""
        apart = self.moved_px[last] - self.moved_px[first]
        spread = self.covariance_px2[first] + self.covariance_px2[last]
        return apart, float(np.sqrt(max(apart @ np.linalg.pinv(spread) @ apart, 0.0)))


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SampledFrames:
    """Frames all over a run: ``values`` (n, row, column), wheel angles ``angle_rad`` (n,), their numbers ``index`` (n,), rising.

    ``good`` (n,) tells which show the scene.
    """

    values: Pixels
    angle_rad: Array
    index: Ticks
    good: Mask


def places(sample: SampledFrames, opening: Opening, *, gain: Array | float = 1.0) -> Places | None:
    """Of the parts of a run; None where too few frames, or pixels, tell, or frames of less than a turn.

    Parameters
    ----------
    sample
        Frames that were looked at.
    opening
        As found in them.
    gain
        Of the non-uniformity correction, shape (row, column), for values that are not corrected.
    """
    mask, bad, reach = opening.mask, opening.bad, opening.border_px + _MARGIN_PX
    used = np.flatnonzero(sample.good & np.isfinite(sample.angle_rad))
    parts = np.array_split(used, _PARTS)
    if parts[-1].size < _FRAMES_PER_NUMBER * (2 * len(_ORDERS) + 2):
        return None
    if not passing_wave.is_told(sample.angle_rad, parts, orders=_ORDERS):
        return None
    box = _box(mask, margin=reach)
    near = np.ascontiguousarray(sample.values[:, *box])
    scale = np.broadcast_to(gain, mask.shape)[box]
    waves = [scale * one for one in _harmonics(near, sample.angle_rad, parts=parts)]
    pixels = ndimage.binary_dilation(mask[box], iterations=reach) & ~bad[box]
    whole: ComplexArray = np.mean(waves, axis=0)
    inner = mask[box] & ~bad[box]
    if inner.sum() < _FEWEST_PIXELS:
        return None
    direction = wheel_contrast.direction(whole, inner)
    contrast = [(wave * direction.conj()).real for wave in waves]
    clusters, middle = _clusters(direction, pixels), np.mean(contrast, axis=0)
    found = [_moved(one, middle, pixels=pixels, direction=direction, clusters=clusters) for one in contrast]
    return Places(
        first_frame=tuple(int(sample.index[part[0]]) for part in parts),
        moved_px=np.array([moved for moved, _ in found]),
        covariance_px2=np.array([covariance for _, covariance in found]),
        radius_px=_radius_px(direction, inner),
        border_px=opening.border_px,
    )


def _box(mask: Mask, *, margin: int) -> tuple[slice, slice]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return (
        slice(max(0, int(rows[0]) - margin), int(rows[-1]) + margin + 1),
        slice(max(0, int(columns[0]) - margin), int(columns[-1]) + margin + 1),
    )


def _harmonics(values: Pixels, angle: Array, *, parts: Sequence[Ticks]) -> list[ComplexArray]:
    """The wave with which cutouts pass in each part, shape (row, column): values weighted so that no other wave leaks into it."""
    used = np.concatenate(parts)
    whole = passing_wave.waves(angle[used], _ORDERS + _CORNERS)
    first = 2 + 2 * len(_ORDERS)
    corners = whole[:, first:] @ np.linalg.pinv(whole, rcond=1e-6)[first:]
    at, found = passing_wave.place(_ORDERS), list[ComplexArray]()
    for part in parts:
        here = np.isin(used, part)
        inverse = np.linalg.pinv(passing_wave.waves(angle[part], _ORDERS), rcond=1e-3)[at]
        weight = -inverse @ corners[here]
        weight[:, here] += inverse
        every = np.zeros((2, len(values)))
        every[:, used] = weight
        sums = np.zeros((3, *values.shape[1:]))
        kernels.add_projection(values, every[0], every[1], sums)
        found.append(sums[0] - 1j * sums[1])
    return found


def _clusters(direction: ComplexArray, pixels: Mask) -> Ticks:
    """Pixels of about the same phase have the same number, shape (n_pixel,)."""
    middle = np.sum(direction[pixels])
    phase = np.angle(direction[pixels] * np.conj(middle))
    ends = np.quantile(phase, np.linspace(0, 1, _CLUSTERS + 1)[1:-1])
    return np.searchsorted(ends, phase)


def _radius_px(direction: ComplexArray, inner: Mask) -> float:
    """The phase of a pixel is twice its polar angle about the axle, so it changes by 2 / r per pixel."""
    deep = ndimage.binary_erosion(inner, iterations=2)
    slope = np.hypot(*(np.abs(one) for one in np.gradient(direction)))[deep if deep.any() else inner]
    return PASSING / max(float(np.median(slope)), 1e-9)


def _moved(
    contrast: Array, whole: Array, *, pixels: Mask, direction: ComplexArray, clusters: Ticks
) -> tuple[Array, Array]:
    """By how much the contrast of a part lies beside that of the whole run, px, and the covariance."""
    level: Array = np.array([direction.real, direction.imag])[:, pixels]  # of one that sways, in each pixel's own phase
    moved = np.zeros(2)
    for _ in range(_ROUNDS):
        there = ndimage.shift(whole, moved, order=1, mode="nearest")
        slopes: Array = -np.array(np.gradient(there))[:, pixels]
        columns: Array = np.concatenate([slopes, there[pixels][None], level]).T
        found = np.asarray(np.linalg.lstsq(columns, contrast[pixels], rcond=None)[0])
        left = contrast[pixels] - columns @ found
        step = found[:2] / max(abs(found[2]), 1e-9) * np.sign(found[2])
        moved += np.clip(step, -2.0, 2.0)
    return moved, _jackknife(columns, left, clusters)[:2, :2]


def _jackknife(columns: Array, left: Array, clusters: Ticks) -> Array:
    """Covariance of a least squares fit from what it does without each cluster in turn, shape (k, k).

    A radial edge of the mask is a cluster or two, and alone tells a move along the arc: leaving it out shows that.
    """
    normal, steps = columns.T @ columns, []
    for cluster in range(_CLUSTERS):
        own = columns[clusters == cluster]
        steps.append(np.linalg.pinv(normal - own.T @ own) @ own.T @ left[clusters == cluster])
    apart = np.array(steps)
    return np.asarray(apart.T @ apart) * (_CLUSTERS - 1) / _CLUSTERS


def findings(found: Places | None, rig: Rig, *, name: str) -> tuple[Finding, ...]:
    """A doubt where the opening moves by more than its noise, than the stated angle of the mask may be off, and than sway feigns.

    Parameters
    ----------
    found
        Where it lies in the parts of the run.
    rig
        What its owner says of the mask's angle: as much, as an angle about the axle, may be amiss anyway.
    name
        Of the recording.
    """
    if found is None:
        return ()
    moves = [
        (*found.between(first, last), found.first_frame[first], found.first_frame[last])
        for first, last in combinations(range(len(found.moved_px)), 2)
    ]
    beyond_doubt = [move for move in moves if move[1] > _FAR]
    if not beyond_doubt:
        return ()
    apart, pull, first, last = max(beyond_doubt, key=lambda move: float(np.hypot(*move[0])))
    size = float(np.hypot(*apart))
    u_mask_px = rig.mask_opening.centre_angle_rad.standard_uncertainty * found.radius_px
    if size <= max(2 * u_mask_px, _SWAY * found.border_px):
        return ()
    return (
        Finding(
            code="image-moved",
            severity="doubt",
            recording=name,
            what=f"in the part of the run from frame {last} on the opening lies {size:.2g} px ({apart[0]:+.2f} px down, "
            f"{apart[1]:+.2f} px to the right; {pull:.0f} u) from where it lies in that from frame {first} on: the camera, its "
            "lens or the mask moved",
            cure="fasten camera and mask, let them warm up, and record again",
        ),
    )
