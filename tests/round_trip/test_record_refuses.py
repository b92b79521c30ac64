"""`irtiming record` before a rig that is not as it must be: one line, exit status 2, and nothing has moved.

The devices are simulated ones in this process; the program knows only their addresses.
"""

import ctypes
import os
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
import serial
from pyGigEVision import GVCPClient

from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.twin import rig as twin
from irtiming.twin.devices.bench import Bench, Workplace
from irtiming.twin.devices.chopper import SimulatedChopper
from irtiming.twin.scene import paper_scene

pytestmark = pytest.mark.slow

_PLAN = """
[camera]
type = "photon"
integration_time = "250 us"

[series]
wheel_hz = 3
frame_hz = 30.303
samples = 500

[blackbody]
temperature = "60 C"

[references]
low = "15 C"
high = "30 C"
"""
_SPEED = 10
_DROP_FROM_BOUNDS, _MAY_READ_ALL = 24, (1, 2)  # of prctl; CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH of root


def _loopback(offset=0):
    pid = os.getpid()
    return f"127.{128 + pid // 2**16 % 64}.{pid // 2**8 % 2**8}.{1 + (pid + offset) % 254}"


class _Laboratory:
    """A simulated rig, the plan for it, and what must stay as it is."""

    def __init__(self, bench, folder, stack, *, told):
        self.bench, self.folder, self.told = bench, folder, told
        self.devices = dict(bench.addresses)
        self.n_triggers = 0
        self.at = stack.enter_context
        bench.view.trigger = self._count

    def _count(self, cycles):
        self.n_triggers += np.size(cycles)

    def still(self):
        """All that could have been moved, heated or triggered."""
        return (
            self.bench.chopper.settings,
            self.bench.chopper.rotation_hz,
            self.bench.blackbody.target_k,
            self.n_triggers,
        )

    def port_of(self, name):
        """Path of a serial port in an address."""
        return self.devices[name].rpartition(":")[2].partition("?")[0]

    def chopper(self, **about):
        """Put another chopper there."""
        other = SimulatedChopper(**about)
        path = self.at(PseudoTerminal(other, speed=_SPEED)).path
        self.devices["chopper"] = f"mc2000b:{path}?speed={_SPEED}"
        return other


@pytest.fixture
def laboratory(tmp_path, monkeypatch, told):
    """A rig at rest, with an empty folder, which is the current one, for what might be recorded."""
    monkeypatch.chdir(tmp_path)
    place = Workplace(camera_address=_loopback(), blackbody_port="serial", speed=_SPEED, settling_s=1.0)
    bench = Bench(twin.draw(paper_scene(16, 20), seed=1), place=place)
    with ExitStack() as stack:
        yield _Laboratory(stack.enter_context(bench), tmp_path, stack, told=told)


