"""`irtiming history`: what is entered, once each, and the drift by hand."""

import json
import sqlite3
from pathlib import Path

import pytest
from typer.testing import CliRunner

from irtiming.archive.result_model import Bound
from irtiming.cli.main import app
from irtiming.errors import IrTimingError
from results_by_hand import OWN_S, RIG_S, result_by_hand

_TABLES = ("setting", "value", "common_input", "recording")


def _run(*arguments):
    done = CliRunner().invoke(app, ["history", *map(str, arguments)], env={"COLUMNS": "200"})
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.output


@pytest.fixture
def register(tmp_path):
    """A register of camera A on three days, of B once, and the same result given twice."""
    days = {"2025-11-23": 400.0, "2026-05-24": 401.0, "2026-11-23": 402.0}
    made = {f"A-{day}": result_by_hand(us * 1e-6, start=f"{day}T10:00:00Z") for day, us in days.items()}
    made["B"] = result_by_hand(500e-6, serial="B")
    adds = []
    for name, result in made.items():
        path = tmp_path / f"{name}.json"
        path.write_text(result.model_dump_json())
        adds += ["--add", path]
    place = tmp_path / "register.sqlite"
    assert "4 new of 4" in _run("--register", place, *adds)
    assert "0 new of 1" in _run("--register", place, *adds[:2])
    return place


def test_drift_has_the_uncertainty_that_the_days_do_not_share(register, tmp_path):
    """Oracle: by hand: change 1 us, u = sqrt(2) own; since the first day 2 us; 2 us a year of 365.25 days."""
    said = _run("A", "--register", register, "--json", tmp_path / "a.json")
    assert "Drift since the last calibration" in said
    assert "moved" in said
    told = json.loads((tmp_path / "a.json").read_text())
    drift = next(one for one in told["drift"] if one["parameter"] == "trigger_delay")
    assert drift["change"] == pytest.approx(1e-6)
    assert drift["change_standard_uncertainty"] == pytest.approx(2**0.5 * OWN_S, rel=1e-6)
    assert drift["standard_uncertainty"] == pytest.approx((OWN_S**2 + RIG_S**2) ** 0.5, rel=1e-6)
    assert drift["rate_per_year"] == pytest.approx(2e-6, rel=5e-3)
    assert len(told["results"]) == 3
    _run("A", "--register", register, "--since", "2026-01-31", "--json", tmp_path / "a.json")
    since = next(
        one for one in json.loads((tmp_path / "a.json").read_text())["drift"] if one["parameter"] == "trigger_delay"
    )
    assert since["change"] == pytest.approx(2e-6)


def test_one_serial_number_read_out_in_two_ways_has_a_history(register, tmp_path):
    """Oracle: by hand; two days of rolling readout beside the three of a snapshot: a drift of each, which its rows tell apart."""
    for day, us in {"2025-11-23": 900.0, "2026-11-23": 905.0}.items():
        path = tmp_path / f"rolling-{day}.json"
        rolling = {"readout_mode": "rolling", "bounds": {"row_delay": Bound(lower=0.0, upper=None, unit="s")}}
        result = result_by_hand(us * 1e-6, start=f"{day}T10:00:00Z").model_copy(update=rolling)
        path.write_text(result.model_dump_json())
        _run("--register", register, "--add", path)
    said = _run("A", "--register", register, "--json", tmp_path / "a.json")
    assert "rolling, 250" in said
    told = json.loads((tmp_path / "a.json").read_text())["drift"]
    changes = {one["readout_mode"]: one["change"] for one in told if one["parameter"] == "trigger_delay"}
    assert changes == {"snapshot": pytest.approx(1e-6), "rolling": pytest.approx(5e-6)}


def test_a_recording_counts_once_however_often_it_is_analysed(register, tmp_path):
    """Oracle: by hand; the result of another rig.toml stands in place of that of the same recording, the other days stay."""
    again = tmp_path / "again.json"
    again.write_text(result_by_hand(402.0 * 1e-6, start="2026-11-23T10:00:00Z", rig="second").model_dump_json())
    assert "1 new of 1" in _run("--register", register, "--add", again)
    _run("A", "--register", register, "--json", tmp_path / "a.json")
    files = [Path(one["file"]).name for one in json.loads((tmp_path / "a.json").read_text())["results"]]
    assert files == ["A-2025-11-23.json", "A-2026-05-24.json", "again.json"]
    with sqlite3.connect(register) as line:
        rows = {name: line.execute(f"select count(distinct result_id) from {name}").fetchone()[0] for name in _TABLES}
    line.close()
    assert set(rows.values()) == {4}


def test_a_register_without_recordings_can_be_used(register, tmp_path):
    """Oracle: by hand; the table that earlier programs did not make is gone: what is in it stays, what comes is added."""
    with sqlite3.connect(register) as line:
        line.execute("drop table recording")
    line.close()
    path = tmp_path / "A.json"
    path.write_text(result_by_hand(403e-6, start="2027-11-23T10:00:00Z").model_dump_json())
    assert "1 new of 1" in _run("--register", register, "--add", path)
    _run("A", "--register", register, "--json", tmp_path / "a.json")
    assert len(json.loads((tmp_path / "a.json").read_text())["results"]) == 4


def test_the_register_is_plain_tables(register):
    """Oracle: Python's own sqlite3, and the page that describes the tables."""
    with sqlite3.connect(register) as line:
        found = line.execute(
            "select serial_number, value from result join value on result_id = id where parameter = 'trigger_delay' order by 2"
        ).fetchall()
        tables = dict(line.execute("select name, sql from sqlite_master where type = 'table'").fetchall())
    line.close()
    assert [serial for serial, _ in found] == ["A", "A", "A", "B"]
    assert found[0][1] == pytest.approx(400e-6)
    assert set(tables) == {"register_version", "result", "setting", "value", "common_input", "finding", "recording"}
    assert [line for line in _run("--register", register).splitlines() if " B " in line]


def test_what_cannot_be_told_is_refused(register, tmp_path):
    """Oracle: by hand: a camera that nobody registered, a register that is not there or no database, a day that is none."""
    with pytest.raises(IrTimingError, match="has no camera 'C'; it knows A, B"):
        _run("C", "--register", register)
    with pytest.raises(IrTimingError, match="there is no register"):
        _run("A", "--register", tmp_path / "none.sqlite")
    (tmp_path / "junk.sqlite").write_text("this is no database, whatever its name says" * 50)
    with pytest.raises(IrTimingError, match="cannot be used"):
        _run("A", "--register", tmp_path / "junk.sqlite")
    with pytest.raises(IrTimingError, match="must be a day such as"):
        _run("A", "--register", register, "--since", "yesterday")
    with pytest.raises(IrTimingError, match="cannot be used"):
        _run("A", "--register", "nonsense://x")
