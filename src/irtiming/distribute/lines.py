"""Lines of a campaign's table: all results of a camera at one setting together, held against the limits.

Results of one camera on one rig have the rig's errors in common, so their mean keeps these (`inference.common_inputs`). Where
they lie further apart than their own parts allow, u is widened by the ratio of Birge.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from irtiming.archive.certificate_file import limit_of
from irtiming.archive.limits_file import LimitsFile
from irtiming.inference import common_inputs, weighted_line
from irtiming.records.campaign import WORST_FIRST, CampaignLine, CampaignPoint, JudgedValue, Judgement
from irtiming.records.setting_point import PointParameter, SettingPoint, groups, in_time
from irtiming.report import budget
from irtiming.report.calibration.decision import Outcome, judged

_DOUBTFUL = 0.05  # probability of a chi-squared as large, below which u is widened
_WORDS: dict[Outcome, Judgement] = {
    "pass": "pass", "conditionalPass": "conditional pass", "conditionalFail": "conditional fail", "fail": "fail",
}  # fmt: skip


def of(points: Sequence[CampaignPoint], limits: LimitsFile) -> tuple[CampaignLine, ...]:
    """One line for each camera and setting, in order of model, serial number and setting.

    Parameters
    ----------
    points
        Of any cameras.
    limits
        For some parameters, or none.
    """
    return tuple(_line(group, limits) for group in groups(sorted((one.point for one in points), key=_order)))


def _order(one: SettingPoint) -> tuple[object, ...]:
    settings = sorted((name, f"{value:024.12f}" if isinstance(value, float | int) else value)
                      for name, value in one.settings.items() if name != "sensor_temperature")  # fmt: skip
    return one.camera.model, one.camera.serial_number, str(settings), in_time(one.start_time), one.label


def _line(group: Sequence[SettingPoint], limits: LimitsFile) -> CampaignLine:
    camera = group[0].camera
    names = list(dict.fromkeys(name for one in group for name in one.parameters))
    values = {
        name: _held(
            mean([one.parameters[name] for one in group if name in one.parameters]),
            limits,
            name=name,
            serial=camera.serial_number,
        )
        for name in names
    }
    asked = [one.parameter for one in limits.limit if one.serial_number in (None, camera.serial_number)]
    judgements: list[Judgement] = [one.judgement for one in values.values()]
    judgements += ["not measured" for name in asked if name not in values]
    settings = dict(group[0].settings)
    temperatures = [float(one.settings["sensor_temperature"]) for one in group if "sensor_temperature" in one.settings]
    if temperatures:
        settings["sensor_temperature"] = float(np.mean(temperatures))
    return CampaignLine(
        camera=camera, settings=settings, values=values, judgement=min(judgements, key=WORST_FIRST.index, default="no limits"),
        n_results=len(group), n_recordings=sum(one.n_recordings for one in group),
        first_measured=min((one.start_time for one in group if one.start_time), key=in_time, default=""),
        findings=tuple(code for one in group for code in one.findings), simulated=any(one.simulated for one in group),
    )  # fmt: skip


def mean(values: Sequence[PointParameter]) -> JudgedValue:
    """Results of one camera at one setting as one value; none is counted more than it says for itself.

    Parameters
    ----------
    values
        At least one.
    """
    if len(values) == 1:
        one = values[0]
        return JudgedValue(
            value=one.value, standard_uncertainty=one.standard_uncertainty, expanded_uncertainty=one.expanded_uncertainty,
            degrees_of_freedom=one.degrees_of_freedom, unit=one.unit,
        )  # fmt: skip
    u = np.array([one.standard_uncertainty for one in values])
    covariance = common_inputs.covariance(u, [one.common for one in values])
    own = np.array([max(one.standard_uncertainty**2 - sum(c**2 for c in one.common.values()), 1e-12 * one.standard_uncertainty**2)
                    for one in values])  # fmt: skip
    found = weighted_line.level(np.array([one.value for one in values]), covariance=covariance)
    birge = found.birge if found.probability < _DOUBTFUL else 1.0
    spread = (birge**2 - 1) / float(np.sum(1 / own))  # the own parts alone grow
    variance = float(found.covariance[0, 0]) + max(0.0, spread)
    freedom = max(1.0, min(one.degrees_of_freedom for one in values) if birge == 1.0 else found.degrees_of_freedom)
    whole = float(np.sqrt(variance))
    return JudgedValue(
        value=float(found.coefficients[0]), standard_uncertainty=whole,
        expanded_uncertainty=budget.coverage_factor(freedom) * whole, degrees_of_freedom=freedom,
        unit=values[0].unit, birge=birge,
    )  # fmt: skip


def _held(found: JudgedValue, limits: LimitsFile, *, name: str, serial: str) -> JudgedValue:
    """The same against its limits."""
    limit = limit_of(limits.limit, parameter=name, serial_number=serial)
    if limit is None:
        return found
    lower, upper = limit.bounds_s
    said = judged(
        found.value, u=found.standard_uncertainty, expanded=found.expanded_uncertainty,
        degrees_of_freedom=found.degrees_of_freedom, limits=(lower, upper), rule=limits.decision.rule,
    )  # fmt: skip
    return replace(found, lower=lower, upper=upper, judgement=_WORDS[said.outcome], probability=said.probability)
