"""What else is amiss with a recording that was refused: frames of the twin, as they are and of the triggers after their own."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.records.choices import Choices
from irtiming.reduce import suspicions
from irtiming.twin.rig import draw, simulate
from irtiming.twin.scene import paper_scene


@pytest.fixture(scope="module")
def rig():
    """A drawn rig of 48 x 64 pixels and 400 triggers."""
    scene = paper_scene(48, 64)
    return draw(replace(scene, trigger=replace(scene.trigger, n_triggers=400)), seed=3)


@pytest.fixture(scope="module")
def recording(rig):
    """What it records."""
    return simulate(rig.scene, seed=3, name="run")


@pytest.fixture(scope="module")
def renumbered(recording, frames_in_memory):
    """The same, but from frame 200 on each is that of the trigger after its own."""
    frames = np.concatenate([block.copy() for _, block in recording.frames.blocks()])
    frames[200:-1] = frames[201:].copy()
    return replace(recording, frames=frames_in_memory(frames))


def test_nothing_is_amiss_with_a_sound_recording(rig, recording):
    """Oracle: nothing was done to it."""
    assert suspicions.of(recording, rig.measured, choices=Choices()) == ()


def test_frames_of_other_triggers_are_a_doubt_without_any_opening(rig, renumbered):
    """Oracle: from the middle on they are those of the trigger after their own."""
    (doubt,) = suspicions.of(renumbered, rig.measured, choices=Choices())
    assert (doubt.code, doubt.severity, doubt.recording) == ("frames-renumbered", "doubt", "run")


def test_nothing_can_be_said_without_the_wheels_angles(rig, recording):
    """Oracle: by hand; two timestamps tell no angle."""
    blind = replace(recording, control_slot_ticks=recording.control_slot_ticks[:2])
    assert suspicions.of(blind, rig.measured, choices=Choices()) == ()


def test_a_refusal_is_raised_with_what_is_amiss_and_anything_else_as_it_is(rig, recording, renumbered):
    """Oracle: the doubt above; a sound recording adds nothing, and an error that is not ours is left alone."""
    refusal = ReductionError("no opening")
    with pytest.raises(ReductionError) as caught, suspicions.explained(renumbered, rig.measured, choices=Choices()):
        raise refusal
    assert caught.value is refusal
    (note,) = caught.value.__notes__
    assert note.startswith("and perhaps therefore: ")
    with pytest.raises(ReductionError) as caught, suspicions.explained(recording, rig.measured, choices=Choices()):
        raise ReductionError("no opening")
    assert not getattr(caught.value, "__notes__", [])
    with pytest.raises(KeyError) as caught, suspicions.explained(renumbered, rig.measured, choices=Choices()):
        raise KeyError("ours")
    assert not getattr(caught.value, "__notes__", [])


def test_light_is_summed_over_the_area_in_every_frame(recording):
    """Oracle: NumPy's own sum over the same pixels."""
    area = np.zeros((48, 64), bool)
    area[5:20, 7:9] = area[30, 40] = True
    frames = np.concatenate([block.copy() for _, block in recording.frames.blocks()])
    assert suspicions._light(recording, area).tolist() == frames[:, area].sum(axis=1).tolist()
