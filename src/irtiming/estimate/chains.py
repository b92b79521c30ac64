"""Recordings in order of something that hardly differs within a group: neighbours that are alike are of one."""

from collections.abc import Callable, Sequence


def chains(order: Sequence[int], is_alike: Callable[[int, int], bool]) -> list[list[int]]:
    """Runs of indices, each like the one before it; sorted within.

    Parameters
    ----------
    order
        Indices, neighbours side by side.
    is_alike
        Whether an index belongs with the one before it, which is given first.
    """
    found: list[list[int]] = []
    for k in order:
        if found and is_alike(found[-1][-1], k):
            found[-1].append(k)
        else:
            found.append([k])
    return [sorted(group) for group in found]
