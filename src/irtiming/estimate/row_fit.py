"""The exact model fitted to one recording: from row sums to its numbers by name, and their covariance."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.errors import about
from irtiming.estimate import frame_steps, harmonic_data, row_sway, row_timing
from irtiming.estimate.harmonic_data import HarmonicData, packed
from irtiming.estimate.row_light import SHAPE_NUMBERS, RowLight
from irtiming.estimate.row_residuals import inflated_in_time, robust_covariance
from irtiming.estimate.row_timing import Solution
from irtiming.inference.correlated_noise import ljung_box_p_value
from irtiming.inference.one_thread import one_thread
from irtiming.inference.optimiser import Linearised
from irtiming.physics import wheel_harmonics
from irtiming.physics.camera import camera
from irtiming.physics.covariance import generalised_inverse
from irtiming.physics.light import row_sum
from irtiming.physics.light.bent_rows import NONLINEARITIES
from irtiming.physics.light.row_sum import BLADE, RowSum, Timing, completed
from irtiming.physics.response import in_camera_filter, integration_window
from irtiming.physics.wheel import TURN
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, ComplexArray, Mask
from irtiming.records.estimate import Estimate
from irtiming.records.reduced import ReducedRecording
from irtiming.records.result import LEAST_WHITENESS
from irtiming.records.row_timing import RowTimingFit, Sway
from irtiming.records.wheel_geometry import WheelModel

_WINDOW = integration_window.PARAMETER
_SIGNIFICANT = 3.0  # standard uncertainties from which a filter is undone, a blade has two numbers, a curve is fitted
_BLOCK = 256  # frames whose scores are made together
_RANK = 1e-6  # relative: amounts of a sway that timing nearly takes over count as determined so well, and hardly move
_NONE = 1e-300
_RESOLVED = 1e-3  # of a turn: a window that does something to the frames
_UNDETERMINED = 0.25  # relative standard uncertainty from which the frames say less of a window than the recording does


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Task:
    """Wheel angle (n,) of each frame, sums (n, n_row) of the lit rows, frames of each stretch; compressed, and the model.

    ``pixels`` (n_row,) is how many of each row the wheel turns before, ``kept`` (n_kept,) are the frames of the recording that
    take part, ``sway`` how the levels of all its frames changed. ``stated`` is what the recording says of the model's numbers,
    ``signs`` which way the contrast goes.
    """

    kept: Mask
    sway: Sway | None
    angle: Array
    sums: Array
    stretches: list[Mask]
    data: list[HarmonicData]
    model: RowSum
    pixels: Array
    stated: Timing
    signs: tuple[int, ...]


def fit(
    rows: ReducedRecording, wheel: WheelModel, *, light: RowLight, start: RowTimingFit | None = None,
    is_searched: bool = False,
) -> RowTimingFit:  # fmt: skip
    """All rows of one recording at once.

    Parameters
    ----------
    rows
        Row sums over the trigger ticks.
    wheel
        Geometry of wheel and gates; its opening angle plays no part, the light has its own.
    light
        Of the rows.
    start
        An earlier fit of the same camera; without one the start values are searched for.
    is_searched
        Whether they are searched for beside an earlier fit, too: the light that one was made with may have led it astray.

    Returns
    -------
    The fit as if the light were exact: ``shape_effect`` is zero.

    Raises
    ------
    EstimationError
        If the rows show nothing that turns with the wheel.
    """
    with one_thread(), about(rows.name):
        return _fit(rows, wheel, light=light, start=start, is_searched=is_searched)


def with_shape_effect(
    found: RowTimingFit, rows: ReducedRecording, *, wheel: WheelModel, light: RowLight, changes: ComplexArray
) -> RowTimingFit:  # fmt: skip
    """A fit that knows what its numbers owe to each number of the sector: one linear step.

    Parameters
    ----------
    found, rows, wheel, light
        The fit and what it was made of.
    changes
        Derivatives of the light to the sector's numbers, shape (n_shape, n_row, M + 1); see `row_light.changes`.
    """
    with one_thread(), about(rows.name):
        task = _task(rows, wheel, light, before=found)
        at = row_timing.solve(task.data, task.model, start=found.timing, held=found.held)
        return replace(found, shape_effect=_shape_effect(task, at, changes))


def _fit(
    rows: ReducedRecording, wheel: WheelModel, *, light: RowLight, start: RowTimingFit | None, is_searched: bool
) -> RowTimingFit:
    task = _task(rows, wheel, light, before=_to_take_out(start, rows, light=light))
    found, held = _solved(task, start, is_searched=is_searched)
    names = found.minimum.free
    waves = harmonic_data.basis(task.angle, n_harmonics=task.model.n_harmonics)
    whole = row_sum.harmonics(task.model, found.timing)
    model = (packed(whole) @ waves).T
    residual, fraction = _residuals(task, found, model)
    mass, noise = np.asarray(light.harmonics[:, 0].real, dtype=float), np.std(fraction - model, axis=0)
    scored = _scores(task, found, residual=residual, waves=waves, swaying=_swaying(task, model))
    order = np.argsort(np.mod(task.angle, TURN))
    covariance, variance_inflation = robust_covariance(
        scored.timing[order], scored.normal, information=scored.information[order]
    )
    if ljung_box_p_value(np.mean((fraction - model) / noise, axis=1)) < LEAST_WHITENESS:
        covariance = inflated_in_time(covariance, scored.timing, normal=scored.normal)
    estimate = _estimate(task, names, values=[found.timing[name] for name in names], covariance=covariance)
    return RowTimingFit(
        name=rows.name,
        trigger_delay_time_set_s=rows.trigger_delay_time_set_s,
        angular_frequency_rad_per_s=rows.track.angular_frequency_rad_per_s,
        estimate=estimate,
        held=held,
        step_rad=task.model.step_rad,
        undone=task.model.undone,
        blades_apart=task.model.blades_apart,
        is_bent=task.model.powers is not None,
        bends=None if start is None else _bends(task, found, light, known=estimate, inflation=variance_inflation),
        sway=None
        if task.sway is None
        else row_sway.improved(task.sway, scored.sway_step, covariance=scored.sway_covariance),
        kept=task.kept,
        rival=found.rival and replace(found.rival, higher=found.rival.higher / variance_inflation),
        start=found.began,
        n_steps=found.n_steps,
        shape_effect=np.zeros((len(names), len(SHAPE_NUMBERS))),
        row_px=light.row_px,
        wheel_angle_rad=np.mod(task.angle, TURN),
        fraction=fraction / mass,
        model=model / mass,
        residual=(fraction - model) / mass,
        noise=noise / mass,
        harmonics=whole / mass[:, None],
        gain_dn=found.gain.mean(axis=0) * mass,
        contrast_dn=np.asarray(found.gain @ (mass / mass.sum())),
        variance_inflation=variance_inflation,
        blackbody_temperature_k=rows.blackbody_temperature_k,
    )


def _estimate(task: _Task, names: Sequence[str], *, values: Sequence[float], covariance: Array) -> Estimate:
    units = tuple(row_sum.unit(name, task.model.camera) for name in names)
    return Estimate(names=tuple(names), units=units, values=np.array(values), covariance=covariance)


def _bends(task: _Task, found: Solution, light: RowLight, *, known: Estimate, inflation: float) -> Estimate | None:
    """What bends the response of pixels that lag, fitted or by one step from where the fit without it has ended."""
    if not task.model.camera.lags:
        return None
    if task.model.powers is not None:
        return known.pick(*NONLINEARITIES)
    names = (*found.minimum.free, *NONLINEARITIES)
    model = replace(task.model, powers=light.powers)
    there = row_timing.likelihood(task.data, model, timing=completed(found.timing))
    at = [model.names.index(name) for name in names]
    white = np.linalg.inv(there.normal[np.ix_(at, at)])
    step = white @ there.gradient[at]
    return _estimate(task, names, values=step.tolist(), covariance=np.asarray(inflation * white)).pick(*NONLINEARITIES)


def are_bent(fits: Sequence[RowTimingFit]) -> bool:
    """Whether the response of a camera is no straight line beyond doubt: then what bends it is fitted, and from then on.

    Parameters
    ----------
    fits
        Of recordings of one contrast, which share those numbers.
    """
    if any(fit.is_bent for fit in fits):
        return True
    looks = [fit.bends for fit in fits if fit.bends is not None]
    weights = [np.array([look.u(name) ** -2 for look in looks]) for name in NONLINEARITIES]
    values = [np.array([look.value(name) for look in looks]) for name in NONLINEARITIES]
    sizes = [abs(float(w @ v)) / float(w.sum()) ** 0.5 for w, v in zip(weights, values, strict=True) if looks]
    return max(sizes, default=0.0) > _SIGNIFICANT


def _solved(task: _Task, start: RowTimingFit | None, *, is_searched: bool) -> tuple[Solution, Timing]:
    """The solution, and which numbers it holds: a window of which the frames say less than the recording.

    With a window held as stated, or found without a statement, the frames' own uncertainty of it decides; an earlier fit has
    decided already.
    """
    if start is not None:
        return _solved_from(task, start, is_searched=is_searched)
    found = row_timing.solve(task.data, task.model, signs=task.signs, held=task.stated)
    if _WINDOW not in task.model.names:
        return found, {}
    window_s = abs(found.timing[_WINDOW])
    u_s = row_timing.uncertainty(task.data, task.model, timing=found.timing, name=_WINDOW)
    held = {_WINDOW: window_s} if u_s > _UNDETERMINED * window_s else {}
    again = row_timing.solve(task.data, task.model, start={**found.timing, _WINDOW: window_s}, held=held)
    return replace(again, began=found.began, n_steps=found.n_steps + again.n_steps), held


def _solved_from(task: _Task, start: RowTimingFit, *, is_searched: bool) -> tuple[Solution, Timing]:
    """The same from an earlier fit on, whose decision stays unless its window has become shorter than any that frames tell."""
    whole = completed(start.timing)
    begin = {name: whole[name] for name in task.model.names}
    found = row_timing.solve(
        task.data, task.model, start=begin, signs=task.signs, held=start.held, is_searched=is_searched
    )
    shortest_s = _shortest_s(task, found) if _WINDOW in found.minimum.free else 0.0
    if abs(found.timing.get(_WINDOW, 0.0)) >= shortest_s:
        return found, start.held
    held = {**start.held, _WINDOW: shortest_s}
    again = row_timing.solve(task.data, task.model, start={**found.timing, **held}, held=held)
    return replace(again, rival=found.rival, n_steps=found.n_steps + again.n_steps), held


def _shortest_s(task: _Task, found: Solution) -> float:
    """Length of the window that is as long as its own uncertainty by the frames, s: what it does goes as its square."""
    at_s = max(abs(found.timing[_WINDOW]), _RESOLVED * TURN / task.model.angular_frequency_rad_per_s)
    u_s = row_timing.uncertainty(task.data, task.model, timing={**found.timing, _WINDOW: at_s}, name=_WINDOW)
    return math.sqrt(at_s * u_s) if math.isfinite(u_s) else at_s


def likelihood(
    rows: ReducedRecording, wheel: WheelModel, *, light: RowLight, before: RowTimingFit | None = None
) -> Callable[[Timing], Linearised]:
    """How well any numbers fit one recording, as few residuals with derivatives in the order of the model's names.

    Parameters as for `fit`; ``before`` is the fit that tells which recursion and which sway the frames are rid of.
    """
    task = _task(rows, wheel, light, before=before)
    return lambda timing: row_timing.likelihood(task.data, task.model, timing=timing)


def to_undo(start: RowTimingFit | None) -> float:
    """Share of a recursive filter that an earlier fit has found beyond doubt, or holds; 0 without one.

    Parameters
    ----------
    start
        The earlier fit.
    """
    name = in_camera_filter.PARAMETER
    if start is None or name not in start.estimate:
        return 0.0 if start is None else start.held.get(name, 0.0)
    return max(start.estimate.value(name), 0.0) if _is_beyond_doubt(start, name) else 0.0


def _to_take_out(start: RowTimingFit | None, rows: ReducedRecording, *, light: RowLight) -> RowTimingFit | None:
    """The earlier fit with the filter that it found; and with how levels sway, once it has undone what filter there is.

    Where one blade is warmer, what it shows beside the opening becomes a number of its own.
    """
    if start is None:
        return None
    undone, sway = to_undo(start), start.sway
    if (undone > 0) == (start.undone > 0):
        per_light = rows.opening.n_summed(light.row_px) / light.harmonics[:, 0].real
        pixels = np.interp(start.row_px, light.row_px, per_light)  # lit rows may have changed
        sway = row_sway.chosen(start, trigger_ticks=rows.trigger_ticks, segment=rows.segment, pixels=pixels)
    apart = start.blades_apart or _is_beyond_doubt(start, BLADE)
    return replace(start, undone=undone, sway=sway, blades_apart=apart)


def _is_beyond_doubt(fit: RowTimingFit, name: str) -> bool:
    return name in fit.estimate and abs(fit.estimate.value(name)) > _SIGNIFICANT * fit.estimate.u(name)


def _task(rows: ReducedRecording, wheel: WheelModel, light: RowLight, *, before: RowTimingFit | None) -> _Task:
    undone = 0.0 if before is None else before.undone
    angle = wheel_angle_rad(0.0, rows.track, at_ticks=rows.trigger_ticks, set_s=rows.trigger_delay_time_set_s)
    sums = rows.row_sums.row_sum_dn[:, light.is_lit]
    kept = np.ones(angle.size, bool)
    if undone:
        kept = frame_steps.follows(rows)
        angle, sums = angle[kept], in_camera_filter.undone(sums, undone, follows=kept)
    segment = rows.segment[kept]
    stretches = [np.asarray(segment == number) for number in np.unique(segment)]
    model = RowSum(
        camera=camera(rows.camera_type, rows.readout_mode),
        open_harmonics=wheel_harmonics.open_harmonics(wheel, light.harmonics.shape[1] - 1),
        row_harmonics=light.harmonics,
        beside_harmonics=light.beside,
        blades_apart=before is not None and before.blades_apart,
        powers=light.powers if before is not None and before.is_bent else None,
        row_px=light.row_px.astype(float),
        angular_frequency_rad_per_s=rows.track.angular_frequency_rad_per_s,
        step_rad=frame_steps.step_rad(rows),
        undone=undone,
    )
    sway = None if before is None else before.sway
    pixels = rows.opening.n_summed(light.row_px)  # the wheel before them or not: an offset that sways is in all
    if before is not None and sway is not None:
        waves = harmonic_data.basis(angle, n_harmonics=model.n_harmonics)
        expected = (packed(row_sum.harmonics(model, before.timing)) @ waves).T
        sums = row_sway.steadied(sums, expected, sway=sway.of(kept), pixels=pixels, stretches=stretches)
    window_s = rows.integration_time_s if _WINDOW in model.names else None
    return _Task(
        kept=kept,
        sway=sway,
        angle=angle,
        sums=sums,
        stretches=stretches,
        data=[harmonic_data.compress(angle[part], sums[part], n_harmonics=model.n_harmonics) for part in stretches],
        model=model,
        pixels=pixels,
        stated={} if window_s is None else {_WINDOW: window_s},
        signs=(-1 if rows.opening.blackbody_is_colder else 1,),
    )


def _residuals(task: _Task, found: Solution, model: Array) -> tuple[Array, Array]:
    """Residual in DN and row sums over gain and offset, each of shape (n, n_row)."""
    residual, fraction = np.empty_like(task.sums), np.empty_like(task.sums)
    for part, gain in zip(task.stretches, found.gain, strict=True):
        expected = model[part]
        level = task.sums[part].mean(axis=0) - gain * expected.mean(axis=0)
        residual[part] = task.sums[part] - level - gain * expected
        fraction[part] = expected + residual[part] / gain
    return residual, fraction


def _linearised(task: _Task, found: Solution) -> tuple[ComplexArray, ComplexArray]:
    """The rows' harmonics (n_row, M + 1) and their derivatives to the numbers that were fitted, (k, n_row, M + 1), per unit."""
    whole, slopes = row_sum.linearised(task.model, found.timing)
    return whole, slopes[[task.model.names.index(name) for name in found.minimum.free]]


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Swaying:
    """What a sway does to the rows over their gain: by its amounts, (k, n, n_row), and in each row for itself, (n, n_row)."""

    shared: Array
    own: Array


