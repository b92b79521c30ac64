"""`irtiming certificate`: files in, certificates out, everything else refused in one line."""

import hashlib
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from irtiming.archive.result_file import write_result
from irtiming.cli.main import app

EXAMPLE = Path(__file__).parents[3] / "examples" / "certificate.toml"


def _result(folder: Path, **changes: object) -> Path:
    """A result of the least that there can be: 400 us with u = 30 us, from noise alone."""
    delay = {
        "value": 400e-6, "standard_uncertainty": 30e-6, "expanded_uncertainty": 60e-6, "coverage_factor": 2.0,
        "effective_degrees_of_freedom": None, "unit": "s", "reference_event": "start of integration",
        "sign": "positive: after the trigger edge that the camera accepts",
    }  # fmt: skip
    line = {
        "source": "noise of the frames", "type": "A", "degrees_of_freedom": None, "unit": "s",
        "standard_uncertainty": {"trigger_delay": 30e-6}, "share_percent": {"trigger_delay": 100.0},
    }  # fmt: skip
    recording, rig = folder / "run.nxs", folder / "rig.toml"
    recording.write_bytes(b"frames")
    rig.write_text("[mask]\n")
    taken = {
        "file": str(recording), "sha256": hashlib.sha256(b"frames").hexdigest(), "frames": 1000, "roi": [0, 10, 0, 10],
        "trigger_delay_time_set": 0.0, "rotation_speed": 3.0, "border_px": 4, "bad_pixels": 0, "axle_row_column_px": None,
    }  # fmt: skip
    content = {
        "method": "pixel-sum", "camera": "photon", "parameters": {"trigger_delay": delay},
        "correlation": {"names": ["trigger_delay"], "matrix": [[1.0]]}, "relative_delays": [], "budget": [],
        "contributions": [line], "edge_delays": None, "warnings": [], "geometry": {}, "wheel": None,
        "choices": {"roi": None, "slope_limits": [0.05, 0.95], "search_started_at": [[1]]}, "inputs": [taken],
        "rig": {"file": str(rig), "sha256": hashlib.sha256(b"[mask]\n").hexdigest()},
        "software": {"python": "3.11.7", "irtiming": "0.1.0", "numpy": "2.1.0"},
    }  # fmt: skip
    write_result(content | changes, folder / "result.json")
    return folder / "result.json"


def _run(*options: object) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["certificate", *map(str, options)])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return 2, str(done.exception)
    return done.exit_code, done.output


def test_a_certificate_is_written_and_read_back(tmp_path: Path) -> None:
    """Oracle: 400 us, U = 60 us; the limit of 1 ms in the example is met by more than U."""
    status, said = _run(_result(tmp_path), "--with", EXAMPLE, "-o", tmp_path / "c.xml", "--out", tmp_path / "c.html")
    assert (status, "trigger delay = 400" in said, "pass" in said) == (0, True, True)
    assert "not in the recordings, and shown as missing: manufacturer, model, serial number, firmware" in said
    assert "U = 60" in (tmp_path / "c.html").read_text()
    status, said = _run("--check", tmp_path / "c.xml", "--json", tmp_path / "c.json")
    assert (status, "it is not signed" in said) == (0, True)
    found = json.loads((tmp_path / "c.json").read_text())
    assert found["quantities"][0] | {"name": ""} == {
        "name": "", "label": "trigger_delay", "value": 400e-6, "expanded": 60e-6, "coverage_factor": 2.0, "unit": r"\second",
        "conformity": "pass",
    }  # fmt: skip


