"""What the numbers of a result owe each other: which names a camera has, units, correlations that a covariance can have.

All of it holds for every result that an analysis gives, within rounding; a file that was edited by hand mostly breaks one of it.
Each function raises a `ValueError` that says what is and what must be; who reads the file adds what to do.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

from irtiming.records.estimate import SHARES
from irtiming.records.frame_events import DELAYS, FrameEvent
from irtiming.records.recording import USUAL_READOUT, CameraType, ReadoutMode
from irtiming.records.two_constants import NAMES as TWO_CONSTANTS

_ROUNDING = 1e-6  # of a correlation coefficient, and relative of a standard uncertainty

Coefficients = Sequence[Sequence[float | None]]
"""Of a correlation; None where one is not known."""


def require_names(
    found: Collection[str], *, camera: CameraType, readout_mode: ReadoutMode | None, frame_event: FrameEvent
) -> None:
    """Every parameter that a result of such a camera has, as a number or as a bound, is there.

    A window has a start only where its length is known; delays by slopes of one direction never stand without it.

    Raises
    ------
    ValueError
        If one is missing.
    """
    own, mode = DELAYS[frame_event], readout_mode or USUAL_READOUT[camera]
    has_lag = camera == "microbolometer"
    has_start = own in found or any(name.startswith(f"{own}_") for name in found)
    needed = [own if has_lag or has_start else "exposure_midpoint_delay"]
    needed += ["time_constant"] * has_lag + ["row_delay"] * (mode == "rolling")
    lacking = [name for name in needed if name not in found]
    if lacking:
        raise ValueError(f"lacks {', '.join(lacking)}, which every result of a {mode} {camera} camera has")


def require_units(units: Mapping[str, str]) -> None:
    """Of each parameter the unit that this program writes.

    Raises
    ------
    ValueError
        If one has another.
    """
    for name, unit in units.items():
        must = "1" if name in SHARES else "s"
        if unit != must:
            raise ValueError(f"has {name} in '{unit}', must be in '{must}'")


def require_same_names(found: Iterable[str], parameters: Iterable[str], *, what: str) -> None:
    """Those of the parameters, but for the two constants of a wide temperature range, which are told apart from all others.

    Raises
    ------
    ValueError
        If one is missing or none of them.
    """
    of_parameters = [name for name in parameters if name not in TWO_CONSTANTS]
    if set(found) != set(of_parameters):
        raise ValueError(
            f"has {what} of {', '.join(found) or 'nothing'}, must be of its parameters, {', '.join(of_parameters) or 'none'}"
        )


def require_correlation(names: Sequence[str], matrix: Coefficients) -> None:
    """A matrix that the correlations of a covariance can be.

    Parameters
    ----------
    names
        (n,); of rows and columns.
    matrix
        n rows of n; a number without uncertainty has 0 on the diagonal.

    Raises
    ------
    ValueError
        If it has another shape, is not symmetric, has coefficients beyond 1, a diagonal of other than 1, or belongs to no
        covariance because some sum of the numbers would have a negative variance.
    """
    n = len(names)
    if len(matrix) != n or any(len(row) != n for row in matrix):
        raise ValueError(f"is no matrix of {n} rows and columns, one for each of its names")
    found = np.array(matrix, dtype=np.float64).reshape(n, n)  # None becomes nan
    for i, k in np.ndindex(n, n):
        one, other, between = found[i, k], found[k, i], f"{names[i]} and {names[k]}"
        if abs(one) > 1 + _ROUNDING:
            raise ValueError(f"has {one:g} between {between}, must be from -1 to 1")
        if i == k and min(abs(one), abs(one - 1)) > _ROUNDING:
            raise ValueError(f"has {one:g} between {names[i]} and itself, must be 1, or 0 where it has no uncertainty")
        if abs(one - other) > _ROUNDING or np.isnan(one) != np.isnan(other):
            raise ValueError(f"has {one:g} between {between}, but {other:g} the other way round, must be symmetric")
    if n and not np.isnan(found).any() and np.linalg.eigvalsh(found)[0] < -n * _ROUNDING:
        raise ValueError(
            f"is of no covariance: a sum of {', '.join(names)} would have a negative variance, must be positive semi-definite"
        )


def require_expanded(u: float | None, factor: float | None, *, expanded: float | None) -> None:
    """The expanded uncertainty is the coverage factor times the standard one, where all three are known.

    Raises
    ------
    ValueError
        If it is not.
    """
    if u is None or factor is None or expanded is None:
        return
    if abs(expanded - factor * u) > _ROUNDING * factor * u:
        raise ValueError(f"has expanded_uncertainty {expanded:g}, must be coverage_factor times u, {factor * u:g}")


def require_covariance(covariance: float | None, *, u: float | None, other_u: float | None) -> None:
    """A covariance of two numbers that is at most the product of their standard uncertainties.

    Raises
    ------
    ValueError
        If it is more.
    """
    if covariance is None or u is None or other_u is None:
        return
    if abs(covariance) > (1 + _ROUNDING) * u * other_u:
        raise ValueError(f"has covariance {covariance:g}, must be within the product of both u, ±{u * other_u:g}")
