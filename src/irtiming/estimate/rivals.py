"""Recordings with two minima: a filter in the camera and a lag that is as long as a frame look nearly alike.

Where the wheel turns little from frame to frame, a lag and a share of the frame before turn and weaken its harmonics alike, or
nearly so. Then a recording has one minimum with a short lag and a filter, and another with a long lag and next to none; the lower
one may be the wrong one by chance. Other recordings of the camera may decide, or what is stated; else the result has two values.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from irtiming.estimate.shared_numbers import MEMORIES
from irtiming.records.finding import Finding
from irtiming.records.rig import Measured
from irtiming.records.row_timing import Rival, RowTimingFit

_NEARLY = 9.0  # deviance: three standard uncertainties
_OF_CAMERA = ("time_constant", *MEMORIES)


def consistent(fits: Sequence[RowTimingFit], *, frame_memory: Measured | None) -> tuple[RowTimingFit, ...]:
    """The same, each at that of its two minima that goes better with what is stated and with the surest of the recordings.

    Parameters
    ----------
    fits
        Of recordings of one camera that should agree.
    frame_memory
        Share of the frame before, as the camera's owner states it; None where nothing is stated.
    """
    known = [_nearer(fit, _of_memory(fit, frame_memory)) for fit in fits]
    surest = max(known, key=lambda fit: np.inf if fit.rival is None else fit.rival.higher)
    return tuple(fit if fit is surest else _nearer(fit, _of_fit(surest)) for fit in known)


def findings(fits: Sequence[RowTimingFit]) -> tuple[Finding, ...]:
    """A doubt where each recording has another minimum, and all together hardly tell them apart.

    Parameters
    ----------
    fits
        Of one camera.
    """
    found = [fit.rival for fit in fits if fit.rival is not None]
    higher = float(sum(rival.higher for rival in found))
    if not found or len(found) < len(fits) or higher > _NEARLY:
        return ()
    here, there = (_said(timing) for timing in (fits[0].timing, found[0].timing))
    return (
        Finding(
            code="two-minima",
            severity="doubt",
            what=f"the frames allow two answers: {here}, which is the result, or {there}, whose deviance is higher by no more "
            f"than {max(higher, 0.0):.1f}",
            cure="record at another frame rate, or with a faster wheel; or state the camera's filter in [camera] frame_memory",
        ),
    )


def _said(timing: Mapping[str, float]) -> str:
    """The camera's own numbers, for a person."""
    shares = [f"{name.replace('_', ' ')} {100 * timing[name]:.2f} %" for name in MEMORIES if name in timing]
    times = [f"time constant {1e3 * timing['time_constant']:.3f} ms"] if "time_constant" in timing else []
    return " with ".join([*times, *shares])


def _of_memory(fit: RowTimingFit, stated: Measured | None) -> dict[str, Measured]:
    """What is stated of a fit's numbers."""
    return {name: stated for name in MEMORIES if stated is not None and name in fit.estimate}


def _of_fit(fit: RowTimingFit) -> dict[str, Measured]:
    """What a fit says of the camera's own numbers."""
    of_camera = [name for name in _OF_CAMERA if name in fit.estimate]
    return {name: Measured(fit.estimate.value(name), fit.estimate.u(name)) for name in of_camera}


def _nearer(fit: RowTimingFit, known: Mapping[str, Measured]) -> RowTimingFit:
    """The fit at that of its two minima that fits better together with what is known, which also tells how much better."""
    if fit.rival is None:
        return fit
    there = fit.rival.timing
    higher = fit.rival.higher + _distance(fit, there, known=known) - _distance(fit, fit.timing, known=known)
    if higher >= 0:
        return replace(fit, rival=replace(fit.rival, higher=higher))
    values = np.array([there.get(name, fit.timing[name]) for name in fit.estimate.names])
    return replace(
        fit, estimate=replace(fit.estimate, values=values), rival=Rival(timing=fit.timing, higher=-higher)
    )  # fmt: skip


def _distance(fit: RowTimingFit, timing: Mapping[str, float], *, known: Mapping[str, Measured]) -> float:
    """Squared distance of numbers from what is known, in standard uncertainties of both."""
    pairs = [(timing[name] - one.value, np.hypot(fit.estimate.u(name), one.standard_uncertainty))
             for name, one in known.items() if name in fit.estimate]  # fmt: skip
    return float(sum((apart / u) ** 2 for apart, u in pairs))
