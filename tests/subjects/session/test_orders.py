"""What a person orders checks itself: contradictions are refused before any work."""

import json
from pathlib import Path

import pytest

from irtiming.archive.json_file import require_places, write_json
from irtiming.errors import ArchiveError, PlanError
from irtiming.records.series_plan import TriggerWishes
from irtiming.session.analysis import AnalysisOrder, analyse
from irtiming.session.apply_time import TimeOrder, apply_time
from irtiming.session.camera import Described, camera
from irtiming.session.capture import CaptureOrder
from irtiming.session.clock import ClockOrder, evaluate
from irtiming.session.frame_stamps import StampsWanted
from irtiming.session.hand_over import ExportOrder, hand_over
from irtiming.session.plan import PlanOrder, plan
from irtiming.session.simulation import CameraOrder, SimulationOrder
from irtiming.session.timestamps import FramesOrder, combine
from irtiming.session.wheel import CalibrationOrder, calibrate

HERE = Path("here")
WISHES = TriggerWishes(wheel_hz=("3",), frame_hz="30", samples="1000", clock_hz="48000000")
BARE = TriggerWishes(wheel_hz=(), frame_hz="30", samples="")


@pytest.mark.parametrize(
    ("order", "wrong", "says"),
    [
        (CameraOrder, {"camera": "bolometer"}, "camera is 'bolometer', must be photon or microbolometer; did you mean"),
        (CameraOrder, {"camera": ["photon"]}, "camera is \"['photon']\", must be photon or microbolometer"),
        (CameraOrder, {"readout": "global"}, "readout is 'global', must be snapshot or rolling; name one of them"),
        (
            SimulationOrder,
            {"folder": HERE, "camera": CameraOrder(), "rotation": "left"},
            "rotation is 'left', must be clockwise or counterclockwise",
        ),
        (
            SimulationOrder,
            {"folder": HERE, "camera": CameraOrder(), "free_running": "trigger"},
            "free_running is 'trigger', must be strobe or stamp or arrival",
        ),
        (Described, {"camera": "cooled"}, "camera is 'cooled', must be photon or microbolometer"),
        (CameraOrder, {"row_delay_s": 1e-6}, "row_delay_s with camera photon readout snapshot"),
        (CameraOrder, {"time_constant_s": 5e-3}, "leave out time_constant_s, or take camera microbolometer"),
        (
            CameraOrder,
            {"camera": "microbolometer", "reference_frames": 0},
            "reference_frames with camera microbolometer",
        ),
        (CameraOrder, {"integration_time_s": 1.5}, "an integration time of '1.5 s' was asked for"),
        (CameraOrder, {"trigger_delay_s": float("nan")}, "a trigger delay of"),
        (
            SimulationOrder,
            {"folder": HERE, "camera": CameraOrder(), "frames": 3, "lost_frames": 3},
            "at least one must",
        ),
        (PlanOrder, {"wishes": BARE}, "clock_hz, wheel_hz, samples must be given; only with wanted"),
        (PlanOrder, {"wishes": WISHES, "rig": HERE}, "nothing is asked of them; add wanted"),
        (PlanOrder, {"wishes": WISHES, "camera": Described(noise=1.0)}, "nothing is asked of them"),
        (Described, {"contrast": 0.0}, "contrast is 0, but must be greater than 0"),
    ],
)
def test_contradictions_are_refused_by_the_fields_names(order, wrong, says):
    """Oracle: by hand, one contradiction at a time."""
    with pytest.raises(PlanError) as refused:
        order(**wrong)
    assert says in str(refused.value)


@pytest.mark.parametrize(
    ("order", "wrong", "says"),
    [
        (CaptureOrder, {"capture": HERE, "lines": "", "frames": HERE}, "frames and out belong together"),
        (CaptureOrder, {"capture": HERE, "lines": ""}, "nothing to write"),
        (FramesOrder, {"timestamps": HERE, "frames": HERE, "out": HERE, "readout": "rolling"}, "go with camera"),
    ],
)
def test_files_that_contradict_are_refused(order, wrong, says):
    """Oracle: by hand."""
    with pytest.raises(ArchiveError) as refused:
        order(**wrong)
    assert says in str(refused.value)


