"""The result of a rolling camera as plain data, for JSON: shared format of all cameras, with what the reader needs."""

from dataclasses import fields
from typing import Any

import numpy as np

from irtiming.records.reduced import ReducedRecording
from irtiming.records.rolling_result import RollingResult
from irtiming.records.row_timing import RowTimingFit
from irtiming.report import budget, joint_result, rolling_noise, two_constant_tables, wheel_result
from irtiming.report.evidence import RollingEvidence
from irtiming.report.prediction_result import predicted
from irtiming.report.result import edge_delays
from irtiming.report.rolling_tables import EVENTS, NAMES, RELATIVE_EVENT, SIGNS, entries
from irtiming.report.tables import RELATIVE_SIGN, SIGN, versions

_NOT_FITTED = ("mirrored", "image_rows", "image_columns")


def result(evidence: RollingEvidence) -> dict[str, Any]:
    """Result of the chosen method with its counterpart, in SI units.

    Returns
    -------
    Keys method, camera, parameters, correlation, relative_delays, warnings as the format asks; beside them bounds, budget,
    edge_delays, last_row_read, noise_correlation, two_constants, other_method, geometry, opening, fits, choices, inputs and
    software.
    """
    other = evidence.best if evidence.result is evidence.as_published else evidence.as_published
    core = _core(evidence, evidence.result)
    return {
        "method": evidence.result.method,
        "camera": "microbolometer",
        **core,
        "parameters": core["parameters"] | two_constant_tables.parameters(evidence.two_constants),
        "warnings": list(evidence.warnings),
        "two_constants": two_constant_tables.result(evidence.two_constants),
        "noise_correlation": _noise(evidence),
        "prediction": predicted(evidence, kind="microbolometer"),
        "other_method": {"method": other.method, **_core(evidence, other), "warnings": list(other.warnings)},
        "geometry": _geometry(evidence),
        "wheel": wheel_result.result(evidence.wheel),
        "opening": _opening(evidence),
        "fits": [_fit(fit) for fit in evidence.row_fits],
        "likelihood": _likelihood(evidence),
        "published_fits": _published(evidence),
        "choices": _choices(evidence),
        "inputs": [_input(recording) for recording in evidence.recordings],
        "rig": {"file": evidence.rig.source, "sha256": evidence.rig.sha256},
        "software": versions(),
    }


def last_row_read(evidence: RollingEvidence, chosen: RollingResult) -> tuple[int, float, float] | None:
    """Last row of the image, when it is read after the trigger edge, and the standard uncertainty of that, s."""
    names = chosen.estimate.names
    if not {"trigger_delay", "row_delay"} <= set(names):
        return None
    row = evidence.recordings[0].opening.mask.shape[0] - 1
    weights = np.zeros(len(names))
    weights[names.index("trigger_delay")], weights[names.index("row_delay")] = 1.0, float(row)
    variance = float(weights @ chosen.estimate.covariance @ weights)
    return row, float(weights @ chosen.estimate.values), float(np.sqrt(max(variance, 0.0)))


def _core(evidence: RollingEvidence, chosen: RollingResult) -> dict[str, Any]:
    last = last_row_read(evidence, chosen)
    return {
        "parameters": {
            name: {
                "value": value,
                "standard_uncertainty": u,
                **budget.expanded_numbers(u, budget.of_rolling(chosen, name).degrees_of_freedom),
                "unit": "s",
                "reference_event": EVENTS[name],
                "sign": SIGNS[name],
            }
            for name, value, u in entries(chosen)
        },
        "bounds": {
            bound.name: {"lower": bound.lower_s, "upper": bound.upper_s, "unit": "s"} for bound in chosen.bounds
        },
        "correlation": {"names": list(chosen.estimate.names), "matrix": chosen.estimate.correlation.tolist()},
        "relative_delays": [
            {
                "file": recording.source or delay.file,
                "nominal": delay.nominal_s,
                "value": delay.value_s,
                "standard_uncertainty": delay.standard_uncertainty_s,
                "unit": "s",
                "reference_event": RELATIVE_EVENT,
                "sign": RELATIVE_SIGN,
            }
            for recording, delay in zip(evidence.recordings, chosen.relative_delays, strict=False)
        ],
        "last_row_read": None
        if last is None
        else {
            "row": last[0],
            "value": last[1],
            "standard_uncertainty": last[2],
            "unit": "s",
            "reference_event": "reading of the last image row",
            "sign": SIGN,
        },
        "budget": _budget(chosen),
        "edge_delays": edge_delays(chosen, event="reading of image row 0, as seen from wheel edges 0 to 3"),
    }


def _budget(chosen: RollingResult) -> list[dict[str, Any]]:
    """In the order of the estimation; shares by parameter."""
    found = {name: budget.of_rolling(chosen, name) for name in NAMES}
    return [
        {
            "source": part.source,
            "type": part.kind,
            "standard_uncertainty": {name: getattr(part, f"{name}_s") for name in NAMES},
            "degrees_of_freedom": budget.freedom_number(part.degrees_of_freedom),
            "share_percent": {name: 100 * budget.share(found[name], part.source) for name in NAMES},
            "unit": "s",
        }
        for part in chosen.budget
    ]


