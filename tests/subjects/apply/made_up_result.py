"""Results of cameras that are made up: the parameters of each kind, as a result file has them."""

from irtiming.archive.result_model import Result
from irtiming.records.estimate import SHARES

_QUANTITY = {
    "expanded_uncertainty": None, "coverage_factor": 2.0, "effective_degrees_of_freedom": None, "unit": "s",
    "reference_event": "made up", "sign": None,
}  # fmt: skip


def made_up_result(camera, readout_mode, numbers, *, matrix=None, serial_number="7", rows=120, window_s=None):
    """A result with ``numbers`` as name: (value, u); uncorrelated where no matrix is given."""
    names = list(numbers)
    content = {
        "method": "made up",
        "camera": camera,
        "readout_mode": readout_mode,
        "item": {"manufacturer": "Maker", "model": "M1", "serial_number": serial_number, "firmware": None},
        "parameters": {
            name: _QUANTITY | {"value": float(value), "standard_uncertainty": float(u), "unit": "1" if name in SHARES else "s"}
            for name, (value, u) in numbers.items()
        },
        "correlation": {
            "names": names,
            "matrix": matrix if matrix is not None else [[float(i == k) for k in range(len(names))] for i in range(len(names))],
        },
        "relative_delays": [],
        "budget": [],
        "edge_delays": None,
        "warnings": [],
        "geometry": {},
        "wheel": None,
        "choices": {},
        "inputs": [
            {
                "file": "run.nxs", "sha256": "0", "frames": 10, "trigger_delay_time_set": 0.0, "rotation_speed": 3.0,
                "roi": [0, 1, 0, 1], "border_px": 1, "bad_pixels": 0, "axle_row_column_px": None,
                "integration_time": window_s, "image": {"rows": rows, "columns": 160}, "frame_period": 0.033,
            }
        ],
        "rig": {"file": "rig.toml", "sha256": "0"},
        "software": {},
    }  # fmt: skip
    return Result.model_validate(content)


BOLOMETER = {"trigger_delay": (4e-3, 3e-5), "time_constant": (5e-3, 6e-6), "row_delay": (4e-5, 2e-7)}
COOLED = {"trigger_delay": (4e-4, 2e-7), "exposure_midpoint_delay": (5.25e-4, 3e-7)}
