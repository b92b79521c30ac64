r"""One likelihood over the pixel sums of all recordings (eq. 1), of whatever set delays, wheel speeds and runs.

Shared by all: the delay t of the window's middle, the angles a_0..a_3 by which the wheel's edges come earlier than rig.toml
says, the opening angle, the length of the window, and by how much the mask's edges miss the axle. Each recording's own:
covered level, step, drift, skew and plate. The deviance is

    D = sum_f |r_f|^2 / noise_f^2 + a^T P^-1 a + |lean - lean seen|^2 / u_lean^2

with P the covariance of all that shifts an edge's angle: mask, gates, register, cutout edges, and what the residuals of all
recordings share. An angle acts as a time in proportion to 1 / omega, so several wheel speeds tell it from a delay; at one
speed P decides, and its uncertainty goes into that of the delay.

Gauss and Newton's steps with analytic derivatives; each recording's own numbers are eliminated from its normal matrix (the
Schur complement), which leaves nine by nine numbers per recording however many frames it has.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.estimate import pixel_sum_model as model_of
from irtiming.estimate.pixel_sum_model import PixelSums
from irtiming.physics.covariance import inverse
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.reduced import ReducedRecording
from irtiming.records.wheel_geometry import WheelGeometry

T_MIDDLE, EDGES, OPENING, WINDOW, LEANS = 0, slice(1, 5), 5, 6, (7, 8)
"""Places of the shared numbers."""

_OWN, _SHARED = [1, 2, 3, 4, 5], [0, 6, 7, 8, 9, 10, 11, 12, 13]
_MOST_STEPS = 40
_SETTLED, _WINDOW_SETTLED = 0.01, 0.1  # standard uncertainties; few frames see the corners, so its curvature has steps
_ROUNDING = 1e-7  # of the deviance
_LEAST_DAMPING = 0.1  # holds back what is known badly, where the model bends, and nothing that is known well
_LEVEL = (
    0.3  # of the deviance: what a step that gains less leaves is a fraction of an uncertainty, and in the shape alone
)
_PATIENCE = 3  # such steps in a row
_UNKNOWN_WINDOW_S = 0.1  # standard uncertainty of a window that no frame tells anything of
_LEAST_U_LEAN_RAD = 1e-5


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """All recordings with their weights; ``noise`` (n_fit,) in units of each one's guessed step.

    ``prior_rad2`` is P; ``own`` (n_fit, 5 + k) are the numbers that each recording has for itself, where the search begins: the
    last k are shifts of ``own_edges``, whose slopes then say nothing about the delay.
    ``leans_rad`` (2,) is how the images show the mask's edges to lean, ``u_lean_rad`` its standard uncertainty.
    """

    parts: tuple[PixelSums, ...]
    noise: Array
    own: Array
    prior_rad2: Array
    leans_rad: Array
    u_lean_rad: float
    own_edges: tuple[int, ...] = ()

    def without(self, edges: tuple[int, ...], own: Array) -> "Problem":
        """The same where some edges are each recording's own, beginning at these numbers of each recording."""
        return replace(self, own=np.hstack([own, np.zeros((len(own), len(edges)))]), own_edges=edges)

    def values(self, shared: Array, own: Array) -> Array:
        """What the model takes for one recording, in the order of `pixel_sum_model.NAMES`."""
        values = np.array([shared[T_MIDDLE], *own[:5], *shared[1:]])
        values[[6 + edge for edge in self.own_edges]] += own[5:]
        return values

    def image(self, shared: Array) -> tuple[Array, Array]:
        """What the images say: information (9, 9) and gradient (9,)."""
        information, pull = np.zeros((9, 9)), np.zeros(9)
        information[WINDOW, WINDOW] = _UNKNOWN_WINDOW_S**-2
        information[LEANS, LEANS] = self.u_lean_rad**-2
        pull[LEANS,] = (self.leans_rad - shared[LEANS,]) / self.u_lean_rad**2
        return information, pull


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """Minimum of the deviance.

    Shapes: ``shared`` (9,), ``own`` (n_fit, 5 + k), ``information`` (n_fit, 9, 9) and ``pull`` (n_fit, 9) as in
    `records.joint_fit.JointFit`, ``start`` (9,). ``is_shape_held`` says that window and leans stayed where the search began.
    """

    shared: Array
    own: Array
    information: Array
    pull: Array
    deviance: float
    start: Array
    n_steps: int
    is_shape_held: bool = False


