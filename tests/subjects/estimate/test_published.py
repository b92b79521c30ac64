"""Delays as published: signs, names and plain means, from lines with known centres."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.estimate.published import slope_delays as published
from irtiming.physics.wheel import slope_centres_rad, wheel_model
from irtiming.records.estimate import PublishedFit, SlopeLine
from irtiming.records.exposed import ExposedFraction

TURN = 2 * np.pi
OMEGA = TURN * 3
MODEL = wheel_model(
    (0.0, 1.5718, 3.1421, 4.7125),
    0.2682,
    opening_angle_rad=float(np.radians(75)),
    centre_angle_rad=float(np.radians(-90)),
)


def _fit(set_delay_s, *, own_delay_s=5e-4, per_edge_s=(0, 0, 0, 0), u_rad=2e-5, rate_hz=3.0, names=("a",)):
    omega = TURN * rate_hz
    nothing = np.zeros(0)
    centres = slope_centres_rad(MODEL) - omega * (set_delay_s + own_delay_s + np.asarray(per_edge_s))
    lines = [
        SlopeLine(
            edge=i,
            centre_rad=float(np.mod(c, TURN)),
            u_centre_rad=u_rad * (1 + i),
            slope_per_rad=0.76,
            reduced_chi_square=1.0,
            angle_rad=nothing,
            fraction=nothing,
        )
        for i, c in enumerate(centres)
    ]
    data = ExposedFraction(
        trigger_delay_time_set_s=set_delay_s,
        rotation_speed_hz=rate_hz,
        angular_frequency_rad_per_s=TURN * rate_hz,
        names=names,
        files=names,
        wheel_angle_rad=nothing,
        fraction=nothing,
        u_wheel_angle_rad=None,
        u_fraction=None,
        plateaus=(),
    )
    return PublishedFit(data=data, lines=tuple(lines), angular_frequency_rad_per_s=omega)


@pytest.mark.parametrize("set_delay_s", [0.0, 0.025, 0.05, 0.075, 0.1])
def test_larger_delay_shifts_the_curve_to_the_left(set_delay_s):
    """Oracle: figure 5's caption; the slopes were put omega t to smaller angles, t comes back, whatever was wrapped."""
    delay, u = published.edge_delays([_fit(set_delay_s)], MODEL)
    np.testing.assert_allclose(delay, 5e-4, atol=1e-12)
    np.testing.assert_allclose(u[0], np.array([2e-5, 4e-5, 6e-5, 8e-5]) / OMEGA)


def test_lines_give_the_middle_and_the_start_lies_half_a_window_earlier():
    """Oracle: by hand; conventions.md, start and middle are both named; falling 0 and 2, rising 1 and 3."""
    edges = (40e-6, -40e-6, 44e-6, -36e-6)
    result = published.estimate([_fit(0.0, per_edge_s=edges)], MODEL, integration_time_s=250e-6)
    found = dict(zip(result.estimate.names, result.estimate.values, strict=True))
    assert found["exposure_midpoint_delay"] == pytest.approx(502e-6, abs=1e-12)
    assert found["trigger_delay"] == pytest.approx(377e-6, abs=1e-12)
    assert found["trigger_delay_falling"] == pytest.approx(417e-6, abs=1e-12)
    assert found["trigger_delay_rising"] == pytest.approx(337e-6, abs=1e-12)
    np.testing.assert_allclose(result.edge_delay_s, 375e-6 + np.array(edges), atol=1e-12)
    assert result.method == "published"


def test_uncertainties_of_plain_means_by_hand():
    """Oracle: by hand; u of a mean of independent centres is the root of the sum of squares over their number."""
    result = published.estimate([_fit(0.0), _fit(0.025)], MODEL, integration_time_s=250e-6)
    u = 2e-5 / OMEGA
    expected = [np.sqrt(2 * 30) / 8, np.sqrt(2 * 30) / 8, np.sqrt(2 * 10) / 4, np.sqrt(2 * 20) / 4]
    np.testing.assert_allclose(result.estimate.standard_uncertainties, u * np.array(expected))
    assert result.estimate.correlation[0, 1] == pytest.approx(1)
    assert result.estimate.correlation[2, 3] == pytest.approx(0)
    total = np.sqrt(sum(c.standard_uncertainty.get("trigger_delay", 0.0) ** 2 for c in result.budget))
    assert total == pytest.approx(result.estimate.standard_uncertainties[0])
    np.testing.assert_allclose(result.u_edge_delay_s, u * np.array([1, 2, 3, 4]) / np.sqrt(2))


def test_unknown_integration_time_reports_the_middle_only():
    """Oracle: the docstring."""
    result = published.estimate([_fit(0.0)], MODEL, integration_time_s=None)
    assert result.estimate.names == ("exposure_midpoint_delay",)
    assert result.estimate.values[0] == pytest.approx(5e-4, abs=1e-12)


def test_relative_delays_by_hand():
    """Oracle: by hand; five nominal delays with the deviations of table 1; the reference has 0 and no uncertainty."""
    deviations = np.array([0, -1.745, -0.652, 3.000, -2.021]) * 1e-6
    made = [_fit(0.025 * k, own_delay_s=5e-4 + d, names=(f"{k}",)) for k, d in enumerate(deviations)]
    relative = published.relative_delays(made)
    np.testing.assert_allclose([r.value_s - r.nominal_s for r in relative], deviations, atol=1e-12)
    assert [r.nominal_s for r in relative] == pytest.approx([0, 0.025, 0.05, 0.075, 0.1])
    assert relative[0].standard_uncertainty_s == 0
    assert relative[1].standard_uncertainty_s == pytest.approx(2e-5 * np.sqrt(2 * 30) / 4 / OMEGA)


def test_every_run_is_named():
    """Oracle: the names of the runs that were averaged."""
    relative = published.relative_delays([_fit(0.0, names=("a", "b")), _fit(0.025, names=("c", "d", "e"))])
    assert [r.file for r in relative] == ["a", "b", "c", "d", "e"]
    assert [r.nominal_s for r in relative] == [0, 0, 0.025, 0.025, 0.025]


def test_each_speed_has_its_own_reference():
    """Oracle: by hand; at 6 Hz the same own delay is twice the angle, which is no relative delay."""
    relative = published.relative_delays([_fit(0.0), _fit(0.025), _fit(0.0, rate_hz=6.0), _fit(0.025, rate_hz=6.0)])
    assert [r.value_s for r in relative] == pytest.approx([0, 0.025, 0, 0.025], abs=1e-12)


def test_limits_of_the_baseline_are_told():
    """Oracle: the uncertainty budget has the scatter only, and the warning says so."""
    result = published.estimate([replace(_fit(0.0))], MODEL, integration_time_s=250e-6)
    assert [c.source for c in result.budget] == ["scatter of the lines"]
    assert "hold the scatter of the line fits only" in result.findings[0].sentence()
