"""Checks of the ticks at their limits: what is just right says nothing, one tick or edge more is told."""

import numpy as np
import pytest

from irtiming.archive import layout
from irtiming.archive.tick_checks import check_ticks

SLOTS = 1000 + 100 * np.arange(1000, dtype=np.int64)
EDGES = 1030 + 5000 * np.arange(20, dtype=np.int64)
TRIGGERS = 2000 + 700 * np.arange(100, dtype=np.int64)
SOUND = {
    layout.CLOCK_FREQUENCY: 30_000.0,
    layout.ROTATION_SPEED: 3.0,
    layout.CAMERA_TRIGGER: TRIGGERS,
    layout.CONTROL_SLOT: SLOTS,
    layout.APPLICATION_SLOT: EDGES,
    layout.CAMERA_PERIOD: 700,
    layout.WHEEL_PERIOD: 10_000,
    layout.FRAME_NUMBER: np.arange(100),
}


def _told(**changed):
    """Severity, place and text of what is found where fields are changed."""
    found = check_ticks(SOUND | {getattr(layout, name): value for name, value in changed.items()})
    return [(one.severity, one.where, one.what) for one in found]


def test_sound_ticks_say_nothing():
    """Oracle: by hand; 3 Hz at 30 kHz are 10 000 ticks a turn, 100 slots, two edges."""
    assert _told() == []


@pytest.mark.parametrize(
    ("window_s", "changed", "is_told"),
    [
        (700 / 30_000, {}, False),
        (0.0234, {}, True),
        (0.0234, {"CAMERA_PERIOD": None}, True),
        (0.0234, {"CAMERA_TYPE": "microbolometer"}, False),
        (0.0234, {"CAMERA_PERIOD": None, "CAMERA_TRIGGER": None, "FRAME_NUMBER": None}, False),
    ],
)
def test_a_window_longer_than_the_frame_period_is_told(window_s, changed, is_told):
    """Oracle: by hand; 700 ticks of 30 kHz are 23.333 ms, the window of a camera may just fill them; a bolometer has none."""
    told = _told(**({"CAMERA_TYPE": "photon", "INTEGRATION_TIME": window_s} | changed))
    what = "= 23.4 ms, but frames follow each other by 23.3333 ms: no camera integrates into the next frame"
    assert told == ([("error", layout.INTEGRATION_TIME.path, what)] if is_told else [])


@pytest.mark.parametrize(
    ("first", "last", "n_outside"),
    [(EDGES[0], EDGES[-1], 0), (EDGES[0] - 1, EDGES[-1], 1), (EDGES[0], EDGES[-1] + 1, 1), (EDGES[0] - 1, EDGES[-1] + 1, 2)],
)  # fmt: skip
def test_a_trigger_at_the_first_or_last_edge_is_not_outside(first, last, n_outside):
    """Oracle: by hand; the edges end there, and one tick beyond there are none."""
    triggers = np.array([first, 20_000, 40_000, last])
    told = _told(CAMERA_TRIGGER=triggers, CAMERA_PERIOD=None, FRAME_NUMBER=None)
    assert [what for _, _, what in told] == (
        [f"has {n_outside} of 4 triggers outside the ticks of {layout.APPLICATION_SLOT.path}"] if n_outside else []
    )
    assert all(severity == "warning" for severity, _, _ in told)


def test_application_slots_at_one_tick_are_told():
    """Oracle: by hand; a wheel that passes its gate at one tick twenty times turns at no speed."""
    told = _told(APPLICATION_SLOT=np.full(20, EDGES[9]), CONTROL_SLOT=np.full(1000, SLOTS[400]))
    assert (
        "error",
        layout.APPLICATION_SLOT.path,
        "repeats the tick before in most of its entries: no wheel turns so",
    ) in told


def test_triggers_that_are_all_outside_are_an_error():
    """Oracle: by hand; no frame has an angle then."""
    told = _told(CAMERA_TRIGGER=SLOTS[-1] + TRIGGERS)
    assert ("error", layout.CAMERA_TRIGGER.path) in [(severity, where) for severity, where, _ in told]


@pytest.mark.parametrize(("off", "n_told"), [(-1, 0), (1, 0), (2, 1), (-2, 1)])
def test_an_interval_may_be_off_by_one_tick(off, n_told):
    """Oracle: by hand; a period that is no whole number of ticks makes intervals one tick longer or shorter."""
    triggers = TRIGGERS.copy()
    triggers[40:] += off
    told = _told(CAMERA_TRIGGER=triggers)
    assert len(told) == n_told
    if n_told:
        assert told[0][2] == (
            f"has 1 interval other than camera_period = 700 ticks, the first of {700 + off} ticks after trigger 39"
        )


