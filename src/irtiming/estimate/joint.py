r"""One likelihood over all recordings of a camera on a rig, whatever the camera: its minimum, and what follows from it.

Every recording f tells some local numbers x_f: one delay per wheel edge, and what the camera's response, its readout and the
light that is summed have (`estimate.pixel_sums`, `estimate.row_fit`). They follow from the shared numbers p
(`estimate.shared_numbers`): delay, response and row delay of the camera, and every error of the rig and of the images that is
known to some uncertainty,

.. math:: x_f = A_f p, \qquad D(p) = \sum_f D_f(A_f p) + \sum_k (p_k - p_{k0})^2 / u_k^2

An angle acts as a time in proportion to 1 / omega, so several speeds distinguish it from a delay; at one speed its prior decides,
and its uncertainty goes into that of the delay. A further nuisance parameter is one more shared number.

At the minimum all is linear algebra with the recordings' pieces of information (`inference.information`). The delay of falling or
rising slopes alone comes from the same pieces after the delays of the other two edges may be anything in each recording.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.estimate.shared_numbers import DELAY, SharedNumber, design
from irtiming.estimate.shared_residual import Trace, TraceModel
from irtiming.inference import optimiser
from irtiming.inference.information import NOISE, Combined, Information, Weights, combine, prior
from irtiming.inference.optimiser import Linearised, Minimum, Model
from irtiming.physics.covariance import inverse
from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class LocalModel:
    """What one recording says of its local numbers ``names``: residuals over the noise, with derivatives.

    ``trace`` is the same along the wheel angle, of recordings with one value per frame.
    """

    names: tuple[str, ...]
    at: Model
    trace: TraceModel | None = None

    def inflated(self, factor: float) -> "LocalModel":
        """The same with variances that many times larger."""
        spread = float(np.sqrt(factor))

        def at(numbers: Mapping[str, float]) -> Linearised:
            there = self.at(numbers)
            return Linearised(residual=there.residual / spread, jacobian=there.jacobian / spread)

        def trace(numbers: Mapping[str, float]) -> Trace:
            assert self.trace is not None
            there = self.trace(numbers)
            return replace(there, residual=there.residual / spread)

        return LocalModel(names=self.names, at=at, trace=None if self.trace is None else trace)


def parabola(estimate: Estimate) -> LocalModel:
    """A recording that is described by the estimate of its local numbers: residuals are how far numbers are from it.

    Parameters
    ----------
    estimate
        Local numbers with their covariance.
    """
    scale = np.sqrt(np.diag(estimate.covariance))
    root = np.linalg.cholesky(inverse(estimate.covariance) * np.outer(scale, scale)).T / scale

    def at(numbers: Mapping[str, float]) -> Linearised:
        values = np.array([numbers[name] for name in estimate.names])
        return Linearised(residual=root @ (values - estimate.values), jacobian=root)

    return LocalModel(names=estimate.names, at=at)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Measurand:
    """A weighted sum of shared numbers plus ``offset``; wheel edges in ``forgotten`` say nothing of the delay."""

    name: str
    weights: Weights
    offset: float = 0.0
    unit: str = "s"
    forgotten: tuple[str, ...] = ()


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Joint:
    """The minimum, and the pieces of information there.

    Parameters
    ----------
    models, shared
        Recordings and shared numbers that were fitted.
    found
        The search; values of the shared numbers.
    pieces
        What each recording says of its local numbers at the minimum.
    priors
        What is known beforehand of shared numbers.
    """

    models: tuple[LocalModel, ...]
    shared: tuple[SharedNumber, ...]
    found: Minimum
    pieces: tuple[Information, ...]
    priors: tuple[Information, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the shared numbers."""
        return tuple(number.name for number in self.shared)

    @property
    def values(self) -> Array:
        """Of the shared numbers at the minimum, shape (n,)."""
        return np.array(list(self.found.values.values()))

    def designs(self) -> tuple[Array, ...]:
        """What makes each recording's local numbers of the shared ones, shapes (k, n)."""
        return tuple(design(self.shared, k, names=model.names) for k, model in enumerate(self.models))

    def combined(self, forgotten: tuple[str, ...] = ()) -> Combined:
        """All pieces and priors over the shared numbers, with some local numbers forgotten."""
        pieces = [
            piece.without(*forgotten).of(self.names, made)
            for piece, made in zip(self.pieces, self.designs(), strict=True)
        ]
        return combine([*pieces, *self.priors])

    def estimate(self, measurands: Sequence[Measurand]) -> Estimate:
        """Values and one covariance of all, to first order in every error.

        Parameters
        ----------
        measurands
            Sums of shared numbers.
        """
        rows, values = [], []
        for one in measurands:
            whole = self.combined(one.forgotten)
            weights = whole.row(one.weights)
            rows.append((weights @ whole.covariance, one.forgotten))
            values.append(one.offset + float(weights @ (self.values + whole.step)))
        covariance = np.zeros((len(rows), len(rows)))
        for piece, made in zip(self.pieces, self.designs(), strict=True):
            follows = np.array([row @ made.T @ piece.forgetting(*forgotten) for row, forgotten in rows])
            covariance += follows @ piece.matrix @ follows.T
        for known in self.priors:
            follows = np.array([row[[self.names.index(name) for name in known.names]] for row, _ in rows])
            covariance += follows @ known.matrix @ follows.T
        return Estimate(
            names=tuple(one.name for one in measurands),
            units=tuple(one.unit for one in measurands),
            values=np.array(values),
            covariance=covariance,
        )


