"""Work that the server owns."""

import pytest

from irtiming.errors import InstrumentError
from irtiming.web.jobs import Job, Jobs
from irtiming.web.work import News


def test_two_windows_never_fight_for_a_rig(monkeypatch):
    """Oracle: the rule; the second recording is refused while the first goes on, and may begin after it."""
    monkeypatch.setattr(Job, "start", lambda *_: None)
    jobs = Jobs()
    first = jobs.start("recording", "the recording into monday", task="recording:record", order=None)
    with pytest.raises(InstrumentError, match="the recording into monday goes on, perhaps from another window"):
        jobs.start("recording", "another", task="recording:record", order=None)
    assert jobs.running("recording") is first
    first._learn(News(kind="done", value={}))
    second = jobs.start("recording", "another", task="recording:record", order=None)
    assert jobs.running("recording") is second


def test_what_a_job_keeps_is_bounded(monkeypatch):
    """Oracle: counting; neither lines nor jobs that are over are kept without end."""
    monkeypatch.setattr(Job, "start", lambda *_: None)
    jobs = Jobs()
    for number in range(200):
        job = jobs.start("check", f"check {number}", task="files:check", order=None)
        for line in range(10):
            job._learn(News(kind="says", value=f"line {line}" * 10))
        job._learn(News(kind="failed", value="so it is"))
    assert len(list(jobs)) <= 41
    for line in range(1000):
        job._learn(News(kind="says", value=str(line)))
    assert (len(job.lines), job.lines[-1]) == (300, "999")
