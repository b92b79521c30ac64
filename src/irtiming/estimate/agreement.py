r"""Whether all that the joint fit takes together agrees: recordings, images and what rig.toml states.

Each recording f has a minimum of its own in its local numbers. At the common minimum its deviance is higher by

.. math:: \chi_f^2 = g_f^T J_f^{-1} g_f

with its gradient and matrix there (`inference.information`); a number that is known beforehand to u, and is x beside that, adds
(x / u)^2. The sum is a chi-square whose degrees of freedom are all statements less the shared numbers that they determine. A
recording that ended in a wrong minimum, an image of another mask, or a stated number that is wrong makes it far larger.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import special

from irtiming.estimate.joint import Joint
from irtiming.inference.information import Information
from irtiming.records.estimate import RecordingFit
from irtiming.records.finding import Finding
from irtiming.units import counted

_FLAT = 1e-10  # of the largest: axes along which a recording says nothing
_SIGNIFICANCE = 1e-6  # once in the life of all laboratories
_FAR = 4.0  # standard uncertainties from which a statement is named
_MOST = 3  # of these


@final
@dataclass(frozen=True, kw_only=True)
class Agreement:
    """Chi-square and its degrees of freedom; ``distances`` of the common minimum from what each one says, in u, by name."""

    chi_square: float
    degrees_of_freedom: int
    distances: dict[str, float]

    @property
    def p_value(self) -> float:
        """How often so much or more is chance."""
        return float(special.chdtrc(max(1, self.degrees_of_freedom), self.chi_square))


def agreement(joint: Joint, *, names: Sequence[str]) -> Agreement:
    """How far recordings and all that is known beforehand are from the common minimum.

    Parameters
    ----------
    joint
        The joint fit.
    names
        Of the recordings.
    """
    found = [_distance(piece) for piece in joint.pieces]
    known = [number for number in joint.shared if number.u is not None]
    pulls = {one.name: (joint.found.values[one.name] - one.known) / float(one.u or 1.0) for one in known}
    recordings = {f"recording {name}": distance for name, (distance, _) in zip(names, found, strict=True)}
    distances = recordings | pulls
    return Agreement(
        chi_square=float(np.sum(np.square(list(distances.values())))),
        degrees_of_freedom=sum(n_known for _, n_known in found) + len(known) - len(joint.shared),
        distances=distances,
    )


def findings(joint: Joint, fits: Sequence[RecordingFit]) -> tuple[Finding, ...]:
    """A doubt where they contradict each other beyond chance.

    Parameters
    ----------
    joint
        The joint fit.
    fits
        Of its recordings, for their names.
    """
    found = agreement(joint, names=[fit.name for fit in fits])
    if found.p_value > _SIGNIFICANCE:
        return ()
    farthest = sorted(found.distances, key=lambda name: -abs(found.distances[name]))[:_MOST]
    named = [f"{name} ({abs(found.distances[name]):.1f} u)" for name in farthest if abs(found.distances[name]) > _FAR]
    return (
        Finding(
            code="statements-contradict",
            severity="doubt",
            what=f"recordings, images and rig.toml contradict each other: chi-square {found.chi_square:.0f} with "
            f"{counted(found.degrees_of_freedom, 'degree')} of freedom{'; farthest off are ' if named else ''}{', '.join(named)}",
            cure="analyse the recordings apart to see which differs, and look at the contrast image and at what rig.toml states",
        ),
    )


def _distance(piece: Information) -> tuple[float, int]:
    """How far the piece's own minimum is, in standard uncertainties, and of how many numbers it says anything."""
    scale = np.sqrt(np.maximum(np.diag(piece.matrix), 1e-300))
    sizes, axes = np.linalg.eigh(piece.matrix / np.outer(scale, scale))
    some = sizes > _FLAT * sizes.max()
    along = axes[:, some].T @ (piece.gradient / scale)
    return float(np.sqrt(np.sum(along**2 / sizes[some]))), int(some.sum())
