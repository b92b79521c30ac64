r"""Delay, time constant and row delay from the row sums of one recording, by an exact model (default method).

Row y, read at t_delay + y t_row, sees the opening through a weight over polar angle (`physics.blurred_sector`), the wheel
covers and uncovers it, and the pixels lag behind (`physics.first_order_lag`). All three are factors on the harmonics:

    F_ym = sum_i  open_im  K_ym  exp(i m omega (d_i + y t_row)) / (1 + i m omega tau)

with one delay d_i per wheel edge, because the cutout's edges need not stand where the ring's do. Gain and offset of each row
are free. All rows are fitted at once by weighted least squares with analytic derivatives, on the compressed row sums
(`estimate.harmonic_data`). The covariance comes from the residuals themselves, frame by frame over all rows, with their
correlation along the wheel angle: nothing is taken to be white that is not.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate.harmonic_data import HarmonicData, packed
from irtiming.physics import wheel_harmonics
from irtiming.physics.response import first_order_lag
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, ComplexArray, Ticks

HARMONICS = 64
"""Highest order of the model: at tau = 3 ms and 3 Hz what is beyond has a hundredth of the power of a row's noise."""

_COARSE = 20
_TAU_TURNS = np.geomspace(1e-3, 0.3, 9)  # of a turn over 2 pi: where the search for tau looks first
_MOST_STEPS = 100
_SETTLED = 0.05  # standard uncertainties that the last step may have: it leaves a hundredth of that
_SEARCHED_ROWS = 16  # about as many are looked at in the search
_EARLIEST = 0.2  # of half a turn before the trigger: the earliest that the middle row may be read
_ROUNDING = 0.02  # of the deviance, where residuals are a ten-thousandth of the sums


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowModel:
    """What the fit needs to know of the rig: open_im, shape (4, M + 1), K_ym, shape (n_row, M + 1), rows and omega."""

    open_harmonics: ComplexArray
    row_harmonics: ComplexArray
    row_px: Ticks
    angular_frequency_rad_per_s: float

    def lowest(self, n_harmonics: int) -> "RowModel":
        """The same with fewer harmonics."""
        return RowModel(
            open_harmonics=self.open_harmonics[:, : n_harmonics + 1],
            row_harmonics=self.row_harmonics[:, : n_harmonics + 1],
            row_px=self.row_px,
            angular_frequency_rad_per_s=self.angular_frequency_rad_per_s,
        )

    def some_rows(self, rows: slice) -> "RowModel":
        """The same with fewer rows."""
        return RowModel(
            open_harmonics=self.open_harmonics,
            row_harmonics=self.row_harmonics[rows],
            row_px=self.row_px[rows],
            angular_frequency_rad_per_s=self.angular_frequency_rad_per_s,
        )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """The six numbers (four edge delays, tau, t_row; s), their normal matrix (s^-2), deviance and where the search began.

    ``gain`` and ``variance`` have shape (n_segment, n_row) and (n_row,).
    """

    values: Array
    normal: Array
    deviance: float
    gain: Array
    variance: Array
    start: Array
    n_steps: int


def solve(
    data: list[HarmonicData], model: RowModel, *, start: Array | None = None, signs: tuple[int, ...] = (1, -1)
) -> Solution:  # fmt: skip
    """Least squares in the six numbers, from a start that the data give.

    Parameters
    ----------
    data
        One per stretch between shutter events.
    model
        Rig.
    start
        Six numbers to begin at, s; None searches.
    signs
        Of the contrast, where to search: 1 for a warm blackbody, -1 for a cold one. An even wheel cannot tell them apart: the
        other one is a quarter turn later.

    Raises
    ------
    EstimationError
        If no minimum is reached.
    """
    coarse = [part.lowest(_COARSE) for part in data]
    begun = _search(coarse, model.lowest(_COARSE), signs) if start is None else start
    near, _, n_coarse = _descend(coarse, model.lowest(_COARSE), begun)
    best, at, n_fine = _descend(data, model, near)
    return Solution(
        values=best, normal=at.normal, deviance=at.deviance, gain=at.gain, variance=at.variance, start=begun,
        n_steps=n_coarse + n_fine,
    )  # fmt: skip


