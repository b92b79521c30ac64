"""`irtiming record` as typed, with the devices of the test behind the addresses."""

import json
from contextlib import asynccontextmanager

import pytest
import typer
from typer.testing import CliRunner

from irtiming.archive import reader
from irtiming.cli.record_command import record
from irtiming.errors import InstrumentError

PLAN = """
[devices]
camera = "gige:fake"
trigger_generator = "fake"
chopper = "mc2000b:fake"
blackbody = "sr800r:fake"

[camera]
type = "photon"

[series]
plan = "plan.json"

[files]
name = "r{run}.nxs"
"""
RUN = {
    "turn_period_ticks": 480_000, "camera_period_ticks": 510_000, "control_slots": 10, "trigger_delay_ticks": 0,
    "repeats": 1, "is_after_correction": False,
}  # fmt: skip


@pytest.fixture
def run(with_blackbody, monkeypatch):
    """Return a function that runs `irtiming record` on a series of two runs with these words."""
    folder = with_blackbody.folder
    (folder / "plan.toml").write_text(PLAN)
    (folder / "plan.json").write_text(json.dumps({"clock_frequency_hz": 48_000_000, "plan": {"runs": [RUN, RUN]}}))
    app = typer.Typer()
    app.command()(record)

    @asynccontextmanager
    async def connected_rig(plan):
        yield with_blackbody.rig

    monkeypatch.setattr("irtiming.acquire.rig.connected_rig", connected_rig)
    words = [str(folder / "plan.toml"), "--out", str(folder / "series")]
    return lambda *more: CliRunner(env={"COLUMNS": "200"}).invoke(app, [*words, *map(str, more)])


def test_a_series_is_recorded(run, with_blackbody):
    """Oracle: two recordings that the reader takes, their paths on the screen, and a summary."""
    summary = with_blackbody.folder / "summary.json"
    done = run("--json", summary)
    assert done.exit_code == 0, done.exception
    paths = [with_blackbody.folder / "series" / name for name in ("r01.nxs", "r02.nxs")]
    assert [line for line in done.stdout.splitlines() if line.endswith(".nxs")] == [str(path) for path in paths]
    assert [reader.read(path).frames.shape[0] for path in paths] == [16, 16]
    assert "run 2: 16 frames for 16 triggers, 0 lost" in done.stderr
    told = json.loads(summary.read_text())
    assert (told["ending"], told["made_now"], told["made_before"]) == ("complete", [1, 2], [])


def test_one_run_of_it(run, with_blackbody):
    """Oracle: the second run alone, and then the first, which was left."""
    assert run("--runs", "2").exit_code == 0
    assert [path.name for path in (with_blackbody.folder / "series").glob("*.nxs")] == ["r02.nxs"]
    assert "made before: runs 2" in run().stderr


def test_a_dry_run_moves_nothing(run, with_blackbody):
    """Oracle: the devices were asked for nothing, and there is no folder."""
    done = run("--dry-run")
    assert done.exit_code == 0
    assert "ready: Vendor Model 7 SN1; 2 of 2 runs to make" in done.stderr
    assert with_blackbody.chopper.done == with_blackbody.generator.begun == []
    assert not (with_blackbody.folder / "series").exists()


def test_a_complaint_ends_it_before_anything_moves(run, with_blackbody):
    """Oracle: a camera without size."""
    del with_blackbody.camera.features["Width"]
    done = run()
    assert isinstance(done.exception, InstrumentError)
    assert "does not report the size of its frames" in str(done.exception)
    assert with_blackbody.generator.begun == []


def test_a_run_in_doubt_ends_it_with_one_line(run, with_blackbody):
    """Oracle: the words, and how to go on."""
    with_blackbody.camera.extra_after = {3}
    done = run()
    assert isinstance(done.exception, InstrumentError)
    assert "not trusted" in str(done.exception)
    assert "say the same command again to go on" in str(done.exception)


def test_references_ask_a_person_or_run_a_command(run, with_blackbody):
    """Oracle: a command that writes down its last word; with nobody there and no command, one line."""
    body, folder = with_blackbody.blackbody, with_blackbody.folder
    with_blackbody.camera.level_dn = lambda: round(10 * body.temperature_k) - 2000
    references = '\n[references]\nlow = "290 K"\nhigh = "330 K"\nframes = 4\n'
    (folder / "plan.toml").write_text(PLAN + references)
    assert "there is no one to do it; say --yes" in str(run().exception)
    script = folder / "attend.sh"
    script.write_text(f"#!/bin/sh\necho $1 >> {folder}/said\n")
    script.chmod(0o755)
    (folder / "series" / "series.json").unlink()
    (folder / "plan.toml").write_text(PLAN + references + f'command = "{script}"\n')
    done = run()
    assert done.exit_code == 0, done.exception
    assert (folder / "said").read_text().split() == ["remove", "insert"]
