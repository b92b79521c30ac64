"""A camera that runs free: the event of each frame placed in counter time, so that all that follows is as for triggers."""

from collections.abc import Iterable
from dataclasses import replace

from irtiming.records.frame_events import FrameEvents
from irtiming.records.recording import Recording
from irtiming.records.rig import Latency, Measured, Rig
from irtiming.reduce.events import stamps, strobe


def placed(recording: Recording) -> Recording:
    """The same recording with one event per frame in the place of the trigger that made it.

    A triggered recording, and one that was placed before, comes back as it is.

    Parameters
    ----------
    recording
        Its frames are not read.

    Raises
    ------
    ReductionError
        If the events of its frames cannot be determined.
    """
    if recording.frame_event == "trigger" or recording.events is not None:
        return recording
    found = (strobe if recording.frame_event == "strobe" else stamps).place(recording)
    findings = tuple(replace(one, recording=recording.name) for one in found.events.findings)
    return replace(
        recording,
        camera_trigger_ticks=found.ticks,
        frame_number=found.frame_number,
        camera_period_ticks=None,
        events=replace(found.events, findings=findings),
        findings=(*recording.findings, *findings),
    )


def rig_for(rig: Rig, events: Iterable[FrameEvents | None]) -> Rig:
    """The rig with what lies between event and counter in the place of the way of the trigger.

    A trigger comes to the camera later than it is stamped; a strobe is stamped later than it leaves the camera. A stamp has no
    such way: its clock is known against the counter within bounds, which all recordings are taken to share.

    Parameters
    ----------
    rig
        As measured by its owner.
    events
        Of the recordings; None where they are triggers.
    """
    found = [one for one in events if one is not None]
    if not found:
        return rig
    if found[0].kind == "strobe":
        stated = None if rig.latency is None else rig.latency.camera_input_s
        way = None if stated is None else Measured(-stated.value, stated.standard_uncertainty)
        return rig if rig.latency is None else replace(rig, latency=replace(rig.latency, trigger_s=way))
    clocks = Measured(0.0, max(one.u_clock_s for one in found))
    return replace(rig, latency=replace(rig.latency or Latency(), trigger_s=clocks))
