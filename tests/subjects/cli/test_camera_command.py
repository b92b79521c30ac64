"""`irtiming camera`: features by name, and what cannot be, in one line."""

import pytest
import typer
from typer.testing import CliRunner

from irtiming.cli.camera_command import camera, named
from irtiming.errors import InstrumentRefused, UnitError
from irtiming.twin import rig as twin
from irtiming.twin.devices.gige_camera import GigeCamera
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.live_camera import LiveCamera
from irtiming.twin.scene import paper_scene


@pytest.fixture(scope="module")
def address(worker_id):
    """Of a simulated camera that is served meanwhile."""
    place = f"127.0.7.{2 if worker_id == 'master' else 3 + int(worker_id.removeprefix('gw'))}"
    scene = twin.draw(paper_scene(16, 20), seed=1).scene
    wheel = DrivenWheel(scene, clock_frequency_hz=1_000_000, seed=1)
    with LiveCamera(scene, wheel, clock_frequency_hz=1_000_000, seed=1) as view, GigeCamera(view, place):
        yield f"gige:{place}"


def _typed(*words):
    app = typer.Typer()
    app.command()(camera)
    return CliRunner().invoke(app, list(words))


def test_the_usual_features_are_told(address):
    """Oracle: the scene's image and the address."""
    found = _typed(address)
    assert found.exit_code == 0, found.exception
    assert f"at {address}" in found.stdout
    assert {"Width = 20", "Height = 16", "PixelFormat = Mono16"} <= set(found.stdout.splitlines())


def test_features_are_set_and_read_back(address):
    """Oracle: what the same command reads afterwards."""
    assert "TriggerSource = Line1" in _typed(address, "--set", "TriggerSource=Line1").stdout
    assert _typed(address, "--get", "TriggerSource").stdout.splitlines()[1:] == ["TriggerSource = Line1"]
    assert "TriggerSoftware = execute" in _typed(address, "--set", "TriggerSoftware=execute").stdout


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--set", "TriggerSource=Line9"), "it may be Software, Line1"),
        (("--set", "TriggerSoftware=now"), "is a command, not to be set to 'now'; say execute"),
        (("--get", "Wdith"), "nearest names: Width"),
    ],
)
def test_what_the_camera_refuses_is_told(address, words, says):
    """Oracle: one odd wish each."""
    found = _typed(address, *words)
    assert isinstance(found.exception, InstrumentRefused)
    assert says in str(found.exception)


@pytest.mark.parametrize("text", ["TriggerSource", "=Line1", "TriggerSource=", ""])
def test_a_text_without_name_or_value_is_refused(text):
    """Oracle: by hand."""
    with pytest.raises(UnitError, match="names no feature and value"):
        named([text])
    assert named(["A = 1", "B=x=y"]) == (("A", "1"), ("B", "x=y"))
