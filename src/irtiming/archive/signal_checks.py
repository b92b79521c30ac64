"""What the frames show of the wheel: whether they follow it at all, and which way its edges move across the image."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from scipy import special

from irtiming.archive import layout
from irtiming.archive.finding import warning_at
from irtiming.archive.tick_checks import half_turn_ticks
from irtiming.physics import edge_motion
from irtiming.records.finding import Finding
from irtiming.records.rig import Rig

if TYPE_CHECKING:
    from irtiming.archive.consistency import Contents
    from irtiming.records.arrays import Array, ComplexArray, Ticks

_FEWEST_FRAMES = 50
_HARMONICS = 3
_SIGNIFICANCE = 1e-6
_LEAST_TURN_RAD = 0.05
"""From tile to tile, of an angle that goes round twice a turn: less is an axle forty tiles away, or no picture of a wheel."""


def check_signal(contents: "Contents", tiles_dn: "Array", *, rig: Rig | None) -> Iterator[Finding]:
    """Findings about the light that the frames saw; none where frames or edges are too few to tell.

    Parameters
    ----------
    contents
        Of the file.
    tiles_dn
        Shape (n_frame, n_row, n_column): mean value of each tile of the image.
    rig
        With the stated rotation, None where none is given.
    """
    angle_rad = _half_turns(contents, len(tiles_dn))
    if angle_rad is None:
        return
    known = np.isfinite(angle_rad)
    if np.count_nonzero(known) < _FEWEST_FRAMES:
        return
    first, p_value = _following(angle_rad[known], tiles_dn[known])
    where = layout.FRAMES.path
    if not np.any(p_value < _SIGNIFICANCE):
        yield warning_at(
            where,
            "does not follow the wheel: no part of the image differs between open and covered",
            code="frames-without-signal",
            cure="check that the blackbody is warmer or colder than the wheel, that camera and mask see it, and that the lens is "
            "uncovered; else frames do not belong to their triggers",
        )
    elif rig is not None:
        yield from _rotation(np.where(p_value < _SIGNIFICANCE, first, 0.0), rig)


def _half_turns(contents: "Contents", n_frames: int) -> "Array | None":
    """Angle within the half turn at each frame's trigger, 2 pi per half turn, rad; nan where no edges are known."""
    edges: Ticks | None = contents.get(layout.APPLICATION_SLOT)
    triggers: Ticks | None = contents.get(layout.CAMERA_TRIGGER)
    numbers: Ticks | None = contents.get(layout.FRAME_NUMBER)
    if edges is None or triggers is None or edges.size < 3 or np.any(np.diff(edges) <= 0):
        return None
    numbers = np.arange(n_frames) if numbers is None else numbers
    if numbers.size != n_frames or numbers.min() < 0 or numbers.max() >= triggers.size:
        return None
    times = triggers[numbers].astype(np.float64)
    half_turns = np.rint(np.cumsum(np.append(0.0, np.diff(edges) / half_turn_ticks(edges))))
    at = np.interp(times, edges.astype(np.float64), half_turns, left=np.nan, right=np.nan)
    return np.asarray(2 * math.pi * at)


def _following(angle_rad: "Array", tiles_dn: "Array") -> "tuple[ComplexArray, Array]":
    """First harmonic of each tile over the half turn, and the p-value of all its harmonics, shapes of the tiles."""
    n = angle_rad.size
    time = np.linspace(-1, 1, n)
    slow = np.stack([np.ones(n), time, time**2], axis=1)
    orders = np.arange(1, _HARMONICS + 1) * angle_rad[:, None]
    waves = np.concatenate([np.cos(orders), np.sin(orders)], axis=1)
    values = tiles_dn.reshape(n, -1).astype(np.float64)
    values = values - values[0]
    without = _left(slow, values)
    both = np.concatenate([slow, waves], axis=1)
    fitted = np.linalg.lstsq(both, values, rcond=None)[0]
    within = np.sum((values - both @ fitted) ** 2, axis=0)
    free = n - both.shape[1]
    gained = np.maximum(without - within, 0.0) / (2 * _HARMONICS)
    ratio = np.divide(gained, within / free, out=np.zeros_like(within), where=within > 1e-12 * n)
    cosine, sine = fitted[slow.shape[1]], fitted[slow.shape[1] + _HARMONICS]
    p_value = special.fdtrc(2 * _HARMONICS, free, ratio) * ratio.size
    return (cosine - 1j * sine).reshape(tiles_dn.shape[1:]), np.asarray(p_value).reshape(tiles_dn.shape[1:])


def _left(model: "Array", values: "Array") -> "Array":
    fitted = np.linalg.lstsq(model, values, rcond=None)[0]
    return np.asarray(np.sum((values - model @ fitted) ** 2, axis=0))


def _rotation(first: "ComplexArray", rig: Rig) -> Iterator[Finding]:
    """Complain where edges move against the stated rotation."""
    found = edge_motion.contradiction(first, rig, least_turn_rad=_LEAST_TURN_RAD)
    if found is not None:
        yield warning_at(
            layout.FRAMES.path,
            f"shows edges that move {found.way}",
            code="rotation-contradicted",
            cure=f"{found.stated} means the other way: correct one of them, or the image is mirrored",
        )