def test_rolling_photon_cameras_have_a_row_delay_and_snapshots_with_lag_have_none():
    """Oracle: the four kinds of cameras."""
    assert CameraOrder(readout="rolling", row_delay_s=-20e-6).row_delay_s == -20e-6
    assert CameraOrder(camera="microbolometer", readout="snapshot", time_constant_s=5e-3).time_constant_s == 5e-3
    with pytest.raises(PlanError, match="take readout rolling"):
        CameraOrder(camera="microbolometer", readout="snapshot", row_delay_s=20e-6)


def test_a_described_camera_is_the_papers_but_for_what_is_said():
    """Oracle: by hand; noise and contrast count as their ratio, a time constant of 0 s is said too."""
    usual = camera(Described())
    assert camera(Described(contrast=4.5)).noise_to_contrast == pytest.approx(2 * usual.noise_to_contrast)
    assert camera(Described(opening_pixels=5.0)).opening_pixels == 5.0
    with pytest.raises(PlanError, match="time_constant_s with a photon camera"):
        camera(Described(time_constant_s=0.0))


@pytest.mark.parametrize("told", [{}, {"row_delay": 30e-6}])
@pytest.mark.parametrize("kind", ["photon", "microbolometer"])
def test_the_camera_of_a_result_keeps_its_readout(tmp_path, kind, told):
    """Oracle: by hand; also where the result tells no row delay."""
    found = {"camera": kind, "readout_mode": "rolling", "noise_to_contrast": 0.01, "opening_pixels": 300.0, **told}
    for mode in ("rolling", "snapshot"):
        (tmp_path / "r.json").write_text(json.dumps({"prediction": {"camera": {**found, "readout_mode": mode}}}))
        seen = camera(Described(like=tmp_path / "r.json"))
        assert (seen.camera_type, seen.readout_mode) == (kind, mode)
        if told and mode == "rolling":
            assert seen.row_delay_s == 30e-6


OUTPUTS = [
    (calibrate, CalibrationOrder(recordings=(HERE,), rig=HERE, calibration=Path("wheel.json"), picture=Path("here.png")),
     "here.png: ends in .png, but SVG is to be written there; give a name that ends in .svg"),
    (evaluate, ClockOrder(recordings=(HERE,), picture=Path("x.PDF")), "ends in .PDF, but SVG is to be written there"),
    (plan, PlanOrder(wishes=WISHES, picture=Path("x.png")), "x.png: ends in .png, but SVG is to be written there"),
    (plan, PlanOrder(wishes=WISHES, json=Path("x.toml")), "ends in .toml, but JSON is to be written there"),
    (analyse, AnalysisOrder(recordings=(HERE,), rig=HERE, report=Path("x.pdf")), "HTML is to be written there"),
    (analyse, AnalysisOrder(recordings=(HERE,), rig=HERE, result=Path("x.html")), "name that ends in .json"),
    (combine, FramesOrder(timestamps=HERE, frames=HERE, out=Path("x.json")), "but a recording is to be written there"),
    (apply_time, TimeOrder(result=HERE, stamps=StampsWanted(source=HERE), out=Path("x.json")),
     "but CSV or Parquet or a recording is to be written there; give a name that ends in .csv or .parquet or .nxs"),
    (hand_over, ExportOrder(result=HERE, program="basalt", out=Path("x.yaml")), "JSON is to be"),
    (hand_over, ExportOrder(result=HERE, program="kalibr", out=Path("x.json")), "YAML is to be"),
]  # fmt: skip


@pytest.mark.parametrize(("verb", "order", "says"), OUTPUTS)
def test_a_name_that_says_another_format_is_refused_before_any_work(verb, order, says):
    """Oracle: by hand, and other programs' own pages; no file that would be read is there, and none is missed."""
    with pytest.raises(ArchiveError) as refused:
        verb(order)
    assert says in str(refused.value)


@pytest.mark.parametrize("name", ["x.svg", "x.SVG", "x", "-", "x.2026", "/dev/stdout"])
def test_a_name_that_says_no_other_format_will_do(name):
    """Oracle: by hand; its own suffix, none, and one that is no format."""
    require_places({"SVG": [name]})


def test_json_is_written_under_no_other_formats_name(tmp_path):
    """Oracle: by hand; whichever command writes it."""
    with pytest.raises(ArchiveError, match="x.html: ends in .html, but JSON is to be written there"):
        write_json({}, tmp_path / "x.html")
    assert list(tmp_path.iterdir()) == []
