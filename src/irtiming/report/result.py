"""The result as plain data, for JSON: the same keys for every camera, SI units, with what the reader needs to judge it."""

from typing import Any

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.finding import Finding
from irtiming.records.result import Contribution, DelayScatter, Result
from irtiming.report import budget, camera_noise, event_words, result_of_fits, result_of_inputs, result_of_wheel
from irtiming.report.combination import combined
from irtiming.report.meanings import (
    RELATIVE_SIGN,
    SIGN,
    delay_name,
    edge_delay_name,
    event,
    has_lag,
    has_pixel_sums,
    headline,
    meaning,
    relative_event,
    unit_of,
)
from irtiming.report.sections.inputs import versions
from irtiming.report.sections.parameters import entries
from irtiming.report.verdict import last_row_read, verdict


def result(analysis: Analysis) -> dict[str, Any]:
    """Result of the chosen method with its counterpart, in SI units.

    Returns
    -------
    Keys method, camera, readout_mode, parameters, bounds, correlation, relative_delays, budget, warnings and
    findings; beside them the fits, the other method, choices, inputs and software. All values are of the types that JSON has.
    """
    return event_words.data(_result(analysis), event_words.event_of(analysis))


def _result(analysis: Analysis) -> dict[str, Any]:
    """The same, as of triggers."""
    core = _core(analysis, analysis.result)
    both = (analysis.best, *(() if analysis.published is None else (analysis.published.result,)))
    two = analysis.two_constants
    return {
        "method": analysis.result.method,
        "camera": analysis.camera_type,
        "readout_mode": analysis.readout_mode,
        "frame_event": event_words.event_of(analysis),
        "item": result_of_inputs.item(analysis.item),
        "simulated": analysis.is_simulated,
        **core,
        "parameters": core["parameters"] | result_of_fits.two_constant_parameters(two),
        "headline": verdict(analysis).sentence,
        "warnings": list(warnings(analysis)),
        "findings": [
            {"code": one.code, "severity": one.severity, "recording": one.recording, "where": one.where, "what": one.what,
             "cure": one.cure}
            for one in analysis.findings
        ],
        "joint_fit": result_of_fits.joint_fit(analysis),
        "likelihood": result_of_fits.likelihood(analysis) if has_lag(analysis) else None,
        "fits": [result_of_fits.fit(one, analysis) for one in analysis.fits],
        "published_fits": result_of_fits.published(analysis),
        "two_constants": result_of_fits.two_constants(two),
        "noise_correlation": _noise(analysis),
        "prediction": _predicted(analysis),
        "diagnosis": result_of_fits.diagnosis(analysis.diagnosis),
        "other_method": next(
            ({"method": other.method, **_core(analysis, other), "warnings": [one.sentence() for one in other.findings]}
             for other in both if other is not analysis.result), None,
        ),
        "geometry": result_of_wheel.geometry(analysis),
        "wheel": result_of_wheel.calibration(analysis.wheel),
        "opening": result_of_fits.opening(analysis.sectors[0]) if analysis.sectors else {},
        "choices": _choices(analysis),
        "inputs": [result_of_inputs.of_recording(recording) for recording in analysis.recordings],
        "rig": result_of_inputs.rig(analysis.rig),
        "software": versions(),
    }  # fmt: skip


def warnings(analysis: Analysis) -> tuple[str, ...]:
    """Findings that a person should know of, doubts before warnings, one sentence each."""
    return tuple(event_words.text(one.sentence(), event_words.event_of(analysis)) for one in doubts(analysis))


def doubts(analysis: Analysis) -> tuple[Finding, ...]:
    """Findings that a person should know of: errors, then doubts, then warnings."""
    order = ("error", "doubt", "warning")
    found = [one for one in analysis.findings if one.severity in order]
    return tuple(sorted(found, key=lambda one: order.index(one.severity)))


