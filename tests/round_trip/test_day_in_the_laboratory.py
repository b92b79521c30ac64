"""A day in the laboratory as typed: discover, plan, record, verify, analyse; the rig runs in a process of its own."""

import json
import os
import re
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

_PROGRAM = [sys.executable, "-c", "from irtiming.cli.main import run; run()"]
_SPEED = 5
_WORST_PULL = 3.5


def _loopback():
    """Of this process alone, so that two of them do not meet at one camera."""
    pid = os.getpid()
    return f"127.{64 + pid // 2**16 % 64}.{pid // 2**8 % 2**8}.{1 + pid % 254}"


def _typed(*words, cwd):
    """What `irtiming` says on standard output and on standard error."""
    done = subprocess.run([*_PROGRAM, *words], cwd=cwd, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr


@contextmanager
def _served(folder, *words):
    """A simulated rig, from the moment when it is ready; gives all that it said until then."""
    command = [
        *_PROGRAM, "rig", "--simulate", "--speed", str(_SPEED), "--run-up", "1 s", "--settling", "1 s", "--console", "0",
        "--camera-address", _loopback(), "--seed", "4", "--out", "lab", *words,
    ]  # fmt: skip
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as rig:
        try:
            said = []
            while "the rig is ready" not in (said or [""])[-1]:
                said.append(rig.stdout.readline())
                assert said[-1], "the rig ended before it was ready"
            yield "".join(said)
        finally:
            rig.terminate()
            rig.stdout.read()


def _change(plan, *changes):
    """Change values in a plan.toml, each named by its line's beginning."""
    text = plan.read_text()
    for key, value in changes:
        text, n_found = re.subn(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.MULTILINE)
        assert n_found == 1, key
    plan.write_text(text)


def _pulls(folder, result):
    """Differences from the truth in standard uncertainties, by parameter."""
    truth = json.loads((folder / "lab" / "truth.json").read_text())
    found = json.loads((folder / result).read_text())["parameters"]
    return {
        name: (found[name]["value"] - truth[f"{name}_s"]) / found[name]["standard_uncertainty"]
        for name in ("trigger_delay", "time_constant", "row_delay")
        if name in found
    }


def _recordings(folder):
    return sorted(str(path) for path in folder.glob("*.nxs"))


def test_a_cooled_camera_is_timed(tmp_path):
    """Oracle: truth.json, which the rig wrote and no other command reads: within 3.5 stated standard uncertainties."""
    with _served(tmp_path, "--rows", "48", "--columns", "64") as said:
        camera, _ = _typed("discover", _loopback(), cwd=tmp_path)
        assert f'camera = "gige:{_loopback()}"' in camera
        assert f"gige:{_loopback()}" in said
        ready, _ = _typed("doctor", "--device", f"camera=gige:{_loopback()}", cwd=tmp_path)
        assert f"ok       camera gige:{_loopback()}: vendor irtiming" in ready
        _change(tmp_path / "lab" / "plan.toml", ("samples", 200), ("frames", 20))
        _, checked = _typed("record", "lab/plan.toml", "--out", "photon", "--dry-run", cwd=tmp_path)
        assert "2 of 2 runs to make" in checked
        assert not (tmp_path / "photon").exists()
        made, _ = _typed("record", "lab/plan.toml", "--out", "photon", cwd=tmp_path)
    recordings = _recordings(tmp_path / "photon")
    assert len(recordings) == 2
    assert [Path(line).name for line in made.splitlines() if line.endswith(".nxs")] == [
        Path(path).name for path in recordings
    ]
    verdicts, _ = _typed("verify", *recordings, cwd=tmp_path)
    assert verdicts.count("ok: ") == 2
    _typed("analyse", *recordings, "--rig", "lab/rig.toml", "--json", "photon.json", cwd=tmp_path)
    pulls = _pulls(tmp_path, "photon.json")
    assert list(pulls) == ["trigger_delay"]
    assert abs(pulls["trigger_delay"]) < _WORST_PULL, pulls


def test_a_microbolometer_camera_is_timed(tmp_path):
    """Oracle: truth.json, which the rig wrote and no other command reads: within 3.5 stated standard uncertainties."""
    with _served(tmp_path, "--camera", "microbolometer", "--rows", "48", "--columns", "64"):
        _change(tmp_path / "lab" / "plan.toml", ("samples", 200))
        _typed("record", "lab/plan.toml", "--out", "series", cwd=tmp_path)
    (recording,) = _recordings(tmp_path / "series")
    _typed("analyse", recording, "--rig", "lab/rig.toml", "--json", "result.json", cwd=tmp_path)
    pulls = _pulls(tmp_path, "result.json")
    assert list(pulls) == ["trigger_delay", "time_constant", "row_delay"]
    assert max(map(abs, pulls.values())) < _WORST_PULL, pulls
