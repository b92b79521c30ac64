"""What level the opening is expected to have at each wheel angle, learned from frames some of which show something else."""

from bisect import bisect_left
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from irtiming.physics import robust
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, Mask

_TRIALS = 400
_COARSE = 0.2  # of the range of levels: how far a second harmonic may stray from the truth
_ORDERS = (1, *range(2, 41, 2))  # the wheel repeats itself nearly after half a turn
_LEAST_WAVE, _MOST_WAVE = 0.25, 0.75  # of the range of levels: the second harmonic's amplitude; of a triangle wave 0.41
_SMOOTH = 1e-5  # penalty on the squares of (order / 2)^2 times coefficient: no waves in gaps between the angles
_TINY = 1e-9
_ALL_ALIKE = 6.0  # standard deviations: beyond, a frame has no weight
_LEAST_LIMIT = 0.01  # of the range of levels
_STAGES = (
    6,
    10,
    14,
    18,
    24,
    32,
    2 + 2 * len(_ORDERS),
)  # columns: the stiff part first, so that no lie can bend the curve
_ROUNDS = 4


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ExpectedLevel:
    """Level of the opening over the wheel angle: a Fourier series and a straight line over time.

    ``coefficients`` of the columns of `_design`; ``scatter_dn`` the standard deviation of good frames about it; ``low_dn``,
    ``high_dn`` its extremes; ``good`` which of the given frames it was learned from.
    """

    coefficients: Array
    scatter_dn: float
    low_dn: float
    high_dn: float
    good: Mask

    def at(self, wheel_angle_rad: Array, place: Array) -> Array:
        """Expected levels, DN, at wheel angles and places in the recording (0 its start, 1 its end), shape (n,)."""
        return np.asarray(_design(wheel_angle_rad, place) @ self.coefficients)

    def longest_level_rad(self, tolerance_dn: float) -> float:
        """The longest stretch of wheel angle over which the level stays within a band of twice the tolerance."""
        angle = TURN * np.arange(720) / 720
        level = np.tile(self.at(angle, np.full(angle.size, 0.5)), 2)

        def is_too_long(n: int) -> bool:
            return bool(np.all(np.ptp(sliding_window_view(level, n), axis=1) > 2 * tolerance_dn))

        longest = bisect_left(range(2, level.size + 1), True, key=is_too_long)
        return TURN * min(longest, 720) / 720


def learn(wheel_angle_rad: Array, place: Array, *, level_dn: Array) -> ExpectedLevel:
    """Learn the expected level; up to two frames in five may show something else.

    Parameters
    ----------
    wheel_angle_rad, place
        Shape (n,); wheel angle of each frame, and its place in the recording from 0 to 1.
    level_dn
        Shape (n,); level of the opening over its surroundings, DN.
    """
    swing = float(np.ptp(np.quantile(level_dn, [0.02, 0.98])))
    design = _design(wheel_angle_rad, place)
    penalty = _SMOOTH * np.array([_TINY, _TINY, *np.repeat((np.array(_ORDERS) / 2) ** 4, 2)])
    beside, limit = _consensus(wheel_angle_rad, level_dn), _COARSE * swing
    coefficients: Array = np.zeros(design.shape[1])
    scatter = limit
    for n_columns in _STAGES:
        for _ in range(_ROUNDS):
            weight = np.maximum(1 - (beside / limit) ** 2, 0.0) ** 2
            used = design[:, :n_columns]
            normal = used.T @ (weight[:, None] * used) + weight.sum() * np.diag(penalty[:n_columns])
            coefficients = np.zeros(design.shape[1])
            coefficients[:n_columns] = np.linalg.solve(normal, used.T @ (weight * level_dn))
            beside = np.abs(level_dn - design @ coefficients)
            scatter = robust.spread(beside[beside < limit]) if np.any(beside < limit) else limit
        limit = min(limit, max(_ALL_ALIKE * scatter, _LEAST_LIMIT * swing))
    good = beside < limit
    freedom = max(1.0 - design.shape[1] / max(int(good.sum()), 1), 0.3)
    angle = TURN * np.arange(720) / 720
    curve = _design(angle, np.full(angle.size, 0.5)) @ coefficients
    return ExpectedLevel(
        coefficients=coefficients,
        scatter_dn=scatter / float(np.sqrt(freedom)),
        low_dn=float(curve.min()),
        high_dn=float(curve.max()),
        good=good,
    )


def _design(angle: Array, place: Array) -> Array:
    """Columns: 1, place, and cosine and sine of each order."""
    waves = [wave(order * angle) for order in _ORDERS for wave in (np.cos, np.sin)]
    return np.stack([np.ones(angle.size), place - 0.5, *waves], axis=1)


def _consensus(angle: Array, level: Array) -> Array:
    """How far each frame strays from one second harmonic: of many fits to three frames each, the one that most confirm."""
    random = np.random.default_rng(0)
    swing = float(np.ptp(np.quantile(level, [0.02, 0.98])))
    design = np.stack([np.ones(angle.size), np.cos(2 * angle), np.sin(2 * angle)], axis=1)
    coarse = _COARSE * swing
    threes = np.array([random.choice(angle.size, 3, replace=False) for _ in range(_TRIALS)])
    threes = threes[np.abs(np.linalg.det(design[threes])) >= 0.3]
    fits = np.linalg.solve(design[threes], level[threes][:, :, None])[:, :, 0]
    wave = np.hypot(fits[:, 1], fits[:, 2])
    # a closed shutter is level: it must not pass for the scene, however often it is there
    fits = fits[(_LEAST_WAVE * swing < wave) & (wave < _MOST_WAVE * swing)]
    if not fits.size:
        return np.zeros(angle.size)
    beside = np.abs(level - fits @ design.T)
    return np.asarray(beside[np.argmin(np.sum(np.minimum(beside, coarse) ** 2, axis=1))])
