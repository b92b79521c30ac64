"""Fields against each other, by hand: what is just right says nothing, one more or less is told."""

import numpy as np
import pytest

from irtiming.archive import layout
from irtiming.archive.consistency import check, check_temperatures

TRIGGERS = 1000 + 700 * np.arange(20, dtype=np.int64)
SOUND = {
    layout.ENDING: layout.COMPLETE,
    layout.FRAMES: (20, 8, 10),
    layout.FRAME_NUMBER: np.arange(20),
    layout.CAMERA_TRIGGER: TRIGGERS,
    layout.CONTROL_SLOT: 100 * np.arange(300, dtype=np.int64),
    layout.REFERENCE_LOW: (10, 8, 10),
    layout.REFERENCE_HIGH: (10, 8, 10),
}


def _told(**changed):
    """Severity, field and text of what is found where fields are changed."""
    found = check(SOUND | {getattr(layout, name): value for name, value in changed.items()})
    return [(one.severity, one.where, one.what) for one in found]


def _with(values, place, value):
    changed = np.array(values)
    changed[place] = value
    return changed


def test_sound_fields_say_nothing():
    """Oracle: by hand; and fields that are not there are left out."""
    assert _told() == []
    assert check({}) == []
    assert _told(FRAME_NUMBER=None) == []


@pytest.mark.parametrize(
    ("ending", "severity"),
    [(f"{layout.NOT_TRUSTED}: a reason", "error"), ("stopped by Ctrl-C", "warning"), (None, None)],
)
def test_an_ending_other_than_complete_is_told(ending, severity):
    """Oracle: by hand; frames that may belong to other triggers are an error, fewer of them a warning."""
    assert [one[:2] for one in _told(ENDING=ending)] == ([(severity, layout.ENDING.path)] if severity else [])


@pytest.mark.parametrize(
    ("name", "ticks", "severity", "what"),
    [
        ("CONTROL_SLOT", _with(SOUND[layout.CONTROL_SLOT], 5, 399), "error", "goes back at entry 5: 399 after 400"),
        ("CONTROL_SLOT", _with(SOUND[layout.CONTROL_SLOT], 0, 101), "error", "goes back at entry 1: 100 after 101"),
        ("CONTROL_SLOT", _with(SOUND[layout.CONTROL_SLOT], 5, 400), "warning", "has 1 repeated tick, the first 400 at entry 5"),
        ("CONTROL_SLOT", _with(SOUND[layout.CONTROL_SLOT], 1, 0), "warning", "has 1 repeated tick, the first 0 at entry 1"),
        ("CAMERA_TRIGGER", _with(TRIGGERS, 1, 1000), "error", "has 1 repeated tick, the first 1000 at entry 1"),
        ("CAMERA_TRIGGER", _with(TRIGGERS, 2, 1699), "error", "goes back at entry 2: 1699 after 1700"),
    ],
)  # fmt: skip
def test_ticks_that_go_back_or_stand_are_told(name, ticks, severity, what):
    """Oracle: by hand; from the first entry on."""
    assert _told(**{name: ticks}) == [(severity, getattr(layout, name).path, what)]


@pytest.mark.parametrize("n", [0, 1])
def test_a_single_tick_cannot_go_back(n):
    """Oracle: by hand; nor can none."""
    assert _told(CONTROL_SLOT=np.zeros(n, np.int64)) == []


@pytest.mark.parametrize(
    ("numbers", "what"),
    [
        (np.arange(19), "has 19 entries for 20 frames"),
        (_with(np.arange(20), 7, 6), "is 6 at frame 7 after 6"),
        (_with(np.arange(20), 1, 0), "is 0 at frame 1 after 0"),
        (np.arange(20) - 1, "runs from -1 to 18 for 20 triggers"),
        (np.arange(20) + 1, "runs from 1 to 20 for 20 triggers"),
    ],
)
def test_numbers_that_are_no_triggers_are_told(numbers, what):
    """Oracle: by hand; 20 triggers are 0 to 19, each for one frame at most."""
    assert _told(FRAME_NUMBER=numbers) == [("error", layout.FRAME_NUMBER.path, what)]


@pytest.mark.parametrize(("n_triggers", "severity"), [(19, "error"), (20, None), (21, "warning")])
def test_frames_without_numbers_belong_to_as_many_triggers(n_triggers, severity):
    """Oracle: by hand; one trigger too few, as many, one too many."""
    told = _told(FRAME_NUMBER=None, CAMERA_TRIGGER=700 * np.arange(n_triggers))
    assert [one[:2] for one in told] == ([(severity, layout.FRAMES.path)] if severity else [])


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (None, (10, 8, 10), [("error", "REFERENCE_LOW", "is missing while high is there")]),
        ((10, 8, 10), None, [("error", "REFERENCE_HIGH", "is missing while low is there")]),
        (None, None, []),
        ((10, 9, 10), (10, 8, 10), [("error", "REFERENCE_LOW", f"has frames of 9 x 10 pixels, {layout.FRAMES.path} of 8 x 10")]),
        ((10, 8, 10), (1, 8, 10), [("warning", "REFERENCE_HIGH", "has a single frame")]),
        ((2, 8, 10), (2, 8, 10), []),
    ],
)  # fmt: skip
def test_references_are_a_pair_of_the_frames_size(low, high, expected):
    """Oracle: by hand; two frames are the fewest whose noise is known."""
    assert _told(REFERENCE_LOW=low, REFERENCE_HIGH=high) == [
        (severity, getattr(layout, name).path, what) for severity, name, what in expected
    ]


@pytest.mark.parametrize(
    ("low_k", "high_k", "n_told"), [(290.0, 300.0, 0), (300.0, 300.0, 1), (300.1, 300.0, 1), (None, 300.0, 0), (300.0, None, 0)]
)  # fmt: skip
def test_the_low_reference_is_the_colder_one(low_k, high_k, n_told):
    """Oracle: by hand; two references at one temperature tell no gain, so they are refused like swapped ones."""
    found = check_temperatures({layout.REFERENCE_LOW: low_k, layout.REFERENCE_HIGH: high_k})
    assert [one.severity for one in found] == ["error"] * n_told
