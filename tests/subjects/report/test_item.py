"""Which camera a result is of: as its recordings say, and of no two."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from irtiming.archive import reader
from irtiming.archive.result_file import read_result, write_result
from irtiming.archive.result_model import Result
from irtiming.errors import EstimationError
from irtiming.measurement import reduce
from irtiming.records.analysis import Analysis
from irtiming.records.camera_frame import CameraIdentity
from irtiming.report.result import result

A320 = CameraIdentity(vendor="Maker", model="A320", serial_number="", firmware="2.1", address="10.0.0.7")
SERIAL = CameraIdentity(vendor="Maker", model="", serial_number="0815", firmware="", address="")


def _written(analysis: Analysis, folder: Path) -> Result:
    write_result(result(analysis), folder / "result.json")
    return read_result(folder / "result.json")


def _of(analysis: Analysis, *cameras: CameraIdentity | None) -> Analysis:
    said = [*cameras, *[None] * (len(analysis.recordings) - len(cameras))]
    recordings = [replace(one, camera=camera) for one, camera in zip(analysis.recordings, said, strict=True)]
    return replace(analysis, recordings=tuple(recordings))


def test_a_result_names_the_camera_as_its_recordings_do(analysis: Analysis, tmp_path: Path) -> None:
    """Oracle: the words given; each from the recording that has it, null where none has."""
    found = _written(_of(analysis, None, A320, SERIAL), tmp_path)
    told = {"manufacturer": "Maker", "model": "A320", "serial_number": "0815", "firmware": "2.1"}
    assert found.item.model_dump() == told
    assert [one.item and one.item.serial_number for one in found.inputs[:3]] == [None, None, "0815"]
    assert set(_written(analysis, tmp_path).item.model_dump().values()) == {None}


def test_a_result_tells_frames_and_rig(analysis: Analysis, tmp_path: Path) -> None:
    """Oracle: numbers of the hand-made analysis: 60 x 80 pixels, 13 mm between beams and axle, 75 degrees of opening."""
    recordings = [replace(one, frame_period_s=0.033, is_simulated=True) for one in analysis.recordings]
    found = _written(replace(analysis, recordings=tuple(recordings)), tmp_path)
    assert (found.inputs[0].image.rows, found.inputs[0].image.columns) == (60, 80)
    assert (found.inputs[0].frame_period, found.simulated, found.inputs[0].simulated) == (0.033, True, True)
    values = {one.name: (one.value, one.standard_uncertainty, one.unit) for one in found.rig.values}
    assert values["beams.half_separation"] == (13e-3, None, "m")
    assert values["mask.opening_angle"] == (np.radians(75), None, "rad")
    assert values["wheel.rotation"] == ("clockwise", None, "")
    assert not [name for name in values if name.startswith("clock.")]


def test_two_cameras_are_not_analysed_together(hand_made, analysis: Analysis) -> None:
    """Oracle: the line says both serial numbers and what to do."""
    recording = replace(reader.read(hand_made()), camera=replace(SERIAL, serial_number="4711"))
    before = _of(analysis, SERIAL).recordings[:1]
    with pytest.raises(EstimationError) as caught:
        reduce(recording, analysis.rig, before=before)
    said = "of a camera with serial number '4711', camera-0ms-r0 of one with '0815': all must be of one camera"
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_says_that_it_is_simulated(hand_made) -> None:
    """Oracle: truth beside the data, or the simulated camera's maker; a recording without either is taken as real."""
    assert not reader.read(hand_made()).is_simulated
    assert reader.read(hand_made(lambda file: file.create_group("entry/truth"), name="a.nxs")).is_simulated
    named = hand_made(lambda file: file.update({"entry/instrument/camera/vendor": "irtiming"}), name="b.nxs")
    assert reader.read(named).is_simulated
    assert reader.read(named).frame_period_s == 1_622_016 / 49_152_000
