"""Which recordings were made at the same wheel speed: a chopper keeps its speed to much less than the steps that are set."""

from collections.abc import Sequence

from irtiming.estimate.chains import chains

_SAME = 2e-3  # of the speed: recordings whose speeds differ by less count as one


def groups(speeds: Sequence[float]) -> list[list[int]]:
    """Indices of the recordings that share a wheel speed.

    Parameters
    ----------
    speeds
        One per recording, all in the same unit.

    Returns
    -------
    Groups from the slowest to the fastest; within one, each speed exceeds the one before by less than 0.2 %.
    """
    order = sorted(range(len(speeds)), key=lambda k: speeds[k])
    return chains(order, lambda before, k: speeds[k] < (1 + _SAME) * speeds[before])
