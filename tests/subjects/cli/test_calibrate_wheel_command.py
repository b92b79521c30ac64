"""`irtiming calibrate-wheel`, and what `irtiming analyse` makes of its file."""

import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from irtiming.archive import rig_writer, writer
from irtiming.archive.wheel_calibration_file import read_wheel_calibration
from irtiming.cli.main import app
from irtiming.errors import ArchiveError, IrTimingError
from irtiming.twin.rig import SimulatedRig, draw, simulate
from irtiming.twin.scene import Ripple, Scene, SpeedWander, paper_scene, with_wheel_speed

TURN = 2 * np.pi


def _scene(hz: float) -> Scene:
    scene = with_wheel_speed(paper_scene(48, 64), hz, samples=400)
    ripple = Ripple(order=1, relative=4e-4 * (3 / hz) ** 2)
    wheel = replace(scene.wheel, ring_edges_rad=(0.0, 1.571, np.pi + 4e-3, 4.713))
    return replace(scene, wheel=wheel, wander=SpeedWander(ripples=(ripple,)))


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, SimulatedRig]:
    """Folder with rig.toml and recordings of one wheel at 3 and 6 Hz, and of another one."""
    folder = tmp_path_factory.mktemp("rig")
    for name, hz, seed in (("slow", 3.0, 5), ("fast", 6.0, 5), ("other", 3.0, 6)):
        drawn = draw(_scene(hz), seed=seed)
        writer.write(simulate(drawn.scene, seed=int(10 * hz) + seed, name=name), folder / f"{name}.nxs")
        if name == "fast":
            rig_writer.write_rig(drawn.measured, folder / "rig.toml")
            rig = drawn
    return folder, rig


@pytest.fixture(scope="module")
def calibrated(place) -> str:
    """What is said of both speeds; wheel.json and wheel.svg lie in the folder then."""
    folder, _ = place
    return _run(
        "calibrate-wheel", folder / "slow.nxs", folder / "fast.nxs", "--rig", folder / "rig.toml",
        "--out", folder / "wheel.json", "--picture", folder / "wheel.svg",
    )  # fmt: skip


def _run(*arguments: object) -> str:
    done = CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "200"})
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.output


def test_two_speeds_give_slots_ripple_and_a_picture(place, calibrated) -> None:
    """Oracle: slots of the twin within a microsecond; ripple of 0.4 mrad, order 1; the picture is XML with both axes named."""
    folder, rig = place
    wheel = read_wheel_calibration(folder / "wheel.json")
    true = np.array(rig.scene.wheel.control_slot_errors_rad)
    assert np.std(wheel.slot_deviation_rad - true) < 1e-6 * TURN * 3
    assert wheel.names == ("slow", "fast")
    assert all(len(checksum) == 64 for checksum in wheel.sha256)
    for words in ("3 Hz", "6 Hz", "gate separation", "application edge α₃", "speed ripple", "closure"):
        assert words in calibrated
    assert "not separable" not in calibrated
    assert ET.parse(folder / "wheel.svg").getroot().tag.endswith("svg")


def test_one_speed_says_what_it_cannot_tell(place) -> None:
    """Oracle: by hand; a ripple and slots look the same at one speed."""
    folder, _ = place
    said = _run(
        "calibrate-wheel", folder / "slow.nxs", "--rig", folder / "rig.toml", "--out", folder / "one.json"
    )  # fmt: skip
    assert "cannot be separated from the slots" in " ".join(said.split())
    assert said.count("not separable") == 6
    assert read_wheel_calibration(folder / "one.json").ripple is None


@pytest.mark.usefixtures("calibrated")
def test_analysis_takes_the_calibration(place) -> None:
    """Oracle: the calibration; the slots of the result are its own, free of the ripple that the recording alone has."""
    folder, rig = place
    results = []
    for more in ((), ("--wheel-calibration", folder / "wheel.json")):
        _run("analyse", folder / "slow.nxs", "--rig", folder / "rig.toml", "--json", folder / "result.json", *more)
        results.append(json.loads((folder / "result.json").read_text())["wheel"])
    alone, helped = results
    assert alone["ripple"] == "not separable at one speed"
    assert not any(entry["separable_from_ripple"] for entry in alone["orders"])
    assert alone["slots_from"] == ["slow"]
    assert helped["slots_from"] == ["slow", "fast"]
    assert helped["ripple"]["amplitude_by_order"][0] == pytest.approx(4e-4, rel=0.03)
    true = np.std(rig.scene.wheel.control_slot_errors_rad)
    assert abs(helped["rms_deviation"] - true) < 0.01 * true
    assert abs(alone["rms_deviation"] - true) > 0.03 * true


def test_the_calibration_of_another_wheel_is_told(place) -> None:
    """Oracle: by hand; it is left out with a warning."""
    folder, _ = place
    _run("calibrate-wheel", folder / "other.nxs", "--rig", folder / "rig.toml", "--out", folder / "other.json")
    said = _run(
        "analyse", folder / "slow.nxs", "--rig", folder / "rig.toml", "--wheel-calibration", folder / "other.json"
    )  # fmt: skip
    assert "another wheel?" in " ".join(said.split())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--out", "slow.nxs"), "is another file of this command"),
        (("--out", "new.json", "--picture", "new.png"), "give a name that ends in .svg"),
        (("--out", "new.json", "--picture", "new.json"), "is another file of this command"),
        (("--out", "nowhere/new.json"), "there is no folder"),
        (("--out", "new.json", "--rig", "slow.nxs"), "is not UTF-8 text"),
    ],
)
def test_nothing_is_written_where_it_may_not(place, monkeypatch, options, said) -> None:
    """Oracle: by hand; refused before any work."""
    folder, _ = place
    monkeypatch.chdir(folder)
    with pytest.raises(IrTimingError, match=said):
        _run("calibrate-wheel", "slow.nxs", "--rig", "rig.toml", *options)
    assert not Path("new.json").exists()


def test_analysis_refuses_what_is_no_calibration(place) -> None:
    """Oracle: by hand; the rig file is none, and a result may not be written over the calibration."""
    folder, _ = place
    with pytest.raises(ArchiveError, match=r"rig\.toml: is not valid JSON"):
        _run(
            "analyse", folder / "slow.nxs", "--rig", folder / "rig.toml", "--wheel-calibration", folder / "rig.toml"
        )  # fmt: skip
    with pytest.raises(ArchiveError, match=r"is another file of this command"):
        _run(
            "analyse", folder / "slow.nxs", "--rig", folder / "rig.toml",
            "--wheel-calibration", folder / "one.json", "--json", folder / "one.json",
        )  # fmt: skip