def _likelihood(evidence: RollingEvidence) -> dict[str, Any]:
    found = evidence.likelihood
    return {
        "values": dict(zip(NAMES, (float(value) for value in found.values), strict=True)),
        "start": dict(zip(NAMES, (float(value) for value in found.start), strict=True)),
        "unit": "s",
        "steps": found.n_steps,
        "whiteness": joint_result.whiteness(evidence.recordings, found.whiteness),
        "profiles": {
            one.name: joint_result.profile(one, event=EVENTS[one.name], sign=SIGNS[one.name]) for one in found.profiles
        },
    }


def _noise(evidence: RollingEvidence) -> dict[str, Any]:
    found = rolling_noise.noise(evidence.row_fits)
    return {
        "names": list(rolling_noise.NAMES),
        "matrix": found.correlation.tolist(),
        "standard_uncertainty": [float(u) for u in found.u_s],
        "trigger_delay_minus_time_constant": {"standard_uncertainty": found.u_difference_s, "unit": "s"},
        "trigger_delay_plus_time_constant": {"standard_uncertainty": found.u_sum_s, "unit": "s"},
        "unit": "s",
    }


def _geometry(evidence: RollingEvidence) -> dict[str, Any]:
    model, gates = evidence.geometry.model, evidence.geometry.gates
    return {
        "cutout_edges": [float(angle) for angle in model.cutout_edges_rad],
        "cutout_edges_from": evidence.geometry.edges_from,
        "beta_1": gates.application_rad,
        "beta_2": gates.control_rad,
        "gate_height": {"value": gates.height_m, "unit": "m"},
        "camera_roll": evidence.geometry.camera_roll_rad,
        "angle_unit": "rad",
    }


def _opening(evidence: RollingEvidence) -> dict[str, Any]:
    found = evidence.sector
    names = [field.name for field in fields(found.shape) if field.name not in _NOT_FITTED]
    u = np.sqrt(np.diag(found.covariance))
    return {
        **{
            name: {"value": float(getattr(found.shape, name)), "standard_uncertainty": float(u[k])}
            for k, name in enumerate(names)
        },
        "mirrored": found.shape.mirrored,
        "row_delay_by_phases": {
            "value": found.row_delay_s,
            "standard_uncertainty": found.u_row_delay_s,
            "unit": "s",
        },
        "reduced_chi_square": found.reduced_chi_square,
    }


def _fit(fit: RowTimingFit) -> dict[str, Any]:
    return {
        "recording": fit.name,
        "trigger_delay": float(fit.edge_delay_s.mean()),
        "time_constant": fit.estimate.value("time_constant"),
        "row_delay": fit.row_delay_s,
        "search_started_at": [fit.start["edge_delay_0"], fit.start["time_constant"], fit.start["row_delay"]],
        "steps": fit.n_steps,
        "rows": [int(fit.row_px[0]), int(fit.row_px[-1])],
        "median_noise": float(np.median(fit.noise)),
        "widening": fit.widening,
        "unit": "s",
    }


def _published(evidence: RollingEvidence) -> list[dict[str, Any]]:
    return [
        {
            "recordings": list(fit.data.names),
            "trigger_delay_time_set": fit.data.trigger_delay_time_set_s,
            "trigger_delay": fit.timing.trigger_delay_s,
            "time_constant": fit.timing.time_constant_s,
            "row_delay": fit.timing.row_delay_s,
            "time_constants_tried": [float(tau) for tau in fit.time_constants_s],
            "rms": [float(rms) for rms in fit.rms],
            "deviation_rms": fit.deviation_rms,
            "unit": "s",
        }
        for fit in evidence.published_fits
    ]


def _choices(evidence: RollingEvidence) -> dict[str, Any]:
    chosen = evidence.choices
    return {
        "roi": None if chosen.roi is None else list(chosen.roi),
        "border_px": chosen.border_px,
        "threshold_level": chosen.threshold_level,
        "reference_edge": chosen.reference_edge,
        "substrate_temperature": chosen.substrate_temperature_k,
        "wheel_temperature": chosen.wheel_temperature_k,
    }


def _input(recording: ReducedRecording) -> dict[str, Any]:
    opening, view = recording.opening, recording.axle
    return {
        "file": recording.source or recording.name,
        "sha256": recording.sha256,
        "frames": recording.n_frames,
        "frames_used": int(recording.frame_index.size),
        "trigger_delay_time_set": recording.trigger_delay_time_set_s,
        "rotation_speed": recording.rotation_speed_hz,
        "blackbody_temperature": recording.blackbody_temperature_k,
        "roi": list(opening.roi),
        "border_px": opening.border_px,
        "bad_pixels": opening.n_bad_pixels,
        "blackbody_is_colder": bool(opening.blackbody_is_colder),
        "shutter_events": [
            {"first_frame": int(event.first_frame), "end_frame": int(event.end_frame), "kind": event.kind}
            for event in recording.shutter_events
        ],
        "axle_row_column_px": None if view is None else [view.row_px, view.column_px],
    }
