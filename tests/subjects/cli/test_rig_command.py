"""`irtiming rig` as typed: a served rig, its files, and words to it."""

import json
import subprocess
import sys

import pytest

from irtiming.archive.rig_file import read_rig
from irtiming.archive.series_file import read_series


def _address(worker_id):
    return "127.0.8.2" if worker_id == "master" else f"127.0.8.{3 + int(worker_id.removeprefix('gw'))}"


@pytest.mark.parametrize(
    ("camera", "options", "readout"),
    [
        ("photon", (), "snapshot"),
        ("photon", ("--readout", "rolling"), "rolling"),
        ("microbolometer", (), "rolling"),
        ("microbolometer", ("--readout", "snapshot"), "snapshot"),
    ],
)
def test_a_served_rig_writes_the_files_that_its_users_want(told, tmp_path, worker_id, camera, options, readout):
    """Oracle: the readers of those files; the plan names the addresses that were printed."""
    status, output, error = told(
        "rig", "--simulate", "--camera", camera, *options, "--rows", "24", "--columns", "32", "--out", str(tmp_path),
        "--duration", "100 ms", "--console", "0", "--camera-address", _address(worker_id), "--speed", "5",
    )  # fmt: skip
    assert status == 0, error
    assert "the rig is ready, 5 of its seconds in one of yours" in output
    plan = read_series(tmp_path / "plan.toml")
    assert (plan.camera.camera_type, plan.camera.readout_mode) == (camera, readout)
    assert plan.devices.camera == f"gige:{_address(worker_id)}"
    for address in (plan.devices.chopper, plan.devices.blackbody, plan.devices.trigger_generator):
        assert address in output
    assert (plan.references is not None) == (camera == "photon")
    assert read_rig(tmp_path / "rig.toml").wheel.control_slots == 100
    truth = json.loads((tmp_path / "truth.json").read_text())
    assert ("row_delay_s" in truth) == (readout == "rolling")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "nothing was asked for; say --simulate"),
        (["--tell", "state", "--console", "1"], "no simulated rig listens at port 1"),
        (["--simulate", "--run-up", "soon"], "'soon' is not a time"),
        (["--simulate", "--camera-address", "203.0.113.7", "--rows", "16", "--columns", "16"], "203.0.113.7"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(told, words, says):
    """Oracle: one odd wish each; exit status 2."""
    status, _, error = told("rig", *words)
    assert status == 2
    assert says in error
    assert "Traceback" not in error
    assert sum(line.startswith("irtiming: ") for line in error.splitlines()) == 1


def test_help_tells_every_word(told):
    """Oracle: the words of the console."""
    status, output, _ = told("rig", "--tell", "help")
    assert status == 0
    assert [line.split()[0] for line in output.splitlines()] == [
        "remove", "insert", "fault", "lose-lock", "unplug", "state",
    ]  # fmt: skip


_HALF_SET_UP = """
import signal
from threading import Thread
from irtiming.cli.main import run

begin = Thread.start

def start(thread):
    begin(thread)
    if thread.name.startswith("camera"):
        signal.raise_signal(signal.SIGTERM)

Thread.start = start
run()
"""


def test_a_rig_that_is_stopped_while_it_is_set_up_ends(worker_id):
    """Oracle: the exit status and one line; one of the camera's threads alone would have gone on for ever."""
    words = [
        "rig",
        "--simulate",
        "--rows",
        "16",
        "--columns",
        "16",
        "--camera-address",
        _address(worker_id),
        "--console",
        "0",
    ]
    command = [sys.executable, "-c", _HALF_SET_UP, *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 143
    assert len(done.stderr.splitlines()) == 1
