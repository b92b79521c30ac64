"""The result as plain data, for JSON: shared format of all cameras, with what the reader needs to judge it."""

from typing import Any

import numpy as np

from irtiming.records.estimate import DelayResult
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rolling_result import RollingResult
from irtiming.report import budget, joint_result, wheel_result
from irtiming.report.combination import combined
from irtiming.report.evidence import Evidence
from irtiming.report.prediction_result import predicted
from irtiming.report.tables import REFERENCE_EVENTS, RELATIVE_EVENT, RELATIVE_SIGN, SIGN, versions

_RELATIVE = {"reference_event": RELATIVE_EVENT, "sign": RELATIVE_SIGN}


def result(evidence: Evidence) -> dict[str, Any]:
    """Result of the chosen method with its counterpart, in SI units.

    Returns
    -------
    Keys method, camera, parameters, correlation, relative_delays, warnings as the format asks; beside them
    relative_delays_combined, budget, edge_delays, joint_fit, other_method, choices, inputs and software. All values are of
    the types that JSON has.
    """
    other = evidence.best if evidence.result is evidence.as_published else evidence.as_published
    return {
        "method": evidence.result.method,
        "camera": "photon",
        **_core(evidence, evidence.result),
        "warnings": list(evidence.warnings),
        "joint_fit": joint_result.result(evidence),
        "prediction": predicted(evidence, kind="photon"),
        "other_method": {"method": other.method, **_core(evidence, other), "warnings": list(other.warnings)},
        "geometry": _geometry(evidence),
        "wheel": wheel_result.result(evidence.wheel),
        "choices": _choices(evidence),
        "inputs": [_input(recording) for recording in evidence.recordings],
        "rig": {"file": evidence.rig.source, "sha256": evidence.rig.sha256},
        "software": versions(),
    }


def _core(evidence: Evidence, chosen: DelayResult) -> dict[str, Any]:
    return {
        "parameters": _parameters(chosen),
        "correlation": {"names": list(chosen.estimate.names), "matrix": chosen.estimate.correlation.tolist()},
        "relative_delays": _relative_delays(evidence, chosen),
        "relative_delays_combined": [
            {
                "nominal": row.nominal_s,
                "value": row.value_s,
                "standard_uncertainty": row.standard_uncertainty_s,
                "runs": row.n_runs,
                "scatter_of_runs": row.scatter_s,
                "rotation_speed": {"value": row.rotation_speed_hz, "unit": "Hz"},
                "unit": "s",
                **_RELATIVE,
            }
            for row in combined(evidence, chosen)
        ],
        "budget": [
            {
                "source": line.part.source,
                "type": line.part.kind,
                "standard_uncertainty": line.part.standard_uncertainty_s,
                "degrees_of_freedom": budget.freedom_number(line.part.degrees_of_freedom),
                "share_percent": 100 * line.share,
                "unit": "s",
            }
            for line in budget.of_delay(chosen).lines
        ],
        "edge_delays": edge_delays(chosen, event=_edge_event(chosen)),
    }


def edge_delays(chosen: DelayResult | RollingResult, *, event: str) -> dict[str, Any] | None:
    """Delay by wheel edge, for either kind of camera; None where the method does not tell edges apart, or could not be run."""
    if not np.isfinite(chosen.edge_delay_s).all():
        return None
    return {
        "value": [float(v) for v in chosen.edge_delay_s],
        "standard_uncertainty": [float(u) for u in chosen.u_edge_delay_s],
        "unit": "s",
        "reference_event": event,
        "sign": SIGN,
    }


def _parameters(chosen: DelayResult) -> dict[str, Any]:
    estimate = chosen.estimate
    return {
        name: {
            "value": float(value),
            "standard_uncertainty": float(u),
            **budget.expanded_numbers(float(u), budget.degrees_of_freedom(chosen, name)),
            "unit": "s",
            "reference_event": REFERENCE_EVENTS.get(name, name),
            "sign": None if name == "integration_time" else SIGN,
        }
        for name, value, u in zip(estimate.names, estimate.values, estimate.standard_uncertainties, strict=True)
    }


def _edge_event(chosen: DelayResult) -> str:
    name = "trigger_delay" if "trigger_delay" in chosen.estimate.names else "exposure_midpoint_delay"
    return f"{REFERENCE_EVENTS[name]}, as seen from wheel edges 0 to 3"


def _relative_delays(evidence: Evidence, chosen: DelayResult) -> list[dict[str, Any]]:
    if not chosen.relative_delays:
        return []
    return [
        {
            "file": recording.source or delay.file,
            "nominal": delay.nominal_s,
            "value": delay.value_s,
            "standard_uncertainty": delay.standard_uncertainty_s,
            "unit": "s",
            **_RELATIVE,
        }
        for recording, delay in zip(evidence.recordings, chosen.relative_delays, strict=True)
    ]


def _geometry(evidence: Evidence) -> dict[str, Any]:
    model, gates = evidence.geometry.model, evidence.geometry.gates
    return {
        "cutout_edges": [float(angle) for angle in model.cutout_edges_rad],
        "cutout_edges_from": evidence.geometry.edges_from,
        "beta_1": gates.application_rad,
        "beta_2": gates.control_rad,
        "gate_height": {"value": gates.height_m, "unit": "m"},
        "camera_roll": evidence.geometry.camera_roll_rad,
        "opening_angle": model.opening_angle_rad,
        "opening_angle_fitted": [fit.opening_angle_rad for fit in evidence.edge_fits],
        "angle_unit": "rad",
    }


def _choices(evidence: Evidence) -> dict[str, Any]:
    chosen = evidence.choices
    return {
        "roi": None if chosen.roi is None else list(chosen.roi),
        "threshold": chosen.threshold_dn,
        "threshold_level": chosen.threshold_level,
        "border_px": chosen.border_px,
        "plateau_margin": chosen.plateau_margin,
        "slope_limits": list(chosen.slope_limits),
        "reference_edge": chosen.reference_edge,
        "search_started_at": [fit.start_delay_s for fit in evidence.edge_fits],
        "fit_arrived_at": [float(np.mean(fit.edge_delay_s)) for fit in evidence.edge_fits],
    }


def _input(recording: ReducedRecording) -> dict[str, Any]:
    opening, view = recording.opening, recording.axle
    return {
        "file": recording.source or recording.name,
        "sha256": recording.sha256,
        "frames": recording.n_frames,
        "trigger_delay_time_set": recording.trigger_delay_time_set_s,
        "integration_time": recording.integration_time_s,
        "rotation_speed": recording.rotation_speed_hz,
        "roi": list(opening.roi),
        "threshold": None if opening.histogram is None else float(opening.histogram.threshold_dn),
        "border_px": opening.border_px,
        "bad_pixels": opening.n_bad_pixels,
        "axle_row_column_px": None if view is None else [view.row_px, view.column_px],
    }
