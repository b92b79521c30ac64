"""Means of the published fits by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate.published import lag_timing as rolling_published
from irtiming.estimate.published import procedure
from irtiming.records.exposed import ExposedRows
from irtiming.records.lag_estimate import LagTiming, PublishedLagFit


@pytest.fixture
def fit():
    """Fit of one nominal delay: ``fit(set_s, (delay, tau, t_row), u, names)``."""

    def make(set_s, values, u, *, names=("run",), rate_hz=3.0, warnings=()):
        nothing = np.zeros(0)
        data = ExposedRows(
            trigger_delay_time_set_s=set_s,
            rotation_speed_hz=rate_hz,
            angular_frequency_rad_per_s=2 * np.pi * rate_hz,
            names=names,
            files=names,
            wheel_angle_rad=nothing,
            fraction=nothing,
            u_fraction=None,
            row_px=np.zeros(0, np.int64),
            row_fraction=nothing,
            u_row_fraction=None,
            mask=np.zeros((2, 2), bool),
        )
        timing, u_timing = (
            LagTiming(trigger_delay_s=three[0], time_constant_s=three[1], row_delay_s=three[2]) for three in (values, u)
        )
        return PublishedLagFit(
            data=data,
            timing=timing,
            u_timing=u_timing,
            initial_timing=timing,
            time_constants_s=nothing,
            rms=nothing,
            parabola=np.zeros(3),
            row_px=np.zeros(0, np.int64),
            delay_of_row_s=nothing,
            simulated_fraction=nothing,
            simulated_row_fraction=nothing,
            deviation_rms=0.0,
            n_simulations=1,
            findings=warnings,
        )

    return make


def test_one_fit_is_the_result(fit):
    """Oracle: its own numbers."""
    result = rolling_published.estimate([fit(0.0, (3.9e-3, 4.8e-3, 38e-6), (3e-6, 4e-6, 5e-8))])
    assert result.method == "published"
    assert result.estimate.names == ("trigger_delay", "time_constant", "row_delay")
    np.testing.assert_allclose(result.estimate.values, [3.9e-3, 4.8e-3, 38e-6])
    np.testing.assert_allclose(result.estimate.standard_uncertainties, [3e-6, 4e-6, 5e-8])
    (relative,) = result.relative_delays
    assert (relative.file, relative.nominal_s, relative.value_s, relative.standard_uncertainty_s) == ("run", 0, 0, 0)
    (line,) = result.budget
    assert line.kind == "A"
    assert line.standard_uncertainty["trigger_delay"] == pytest.approx(3e-6)
    assert line.standard_uncertainty["time_constant"] == pytest.approx(4e-6)
    assert np.isnan(result.edge_delay_s).all()
    assert result.edge_delay_s.shape == result.u_edge_delay_s.shape == (4,)
    assert "the stated uncertainties hold the scatter" in result.findings[-1].sentence()


def test_mean_of_two_fits_has_half_of_the_summed_uncertainty(fit):
    """Oracle: by hand; mean of values, square root of the sum of squares over two."""
    fits = [
        fit(0.0, (3.9e-3, 4.8e-3, 38e-6), (3e-6, 4e-6, 5e-8), names=("a", "b"), warnings=("w", "v")),
        fit(0.025, (3.910e-3, 4.6e-3, 39e-6), (4e-6, 3e-6, 12e-8), names=("c",), warnings=("v",)),
    ]
    result = rolling_published.estimate(fits)
    np.testing.assert_allclose(result.estimate.values, [3.905e-3, 4.7e-3, 38.5e-6])
    np.testing.assert_allclose(result.estimate.standard_uncertainties, [2.5e-6, 2.5e-6, 6.5e-8])
    assert [one.file for one in result.relative_delays] == ["a", "b", "c"]
    assert [one.nominal_s for one in result.relative_delays] == [0, 0, 0.025]
    np.testing.assert_allclose([one.value_s for one in result.relative_delays], [0, 0, 0.02501])
    np.testing.assert_allclose([one.standard_uncertainty_s for one in result.relative_delays], [0, 0, 5e-6])
    assert result.findings[:2] == ("w", "v")
    assert len(result.findings) == 3


def test_relative_delays_are_taken_within_one_speed(fit):
    """Oracle: by hand; an angle error shifts the delays at 6 Hz by 100 us, which is no relative delay."""
    fits = [
        fit(0.0, (3.9e-3, 4.8e-3, 38e-6), (3e-6,) * 3, names=("a",)),
        fit(0.01, (3.902e-3, 4.8e-3, 38e-6), (4e-6,) * 3, names=("b",)),
        fit(0.01, (3.8e-3, 4.8e-3, 38e-6), (3e-6,) * 3, names=("c",), rate_hz=6.0),
        fit(0.03, (3.803e-3, 4.8e-3, 38e-6), (4e-6,) * 3, names=("d",), rate_hz=6.0),
    ]
    for order in (fits, fits[::-1]):
        told = {one.file: one for one in rolling_published.estimate(order).relative_delays}
        assert [told[k].nominal_s for k in "abcd"] == pytest.approx([0, 0.01, 0, 0.02])
        assert [told[k].value_s for k in "abcd"] == pytest.approx([0, 0.010002, 0, 0.020003])


def test_the_row_delay_is_looked_for_from_a_frame_period_over_all_rows(monkeypatch):
    """Oracle: by hand, as in the paper: a frame in 33 ms, 120 rows, 275 us."""
    recording = SimpleNamespace(
        axle=SimpleNamespace(row_px=35.2, column_px=31.3), opening=SimpleNamespace(mask=np.ones((120, 160), bool)),
        trigger_period_s=33e-3,
    )  # fmt: skip
    begun = []
    monkeypatch.setattr(
        procedure.row_delay_and_lag, "fit", lambda *_, initial_row_delay_s, **__: begun.append(initial_row_delay_s)
    )
    geometry = SimpleNamespace(model=None, camera_roll_rad=None, rotation="clockwise")
    procedure._lag_fit(None, geometry, first=recording)
    assert begun == [pytest.approx(275e-6)]


def test_fits_are_left_as_they_were(fit):
    """Oracle: the same object before and after."""
    one = fit(0.0, (3.9e-3, 4.8e-3, 38e-6), (3e-6,) * 3)
    before = replace(one)
    rolling_published.estimate([one])
    assert one.timing == before.timing


def test_a_procedure_that_could_not_be_run_has_no_numbers_and_a_reason():
    """Oracle: nothing is known, so nothing is stated, of none of the four edges."""
    nothing = procedure.without("no slopes", None).result
    np.testing.assert_array_equal([nothing.edge_delay_s, nothing.u_edge_delay_s], np.full((2, 4), np.nan))
    assert nothing.estimate.names == ()
    assert nothing.relative_delays == ()
    (finding,) = nothing.findings
    assert (finding.code, finding.what) == ("published-not-run", "the published procedure could not be run: no slopes")
