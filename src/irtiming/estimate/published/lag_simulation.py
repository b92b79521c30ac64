r"""Simulation of the opening fractions that a rolling microbolometer camera sees, as published (Schatz 2023, 3.2.4).

Each row follows its instantaneous opening fraction g, counted from the pixels of the binary mask, by eq. (2):
:math:`\dot v = (g - v) / \tau`. Ten steps of the classical Runge-Kutta method per sampling interval, start at 0.5, two turns
run-in, the third is put out. Delays are advances of the wheel angle. With z = step / tau, the four stages of a step

    k1 = g(t) - v,  k2 = g(t + h/2) - v - z/2 k1,  k3 = g(t + h/2) - v - z/2 k2,  k4 = g(t + h) - v - z k3

make v + z/6 (k1 + 2 k2 + 2 k3 + k4), which is a weighted sum of v and of the three g. The kernel below uses these weights,
and takes the steps between two samples, which are the same in each turn, once from v = 0: the same numbers up to rounding,
without stages and steps that each have to wait for the one before.
"""

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numba import njit

from irtiming.errors import EstimationError
from irtiming.physics.wheel import EDGE_SIGNS, TURN
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.lag_estimate import LagTiming, WheelInImage
from irtiming.records.wheel_geometry import WheelModel

STEPS_PER_SAMPLE = 10
START = 0.5
TURNS = 3
"""Of which the last is put out."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class MaskCrossings:
    """When the wheel's edges pass the pixels of each mask row, sorted: counting them is then a walk along a list.

    Parameters
    ----------
    row_px, pixels
        Shape (n_row,); image rows in which the mask has pixels, and how many.
    first
        Shape (n_row + 1,); row i owns crossings first[i] to first[i + 1].
    angle_rad, fraction
        Shape (n_crossing,); wheel angle in [0, 2 pi) of each crossing, ascending in each row, and the opening fraction of
        the row from there to the next.
    """

    row_px: Ticks
    pixels: Ticks
    first: Ticks
    angle_rad: Array
    fraction: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedRows:
    """Normalised opening fractions over the wheel angle at the trigger: shapes (n,), (n,) and (n_row, n)."""

    wheel_angle_rad: Array
    fraction: Array
    row_fraction: Array


def crossings(mask: Mask, model: WheelModel, *, wheel: WheelInImage) -> MaskCrossings:
    """Wheel angles at which the pixel centres of a mask are covered and uncovered.

    Parameters
    ----------
    mask
        Shape (row, column) of the whole image.
    model
        Angles of cutout edges and application gate.
    wheel
        Where the image shows the axle; a counterclockwise wheel is mirrored to the clockwise one of the model.

    Raises
    ------
    EstimationError
        If the mask has no pixel.

    Notes
    -----
    A pixel at polar angle phi is open when phi_A + theta - phi, modulo a turn, lies in [alpha_1, alpha_2) or
    [alpha_3, 2 pi): edge i passes it at theta = phi - phi_A + alpha_i.
    """
    row, column = np.nonzero(mask)
    if row.size == 0:
        raise EstimationError("the mask has no pixel: there is nothing to simulate; name the opening with --roi")
    phi = np.arctan2(row - wheel.row_px, column - wheel.column_px) - wheel.roll_rad
    if wheel.rotation == "counterclockwise":
        phi = np.pi - phi
    passed = np.mod((phi - model.gate_angle_rad)[:, None] + np.asarray(model.cutout_edges_rad), TURN)
    sign = np.asarray(EDGE_SIGNS)
    open_before = sign[np.argmax(passed, axis=1)] > 0  # as the pixel's last edge of a turn left it
    rows, pixels = np.unique(row, return_counts=True)
    order = np.lexsort((passed.ravel(), np.repeat(row, 4)))
    first = np.concatenate([[0], np.cumsum(4 * pixels)])
    # the four signs of a pixel add to nothing, so that one running sum serves all rows
    opened = np.cumsum(np.tile(sign, row.size)[order])
    before = np.bincount(row, open_before)[rows]
    return MaskCrossings(
        row_px=rows.astype(np.int64),
        pixels=pixels.astype(np.int64),
        first=first.astype(np.int64),
        angle_rad=passed.ravel()[order],
        fraction=(opened + np.repeat(before, 4 * pixels)) / np.repeat(pixels, 4 * pixels),
    )


def simulate(
    mask: MaskCrossings, timing: LagTiming, *, samples: int, angular_frequency_rad_per_s: float
) -> SimulatedRows:
    """Normalised opening fractions of the whole mask and of each of its rows at equidistant wheel angles.

    Parameters
    ----------
    mask
        Its pixels, as crossings.
    timing
        Trial parameters; the trigger delay with what was set in the trigger generator.
    samples
        Angles per turn, 0 the first.
    angular_frequency_rad_per_s
        Of the wheel.

    Returns
    -------
    Like the data, each curve is normalised by the averages of the extrema of its two upper and two lower plateaus.

    Raises
    ------
    EstimationError
        If a step is longer than the time constant, or a row has no two plateaus of either kind.

    Notes
    -----
    The paper calls the simulated quantities normalised and does not say how. A lagging pixel never reaches 0 or 1, and what
    the data call 1 is the most that they reach: so the same is done here. In a simulated recording of 120 rows, with a time
    constant of 6.12 ms at 3 Hz, the result was 0.05 ms off; with curves left as they are, 1.09 ms.
    """
    lag_rad = angular_frequency_rad_per_s * timing.time_constant_s
    if not lag_rad * STEPS_PER_SAMPLE * samples > TURN:
        raise EstimationError(
            f"a time constant of {1e6 * timing.time_constant_s:.1f} µs with {samples} angles per turn: a simulation step, "
            f"{1e6 * TURN / (STEPS_PER_SAMPLE * samples * angular_frequency_rad_per_s):.1f} µs, must be shorter than the time "
            "constant; sample the turn more finely"
        )
    advance = angular_frequency_rad_per_s * (timing.trigger_delay_s + mask.row_px * timing.row_delay_s)
    rows = _follow_rows((mask.first, mask.angle_rad, mask.fraction), np.mod(advance, TURN), lag_rad, samples)
    # eq. (2) is linear: the lagging sum is the sum of the lagging rows
    whole = (mask.pixels @ rows)[None, :]
    if not (_normalise(rows) and _normalise(whole)):
        raise EstimationError(
            f"simulated with a time constant of {1e3 * timing.time_constant_s:.3f} ms, an opening fraction does not rise and "
            "fall twice per turn as it must; correct [mask] and [wheel], or name the opening with --roi"
        )
    return SimulatedRows(
        wheel_angle_rad=np.asarray(TURN / samples * np.arange(samples)), fraction=whole[0], row_fraction=rows
    )


@njit(cache=True, nogil=True)
def _follow_rows(mask: tuple[Ticks, Array, Array], advance_rad: Array, lag_rad: float, samples: int) -> Array:
    """Lagging opening fraction of each row at the samples of the third turn, shape (n_row, samples)."""
    first, angle, fraction = mask
    out = np.empty((advance_rad.size, samples))
    for row in range(advance_rad.size):
        own = slice(first[row], first[row + 1])
        target = _targets(angle[own], fraction[own], advance_rad[row], 2 * STEPS_PER_SAMPLE * samples)
        _run(target, TURN / (STEPS_PER_SAMPLE * samples) / lag_rad, out[row])
    return out


@njit(cache=True, nogil=True)
def _targets(angle: Array, fraction: Array, start_rad: float, size: int) -> Array:
    """Instantaneous opening fraction at each half step of a turn from ``start_rad`` on, its end included."""
    target = np.empty(size + 1)
    following = np.searchsorted(angle, start_rad, side="right")
    now = fraction[following - 1]  # before the first crossing it is as after the last
    turned = 0.0
    if following == angle.size:
        following, turned = 0, TURN
    next_rad = angle[following] + turned
    for place in range(size + 1):
        here = start_rad + place * (TURN / size)
        while next_rad <= here:
            now = fraction[following]
            following += 1
            if following == angle.size:
                following, turned = 0, turned + TURN
            next_rad = angle[following] + turned
        target[place] = now
    return target


@njit(cache=True, nogil=True)
def _run(target: Array, z: float, out: Array) -> None:
    """Runge-Kutta steps of ``z`` time constants over all turns; values at the samples of the last one into ``out``."""
    at_start = z / 6 * (1 - z + z**2 / 2 - z**3 / 4)
    at_middle = z / 6 * (4 - 2 * z + z**2 / 2)
    at_end = z / 6
    keep = 1 - z + z**2 / 2 - z**3 / 6 + z**4 / 24
    drawn = np.zeros(out.size)  # what the steps from one sample to the next make of 0
    for sample in range(out.size):
        for step in range(sample * STEPS_PER_SAMPLE, (sample + 1) * STEPS_PER_SAMPLE):
            exposed = at_start * target[2 * step] + at_middle * target[2 * step + 1] + at_end * target[2 * step + 2]
            drawn[sample] = keep * drawn[sample] + exposed
    kept = keep**STEPS_PER_SAMPLE
    value = START
    for _ in range(TURNS):
        for sample in range(out.size):
            out[sample] = value
            value = kept * value + drawn[sample]


@njit(cache=True, nogil=True)
def _normalise(curves: Array) -> bool:
    """Normalise each curve in place by the averages of the extrema of its plateaus; False if one has not two of each."""
    sound = np.zeros(curves.shape[0], np.bool_)
    for row in range(curves.shape[0]):
        low, high = _levels(curves[row])
        curves[row] = (curves[row] - low) / (high - low)
        sound[row] = high > low
    return bool(sound.all())


@njit(cache=True, nogil=True)
def _levels(curve: Array) -> tuple[float, float]:
    """Mean of the lowest values of both lower plateaus and of the highest of both upper ones; NaN if there are not two."""
    begin = np.argmin(curve)
    least, most = curve[begin], curve.max()
    if not most > least:
        return math.nan, math.nan
    total, count = np.zeros(2), np.zeros(2)
    extremum, side = least, 0
    for k in range(begin - curve.size, begin + 1):  # once around
        value = curve[k]
        place = (value - least) / (most - least)
        # a row that the mask's inner arc parts in two rests half way: on a slope a value belongs to the plateau before
        now = 1 if place > 0.75 else 0 if place < 0.25 else side
        if now != side:
            total[side] += extremum
            count[side] += 1
            extremum, side = value, now
        extremum = max(extremum, value) if side == 1 else min(extremum, value)
    if count[0] != 2 or count[1] != 2:
        return math.nan, math.nan
    return total[0] / 2, total[1] / 2
