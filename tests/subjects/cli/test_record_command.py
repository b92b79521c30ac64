"""`irtiming record` as typed, with input that cannot be: exit status 2, one line, nothing made."""

import pytest

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


@pytest.fixture
def run(tmp_path, monkeypatch, told):
    """Exit status and error of `irtiming record` with these words in an empty folder."""

    def typed(text, *words):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "plan.toml").write_text(text)
        status, _, error = told("record", "plan.toml", "--out", "series", *words)
        return status, error

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
    status, error = run(text, *words)
    assert status == 2
    lines = error.strip().splitlines()
    assert says in error
    assert all(line.startswith(("irtiming: ", "not ready: ")) for line in lines)
    assert not (tmp_path / "series").exists()


def test_every_device_that_cannot_be_reached_is_told(run):
    """Oracle: two addresses that lead nowhere, each in a line of its own."""
    status, error = run(PLAN.replace("gige:127.0.0.2", "nosuch:1"))
    lines = error.strip().splitlines()
    assert status == 2
    assert [line.split(":")[0] for line in lines] == ["not ready", "not ready", "irtiming"]
    assert "2 complaints" in lines[-1]
