"""What recordings state of the camera's integration time, and where the search for it begins."""

from collections.abc import Sequence

from irtiming.errors import EstimationError
from irtiming.physics.wheel import TURN
from irtiming.records.reduced import ReducedRecording
from irtiming.records.wheel_geometry import WheelModel


def common(recordings: Sequence[ReducedRecording]) -> float | None:
    """What all recordings state, s; None where they do not.

    Parameters
    ----------
    recordings
        Of one camera.

    Raises
    ------
    EstimationError
        If they differ.
    """
    times = {recording.integration_time_s for recording in recordings}
    if len(times) > 1:
        stated = ", ".join(f"{r.name}: {r.integration_time_s}" for r in recordings)
        raise EstimationError(
            f"the recordings differ in integration time (count_time; {stated} s), which must be one for all; analyse them apart"
        )
    return times.pop()


def starts_s(reduced: ReducedRecording, wheel: WheelModel) -> tuple[float, float]:
    """Where the search for one begins of which nothing is stated: one sample, and half of an edge's way over the opening, s.

    Longer windows have minima of their own that a search from a short one does not reach, and the other way round.

    Parameters
    ----------
    reduced
        Of a photon camera.
    wheel
        As drawn by rig.toml.
    """
    sample_rad, half_rad = TURN / reduced.samples_per_turn, wheel.opening_angle_rad / 2
    return sample_rad / reduced.track.angular_frequency_rad_per_s, half_rad / reduced.track.angular_frequency_rad_per_s
