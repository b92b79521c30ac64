"""Frames that are kept, against the frames that are made anew every time."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.twin import rig as twin
from irtiming.twin.in_camera import InCamera
from irtiming.twin.kept_frames import KeptFrames, kept
from irtiming.twin.scene import microbolometer_scene

SCENE = microbolometer_scene(24, 32)
FILTERED = replace(SCENE, in_camera=InCamera(filter_share=0.3))
WANTED = [40, 3, 3, 17]


def _whole(stack):
    return np.concatenate([block.copy() for _, block in stack.blocks()])


@pytest.mark.parametrize("scene", [SCENE, FILTERED], ids=["plain", "filtered"])
def test_kept_frames_are_those_that_are_made(scene):
    """Oracle: the stack below, which makes each frame anew; before a whole pass, in it and after it."""
    frames = twin.simulate(scene, seed=3).frames
    assert isinstance(frames, KeptFrames)
    made = frames._made
    truth = _whole(made)
    assert np.array_equal(frames.pick(WANTED), truth[WANTED])
    for _ in range(2):
        assert np.array_equal(_whole(frames), truth)
    for _, block in frames.blocks():
        block[...] = 0  # a block is its reader's own
    assert np.array_equal(_whole(frames), truth)
    assert np.array_equal(frames.pick(WANTED), truth[WANTED])
    with pytest.raises(ReductionError, match="asked for"):
        frames.pick([len(truth)])


def test_large_recordings_are_not_kept():
    """Oracle: by hand; 2000 frames of 512 x 640 pixels are 1.3 GB."""

    class Large:
        shape = (2000, 512, 640)

    large = Large()
    assert kept(large, one_by_one=True) is large
