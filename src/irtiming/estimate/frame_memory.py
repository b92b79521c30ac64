"""What is said of cameras whose frames hold a share of those before, and of noise that successive frames have in common."""

from collections.abc import Sequence

import numpy as np

from irtiming.estimate.shared_numbers import MEMORIES
from irtiming.inference.correlated_noise import ljung_box_p_value
from irtiming.records.estimate import Estimate, RecordingFit
from irtiming.records.finding import Finding
from irtiming.records.result import LEAST_WHITENESS
from irtiming.records.rig import Measured
from irtiming.records.row_timing import RowTimingFit
from irtiming.units import counted

_SIGNIFICANT = 3.0  # standard uncertainties from which a share is distinguished from none
_CONTRADICTS = 4.0  # standard uncertainties between statement and frames
_MOSTLY = 0.5  # of a frame: from there on the frames before have the greater part in it
_IMPOSSIBLE = 4.0  # standard uncertainties below zero: no camera takes part of the frame before away


def of_result(estimate: Estimate) -> tuple[Finding, ...]:
    """Where frames hold a share of the frame before, or seem to hold less than nothing of it.

    Parameters
    ----------
    estimate
        Of the camera; says nothing where it has no such share.
    """
    found = list[Finding]()
    for name in MEMORIES:
        if name not in estimate:
            continue
        share, u = estimate.value(name), estimate.u(name)
        shares = f"{100 * share:.3g} % (u = {100 * u:.2g} %) of the frame before"
        if share > _MOSTLY:
            found.append(_mostly_older(shares))
        elif share > _SIGNIFICANT * u:
            found.append(_significant(name, shares))
        elif share < -_IMPOSSIBLE * u:
            found.append(_impossible(name, shares))
    return tuple(found)


def of_stated(fits: Sequence[RecordingFit], stated: Measured | None) -> tuple[Finding, ...]:
    """Where the frames contradict the share that rig.toml states.

    Parameters
    ----------
    fits
        One per recording, each with what its own frames tell.
    stated
        The share of the frame before; None where rig.toml does not state it.
    """
    estimates = [(fit.estimate, name) for fit in fits for name in MEMORIES if name in fit.estimate]
    if stated is None or not estimates:
        return ()
    weights = np.array([estimate.u(name) ** -2 for estimate, name in estimates])
    share = float(np.average([estimate.value(name) for estimate, name in estimates], weights=weights))
    u = float(np.hypot(weights.sum() ** -0.5, stated.standard_uncertainty))
    if abs(share - stated.value) < _CONTRADICTS * u:
        return ()
    return (
        Finding(
            code="frame-memory-contradicted",
            severity="doubt",
            what=f"frames hold {100 * share:.3g} % of the frame before, rig.toml states frame_memory = {stated.value:g}: "
            f"{abs(share - stated.value) / u:.1f} standard uncertainties apart, and the result is that of the statement",
            cure="take frame_memory out of rig.toml, then the frames alone determine it; or state its uncertainty",
        ),
    )


def _significant(name: str, shares: str) -> Finding:
    if name == "recursive_filter":
        return Finding(
            code="camera-filters-frames",
            severity="warning",
            what=f"each frame of the camera holds {shares}: a noise filter in the camera is on; time constant and delay are "
            "corrected for it, if it keeps the digits behind the point",
            cure="switch the filter off to measure the detector alone",
        )
    return Finding(
        code="pixels-remember",
        severity="warning",
        what=f"each frame holds {shares}: a memory of the pixels, or a noise filter in the camera; delays are corrected for it",
        cure="switch filters of the camera off; what is left is the detector's own",
    )


def _mostly_older(shares: str) -> Finding:
    return Finding(
        code="frames-mostly-older",
        severity="doubt",
        what=f"each frame holds {shares}: most of it is older than its trigger, as where a camera repeats frames, hands each one "
        "out a frame late, or takes the mean of several; the model knows a filter that takes the smaller part of the frame "
        "before, and what goes along with it (time constant, delays) may be off by more than stated",
        cure="switch filters and averaging of the camera off, and check with a lamp that a frame shows what is at its trigger",
    )


def _impossible(name: str, shares: str) -> Finding:
    return Finding(
        code="frame-memory-negative",
        severity="doubt",
        what=f"frames seem to hold {shares}, which no camera does: something that is not in the model looks like a "
        f"{name.replace('_', ' ')}, and what goes along with it (time constant, delays) may be off by more than stated",
        cure="look at the residuals over the wheel angle for what differs from the model",
    )


def correlation(fit: RowTimingFit) -> tuple[float, float]:
    """Correlation of the residuals of frames that followed each other, and its p-value.

    Parameters
    ----------
    fit
        Its residuals are in the order of the triggers; a recursive filter that was found is undone in them.

    Returns
    -------
    Coefficient at one frame, and the p-value of Ljung and Box.
    """
    mean = np.mean(fit.residual / fit.noise, axis=1)
    centred = mean - mean.mean()
    power = float(centred @ centred)
    return (float(centred[:-1] @ centred[1:]) / power if power else 0.0), ljung_box_p_value(mean)


def of_row_fits(fits: Sequence[RowTimingFit]) -> tuple[Finding, ...]:
    """Where residuals of successive frames are correlated.

    Parameters
    ----------
    fits
        One per recording.
    """
    correlations = [correlation(fit) for fit in fits]
    low = [one for one in correlations if one[1] < LEAST_WHITENESS]
    if not low:
        return ()
    largest = max((one[0] for one in low), key=abs)
    return (
        Finding(
            code="residuals-not-white-in-time",
            severity="warning",
            what=f"residuals of {len(low)} of {counted(len(correlations), 'recording')} are not white in the order of the "
            f"triggers (correlation of successive frames up to {largest:+.2f}): the camera's level sways from frame to frame, or "
            "a filter in the camera is not the one of the model",
            cure="their uncertainty is widened for it",
        ),
    )
