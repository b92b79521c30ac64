"""Find the intervals in which the opening is wholly open or covered, and normalise on them (Schatz 2023, 3.1.3)."""

import numpy as np
from scipy import ndimage

from irtiming.errors import ReductionError
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array

_MIDDLE = (0.2, 0.8)
_SMOOTHED = 5  # neighbouring points that a running median takes together
_EXTREME = 0.01  # of the points may lie beyond the levels
_FEWEST = 5  # points that make a slope
_NARROWEST_RAD = 0.045  # a triangle wave cut at those extremes shows 0.03

Plateau = tuple[float, float, int]
"""Start and end angle (rad, end above start, start in [0, 2 pi)) and level: 0 covered, 1 open."""


def find(wheel_angle_rad: Array, value: Array, *, name: str, margin: float = 0.15) -> tuple[Plateau, ...]:
    """The four plateaus of a turn.

    A straight line through the middle of each slope is prolonged to the lowest and the highest value; a plateau is what
    lies between two such corners, less a margin on both sides.

    Parameters
    ----------
    wheel_angle_rad, value
        Shape (n,); angles in [0, 2 pi) and counts or sums, in any order.
    name
        Of the recording, for messages.
    margin
        Share of the width between two corners that is kept away from each of them.

    Raises
    ------
    ReductionError
        If there are not two plateaus at either level.
    """
    order = np.argsort(wheel_angle_rad)
    angle, level = wheel_angle_rad[order], value[order]
    level = ndimage.median_filter(level, _SMOOTHED, mode="wrap")  # a wild frame is no slope
    low, high = np.quantile(level, [_EXTREME, 1 - _EXTREME])
    level = (level - low) / max(high - low, np.finfo(float).tiny)
    lines = [_line(angle[part], level[part]) for part in _slopes(angle, level)]
    n_rising = sum(m > 0 for _, m in lines)
    if len(lines) != 4 or n_rising != 2:
        raise ReductionError(
            f"{name}: found {n_rising} rising and {len(lines) - n_rising} falling slopes over one turn, 2 of each must be "
            "there; the recording must span whole turns and show the whole opening"
        )
    lines.sort(key=lambda line: line[0] % TURN)
    found: list[Plateau] = []
    for (centre, slope), (next_centre, next_slope) in zip(lines, lines[1:] + lines[:1], strict=True):
        start = centre % TURN + 0.5 / abs(slope)
        end = next_centre % TURN - 0.5 / abs(next_slope)
        end += TURN if end < start - np.pi else 0.0
        width = end - start
        if width < _NARROWEST_RAD:
            raise ReductionError(
                f"{name}: no plateau between {np.degrees(start):.1f} and {np.degrees(end):.1f} deg: the opening is open or "
                f"covered for {np.degrees(width):.2f} deg, at least {np.degrees(_NARROWEST_RAD):.1f} deg "
                "are needed; use a narrower mask"
            )
        lower, upper = start + margin * width, end - margin * width
        found.append((lower % TURN, lower % TURN + upper - lower, int(slope > 0)))
    return tuple(found)


def inside(wheel_angle_rad: Array, plateau: Plateau) -> np.ndarray:
    """Which angles lie in the plateau, shape as given, bool."""
    return np.asarray(np.mod(wheel_angle_rad - plateau[0], TURN) <= plateau[1] - plateau[0])


def normalise(wheel_angle_rad: Array, value: Array, *, plateaus: tuple[Plateau, ...]) -> Array:
    """Opening fraction: 0 at the mean of the covered plateaus, 1 at that of the open ones, shape (n,)."""
    level = [
        float(np.mean(value[np.any([inside(wheel_angle_rad, p) for p in plateaus if p[2] == kind], axis=0)]))
        for kind in (0, 1)
    ]
    return (value - level[0]) / (level[1] - level[0])


def _slopes(angle: Array, level: Array) -> list[np.ndarray]:
    """Indices of the points on each slope: around the turn, those between the last below 0.2 and the first above 0.8, or back.

    Where neighbouring points scatter by more than they rise, a slope leaves the middle and comes back to it at either end.
    """
    above = level > _MIDDLE[1]
    beside = np.flatnonzero(above | (level < _MIDDLE[0]))
    onward = np.append(beside[1:], beside[:1] + angle.size)
    changes = np.flatnonzero(above[beside] != above[onward % angle.size])
    runs = [np.arange(beside[k] + 1, onward[k]) % angle.size for k in changes]
    return [run for run in runs if run.size >= _FEWEST]


def _line(angle: Array, level: Array) -> tuple[float, float]:
    """Angle at half height and slope of a straight line through the points."""
    unwrapped = angle[0] + np.mod(angle - angle[0] + np.pi, TURN) - np.pi
    slope, height = np.polyfit(unwrapped - unwrapped[0], level, 1)
    return float(unwrapped[0] + (0.5 - height) / slope), float(slope)
