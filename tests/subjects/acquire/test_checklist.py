"""The checklist: every complaint at once, and nothing moves."""

import asyncio
from dataclasses import replace

import pytest

from irtiming.acquire import checklist
from irtiming.acquire.checklist import complaints
from irtiming.errors import InstrumentSilent
from irtiming.records.series_plan import CameraWishes, ReferenceWishes


def _complaints(laboratory):
    return asyncio.run(complaints(laboratory.rig, laboratory.series, journal=laboratory.journal))


def test_a_rig_that_is_ready_has_none(with_blackbody):
    """Oracle: an empty list, and devices of which nothing was asked but words."""
    assert _complaints(with_blackbody) == []
    assert with_blackbody.chopper.done == with_blackbody.blackbody.targets == with_blackbody.generator.begun == []
    assert list(with_blackbody.folder.iterdir()) == []


def test_all_are_told_at_once(with_blackbody):
    """Oracle: five things that were broken, in the words for each."""
    camera = CameraWishes(
        camera_type="photon", integration_time_s=0.02, serial_number="SN9", features=(("Gain2", "3"),)
    )
    with_blackbody.plan = replace(with_blackbody.plan, camera=camera)
    with_blackbody.chopper.state_now = replace(with_blackbody.chopper.state_now, blade="MC1F10")
    with_blackbody.generator.clock_frequency_hz = 50_000_000
    found = _complaints(with_blackbody)
    assert [text[:40] for text in found] == [
        "camera is number SN1, the plan is for SN",
        "camera has no feature Gain2; correct [ca",
        "the integration time is 20 ms, the camer",
        "chopper is set to blade MC1F10; a wheel ",
        "the plan is for a clock of 48000000 Hz, ",
    ]


@pytest.mark.parametrize(
    ("window_s", "told"),
    [(250e-6, ["the plan's integration_time is 250 µs, and ExposureTime = 500 (µs) is to be set beside"]), (None, [])],
)
def test_an_integration_time_that_is_set_twice_is_told(laboratory, window_s, told):
    """Oracle: by hand; a feature such as --set gives it beside the plan's, and alone, where nothing contradicts it."""
    camera = CameraWishes(camera_type="photon", integration_time_s=window_s, features=(("ExposureTime", "500"),))
    laboratory.plan = replace(laboratory.plan, camera=camera)
    assert [text[:86] for text in _complaints(laboratory)] == told


def test_a_camera_that_is_too_slow_is_told(laboratory):
    """Oracle: 48e6 / 510 000 is 94.1 frames a second, the camera says 60."""
    laboratory.camera.features["ResultingFrameRate"] = "60.0"
    (text,) = _complaints(laboratory)
    assert "makes 60 frames per second at most as it is set, the plan asks for 94.1176" in text


def test_a_camera_that_the_plan_makes_fast_enough_is_no_complaint(laboratory, monkeypatch):
    """Oracle: by hand; 60 frames a second at 4 rows are 120 at the 2 of the plan; where they are not, no run begins."""
    features = laboratory.camera.features
    features["ResultingFrameRate"] = "60.0"
    camera = CameraWishes(camera_type="photon", integration_time_s=250e-6, features=(("Height", "2"),))
    laboratory.plan = replace(laboratory.plan, camera=camera)
    monkeypatch.setattr(checklist.shutil, "disk_usage", lambda place: type("Usage", (), {"free": 192})())
    assert _complaints(laboratory) == []
    assert "makes 60 frames per second at most" in laboratory.recorded().ending
    assert laboratory.generator.begun == []

    async def set_faster(self, name, *, value):
        features[name] = value
        features["ResultingFrameRate"] = f"{240 / int(features['Height'])}"

    monkeypatch.setattr(type(laboratory.camera), "set_feature", set_faster)
    assert laboratory.recorded().is_good


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"reference": "internal-outer", "is_enabled": True}, "turns on its reference internal-outer"),
        ({"harmonic_divider": 2, "is_enabled": True}, "turns at 1/2 of its reference"),
    ],
)
def test_a_turning_wheel_on_another_reference_is_told(with_blackbody, change, says):
    """Oracle: the words; one that stands will be set."""
    with_blackbody.chopper.state_now = replace(with_blackbody.chopper.state_now, **change)
    assert says in _complaints(with_blackbody)[0]
    with_blackbody.chopper.state_now = replace(with_blackbody.chopper.state_now, is_enabled=False)
    assert _complaints(with_blackbody) == []


def test_a_device_that_falls_silent_is_one_complaint(with_blackbody, monkeypatch):
    """Oracle: the driver's own words."""

    async def silent(self):
        raise InstrumentSilent("blackbody does not answer; check its cable")

    monkeypatch.setattr(type(with_blackbody.blackbody), "state", silent)
    assert _complaints(with_blackbody) == ["blackbody does not answer; check its cable"]


def test_a_disk_that_is_too_small_is_told(laboratory, monkeypatch):
    """Oracle: 16 frames of 48 bytes need 384 bytes at half their size."""
    monkeypatch.setattr(checklist.shutil, "disk_usage", lambda place: type("Usage", (), {"free": 383})())
    assert "16 frames need" in _complaints(laboratory)[0]
    monkeypatch.setattr(checklist.shutil, "disk_usage", lambda place: type("Usage", (), {"free": 384})())
    assert _complaints(laboratory) == []


def test_a_folder_that_cannot_be_is_told(laboratory):
    """Oracle: a folder in one that does not exist."""
    laboratory.folder = laboratory.folder / "no" / "such"
    assert "make it first" in _complaints(laboratory)[0]


def test_references_that_are_not_there_are_told(laboratory):
    """Oracle: a file that does not exist."""
    laboratory.plan = replace(laboratory.plan, references=ReferenceWishes(file=str(laboratory.folder / "gone.npz")))
    assert "gone.npz: does not exist" in _complaints(laboratory)[0]
