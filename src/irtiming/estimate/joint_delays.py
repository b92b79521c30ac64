r"""From the joint fit to delays with their covariance and the budget, by linear algebra on nine numbers per recording.

At the minimum the deviance is a parabola, and every estimate is a linear function of two kinds of independent errors: those of
the frames, whose gradients n_f have the covariance N_f (information), and those of the edges' angles, a ~ (0, P). With A the
inverse of sum N_f + P^-1,

    error of the shared numbers = A sum n_f - A P^-1 a

The delay of falling or rising slopes alone comes from the same numbers after the other two edges are made each recording's own
nuisance, which takes all that their slopes say out of N_f and n_f.

What recordings of one speed see is t + mean(a) / omega, to nanoseconds; t and mean(a) alone they hardly know. So the algebra is
done in the seen delay instead of t, or digits would be lost where the two nearly cancel.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.estimate.joint_fit import EDGES, T_MIDDLE, WINDOW, normal_matrix
from irtiming.physics.covariance import inverse
from irtiming.records.arrays import Array, Ticks
from irtiming.records.estimate import Contribution

_FALLING, _RISING = (0, 2), (1, 3)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class AnglePart:
    """One reason for which edges may not be where rig.toml says, and its covariance (4, 4), rad^2."""

    source: str
    kind: str
    covariance_rad2: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Told:
    """What the recordings say about delay and shared numbers, each (n_fit, ...), at the point ``shared`` (9,).

    ``image`` (9, 9) is what the images tell; its gradient at ``shared`` is ``image_pull`` (9,). ``angular_frequency_rad_per_s``
    (n_fit,) is that of the wheel.
    """

    shared: Array
    information: Array
    pull: Array
    image: Array
    image_pull: Array
    angles: Sequence[AnglePart]
    angular_frequency_rad_per_s: Array

    @property
    def prior_rad2(self) -> Array:
        """Covariance of the edges' angles, all parts together, shape (4, 4)."""
        return total_rad2(self.angles)

    @property
    def delay_row(self) -> Array:
        """The delay in terms of the seen delay and the edges' angles: t = seen - mean(a) / omega, shape (9,)."""
        row = np.zeros(9)
        row[T_MIDDLE] = 1.0
        row[EDGES] = -0.25 / float(np.mean(self.angular_frequency_rad_per_s))
        return row

    def seen(self) -> "Told":
        """The same with the seen delay in the place of the delay."""
        back = np.eye(9)
        back[T_MIDDLE] = self.delay_row
        shared = self.shared.copy()
        shared[T_MIDDLE] = shared[T_MIDDLE] - self.delay_row[EDGES] @ shared[EDGES]
        return replace(
            self, shared=shared, information=back.T @ self.information @ back, pull=self.pull @ back,
            image=back.T @ self.image @ back, image_pull=self.image_pull @ back,
        )  # fmt: skip


def total_rad2(angles: Sequence[AnglePart]) -> Array:
    """Covariance of all parts together, shape (4, 4)."""
    return np.asarray(np.sum([part.covariance_rad2 for part in angles], axis=0)) + 1e-18 * np.eye(4)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class _Estimator:
    """Shared numbers from some of the edges: values (9,), gain A (9, 9), A P^-1 on the edges (9, 4).

    ``without`` (n_fit, 9, 9) takes from each recording's gradient what it must not know.
    """

    values: Array
    gain: Array
    by_angle: Array
    without: Array


def _estimator(told: Told, forgotten: tuple[int, ...]) -> _Estimator:
    """All edges, or without some of them, from what is told with the seen delay."""
    without = np.tile(np.eye(9), (len(told.information), 1, 1))
    places = [EDGES.start + edge for edge in forgotten]
    alone = np.eye(9)[:, places]  # an edge moves, the delay does not: the seen delay follows
    alone[T_MIDDLE] = -told.delay_row[places]
    for keep, full in zip(without, told.information, strict=True):
        if places:
            keep -= full @ alone @ inverse(alone.T @ full @ alone) @ alone.T
    weight = inverse(told.prior_rad2)
    gain = inverse(normal_matrix(without @ told.information, image=told.image, prior_weight=weight))
    gradient = np.einsum("fij,fj->i", without, told.pull) + told.image_pull
    gradient[EDGES] -= weight @ told.shared[EDGES]
    return _Estimator(
        values=told.shared + gain @ gradient, gain=gain, by_angle=gain[:, EDGES] @ weight, without=without
    )


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SharedDelays:
    """Middle of the window from all, falling and rising edges, and the window: values (4,), covariance (4, 4), s."""

    values: Array
    covariance: Array
    edge_angles_rad: Array
    u_edge_angles_rad: Array


