"""Which recordings show the same blackbody: a pixel is faster the warmer it gets, and surfaces differ in contrast."""

from collections.abc import Sequence

from irtiming.estimate.chains import chains
from irtiming.records.reduced import ReducedRecording

_SAME_K = 1.0  # blackbodies that differ by less count as one


def of_recordings(recordings: Sequence[ReducedRecording]) -> list[list[int]]:
    """`groups` of recordings, by what they state and show."""
    return groups(
        [one.blackbody_temperature_k for one in recordings],
        is_colder=[one.opening.blackbody_is_colder for one in recordings],
    )


def groups(temperature_k: Sequence[float | None], *, is_colder: Sequence[bool]) -> list[list[int]]:
    """Indices of the recordings that share a blackbody's temperature.

    Parameters
    ----------
    temperature_k
        One per recording, K; None where it is not known.
    is_colder
        Whether the blackbody is colder than the wheel: tells apart what ``temperature_k`` does not.

    Returns
    -------
    Groups in the order of their first members. Within one, sorted temperatures follow each other by less than 1 K.
    """
    order = sorted(
        range(len(temperature_k)), key=lambda k: (is_colder[k], temperature_k[k] is None, temperature_k[k] or 0)
    )
    found = chains(order, lambda before, k: _alike(before, k, temperature_k, is_colder))
    return sorted(found, key=lambda group: group[0])


def _alike(one: int, other: int, temperature_k: Sequence[float | None], is_colder: Sequence[bool]) -> bool:
    if is_colder[one] != is_colder[other]:
        return False
    first, second = temperature_k[one], temperature_k[other]
    if first is None or second is None:
        return first is second
    return abs(first - second) < _SAME_K
