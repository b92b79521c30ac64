"""Timing of one recording from its row sums, by an exact model (default method).

`physics.light.row_sum` says what each row sees over the wheel angle; gain and offset of each row are free. All rows are fitted at
once by weighted least squares with analytic derivatives, on the compressed row sums (`estimate.harmonic_data`): gains are
eliminated by projection, and each row's variance is that of its own residuals, so that what is minimised is the sum over rows of
n log(mean square residual), counted from what the best periodic curve would leave.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate.harmonic_data import HarmonicData, packed
from irtiming.inference.condensed import condensed
from irtiming.inference.optimiser import Linearised, Minimum, minimise
from irtiming.physics.light import row_sum
from irtiming.physics.light.row_sum import EDGE_DELAYS, RowSum, Timing
from irtiming.physics.response import integration_window
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.row_timing import Rival

_WINDOW = integration_window.PARAMETER
_COARSE = 20
_RESPONSES_RAD = np.geomspace(2e-3, 0.6, 9)  # of the wheel: where the search looks for the response's parameter
_SEARCHED_ROWS = 16  # about as many are looked at in the search
_ALIKE = 0.05  # of a half turn: a frame that is nearer to whole ones after another shows nearly the same
_LEAST_SHARE = -0.5  # of the frame before: at -1 a filter makes any odd harmonic of next to nothing
_UNTOLD = 16.0  # of the deviance: frames that say no more against a share of none hardly tell one
_APART = 3.0  # standard uncertainties from which two minima are two
_CLEARLY = 4.0  # misfit by which another minimum must be lower than that of the start
_EARLIEST = 0.2  # of half a turn before the trigger: the earliest that the middle row may be read


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """Where the search ended, by name; where it ``began``, and how many ``n_steps`` it took.

    ``gain`` and ``variance`` have shape (n_segment, n_row) and (n_row,). ``misfit`` is the deviance, and what numbers that no
    camera has add to it; ``u`` are the standard uncertainties of response and share of the frame before, were residuals white;
    ``rival`` is the next higher minimum.
    """

    minimum: Minimum
    began: Timing
    n_steps: int
    gain: Array
    variance: Array
    misfit: float
    u: Timing
    rival: Rival | None = None

    @property
    def timing(self) -> Timing:
        """All numbers at the minimum."""
        return self.minimum.values

    def is_apart(self, other: "Solution") -> bool:
        """Whether another search ended in another minimum, whose response or share differs far beyond the uncertainty.

        A window may be longer or shorter, but has no sign.
        """
        ends = [dict(end.timing) | {_WINDOW: abs(end.timing.get(_WINDOW, 0.0))} for end in (self, other)]
        return any(abs(ends[0][name] - ends[1][name]) > _APART * u for name, u in self.u.items())

    @property
    def normal(self) -> Array:
        """Normal equations' matrix of the numbers that were free, shape (k, k)."""
        at = [list(self.timing).index(name) for name in self.minimum.free]
        return self.minimum.at.normal[np.ix_(at, at)]


def solve(
    data: Sequence[HarmonicData], model: RowSum, *, start: Timing | None = None, signs: tuple[int, ...] = (1, -1),
    held: Timing | None = None, is_searched: bool = False,
) -> Solution:  # fmt: skip
    """Least squares in the model's numbers, from a start that the data give.

    Parameters
    ----------
    data
        One per stretch between shutter events.
    model
        Rows of the camera.
    start
        Where to begin; None searches.
    signs
        Of the contrast, where to search: 1 for a warm blackbody, -1 for a cold one. An even wheel cannot tell them apart: the
        other one is a quarter turn later.
    held
        Numbers that keep these values.
    is_searched
        Whether to search beside a start, too; that is left where another minimum is clearly lower.

    Raises
    ------
    EstimationError
        If the rows show nothing that turns with the wheel.
    """
    fixed, n_coarse, begins = dict(held or {}), 0, []
    if start is not None:
        began, memory = {**start, **fixed}, model.camera.memory.PARAMETER
        begins.append((began, began if _is_share(began[memory]) else {**began, memory: 0.0}))
    if start is None or is_searched:
        coarse, few = [part.lowest(_COARSE) for part in data], model.lowest(_COARSE)
        near = _near(coarse, few, signs=signs, held=fixed)
        near += _beside(data, model, start=begins[0][1], held=fixed) if begins else []
        n_coarse = sum(one.n_steps for one in near)
        begins += [(one.start, one.values) for one in near]
    ends = [_end(data, model, began=began, begin=begin, held=fixed) for began, begin in begins]
    by_depth = sorted(ends, key=lambda end: end.misfit)
    best = by_depth[0]
    if start is not None and ends[0].misfit < best.misfit + _CLEARLY:
        best = ends[0]
    others = [Rival(timing=end.timing, higher=end.misfit - best.misfit) for end in by_depth if best.is_apart(end)]
    return replace(best, n_steps=n_coarse + sum(end.n_steps for end in ends), rival=others[0] if others else None)