def _core(analysis: Analysis, chosen: Result) -> dict[str, Any]:
    relative = {"unit": "s", "reference_event": relative_event(analysis), "sign": RELATIVE_SIGN}
    return {
        "parameters": {name: _parameter(analysis, chosen, name=name) for name in chosen.estimate.names},
        "bounds": {one.name: {"lower": one.lower, "upper": one.upper, "unit": one.unit} for one in chosen.bounds},
        "correlation": {"names": list(chosen.estimate.names), "matrix": chosen.estimate.correlation.tolist()},
        "relative_delays": [
            {
                "file": delay.file,
                "nominal": delay.nominal_s,
                "value": delay.value_s,
                "standard_uncertainty": delay.standard_uncertainty_s,
                "deviation": delay.deviation[0],
                "deviation_standard_uncertainty": delay.deviation[1],
                **relative,
            }
            for delay in chosen.relative_delays
        ],
        "relative_delays_combined": [
            {
                "nominal": row.nominal_s,
                "value": row.value_s,
                "standard_uncertainty": row.standard_uncertainty_s,
                "runs": row.n_runs,
                "scatter_of_runs": row.scatter_s,
                "rotation_speed": {"value": row.rotation_speed_hz, "unit": "Hz"},
                **relative,
            }
            for row in combined(analysis, chosen)
        ],
        "not_in_uncertainty": list(chosen.not_in_uncertainty),
        "last_row_read": _last_row(analysis, chosen),
        "budget": _of_delay(chosen) if has_pixel_sums(analysis) else _by_parameter(chosen, headline(analysis, chosen)),
        "contributions": _by_parameter(chosen, _times(chosen)),
        "edge_delays": _edge_delays(analysis, chosen),
        "falling_rising": _falling_rising(chosen),
        "delay_scatter": _scatter(chosen.delay_scatter),
    }


def _parameter(analysis: Analysis, chosen: Result, *, name: str) -> dict[str, Any]:
    value, u = entries(chosen)[name]
    means = meaning(name, analysis)
    return {
        "value": value,
        "standard_uncertainty": u,
        **budget.expanded_numbers(u, budget.of(chosen, name).degrees_of_freedom),
        "unit": unit_of(name, chosen),
        "reference_event": means.event,
        "sign": means.sign,
    }


def _last_row(analysis: Analysis, chosen: Result) -> dict[str, Any] | None:
    last = last_row_read(analysis, chosen)
    if last is None:
        return None
    what = "reading" if has_lag(analysis) else "start of integration"
    return {
        "row": last[0],
        "value": last[1],
        "standard_uncertainty": last[2],
        "unit": "s",
        "reference_event": f"{what} of the last image row",
        "sign": SIGN,
    }


def _of_delay(chosen: Result) -> list[dict[str, Any]]:
    """Of a camera whose verdict is one delay: the largest first."""
    return [
        {
            "source": line.source,
            "type": line.kind,
            "standard_uncertainty": line.standard_uncertainty,
            "degrees_of_freedom": budget.freedom_number(line.degrees_of_freedom),
            "share_percent": 100 * line.share,
            "unit": "s",
            "measured": _measured(line),
            "sensitivity": line.sensitivity,
        }
        for line in budget.of(chosen, delay_name(chosen)).lines
    ]


def _times(chosen: Result) -> tuple[str, ...]:
    """Parameters that are times."""
    return tuple(name for name in chosen.estimate.names if unit_of(name, chosen) == "s")


def _by_parameter(chosen: Result, names: tuple[str, ...]) -> list[dict[str, Any]]:
    """In the order of the estimation; shares by parameter."""
    found = {name: budget.of(chosen, name) for name in names}
    return [
        {
            "source": part.source,
            "type": part.kind,
            "standard_uncertainty": {name: part.standard_uncertainty.get(name, 0.0) for name in names},
            "degrees_of_freedom": budget.freedom_number(part.degrees_of_freedom),
            "share_percent": {name: 100 * found[name].share(part.source) for name in names},
            "unit": "s",
            "measured": _measured(part),
            "sensitivity": None if not part.measured or part.measured[0] <= 0 else {
                name: part.standard_uncertainty.get(name, 0.0) / part.measured[0] for name in names
            },
        }
        for part in chosen.budget
    ]  # fmt: skip


def _measured(line: Contribution | budget.Line) -> dict[str, Any] | None:
    """A measured quantity, where the line follows from one such number."""
    if line.measured is None:
        return None
    return {"standard_uncertainty": line.measured[0], "unit": line.measured[1]}