def _swaying(task: _Task, model: Array) -> _Swaying:
    if task.sway is None:
        return _Swaying(shared=np.zeros((0, *model.shape)), own=np.zeros(model.shape))
    sway = task.sway.of(task.kept)
    own = row_sway.own_columns(sway, model, stretches=task.stretches)
    shared = row_sway.columns(sway, model, pixels=task.pixels, stretches=task.stretches)
    return _Swaying(shared=row_sway.beside_own(own, shared, stretches=task.stretches), own=own)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Scores:
    """Scores of the frames: ``timing`` (n, k) is the gradient of the log-likelihood that each contributes.

    ``information`` (n, k, k) are the normal equations that each contributes, ``normal`` (k, k) those of all; what the amounts of
    a sway can take over is left out. ``sway_step`` (j,) takes those to their best, with ``sway_covariance`` (j, j).
    """

    timing: Array
    information: Array
    normal: Array
    sway_step: Array
    sway_covariance: Array


def _scores(task: _Task, found: Solution, *, residual: Array, waves: Array, swaying: _Swaying) -> _Scores:
    """Gain and offset of the rows are projected out, and what a sway does to each row for itself."""
    shape, slopes = (packed(one) for one in _linearised(task, found))
    n_all = len(slopes) + len(swaying.shared)
    scores, information = np.zeros((len(residual), n_all)), np.zeros((len(residual), n_all, n_all))
    normal = found.normal.copy()
    for part, data, gain in zip(task.stretches, task.data, found.gain, strict=True):
        frames, per_noise = np.flatnonzero(part), gain / np.sqrt(found.variance)
        through = shape @ data.gram
        along = np.einsum("yp,kyp->ky", through, slopes) / np.einsum("yp,yp->y", through, shape)
        free = slopes - along[:, :, None] * shape
        free[:, :, 0] -= free @ waves[:, frames].mean(axis=1)
        taken = np.einsum("kyp,py->ky", free, waves[:, frames] @ swaying.own[frames])
        normal -= (taken * per_noise**2) @ taken.T
        for block in np.split(frames, range(_BLOCK, frames.size, _BLOCK)):
            own_waves = waves[:, block].astype(np.float32)  # seven digits are plenty for a covariance
            light = free.astype(np.float32) @ own_waves - taken[:, :, None] * swaying.own[block].T
            both = np.concatenate([light, swaying.shared[:, block].transpose(0, 2, 1)]) * per_noise[:, None]
            by_frame = both.transpose(2, 0, 1)
            scores[block] = np.einsum("nky,ny->nk", by_frame, residual[block] / np.sqrt(found.variance))
            information[block] = by_frame @ by_frame.transpose(0, 2, 1)
    return _without_sway(scores, information, normal=normal)


