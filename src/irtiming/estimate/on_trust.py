"""What recordings cannot check: a mistake in any of it moves the result, and nothing in the frames would tell."""

from collections.abc import Sequence

from irtiming.estimate.rig_errors import speeds_differ
from irtiming.records.finding import Finding
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Latency, Rig

_OF_EVENT = {
    "trigger": "that the trigger is stamped at the edge that the camera takes, and by the counter that stamps the gates",
    "strobe": "which edge of the strobe is stamped",
    "stamp": "that the stamps are as the camera gave them",
    "arrival": "that the program that stamped the arrivals, and what else that computer does, stay the same",
}


def of(recordings: Sequence[ReducedRecording], *, rig: Rig, is_length_checked: bool = False) -> tuple[Finding, ...]:
    """One finding that lists it, so that a person can look at each once more.

    At one wheel speed an angle that is wrong is a delay; several speeds tell the two apart, so that angles are then checked.

    Parameters
    ----------
    recordings
        Their wheel speeds count.
    rig
        As measured by its owner.
    is_length_checked
        Whether the frames alone tell how long the camera integrates, about as well as what is stated.
    """
    several = speeds_differ([one.track.angular_frequency_rad_per_s for one in recordings])
    late = rig.latency or Latency()
    stated = [one for one in (late.application_gate_s, late.control_gate_s, late.trigger_s) if one is not None]
    has_window = recordings[0].camera_type == "photon" and recordings[0].integration_time_s is not None
    taken = {
        "[mask] centre_angle_deg within the roll of the camera": not several,
        "[beams] whole_slots_between (a height_mm by a ruler would check it)": not several
        and rig.light_gates.height_m is None,
        "[beams] half_separation_mm, height_difference_mm and lateral_offset_mm": not several,
        "count_time": has_window and not is_length_checked,
        "[latency]": bool(stated),
        "clock_frequency, where rotation_speed is wrong by as much": True,
        "trigger_delay_time_set": recordings[0].events is None,
        _OF_EVENT["trigger" if recordings[0].events is None else recordings[0].events.kind]: True,
        "that the control slots are regular, which fewer than nine turns do not tell": not all(
            one.track.has_learned_slots for one in recordings
        ),
        "that the control gate stamps the edge of each slot that is in register with the cutouts": not several,
    }
    return (
        Finding(
            code="taken-on-trust",
            severity="info",
            what=f"nothing in {'these recordings' if len(recordings) > 1 else 'this recording'} checks "
            f"{'; '.join(what for what, is_taken in taken.items() if is_taken)}",
            cure="look at each once more" if several else "look at each once more; several wheel speeds check angles",
        ),
    )
