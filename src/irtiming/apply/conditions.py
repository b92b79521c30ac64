"""Whether a result holds for other frames: it does for the camera and the settings that were measured, and for no other."""

from typing import get_args

import numpy as np

from irtiming.apply.camera_timing import Conditions
from irtiming.archive import layout
from irtiming.archive.frames.source import FrameFacts
from irtiming.errors import ConditionError
from irtiming.records.recording import CameraType, ReadoutMode, Recording
from irtiming.units import readable_time

_FEWEST = 8
SAME = 1e-3
"""Relative, within which two settings are one."""

_OTHER_UNIT = 10.0
"""Factor between two times between frames from which a unit is doubted. Units of stamps are 1000 apart, cameras' counters tick in
1 µs or 0.1 µs, 10 apart; a camera that makes frames so much faster or slower than when it was measured is noted, not refused."""


def of_recording(recording: Recording) -> Conditions:
    """What a recording says of its camera."""
    _, rows, columns = recording.frames.shape
    camera = recording.camera
    return Conditions(
        camera_type=recording.camera_type,
        readout_mode=recording.readout_mode,
        serial_number="" if camera is None else camera.serial_number,
        model="" if camera is None else camera.model,
        integration_time_s=recording.integration_time_s,
        rows=rows,
        columns=columns,
        frame_period_s=_period_s(recording),
    )


def of_facts(facts: FrameFacts) -> Conditions:
    """What any file of frames says of its camera; kind of detector and readout mode where it was a recording once."""
    detector, readout = (str(facts.more.get(field.name, "")) for field in (layout.CAMERA_TYPE, layout.READOUT_MODE))
    return Conditions(
        camera_type=next((one for one in get_args(CameraType) if one == detector), ""),
        readout_mode=next((one for one in get_args(ReadoutMode) if one == readout), ""),
        serial_number="" if facts.camera is None else facts.camera.serial_number,
        model="" if facts.camera is None else facts.camera.model,
        integration_time_s=facts.integration_time_s,
        rows=facts.rows,
        columns=facts.columns,
    )


def _period_s(recording: Recording) -> float | None:
    """Between frames, as triggered; else by the frames' arrival, which is rough; None where neither tells."""
    if recording.camera_period_ticks is not None:
        return recording.camera_period_ticks / recording.clock_frequency_hz
    if recording.camera_trigger_ticks.size > 1:
        return float(np.median(np.diff(recording.camera_trigger_ticks))) / recording.clock_frequency_hz
    arrivals = recording.frame_host_time_s
    return None if arrivals is None or arrivals.size < _FEWEST else float(np.median(np.diff(arrivals)))


def require(measured: Conditions, found: Conditions, *, where: str) -> tuple[str, ...]:
    """Refuse frames for which a result does not hold.

    Parameters
    ----------
    measured
        For what the result holds.
    found
        What is said of the frames.
    where
        Their file.

    Returns
    -------
    What could not be compared, since one of both does not say it: one remark, or none.

    Raises
    ------
    ConditionError
        If they differ in serial number, model, kind of detector, readout mode, integration time or image size.
    """
    stated = (
        ("serial number", measured.serial_number, found.serial_number),
        ("model", measured.model, found.model),
        ("image size", _size(measured), _size(found)),
        ("integration time", _window(measured), _window(found)),
    )
    kinds = (
        ("detector", measured.camera_type, found.camera_type),
        ("readout mode", measured.readout_mode, found.readout_mode),
    )
    is_photon = measured.camera_type == "photon"
    for what, ours, theirs in (*kinds, *stated):
        if what == "integration time" and (not is_photon or same_window(measured, found)):
            continue
        if ours and theirs and ours != theirs:
            raise ConditionError(
                f"its {what} is {theirs}, the result was measured with {ours} and holds for that alone: measure this camera "
                "as it is set, or give its own result",
                where=where,
            )
    unsaid = [what for what, ours, theirs in (*kinds, *stated) if not (ours and theirs) and what != "model"]
    return _not_compared([what for what in unsaid if what != "integration time" or is_photon])


def _not_compared(unsaid: list[str]) -> tuple[str, ...]:
    if not unsaid:
        return ()
    *others, last = unsaid
    return (f"{', '.join(others)} and {last} were not compared" if others else f"{last} was not compared",)


def doubted_unit(measured: Conditions, interval_s: float | None) -> tuple[str, ...]:
    """What is to be said of a time between frames that differs so much from the measured one that its unit may be another.

    Parameters
    ----------
    measured
        For what the result holds.
    interval_s
        Median time between the frames to which it is applied; None for a single one.
    """
    period_s = measured.frame_period_s
    if period_s is None or interval_s is None or 1 / _OTHER_UNIT <= interval_s / period_s <= _OTHER_UNIT:
        return ()
    return (
        f"frames are {readable_time(interval_s)} apart by their stamps (median), those that were measured "
        f"{readable_time(period_s)}: is the unit of the stamps right?",
    )


def _size(one: Conditions) -> str:
    return f"{one.rows} x {one.columns}" if one.rows is not None and one.columns is not None else ""


def _window(one: Conditions) -> str:
    return "" if one.integration_time_s is None else f"{1e6 * one.integration_time_s:.3f} µs"


def same_window(one: Conditions, other: Conditions) -> bool:
    """Whether both state the integration time, and it is the same."""
    if one.integration_time_s is None or other.integration_time_s is None:
        return False
    return abs(one.integration_time_s - other.integration_time_s) <= SAME * one.integration_time_s