def fit(models: Sequence[LocalModel], shared: Sequence[SharedNumber]) -> Joint:
    """The lowest minimum.

    Parameters
    ----------
    models
        One per recording.
    shared
        Numbers that the local ones are made of; the search begins at their start, and again at each of their ``other_starts``.
        One that ``may_be_mirrored`` has a minimum on either side of zero, and both are tried.

    Raises
    ------
    EstimationError
        If the recordings give no finite residuals at the start.
    """
    start, at = {number.name: number.start for number in shared}, residuals(models, shared)
    best = optimiser.minimise(at, start=start)
    for number in shared:
        begins = [start | {number.name: value} for value in number.other_starts]
        if number.may_be_mirrored:
            begins.append(best.values | {number.name: -best.values[number.name]})
        for begin in begins:
            other = optimiser.minimise(at, start=begin)
            if other.at.deviance < best.at.deviance:
                best = replace(other, start=start, n_steps=best.n_steps + other.n_steps)
    return at_point(models, shared, found=best)


def at_point(models: Sequence[LocalModel], shared: Sequence[SharedNumber], *, found: Minimum) -> Joint:
    """The pieces of information where a search ended."""
    pieces = []
    for k, model in enumerate(models):
        local = design(shared, k, names=model.names) @ np.array(list(found.values.values()))
        there = model.at(dict(zip(model.names, local.tolist(), strict=True)))
        pieces.append(Information(source=NOISE, names=model.names, matrix=there.normal, gradient=there.gradient))
    priors = tuple(
        prior(one.name, one.u, source=one.source, kind=one.kind, gap=one.known - found.values[one.name])
        for one in shared
        if one.u is not None
    )
    return Joint(models=tuple(models), shared=tuple(shared), found=found, pieces=tuple(pieces), priors=priors)


def traces(joint: Joint) -> tuple[Trace, ...]:
    """Residuals of every recording along the wheel angle at the minimum; none where one has no trace.

    Parameters
    ----------
    joint
        The joint fit.
    """
    pieces = [
        model.trace(dict(zip(model.names, (made @ joint.values).tolist(), strict=True)))
        for model, made in zip(joint.models, joint.designs(), strict=True)
        if model.trace is not None
    ]
    return tuple(pieces) if len(pieces) == len(joint.models) else ()


