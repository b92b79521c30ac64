"""`irtiming record` as typed, with input that cannot be: exit status 2, one line, nothing made."""

import json
import subprocess
import sys

import pytest

from irtiming.cli.series_triggers import chosen_runs, triggers_of
from irtiming.errors import PlanError
from irtiming.records.series_plan import CameraWishes, DeviceAddresses, SeriesPlan, TriggerWishes

PLAN = """
[devices]
camera = "gige:127.0.0.2"
trigger_generator = "/dev/no-such-port"

[camera]
type = "photon"

[series]
wheel_hz = 3
frame_hz = 30.303
samples = 1000
"""
_AS_TYPED = "from irtiming.cli import main, record_command; main.app.command()(record_command.record); main.run()"


@pytest.fixture
def run(tmp_path):
    """Return a function that runs `irtiming record` with these words in an empty folder."""

    def typed(text, *words):
        (tmp_path / "plan.toml").write_text(text)
        command = [sys.executable, "-c", _AS_TYPED, "record", "plan.toml", "--out", "series", *words]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)

    return typed


@pytest.mark.parametrize(
    ("text", "words", "says"),
    [
        (PLAN, [], "/dev/no-such-port"),
        (PLAN.replace("photon", "foton"), [], "did you mean 'photon'?"),
        (PLAN.replace("wheel_hz", "wheel_rate"), [], "[series] wheel_rate is not a key"),
        (PLAN, ["--json", "no/such/folder.json"], "no folder"),
        (PLAN + '[stop]\nuncertainty = {trigger_delay = "1 us"}\n', [], "say --rig rig.toml"),
        (PLAN + '[stop]\nuncertainty = {delay = "1 us"}\n', [], "uncertainty.delay is nothing that is measured"),
        (PLAN, ["--rig", "no-rig.toml"], "no-rig.toml"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(run, tmp_path, text, words, says):
    """Oracle: the words; the folder of the series is not made."""
    done = run(text, *words)
    assert done.returncode == 2
    lines = done.stderr.strip().splitlines()
    assert says in done.stderr
    assert all(line.startswith(("irtiming: ", "not ready: ")) for line in lines)
    assert not (tmp_path / "series").exists()


def test_every_device_that_cannot_be_reached_is_told(run):
    """Oracle: two addresses that lead nowhere, each in a line of its own."""
    done = run(PLAN.replace("gige:127.0.0.2", "nosuch:1"))
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 2
    assert [line.split(":")[0] for line in lines] == ["not ready", "not ready", "irtiming"]
    assert "2 complaints" in lines[-1]


def _plan(**about):
    wishes = TriggerWishes(wheel_hz=("3", "9"), frame_hz="30.303", samples="1000", **about)
    return SeriesPlan(
        devices=DeviceAddresses(camera="gige:1", trigger_generator="/dev/null"),
        camera=CameraWishes(camera_type="photon"),
        triggers=wishes,
        file_name="{run}.nxs",
    )


def test_wishes_become_runs_for_the_generators_clock():
    """Oracle: two speeds, two delays and two repeats of the paper's scheme: four runs of 2000 triggers."""
    plan = triggers_of(_plan(delays=("0 s", "25 ms"), repeats="2"), clock_frequency_hz=49_152_000)
    assert plan.clock_frequency_hz == 49_152_000
    assert [(run.trigger_delay_ticks, run.repeats) for run in plan] == [(0, 2), (1_228_800, 2)] * 2
    for run in plan:
        assert run.scheme.samples_per_turn == pytest.approx(1000, rel=0.01)
    rates = [49_152_000 / scheme.turn_period_ticks for scheme in plan.schemes]
    assert rates == pytest.approx([3, 9], rel=0.01)


def test_a_plan_file_is_read(tmp_path):
    """Oracle: the numbers in the file."""
    run = {
        "turn_period_ticks": 4_000_000, "camera_period_ticks": 1_560_000, "control_slots": 100, "trigger_delay_ticks": 0,
        "repeats": 1, "is_after_correction": False,
    }  # fmt: skip
    path = tmp_path / "plan.json"
    path.write_text(json.dumps({"clock_frequency_hz": 48_000_000, "plan": {"runs": [run]}}))
    plan = SeriesPlan(
        devices=DeviceAddresses(camera="gige:1", trigger_generator="/dev/null"),
        camera=CameraWishes(camera_type="photon"),
        plan_file=str(path),
        file_name="{run}.nxs",
    )
    assert triggers_of(plan, clock_frequency_hz=1).runs[0].scheme.camera_period_ticks == 1_560_000


def test_runs_are_chosen():
    """Oracle: by hand."""
    assert chosen_runs("2", 5) == {2}
    assert chosen_runs("1,3-5", 5) == {1, 3, 4, 5}


@pytest.mark.parametrize("text", ["", "a", "0", "6", "3-1", "1-"])
def test_runs_that_are_not_there_are_refused(text):
    """Oracle: a series of five."""
    with pytest.raises(PlanError, match="--runs"):
        chosen_runs(text, 5)
