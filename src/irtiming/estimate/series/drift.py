r"""Drift of a camera since an earlier calibration, with what two calibrations on one rig have in common.

.. math:: d = w^T y, \qquad u^2(d) = w^T V w

w is 1/n for the n results of the newest day and -1/m for the m results of the earlier one, V their covariance
(`inference.common_inputs`): an error of the rig that both days share is no drift of the camera. A rig.toml that states other
numbers shares less.
"""

from collections.abc import Iterator, Sequence
from datetime import date

import numpy as np

from irtiming.errors import EstimationError
from irtiming.inference import common_inputs, weighted_line
from irtiming.records.drift import Drift
from irtiming.records.setting_point import SettingPoint, groups, in_time, utc

_DAYS_OF_A_YEAR = 365.25
_FEWEST_DAYS = 3


def drifts(points: Sequence[SettingPoint], *, since: date | None = None) -> tuple[Drift, ...]:
    """Each parameter of each camera, at each setting that was calibrated on two days or more.

    Parameters
    ----------
    points
        Of any cameras, in any order; those that do not say when they were measured are left out.
    since
        The earlier day is the last one up to this; None: the last day before the newest.

    Raises
    ------
    EstimationError
        If a time is none of ISO 8601.
    """
    dated = sorted((one for one in points if one.start_time), key=lambda one: in_time(one.start_time))
    return tuple(found for group in groups(dated) for found in _of_setting(group, since))


def day_of(point: SettingPoint) -> date:
    """Day on which a result was measured, UTC.

    Raises
    ------
    EstimationError
        If its time is none of ISO 8601.
    """
    when = utc(point.start_time)
    if when is None:
        raise EstimationError(
            f"was measured at '{point.start_time:.40}', which is no time of ISO 8601; correct start_time of its recordings",
            where=point.label,
        )
    return when.date()


def _of_setting(group: Sequence[SettingPoint], since: date | None) -> Iterator[Drift]:
    days = [day_of(one) for one in group]
    newest = max(days)
    before = [day for day in days if day < newest and (since is None or day <= since)]
    if not before:
        return
    earlier = max(before)
    for name in group[-1].parameters:
        points = [one for one in group if name in one.parameters]
        if {newest, earlier} <= {day_of(one) for one in points}:
            yield _drift(name, points, newest=newest, earlier=earlier)


def _drift(name: str, points: Sequence[SettingPoint], *, newest: date, earlier: date) -> Drift:
    found, days = [one.parameters[name] for one in points], [day_of(one) for one in points]
    y, u = np.array([one.value for one in found]), np.array([one.standard_uncertainty for one in found])
    covariance = common_inputs.covariance(u, [one.common for one in found])
    is_new, is_old = (np.array([day == which for day in days], dtype=np.float64) for which in (newest, earlier))
    now = is_new / is_new.sum()
    weights = now - is_old / is_old.sum()
    years = np.array([(day - newest).days / _DAYS_OF_A_YEAR for day in days])
    rate = u_rate = None
    n_days = len(set(days))
    if n_days >= _FEWEST_DAYS:
        line = weighted_line.line(years, y, covariance=covariance)
        rate = float(line.coefficients[1])
        u_rate = max(1.0, line.birge) * float(np.sqrt(line.covariance[1, 1]))
    return Drift(
        parameter=name, unit=found[0].unit, earlier=tuple(one for one in points if day_of(one) == earlier),
        newest=tuple(one for one in points if day_of(one) == newest), value=float(now @ y),
        standard_uncertainty=float(np.sqrt(now @ covariance @ now)), change=float(weights @ y),
        u_change=float(np.sqrt(weights @ covariance @ weights)), n_days=n_days, rate_per_year=rate, u_rate_per_year=u_rate,
    )  # fmt: skip