@pytest.mark.parametrize(("hz", "n_told"), [(3.0 / 1.0199, 0), (3.0 / 1.0201, 1), (3.0 / 0.9801, 0), (3.0 / 0.9799, 1)])
def test_speeds_may_differ_by_two_per_cent(hz, n_told):
    """Oracle: by hand; the edges pass at 3 Hz, and so does the wheel's period."""
    told = _told(ROTATION_SPEED=hz)
    assert [(severity, where) for severity, where, _ in told] == (
        [("error", layout.ROTATION_SPEED.path), ("warning", layout.WHEEL_PERIOD.path)]
        if n_told
        else [("doubt", layout.ROTATION_SPEED.path)]
    )


@pytest.mark.parametrize(("hz", "n_told"), [(3.0 / 1.0019, 0), (3.0 / 1.0021, 1), (3.0 / 0.9981, 0), (3.0 / 0.9979, 1)])
def test_a_speed_two_per_mille_off_is_a_doubt(hz, n_told):
    """Oracle: by hand; the edges pass at 3 Hz, which a chopper that is locked keeps better."""
    assert [severity for severity, *_ in _told(ROTATION_SPEED=hz)] == ["doubt"] * n_told


@pytest.mark.parametrize(("off", "severity"), [(2, "warning"), (14_001, "warning"), (14_002, "doubt")])
def test_intervals_that_no_two_crystals_make_are_a_doubt(off, severity):
    """Oracle: by hand; 200 ppm of 70 million ticks and one tick more are 14 001."""
    triggers = 100_000 * TRIGGERS
    triggers[40:] += off
    told = _told(CAMERA_TRIGGER=triggers, CAMERA_PERIOD=70_000_000, APPLICATION_SLOT=None, CONTROL_SLOT=None)
    assert [one for one, *_ in told] == [severity]


@pytest.mark.parametrize(
    ("edges", "says"),
    [
        (np.delete(EDGES, 7), "has 1 missing edge, the first after entry 6"),
        (np.insert(EDGES, 8, EDGES[7] + 2400), "has 1 doubled or spurious edge, the first after entry 7"),
        (np.insert(EDGES, 8, EDGES[7] + 2500), ""),
    ],
)
def test_half_turns_of_another_length_are_told(edges, says):
    """Oracle: by hand; an interval of two half turns, one of less than half of one, and one of just half."""
    told = [what for _, where, what in _told(APPLICATION_SLOT=edges) if where == layout.APPLICATION_SLOT.path]
    assert told == ([says] if says else [])


def test_a_turn_with_another_number_of_slots_is_told():
    """Oracle: by hand; slot 330 lies in the fourth turn after the first edge."""
    assert [what for _, _, what in _told(CONTROL_SLOT=np.delete(SLOTS, 330))] == [
        "has 1 of 9 turns without the usual 100 slots, the first is turn 3 with 99"
    ]


@pytest.mark.parametrize(
    ("numbers", "says"),
    [
        (np.delete(np.arange(100), [40, 41]), "leaves out 2 of 100 triggers, the first is 40: lost frames"),
        (np.arange(2, 100), "leaves out 2 of 100 triggers, the first is 0: lost frames"),
        (np.arange(98), "leaves out 2 of 100 triggers, the first is 98: lost frames"),
    ],
)
def test_lost_frames_are_told_where_they_begin(numbers, says):
    """Oracle: by hand; lost in the middle, before the first and after the last frame."""
    assert [what for _, _, what in _told(FRAME_NUMBER=numbers)] == [says]


@pytest.mark.parametrize(("n_edges", "n_turns"), [(2, 0), (3, 1), (5, 2)])
def test_a_single_whole_turn_tells_whether_slots_are_there(n_edges, n_turns):
    """Oracle: by hand; two slots pass in a turn, so three of them bound one; no control slot lies between any."""
    told = _told(APPLICATION_SLOT=EDGES[:n_edges], CONTROL_SLOT=SLOTS + 10**6, WHEEL_PERIOD=None, CAMERA_TRIGGER=None)
    absent = [where for severity, where, what in told if severity == "error" and "no ticks between" in what]
    assert absent == ([layout.CONTROL_SLOT.path] if n_turns else [])


def test_more_frames_than_triggers_are_no_lost_ones():
    """Oracle: by hand; 101 frames of 100 triggers lack none."""
    told = _told(FRAME_NUMBER=np.arange(101))
    assert [what for _, _, what in told if "lost frames" in what] == []
