"""Trigger and wheel angle of every frame of a recording."""

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.arrays import Array, Ticks
from irtiming.records.choices import ReferenceEdge
from irtiming.records.recording import Recording
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.wheel_track import WheelTrack
from irtiming.reduce import remarks
from irtiming.reduce.wheel import nominal_angles, wheel_angles


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FrameAngles:
    """What the timestamps of a recording tell of its frames.

    ``learned`` and ``equal`` are the wheel's tracks with learned and with equal slots. Shapes (n_frame,): ``trigger_ticks``,
    nominal; ``angle_rad`` of the wheel at the trigger plus the set delay, nan where no control slots were recorded.
    """

    recording: Recording
    learned: WheelTrack
    equal: WheelTrack
    trigger_ticks: Ticks
    angle_rad: Array

    @property
    def time_s(self) -> Array:
        """Time of the triggers after the first, shape (n_frame,), s."""
        return np.asarray((self.trigger_ticks - self.trigger_ticks[0]) / self.recording.clock_frequency_hz)

    def reduced(self, segment: Ticks, **found: Any) -> ReducedRecording:
        """The recording, reduced to what was found in its frames.

        Parameters
        ----------
        segment
            Shape (n_frame,); number of the stretch of each frame, -1 for frames that are not kept.
        found
            Other fields of the record.
        """
        one, kept = self.recording, segment >= 0
        read = remarks.of_input(one, self.learned)
        return ReducedRecording(
            name=one.name,
            source=one.source,
            sha256=one.sha256,
            camera_type=one.camera_type,
            readout_mode=one.readout_mode,
            n_frames=one.frames.shape[0],
            trigger_ticks=self.trigger_ticks[kept],
            frame_index=np.flatnonzero(kept),
            segment=segment[kept],
            samples_per_turn=nominal_angles.samples_per_turn(one),
            track=self.learned,
            equal_track=self.equal,
            integration_time_s=one.integration_time_s,
            trigger_delay_time_set_s=one.trigger_delay_time_set_s,
            rotation_speed_hz=one.rotation_speed_hz,
            blackbody_temperature_k=one.blackbody_temperature_k,
            frame_period_s=one.frame_period_s,
            bit_depth=one.bit_depth,
            camera=one.camera,
            settings=one.settings,
            start_time=one.start_time,
            is_simulated=one.is_simulated,
            events=one.events,
            **(found | {"findings": (*read, *found["findings"])}),
        )


def of(recording: Recording, rig: Rig, *, reference_edge: ReferenceEdge) -> FrameAngles:
    """Wheel angles of the frames of a recording.

    Parameters
    ----------
    recording, rig
        Its timestamps, and the wheel as measured by its owner.
    reference_edge
        Which of the two alternating application edges is the angle zero.

    Raises
    ------
    ReductionError
        If the timestamps do not tell.
    """
    wheel_angles.refuse_lost_timestamps(recording)
    learned, equal = wheel_angles.both_tracks(recording, rig, reference_edge=reference_edge)
    triggers = wheel_angles.frame_trigger_ticks(recording)
    return FrameAngles(
        recording=recording,
        learned=learned,
        equal=equal,
        trigger_ticks=triggers,
        angle_rad=wheel_angle_rad(0.0, learned, at_ticks=triggers, set_s=recording.trigger_delay_time_set_s),
    )