def _end(data: Sequence[HarmonicData], model: RowSum, *, began: Timing, begin: Timing, held: Timing) -> Solution:
    """Where one search ends; a lag or a share of the frame before that is below zero counts as higher by how unlikely it is."""
    found, at = _with_share(data, model, start=begin, held=held)
    memory, response = model.camera.memory.PARAMETER, model.camera.response.PARAMETER
    u = {name: _white_u(at.normal, model.names.index(name)) for name in (memory, response)}
    of_cameras = [name for name in u if name not in held and not (name == response and not model.camera.lags)]
    below = np.array([min(0.0, found.values[name]) / u[name] for name in of_cameras])
    return Solution(
        minimum=found, began=began, n_steps=found.n_steps, gain=at.gain, variance=at.variance,
        misfit=found.at.deviance + float(below @ below), u=u,
    )  # fmt: skip


def _near(data: Sequence[HarmonicData], model: RowSum, *, signs: tuple[int, ...], held: Timing) -> list[Minimum]:
    """The minima that searches from some shares of the frame before lead to, with a share below one; each once.

    Few harmonics hardly tell a filter from a lag that is as long, so that the lower of two minima may be the wrong one.

    A recursive filter of k and one of 1 / k leave each harmonic equally strong, and without bounds k becomes a delay of one
    frame: a search that passes k = 1 ends there, with as good a fit and a wrong delay.
    """
    memory = model.camera.memory
    shares = [held[memory.PARAMETER]] if memory.PARAMETER in held else memory.LOOKED_AT
    starts = [{**_search(data, model, signs=signs, held={**held, memory.PARAMETER: share}), **held} for share in shares]
    found = [_with_share(data, model, start=start, held=held)[0] for start in starts]
    possible = _possible(found, memory.PARAMETER)
    if not possible:
        least = min((one.values[memory.PARAMETER] for one in found), key=abs)
        raise EstimationError(_no_share(least, step_rad=model.step_rad))
    return possible


def _beside(data: Sequence[HarmonicData], model: RowSum, *, start: Timing, held: Timing) -> list[Minimum]:
    """The minima of some rows, with a share below one, that lie at other shares than an earlier fit, found with all harmonics.

    A lag and a filter that are nearly as long make one valley of two minima, which few harmonics do not tell apart.
    """
    memory = model.camera.memory
    if memory.PARAMETER in held:
        return []
    few, rows = _some_rows(data, model)
    at = [{memory.PARAMETER: share} for share in memory.LOOKED_AT]
    there = [_minimum(few, rows, start={**start, **one}, held={**held, **one})[0].values for one in at]
    return _possible([_with_share(few, rows, start=one, held=held)[0] for one in there], memory.PARAMETER)


def _possible(found: Sequence[Minimum], share: str) -> list[Minimum]:
    """Those whose share of the frame before, by its name, is below one; of equal deviances the first."""
    below = [one for one in found if abs(one.values[share]) < 1]
    return list({round(one.at.deviance, 3): one for one in reversed(below)}.values())


