"""No command writes over a file that it reads, whichever option names it."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from irtiming.cli.main import app
from irtiming.errors import IrTimingError

EXAMPLES = Path(__file__).parents[3] / "examples"


LINKS = {
    "rig.json": "rig.toml", "rig.svg": "rig.toml", "r.json": "r.sqlite", "a.json": "a.nxs", "l.json": "l.toml",
    "cert.json": "cert.xml", "p.json": "rig.png",
}  # fmt: skip
"""Other names of the files, with the suffix of what is to be written."""


@pytest.mark.parametrize(
    ("words", "read"),
    [
        (("history", "A", "--register", "r.sqlite", "--json", "r.json"), "r.sqlite"),
        (("history", "A", "--register", "sqlite:///r.sqlite", "--json", "r.json"), "r.sqlite"),
        (("plan", "--for", "trigger_delay=1us", "--rig", "rig.toml", "--json", "rig.json"), "rig.toml"),
        (("plan", "--for", "trigger_delay=1us", "--rig", "rig.toml", "--picture", "rig.svg"), "rig.toml"),
        (("plan", "--free-running", "33 ms", "--wheel-hz", "3", "--samples", "1000", "--rig", "rig.toml", "--json", "rig.json"),
         "rig.toml"),
        (("clock", "a.nxs", "--rig", "rig.toml", "--json", "rig.json"), "rig.toml"),
        (("clock", "a.nxs", "--json", "b", "--picture", "b"), "a.nxs"),
        (("latency", "gates", "a.nxs", "--rig", "rig.toml", "--json", "rig.json"), "rig.toml"),
        (("latency", "loopback", "a.nxs", "--rig", "rig.toml", "--json", "rig.json"), "rig.toml"),
        (("gateware", "loopback", "no-port", "--rig", "rig.toml", "--json", "rig.json"), "rig.toml"),
        (("record", "plan.toml", "--out", "out", "--rig", "rig.toml", "--json", "rig.json"), "rig.toml"),
        (("record", "plan.toml", "--out", "out", "--json", "out/series.json"), "out/series.json"),
        (("verify", "a.nxs", "--rig", "rig.toml", "--json", "rig.json"), "rig.toml"),
        (("campaign", "a.csv", "--rig", "rig.toml", "--out", "new", "--limits", "l.toml", "--json", "l.json"), "l.toml"),
        (("campaign", "a.csv", "--rig", "rig.toml", "--out", "new", "--json", "a.json"), "a.nxs"),
        (("campaign", "a.csv", "--rig", "rig.toml", "--out", "new", "--wheel-calibration", "w.json", "--json", "w.json"),
         "w.json"),
        (("campaign", "a.csv", "--rig", "rig.toml", "--out", "new", "--register", "r.sqlite", "--json", "r.json"), "a.csv"),
        (("campaign", "out/table.csv", "--rig", "rig.toml", "--out", "out", "--register", "none"), "out/table.csv"),
        (("certificate", "--check", "cert.xml", "--json", "cert.json"), "cert.xml"),
        (("analyse", "a.nxs", "--rig", "rig.toml", "--maps", "rig.h5", "--json", "p.json"), "rig.toml"),
    ],
)  # fmt: skip
def test_a_file_that_is_read_is_refused_as_output(words, read, tmp_path, monkeypatch):
    """Oracle: by hand; one file is named twice, by whatever name, the error says so, and the file is as before."""
    monkeypatch.chdir(tmp_path)
    Path("out").mkdir()
    for name in ("a.nxs", "r.sqlite", "l.toml", "w.json", "cert.xml", "out/series.json"):
        Path(name).touch()
    Path("plan.toml").write_text((EXAMPLES / "cooled.plan.toml").read_text())
    Path("rig.toml").write_text((EXAMPLES / "cooled.rig.toml").read_text())
    Path("a.csv").write_text("file\na.nxs\n")
    Path("out/table.csv").write_text("file\n../a.nxs\n")
    for name, file in LINKS.items():
        Path(name).symlink_to(file)
    before = Path(read).read_bytes()
    done = CliRunner().invoke(app, list(words))
    assert isinstance(done.exception, IrTimingError), done.output
    assert "is another file of this command and would be overwritten" in str(done.exception)
    assert Path(read).read_bytes() == before


def test_maps_and_the_picture_beside_them_are_two_places(tmp_path, monkeypatch):
    """Oracle: by hand; both may be written, so what is refused is the recording, which is empty."""
    monkeypatch.chdir(tmp_path)
    Path("a.nxs").touch()
    Path("rig.toml").write_text((EXAMPLES / "cooled.rig.toml").read_text())
    done = CliRunner().invoke(app, ["analyse", "a.nxs", "--rig", "rig.toml", "--maps", "maps.h5"])
    assert isinstance(done.exception, IrTimingError), done.output
    assert str(done.exception).startswith("a.nxs: ")
