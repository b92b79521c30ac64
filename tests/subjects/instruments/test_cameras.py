"""Addresses of devices, drivers of plug-ins, and cameras that are found."""

import asyncio
import json
from contextlib import asynccontextmanager
from importlib.metadata import EntryPoint

import pytest
import typer
from typer.testing import CliRunner

from irtiming.errors import InstrumentError
from irtiming.instruments import device_address
from irtiming.instruments.cameras import find, open_camera
from irtiming.instruments.device_address import BLACKBODIES, CAMERAS, CHOPPERS, connect, drivers


@asynccontextmanager
async def _made_up(address):
    yield f"camera at {address}"


@pytest.fixture
def plug_ins(monkeypatch):
    """Entry points of four plug-ins: a good one, one that lacks a package, one that breaks, one that takes a built-in name."""

    def entry_points(*, group):
        values = {
            "good": f"{__name__}:_made_up",
            "lacking": "no_such_package_of_anybody:connected",
            "gone": f"{__name__}:_not_there",
            "gige": f"{__name__}:_made_up",
        }
        return [EntryPoint(name=n, value=v, group=group) for n, v in values.items()] if group == CAMERAS else []

    monkeypatch.setattr(device_address, "entry_points", entry_points)


@pytest.mark.parametrize(
    ("group", "address", "words"),
    [
        (CAMERAS, "gigE:1.2.3.4", "camera address 'gigE:1.2.3.4' names no driver 'gigE'; .* aravis:..., gige:..."),
        (CAMERAS, "192.168.0.7", "camera address '192.168.0.7' names no driver; .* aravis:..., gige:..."),
        (CAMERAS, "gige:", "ends after the colon"),
        (CHOPPERS, "x:y", "chopper address 'x:y' .* mc2000b:..."),
        (BLACKBODIES, "", "blackbody address '' .* sr800r:..."),
        ("nobody.asked", "x:y", "device address 'x:y' .* none; install a driver"),
    ],
)
def test_address_that_names_no_driver(group, address, words):
    """Oracle: the addresses that there are, in one line."""
    with pytest.raises(InstrumentError, match=words):
        connect(group, address)


def test_plug_in_is_used_by_its_scheme(plug_ins):
    """Oracle: a driver of the test's own; it is given what stands behind the first colon."""

    async def test():
        async with open_camera("good:tcp:host:52") as camera:
            return camera

    assert asyncio.run(test()) == "camera at tcp:host:52"


def test_plug_ins_that_cannot_be_loaded_are_told_and_harm_nobody(plug_ins):
    """Oracle: the plug-ins of the fixture; a built-in name stays with the built-in driver."""
    found = {driver.scheme: driver for driver in drivers(CAMERAS)}
    assert list(found) == ["aravis", "gige", "gone", "good", "lacking"]
    assert found["good"].load_error == ""
    assert found["good"].entry_point is not None
    assert found["lacking"].entry_point is None
    assert "no_such_package_of_anybody" in found["lacking"].load_error
    assert "_not_there" in found["gone"].load_error
    assert found["gige"].entry_point is None or found["gige"].entry_point.value.startswith("irtiming.")
    with pytest.raises(InstrumentError, match="driver of lacking:1 cannot be loaded: .*no_such_package_of_anybody"):
        connect(CAMERAS, "lacking:1")


def test_missing_package_of_a_built_in_driver_names_the_extra(monkeypatch):
    """Oracle: the name of the extra."""
    monkeypatch.setitem(device_address._BUILT_IN, CAMERAS, {"gige": "no_such_package_of_anybody:connected"})
    with pytest.raises(InstrumentError, match=r"pip install 'irtiming\[rig\]'"):
        open_camera("gige:1.2.3.4")


def test_camera_is_found_by_its_address():
    """Oracle: the small camera's own name; the same camera is listed once, and nothing but a question was sent to it."""
    pytest.importorskip("pyGigEVision", reason="the extra irtiming[rig] is not installed")
    from gige_responder import Responder

    with Responder() as responder:
        before = bytes(responder.memory)
        cameras, _ = find(hosts=[responder.host, responder.host, "127.9.9.8", "no host"], timeout_s=0.2)
        found = [camera for camera in cameras if camera.address == f"gige:{responder.host}"]
        assert [(c.vendor, c.model, c.serial_number) for c in found] == [("Test", "Small", "T7")]
        assert responder.memory == before
        assert responder.controller is None


def test_aravis_fake_camera_is_found():
    """Oracle: the Aravis project's program."""
    pytest.importorskip("pyGigEVision", reason="the extra irtiming[rig] is not installed")
    from gige_responder import aravis_fake

    with aravis_fake():
        cameras, complaints = find(hosts=["127.0.0.1"], timeout_s=0.3)
    found = [camera for camera in cameras if camera.address == "gige:127.0.0.1"]
    assert [(c.vendor, c.model, c.serial_number, c.firmware[:2]) for c in found] == [("Aravis", "Fake", "SIM01", "0.")]
    assert not [complaint for complaint in complaints if "GigE" in complaint]


def test_discover_lists_what_a_plan_takes(tmp_path):
    """Oracle: the small camera's address as a line of plan.toml, and the same in the JSON file."""
    pytest.importorskip("pyGigEVision", reason="the extra irtiming[rig] is not installed")
    from gige_responder import Responder

    from irtiming.cli.discover_command import discover

    app = typer.Typer()
    app.command()(discover)
    with Responder() as responder:
        place = tmp_path / "found.json"
        told = CliRunner().invoke(app, [responder.host, "--timeout", "0.2", "--json", str(place)])
        assert told.exit_code == 0, told.output
        assert f'camera = "gige:{responder.host}"  # Test Small, serial number T7' in told.output
        assert "serial ports: " in told.output
        written = json.loads(place.read_text())
    assert responder.host in [camera["address"].removeprefix("gige:") for camera in written["cameras"]]
    assert isinstance(written["serial_ports"], list)


def test_discover_without_any_camera(monkeypatch):
    """Oracle: no camera and a library that is not there: both in one line each, and no failure."""
    from irtiming.cli import discover_command

    monkeypatch.setattr(discover_command, "find", lambda **_: ([], ["USB3 Vision cameras were not looked for: x"]))
    app = typer.Typer()
    app.command()(discover_command.discover)
    told = CliRunner().invoke(app, [])
    assert told.exit_code == 0
    assert "cameras: none answers; check power and cable" in told.output
    assert "note: USB3 Vision cameras were not looked for: x" in told.output
