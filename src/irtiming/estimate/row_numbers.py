"""What response, memory and readout of a camera whose rows are summed have, as numbers that its recordings share."""

from collections.abc import Sequence

from irtiming.estimate import shared_numbers
from irtiming.estimate.measurands import LAG
from irtiming.estimate.shared_numbers import SharedNumber
from irtiming.physics.light.bent_rows import NONLINEARITIES
from irtiming.records.estimate import EDGE_DELAYS
from irtiming.records.row_timing import RowTimingFit

_LATER = dict(zip(EDGE_DELAYS, (-1.0, 1.0, -1.0, 1.0), strict=True))  # edges that uncover, and those that cover


def of_camera(
    fits: Sequence[RowTimingFit], first: RowTimingFit, *, blackbodies: Sequence[Sequence[int]]
) -> list[SharedNumber]:
    """The camera's numbers: one each, but for those that go with the blackbody.

    A pixel is faster the warmer it gets, so of several blackbodies each has a time constant; and by how much edges that uncover
    are later than those that cover: a pixel that is faster when it is warm warms later and cools earlier than the one time
    constant says. A response that is not a straight line is bent by more the larger the contrast is.

    Parameters
    ----------
    fits
        One per recording.
    first
        The one whose numbers the search begins at.
    blackbodies
        Indices of the fits before each blackbody.
    """
    names = list(dict.fromkeys(name for fit in fits for name in fit.estimate.names if name not in EDGE_DELAYS))
    several = len(blackbodies) > 1
    alike = [name for name in names if name not in NONLINEARITIES and (name != LAG or not several)]
    found = [
        (shared_numbers.memory if name in shared_numbers.MEMORIES else shared_numbers.same)(
            name, fits, start=first.timing[name]
        )
        for name in alike
    ]
    for g, members in enumerate(blackbodies):
        of, one = f" of blackbody {g}" if several else "", fits[members[0]]
        if several and LAG in names:
            found.append(_of_some(fits, members, name=f"{LAG}{of}", effect={LAG: 1.0}, start=first.timing[LAG]))
            found.append(_of_some(fits, members, name=f"uncovering_later{of}", effect=_LATER))
        found += [
            _of_some(fits, members, name=f"{name}{of}", effect={name: 1.0}, start=one.timing[name], unit="1")
            for name in NONLINEARITIES
            if name in one.estimate
        ]
    return found


def _of_some(
    fits: Sequence[RowTimingFit], members: Sequence[int], *, name: str, effect: dict[str, float], start: float = 0.0,
    unit: str = "s",
) -> SharedNumber:  # fmt: skip
    effects = [effect if k in members else {} for k in range(len(fits))]
    return SharedNumber(name=name, effects=effects, start=start, unit=unit)
