"""`irtiming doctor`, as typed, and its checks on files that stand in for those of the system."""

import json
from types import SimpleNamespace

import pytest
import typer
from typer.testing import CliRunner

from irtiming.cli.doctor_command import doctor
from irtiming.errors import ArchiveError, InstrumentError
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.reduce import device_memory
from irtiming.session import computer
from irtiming.twin.devices.blackbody import SimulatedBlackbody
from irtiming.twin.devices.chopper import SimulatedChopper
from irtiming.twin.devices.network_port import TcpPort


@pytest.fixture
def run(tmp_path):
    """Return a function that runs `irtiming doctor` with these words."""
    app = typer.Typer()
    app.command()(doctor)
    return lambda *words: CliRunner(env={"COLUMNS": "200"}).invoke(app, ["--folder", str(tmp_path), *map(str, words)])


def _lines(result):
    return {line[9:].split(":")[0]: (line[:8].strip(), line[9:]) for line in result.stdout.splitlines()}


def test_all_parts_are_listed_with_exit_status_0(run, tmp_path):
    """Oracle: the file says what the screen says; a part that must be there for these tests is, in its version."""
    from importlib.metadata import version

    place = tmp_path / "found.json"
    result = run("--json", place)
    assert result.exit_code == 0
    checks = json.loads(place.read_text())["checks"]
    assert len(checks) == len(result.stdout.splitlines())
    assert {check["status"] for check in checks} <= {"ok", "warning", "missing"}
    assert all(check["cure"] for check in checks if check["status"] == "warning")
    found = {check["part"]: check for check in checks}
    assert found["pymeasure"]["found"].startswith(version("pymeasure"))
    assert found["HDF5 filters"]["status"] == "ok"
    assert found["irtiming.choppers mc2000b"]["status"] == "ok"
    assert found["irtiming.blackbodies sr800r"]["status"] == "ok"
    assert found[f"disk of {tmp_path}"]["status"] in ("ok", "warning")
    assert list(tmp_path.iterdir()) == [place]


def test_a_package_that_is_not_there_is_told_with_its_cure(run, monkeypatch):
    """Oracle: the words for a package of no such name."""
    monkeypatch.setattr(computer, "_PACKAGES", (("no_such_package", "no-such", "nothing", "pip install it"),))
    assert "missing  no-such: not installed, for nothing; pip install it" in run().stdout


@pytest.mark.parametrize("there", [None, b"Model Z"])
def test_a_gpu_is_told_by_its_name(run, monkeypatch, there):
    """Oracle: the words for the device's own name, and for none."""
    runtime = SimpleNamespace(getDeviceProperties=lambda number: {"name": there})
    cupy = SimpleNamespace(cuda=SimpleNamespace(runtime=runtime))
    monkeypatch.setattr(device_memory, "gpu", lambda: cupy if there else None)
    words = "Model Z, which sums the frames" if there else "none that CuPy finds"
    assert f"ok       GPU: {words}" in run().stdout


def test_a_driver_that_cannot_be_loaded_is_told(run, monkeypatch):
    """Oracle: the words for a module that is not there."""
    from irtiming.instruments import device_address

    group = {"irtiming.choppers": {"broken": "irtiming.no_such_module:connected"}}
    monkeypatch.setattr(device_address, "_BUILT_IN", group)
    status, line = _lines(run())["irtiming.choppers broken"]
    assert status == "missing"
    assert "cannot be loaded (No module named 'irtiming.no_such_module')" in line


def test_devices_are_asked_and_left_as_they_are(run):
    """Oracle: what the simulated devices are; their settings before and after."""
    chopper, blackbody = SimulatedChopper(), SimulatedBlackbody()
    before = chopper.settings
    with (
        PseudoTerminal(chopper, speed=50) as one,
        TcpPort(blackbody, speed=50) as two,
        PseudoTerminal(ModelDevice()) as three,
    ):
        result = run(
            "--device", f"chopper=mc2000b:{one.path}?speed=50",
            "--device", f"blackbody=sr800r:tcp:127.0.0.1:{two.port}?speed=50",
            "--device", f"generator={three.path}",
            "--device", "camera=gone:1.2.3.4",
        )  # fmt: skip
    assert result.exit_code == 0
    said = result.stdout.splitlines()[-4:]
    assert said[0].startswith(f"ok       chopper mc2000b:{one.path}?speed=50: model THORLABS MC2000B")
    assert "blade MC1F2, reference internal-outer" in said[0]
    assert "temperature_k 298.15, target_k 298.15, is_stable True" in said[1]
    assert "clock_frequency_hz 48000000" in said[2]
    assert said[3].startswith("missing  camera gone:1.2.3.4: camera address 'gone:1.2.3.4' names no driver 'gone'")
    assert chopper.settings == before
    assert blackbody.target_k == 298.15


@pytest.mark.parametrize("text", ["chopper", "chopper=", "wheel=mc2000b:/dev/ttyUSB0"])
def test_bad_usage_is_refused(run, text):
    """Oracle: the words."""
    result = run("--device", text)
    assert isinstance(result.exception, InstrumentError)
    assert "write KIND=ADDRESS with KIND one of camera, chopper, blackbody, generator" in str(result.exception)


def test_a_place_where_nothing_can_be_written_is_refused_first(run, tmp_path):
    """Oracle: the words, before anything is looked at."""
    result = run("--json", tmp_path / "no" / "found.json")
    assert isinstance(result.exception, ArchiveError)
    assert result.stdout == ""


def test_a_serial_port_that_may_not_be_opened_is_told(run, monkeypatch, tmp_path):
    """Oracle: the words for a port that the system denies; it is not opened."""
    import os

    port = tmp_path / "ttyUSB0"
    port.write_text("")
    monkeypatch.setattr("irtiming.instruments.serial_line.ports", lambda: [f"{port} (MC2000B)"])
    assert f"ok       serial port: {port} (MC2000B)" in run().stdout
    real = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: str(path) != str(port) and real(path, mode))
    text = run().stdout
    assert f"warning  serial port: {port} (MC2000B) may not be opened by this user; join the group that owns it" in text


def test_a_folder_that_cannot_be_written_is_told(run, tmp_path):
    """Oracle: the words."""
    assert (
        "cannot be written (No such file or directory); name a folder by --folder"
        in run("--folder", tmp_path / "no").stdout
    )
