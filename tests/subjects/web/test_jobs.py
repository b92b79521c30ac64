"""Work that the server owns."""

import signal
import subprocess
import sys

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


_HALF = """
import sys, time
from multiprocessing import Pipe
from irtiming.archive.whole_file import whole_file
from irtiming.web import work

def half(line, place):
    with whole_file(place) as part:
        part.write_text("half")
        print("here", flush=True)
        time.sleep(60)

work.function_of = lambda _: half
work.run(Pipe()[0], task="", order=sys.argv[1])
"""


def test_work_that_is_broken_off_leaves_nothing_half(tmp_path):
    """Oracle: an empty folder, and the exit status of SIGTERM."""
    with subprocess.Popen([sys.executable, "-c", _HALF, str(tmp_path / "a.csv")], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"here\n"
        process.send_signal(signal.SIGTERM)
        assert process.wait(30) == 143
    assert list(tmp_path.iterdir()) == []
