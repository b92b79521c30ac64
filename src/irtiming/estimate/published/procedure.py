"""The procedures of Schatz 2023, 3.1 and 3.2, step by step: the baseline of every result."""

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np

from irtiming.errors import EstimationError, IrTimingError
from irtiming.estimate import by_blackbody, integration_time, wheel_geometry
from irtiming.estimate.published import lag_timing, row_delay_and_lag, slope_delays, slopes
from irtiming.records.analysis import Published
from irtiming.records.choices import Choices
from irtiming.records.estimate import Estimate
from irtiming.records.exposed import ExposedFraction, ExposedRows
from irtiming.records.finding import Finding
from irtiming.records.lag_estimate import PublishedLagFit, WheelInImage
from irtiming.records.reduced import ReducedRecording
from irtiming.records.result import Result
from irtiming.records.rig import Rig
from irtiming.records.wheel_geometry import WheelGeometry

Average: TypeAlias = ExposedFraction | ExposedRows
"""Opening fractions of one nominal delay."""


def groups(recordings: Sequence[ReducedRecording]) -> list[list[ReducedRecording]]:
    """Runs of the same nominal delay, wheel speed and blackbody together: what the paper averages.

    Parameters
    ----------
    recordings
        Of one camera.
    """
    blackbodies = by_blackbody.of_recordings(recordings)
    found: dict[tuple[float, float, int], list[ReducedRecording]] = {}
    for k, one in enumerate(recordings):
        shown = 0 if one.rows is None else next(g for g, members in enumerate(blackbodies) if k in members)
        found.setdefault((one.rotation_speed_hz, round(one.trigger_delay_time_set_s, 9), shown), []).append(one)
    return list(found.values())


def is_for(recording: ReducedRecording) -> bool:
    """Whether the paper has a procedure for the camera: snapshot photon detectors and rolling microbolometers."""
    return (recording.camera_type, recording.readout_mode) in (("photon", "snapshot"), ("microbolometer", "rolling"))


def estimate(
    averages: Iterable[Average], recordings: Sequence[ReducedRecording], *, rig: Rig, choices: Choices
) -> Published:
    """Timing as the paper finds it, of the two kinds of cameras that it has.

    Parameters
    ----------
    averages
        Opening fractions of each of the `groups`; one that cannot be made is a reason not to run.
    recordings, rig
        What they were made of.
    choices
        Between which opening fractions lines are fitted.

    Returns
    -------
    Without fits, and with a finding that says why, where the procedure could not be run and was not the method asked for: it must
    not take the default method with it.

    Raises
    ------
    IrTimingError
        If it could not be run and was asked for.
    """
    equal = wheel_geometry.geometry(recordings, rig, slots="equal", off_axle_mask=False)
    try:
        return _run(averages, recordings, equal=equal, choices=choices)
    except IrTimingError as error:
        if choices.method == "published":
            raise
        return without(str(error), equal)


def _run(
    averages: Iterable[Average], recordings: Sequence[ReducedRecording], *, equal: WheelGeometry, choices: Choices
) -> Published:
    first = recordings[0]
    if first.pixels is not None:
        lines = tuple(
            slopes.fit(
                one,
                equal.model,
                angular_frequency_rad_per_s=one.angular_frequency_rad_per_s,
                limits=choices.slope_limits,
            )
            for one in averages
            if isinstance(one, ExposedFraction)
        )
        result = slope_delays.estimate(list(lines), equal.model, integration_time_s=integration_time.common(recordings))
        return Published(result=result, fits=lines, geometry=equal)
    if not is_for(first):
        raise EstimationError(
            f"{first.name}: the paper has no procedure for a {first.readout_mode} {first.camera_type} camera; use the "
            "default method"
        )
    lags = tuple(_lag_fit(one, equal, first=first) for one in averages if isinstance(one, ExposedRows))
    return Published(result=lag_timing.estimate(lags), fits=lags, geometry=equal)


def _lag_fit(average: ExposedRows, equal: WheelGeometry, *, first: ReducedRecording) -> PublishedLagFit:
    """Wheel centre and roll are those of the contrast image; the row delay begins at frame period over rows."""
    if first.axle is None:
        raise EstimationError("the wheel centre is not known; fit the contrast image first")
    return row_delay_and_lag.fit(
        average,
        equal.model,
        wheel=WheelInImage(
            row_px=first.axle.row_px,
            column_px=first.axle.column_px,
            roll_rad=equal.camera_roll_rad or 0.0,
            rotation=equal.rotation,
        ),
        initial_row_delay_s=first.trigger_period_s / first.opening.mask.shape[0],
    )


def without(reason: str, geometry: WheelGeometry) -> Published:
    """No result.

    Parameters
    ----------
    reason
        Why the procedure could not be run.
    geometry
        With equal slots.
    """
    nothing = Result(
        method="published",
        estimate=Estimate(names=(), units=(), values=np.zeros(0), covariance=np.zeros((0, 0))),
        relative_delays=(),
        budget=(),
        edge_delay_s=np.full(4, np.nan),
        u_edge_delay_s=np.full(4, np.nan),
        findings=(
            Finding(
                code="published-not-run", severity="warning", what=f"the published procedure could not be run: {reason}"
            ),
        ),
    )
    return Published(result=nothing, fits=(), geometry=geometry)
