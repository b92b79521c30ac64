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
    "parameters": {"trigger_delay": _DELAY, "exposure_midpoint_delay": _DELAY},
    "correlation": {"names": ["trigger_delay", "exposure_midpoint_delay"], "matrix": [[1.0, 0.9], [0.9, 1.0]]},
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


def _with(**parameters: object) -> dict:
    """A result with these parameters in place of its own."""
    return LEAST | {"parameters": LEAST["parameters"] | parameters}


def _change(path: Path, **keys: object) -> None:
    content = json.loads(path.read_text()) | keys
    path.write_text(json.dumps({key: value for key, value in content.items() if value is not ...}))


def test_a_result_is_written_with_its_format_and_read_back(tmp_path: Path) -> None:
    """Oracle: the keys and values given; format and version stand before them, and not-a-number is null."""
    path = tmp_path / "result.json"
    write_result(_with(trigger_delay=_DELAY | {"value": float("nan")}), path)
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
        (_with(trigger_delay=_DELAY | {"unti": "s"}), "parameters: trigger_delay: unti is unknown"),
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
        (_with(trigger_delay=_DELAY | {"value": "x"}), "trigger_delay: value is 'x', must be a number"),
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


def _rolling(**changes: object) -> dict:
    """A rolling microbolometer's result, uncorrelated but for 0.5 between delay and time constant."""
    names = ["trigger_delay", "time_constant", "row_delay"]
    line = {
        "source": "noise", "type": "A", "standard_uncertainty": dict.fromkeys(names, 1e-7), "degrees_of_freedom": None,
        "share_percent": dict.fromkeys(names, 100.0), "unit": "s",
    }  # fmt: skip
    return LEAST | {
        "camera": "microbolometer", "readout_mode": "rolling", "parameters": dict.fromkeys(names, _DELAY),
        "correlation": {"names": names, "matrix": [[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]]},
        "contributions": [line],
    } | changes  # fmt: skip


def _correlated(matrix: list) -> dict:
    return {"correlation": {"names": ["trigger_delay", "time_constant", "row_delay"], "matrix": matrix}}


_NO_ROWS = ["trigger_delay", "time_constant"]
_EDITED = [
    ({"parameters": dict.fromkeys(_NO_ROWS, _DELAY)}, "correlations of trigger_delay, time_constant, row_delay, must be of"),
    (
        {
            "parameters": dict.fromkeys(_NO_ROWS, _DELAY),
            "correlation": {"names": _NO_ROWS, "matrix": [[1.0, 0.5], [0.5, 1.0]]},
        },
        "contributions of 'noise' of trigger_delay, time_constant, row_delay, must be of",
    ),
    (
        {
            "parameters": dict.fromkeys(_NO_ROWS, _DELAY),
            "correlation": {"names": _NO_ROWS, "matrix": [[1.0, 0.5], [0.5, 1.0]]},
            "contributions": [],
        },
        "lacks row_delay, which every result of a rolling microbolometer camera has",
    ),
    (
        {"parameters": dict.fromkeys(_NO_ROWS, _DELAY) | {"row_delay": _DELAY | {"unit": "ms"}}},
        "row_delay: unit is 'ms', must be s or 1",
    ),
    (
        {"parameters": dict.fromkeys(_NO_ROWS, _DELAY) | {"row_delay": _DELAY | {"unit": "1"}}},
        "row_delay in '1', must be in 's'",
    ),
    (
        {"parameters": dict.fromkeys(_NO_ROWS, _DELAY) | {"row_delay": _DELAY | {"standard_uncertainty": -1e-7}}},
        "row_delay: standard_uncertainty = -1e-07, must be 0 or more",
    ),
    (
        {"parameters": dict.fromkeys(_NO_ROWS, _DELAY) | {"row_delay": _DELAY | {"standard_uncertainty": 1e-9}}},
        "row_delay has expanded_uncertainty 2e-07, must be coverage_factor times u, 2e-09",
    ),
    (_correlated([[1.0, 5.0, 0.0], [5.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), "has 5 between trigger_delay and time_constant"),
    (_correlated([[1.0, 0.5, 0.0], [0.4, 1.0, 0.0], [0.0, 0.0, 1.0]]), "0.4 the other way round, must be symmetric"),
    (_correlated([[1.0, 0.5, 0.0], [0.5, 0.9, 0.0], [0.0, 0.0, 1.0]]), "0.9 between time_constant and itself, must be 1"),
    (_correlated([[1.0, 0.9, 0.9], [0.9, 1.0, -0.9], [0.9, -0.9, 1.0]]), "must be positive semi-definite"),
    (
        {
            "falling_rising": {
                "time": {"value": 0.0, "standard_uncertainty": 1e-6, "unit": "s"},
                "angle": {"value": 0.0, "standard_uncertainty": 1e-3, "unit": "rad"},
                "covariance": 2e-9,
                "covariance_unit": "s rad",
            }
        },
        "falling_rising has covariance 2e-09, must be within the product of both u, ±1e-09",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("change", "said"), _EDITED)
def test_a_result_that_was_edited_by_hand_is_refused(tmp_path: Path, change: dict, said: str) -> None:
    """Oracle: by hand; one thing changed that no analysis writes, in a result that is good; the words, and what to do.

    Three numbers with correlations 0.9, 0.9 and -0.9 have the determinant 1 - 3 * 0.81 - 2 * 0.729 < 0.
    """
    path = tmp_path / "result.json"
    write_result(_rolling(), path)
    assert read_result(path).parameters["row_delay"].value == 4.1e-4
    _change(path, **change)
    with pytest.raises(ArchiveError) as caught:
        read_result(path)
    assert said in str(caught.value)
    assert str(caught.value).endswith("; write it anew with irtiming analyse --json")


def test_correlations_may_be_rounded_and_a_parameter_bounded(tmp_path: Path) -> None:
    """Oracle: by hand; a coefficient of 1 + 2e-16, a parameter without uncertainty, one with bounds in place of a number."""
    path = tmp_path / "result.json"
    names = ["trigger_delay", "time_constant"]
    parts = {
        "parameters": dict.fromkeys(names, _DELAY), "bounds": {"row_delay": {"lower": None, "upper": 1.0, "unit": "s"}},
        "contributions": [],
    }  # fmt: skip
    for matrix in ([[1.0, 1.0 + 2e-16], [1.0, 1.0]], [[1.0, 0.0], [0.0, 0.0]]):
        write_result(_rolling(**parts, correlation={"names": names, "matrix": matrix}), path)
        assert read_result(path).bounds["row_delay"].upper == 1.0
