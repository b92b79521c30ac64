"""What recordings of one rig share, whatever the camera: wheel speeds, the edges' scatter, delays against the smallest one."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from irtiming.records.arrays import Array
from irtiming.records.estimate import RelativeDelay
from irtiming.records.wheel_geometry import WheelGeometry

_T_FACTOR = 3.0  # nu / (nu - 2) with the 3 degrees of freedom of four edges (JCGM 101, 6.4.9)
_LARGEST_EDGE_RAD = 5e-3


class EdgeDelays(Protocol):
    """A fit of one recording that gives a delay for each wheel edge."""

    @property
    def name(self) -> str:
        """Of the recording."""
        ...

    @property
    def trigger_delay_time_set_s(self) -> float:
        """Extra delay set, already taken off the edge delays."""
        ...

    @property
    def angular_frequency_rad_per_s(self) -> float:
        """Of the wheel."""
        ...

    @property
    def edge_delay_s(self) -> Array:
        """Shape (4,)."""
        ...


def by_speed(fits: Sequence[EdgeDelays]) -> list[tuple[float, list[int]]]:
    """Wheel rate in Hz and the indices of its fits, for each rate."""
    speeds = np.round([fit.angular_frequency_rad_per_s / (2 * np.pi) for fit in fits], 2)
    return [(float(speed), [int(k) for k in np.flatnonzero(speeds == speed)]) for speed in np.unique(speeds)]


def edge_uncertainty(fits: Sequence[EdgeDelays], geometry: WheelGeometry) -> float:
    """Standard uncertainty of one cutout edge, rad: as stated, else from the scatter of the four edges.

    The four edges of a perfect wheel would give one delay. Their scatter, with 3 degrees of freedom, is that of the
    cutout edges against the ring (plus noise, which is small beside it).
    """
    if geometry.u_edge_rad is not None:
        return geometry.u_edge_rad
    angles = np.mean([fit.edge_delay_s * fit.angular_frequency_rad_per_s for fit in fits], axis=0)
    return float(np.sqrt(_T_FACTOR * np.var(angles, ddof=1)))


def edge_doubts(u_edge_rad: float) -> tuple[str, ...]:
    """A doubt where the edges differ by more than wheels are cut to."""
    if u_edge_rad <= _LARGEST_EDGE_RAD:
        return ()
    return (
        f"the four wheel edges disagree by {1e3 * u_edge_rad:.1f} mrad (standard uncertainty of one edge), wheels are cut to "
        f"better than {1e3 * _LARGEST_EDGE_RAD:.0f} mrad; check [wheel] rotation and cutout_edges_rad",
    )


def relative_delays(
    fits: Sequence[EdgeDelays], weights: Array, *, values: Array, total: Array
) -> tuple[RelativeDelay, ...]:
    """Delay of each recording minus the mean of those with the smallest set delay, including what was set.

    Parameters
    ----------
    fits
        One per recording, n in all.
    weights
        Shape (n, k); delay of each recording, set delay taken off, from the values.
    values, total
        Shapes (k,), s, and (k, k), s^2; what was fitted, and its covariance.
    """
    nominal = np.array([fit.trigger_delay_time_set_s for fit in fits])
    reference = np.isclose(nominal, nominal.min(), rtol=0, atol=1e-12)
    difference = np.eye(len(fits)) - reference / reference.sum()
    covariance = difference @ weights @ total @ weights.T @ difference.T
    value, u = difference @ (weights @ values + nominal), np.sqrt(np.maximum(np.diag(covariance), 0))
    return tuple(
        RelativeDelay(
            file=fit.name,
            nominal_s=float(nominal[k] - nominal.min()),
            value_s=float(value[k]),
            standard_uncertainty_s=float(u[k]),
        )
        for k, fit in enumerate(fits)
    )
