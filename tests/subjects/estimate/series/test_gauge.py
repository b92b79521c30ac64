"""Gauge repeatability and reproducibility: by hand, by the book, and by another program."""

import numpy as np
import pandas
import pytest
from statsmodels.formula.api import ols
from statsmodels.stats.anova import anova_lm

from irtiming.estimate.series.gauge import studies, study
from irtiming.records.campaign import CampaignPoint
from irtiming.records.setting_point import CameraKey, PointParameter, SettingPoint

AIAG = np.array(
    [  # AIAG, Measurement Systems Analysis, 4th ed., figure III-B 15: 3 appraisers, 3 trials, 10 parts
        [[0.29, -0.56, 1.34, 0.47, -0.80, 0.02, 0.59, -0.31, 2.26, -1.36],
         [0.41, -0.68, 1.17, 0.50, -0.92, -0.11, 0.75, -0.20, 1.99, -1.25],
         [0.64, -0.58, 1.27, 0.64, -0.84, -0.21, 0.66, -0.17, 2.01, -1.31]],
        [[0.08, -0.47, 1.19, 0.01, -0.56, -0.20, 0.47, -0.63, 1.80, -1.68],
         [0.25, -1.22, 0.94, 1.03, -1.20, 0.22, 0.55, 0.08, 2.12, -1.62],
         [0.07, -0.68, 1.34, 0.20, -1.28, 0.06, 0.83, -0.34, 2.19, -1.50]],
        [[0.04, -1.38, 0.88, 0.14, -1.46, -0.29, 0.02, -0.46, 1.77, -1.49],
         [-0.11, -1.13, 1.09, 0.20, -1.07, -0.67, 0.01, -0.56, 1.45, -1.77],
         [-0.15, -0.96, 0.67, 0.11, -1.45, -0.49, 0.21, -0.49, 1.87, -2.16]],
    ]
).transpose(2, 0, 1)  # fmt: skip


def test_the_book_of_the_trade():
    """Oracle: the book's table III-B 8: standard deviations 0.199933, 0.226838, 0, 0.302373, 1.042327, total 1.085."""
    found = study(AIAG)
    assert found.repeatability**0.5 == pytest.approx(0.199933, abs=2e-6)
    assert found.operators**0.5 == pytest.approx(0.226838, abs=2e-6)
    assert found.interaction == 0
    assert found.gauge**0.5 == pytest.approx(0.302373, abs=2e-6)
    assert found.cameras**0.5 == pytest.approx(1.042327, abs=2e-6)
    assert found.total**0.5 == pytest.approx(1.0853, abs=1e-4)
    assert found.interaction_p_value == pytest.approx(0.9741, abs=1e-4)


def test_two_cameras_two_operators_by_hand():
    """Oracle: by hand. Cell means 1, 3 / 5, 11, each +-1: MS cameras 72, operators 32, interaction 8, rest 2."""
    means = np.array([[1.0, 3.0], [5.0, 11.0]])
    found = study(means[:, :, None] + np.array([-1.0, 1.0]))
    assert found.interaction_p_value == pytest.approx(0.116, abs=1e-3)
    assert (found.repeatability, found.interaction) == (pytest.approx(2), pytest.approx(3))
    assert (found.operators, found.cameras) == (pytest.approx(6), pytest.approx(16))


def test_one_operator_is_the_one_way_analysis():
    """Oracle: by hand: camera means 1 and 5, each +-1: rest 2, cameras (16 - 2) / 2."""
    found = study(np.array([[[0.0, 2.0]], [[4.0, 6.0]]]))
    assert (found.repeatability, found.cameras, found.reproducibility) == (2.0, 7.0, 0.0)
    assert found.interaction_p_value is None


@pytest.mark.parametrize("interaction", [0.0, 2.0])
def test_another_program_says_the_same(interaction):
    """Oracle: mean squares of statsmodels' analysis of variance, put into the expectations of the mean squares."""
    rng = np.random.default_rng(11)
    values = (
        rng.normal(0, 3, (6, 1, 1)) + rng.normal(0, 1, (1, 3, 1)) + rng.normal(0, interaction, (6, 3, 1))
        + rng.normal(0, 0.5, (6, 3, 4))
    )  # fmt: skip
    camera, operator, _ = np.indices(values.shape)
    frame = pandas.DataFrame({"y": values.ravel(), "c": camera.ravel(), "o": operator.ravel()})
    table = anova_lm(ols("y ~ C(c) * C(o)", frame).fit())
    found = study(values)
    ms = table["mean_sq"]
    assert found.interaction_p_value == pytest.approx(table["PR(>F)"]["C(c):C(o)"], rel=1e-9)
    rest, crossed = ms["Residual"], ms["C(c):C(o)"]
    if found.interaction_p_value > 0.25:
        plain = anova_lm(ols("y ~ C(c) + C(o)", frame).fit())
        rest = crossed = plain["mean_sq"]["Residual"]
    assert found.repeatability == pytest.approx(rest)
    assert found.interaction == pytest.approx(max(0, crossed - rest) / 4)
    assert found.operators == pytest.approx(max(0, (ms["C(o)"] - crossed) / 24))
    assert found.cameras == pytest.approx((ms["C(c)"] - crossed) / 12)


def _result(serial_number, run, value, *, manufacturer="m", readout_mode="snapshot"):
    camera = CameraKey(
        manufacturer=manufacturer,
        model="k",
        serial_number=serial_number,
        camera_type="photon",
        readout_mode=readout_mode,
    )
    delay = PointParameter(
        value=value, standard_uncertainty=5.0, unit="s", expanded_uncertainty=10.0, common={"gate": 3.0, "wheel": 2.0}
    )
    point = SettingPoint(label=serial_number + run, camera=camera, settings={}, parameters={"trigger_delay": delay})
    return CampaignPoint(point=point, operator="a", run=run)


def test_repeatability_stands_beside_what_is_each_result_s_own():
    """Oracle: by hand; of 5^2, 3^2 + 2^2 is of the rig: 12 is left; a third run of one camera is not taken."""
    (found,), words = studies([_result("1", "a", 0.0), _result("1", "b", 2.0), _result("2", "a", 4.0),
                               _result("2", "b", 6.0), _result("2", "c", 99.0)])  # fmt: skip
    assert found.rms_u_own == pytest.approx(12**0.5)
    assert (found.parameter, found.repeatability, found.cameras) == ("trigger_delay", 2.0, 7.0)
    assert words.startswith("1 of 5 results")


@pytest.mark.parametrize("other", [{"readout_mode": "rolling"}, {"manufacturer": "n"}])
def test_cameras_that_share_a_serial_number_alone_are_not_mixed(other):
    """Oracle: by hand; of one number there is one result of each of two cameras: only camera 2 was measured twice."""
    mixed = [_result("1", "a", 0.0), _result("1", "b", 500.0, **other), _result("2", "a", 4.0), _result("2", "b", 6.0)]
    found, words = studies(mixed)
    assert found == ()
    assert "at least two cameras" in words
