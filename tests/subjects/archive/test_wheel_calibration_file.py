"""The calibration file: what is written is read back, and what is not a calibration is refused."""

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from irtiming.archive.wheel_calibration_file import read_wheel_calibration, write_wheel_calibration
from irtiming.errors import ArchiveError
from irtiming.records.wheel_calibration import SlotsAtSpeed, SpeedRipple, WheelCalibration

N = 10


def _table(seed: int, size: int = N) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, 3e-4, size)


def _calibration() -> WheelCalibration:
    variance = np.abs(_table(9, N // 2 + 1)) ** 2
    speeds = tuple(
        SlotsAtSpeed(rotation_speed_hz=hz, n_turns=100, deviation_rad=_table(int(hz)), order_variance_rad2=variance)
        for hz in (3.0, 6.0)
    )
    return WheelCalibration(
        slot_deviation_rad=_table(1),
        order_variance_rad2=variance,
        ripple=SpeedRipple(
            reference_speed_hz=3.0,
            deviation_rad=_table(2),
            order_variance_rad2=2 * variance,
            order_chance=np.linspace(1, 0, N // 2 + 1),
            chance=1e-9,
        ),
        speeds=speeds,
        gate_separation_rad=0.5697,
        u_gate_separation_rad=3e-5,
        application_edges_rad=(0.0, 1.571, 3.1423, 4.7134),
        u_application_edges_rad=(1e-6, 2e-6, 3e-6, 4e-6),
        names=("slow", "fast"),
        sha256=("a" * 64, "b" * 64),
        warnings=("Δ one",),
    )


def _same(one: object, other: object) -> bool:
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, (SlotsAtSpeed, SpeedRipple, WheelCalibration)):
        return all(_same(getattr(one, field.name), getattr(other, field.name)) for field in fields(one))
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    return one == other


@pytest.mark.parametrize(
    "without", [{}, {"ripple": None}, {"application_edges_rad": None, "u_application_edges_rad": None}]
)
def test_calibration_comes_back_to_the_last_digit(tmp_path: Path, without: dict) -> None:
    """Oracle: the calibration itself, field by field."""
    calibration = replace(_calibration(), **without)
    write_wheel_calibration(calibration, tmp_path / "wheel.json")
    assert _same(calibration, read_wheel_calibration(tmp_path / "wheel.json"))


def test_orders_are_listed_for_other_programs(tmp_path: Path) -> None:
    """Oracle: a cosine of order 2; at one speed no order is separable from ripple, at two all are."""
    wave = 1e-4 * np.cos(2 * 2 * np.pi * np.arange(N) / N + 0.5)
    for ripple in (None, _calibration().ripple):
        write_wheel_calibration(
            replace(_calibration(), slot_deviation_rad=wave, ripple=ripple), tmp_path / "wheel.json"
        )
        orders = json.loads((tmp_path / "wheel.json").read_text())["orders"]
        assert [entry["order"] for entry in orders] == [1, 2, 3, 4, 5]
        assert orders[1]["amplitude_rad"] == pytest.approx(1e-4)
        assert orders[1]["phase_rad"] == pytest.approx(0.5)
        assert {entry["is_separable_from_ripple"] for entry in orders} == {ripple is not None}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": "other"}, "is no wheel calibration"),
        ({"version": 2}, "version is 2, this irtiming knows 1"),
        ({"version": True}, "version is True, must be a whole number"),
        ({"colour": 1}, "colour is unknown"),
        ({"speeds": ...}, "speeds is missing"),
        ({"speeds": []}, "speeds is [], must hold the slots at one speed or more"),
        ({"speeds": [3]}, "speeds[0] is 3, must be an object"),
        ({"control_slots": 9}, "deviation_rad has 10 entries, must have 9"),
        ({"control_slots": 1e99}, "control_slots is 1e+99, must be a whole number from 2 to"),
        ({"slot_deviation_rad": [0.0] * 9 + ["x"]}, "slot_deviation_rad[9] is 'x', must be a number"),
        ({"slot_deviation_rad": [0.0] * 9 + [float("nan")]}, "slot_deviation_rad[9] = nan, must be a finite number"),
        ({"slot_deviation_rad": [0] * 9 + [10**400]}, "slot_deviation_rad[9] = 1000"),
        ({"slot_deviation_rad": None}, "slot_deviation_rad is None, must be a list"),
        ({"order_variance_rad2": [-1.0] * 6}, "order_variance_rad2[0] = -1, must be 0 or more"),
        ({"gate_separation_rad": "0.5"}, "gate_separation_rad is '0.5', must be a number"),
        ({"u_gate_separation_rad": 0}, "u_gate_separation_rad = 0 rad, must be greater than 0"),
        ({"application_edges_rad": [1, 2, 3]}, "application_edges_rad is [1, 2, 3], must have 4 entries"),
        ({"application_edges_rad": None}, "must both be given or both be null"),
        ({"ripple": 1}, "ripple is 1, must be an object or null"),
        ({"ripple": {}}, "ripple: reference_speed_hz is missing"),
        ({"recordings": [{"name": "a"}]}, "recordings[0]: sha256 is missing"),
        ({"recordings": [{"name": 1, "sha256": ""}]}, "recordings[0]: name is 1, must be text"),
        ({"warnings": [1]}, "warnings[0] is 1, must be text"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, change: dict, said: str) -> None:
    """Oracle: the one value that was changed; file and key stand in the message, and what to do."""
    path = tmp_path / "wheel.json"
    write_wheel_calibration(_calibration(), path)
    content = json.loads(path.read_text()) | change
    path.write_text(json.dumps({key: value for key, value in content.items() if value is not ...}))
    with pytest.raises(ArchiveError) as caught:
        read_wheel_calibration(path)
    assert str(caught.value).startswith(str(path))
    assert said in str(caught.value)
    assert "irtiming calibrate-wheel" in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"\xff\xfe\x00", b"[" * 100_000])
def test_other_files_are_refused(tmp_path: Path, content: bytes) -> None:
    """Oracle: by hand; empty, broken, no object, no UTF-8, nested too deep."""
    path = tmp_path / "wheel.json"
    path.write_bytes(content)
    with pytest.raises(ArchiveError, match=r"wheel\.json: (is not valid JSON|holds a list)"):
        read_wheel_calibration(path)
    with pytest.raises(ArchiveError, match=r"none\.json: does not exist; name the wheel calibration"):
        read_wheel_calibration(tmp_path / "none.json")
