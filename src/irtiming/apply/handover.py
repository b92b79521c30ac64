r"""What a result says in the words of other programs: events, signs, and what those programs cannot express.

Every program here has one number for "the image is of another moment than its stamp", and some have one for the rolling
shutter. None has a time constant. So what is handed over is the *effective* moment: middle of the integration of a photon camera,
reading minus time constant of a lagging one. That is good to first order: for a scene, or a camera, whose motion changes little
within a time constant. For a motion of angular frequency omega the lag shifts by :math:`\arctan(\omega\tau)/\omega` instead of
tau and damps by :math:`1/\sqrt{1 + (\omega\tau)^2}`; `Validity` says up to which frequency both stay within one per cent.
"""

from dataclasses import dataclass, replace
from math import pi, sqrt
from typing import final

import numpy as np

from irtiming.apply.camera_timing import CameraTiming, Moment
from irtiming.errors import EstimationError
from irtiming.records.frame_events import FrameEvent

_SAME_RATE = 0.01
_DAMPING = 0.01


@final
@dataclass(frozen=True, kw_only=True)
class Number:
    """A value with its standard uncertainty; s."""

    value_s: float
    u_s: float


@final
@dataclass(frozen=True, kw_only=True)
class Validity:
    """How far one effective moment stands for a lag: up to ``frequency_hz`` amplitudes lose less than one per cent.

    At that frequency the shift is less than the time constant by ``shift_s``.
    """

    time_constant_s: float
    frequency_hz: float
    shift_s: float


@final
@dataclass(frozen=True, kw_only=True)
class HandOver:
    """What all programs take from: moments after the stamp, which is the ``event`` plus ``stamp_latency_s``.

    ``first_row`` and ``middle_row`` are the effective moments of image row 0 and of the middle of the image after the stamp.
    ``exposure_start`` is the start of integration of row 0, None where pixels lag. ``readout`` is from the reading of
    row 0 to that of one past the last row, negative from the bottom up; 0 for a snapshot camera. ``frames_back`` is by how much
    earlier the share of the frame before makes the effective moment, None where the result has no such share or no one frame
    period, without which it is unknown; then ``not_counted`` names that share.
    """

    event: FrameEvent
    first_row: Number
    middle_row: Number
    exposure_start: Number | None
    integration: Number | None
    row_delay: Number
    readout: Number
    rows: int | None
    columns: int | None
    validity: Validity | None
    frames_back: Number | None
    camera: str
    serial_number: str
    frame_period_s: float | None
    not_in_uncertainty: tuple[str, ...]
    not_counted: str
    simulated: bool

    @property
    def is_rolling(self) -> bool:
        """Whether rows are read one after the other."""
        return self.row_delay.value_s != 0


def of_camera(
    camera: CameraTiming, *, stamp_latency_s: float = 0.0, stamp_latency_u_s: float = 0.0, frame_hz: float | None = None
) -> HandOver:
    """What a camera's timing is for other programs.

    Parameters
    ----------
    camera
        As its result states it.
    stamp_latency_s, stamp_latency_u_s
        By how much later than the event, such as the trigger edge, the frames are stamped, and its standard uncertainty; s.
    frame_hz
        At which the camera is used, for a share of the frame before where the recordings have several frame rates, Hz.

    Raises
    ------
    EstimationError
        If the camera is rolling and its result does not say how many rows it has, if each frame holds a share of the one
        before, which lies at no one time before it, or if no recording has that frame rate.
    """
    if frame_hz is not None:
        camera = _at_rate(camera, frame_hz)
    conditions = camera.conditions
    _require_one_period(camera)
    moments = {one.name: one for one in camera.moments(conditions.frame_period_s)}
    if camera.row_delay_s and conditions.rows is None:
        raise EstimationError("the result does not say how many rows the image has; analyse the recordings anew")
    middle = 0.0 if conditions.rows is None or not camera.row_delay_s else (conditions.rows - 1) / 2

    def after_stamp(moment: Moment, row: float) -> Number:
        at = np.array([row])
        u_s = float(np.hypot(camera.u_s(moment, at)[0], stamp_latency_u_s))
        return Number(value_s=float(camera.offset_s(moment, at)[0]) - stamp_latency_s, u_s=u_s)

    tau_s = camera.estimate.value("time_constant") if camera.has_lag else 0.0
    row = Number(value_s=camera.row_delay_s, u_s=camera.estimate.u("row_delay") if camera.row_delay_s else 0.0)
    n_rows = conditions.rows or 0
    return HandOver(
        event=camera.event,
        first_row=after_stamp(moments["effective"], 0.0),
        middle_row=after_stamp(moments["effective"], middle),
        exposure_start=after_stamp(moments["start"], 0.0) if "start" in moments else None,
        integration=_window(camera, moments["start"], moments["end"]) if "start" in moments else None,
        row_delay=row,
        readout=Number(value_s=n_rows * row.value_s, u_s=n_rows * row.u_s),
        rows=conditions.rows,
        columns=conditions.columns,
        validity=_validity(tau_s) if tau_s else None,
        frames_back=_frames_back(camera),
        camera=conditions.model,
        serial_number=conditions.serial_number,
        frame_period_s=conditions.frame_period_s,
        not_in_uncertainty=camera.not_in_uncertainty,
        not_counted=_not_counted(camera),
        simulated=camera.simulated,
    )