def problem(
    recordings: Sequence[ReducedRecording], fits: Sequence[EdgeDelayFit], *, geometry: WheelGeometry, noise: Array,
    prior_rad2: Array,
) -> Problem:  # fmt: skip
    """The recordings with the frames that their own fits kept.

    Parameters
    ----------
    recordings, fits
        In the same order.
    geometry
        The wheel as drawn by rig.toml.
    noise
        Shape (n_fit,); standard deviation of a frame's residual, widened for all that makes frames less than independent, in
        opening fractions.
    prior_rad2
        Shape (4, 4); covariance of the edges' angles.
    """
    wheel = geometry.model
    seen = [model_of.leans_in_image(one, turns_clockwise=geometry.rotation == "clockwise") for one in recordings]
    parts = tuple(
        replace(model_of.pixel_sums(one, wheel)[0], kept=fit.kept) for one, fit in zip(recordings, fits, strict=True)
    )
    steps = np.array([abs(fit.values[model_of.STEP] / part.unit_dn) for fit, part in zip(fits, parts, strict=True)])
    return Problem(
        parts=parts,
        noise=noise * steps,
        own=np.array([fit.values[_OWN] for fit in fits]),
        prior_rad2=prior_rad2,
        leans_rad=np.mean([leans for leans, _ in seen], axis=0),
        u_lean_rad=max(_LEAST_U_LEAN_RAD, float(np.mean([u for _, u in seen]))),
    )


def begin(given: Problem, fits: Sequence[EdgeDelayFit]) -> Array:
    """Shared numbers to begin at: the earliest delay that a recording found alone, no angle error, one sample for a window."""
    sample_s = min(TURN / part.reduced.samples_per_turn / part.angular_frequency_rad_per_s for part in given.parts)
    middle_s = min(float(fit.values[model_of.DELAY]) for fit in fits)
    return np.array([middle_s, 0, 0, 0, 0, given.parts[0].wheel.opening_angle_rad, sample_s, *given.leans_rad])


def search(given: Problem, start: Array) -> Solution:
    """Lowest minimum of those that differ in the side to which the mask's edges lean.

    A lean rounds a corner nearly alike to either side, so each side has a minimum of its own.

    Parameters
    ----------
    given
        All recordings.
    start
        Shape (9,).

    Raises
    ------
    EstimationError
        If no minimum is reached.
    """
    try:
        best = solve(given, start)
    except EstimationError:  # the shape of the corners hardly touches the delay: leave it as the image shows it
        return replace(solve(given, start, fixed=(WINDOW, *LEANS)), is_shape_held=True)
    for place in LEANS:
        mirrored = best.shared.copy()
        mirrored[place] = -mirrored[place]
        try:
            other = solve(replace(given, own=best.own), mirrored)
        except EstimationError:  # there is no minimum on that side
            continue
        if other.deviance < best.deviance:
            best = replace(other, start=best.start, n_steps=best.n_steps + other.n_steps)
    return best


def solve(given: Problem, start: Array, *, fixed: Sequence[int] = ()) -> Solution:
    """Minimum of the deviance, with some of the shared numbers held.

    Parameters
    ----------
    given
        All recordings.
    start
        Shape (9,).
    fixed
        Places of the shared numbers that stay at their start value.

    Raises
    ------
    EstimationError
        If no minimum is reached.
    """
    free = np.setdiff1d(np.arange(9), fixed)
    shared, own = np.array(start, float), given.own.copy()
    at = _linearise(given, shared, own)
    damping, n_level, enough = 0.0, 0, np.where(np.arange(9) >= WINDOW, _WINDOW_SETTLED, _SETTLED)
    for step in range(1, _MOST_STEPS + 1):
        normal, gradient = _with_prior(given, at, shared)
        part = normal[np.ix_(free, free)]
        size = np.sqrt(np.diag(inverse(part)))
        move = np.zeros(9)
        move[free] = inverse(part + damping * np.diag(size**-2.0)) @ gradient[free]
        if shared[WINDOW] + move[WINDOW] < 0:
            move[WINDOW] = -shared[WINDOW] / 2
        is_settled = bool(np.all(np.abs(move[free]) < enough[free] * size))
        tried, tried_own = shared + move, np.hstack([at.levels, own[:, 5:] + at.shift_moves(move)])
        then = _linearise(given, tried, tried_own)
        gained = _total(given, at, shared) - _total(given, then, tried)
        n_level = n_level + 1 if abs(gained) < _LEVEL else 0
        if gained >= -_ROUNDING * (1 + at.deviance):
            shared, own, at = tried, tried_own, then
            damping = damping / 5 if damping > _LEAST_DAMPING else 0.0
        else:
            damping = max(5 * damping, 2 * _LEAST_DAMPING)
        if is_settled or n_level >= _PATIENCE:
            return Solution(
                shared=shared,
                own=np.hstack([at.levels, own[:, 5:]]),
                information=at.information,
                pull=at.pull,
                deviance=_total(given, at, shared),
                start=np.array(start, float),
                n_steps=step,
            )
    raise EstimationError(
        f"the joint fit of {len(given.parts)} recordings did not settle in {_MOST_STEPS} steps (last delay of the middle "
        f"{1e6 * shared[T_MIDDLE]:.3f} us); they must be of one camera on one rig: analyse them apart to see which differs"
    )


