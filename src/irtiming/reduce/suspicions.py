"""What else is amiss with a recording that was refused: often the cause, where the refusal names what came of it.

An opening that is searched for in frames that moved, or that were counted wrongly, looks like none. So all frames are read once
more, and the run is looked at in parts, which takes neither a plateau nor an opening of a certain shape.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from irtiming.errors import IrTimingError
from irtiming.records.arrays import Array, Mask
from irtiming.records.choices import Choices
from irtiming.records.finding import Finding, perhaps_therefore
from irtiming.records.recording import Recording
from irtiming.records.rig import Rig
from irtiming.reduce import kernels, motion_filter, nonuniformity, steadiness
from irtiming.reduce.opening import sample_frames
from irtiming.reduce.wheel import frame_angles

_LIVELY = 0.6  # of the swing of the liveliest pixels
_LIVELIEST = 0.995


@contextmanager
def explained(recording: Recording, rig: Rig, *, choices: Choices) -> Iterator[None]:
    """A refusal within is raised with the doubts about the run.

    Parameters
    ----------
    recording, rig, choices
        As of `recipes.reduce`.

    Raises
    ------
    IrTimingError
        The refusal.
    """
    try:
        yield
    except IrTimingError as error:
        perhaps_therefore(error, of(recording, rig, choices=choices))
        raise


def of(recording: Recording, rig: Rig, *, choices: Choices) -> tuple[Finding, ...]:
    """Doubts about the run, by the light of its liveliest pixels; none where that cannot be decided.

    Parameters
    ----------
    recording, rig, choices
        As of `recipes.reduce`.
    """
    try:
        angles = frame_angles.of(recording, rig, reference_edge=choices.reference_edge)
        sample = sample_frames.look(recording, angles.angle_rad, correct=nonuniformity.correction(recording))
    except IrTimingError:
        return ()
    swing = sample.raw.std(axis=0, dtype=np.float32)
    lively = np.asarray(swing >= _LIVELY * np.quantile(swing, _LIVELIEST))
    unsteady = steadiness.findings(angles, rig, light_dn=_light(recording, lively))
    return (*unsteady, *motion_filter.findings(recording))


def _light(recording: Recording, area: Mask) -> Array:
    """Sum over the area in every frame, shape (n_frame,), DN."""
    light, bits = np.zeros(recording.frames.shape[0]), np.where(area, 0xFFFF, 0).astype(np.uint16)
    for first, frames in recording.frames.blocks():
        light[first : first + len(frames)] = kernels.sum_within(np.ascontiguousarray(frames), bits).sum(axis=1)
    return light
