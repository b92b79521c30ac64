"""One slot table for all recordings of a rig: their wheel is the same, only its wander, ripple and speed differ."""

from collections.abc import Sequence

from irtiming.records.wheel_calibration import WheelCalibration
from irtiming.records.wheel_track import WheelTrack
from irtiming.reduce.wheel.slot_table import SlotTable
from irtiming.reduce.wheel.slots_on_track import with_common_zero, with_slots
from irtiming.reduce.wheel.wheel_calibration import WheelRun, calibrate, stands_on


def pool(
    runs: Sequence[WheelRun], *, before: WheelCalibration | None = None
) -> tuple[list[WheelTrack], WheelCalibration | None]:
    """Tracks with the slots that all recordings tell together, and these slots.

    A table learned from one recording carries that recording's wander into its delays. The common one carries less, and the
    same for all, so that it cancels in relative delays; so does the angle between the gates. At several speeds it is free of
    the ripple: the angle at a slot's edge is the slot's own angle, however the wheel got there.

    Parameters
    ----------
    runs
        Of one wheel, each track with its own learned table or with equal slots.
    before
        An earlier calibration of the same wheel; its recordings count once.

    Returns
    -------
    One track per run, and the calibration; None, and the tracks as they were, where nothing was learned. A track whose slots
    contradict those of most turns keeps its own, and the calibration warns of it.

    Raises
    ------
    ReductionError
        If the earlier calibration is of a wheel with another number of slots.
    """
    if before is None and not any(run.track.has_learned_slots for run in runs):
        return [run.track for run in runs], None
    calibration = calibrate(runs, before=before)
    slots = SlotTable(deviation_rad=calibration.slot_deviation_rad, order_variance_rad2=calibration.order_variance_rad2)
    on_table = [stands_on(run.track, calibration.speeds) for run in runs]
    common = iter(
        with_common_zero([with_slots(run.track, slots) for run, is_on in zip(runs, on_table, strict=True) if is_on])
    )
    return [next(common) if is_on else run.track for run, is_on in zip(runs, on_table, strict=True)], calibration
