"""Whether frames tell the wave with which the two cutouts pass, in the light over the wheel's angle.

Parts of a run are fitted with waves of the wheel's angle beside a level and a straight line over time. Where the wheel turns by
nearly whole half turns from frame to frame, a part visits a piece of the turn only, and that slowly: what it sees of the passing
wave, the others and the line make up for, and its phase is anything.
"""

from collections.abc import Sequence

import numpy as np

from irtiming.records.arrays import Array, Ticks

PASSING = 2
"""Waves a turn: of two cutouts."""

_LEAST_TOLD = 0.1
"""Of the passing wave's power, what no other wave can make up for: less widens its uncertainty threefold, by all that waves of
higher order than the fit's leave as well."""


def waves(angle_rad: Array, orders: tuple[int, ...]) -> Array:
    """Level, straight line over time, and cosine and sine of each order, shape (n_frame, 2 + 2 n_order).

    Parameters
    ----------
    angle_rad
        Shape (n_frame,), of the wheel, in the order of time.
    orders
        Waves a turn.
    """
    every = [wave for order in orders for wave in (np.cos(order * angle_rad), np.sin(order * angle_rad))]
    return np.stack([np.ones(angle_rad.size), np.linspace(-1.0, 1.0, angle_rad.size), *every], axis=1)


def place(orders: tuple[int, ...], *, order: int = PASSING) -> slice:
    """Columns of one wave, the passing one, among `waves`."""
    at = 2 + 2 * orders.index(order)
    return slice(at, at + 2)


def is_told(angle_rad: Array, parts: Sequence[Ticks], *, orders: tuple[int, ...]) -> bool:
    """Whether the frames of each part tell the passing wave from the other waves, from level and from line.

    Parameters
    ----------
    angle_rad
        Shape (n_frame,).
    parts
        Frames of each part, shapes (n,).
    orders
        Of the waves that are fitted to a part.
    """
    return all(_told(waves(angle_rad[part], orders), place(orders)) >= _LEAST_TOLD for part in parts)


def _told(columns: Array, passing: slice) -> float:
    """Share of the passing wave's power that is not in the span of the others: of cosine or sine, or what is told least."""
    others = np.delete(columns, np.arange(len(columns[0]))[passing], axis=1)
    axes, sizes, _ = np.linalg.svd(others, full_matrices=False)
    kept = axes[:, sizes > np.finfo(float).eps * len(columns) * sizes[0]]
    left = columns[:, passing] - kept @ (kept.T @ columns[:, passing])
    return float(np.linalg.norm(left, ord=-2) ** 2) / (len(columns) / 2)
