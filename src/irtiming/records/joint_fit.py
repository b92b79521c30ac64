"""The joint fit of all recordings of a snapshot photon camera: what it found, how, and how far it can be trusted."""

from dataclasses import dataclass
from typing import final

from irtiming.records.arrays import Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Likelihood along one parameter, all others at their best.

    Parameters
    ----------
    name, unit
        Of the parameter.
    value, standard_uncertainty
        Its estimate and what the covariance says.
    values, deviation
        Shape (k,); values tried, and twice the logarithm of the likelihood lost: 1 at one standard uncertainty.
    lower, upper
        Where the deviation reaches 1; None where the parameter's bound comes first.
    """

    name: str
    unit: str
    value: float
    standard_uncertainty: float
    values: Array
    deviation: Array
    lower: float | None
    upper: float | None


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class JointFit:
    """One likelihood over all recordings.

    Parameters
    ----------
    shared, covariance
        Shapes (9,), (9, 9): middle of the integration window after the trigger (s), angles by which edges 0..3 come earlier than
        rig.toml says (rad), opening angle (rad), window (s), angles by which the
        mask's two radial edges miss the axle, at the mean radius (rad).
    start
        Shape (9,); where the search began.
    prior_covariance_rad2
        Shape (4, 4); of the edges' angles, from rig.toml, the images and the residuals.
    information, pull
        Shapes (n_fit, 9, 9) and (n_fit, 9); what each recording alone says about delay and the eight other shared numbers: its
        normal matrix, and its gradient at ``shared``. Units as above, inverse.
    reduced_chi_square
        Deviance over its degrees of freedom; 1 where residuals are as large as each recording alone leaves them.
    birge
        Square root of the deviance over its degrees of freedom, of the recordings' delays against the common one.
    whiteness
        Shape (n_fit,); probability of residuals at least as correlated along the wheel angle, were they white.
    n_steps
        Steps from the start.
    profiles
        Of each reported parameter.
    """

    shared: Array
    covariance: Array
    start: Array
    prior_covariance_rad2: Array
    information: Array
    pull: Array
    reduced_chi_square: float
    birge: float
    whiteness: Array
    n_steps: int
    profiles: tuple[Profile, ...]