def _record(laboratory, *words, without_privileges=False):
    """Run `irtiming record` on the devices of the laboratory; exit status, output and error."""
    names = "".join(f'{name} = "{address}"\n' for name, address in laboratory.devices.items())
    plan = laboratory.folder / "plan.toml"
    plan.write_text(f"[devices]\n{names}speed = {_SPEED}\n{_PLAN}")
    words = ("record", str(plan), "--out", "series", *words)
    if not without_privileges:
        return laboratory.told(*words)
    done = subprocess.run(
        [sys.executable, "-c", "from irtiming.cli.main import run; run()", *words],
        cwd=laboratory.folder, capture_output=True, text=True, timeout=60, check=False, preexec_fn=_without_privileges,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


def _refused(laboratory, says, *words, **about):
    """Require exit status 2, one line with these words, and a rig as it was."""
    before = laboratory.still()
    status, output, error = _record(laboratory, *words, **about)
    assert status == 2, error
    lines = error.splitlines()
    assert len(lines) == 1, error
    assert lines[0].startswith("irtiming: ")
    assert says in lines[0]
    assert output == ""
    assert laboratory.still() == before
    assert laboratory.n_triggers == 0
    assert list(laboratory.folder.rglob("*.nxs*")) == []


def test_a_rig_that_is_as_it_must_be_is_not_refused(laboratory):
    """Oracle: the same rig without any fault passes the checklist; else the refusals below would prove nothing."""
    status, _, error = _record(laboratory, "--dry-run")
    assert status == 0, error
    assert error.startswith("ready: ")


def _blackbody_where_the_chopper_should_be(laboratory):
    path = laboratory.port_of("blackbody")
    laboratory.devices["chopper"] = f"mc2000b:{path}?speed={_SPEED}"
    other = laboratory.at(PseudoTerminal(SimulatedChopper(), speed=_SPEED)).path
    laboratory.devices["blackbody"] = f"sr800r:{other}?speed={_SPEED}"


def _swap_generator_and_chopper(laboratory):
    chopper, generator = laboratory.port_of("chopper"), laboratory.devices["trigger_generator"]
    laboratory.devices["trigger_generator"] = chopper
    laboratory.devices["chopper"] = f"mc2000b:{generator}?speed={_SPEED}"


@pytest.mark.parametrize(
    ("swap", "says"),
    [
        (_blackbody_where_the_chopper_should_be, ("chopper", "blackbody")),
        (_swap_generator_and_chopper, ("dev/pts", "dev/pts")),
    ],
)
def test_devices_at_each_others_ports_are_both_told(laboratory, swap, says):
    """Oracle: two addresses exchanged: a line for each above the one that ends it, all settings as they were."""
    swap(laboratory)
    before = laboratory.still()
    status, _, error = _record(laboratory)
    assert status == 2
    *complaints, last = error.splitlines()
    assert [line.split(":")[0] for line in complaints] == ["not ready", "not ready"]
    assert all(word in line for word, line in zip(says, complaints, strict=True))
    assert last == "irtiming: 2 complaints, see above; nothing was moved"
    assert laboratory.still() == before
    assert laboratory.n_triggers == 0


def test_nobody_at_the_cameras_address(laboratory):
    """Oracle: a loopback address at which nothing is served."""
    laboratory.devices["camera"] = f"gige:{_loopback(offset=100)}"
    _refused(laboratory, f"camera {_loopback(offset=100)} does not answer")


@pytest.mark.parametrize(
    ("about", "says"),
    [
        ({"identity": "THORLABS MC1000A Optical Chopper 2.0"}, "no THORLABS MC2000B"),
        ({"blade": 1}, "is set to blade MC1F10"),
    ],
)
def test_another_chopper_or_blade(laboratory, about, says):
    """Oracle: a controller of another name, and one with a blade of ten slots; its settings stay as they were."""
    other = laboratory.chopper(**about)
    settings = other.settings
    _refused(laboratory, says)
    assert other.settings == settings
    assert other.rotation_hz == 0


@pytest.mark.parametrize(
    ("register", "value", "says"),
    [("VERSION", 0x0002_0000, "has version 2.0"), ("IDENTITY", 1, "it is no trigger generator")],
)
def test_another_trigger_generator(laboratory, register, value, says):
    """Oracle: registers of a device that is not ours, or of a later one."""
    device = ModelDevice(registers={register: value})
    laboratory.devices["trigger_generator"] = laboratory.at(PseudoTerminal(device, speed=_SPEED)).path
    _refused(laboratory, says)


@pytest.mark.parametrize(
    ("device", "name", "value", "says"),
    [
        ("chopper", "garbled", 1.0, "another device is at this port"),
        ("chopper", "is_silent", True, "does not answer 'id?'"),
        ("blackbody", "is_binary", True, "the binary protocol of an SR-800N"),
        ("blackbody", "garbled", 1.0, "another device is at this line"),
        ("blackbody", "bit_error", "SENSOR 2", "reports a fault ('SENSOR 2')"),
        ("generator", "is_silent", True, "does not answer"),
    ],
)
def test_replies_that_are_none(laboratory, device, name, value, says):
    """Oracle: faults of the simulated devices, one at a time."""
    setattr(laboratory.bench.faults[device], name, value)
    _refused(laboratory, says)


@pytest.mark.parametrize("name", ["trigger_generator", "chopper", "blackbody"])
def test_a_port_that_another_program_uses(laboratory, name):
    """Oracle: this process, which has the port."""
    with serial.Serial(laboratory.port_of(name), exclusive=True):
        _refused(laboratory, "is used by another program; end that program, or name another port")


def test_a_camera_that_another_program_controls(laboratory):
    """Oracle: a client of pyGigEVision, which has control."""
    client = GVCPClient(_loopback())
    client.connect()
    try:
        _refused(laboratory, "is controlled by another program; end that program")
    finally:
        client.disconnect()


@contextmanager
def _forbidden(path, mode):
    """Nobody may open a file or change a folder meanwhile."""
    before = Path(path).stat().st_mode
    Path(path).chmod(mode)
    try:
        yield
    finally:
        Path(path).chmod(before)


def _without_privileges():
    """Make even an administrator keep to permissions; nothing to others."""
    prctl = ctypes.CDLL(None).prctl
    for capability in _MAY_READ_ALL:
        prctl(_DROP_FROM_BOUNDS, capability, 0, 0, 0)


@pytest.mark.skipif(sys.platform != "linux", reason="permissions of an administrator are given up in Linux's way")
def test_a_port_that_this_user_may_not_open(laboratory):
    """Oracle: the permissions of the port, which nobody has."""
    with _forbidden(laboratory.port_of("chopper"), 0o000):
        _refused(laboratory, "may not be opened by this user", without_privileges=True)


@pytest.mark.skipif(sys.platform != "linux", reason="permissions of an administrator are given up in Linux's way")
def test_a_folder_that_this_user_may_not_write_to(laboratory):
    """Oracle: the permissions of the folder."""
    locked = laboratory.folder / "locked"
    locked.mkdir()
    with _forbidden(locked, 0o500):
        words = ["--out", str(locked / "series")]
        _refused(laboratory, "may not be written to", *words, without_privileges=True)