def shared_delays(told: Told) -> SharedDelays:
    """Delays common to all recordings, and the window.

    Returns
    -------
    In the order of the middle from all edges, from falling ones, from rising ones, and the length of the window.
    """
    seen, delay, window = told.seen(), told.delay_row, np.eye(9)[WINDOW]
    all_edges, falling, rising = (_estimator(seen, forgotten) for forgotten in ((), _RISING, _FALLING))
    rows = [(all_edges, delay), (falling, delay), (rising, delay), (all_edges, window)]
    by_frame = np.array([row @ one.gain @ one.without for one, row in rows])
    by_image = np.array([row @ one.gain for one, row in rows])
    angle = np.array([row @ one.by_angle for one, row in rows])
    noise = np.einsum("afi,fij,bfj->ab", by_frame, seen.information, by_frame, optimize=True)
    return SharedDelays(
        values=np.array([row @ one.values for one, row in rows]),
        covariance=noise + by_image @ seen.image @ by_image.T + angle @ told.prior_rad2 @ angle.T,
        edge_angles_rad=all_edges.values[EDGES],
        u_edge_angles_rad=np.sqrt(np.diag(all_edges.gain[EDGES, EDGES])),
    )


def budget(told: Told, *, degrees_of_freedom: float) -> tuple[Contribution, ...]:
    """What each source alone gives to the delay from all edges; squares add up to its variance.

    Parameters
    ----------
    told
        From the joint fit.
    degrees_of_freedom
        Of the frames' noise.
    """
    seen = told.seen()
    best = _estimator(seen, ())
    noise, angle = told.delay_row @ best.gain, told.delay_row @ best.by_angle
    frames = seen.information.sum(axis=0) + seen.image
    parts = [("noise of the frames", "A", float(noise @ frames @ noise), degrees_of_freedom)]
    parts += [
        (part.source, part.kind, float(angle @ part.covariance_rad2 @ angle), float("inf")) for part in told.angles
    ]
    return tuple(
        Contribution(
            source=source,
            kind=kind,
            standard_uncertainty_s=float(np.sqrt(max(0.0, variance))),
            degrees_of_freedom=freedom,
        )
        for source, kind, variance, freedom in parts
    )


def each_delay(told: Told, *, setting: Ticks) -> tuple[Array, Array]:
    """Delay of the window's middle in each recording, with angles, opening and window shared by all.

    Nothing is taken for granted of the delays that were set: recordings of one setting share a delay, which is what lets wheel
    speeds tell angles from delays; recordings of different settings do not.

    Parameters
    ----------
    told
        From the joint fit.
    setting
        Shape (n_fit,); number of each recording's set delay, from 0.

    Returns
    -------
    Values (n_fit,), s, and covariance (n_fit, n_fit), s^2.
    """
    seen = told.seen()
    n, n_set = len(seen.information), int(setting.max()) + 1
    place = np.zeros((n, 9, n_set + 8))  # where each recording's nine numbers stand among all
    place[np.arange(n), T_MIDDLE, setting] = 1.0
    place[:, 1:, n_set:] = np.eye(8)
    weight = np.zeros((9, 9))
    weight[EDGES, EDGES] = inverse(told.prior_rad2)
    rest = np.eye(9)[:, 1:] @ np.eye(n_set + 8)[n_set:]
    normal = np.einsum("fia,fij,fjb->ab", place, seen.information, place, optimize=True)
    gain = inverse(normal + rest.T @ (seen.image + weight) @ rest)
    gradient = np.einsum("fia,fi->a", place, seen.pull) + rest.T @ (seen.image_pull - weight @ told.shared)
    moved = (gain @ gradient)[n_set:]
    alone = 1 / seen.information[:, T_MIDDLE, T_MIDDLE]
    others = seen.information[:, T_MIDDLE, 1:]
    values = seen.shared[T_MIDDLE] + alone * (seen.pull[:, T_MIDDLE] - others @ moved)
    values = values + told.delay_row[1:] @ (seen.shared[1:] + moved)
    follows = (told.delay_row[1:] - alone[:, None] * others) @ gain[n_set:]  # as all numbers change
    maps = np.einsum("fa,gia->fgi", follows, place)
    maps[np.arange(n), np.arange(n), T_MIDDLE] += alone
    noise = np.einsum("fka,kab,gkb->fg", maps, seen.information, maps, optimize=True)
    by_image, angle = follows @ rest.T, follows @ rest.T @ weight[:, EDGES]
    return values, noise + by_image @ seen.image @ by_image.T + angle @ told.prior_rad2 @ angle.T