def _require_one_period(camera: CameraTiming) -> None:
    response = camera.response
    if camera.conditions.frame_period_s is not None or not (response.recursive_filter or response.pixel_memory):
        return
    rates = f" ({_rates(camera)})" if camera.frame_periods_s else ""
    raise EstimationError(
        f"each frame holds a share of the one before, and the result's recordings have frame periods that differ{rates}: "
        "when a frame was like the scene depends on the period; give {frame_hz}, the frame rate at which you use the "
        "camera, or use irtiming apply time",
        "frame_hz",
    )


def _window(camera: CameraTiming, start: Moment, end: Moment) -> Number:
    """Length of the integration, as found or as the recordings state it."""
    row, name = np.zeros(1), "integration_time"
    length_s = float(camera.offset_s(end, row)[0] - camera.offset_s(start, row)[0])
    return Number(
        value_s=length_s, u_s=camera.estimate.u(name) if name in camera.estimate else camera.stated_window_u_s
    )


def _frames_back(camera: CameraTiming) -> Number | None:
    """By how much the share of the frame before makes the effective moment earlier."""
    period_s = camera.conditions.frame_period_s
    if camera.frame_before is None or period_s is None:
        return None
    at, row = {one.name: one for one in camera.moments(period_s)}, np.zeros(1)
    without = {one.name: one for one in camera.moments(None)}["effective"]
    back_s = camera.offset_s(without, row) - camera.offset_s(at["effective"], row)
    u_s = abs(at["effective"].factors[camera.frame_before]) * camera.estimate.u(camera.frame_before)
    return Number(value_s=float(back_s[0]), u_s=u_s)


def _not_counted(camera: CameraTiming) -> str:
    """A share of the frame before that the effective moment leaves out, for want of one frame period; empty if there is none."""
    name = camera.frame_before
    if name is None or camera.conditions.frame_period_s is not None:
        return ""
    share, u = (100 * one for one in (camera.estimate.value(name), camera.estimate.u(name)))
    return f"{name.replace('_', ' ')} of {share:.2g} % (u = {u:.2g} %)"


def _at_rate(camera: CameraTiming, frame_hz: float) -> CameraTiming:
    """The camera at one of the frame rates that its recordings have."""
    if not any(abs(frame_hz * period_s - 1) < _SAME_RATE for period_s in camera.frame_periods_s):
        raise EstimationError(
            f"{{frame_hz}} is {frame_hz:g} Hz, must be that of a recording of the result: {_rates(camera) or 'none is known'}",
            "frame_hz",
        )
    return replace(camera, conditions=replace(camera.conditions, frame_period_s=1 / frame_hz))


def _rates(camera: CameraTiming) -> str:
    """Frame rates of the recordings, as people write them."""
    return ", ".join(f"{1 / period_s:.5g} Hz" for period_s in camera.frame_periods_s)


def _validity(time_constant_s: float) -> Validity:
    turning = sqrt((1 - _DAMPING) ** -2 - 1)  # omega tau at which the amplitude is down to 99 %
    return Validity(
        time_constant_s=time_constant_s,
        frequency_hz=turning / (2 * pi * time_constant_s),
        shift_s=time_constant_s * (1 - float(np.arctan(turning)) / turning),
    )
