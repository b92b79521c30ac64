"""The command line from simulation to result, and what it says when something is wrong."""

import json
import shutil

import pytest
from typer.testing import CliRunner

from irtiming.cli.main import app


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("simulated")
    options = [
        "--rows",
        "60",
        "--columns",
        "80",
        "--frames",
        "300",
        "--delay",
        "0 ms",
        "--delay",
        "25 ms",
        "--seed",
        "3",
    ]
    done = CliRunner().invoke(app, ["simulate", str(folder), *options])
    assert done.exit_code == 0, done.output
    return folder


def test_simulate_verify_analyse(simulated, told, tmp_path):
    """Oracle: truth.json of the simulation, and the result format."""
    recordings = sorted(simulated.glob("*.nxs"))
    assert len(recordings) == 2
    assert told("verify", *recordings)[0] == 0
    out, page = tmp_path / "result.json", tmp_path / "report.html"
    status, _, error = told("analyse", *recordings, "--rig", simulated / "rig.toml", "--json", out, "--report", page)
    assert status == 0, error
    result, truth = json.loads(out.read_text()), json.loads((simulated / "truth.json").read_text())
    assert result["camera"] == "photon"
    assert result["method"] == "pixel-sum"
    delay = result["parameters"]["trigger_delay"]
    assert delay["unit"] == "s"
    assert abs(delay["value"] - truth["trigger_delay_s"]) < 3.5 * delay["standard_uncertainty"]
    assert [round(entry["nominal"], 6) for entry in result["relative_delays"]] == [0, 0.025]
    second = result["relative_delays"][1]
    assert abs(second["value"] - 0.025) < 3.5 * second["standard_uncertainty"]
    n = len(result["correlation"]["names"])
    assert [len(row) for row in result["correlation"]["matrix"]] == [n] * n
    assert page.read_text().startswith("<!DOCTYPE html>")


def test_the_published_method_is_the_result_when_asked_for(simulated, told, tmp_path):
    """Oracle: the result format's method, and the other method beside it."""
    out = tmp_path / "result.json"
    recording = min(simulated.glob("*.nxs"))
    status, _, error = told(
        "analyse", recording, "--rig", simulated / "rig.toml", "--json", out, "--method", "published"
    )
    assert status == 0, error
    result = json.loads(out.read_text())
    assert result["method"] == "published"
    assert result["other_method"]["method"] == "pixel-sum"
    assert result["parameters"]["trigger_delay"] != result["other_method"]["parameters"]["trigger_delay"]


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("truncated", "is truncated"),
        ("absent", "does not exist"),
        ("twice", "are the same recording"),
        ("typo", "did you mean 'half_separation_mm'"),
        ("--roi=1,2,3", "must be 4 finite numbers"),
        ("--roi=nan,1,2,3", "must be 4 finite numbers"),
        ("--roi=1e400,1,2,3", "must be 4 finite numbers"),
        ("--roi=0.5,10,2,30", "must be four whole numbers"),
        ("--threshold-dn=nan", "--threshold-dn is nan, must be a finite number"),
        ("nowhere", "there is no folder"),
    ],
)
def test_unusable_input_ends_in_one_line_and_exit_2(simulated, told, tmp_path, what, says):
    """Oracle: the promise of the README; one line on standard error that names what is wrong, no traceback."""
    good = sorted(simulated.glob("*.nxs"))[0]
    rig, files, options = simulated / "rig.toml", [good], []
    if what == "truncated":
        files = [tmp_path / "cut.nxs"]
        files[0].write_bytes(good.read_bytes()[: good.stat().st_size // 2])
    elif what == "absent":
        files = [tmp_path / "absent.nxs"]
    elif what == "twice":
        files = [good, tmp_path / "copy.nxs"]
        shutil.copy(good, files[1])
    elif what == "typo":
        rig = tmp_path / "rig.toml"
        rig.write_text((simulated / "rig.toml").read_text().replace("half_separation_mm", "half_seperation_mm"))
    elif what.startswith("--"):
        options = [what]
    else:
        options = ["--json", tmp_path / "no" / "folder.json"]
    status, _, said = told("analyse", *files, "--rig", rig, *options)
    assert status == 2
    complaints = [line for line in said.splitlines() if line.startswith("irtiming: ")]
    assert len(complaints) == 1
    assert says in complaints[0]
    assert "Traceback" not in said
