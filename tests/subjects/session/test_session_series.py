"""Whoever attends a series, and what the live analysis hears of it."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from irtiming.acquire.run_order import ENOUGH, INTERRUPTED
from irtiming.archive.live.recording import COMPLETE
from irtiming.session.live_estimate import LiveEstimate
from irtiming.session.series import LiveAttendant

PLAN = SimpleNamespace(stop=SimpleNamespace(uncertainty_s=(("trigger_delay", 1e-6),)))
ON = {"made": 1, "total": 2, "lost": 0, "waiting": 0}


class _Live:
    """Writes down what it hears, and knows what it is told to know."""

    def __init__(self):
        self.heard, self.latest = [], None

    def begins(self):
        self.heard.append("begins")

    def grows(self, path, frames):
        self.heard.append((path.name, frames))

    def keep(self, path):
        self.heard.append(f"keep {path.name}")

    def learn(self, u_s):
        self.latest = LiveEstimate(frames=1, values={}, uncertainties={"trigger_delay": u_s})


class _Attendant(LiveAttendant):
    def __init__(self, live):
        super().__init__(PLAN, live)
        self.learned = []

    def learns(self, estimate):
        self.learned.append(estimate)


def test_the_live_analysis_hears_of_every_run_and_the_attendant_of_every_new_estimate():
    """Oracle: by hand; the same estimate is told once, and only a wish that is reached is enough."""
    live = _Live()
    attendant = _Attendant(live)
    attendant.begins(None, number=1, path=Path("one.nxs"))
    attendant.goes_on(frames=5, **ON)
    live.learn(2e-6)
    attendant.goes_on(frames=6, **ON)
    attendant.goes_on(frames=7, **ON)
    assert not attendant.is_enough()
    live.learn(1e-6)
    attendant.goes_on(frames=8, **ON)
    assert attendant.is_enough()
    assert live.heard == ["begins", ("one.nxs", 5), ("one.nxs", 6), ("one.nxs", 7), ("one.nxs", 8)]
    assert [each.uncertainties["trigger_delay"] for each in attendant.learned] == [2e-6, 1e-6]


@pytest.mark.parametrize(("ending", "kept"), [(COMPLETE, True), (ENOUGH, True), (INTERRUPTED, False), ("odd", False)])
def test_only_recordings_that_are_good_go_into_the_estimate(ending, kept):
    """Oracle: by hand."""
    live = _Live()
    _Attendant(live).ended(SimpleNamespace(ending=ending, path=Path("one.nxs")))
    assert live.heard == (["keep one.nxs"] if kept else [])


def test_without_a_rig_there_is_nothing_to_hear_and_never_enough():
    """Oracle: by hand."""
    attendant = _Attendant(None)
    attendant.begins(None, number=1, path=Path("one.nxs"))
    attendant.goes_on(frames=5, **ON)
    attendant.ended(SimpleNamespace(ending=COMPLETE, path=Path("one.nxs")))
    assert not attendant.is_enough()
    assert attendant.learned == []
