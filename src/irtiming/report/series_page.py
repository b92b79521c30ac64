"""The page of a series over settings, and the same as plain data."""

from datetime import datetime
from typing import Any

import numpy as np

from irtiming.records.setting_point import SETTINGS
from irtiming.records.setting_series import CameraSeries, LineFit, OverSetting
from irtiming.report.language import several, t, with_capital
from irtiming.report.meanings import words
from irtiming.report.page import Content, Verdict, Warned, render
from irtiming.report.sections import over_settings


def page(series: tuple[CameraSeries, ...], *, created: datetime | None = None) -> str:
    """One HTML page without any link to the outside.

    Parameters
    ----------
    series
        Of one camera or several.
    created
        Date to print; now, where none is given.
    """
    return render(
        Content(
            heading=t("Timing of a camera over its settings")
            if len(series) == 1
            else t("Timing of cameras over their settings"),
            verdict=verdict(series),
            warnings=tuple(Warned(text=one) for one in over_settings.doubts(series)),
            sections=over_settings.sections(series),
        ),
        created=created,
    )


def verdict(series: tuple[CameraSeries, ...]) -> Verdict:
    """The slope that a reader asks for first."""
    over = [each for one in series for each in one.over]
    results = sum(len(one.points) for one in series)
    simulated = (
        (t("SIMULATED: results of no real camera."),) if any(p.simulated for one in series for p in one.points) else ()
    )
    if not over:
        return Verdict(
            number=t("no settings to compare"),
            sentence=t(
                "{results} of {cameras}: no two of one camera differ in one setting alone that both of them state.",
                results=several(results, "result"),
                cameras=several(len(series), "camera"),
            ),
            remarks=simulated,
        )
    first = over[0]
    return Verdict(
        number=t("{what}: slope {slope}", what=_what(first), slope=over_settings.slope_text(first)),
        sentence=t(
            "{results} of {cameras}; slopes with standard uncertainties (k = 1), in which what all results have in "
            "common hardly counts. Agrees with {meaning}.",
            results=several(results, "result"),
            cameras=several(len(series), "camera"),
            meaning=over_settings.meaning(first),
        ),
        remarks=(
            *(
                t("{what}: slope {slope}.", what=with_capital(_what(one)), slope=over_settings.slope_text(one))
                for one in over[1:4]
            ),
            *simulated,
        ),
    )


def _what(one: OverSetting) -> str:
    return t(
        "{parameter} over {setting}", parameter=words(one.parameter), setting=over_settings.setting_name(one.setting)
    )


def as_json(series: tuple[CameraSeries, ...]) -> dict[str, Any]:
    """The same as plain data, SI units."""
    return {"format": "irtiming-series", "version": "1.0", "cameras": [_camera(one) for one in series]}


def _camera(one: CameraSeries) -> dict[str, Any]:
    key = one.camera
    return {
        "manufacturer": key.manufacturer or None,
        "model": key.model or None,
        "serial_number": key.serial_number or None,
        "camera": key.camera_type,
        "readout_mode": key.readout_mode,
        "results": [
            {
                "file": each.label,
                "settings": dict(each.settings),
                "parameters": {
                    name: {"value": p.value, "standard_uncertainty": p.standard_uncertainty, "unit": p.unit}
                    for name, p in each.parameters.items()
                },
                "simulated": each.simulated,
            }
            for each in one.points
        ],
        "over_settings": [_over(each) for each in one.over],
    }


def _over(one: OverSetting) -> dict[str, Any]:
    slope, u = one.slope
    beyond, u_beyond = one.differences
    return {
        "parameter": one.parameter,
        "unit": one.unit,
        "setting": one.setting,
        "setting_unit": SETTINGS[one.setting][1],
        "files": [each.label for each in one.points],
        "settings": one.x.tolist(),
        "values": one.values.tolist(),
        "covariance": one.covariance.tolist(),
        "beyond_first": beyond.tolist(),
        "beyond_first_standard_uncertainty": u_beyond.tolist(),
        "slope": {"value": slope, "standard_uncertainty": u, "agrees_with": list(one.simple_slopes)},
        "level": _fit(one.level),
        "line": _fit(one.line),
        "step": None if one.step is None else {
            "after": one.step.after, "before": one.step.before, "size": one.step.size,
            "standard_uncertainty": one.step.standard_uncertainty, "chance": one.step.p_value,
        },
    }  # fmt: skip


def _fit(fit: LineFit) -> dict[str, Any]:
    return {
        "coefficients": fit.coefficients.tolist(),
        "standard_uncertainties": np.sqrt(np.diag(fit.covariance)).tolist(),
        "covariance": fit.covariance.tolist(),
        "residuals": fit.residuals.tolist(),
        "chi_squared": fit.chi_squared,
        "degrees_of_freedom": fit.degrees_of_freedom,
        "probability": fit.probability,
    }
