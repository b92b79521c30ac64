"""Small JSON files that the program writes: a wheel calibration, a result, a plan and the journal of a series."""

import json
import tempfile
from pathlib import Path

import numpy as np

from irtiming.archive.result_model import FORMAT, VERSION
from irtiming.archive.wheel_calibration_file import write_wheel_calibration
from irtiming.records.wheel_calibration import SlotsAtSpeed, SpeedRipple, WheelCalibration

_DELAY = {
    "value": 4.1e-4, "standard_uncertainty": 1e-7, "expanded_uncertainty": 2e-7, "coverage_factor": 2.0,
    "effective_degrees_of_freedom": None, "unit": "s", "reference_event": "start of integration", "sign": "positive",
}  # fmt: skip
_RESULT = {
    "format": FORMAT, "version": VERSION, "method": "pixel-sum", "camera": "photon",
    "parameters": {"trigger_delay": _DELAY},
    "correlation": {"names": ["trigger_delay"], "matrix": [[1.0]]},
    "relative_delays": [], "budget": [], "edge_delays": None, "warnings": ["the wheel wobbles"], "prediction": None,
    "geometry": {
        "cutout_edges": [0.0, 1.571, 3.1423, 4.7134], "cutout_edges_from": "rig.toml", "beta_1": 0.27, "beta_2": 0.3,
        "gate_height": {"value": 0.047, "unit": "m"}, "camera_roll": 0.0, "angle_unit": "rad",
    },
    "wheel": None, "choices": {"roi": None}, "inputs": [], "rig": {"file": "rig.toml", "sha256": "a" * 64},
    "software": {"irtiming": "0.1.0"},
}  # fmt: skip
_RUN = {
    "turn_period_ticks": 16_384_000, "camera_period_ticks": 1_622_016, "control_slots": 100, "trigger_delay_ticks": 0,
    "repeats": 1, "is_after_correction": False,
}  # fmt: skip
_PLAN = {"clock_frequency_hz": 49_152_000, "plan": {"runs": [_RUN]}}
_JOURNAL = {
    "uid": "u", "plan_digest": "d", "n_runs": 2, "runs": {"0": {"file": "a.nxs", "ending": "complete"}}, "events": [],
}  # fmt: skip


def documents() -> dict[str, bytes]:
    """By name."""
    found = {"result": _RESULT, "plan": _PLAN, "journal": _JOURNAL}
    return {name: json.dumps(content).encode() for name, content in found.items()} | {"wheel": _wheel()}


def _wheel() -> bytes:
    table, variance = np.linspace(-3e-4, 3e-4, 10), np.full(6, 1e-10)
    speed = SlotsAtSpeed(rotation_speed_hz=3.0, n_turns=100, deviation_rad=table, order_variance_rad2=variance)
    ripple = SpeedRipple(
        reference_speed_hz=3.0,
        deviation_rad=table,
        order_variance_rad2=variance,
        order_chance=np.linspace(1, 0, 6),
        chance=1e-9,
    )
    wheel = WheelCalibration(
        slot_deviation_rad=table, order_variance_rad2=variance, ripple=ripple, speeds=(speed,), gate_separation_rad=0.5697,
        u_gate_separation_rad=3e-5, application_edges_rad=(0.0, 1.571, 3.1423, 4.7134),
        u_application_edges_rad=(1e-6, 2e-6, 3e-6, 4e-6), names=("slow",), sha256=("a" * 64,), warnings=("Δ",),
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wheel.json"
        write_wheel_calibration(wheel, path)
        return path.read_bytes()