def _some_rows(data: Sequence[HarmonicData], model: RowSum) -> tuple[list[HarmonicData], RowSum]:
    """As few rows as a search looks at."""
    every = slice(None, None, max(1, model.row_px.size // _SEARCHED_ROWS))
    return [part.some_rows(every) for part in data], model.some_rows(every)


def _is_share(value: float) -> bool:
    """Whether a camera's frames may seem to hold so much of the frame before: it is 0 to 1, but for noise."""
    return _LEAST_SHARE < value < 1


def _with_share(
    data: Sequence[HarmonicData], model: RowSum, *, start: Timing, held: Timing
) -> "tuple[Minimum, _Projected]":
    """Where the search ended; if that is no share, where it ends without one, as far as the frames do not contradict that.

    The share counts as free there, too: what frames that hardly tell it leave open is in the uncertainty.
    """
    memory = model.camera.memory.PARAMETER
    found = _minimum(data, model, start=start, held=held)
    if memory in held or _is_share(found[0].values[memory]):
        return found
    none = {memory: 0.0}
    without, at = _minimum(data, model, start={**start, **none}, held={**held, **none})
    is_untold = without.at.deviance - found[0].at.deviance < _UNTOLD
    return (replace(without, free=found[0].free), at) if is_untold else found


def _no_share(least: float, *, step_rad: float) -> str:
    """Why ``least`` can be no share of the frame before, where the wheel turns by ``step_rad`` from trigger to trigger."""
    what = (
        f"the row sums fit only if each frame holds {least:.3g} of the frame before, a share that must be between -1 and 1: the "
        "fit has not found when the rows are read"
    )
    half_turns = 2 * step_rad / TURN
    if abs(half_turns - round(half_turns)) > _ALIKE:
        return (
            f"{what}; check that every frame belongs to its trigger (frame_number), that the triggers reached the camera, that "
            "rig.toml is that of this rig, and that the camera's noise filter is off; then record again"
        )
    return (
        f"{what}; the wheel turns by {half_turns:.4f} half turns from frame to frame, so that the frame before shows nearly the "
        "same: how much of it a frame holds cannot be determined; record at another wheel speed or frame rate (irtiming plan)"
    )


def uncertainty(data: Sequence[HarmonicData], model: RowSum, *, timing: Timing, name: str) -> float:
    """Standard uncertainty of one number at a minimum in the others, were residuals white; infinite where nothing tells it."""
    return _white_u(_project(data, model, timing).normal, model.names.index(name))


def _white_u(normal: Array, k: int) -> float:
    """Standard uncertainty of the k-th number by the normal equations' matrix of all."""
    others = np.delete(np.arange(len(normal)), k)
    apart = normal[k, others] @ np.linalg.solve(normal[np.ix_(others, others)], normal[others, k])
    left = float(normal[k, k] - apart)
    return left**-0.5 if left > 0 else np.inf


def likelihood(data: Sequence[HarmonicData], model: RowSum, *, timing: Timing) -> Linearised:
    """How well any numbers fit, as few residuals with derivatives in the order of ``model.names``.

    The deviance is the sum over rows of n log(mean square residual) less that of the best periodic curve.
    """
    at = _project(data, model, timing)
    return condensed(deviance=at.deviance, gradient=at.gradient, normal=at.normal)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Projected:
    """Gradient and normal matrix at a point, gains (n_segment, n_row) at their best, variance of each row, deviance."""

    gradient: Array
    normal: Array
    deviance: float
    gain: Array
    variance: Array


def _minimum(
    data: Sequence[HarmonicData], model: RowSum, *, start: Timing, held: Collection[str]
) -> tuple[Minimum, _Projected]:
    """Where the search ended, and the rows there."""
    ordered = {name: start[name] for name in model.names}
    last: list[_Projected] = []

    def model_at(timing: Timing) -> Linearised:
        last[:] = [_project(data, model, timing)]
        return condensed(deviance=last[0].deviance, gradient=last[0].gradient, normal=last[0].normal)

    found = minimise(model_at, start=ordered, held=held)
    return found, last[0]  # where a search ends is the last place that it looks at


def _project(data: Sequence[HarmonicData], model: RowSum, timing: Timing) -> _Projected:
    whole, slopes = row_sum.linearised(model, timing)
    columns = np.ascontiguousarray(packed(np.concatenate([whole[None], slopes])).transpose(1, 0, 2))
    n_row, n_column, _ = columns.shape
    freedom = sum(part.n_frames for part in data) - 2 * len(data)
    gains, normals, gradients, left, least = [], [], [], np.zeros(n_row), np.zeros(n_row)
    for part in data:
        white = part.white
        whitened = (columns.reshape(n_row * n_column, -1) @ white.root.T).reshape(n_row, n_column, -1)
        shape, slope = whitened[:, :1], whitened[:, 1:]
        norm = np.maximum(np.einsum("yik,yik->y", shape, shape), 1e-300)
        gain = np.einsum("yik,yk->y", shape, white.target) / norm
        residual = white.target - gain[:, None] * shape[:, 0]
        along = slope @ shape.transpose(0, 2, 1)
        square = slope @ slope.transpose(0, 2, 1) - along * along.transpose(0, 2, 1) / norm[:, None, None]
        normals.append(gain[:, None, None] ** 2 * square)
        gradients.append(gain[:, None] * (slope @ residual[:, :, None])[:, :, 0])
        gains.append(gain)
        left += white.rest + np.einsum("yk,yk->y", residual, residual)
        least += white.rest
    variance = left / freedom
    return _Projected(
        gradient=np.einsum("y,yk->k", 1 / variance, np.sum(gradients, axis=0)),
        normal=np.einsum("y,ykl->kl", 1 / variance, np.sum(normals, axis=0)),
        deviance=float(freedom * np.sum(np.log(left / least))),
        gain=np.array(gains),
        variance=variance,
    )


def _search(data: Sequence[HarmonicData], model: RowSum, *, signs: tuple[int, ...], held: Timing) -> Timing:
    """Start values: for each of some responses the delay and row delay by the phases of the rows' second harmonic; memory held.

    The wheel looks the same after half a turn, so the middle row is taken to be read at most a fifth of that before the trigger
    and four fifths after it.
    """
    data, model = _some_rows(data, model)
    omega, response = model.angular_frequency_rad_per_s, model.camera.response.PARAMETER
    memory = model.camera.memory.PARAMETER
    part = max(data, key=lambda one: one.n_frames)
    most = (part.gram.shape[0] - 1) // 2
    amplitude = np.linalg.solve(part.gram[1:, 1:] + 1e-9 * np.trace(part.gram) * np.eye(2 * most), part.moment[:, 1:].T)
    wave = amplitude[1] - 1j * amplitude[most + 1]
    if not np.all(np.isfinite(wave)) or not np.any(wave):
        raise EstimationError(
            "the row sums do not change with the wheel; check the recording and its region of interest"
        )
    tried = [held[response]] if response in held else (_RESPONSES_RAD / omega).tolist()
    trials = [
        _by_phases(wave, model, sign=sign, held={response: value, memory: held[memory]})
        for value in tried
        for sign in signs  # the other one is half a period of the second harmonic later
    ]
    return min(trials, key=lambda timing: _project(data, model, timing).deviance)


def _by_phases(wave: Array, model: RowSum, *, sign: int, held: Timing) -> Timing:
    """Delay of all edges, and row delay if there is one, that give the rows' second harmonic (n_row,) its phases."""
    omega, readout = model.angular_frequency_rad_per_s, model.camera.readout.PARAMETERS
    at_once = dict.fromkeys(model.names, 0.0) | dict(held)
    turned = sign * wave * row_sum.harmonics(model.lowest(2), at_once)[:, 2].conj()
    phase = np.angle(np.sum(turned))
    rows = np.angle(turned * np.exp(-1j * phase))
    slope, level = np.polyfit(model.row_px, rows, 1, w=np.sqrt(np.abs(turned))) if readout else (0.0, 0.0)
    middle_s = slope / (2 * omega) * float(np.mean(model.row_px))
    half_turn_s = np.pi / omega
    earliest_s = _EARLIEST * half_turn_s
    read_s = np.mod((phase + level) / (2 * omega) + middle_s + earliest_s, half_turn_s) - earliest_s
    return (
        at_once
        | dict.fromkeys(EDGE_DELAYS, float(read_s - middle_s))
        | dict.fromkeys(readout, float(slope / (2 * omega)))
    )
