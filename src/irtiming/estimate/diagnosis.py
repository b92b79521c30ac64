r"""Which cause explains structured residuals best: a score test of every one that the program can name.

With residuals r over their noise and what a cause adds c, both beside all that was fitted, its number would be
a = c'r / c'c, and taking it into the fit would gain the deviance

.. math:: (c'r)^2 / (c'c)

which is chi squared with one degree of freedom where there is nothing but noise. It would move the fitted numbers by
-a (X'X)^{-1} X'c. The noise is that of neighbours along the wheel angle, so that structure along it is not taken for noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import special

from irtiming.estimate import causes
from irtiming.estimate.causes import CANDIDATES, Candidate
from irtiming.estimate.frame_residuals import FrameResiduals, of_fit, with_residual
from irtiming.estimate.joint import Joint
from irtiming.estimate.measurands import LAG
from irtiming.estimate.timing import Timing
from irtiming.records.arrays import Array
from irtiming.records.diagnosis import Cause, Diagnosis, Fitted
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit, Estimate
from irtiming.records.finding import Finding, Severity
from irtiming.records.rig import Measured
from irtiming.records.row_timing import RowTimingFit

_SIGNIFICANCE = 1e-6
_MOVES = 1.0
_STRUCTURED, _GOOD_PART = 0.3, 0.3
"""Shares of the degrees of freedom and of the deviance beyond them from which a cause is worth naming whatever it moves."""

_NEARLY = 10.0
"""Of deviance: by so much less a cause is e^5 times as unlikely."""

_UNLIKE = 1e-3
"""A cause of which less than this share is unlike all that was fitted is taken for fitted."""

_MOST_FITTED = 8
_TIMING = (*EDGE_DELAYS, "opening_angle", "time_constant", "integration_time", "row_delay")


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Beside:
    """Residuals of all recordings over their noise, (n,), what the fitted numbers add, (n, k), and what is known of them.

    ``known`` (m, k) are rows of the numbers' priors over their uncertainties. ``parameters`` (k,) are the weights of the fitted
    numbers in each parameter of the result.
    """

    runs: tuple[FrameResiduals, ...]
    residual: Array
    fitted: Array
    known: Array
    parameters: dict[str, Array]


def diagnose(found: Timing) -> Diagnosis:
    """Every cause, and what it explains of the residuals.

    Parameters
    ----------
    found
        The fit of all recordings; numbers that it has for defects are listed with how far they are from none.
    """
    estimate = found.found.result.estimate
    beside = _of_rows(found) if found.recordings[0].pixels is None else _of_pixels(found)
    tried = [one for one in CANDIDATES if not one.of_rows or beside.runs[0].row.size > 2]
    ranked = sorted(
        (_cause(one, beside, estimate, n_tried=len(tried)) for one in tried), key=lambda one: -_surprise(one)
    )
    deviance, freedom = float(beside.residual @ beside.residual), beside.residual.size - beside.fitted.shape[1]
    return Diagnosis(
        deviance=deviance,
        degrees_of_freedom=freedom,
        causes=tuple(ranked),
        fitted=_fitted(found.found.joint, found.fits),
        findings=_findings(ranked, deviance=deviance, freedom=freedom),
    )


def _of_rows(found: Timing) -> _Beside:
    """With columns made of the model, for the likelihood of the rows is not one of frames."""
    runs = [of_fit(one, fit) for one, fit in zip(found.recordings, found.fits, strict=True)]
    lags = [
        float(fit.timing[LAG]) if isinstance(fit, RowTimingFit) and LAG in fit.timing else None for fit in found.fits
    ]
    made = [causes.fitted(one, lag_s=lag) for one, lag in zip(runs, lags, strict=True)]
    names, first = tuple(made[0]), runs[0]
    columns = [np.concatenate([_flat(one, of[name]) for one, of in zip(runs, made, strict=True)]) for name in names]
    delay = {name: 0.25 for name in names if name.startswith("edge")} | {"row delay": -first.middle_px / first.half_px}
    weights = {
        "trigger_delay": delay,
        "exposure_midpoint_delay": delay,
        "time_constant": {"time constant": 1.0},
        "row_delay": {"row delay": 1 / first.half_px},
    }
    return _Beside(
        runs=tuple(runs),
        residual=np.concatenate([_flat(one, one.residual) for one in runs]),
        fitted=np.stack(columns, axis=1),
        known=np.zeros((0, len(names))),
        parameters={
            name: np.array([of.get(column, 0.0) for column in names])
            for name, of in weights.items()
            if any(column in names for column in of)
        },
    )


def _of_pixels(found: Timing) -> _Beside:
    """With the derivatives of the joint fit itself, and with its priors."""
    joint = found.found.joint
    runs, residuals, columns = [], [], []
    for one, fit, model, design in zip(found.recordings, found.fits, joint.models, joint.designs(), strict=True):
        plain = of_fit(one, fit)
        there = model.at(dict(zip(model.names, (design @ joint.values).tolist(), strict=True)))
        scale = float(there.residual @ plain.residual[:, 0]) / max(float(there.residual @ there.residual), 1e-300)
        exact = with_residual(plain, scale * there.residual[:, None])
        runs.append(exact)
        residuals.append(scale * there.residual / exact.noise)
        columns.append(-scale * there.jacobian @ design / exact.noise[:, None])
    priors = [np.eye(len(joint.shared))[k] / one.u for k, one in enumerate(joint.shared) if one.u]
    return _Beside(
        runs=tuple(runs),
        residual=np.concatenate(residuals),
        fitted=np.concatenate(columns),
        known=np.array(priors).reshape(-1, len(joint.shared)),
        parameters={
            one.name: np.array([one.weights.get(name, 0.0) for name in joint.names])
            for one in found.found.profiled
            if not one.forgotten
        },
    )


def _flat(frames: FrameResiduals, values: Array) -> Array:
    """Values (n, n_band) over the noise, beside each band's own covered level and step, in one column."""
    left = np.empty_like(values)
    for band in range(values.shape[1]):
        own = np.stack([np.ones(len(values)), frames.fraction[:, band]], axis=1)
        left[:, band] = values[:, band] - own @ np.linalg.lstsq(own, values[:, band], rcond=None)[0]
    return (left / frames.noise).ravel()


