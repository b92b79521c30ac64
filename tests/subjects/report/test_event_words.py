"""Words of a camera that runs free, in the place of those of a trigger."""

import pytest

from irtiming.report import event_words

LATE = ": by what edges are late the delay is too long"
GATES = "rig.toml states no latency of application gate, control gate and trigger path" + LATE
PATH = "rig.toml states no latency of trigger path" + LATE


@pytest.mark.parametrize(
    ("said", "words"),
    [(GATES, "application gate, control gate and camera input: "), (PATH, "latency of camera input: ")],
)
def test_a_late_strobe_makes_its_delay_too_short(said, words):
    """Oracle: the delay's definition; it counts from the strobe's edge, and what is stamped 100 us late leaves 100 us less.

    A trigger that comes late to the camera leaves 100 us more, and so do wheel edges that are stamped late.
    """
    told = event_words.text(said, "strobe")
    assert words in told
    assert told.endswith("by what the wheel's edges are late the delay is too long, by what the event's are too short")
    assert event_words.text(said, "trigger") == said
