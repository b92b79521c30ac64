"""What recordings state of the camera's integration time."""

from collections.abc import Sequence

from irtiming.errors import EstimationError
from irtiming.records.reduced import ReducedRecording


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