def profile(data: list[HarmonicData], model: RowModel, *, values: Array, time_constant_s: float) -> float:
    """Deviance at a given time constant, all else at its best near ``values``."""
    there = np.array([*values[:4] - (time_constant_s - values[4]), time_constant_s, values[5]])
    _, at, _ = _descend(data, model, there, free=np.array([0, 1, 2, 3, 5]))
    return at.deviance


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Parabola:
    """Deviance at some six numbers, half its gradient there with the sign turned, (6,), and half its curvature, (6, 6)."""

    deviance: float
    gradient: Array
    normal: Array


def parabola(data: list[HarmonicData], model: RowModel, *, values: Array) -> Parabola:
    """How well six numbers fit, and which would fit better; parameters as for `solve`, ``values`` of shape (6,), s."""
    at = _linearise(data, model, values)
    return Parabola(deviance=at.deviance, gradient=at.gradient, normal=at.normal)


def row_functions(model: RowModel, values: Array) -> tuple[ComplexArray, ComplexArray]:
    """Harmonics of each row, and their derivatives to d_0..d_3, tau, t_row.

    Returns
    -------
    Shapes (n_row, M + 1) and (6, n_row, M + 1), the latter per second.
    """
    omega, tau, t_row = model.angular_frequency_rad_per_s, values[4], values[5]
    n = model.row_harmonics.shape[1] - 1
    turning = 1j * np.arange(n + 1) * omega
    lag = first_order_lag.transfer(omega, tau, n_harmonics=n)
    edges = model.open_harmonics * wheel_harmonics.later(omega * values[:4], n_harmonics=n) * lag
    rows = model.row_harmonics * wheel_harmonics.later(omega * model.row_px * t_row, n_harmonics=n)
    by_edge = (edges * turning)[:, None, :] * rows
    whole = edges.sum(axis=0) * rows
    by_row = by_edge.sum(axis=0) * model.row_px[:, None]
    return whole, np.concatenate([by_edge, (-turning * lag * whole)[None], by_row[None]])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Linear:
    """Gradient and normal matrix at a point; deviance = sum over rows of n log(mean square residual)."""

    gradient: Array
    normal: Array
    deviance: float
    gain: Array
    variance: Array


def _linearise(data: list[HarmonicData], model: RowModel, values: Array) -> _Linear:
    whole, slopes = row_functions(model, values)
    columns = np.ascontiguousarray(packed(np.concatenate([whole[None], slopes])).transpose(1, 0, 2))
    n_row, n_column, _ = columns.shape
    n_frames = sum(part.n_frames for part in data)
    products, projections = [], []
    for part in data:
        through = (columns.reshape(n_row * n_column, -1) @ part.gram).reshape(columns.shape)
        products.append(through @ columns.transpose(0, 2, 1))
        projections.append((columns @ part.moment[:, :, None])[:, :, 0])
    gain = np.array([b[:, 0] / a[:, 0, 0] for a, b in zip(products, projections, strict=True)])
    left = sum(part.power - b[:, 0] ** 2 / a[:, 0, 0] for part, a, b in zip(data, products, projections, strict=True))
    variance = np.maximum(np.asarray(left), 1e-12 * sum(part.power for part in data)) / (n_frames - 2 * len(data))
    normal, gradient = np.zeros((6, 6)), np.zeros(6)
    for a, b, g in zip(products, projections, gain, strict=True):
        free = a[:, 1:, 1:] - a[:, 1:, :1] * a[:, :1, 1:] / a[:, :1, :1]
        normal += np.tensordot(g**2 / variance, free, 1)
        gradient += (g / variance) @ (b[:, 1:] - g[:, None] * a[:, 1:, 0])
    return _Linear(
        gradient=gradient,
        normal=normal,
        deviance=float(n_frames * np.sum(np.log(variance))),
        gain=gain,
        variance=variance,
    )


