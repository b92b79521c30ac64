"""Which recipe reduces a recording: pixel sums where all pixels are read at once and do not lag, else row sums."""

from collections.abc import Callable

from irtiming.errors import ReductionError
from irtiming.records.choices import Choices
from irtiming.records.recording import Recording
from irtiming.records.reduced import Opening, ReducedRecording
from irtiming.records.rig import Rig
from irtiming.reduce import pixel_sums, row_sums

_FEWEST_FRAMES = 100


def reduce(
    recording: Recording, rig: Rig, *, choices: Choices, progress: Callable[[int], None] = lambda n: None,
    before: Opening | None = None,
) -> ReducedRecording:  # fmt: skip
    """Sums of every frame that shows the scene, the wheel's track, and the contrast of each pixel.

    Parameters
    ----------
    recording
        Its frames are read once in a stream, after a look at some of them.
    rig
        As measured by its owner.
    choices
        What a person decided instead of the automatic choice.
    progress
        Is given the number of frames done so far.
    before
        Opening of an earlier recording of the same camera, taken over where it is still in place.

    Raises
    ------
    ReductionError
        If the recording cannot be reduced; the message says why.
    """
    if recording.frames.shape[0] < _FEWEST_FRAMES:
        raise ReductionError(
            f"{recording.name}: {recording.frames.shape[0]} frames, at least {_FEWEST_FRAMES} are needed; record a whole "
            "measurement (irtiming plan)"
        )
    is_instant = (recording.camera_type, recording.readout_mode) == ("photon", "snapshot")
    recipe = pixel_sums if is_instant else row_sums
    return recipe.reduce(recording, rig, choices=choices, progress=progress, before=before)