def covariance(given: Problem, found: Solution) -> Array:
    """Inverse of the normal matrix, shape (9, 9)."""
    image, _ = given.image(found.shared)
    return inverse(normal_matrix(found.information, image=image, prior_weight=inverse(given.prior_rad2)))


def normal_matrix(information: Array, *, image: Array, prior_weight: Array) -> Array:
    """Sum over recordings, what the images say, and the prior's inverse covariance on the edges; shape (9, 9)."""
    normal = information.sum(axis=0) + image
    normal[EDGES, EDGES] += prior_weight
    return np.asarray(normal)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Linear:
    """Normal matrix and gradient of each recording, its own numbers eliminated, and what the shifts of its edges follow by.

    ``levels`` (n_fit, 5) are covered level, step, drift, skew and plate at their best.
    """

    information: Array
    pull: Array
    deviance: float
    levels: Array
    shift_step: Array
    shift_slope: Array

    def shift_moves(self, shared_move: Array) -> Array:
        """Best change of the shifts of each recording's own edges, shape (n_fit, k), as the shared numbers move."""
        return np.asarray(self.shift_step - self.shift_slope @ shared_move)


def _linearise(given: Problem, shared: Array, own: Array) -> _Linear:
    n = len(given.parts)
    information, pull = np.zeros((n, 9, 9)), np.zeros((n, 9))
    ours_are = [*_OWN, *(6 + edge for edge in given.own_edges)]
    shift_step, shift_slope = np.zeros((n, len(given.own_edges))), np.zeros((n, len(given.own_edges), 9))
    deviance, levels = 0.0, np.zeros((n, 5))
    for k, (part, noise) in enumerate(zip(given.parts, given.noise, strict=True)):
        values = model_of.at_best_levels(given.values(shared, own[k]), part)
        levels[k] = values[_OWN]
        misfit = model_of.residual(values, part) / noise
        slopes = model_of.slopes(values, part) / noise
        ours, theirs = slopes[:, ours_are], slopes[:, _SHARED]
        scale = np.linalg.norm(ours, axis=0)
        ours = ours / scale
        square, mixed = ours.T @ ours, ours.T @ theirs
        own_gradient = ours.T @ misfit
        through = np.linalg.solve(square, np.column_stack([mixed, own_gradient]))
        information[k] = theirs.T @ theirs - mixed.T @ through[:, :9]
        pull[k] = theirs.T @ misfit - mixed.T @ through[:, 9]
        shifts = through[len(_OWN) :] / scale[len(_OWN) :, None]
        shift_slope[k], shift_step[k] = shifts[:, :9], shifts[:, 9]
        deviance += float(misfit @ misfit)
    return _Linear(
        information=information, pull=pull, deviance=deviance, levels=levels, shift_step=shift_step,
        shift_slope=shift_slope,
    )  # fmt: skip


def _with_prior(given: Problem, at: _Linear, shared: Array) -> tuple[Array, Array]:
    weight, (image, towards) = inverse(given.prior_rad2), given.image(shared)
    gradient = at.pull.sum(axis=0) + towards
    gradient[EDGES] -= weight @ shared[EDGES]
    return normal_matrix(at.information, image=image, prior_weight=weight), gradient


def _total(given: Problem, at: _Linear, shared: Array) -> float:
    edges, lean = shared[EDGES], (shared[LEANS,] - given.leans_rad) / given.u_lean_rad
    return at.deviance + float(edges @ np.linalg.solve(given.prior_rad2, edges)) + float(lean @ lean)