def _without_sway(scores: Array, information: Array, *, normal: Array) -> _Scores:
    """Timing and sway together by least squares, each free of the other.

    Both are in the ``scores`` (n, k + j) and the ``information`` (n, k + j, k + j) of the frames, timing first; ``normal`` (k, k)
    is that of the timing.
    """
    k, whole = len(normal), information.sum(axis=0)
    mixed, own, gradient = whole[:k, k:], whole[k:, k:], scores.sum(axis=0)
    taken = mixed @ generalised_inverse(own, flat=_RANK)
    free = np.hstack([np.eye(k), -taken])
    of_timing = np.linalg.solve(normal, mixed)
    left = own - mixed.T @ of_timing
    says = np.diag(own) > 0  # a number that moves nothing is known to be none
    scale = np.sqrt(np.where(says, np.diag(own), 1.0))
    sizes, axes = np.linalg.eigh(left / np.outer(scale, scale))
    axes = axes * (says / scale)[:, None]
    covariance = (axes / np.maximum(sizes, _RANK * np.max(sizes, initial=_NONE))) @ axes.T
    return _Scores(
        timing=scores @ free.T,
        information=free @ information @ free.T,
        normal=normal - taken @ mixed.T,
        sway_step=covariance @ (gradient[k:] - of_timing.T @ gradient[:k]),
        sway_covariance=covariance,
    )


def _shape_effect(task: _Task, found: Solution, changes: ComplexArray) -> Array:
    """Change of the fitted numbers per unit of each number of the sector, shape (k, n_shape): one linear step of the fit."""
    (whole, slopes), light = _linearised(task, found), task.model.row_harmonics
    moved = packed(changes * (whole / np.where(light == 0, 1, light)))
    shape, slope = packed(whole), packed(slopes)
    mixed = np.zeros((len(slope), len(changes)))
    for data, gain in zip(task.data, found.gain, strict=True):
        through = slope @ data.gram
        along = np.einsum("kyp,yp->ky", through, shape)
        beside = shape @ data.gram
        norm = np.einsum("yp,yp->y", beside, shape)
        off = np.einsum("syp,yp->sy", moved, beside)
        both = through.transpose(1, 0, 2) @ moved.transpose(1, 2, 0)
        mixed -= np.tensordot(gain**2 / found.variance, both, 1) - (along / norm * gain**2 / found.variance) @ off.T
    return np.asarray(np.linalg.solve(found.normal, mixed), dtype=float)