def residuals(models: Sequence[LocalModel], shared: Sequence[SharedNumber]) -> Model:
    """Residuals of all recordings, then of all numbers that are known beforehand, over the shared numbers.

    Parameters
    ----------
    models, shared
        As for `fit`.
    """
    made = [design(shared, k, names=model.names) for k, model in enumerate(models)]
    known = [(k, one) for k, one in enumerate(shared) if one.u is not None]
    prior_slopes = np.array([np.eye(len(shared))[k] / float(one.u or 1.0) for k, one in known]).reshape(-1, len(shared))

    def at(numbers: Mapping[str, float]) -> Linearised:
        values = np.array(list(numbers.values()))
        there = [
            model.at(dict(zip(model.names, (local @ values).tolist(), strict=True)))
            for model, local in zip(models, made, strict=True)
        ]
        beside = np.array([(values[k] - one.known) / float(one.u or 1.0) for k, one in known])
        return Linearised(
            residual=np.concatenate([*(one.residual for one in there), beside]),
            jacobian=np.concatenate(
                [*(one.jacobian @ local for one, local in zip(there, made, strict=True)), prior_slopes]
            ),
        )

    return at


def each_delay(joint: Joint, setting: Sequence[int]) -> tuple[Array, Array]:
    """Delay of each recording, with all else shared.

    Nothing is taken for granted of the delays that were set: recordings of one setting share a delay, which is what lets wheel
    speeds tell angles from delays; recordings of different settings do not.

    Parameters
    ----------
    joint
        The joint fit.
    setting
        Number of each recording's set delay, from 0; length n_fit.

    Returns
    -------
    Values (n_fit,), s, and covariance (n_fit, n_fit), s^2.
    """
    names, n_set = joint.names, max(setting) + 1
    others = [name for name in names if name != DELAY]
    wide = (*(f"{DELAY} of setting {k}" for k in range(n_set)), *others)
    own = [piece.of(names, made) for piece, made in zip(joint.pieces, joint.designs(), strict=True)]
    placed = [
        replace(piece, names=tuple(wide[number] if name == DELAY else name for name in names))
        for piece, number in zip(own, setting, strict=True)
    ]
    whole = combine([_all_of(wide), *placed, *joint.priors])
    at, rest = names.index(DELAY), [names.index(name) for name in others]
    alone = np.array([1 / piece.matrix[at, at] for piece in own])
    coupling = np.array([piece.matrix[at, rest] for piece in own])
    gradient = np.array([piece.gradient[at] for piece in own])
    values = joint.found.values[DELAY] + alone * (gradient - coupling @ whole.step[n_set:])
    follows = -(alone[:, None] * coupling) @ whole.covariance[n_set:]
    covariance = np.zeros((len(own), len(own)))
    for k, piece in enumerate(placed):
        maps = follows[:, [wide.index(name) for name in piece.names]]
        maps[k, at] += alone[k]
        covariance += maps @ piece.matrix @ maps.T
    for known in joint.priors:
        maps = follows[:, [wide.index(name) for name in known.names]]
        covariance += maps @ known.matrix @ maps.T
    return values, covariance


def _all_of(names: tuple[str, ...]) -> Information:
    """Nothing, of these names in this order."""
    n = len(names)
    return Information(source=NOISE, names=names, matrix=np.zeros((n, n)), gradient=np.zeros(n))


def disagreement(joint: Joint) -> float:
    """Birge ratio: root of the deviance of the recordings' delays about the common one, over its degrees of freedom."""
    each, covariance = each_delay(joint, [0] * len(joint.pieces))
    if each.size < 2:
        return 1.0
    ones = np.ones(each.size)
    through = np.linalg.solve(covariance, np.stack([ones, each], axis=1))
    mean = float(ones @ through[:, 1]) / float(ones @ through[:, 0])
    apart = each - mean
    return float(np.sqrt(apart @ np.linalg.solve(covariance, apart) / (each.size - 1)))