def _cause(one: Candidate, beside: _Beside, estimate: Estimate, *, n_tried: int) -> Cause:
    made = [one.columns(frames) for frames in beside.runs]
    each = [[_flat(frames, of[k]) for frames, of in zip(beside.runs, made, strict=True)] for k in range(len(made[0]))]
    nothing = np.zeros(len(beside.known))
    columns = np.stack([np.concatenate([*parts, nothing]) for parts in each], axis=1)
    residual = np.concatenate([beside.residual, nothing])
    inside, left = _split(columns, np.concatenate([beside.fitted, beside.known]))
    own = np.linalg.norm(left, axis=0) > _UNLIKE * np.linalg.norm(columns, axis=0)
    left, inside, columns = left[:, own], inside[:, own], columns[:, own]
    if not own.any():
        return Cause(name=one.name, gained=0.0, n_numbers=0, chance=1.0, size=0.0, moves={}, cure=one.cure)
    scale = np.linalg.norm(left, axis=0)
    number, _, rank, _ = np.linalg.lstsq(left / scale, residual, rcond=_UNLIKE)
    number = number / scale
    gained, n_numbers = float(np.sum((left @ number) ** 2)), int(rank)
    noise = np.concatenate([np.broadcast_to(frames.noise, frames.residual.shape).ravel() for frames in beside.runs])
    moved = -inside @ number
    return Cause(
        name=one.name,
        gained=gained,
        n_numbers=n_numbers,
        chance=min(1.0, n_tried * float(special.chdtrc(n_numbers, max(0.0, gained)))) if n_numbers else 1.0,
        size=float(np.sqrt(np.mean(((columns @ number)[: noise.size] * noise) ** 2))),
        moves={
            name: float(weights @ moved) / estimate.u(name)
            for name, weights in beside.parameters.items()
            if name in estimate and estimate.u(name) > 0
        },
        cure=one.cure,
    )


