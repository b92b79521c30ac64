r"""How well a set of runs can tell what is sought, in the algebra of `inference.information`.

What a run has for itself (its level, its step, its drift) is eliminated within; what all runs share stays. The rig's angle errors
are numbers too, counted in their standard uncertainty, so that what rig.toml says of them is an information of 1. With one wheel
speed an angle error looks like a delay and stays; with several it does not, and the frames tell them apart.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias, final

import numpy as np

from irtiming.errors import EstimationError, PlanError
from irtiming.inference.information import NOISE, Combined, Information, Weights, combine, prior
from irtiming.physics.camera import EXACT_SHARE, Camera
from irtiming.physics.latency import EXACT_S
from irtiming.plan.beside_angles import Beside
from irtiming.records import sources
from irtiming.records.arrays import Array
from irtiming.records.prediction import PredictedPart, PredictedUncertainty

Asked: TypeAlias = Mapping[str, Weights]
"""What is asked for, by name: each a sum of parameters."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RunInformation:
    """What runs say of parameters and errors (``frames``), and what is known of the errors beforehand, by source.

    ``beside`` is what errors that no run determines add to parameters: by parameter, then by source, s. ``stated`` is what is
    known of parameters beforehand. ``centre`` is by how much errors make the centre of what the window takes in later than its
    middle, s by their names.
    """

    frames: Information
    known: tuple[Information, ...]
    beside: Beside = field(default_factory=dict)
    stated: tuple[Information, ...] = ()
    centre: Weights = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        errors = {name for one in self.known for name in one.names}
        return tuple(name for name in self.frames.names if name not in errors)

    def times(self, n_runs: float) -> "RunInformation":
        """That of so many runs; what is known of the rig does not grow with them."""
        return replace(self, frames=self.frames.times(n_runs))


def run_information(names: Sequence[str], sources: Sequence[str], *, matrix: Array) -> RunInformation:
    """What a run says.

    Parameters
    ----------
    names
        Of the parameters.
    sources
        Of the errors, each with a standard uncertainty of 1; several may have the same.
    matrix
        Shape (n, n); information on the parameters, then on the errors.
    """
    errors = [f"{source} {k}" for k, source in enumerate(sources)]
    of_source = {source: [e for e, own in zip(errors, sources, strict=True) if own == source] for source in sources}
    known = tuple(_ones(source, own) for source, own in of_source.items())
    return RunInformation(frames=_silent(NOISE, (*names, *errors), matrix), known=known)


def _ones(source: str, errors: Sequence[str]) -> Information:
    return _silent(source, tuple(errors), np.eye(len(errors)))


def _silent(source: str, names: tuple[str, ...], matrix: Array) -> Information:
    return Information(source=source, names=names, matrix=matrix, gradient=np.zeros(len(names)))


def stated_memory(camera: Camera, u: float | None) -> tuple[Information, ...]:
    """What is known of the share of the frame before in each frame.

    Parameters
    ----------
    camera
        Whose frames keep something of those before, in its own way.
    u
        Standard uncertainty of the share, as rig.toml states it; None where it states nothing.
    """
    if u is None:
        return (prior(camera.memory.PARAMETER, camera.memory.U_SHARE, source=NOISE),)
    return (prior(camera.memory.PARAMETER, max(u, EXACT_SHARE), source=sources.MEMORY),)


def stated_window(u_s: float | None) -> tuple[Information, ...]:
    """What is known of the integration time where its standard uncertainty, s, is stated."""
    return () if u_s is None else (prior("integration_time", max(u_s, EXACT_S), source=sources.WINDOW),)


def total(parts: Sequence[RunInformation]) -> RunInformation:
    """Information of independent runs together.

    Parameters
    ----------
    parts
        One or more.

    Raises
    ------
    PlanError
        If they do not have the same parameters and errors.
    """
    first = parts[0]
    if any(part.frames.names != first.frames.names for part in parts):
        raise PlanError(
            "the runs do not have the same parameters, so their information cannot be added; plan them apart"
        )
    matrix = np.sum([part.frames.matrix for part in parts], axis=0)
    return replace(first, frames=replace(first.frames, matrix=matrix))


def apart(delayed: RunInformation, reference: RunInformation) -> RunInformation:
    """Information of two sets of runs with two set delays: the difference of their delays is the parameter relative_delay."""
    names = ("relative_delay", *delayed.frames.names)
    without = np.eye(len(names))[1:]
    spread = without.copy()
    spread[delayed.frames.names.index("trigger_delay"), 0] = 1.0
    both = delayed.frames.of(names, spread), reference.frames.of(names, without)
    return replace(delayed, frames=replace(both[0], matrix=both[0].matrix + both[1].matrix))


def combined(one: RunInformation) -> Combined:
    """Frames and what is known beforehand.

    Raises
    ------
    PlanError
        If nothing determines a parameter.
    """
    try:
        return combine([one.frames, *one.known, *one.stated])
    except EstimationError as error:
        raise PlanError(str(error)) from error


def uncertainties(one: RunInformation, asked: Asked) -> tuple[PredictedUncertainty, ...]:
    """Predicted standard uncertainty of each sum of parameters, with its parts: noise, and the errors by source."""
    whole = combined(one)
    found = []
    for name, weights in asked.items():
        squares = whole.shares(weights)
        parts = tuple(
            PredictedPart(source=source, standard_uncertainty_s=float(np.sqrt(max(square, 0.0))))
            for source, square in squares.items()
        )
        u_s = float(np.sqrt(max(sum(squares.values()), 0.0)))
        without = PredictedUncertainty(name=name, standard_uncertainty_s=u_s, parts=parts)
        found.append(with_parts(without, one.beside.get(name, {})))
    return tuple(found)


def with_parts(one: PredictedUncertainty, more: Mapping[str, float]) -> PredictedUncertainty:
    """The same with further parts.

    Parameters
    ----------
    one
        A prediction.
    more
        Standard uncertainties by source, s.
    """
    parts = tuple(PredictedPart(source=source, standard_uncertainty_s=u) for source, u in more.items() if u > 0)
    squares = one.standard_uncertainty_s**2 + sum(part.standard_uncertainty_s**2 for part in parts)
    return replace(one, standard_uncertainty_s=float(np.sqrt(squares)), parts=(*one.parts, *parts))


def variances(one: RunInformation, asked: Asked) -> Array:
    """Squares of the uncertainties alone, shape (n_asked,), where many sets of runs are compared; s^2."""
    whole = combined(one)
    return np.array([whole.variance(weights) + _beside(one, name) for name, weights in asked.items()])


def _beside(one: RunInformation, name: str) -> float:
    return sum(u**2 for u in one.beside.get(name, {}).values())
