"""The fits behind a result as plain data, for JSON: joint fit, recording by recording, as published, opening, two constants."""

from dataclasses import asdict, fields
from math import inf
from typing import Any

import numpy as np

from irtiming.records.analysis import Analysis
from irtiming.records.diagnosis import Diagnosis
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.result import LEAST_WHITENESS, Profile
from irtiming.records.row_timing import RowTimingFit, SectorFit, SectorShape
from irtiming.records.two_constants import TwoConstantsResult
from irtiming.report import budget
from irtiming.report.camera_noise import OF_CAMERA
from irtiming.report.meanings import SIGN, edge_delay_name, has_lag, meaning, several_speeds
from irtiming.report.sections import two_constants as wide_range
from irtiming.report.sections.joint_fit import Shared, angles, moved, shared
from irtiming.report.sections.row_sums import published_fits

_OF_WINDOW = {"delay": "middle_of_window", "integration_time": "window"}


def joint_fit(analysis: Analysis) -> dict[str, Any]:
    """Everything that the section of the certificate shows, SI units.

    Returns
    -------
    Keys shared, correlation, steps, moved, reduced_chi_square, birge, whiteness, angles and profiles.
    """
    joint = analysis.joint
    way_s, own = moved(analysis)
    names = {} if has_lag(analysis) else _OF_WINDOW
    numbers = {names.get(one.name, one.name): _number(one) for one in shared(analysis)}
    return {
        "shared": numbers,
        "correlation": {"names": list(numbers), "matrix": joint.parameters.correlation.tolist()},
        "steps": joint.n_steps,
        "decrement": joint.decrement,
        "moved": {"value": way_s, "over_standard_uncertainty": own, "unit": "s"},
        "reduced_chi_square": joint.reduced_chi_square,
        "birge": joint.birge,
        "whiteness": _whiteness(analysis),
        "whiteness_limit": LEAST_WHITENESS,
        "angles": {one.name: _number(one) for one in angles(analysis)},
        "angles_measured": several_speeds(analysis),
        "profiles": {one.name: _profile(one, analysis) for one in analysis.profiles},
    }


def _number(one: Shared) -> dict[str, Any]:
    is_early = one.name.startswith(("edge", "common"))
    return {
        "value": one.value,
        "standard_uncertainty": one.standard_uncertainty,
        "start": one.start,
        "prior_standard_uncertainty": one.prior_uncertainty,
        "value_over_prior": one.over_prior,
        "unit": one.unit,
        "meaning": one.meaning,
        "sign": SIGN if one.name == "delay" else "positive: early" if is_early else None,
    }


def _profile(one: Profile, analysis: Analysis) -> dict[str, Any]:
    means = meaning(one.name, analysis)
    return {
        "value": one.value,
        "standard_uncertainty": one.standard_uncertainty,
        "values": one.values.tolist(),
        "deviation": one.deviation.tolist(),
        "lower": one.lower,
        "upper": one.upper,
        "unit": one.unit,
        "reference_event": means.event,
        "sign": means.sign,
    }


def _whiteness(analysis: Analysis) -> list[dict[str, Any]]:
    return [
        {"file": recording.file, "probability": float(one)}
        for recording, one in zip(analysis.recordings, analysis.joint.whiteness, strict=True)
    ]


def likelihood(analysis: Analysis) -> dict[str, Any]:
    """The joint fit of a lagging camera under its parameters' names."""
    joint = analysis.joint
    names = {"delay": "trigger_delay", "time_constant": "time_constant", "row_delay": "row_delay"}
    return {
        "values": {said: joint.parameters.value(name) for name, said in names.items() if name in joint.parameters},
        "start": {said: joint.start[name] for name, said in names.items() if name in joint.start},
        "unit": "s",
        "steps": joint.n_steps,
        "whiteness": _whiteness(analysis),
        "profiles": {one.name: _profile(one, analysis) for one in analysis.profiles},
    }


def starts(analysis: Analysis) -> list[tuple[float, float]]:
    """Delay where each recording's search began and where it ended, s."""
    return [
        (
            fit.start_delay_s if isinstance(fit, EdgeDelayFit) else fit.start["edge_delay_0"],
            float(np.mean(fit.edge_delay_s)),
        )
        for fit in analysis.fits
    ]