def _split(columns: Array, fitted: Array) -> tuple[Array, Array]:
    """Columns as sums of the fitted ones, shape (k, n_column), and what is left of them."""
    unit = np.linalg.norm(fitted, axis=0)
    unit[unit == 0] = 1.0
    inside = np.linalg.lstsq(fitted / unit, columns, rcond=1e-9)[0] / unit[:, None]
    return inside, columns - fitted @ inside


def _surprise(one: Cause) -> float:
    """Deviance beyond what its numbers gain by chance, in standard deviations of that."""
    return (one.gained - one.n_numbers) / max(2 * one.n_numbers, 1) ** 0.5


def _fitted(joint: Joint, fits: Sequence[EdgeDelayFit | RowTimingFit]) -> tuple[Fitted, ...]:
    """Numbers that stand for a defect, the clearest first: errors known beforehand, and what recordings have of their own."""
    covariance = joint.combined().covariance
    found = []
    for k, one in enumerate(joint.shared):
        if one.u is None:
            continue
        value, u = float(joint.values[k]) - one.known, float(np.sqrt(max(covariance[k, k], 1e-300)))
        found.append(
            Fitted(
                name=one.name, value=Measured(value, u), unit=one.unit, from_none=value / one.u, gained=(value / u) ** 2
            )
        )
    for fit in fits:
        found += _own(fit)
    found.sort(key=lambda one: -abs(one.from_none))
    return tuple(found[:_MOST_FITTED])


def _own(fit: EdgeDelayFit | RowTimingFit) -> list[Fitted]:
    found = []
    if isinstance(fit, EdgeDelayFit) and fit.u_blades > 0:
        z = fit.blades / fit.u_blades
        name = f"{fit.name}: second blade above the first"
        found.append(Fitted(name=name, value=Measured(fit.blades, fit.u_blades), unit="1", from_none=z, gained=z * z))
    for name, unit in zip(fit.estimate.names, fit.estimate.units, strict=True):
        if name not in _TIMING and (u := fit.estimate.u(name)) > 0:
            z = fit.estimate.value(name) / u
            value = Measured(fit.estimate.value(name), u)
            found.append(Fitted(name=f"{fit.name}: {name}", value=value, unit=unit, from_none=z, gained=z * z))
    return found


def _findings(found: Sequence[Cause], *, deviance: float, freedom: int) -> tuple[Finding, ...]:
    """The likeliest cause, and what explains nearly as much, where it is no chance.

    It is named where one of them would move the result, or where residuals are far above their noise and it explains a good part.
    """
    first, excess = found[0], deviance - freedom
    if first.chance > _SIGNIFICANCE:
        return ()
    nearly = [one for one in found[1:] if _surplus(one) > _surplus(first) - _NEARLY and one.chance <= _SIGNIFICANCE]
    moves = [(abs(size), size, name) for one in (first, *nearly) for name, size in one.moves.items()]
    largest, size, name = max(moves, default=(0.0, 0.0, ""))
    is_plain = excess > _STRUCTURED * freedom and first.gained > _GOOD_PART * excess
    if largest < _MOVES and not is_plain:
        return ()
    others = f", or nearly as well that {' or that '.join(one.name for one in nearly)}" if nearly else ""
    outcome = f": that would move {name} by {size:+.1f} u" if name else ""
    what = (
        f"the residuals are structured; what explains most of them is that {first.name} (deviance {first.gained:.0f} of "
        f"{max(excess, first.gained):.0f} too much){others}{outcome}"
    )
    severity: Severity = "warning" if largest < _MOVES else "doubt"
    return (Finding(code="likeliest-cause", severity=severity, what=what, cure=first.cure),)


def _surplus(one: Cause) -> float:
    """Deviance beyond what its numbers gain by chance."""
    return one.gained - one.n_numbers