def _misfit(data: list[HarmonicData], model: RowModel, values: Array) -> float:
    """The deviance alone, where the search looks."""
    shape = packed(row_functions(model, values)[0])
    left = sum(
        part.power - np.einsum("yp,yp->y", shape, part.moment) ** 2 / np.einsum("yp,yp->y", shape @ part.gram, shape)
        for part in data
    )
    return float(np.sum(np.log(np.maximum(np.asarray(left), 1e-300))))


def _descend(
    data: list[HarmonicData], model: RowModel, start: Array, *, free: Ticks | None = None
) -> tuple[Array, _Linear, int]:
    """Newton's method with Levenberg's damping in the free numbers; the minimum, the problem there and the number of steps.

    The last step is so small that the problem is not set up anew after it.
    """
    free = np.arange(6) if free is None else free
    values, damping = np.array(start, float), 0.0
    at = _linearise(data, model, values)
    for step in range(1, _MOST_STEPS + 1):
        normal = at.normal[np.ix_(free, free)]
        move = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), at.gradient[free])
        tried = values.copy()
        tried[free] += move
        if damping < 1e-3 and np.all(np.abs(move) <= _SETTLED / np.sqrt(np.diag(normal))):
            return tried, at, step
        then = _linearise(data, model, tried)
        if then.deviance <= at.deviance + _ROUNDING:
            values, at, damping = tried, then, damping / 30 if damping > 1e-4 else 0.0
            continue
        damping = max(10 * damping, 1e-3)
        if damping > 1e9:
            return values, at, step
    raise EstimationError(
        f"the fit of the row sums did not settle in {_MOST_STEPS} steps (last time constant {1e3 * values[4]:.3f} ms); the "
        "frames do not follow the wheel as a lagging camera would: check [wheel] and [mask] in rig.toml and the recording"
    )


def _search(data: list[HarmonicData], model: RowModel, signs: tuple[int, ...]) -> Array:
    """Start values: for each of some time constants the delay and row delay by the phases of the rows' second harmonic.

    The wheel looks the same after half a turn, so the middle row is taken to be read at most a fifth of that before the trigger
    and four fifths after it.
    """
    every = slice(None, None, max(1, model.row_px.size // _SEARCHED_ROWS))
    model, data = model.some_rows(every), [part.some_rows(every) for part in data]
    omega = model.angular_frequency_rad_per_s
    part = max(data, key=lambda one: one.n_frames)
    most = (part.gram.shape[0] - 1) // 2
    amplitude = np.linalg.solve(part.gram[1:, 1:] + 1e-9 * np.trace(part.gram) * np.eye(2 * most), part.moment[:, 1:].T)
    seen = amplitude[1] - 1j * amplitude[most + 1]
    half_turn_s, trials = np.pi / omega, []
    earliest_s = _EARLIEST * half_turn_s
    for tau in _TAU_TURNS * TURN / omega / np.pi:
        still, _ = row_functions(model, np.array([0, 0, 0, 0, tau, 0.0]))
        for sign in signs:  # the other one is half a period of the second harmonic later
            turned = sign * seen * still[:, 2].conj()
            phase = np.angle(np.sum(turned))
            rows = np.angle(turned * np.exp(-1j * phase))
            slope, level = np.polyfit(model.row_px, rows, 1, w=np.sqrt(np.abs(turned)))
            t_row = slope / (2 * omega)
            middle_s = t_row * np.mean(model.row_px)
            read_s = np.mod((phase + level) / (2 * omega) + middle_s + earliest_s, half_turn_s) - earliest_s
            values = np.array([*[read_s - middle_s] * 4, tau, t_row])
            trials.append((_misfit(data, model, values), values))
    return min(trials, key=lambda trial: trial[0])[1]
