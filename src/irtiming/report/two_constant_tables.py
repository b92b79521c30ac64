"""The constants of substrate and scene as tables, and as plain data for JSON."""

from math import inf
from typing import Any

import numpy as np

from irtiming.records.two_constants import TwoConstantsResult
from irtiming.report import budget
from irtiming.report.rolling_tables import bound_text
from irtiming.report.rounding import fixed, signed, time_text
from irtiming.report.tables import Table

MS, US = 1e-3, 1e-6
NAMES = ("substrate_time_constant", "scene_time_constant")
_WHAT = {
    "substrate_time_constant": "exchange of heat with the detector’s substrate alone, by conduction",
    "scene_time_constant": "exchange of heat with the scene alone, by radiation, for a pixel at {kelvin:g} K",
}
_WHEEL_FROM = {"you": "by you", "contrast": "where the contrast vanishes", "assumption": "assumed"}


def constants(found: TwoConstantsResult) -> Table:
    """Both constants, or what is known of them, and what they rest on."""
    change = found.change_per_k_s
    names = found.estimate.names
    rows = []
    for k, name in enumerate(NAMES):
        what = _what(name, found)
        if name in names:
            value, u = float(found.estimate.values[k]), float(found.estimate.standard_uncertainties[k])
            moved = [f"{1e6 * one:+.1f}".replace("-", "−") for one in change[k]]
            rows.append((name, time_text(value, u), budget.expanded_text(u, inf)[0], *moved, what))
        else:
            rows.append((name, bound_text(next(b for b in found.bounds if b.name == name)), "–", "–", "–", what))
    around = found.surroundings
    return Table(
        title="Separate time constants",
        columns=(
            "parameter", "value ± u", f"U\u00a0(k\u00a0=\u00a0{budget.coverage_factor(inf):.2f})", "per K of substrate (µs)",
            "per K of wheel (µs)", "what it is",
        ),
        align="lrrrrl",
        rows=tuple(rows),
        note=f"Substrate at {around.substrate_temperature_k:.2f} K, by you; solid wheel like {around.wheel_temperature_k:.2f} K, "
        f"{_WHEEL_FROM[around.wheel_temperature_from]}. u holds the uncertainty of the effective constants alone, not that "
        "of these temperatures: what a kelvin of either would change stands in the report."
        + (f" Correlation of the two: {fixed(float(found.estimate.correlation[0, 1]), 3)}." if names else ""),
    )  # fmt: skip


def effective(found: TwoConstantsResult) -> Table:
    """The constant that was fitted at each blackbody temperature beside the model."""
    u = np.sqrt(np.diag(found.effective.covariance_s2))
    rows = tuple(
        (f"{kelvin:.2f}", f"{pixel:.2f}", time_text(float(tau), float(one)), time_text(float(model)),
         signed(float(tau - model), float(one), unit_s=US), f"{1e6 * bend:.2f}")
        for kelvin, pixel, tau, one, model, bend in zip(
            found.effective.blackbody_temperature_k, found.pixel_temperature_k, found.effective.time_constant_s, u,
            found.model_time_constant_s, found.bend_s, strict=True,
        )
    )  # fmt: skip
    return Table(
        title="Effective time constants",
        columns=(
            "blackbody (K)", "pixel, middle (K)", "fitted ± u", "two constants", "difference (µs)", "for bending (µs)",
        ),
        align="rrrrrr",
        rows=rows,
        note="A pixel lies between scene and substrate; warmer, it radiates more per kelvin and is faster. For bending: what the "
        "model adds because the answer to a large step is no exponential.",
    )  # fmt: skip


def result(found: TwoConstantsResult | None) -> dict[str, Any] | None:
    """All of it for JSON, SI units."""
    if found is None:
        return None
    around = found.surroundings
    u = np.sqrt(np.diag(found.effective.covariance_s2))
    return {
        "parameters": parameters(found),
        "bounds": {
            bound.name: {"lower": bound.lower_s, "upper": bound.upper_s, "unit": "s"} for bound in found.bounds
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


def parameters(found: TwoConstantsResult | None) -> dict[str, Any]:
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
            "reference_event": _what(name, found),
            "sign": "never negative",
            "reference_temperature": {"value": found.reference_temperature_k, "unit": "K"},
            "change_per_kelvin": {"substrate": float(change[0]), "wheel": float(change[1]), "unit": "s/K"},
        }
        for name, value, u, change in zip(
            estimate.names, estimate.values, estimate.standard_uncertainties, found.change_per_k_s, strict=False
        )
    }


def _what(name: str, found: TwoConstantsResult) -> str:
    return _WHAT[name].format(kelvin=found.reference_temperature_k)
