"""Drift of a camera over three days: by hand."""

from dataclasses import replace

import pytest

from irtiming.estimate.series.drift import drifts
from irtiming.records.setting_point import CameraKey, PointParameter, SettingPoint

_CAMERA = CameraKey(
    manufacturer="m", model="k", serial_number="1", camera_type="photon detector", readout_mode="snapshot"
)
_DAYS = ("2016-01-01", "2020-01-01", "2024-01-01")  # 1461 days, four years, apart


def _points(values, u=0.5, common=None):
    return [
        SettingPoint(
            label=day,
            camera=_CAMERA,
            settings={},
            start_time=f"{day}T12:00:00Z",
            parameters={
                "trigger_delay": PointParameter(
                    value=value, standard_uncertainty=u, unit="s", expanded_uncertainty=2 * u, common=common or {}
                )
            },
        )
        for day, value in zip(_DAYS, values, strict=True)
    ]


def _drift_of(values, **more):
    (found,) = drifts(_points(values, **more))
    return found


def test_the_rate_of_days_on_a_line_is_as_uncertain_as_its_days():
    """Oracle: by hand; 1, 2 and 3 at -8, -4 and 0 years rise by 1/4 a year; squares about their middle are 32."""
    found = _drift_of([1.0, 2.0, 3.0])
    assert found.rate_per_year == pytest.approx(0.25)
    assert found.u_rate_per_year == pytest.approx(0.5 / 32**0.5)
    assert (found.value, found.change) == (pytest.approx(3.0), pytest.approx(1.0))
    assert ([one.label for one in found.earlier], [one.label for one in found.newest]) == (
        ["2020-01-01"],
        ["2024-01-01"],
    )
    assert found.u_change == pytest.approx(0.5 * 2**0.5)


def test_days_that_scatter_make_the_rate_less_certain():
    """Oracle: by hand; 0, 3 and 0 lie -1, 2 and -1 beside their level: 6 / 0.5^2 for one degree of freedom."""
    found = _drift_of([0.0, 3.0, 0.0])
    assert found.rate_per_year == pytest.approx(0.0, abs=1e-12)
    assert found.u_rate_per_year == pytest.approx(24**0.5 * 0.5 / 32**0.5)


def test_what_all_days_have_in_common_is_no_drift():
    """Oracle: by hand; of u = 0.5, 0.4 is common: 0.3 is each day's own."""
    found = _drift_of([1.0, 2.0, 3.0], common={"gate": 0.4})
    assert found.u_rate_per_year == pytest.approx(0.3 / 32**0.5)
    assert found.u_change == pytest.approx(0.3 * 2**0.5)
    assert found.standard_uncertainty == pytest.approx(0.5)


def test_a_camera_that_is_read_out_in_two_ways_has_a_drift_of_each():
    """Oracle: by hand; the last change of one is 1, of the other 5."""
    rolling = replace(_CAMERA, readout_mode="rolling")
    points = [*_points([1.0, 2.0, 3.0]), *(replace(one, camera=rolling) for one in _points([7.0, 2.0, 7.0]))]
    found = {one.newest[0].camera.readout_mode: one.change for one in drifts(points)}
    assert found == {"snapshot": pytest.approx(1.0), "rolling": pytest.approx(5.0)}