def _scatter(found: DelayScatter | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {
        "standard_deviation": found.standard_deviation_s if found.is_sure else None,
        "standard_uncertainty": found.u_s if found.is_sure else None,
        "upper_limit": found.upper_limit_s,
        "unit": "s",
    }


def _falling_rising(chosen: Result) -> dict[str, Any] | None:
    """None where one wheel speed does not tell the time from the angle."""
    found = chosen.falling_rising
    if found is None:
        return None
    words = ("time", "angle")
    return {
        word: {"value": float(value), "standard_uncertainty": float(u), "unit": unit}
        for word, value, u, unit in zip(words, found.values, found.standard_uncertainties, found.units, strict=True)
    } | {"covariance": float(found.covariance[0, 1]), "covariance_unit": "s rad"}


def _edge_delays(analysis: Analysis, chosen: Result) -> dict[str, Any] | None:
    """None where the method does not tell edges apart, or could not be run."""
    if not np.isfinite(chosen.edge_delay_s).all():
        return None
    return {
        "value": [float(v) for v in chosen.edge_delay_s],
        "standard_uncertainty": [float(u) for u in chosen.u_edge_delay_s],
        "unit": "s",
        "reference_event": f"{event(edge_delay_name(analysis), analysis)}, by wheel edges 0 to 3",
        "sign": SIGN,
    }


def _noise(analysis: Analysis) -> dict[str, Any]:
    found = camera_noise.noise(analysis)
    both = {
        f"{found.names[0]}_{word}_time_constant": {
            "standard_uncertainty": camera_noise.u_of_sum(found, {found.names[0]: 1.0, "time_constant": sign}), "unit": "s",
        }
        for word, sign in (("minus", -1.0), ("plus", 1.0)) if "time_constant" in found
    }  # fmt: skip
    return {
        "names": list(found.names),
        "matrix": found.correlation.tolist(),
        "standard_uncertainty": found.standard_uncertainties.tolist(),
        **both,
        "unit": "s",
    }


def _predicted(analysis: Analysis) -> dict[str, Any] | None:
    """Predicted standard uncertainties with their parts, and the camera in the words of `irtiming plan --like`.

    None where nothing was predicted. ``ratio`` is the stated standard uncertainty of the default method over the predicted one.
    """
    found, stated = analysis.prediction, entries(analysis.best)
    if found is None:
        return None
    camera: dict[str, Any] = {
        "camera": analysis.camera_type, "readout_mode": analysis.readout_mode, "noise_to_contrast": found.noise_to_contrast,
        "opening_pixels": found.opening_pixels, "unit": "s",
    }  # fmt: skip
    if has_lag(analysis):
        camera["time_constant"] = stated["time_constant"][0] if "time_constant" in stated else None
    else:
        camera["integration_time"] = analysis.recordings[0].integration_time_s
    if "row_delay" in stated:
        camera["row_delay"] = stated["row_delay"][0]
    return {
        "camera": camera,
        "parameters": {
            each.name: {
                "predicted_standard_uncertainty": each.standard_uncertainty_s,
                "ratio": stated[each.name][1] / each.standard_uncertainty_s
                if each.name in stated and each.standard_uncertainty_s > 0
                else None,
                "parts": [
                    {"source": part.source, "standard_uncertainty": part.standard_uncertainty_s} for part in each.parts
                ],
                "unit": "s",
            }
            for each in found.uncertainties
        },
        "relative_delays": [
            {
                "nominal": each.nominal_s,
                "rotation_speed": {"value": each.rotation_speed_hz, "unit": "Hz"},
                "predicted_standard_uncertainty": each.standard_uncertainty_s,
                "unit": "s",
            }
            for each in found.relative_delays
        ],
    }


def _choices(analysis: Analysis) -> dict[str, Any]:
    chosen = analysis.choices
    fits = result_of_fits.starts(analysis)
    return {
        "roi": None if chosen.roi is None else list(chosen.roi),
        "threshold": chosen.threshold_dn,
        "threshold_level": chosen.threshold_level,
        "border_px": chosen.border_px,
        "plateau_margin": chosen.plateau_margin,
        "slope_limits": list(chosen.slope_limits),
        "reference_edge": chosen.reference_edge,
        "substrate_temperature": chosen.substrate_temperature_k,
        "wheel_temperature": chosen.wheel_temperature_k,
        "search_started_at": [start for start, _ in fits],
        "fit_arrived_at": [end for _, end in fits],
    }
