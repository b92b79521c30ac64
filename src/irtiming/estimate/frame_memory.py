"""What is said of cameras whose frames hold a share of those before, and of noise that successive frames have in common."""

from collections.abc import Sequence

import numpy as np

from irtiming.estimate.shared_numbers import MEMORIES
from irtiming.inference.correlated_noise import ljung_box_p_value
from irtiming.physics.response import in_camera_filter
from irtiming.records.estimate import Estimate, RecordingFit
from irtiming.records.finding import Finding
from irtiming.records.result import LEAST_WHITENESS
from irtiming.records.rig import Measured
from irtiming.records.row_timing import RowTimingFit
from irtiming.units import counted

_SIGNIFICANT = 3.0  # standard uncertainties of an age from which it is distinguished from none
_CONTRADICTS = 4.0  # standard uncertainties between the ages of statement and frames
_MOSTLY = 0.5  # of a frame: from there on the frames before have the greater part in it
_MUCH = 0.3  # correlation of successive frames: more than chance or a level that sways a little leaves in them
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
        age = _age(name, Measured(share, u))
        if age.value > _SIGNIFICANT * age.standard_uncertainty:
            found.append(_mostly_older(shares) if share > _MOSTLY else _significant(name, shares))
        elif age.value < -_IMPOSSIBLE * age.standard_uncertainty:
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
    named = [(name, fit.estimate) for fit in fits for name in MEMORIES if name in fit.estimate]
    if stated is None or not named:
        return ()
    ages = [_age(name, Measured(estimate.value(name), estimate.u(name))) for name, estimate in named]
    weights, said = np.array([age.standard_uncertainty**-2 for age in ages]), _age(named[0][0], stated)
    apart = abs(float(np.average([age.value for age in ages], weights=weights)) - said.value)
    apart /= float(np.hypot(weights.sum() ** -0.5, said.standard_uncertainty))
    if apart < _CONTRADICTS:
        return ()
    share = float(np.average([estimate.value(name) for name, estimate in named], weights=weights))
    return (
        Finding(
            code="frame-memory-contradicted",
            severity="doubt",
            what=f"frames hold {100 * share:.3g} % of the frame before, rig.toml states frame_memory = {stated.value:g}: "
            f"{apart:.1f} standard uncertainties apart, and the result is that of the statement",
            cure="take frame_memory out of rig.toml, then the frames alone determine it; or state its uncertainty",
        ),
    )


def _age(name: str, share: Measured) -> Measured:
    """By how many frames what a frame shows is older, on average: the number that frames tell of a share.

    Of a filter's share it is another function, which counts where the frames hardly tell the filter from a delay: there the share
    may lie three of its own standard uncertainties from none where its age does one and a half.
    """
    if name != in_camera_filter.PARAMETER or share.value >= 1:
        return share
    slope = in_camera_filter.mean_age_slope(share.value)
    return Measured(in_camera_filter.mean_age(share.value), slope * share.standard_uncertainty)


def _significant(name: str, shares: str) -> Finding:
    if name == in_camera_filter.PARAMETER:
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


def of_row_fits(fits: Sequence[RowTimingFit], estimate: Estimate) -> tuple[Finding, ...]:
    """Where residuals of successive frames are correlated.

    Parameters
    ----------
    fits
        One per recording.
    estimate
        Of the camera.
    """
    correlations = [correlation(fit) for fit in fits]
    low = [one for one in correlations if one[1] < LEAST_WHITENESS]
    if not low:
        return ()
    largest = max((one[0] for one in low), key=abs)
    if all(abs(one) > _MUCH for one, _ in correlations) and of_result(estimate):  # a filter is in every recording
        return (_of_another_kind(largest),)
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


def _of_another_kind(largest: float) -> Finding:
    return Finding(
        code="filter-of-another-kind",
        severity="doubt",
        what=f"with the filter of the camera undone, residuals of successive frames have a correlation of {largest:+.2f}: the "
        "camera's filter is of another kind than the model's, which takes one share of the frame before, as where it takes the "
        "mean of several frames; time constant and delay are corrected for the wrong one and may be off by more than stated",
        cure="switch filters and averaging of the camera off, and record again",
    )
