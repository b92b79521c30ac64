"""Levels that sway while the wheel turns: what all row sums together show of it, and the row sums without it.

A camera whose gain and offset go with its temperature shows the same light larger, smaller or brighter. Neighbours along the
wheel's angle were taken at other times, so a sway looks like residuals with structure. It is two smooth curves of few numbers
that all row sums share. An earlier fit's residuals choose them, twice, for the first fit took the sway for something of the
wheel. Their amounts are then found together with the timing: where frames visit the wheel's angles slowly, one looks like the
other.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from irtiming.inference import drifting_levels
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.row_timing import RowTimingFit, Sway

_FEWEST_FRAMES = 24  # of a stretch: offset, gain and one number more, at eight frames for each
_SHORTEST = 40  # frames per interval of a spline: all rows of a frame together tell a sway better than one sum does
_SPANNED = 1e-9  # relative: less than this of a column's square is rounding
_LOOKS = 2
_DAMPED, _LEAST_DAMPED = (
    0.7,
    0.1,
)  # of a step: where the wheel passes slowly, all else follows the sway, and they go to and fro
_BACK = 0.2  # of the step before: by how much the next one goes back where they do
_NONE = 1e-300


def chosen(fit: RowTimingFit, *, trigger_ticks: Ticks, segment: Ticks, pixels: Array) -> Sway:
    """Curves of gain and offset as an earlier fit and its residuals show them; its own once they were chosen twice.

    Parameters
    ----------
    fit
        The earlier one.
    trigger_ticks, segment
        Of all frames of the recording, shape (n,); between two shutter events gains and offsets are the fit's own.
    pixels
        Of each row that was fitted, per pixel of light, shape (n_row,): an offset is alike in all.
    """
    before = fit.sway
    if before is not None and before.n_looks >= _LOOKS:
        return before
    weight = fit.noise**-2.0 / np.sum(fit.noise**-2.0)
    moving, measured, per_offset = fit.model @ weight, fit.fraction @ weight, float(pixels @ weight)
    if before is not None:
        known = before.of(fit.kept)
        measured = measured + (known.relative_gain - 1) * moving + known.offset_change * per_offset
    offsets, gains = list[Array](), list[Array]()
    amounts: tuple[list[Array], list[Array]] = ([np.zeros(0)], [np.zeros(0)])
    for number in np.unique(segment):
        part = segment == number
        kept = part & fit.kept
        if np.count_nonzero(kept) >= _FEWEST_FRAMES:
            own = part[fit.kept]
            place = trigger_ticks / max(1, int(np.ptp(trigger_ticks[kept])))
            place = place - place[kept][0]
            found = drifting_levels.choose(
                measured[own],
                moving[own],
                shapes=np.zeros((own.sum(), 0)),
                place=place[kept],
                shortest=_SHORTEST,
                beside=True,
            )
            offsets.append(_over_all(found.drift, place, kept=kept, part=part))
            gains.append(_over_all(found.gain, place, kept=kept, part=part))
            amounts[0].append(_amounts(found.drift, found.offset_change / per_offset))
            amounts[1].append(_amounts(found.gain, found.relative_gain - 1))
    none = np.zeros((trigger_ticks.size, 0))
    offset_amounts, gain_amounts = (np.concatenate(one) for one in amounts)
    n = offset_amounts.size + gain_amounts.size
    return Sway(
        offsets=np.concatenate([none, *offsets], axis=1),
        gains=np.concatenate([none, *gains], axis=1),
        offset_amounts=offset_amounts,
        gain_amounts=gain_amounts,
        covariance=np.zeros((n, n)),
        n_looks=1 if before is None else before.n_looks + 1,
    )


def _over_all(columns: Array, place: Array, *, kept: Mask, part: Mask) -> Array:
    """Curves of the kept frames of a stretch for all its frames, and zero beside it; shape (n, k)."""
    out = np.zeros((place.size, columns.shape[1]))
    for k, column in enumerate(columns.T):
        out[part, k] = np.interp(place[part], place[kept], column)
    return out


def _amounts(columns: Array, curve: Array) -> Array:
    return np.asarray(np.linalg.lstsq(columns, curve, rcond=1e-12)[0], dtype=float)


def improved(sway: Sway, step: Array, *, covariance: Array) -> Sway:
    """With amounts that are nearer to the best ones.

    Parameters
    ----------
    sway
        With its last step, from which it may be on its way to and fro: then it moves by half the share that it did.
    step
        By how much its amounts are off while all else stays as it is, shape (p + q,).
    covariance
        Of the amounts, shape (p + q, p + q).
    """
    damping = min(sway.damping, _DAMPED)
    if sway.step.size == step.size:
        weight = 1 / np.maximum(np.diag(covariance), _NONE)
        if (step * weight) @ sway.step < -_BACK * (sway.step * weight) @ sway.step:
            damping = max(damping / 2, _LEAST_DAMPED)
    p, moved = sway.offset_amounts.size, damping * step
    return replace(
        sway, offset_amounts=sway.offset_amounts + moved[:p], gain_amounts=sway.gain_amounts + moved[p:],
        covariance=covariance, step=step, damping=damping,
    )  # fmt: skip


def columns(sway: Sway, model: Array, *, pixels: Array, stretches: Sequence[Mask]) -> Array:
    """What one unit of each amount does to the row sums, gain and offset of the rows projected out.

    Parameters
    ----------
    sway
        Of the frames that are fitted.
    model, pixels
        What the rows show, shape (n, n_row), and how many pixels they have, (n_row,), px^2.
    stretches
        Frames between two shutter events, each of shape (n,).

    Returns
    -------
    Shape (p + q, n, n_row), px^2.
    """
    out = np.concatenate([sway.offsets.T[:, :, None] * pixels, sway.gains.T[:, :, None] * model])
    for part in stretches:
        light = _centred(model[part])
        own = out[:, part] - out[:, part].mean(axis=1, keepdims=True)
        along = np.einsum("jny,ny->jy", own, light) / _products(light, light)
        out[:, part] = own - along[:, None, :] * light
    return out


def own_columns(sway: Sway, model: Array, *, stretches: Sequence[Mask]) -> Array:
    """The gain's curve in each row, gain and offset of the row projected out: pixels have levels of their own, which it moves.

    Parameters
    ----------
    sway
        Of the frames that are fitted.
    model
        What the rows show, shape (n, n_row).
    stretches
        Frames between two shutter events, each of shape (n,); in each the column has a unit length, or none.

    Returns
    -------
    Shape (n, n_row).
    """
    out = np.zeros(model.shape)
    if sway.n_looks < _LOOKS:
        return out  # a curve that is still looked for must not take anything away
    for part in stretches:
        curve = sway.relative_gain[part]
        if np.ptp(curve) > 0:
            light, own = _centred(model[part]), _centred(np.repeat(curve[:, None], model.shape[1], axis=1))
            own = own - _products(own, light) / _products(light, light) * light
            out[part] = own / np.sqrt(_products(own, own))
    return out


def steadied(row_sums: Array, expected: Array, *, sway: Sway, pixels: Array, stretches: Sequence[Mask]) -> Array:
    """Row sums as if gain and offset had not changed.

    Parameters
    ----------
    row_sums, expected
        Shape (n, n_row); DN, and what the rows show at gain and offset of their own, which they have in each stretch, px^2.
    sway
        Of these frames.
    pixels
        How many the rows have, (n_row,), px^2.
    stretches
        Frames between two shutter events, each of shape (n,).

    Returns
    -------
    Shape (n, n_row).
    """
    found = row_sums.copy()
    change = (sway.relative_gain - 1)[:, None] * expected + sway.offset_change[:, None] * pixels
    for part in stretches:
        if np.ptp(change[part]) > 0:
            centred = _centred(expected[part] + change[part])
            found[part] -= _products(centred, _centred(row_sums[part])) / _products(centred, centred) * change[part]
    return without(own_columns(sway, expected, stretches=stretches), found, stretches=stretches)


def without(own: Array, values: Array, *, stretches: Sequence[Mask]) -> Array:
    """Values less their part along each row's own column, stretch by stretch.

    Parameters
    ----------
    own
        From `own_columns`, shape (n, n_row).
    values
        Shape (.., n, n_row).
    stretches
        Frames between two shutter events, each of shape (n,).

    Returns
    -------
    Shape of the values.
    """
    out = values.copy()
    for part in stretches:
        along = np.einsum("...ny,ny->...y", values[..., part, :], own[part])
        out[..., part, :] -= along[..., None, :] * own[part]
    return out


def beside_own(own: Array, shared: Array, *, stretches: Sequence[Mask]) -> Array:
    """Columns of a sway less what rows have of their own; zero where that is all of a column.

    An offset whose curve is that of the gain is in the span of the rows' own columns. What is then left of it is rounding, by
    which no amount may be found.

    Parameters
    ----------
    own
        From `own_columns`, shape (n, n_row).
    shared
        From `columns`, shape (k, n, n_row).
    stretches
        Frames between two shutter events, each of shape (n,).

    Returns
    -------
    Shape (k, n, n_row).
    """
    out = without(own, shared, stretches=stretches)
    left, whole = (np.einsum("jny,jny->j", one, one) for one in (out, shared))
    out[left <= _SPANNED * whole] = 0.0
    return out


def _centred(columns: Array) -> Array:
    return np.asarray(columns - columns.mean(axis=0))


def _products(a: Array, b: Array) -> Array:
    """Sums over the frames, shape (n_row,)."""
    return np.asarray(np.einsum("ny,ny->y", a, b))
