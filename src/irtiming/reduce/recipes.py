"""Which recipe reduces a recording: pixel sums where all pixels are exposed together and follow at once, else row sums."""

from collections.abc import Callable

from irtiming.records.choices import Choices
from irtiming.records.recording import Recording
from irtiming.records.reduced import Opening, ReducedRecording
from irtiming.records.rig import Rig
from irtiming.reduce import cooled, microbolometer


def reduce(
    recording: Recording, rig: Rig, *, choices: Choices, progress: Callable[[int], None] = lambda n: None,
    before: Opening | None = None,
) -> ReducedRecording:  # fmt: skip
    """One recording as sums over the wheel angle.

    Parameters
    ----------
    recording
        Its ``camera_type`` and ``readout_mode`` choose.
    rig
        As measured by its owner.
    choices, progress
        What a person decided instead of the automatic choice; called with the number of frames done so far.
    before
        Opening of an earlier recording of the same camera, taken over where it is still in place.

    Raises
    ------
    ReductionError
        If the recording cannot be reduced; the message says why.
    """
    is_pixel_sum = (recording.camera_type, recording.readout_mode) == ("photon", "snapshot")
    recipe = cooled.reduce if is_pixel_sum else microbolometer.reduce
    return recipe(recording, rig, choices=choices, progress=progress, before=before)
