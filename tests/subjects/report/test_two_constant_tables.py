"""Substrate and scene on the page and in the result, with numbers and with bounds."""

import json
from dataclasses import replace

import numpy as np
import pytest

from irtiming.records.estimate import Estimate
from irtiming.records.result import Bound, EffectiveTimeConstants
from irtiming.records.two_constants import PixelSurroundings, TwoConstantsResult
from irtiming.report import result_of_fits
from irtiming.report.sections import two_constants

NAMES = ("substrate_time_constant", "scene_time_constant")


@pytest.fixture
def told():
    """Three blackbodies, both constants determined."""
    kelvin = np.array([288.15, 303.15, 318.15])
    return TwoConstantsResult(
        estimate=Estimate(
            names=NAMES,
            units=("s",) * len(NAMES),
            values=np.array([8e-3, 16e-3]),
            covariance=np.array([[1e-8, -3.9e-8], [-3.9e-8, 16e-8]]),
        ),
        reference_temperature_k=300.0,
        surroundings=PixelSurroundings(
            substrate_temperature_k=303.15, wheel_temperature_k=296.6, wheel_temperature_from="contrast"
        ),
        effective=EffectiveTimeConstants(
            blackbody_temperature_k=kelvin,
            time_constant_s=np.array([5.339e-3, 5.301e-3, 5.255e-3]),
            covariance_s2=9e-12 * np.eye(3) + 1e-12,
            contrast_dn=kelvin - 296.6,
        ),
        pixel_temperature_k=np.array([299.7, 302.1, 304.8]),
        model_time_constant_s=np.array([5.340e-3, 5.300e-3, 5.256e-3]),
        scene_share=0.33,
        share_scan=np.linspace(0, 0.98, 50),
        deviation=1e3 * (np.linspace(0, 0.98, 50) - 0.33) ** 2,
        least_share=0.1,
        curve_blackbody_k=np.linspace(280, 326, 20),
        curve_time_constant_s=np.linspace(5.37e-3, 5.23e-3, 20),
        change_per_k_s=np.array([[23e-6, 4e-6], [9e-6, 9e-6]]),
        bend_s=np.array([0.03e-6, 0.02e-6, 0.25e-6]),
        bounds=(),
        findings=(),
    )


@pytest.fixture
def bounded(told):
    """Nothing determined."""
    nothing = Estimate(names=(), units=(), values=np.zeros(0), covariance=np.zeros((0, 0)))
    bounds = (
        Bound(name=NAMES[0], lower=5.3e-3, upper=6e-3),
        Bound(name=NAMES[1], lower=40e-3, upper=None),
    )
    return replace(told, estimate=nothing, bounds=bounds, change_per_k_s=np.full((2, 2), np.nan))


def test_table_states_value_temperature_and_what_moves_it(told):
    """Oracle: the record, rounded by hand."""
    table = two_constants.constants(told)
    assert table.rows[0][:5] == ("substrate_time_constant", "8.00 ± 0.10 ms", "200 µs", "+23.0", "+4.0")
    assert table.rows[1][1] == "16.00 ± 0.40 ms"
    assert "300 K" in table.rows[1][5]
    assert "303.15 K, by you" in table.note
    assert "296.60 K, where the contrast vanishes" in table.note
    assert "−0.975" in table.note


def test_table_states_bounds_where_there_is_no_number(bounded):
    """Oracle: the bounds; a correlation of nothing is not told."""
    table = two_constants.constants(bounded)
    assert [row[1] for row in table.rows] == ["5.3 ms … 6 ms", "above 40 ms"]
    assert "Correlation" not in table.note
    assert result_of_fits.two_constant_parameters(bounded) == {}
    assert json.loads(json.dumps(result_of_fits.two_constants(bounded), allow_nan=False))["bounds"][NAMES[1]] == {
        "lower": 0.04, "upper": None, "unit": "s",
    }  # fmt: skip
    assert "not determined apart" in two_constants.panel(bounded).caption


def test_differences_from_the_model_stand_in_the_table(told):
    """Oracle: fitted minus model, by hand."""
    table = two_constants.effective(told)
    assert [row[0] for row in table.rows] == ["288.15", "303.15", "318.15"]
    assert [row[4] for row in table.rows] == ["−1.0", "+1.0", "−1.0"]


def test_page_has_the_section_only_where_it_was_asked_for(told):
    """Oracle: the number of blocks: two tables and a figure, or nothing."""
    assert two_constants.section(None) is None
    section = two_constants.section(told)
    assert section.title == "Wide temperature range"
    assert [block.title for block in section.blocks] == [
        "Separate time constants",
        "Effective time constants",
        "Time constant over the blackbody’s temperature",
    ]
