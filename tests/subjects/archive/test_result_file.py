"""The result file: what an analysis gives is written and read back; what is no result is refused with its cure."""

import json
from pathlib import Path

import pytest

from irtiming.archive.result_file import read_result, write_result
from irtiming.errors import ArchiveError

_DELAY = {
    "value": 4.1e-4,
    "standard_uncertainty": 1e-7,
    "expanded_uncertainty": 2e-7,
    "coverage_factor": 2.0,
    "effective_degrees_of_freedom": None,
    "unit": "s",
    "reference_event": "start of integration",
    "sign": "positive: after the trigger edge that the camera accepts",
}
LEAST = {
    "method": "pixel-sum",
    "camera": "photon",
    "parameters": {"trigger_delay": _DELAY},
    "correlation": {"names": ["trigger_delay"], "matrix": [[1.0]]},
    "relative_delays": [],
    "budget": [],
    "edge_delays": None,
    "warnings": ["the wheel wobbles"],
    "prediction": None,
    "geometry": {
        "cutout_edges": [0.0, 1.571, 3.1423, 4.7134],
        "cutout_edges_from": "rig.toml",
        "beta_1": 0.27,
        "beta_2": 0.3,
        "gate_height": {"value": 0.047, "unit": "m"},
        "camera_roll": 0.0,
        "angle_unit": "rad",
    },
    "wheel": None,
    "choices": {"roi": None},
    "inputs": [],
    "rig": {"file": "rig.toml", "sha256": "a" * 64},
    "software": {"irtiming": "0.1.0"},
}


def _change(path: Path, **keys: object) -> None:
    content = json.loads(path.read_text()) | keys
    path.write_text(json.dumps({key: value for key, value in content.items() if value is not ...}))


def test_a_result_is_written_with_its_format_and_read_back(tmp_path: Path) -> None:
    """Oracle: the keys and values given; format and version stand before them, and not-a-number is null."""
    path = tmp_path / "result.json"
    write_result(LEAST | {"parameters": {"trigger_delay": _DELAY | {"value": float("nan")}}}, path)
    content = json.loads(path.read_text())
    assert list(content) == ["format", "version", *LEAST]
    assert (content["format"], content["version"]) == ("irtiming-result", "1.2")
    assert {key: content[key] for key in LEAST if key != "parameters"} == {
        key: value for key, value in LEAST.items() if key != "parameters"
    }
    found = read_result(path)
    assert found.parameters["trigger_delay"].value is None
    assert found.parameters["trigger_delay"].standard_uncertainty == 1e-7
    assert found.warnings == ["the wheel wobbles"]
    assert (found.joint_fit, found.two_constants, found.bounds) == (None, None, {})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"colour": 1}, "colour is unknown"),
        ({"parameters": {"trigger_delay": _DELAY | {"unti": "s"}}}, "parameters: trigger_delay: unti is unknown"),
        ({"geometry": ...}, "geometry is missing"),
        ({"camera": "bolometer"}, "camera is 'bolometer', must be photon or microbolometer"),
    ],
)
def test_what_is_no_result_is_not_written(tmp_path: Path, change: dict, said: str) -> None:
    """Oracle: one key changed in a result that is good; nothing is written."""
    wrong = {key: value for key, value in (LEAST | change).items() if value is not ...}
    with pytest.raises(ArchiveError) as caught:
        write_result(wrong, tmp_path / "result.json")
    assert said in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_later_minor_version_is_read_without_its_further_keys(tmp_path: Path) -> None:
    """Oracle: the same result; the keys that version 1.7 may have, at the top and below, are left out."""
    path = tmp_path / "result.json"
    write_result(LEAST, path)
    _change(path, version="1.7", colour=1, rig=LEAST["rig"] | {"owner": "me"})
    assert read_result(path).rig.file == "rig.toml"
    _change(path, version="1.1")
    with pytest.raises(ArchiveError, match=r"(colour|owner) is unknown"):
        read_result(path)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": "irtiming wheel calibration"}, "is no result (its format must be 'irtiming-result')"),
        ({"format": ...}, "is no result"),
        ({"version": "2.0"}, "version is 2.0, this irtiming knows 1.2: update it"),
        ({"version": "new"}, "version is 'new'"),
        ({"inputs": 3}, "inputs is 3, must be a list"),
        ({"inputs": [{"file": 1}]}, "inputs[0]: file is 1, must be text"),
        ({"parameters": {"trigger_delay": _DELAY | {"value": "x"}}}, "trigger_delay: value is 'x', must be a number"),
    ],
)
def test_what_is_no_result_is_refused_with_its_cure(tmp_path: Path, change: dict, said: str) -> None:
    """Oracle: one thing changed in a file that is good; the words for it, and what to do."""
    path = tmp_path / "result.json"
    write_result(LEAST, path)
    _change(path, **change)
    with pytest.raises(ArchiveError) as caught:
        read_result(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)
    assert "irtiming analyse --json" in str(caught.value)


def test_a_result_of_version_1_0_is_still_read(tmp_path: Path) -> None:
    """Oracle: the keys of 1.0, which knew neither item nor rig.values; these are then as if nobody had said anything."""
    path = tmp_path / "result.json"
    write_result(LEAST, path)
    _change(path, version="1.0")
    found = read_result(path)
    assert (found.item.serial_number, found.simulated, found.rig.values) == (None, False, [])
