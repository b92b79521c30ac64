r"""One likelihood over the row sums of all recordings of a rolling camera: its minimum, and how it rises around it.

The six numbers x_f of each recording (`estimate.row_timing`) follow from what all recordings share:

    x_f = M_f b + a / omega_f + E_f s

b are delay, row delay and tau of the camera (`rolling_timing.structure`), a the errors of the four edges' angles (mask, gates,
register, cutout edges), s those of the opening's shape in the image, whose effect E_f each fit knows. With P and S their
covariances the deviance is

    D = sum_f D_f(x_f) / factor_f  +  a^T P^-1 a  +  s^T S^-1 s

Generalised least squares (`rolling_timing.estimate`) takes each D_f for a parabola. Here it is what it is: Newton's steps begin
at one recording's own numbers, a parameter is held and all others find their best. That shows how far the covariance can be
trusted, and that the estimate left its start.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import profile_of, rig_wide, whiteness
from irtiming.estimate.rolling_timing import NAMES, Structure, structure
from irtiming.inference.optimiser import Linearised
from irtiming.physics.camera import camera
from irtiming.physics.light import row_sum
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.estimate import Estimate
from irtiming.records.joint_fit import Profile
from irtiming.records.row_timing import RowLikelihood, RowTimingFit, SectorFit
from irtiming.records.wheel_geometry import WheelGeometry

_NAMES = row_sum.timing_names(camera("microbolometer", "rolling"))
_MOST_STEPS = 20
_SETTLED = 0.02  # standard uncertainties
_NEVER_EXACT = 1e-18  # rad^2 on the diagonal of P, where an angle is taken as exact

Likelihood = Callable[[Mapping[str, float]], Linearised]
"""Of one recording, over its six numbers by name."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """Likelihood of each recording over numbers that all share.

    ``maps`` (n_fit, 6, k + m) makes each recording's six numbers from k numbers of the camera and m errors, each with a
    standard uncertainty of 1. ``mix`` (3, k + m) makes the three numbers reported. ``factor`` (n_fit,) divides the deviances.
    """

    likelihoods: tuple[Likelihood, ...]
    maps: Array
    mix: Array
    factor: Array
    n_errors: int


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Minimum:
    """Shared numbers (k + m,), deviance and half its curvature (k + m, k + m) there, and the steps to it."""

    shared: Array
    deviance: float
    normal: Array
    n_steps: int


def estimate(
    likelihoods: Sequence[Likelihood], fits: Sequence[RowTimingFit], *, geometry: WheelGeometry,
    sectors: Sequence[SectorFit], told: Estimate,
) -> RowLikelihood:  # fmt: skip
    """Minimum and profiles.

    Parameters
    ----------
    likelihoods, fits, sectors
        In the same order, one per recording.
    geometry
        Uncertainties of the angles.
    told
        What is reported, from generalised least squares.

    Raises
    ------
    EstimationError
        If no minimum is reached.
    """
    given = problem(likelihoods, fits, geometry=geometry, sectors=sectors)
    start = begin(given, fits)
    found = minimum(given, start)
    rows = {name: given.mix[k] for k, name in enumerate(NAMES)}
    return RowLikelihood(
        values=given.mix @ found.shared,
        start=given.mix @ start,
        n_steps=found.n_steps,
        whiteness=np.array([_whiteness(fit) for fit in fits]),
        profiles=tuple(
            _profile(given, found, name=name, row=rows[name], u=float(u))
            for name, u in zip(told.names, told.standard_uncertainties, strict=True)
        ),
    )


def problem(
    likelihoods: Sequence[Likelihood], fits: Sequence[RowTimingFit], *, geometry: WheelGeometry,
    sectors: Sequence[SectorFit],
) -> Problem:  # fmt: skip
    """The shared numbers and what each recording makes of them; parameters as for `estimate`."""
    made: Structure = structure(fits, geometry, sectors=sectors)
    u_edge = rig_wide.edge_uncertainty(fits, geometry)
    common = sum(u**2 for _, _, u in geometry.angle_budget)
    angles = np.linalg.cholesky((u_edge**2 + _NEVER_EXACT) * np.eye(4) + common)
    different = list({id(sector): sector for sector in sectors}.values())
    maps = []
    for design, fit, own in zip(made.design, fits, sectors, strict=True):
        turned = np.vstack([angles / fit.angular_frequency_rad_per_s, np.zeros((2, 4))])
        shapes = [fit.shape_effect @ _root(one.covariance) * (one is own) for one in different]
        maps.append(np.hstack([design, turned, *shapes]))
    n_errors = maps[0].shape[1] - made.design.shape[2]
    return Problem(
        likelihoods=tuple(likelihoods),
        maps=np.array(maps),
        mix=np.hstack([made.mix, np.zeros((3, n_errors))]),
        factor=made.factor,
        n_errors=n_errors,
    )


def begin(given: Problem, fits: Sequence[RowTimingFit]) -> Array:
    """The numbers of the recording that was read earliest, and no errors: where the search begins; shape (k + m,)."""
    first = min(fits, key=lambda fit: float(fit.edge_delay_s.mean()))
    n_own = given.maps.shape[2] - given.n_errors
    six = np.array([*[float(first.edge_delay_s.mean())] * 4, *first.estimate.values[4:]])
    every = np.concatenate([one[:, :n_own] for one in given.maps])
    own, *_ = np.linalg.lstsq(every, np.tile(six, len(given.maps)), rcond=None)
    return np.append(own, np.zeros(given.n_errors))


def minimum(given: Problem, start: Array, *, held: Array | None = None) -> Minimum:
    """Least deviance, reached by Newton's steps.

    Parameters
    ----------
    given
        All recordings.
    start
        Shape (k + m,).
    held
        Shape (k + m,); the sum of shared numbers with these weights keeps its value. None holds nothing.

    Raises
    ------
    EstimationError
        If no minimum is reached.
    """
    shared = np.array(start, float)
    for step in range(1, _MOST_STEPS + 1):
        deviance, gradient, normal = _at(given, shared)
        scale = 1 / np.sqrt(np.diag(normal))
        square = normal * np.outer(scale, scale)
        if held is None:
            move = scale * np.linalg.solve(square, scale * gradient)
        else:
            along = np.linalg.solve(square, np.stack([scale * gradient, scale * held], axis=1))
            free = along[:, 0] - along[:, 1] * float(scale * held @ along[:, 0]) / float(scale * held @ along[:, 1])
            move = scale * free
        if float(move @ normal @ move) < _SETTLED**2:
            return Minimum(shared=shared, deviance=deviance, normal=normal, n_steps=step)
        shared = shared + move
    raise EstimationError(
        f"the likelihood of all {len(given.maps)} recordings together did not settle in {_MOST_STEPS} steps; they must be of one "
        "camera on one rig: analyse them apart to see which differs"
    )


def _at(given: Problem, shared: Array) -> tuple[float, Array, Array]:
    n = shared.size
    errors = np.append(np.zeros(n - given.n_errors), np.ones(given.n_errors))
    deviance = float(np.sum(errors * shared**2))
    gradient, normal = -errors * shared, np.diag(errors)
    for likelihood, own, factor in zip(given.likelihoods, given.maps, given.factor, strict=True):
        at = likelihood(dict(zip(_NAMES, own @ shared, strict=True)))
        deviance += at.deviance / factor
        gradient = gradient + own.T @ at.gradient / factor
        normal = normal + own.T @ at.normal @ own / factor
    return deviance, gradient, normal


def _profile(given: Problem, found: Minimum, *, name: str, row: Array, u: float) -> Profile:
    value = float(row @ found.shared)
    covariance = np.linalg.inv(found.normal)
    along = covariance @ row / float(row @ covariance @ row)  # how all others follow

    def lost(tried: float) -> float:
        try:
            return minimum(given, found.shared + along * (tried - value), held=row).deviance - found.deviance
        except EstimationError:  # so far away that no fit settles
            return float("nan")

    return profile_of.profile(name, value=value, u=u, lost=lost)


def _root(covariance: Array) -> Array:
    """A matrix whose product with its transpose is this, which may be singular."""
    sizes, axes = np.linalg.eigh(covariance)
    return np.asarray(axes * np.sqrt(np.maximum(sizes, 0.0)))


def _whiteness(fit: RowTimingFit) -> float:
    """Of the frames' mean residuals, each row in units of its noise, along the wheel angle."""
    mean = np.mean(fit.residual / fit.noise, axis=1)
    return whiteness.probability(mean[np.argsort(np.mod(fit.wheel_angle_rad, TURN))])