def test_a_crate_holds_everything_with_its_checksum(tmp_path: Path) -> None:
    """Oracle: RO-Crate 1.1: each file of the zip but the description is described, with the SHA-256 of its bytes.

    And pip's: of requirements.txt it reads the lines that are no comment, and irtiming is in no index.
    """
    result = _result(tmp_path)
    assert _run(result, "--with", EXAMPLE, "--out", tmp_path / "c.xml", "--crate", tmp_path / "all.zip")[0] == 0
    with zipfile.ZipFile(tmp_path / "all.zip") as crate:
        described = json.loads(crate.read("ro-crate-metadata.json"))["@graph"]
        files = {one["@id"]: one for one in described if one["@type"] == "File"}
        names = set(crate.namelist()) - {"ro-crate-metadata.json"}
        assert names == set(files) == {one["@id"] for one in described[1]["hasPart"]}
        assert names >= {
            "analysis1/result.json",
            "analysis1/run.nxs",
            "analysis1/rig.toml",
            "certificate/c.xml",
            "repeat.py",
        }
        for name, one in files.items():
            assert one["sha256"] == hashlib.sha256(crate.read(name)).hexdigest()
        compile(crate.read("repeat.py"), "repeat.py", "exec")
        wanted = crate.read("requirements.txt").decode()
        assert [line for line in wanted.splitlines() if not line.startswith("#")] == ["numpy==2.1.0"]
        assert "# irtiming 0.1.0 made the results. There is no release of it yet" in wanted
        assert b"'slope_limits': [0.05, 0.95]" in crate.read("repeat.py")
    (tmp_path / "run.nxs").write_bytes(b"other")
    status, said = _run(result, "--with", EXAMPLE, "--crate", tmp_path / "again.zip")
    assert (status, "run.nxs has changed since the analysis" in said) == (2, True)
    assert not (tmp_path / "again.zip").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ([], "a certificate needs results and --with certificate.toml"),
        (["result.json"], "a certificate needs results and --with certificate.toml"),
        (["result.json", "--with", EXAMPLE], "nothing is to be written; give --out cert.pdf"),
        (
            ["result.json", "--with", EXAMPLE, "--out", "c.doc"],
            "c.doc: a certificate is written as .pdf, .html or .xml",
        ),
        (["result.json", "--with", EXAMPLE, "--crate", "c.tar"], "c.tar: a crate is a .zip"),
        (["result.json", "result.json", "--with", EXAMPLE, "--out", "c.xml"], "are the same result; give each once"),
        (["none.json", "--with", EXAMPLE, "--out", "c.xml"], "none.json: does not exist"),
        (["result.json", "--with", "none.toml", "--out", "c.xml"], "none.toml: does not exist"),
        (
            ["result.json", "--with", "bad.toml", "--out", "c.xml"],
            "bad.toml: [laboratory] nmae is not a key of this section",
        ),
        (
            ["result.json", "--with", "limits-of-mine.toml", "--out", "c.xml"],
            "limits-of-mine.toml has a [[limit]] of 'row_delay', which was not measured",
        ),
        (["--check", "result.json"], "result.json: is not XML"),
        (["--check", "c.xml", "--out", "d.xml"], "--check reads a certificate and writes none"),
    ],
)
def test_what_cannot_be_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[object], said: str
) -> None:
    """Oracle: one thing wrong in each; nothing is written."""
    monkeypatch.chdir(tmp_path)
    _result(tmp_path)
    Path("bad.toml").write_text(EXAMPLE.read_text().replace("[laboratory]\nname", "[laboratory]\nnmae"))
    other = EXAMPLE.read_text() + '\n[[limit]]\nparameter = "row_delay"\nupper = "1 ms"\n'
    Path("limits-of-mine.toml").write_text(other)
    before = sorted(tmp_path.iterdir())
    status, words = _run(*options)
    assert (status, said in words) == (2, True), words
    assert sorted(tmp_path.iterdir()) == before


def test_one_line_on_standard_error(tmp_path: Path) -> None:
    """Oracle: exit status 2 and one line, as every command; the result determines nothing."""
    bounds = {"trigger_delay": {"lower": 0.0, "upper": None, "unit": "s"}}
    result = _result(tmp_path, parameters={}, bounds=bounds, correlation={"names": [], "matrix": []}, contributions=[])
    arguments = ["certificate", result, "--with", EXAMPLE, "--out", tmp_path / "c.xml"]
    done = subprocess.run([sys.executable, "-m", "irtiming", *arguments], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "irtiming: the result determines no time of the camera; there is nothing to certify\n"