def fit(one: EdgeDelayFit | RowTimingFit, analysis: Analysis) -> dict[str, Any]:
    """One recording's own fit; delays of rows through a window count to its middle."""
    beside = [name for name in (*OF_CAMERA, "opening_angle") if name in one.estimate]
    rows = one if isinstance(one, RowTimingFit) else None
    started = (
        [one.start_delay_s] if isinstance(one, EdgeDelayFit) else [one.start[k] for k in ("edge_delay_0", *beside)]
    )
    return {
        "recording": one.name,
        edge_delay_name(analysis): float(np.mean(one.edge_delay_s)),
        **{name: one.estimate.value(name) for name in beside},
        "search_started_at": started,
        "steps": None if rows is None else rows.n_steps,
        "rows": None if rows is None else [int(rows.row_px[0]), int(rows.row_px[-1])],
        "median_noise": float(np.median(one.noise)),
        "widening": one.variance_inflation,
        "unit": "s",
    }


def published(analysis: Analysis) -> list[dict[str, Any]]:
    """What the published simulation of a lagging camera found; empty of others."""
    return [
        {
            "recordings": list(fit.data.names),
            "trigger_delay_time_set": fit.data.trigger_delay_time_set_s,
            "trigger_delay": fit.timing.trigger_delay_s,
            "time_constant": fit.timing.time_constant_s,
            "row_delay": fit.timing.row_delay_s,
            "time_constants_tried": fit.time_constants_s.tolist(),
            "rms": fit.rms.tolist(),
            "deviation_rms": fit.deviation_rms,
            "unit": "s",
        }
        for fit in published_fits(analysis)
    ]


def opening(found: SectorFit) -> dict[str, Any]:
    """The fitted sector."""
    names = [field.name for field in fields(SectorShape) if field.type is float]
    return {
        **{name: {"value": found.value(name), "standard_uncertainty": found.u(name)} for name in names},
        "mirrored": found.shape.mirrored,
        "row_delay_by_phases": {"value": found.row_delay_s, "standard_uncertainty": found.u_row_delay_s, "unit": "s"},
        "reduced_chi_square": found.reduced_chi_square,
    }


def two_constants(found: TwoConstantsResult | None) -> dict[str, Any] | None:
    """All of it for JSON, SI units."""
    if found is None:
        return None
    around = found.surroundings
    u = np.sqrt(np.diag(found.effective.covariance_s2))
    return {
        "parameters": two_constant_parameters(found),
        "bounds": {
            bound.name: {"lower": bound.lower, "upper": bound.upper, "unit": "s"} for bound in found.bounds
        },
        "correlation": {"names": list(found.estimate.names), "matrix": found.estimate.correlation.tolist()},
        "scene_share": found.scene_share,
        "least_share": found.least_share,
        "substrate_temperature": {"value": around.substrate_temperature_k, "unit": "K"},
        "wheel_temperature": {
            "value": around.wheel_temperature_k, "unit": "K", "from": around.wheel_temperature_from,
        },
        "effective": [
            {
                "blackbody_temperature": float(kelvin), "pixel_temperature": float(pixel), "temperature_unit": "K",
                "value": float(tau), "standard_uncertainty": float(one), "model": float(model), "unit": "s",
            }
            for kelvin, pixel, tau, one, model in zip(
                found.effective.blackbody_temperature_k, found.pixel_temperature_k, found.effective.time_constant_s, u,
                found.model_time_constant_s, strict=True,
            )
        ],
        "effective_correlation": (found.effective.covariance_s2 / np.outer(u, u)).tolist(),
    }  # fmt: skip


def two_constant_parameters(found: TwoConstantsResult | None) -> dict[str, Any]:
    """The two as parameters of the result; none where they are not determined."""
    if found is None:
        return {}
    estimate = found.estimate
    return {
        name: {
            "value": float(value),
            "standard_uncertainty": float(u),
            **budget.expanded_numbers(float(u), inf),
            "unit": "s",
            "reference_event": wide_range.what(name, found),
            "sign": "never negative",
            "reference_temperature": {"value": found.reference_temperature_k, "unit": "K"},
            "change_per_kelvin": {"substrate": float(change[0]), "wheel": float(change[1]), "unit": "s/K"},
        }
        for name, value, u, change in zip(
            estimate.names, estimate.values, estimate.standard_uncertainties, found.change_per_k_s, strict=False
        )
    }


def diagnosis(found: Diagnosis | None) -> dict[str, Any] | None:
    """Causes that were tried and numbers that stand for defects; None where not asked for."""
    if found is None:
        return None
    return {
        "deviance": found.deviance,
        "degrees_of_freedom": found.degrees_of_freedom,
        "causes": [asdict(one) for one in found.causes],
        "fitted": [
            {"name": one.name, "value": one.value.value, "standard_uncertainty": one.value.standard_uncertainty,
             "unit": one.unit, "from_none": one.from_none, "gained": one.gained}
            for one in found.fitted
        ],
    }  # fmt: skip
