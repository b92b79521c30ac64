"""Small JSON files that the program writes: a wheel calibration, a result, a plan and the journal of a series."""

import json
import tempfile
from pathlib import Path
from typing import Any

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
_INPUT = {
    "file": "a.nxs", "sha256": "b" * 64, "frames": 500, "trigger_delay_time_set": 0.0, "rotation_speed": 3.0,
    "roi": [0, 120, 0, 160], "border_px": 2, "bad_pixels": 0, "axle_row_column_px": None, "integration_time": 250e-6,
    "image": {"rows": 120, "columns": 160}, "frame_period": 0.033, "start_time": "2026-11-23T10:00:00+00:00",
    "settings": {"gain_setting": "high", "sensor_temperature": 77.0},
}  # fmt: skip
_JITTER = {
    "standard_deviation": 1e-5, "quantiles": {"0.05": -2e-5, "0.5": 0.0, "0.95": 2e-5},
    "histogram": {"edges": [-2e-5, 0.0, 2e-5], "counts": [3, 4]},
}  # fmt: skip
_EVENT = {
    "kind": "stamp", "period": 0.033, "clock_rate": 1e-6, "clock_rate_standard_uncertainty": 1e-8, "clock_offset": 0.1,
    "clock_standard_uncertainty": 1e-6, "grid_standard_uncertainty": 1e-6, "jitter": _JITTER, "unit": "s",
}  # fmt: skip
_LAG = {"timestamp_delay": 4e-3, "row_delay": 4e-5, "time_constant": 5e-3, "recursive_filter": 0.1}


def _lagging() -> dict[str, Any]:
    """A microbolometer that runs free, with everything that a result of one can say."""
    names = list(_LAG)
    told = {name: _DELAY | {"value": value} for name, value in _LAG.items()}
    told["recursive_filter"]["unit"] = "1"
    kelvin = {"value": 300.0, "unit": "K"}
    told["scene_time_constant"] = _DELAY | {"value": 6e-3, "reference_temperature": kelvin}
    told["substrate_time_constant"] = _DELAY | {"value": 5e-3}
    budget = {
        "source": "mask centre angle phi_M", "type": "B", "standard_uncertainty": dict.fromkeys(names[:3], 1e-7),
        "degrees_of_freedom": None, "share_percent": dict.fromkeys(names[:3], 90.0), "unit": "s",
    }  # fmt: skip
    return _RESULT | {
        "camera": "microbolometer", "readout_mode": "rolling", "frame_event": "stamp", "parameters": told,
        "item": {"manufacturer": "Maker", "model": "M1", "serial_number": "7", "firmware": "1"},
        "inputs": [_INPUT | {"event": _EVENT}],
        "correlation": {"names": names, "matrix": [[float(i == k) for k in range(4)] for i in range(4)]},
        "two_constants": {"substrate_temperature": kelvin}, "contributions": [budget],
        "prediction": {"camera": {
            "camera": "microbolometer", "readout_mode": "rolling", "noise_to_contrast": 0.01, "opening_pixels": 2000.0,
            "unit": "s", "time_constant": 5e-3, "row_delay": 4e-5,
        }},
        "rig": {"file": "rig.toml", "sha256": "a" * 64, "values": [
            {"name": "clock.relative_error", "value": 1e-6, "standard_uncertainty": 1e-6, "unit": "1"},
            {"name": "latency.trigger", "value": 1e-6, "standard_uncertainty": 1e-6, "unit": "s"},
        ]},
    }  # fmt: skip


def _integrating() -> dict[str, Any]:
    """A photon camera with both of its delays."""
    told = {"trigger_delay": _DELAY, "exposure_midpoint_delay": _DELAY | {"value": 5.35e-4}}
    return _RESULT | {
        "parameters": told, "correlation": {"names": list(told), "matrix": [[1.0, 0.99], [0.99, 1.0]]}, "inputs": [_INPUT],
        "item": {"serial_number": "7"},
        "prediction": {"camera": {
            "camera": "photon", "noise_to_contrast": 0.01, "opening_pixels": 2000.0, "unit": "s", "integration_time": 25e-5,
        }},
    }  # fmt: skip


_RUN = {
    "turn_period_ticks": 16_384_000, "camera_period_ticks": 1_622_016, "control_slots": 100, "trigger_delay_ticks": 0,
    "repeats": 1, "is_after_correction": False,
}  # fmt: skip
_PLAN = {"clock_frequency_hz": 49_152_000, "plan": {"runs": [_RUN]}}
_JOURNAL = {
    "uid": "u", "plan_digest": "d", "n_runs": 2, "runs": {"0": {"file": "series.json", "ending": "complete"}},
    "events": [{"time": "2026-11-23T10:00:00+00:00", "text": "run 0: complete"}],
}  # fmt: skip


def documents() -> dict[str, bytes]:
    """By name."""
    found = {
        "result": _RESULT,
        "lagging": _lagging(),
        "integrating": _integrating(),
        "plan": _PLAN,
        "journal": _JOURNAL,
    }
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
