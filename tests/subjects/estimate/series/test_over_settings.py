"""Parameters over settings: which results go together, and what their lines tell."""

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate.series.over_settings import by_camera
from irtiming.estimate.series.points import point
from results_by_hand import result_by_hand

WINDOWS_S = (100e-6, 200e-6, 400e-6, 800e-6)


def _points(serial="A", **settings):
    """A camera whose start of integration stays, so that its middle moves by half of the integration time."""
    return [
        point(result_by_hand(400e-6, serial=serial, window_s=window_s, settings=settings), label=f"{serial}-{window_s}")
        for window_s in WINDOWS_S
    ]


def test_the_middle_of_integration_has_slope_one_half():
    """Oracle: by hand: the start stays, so slopes are 0 and 1/2; u of a slope holds own errors alone, sqrt(18) less."""
    (series,) = by_camera(_points())
    found = {one.parameter: one for one in series.over}
    assert found["trigger_delay"].simple_slopes == (0.0,)
    assert found["exposure_midpoint_delay"].simple_slopes == (0.5,)
    slope, u = found["trigger_delay"].slope
    x = np.array(WINDOWS_S)
    assert slope == pytest.approx(0, abs=1e-9)
    assert u == pytest.approx(0.3e-6 / np.sqrt(np.sum((x - x.mean()) ** 2)), rel=1e-6)
    beyond, u_beyond = found["exposure_midpoint_delay"].differences
    np.testing.assert_allclose(beyond, (x - x[0]) / 2, atol=1e-12)
    np.testing.assert_allclose(u_beyond[1:], np.sqrt(2) * 0.3e-6, rtol=1e-6)


def test_two_cameras_are_never_taken_together():
    """Oracle: by hand: two series of four results; a result without serial number beside two cameras is refused."""
    found = by_camera([*_points("B"), *_points("A")])
    assert [(one.camera.serial_number, len(one.points)) for one in found] == [("A", 4), ("B", 4)]
    assert all({p.camera for p in each.points} == {one.camera} for one in found for each in one.over)
    with pytest.raises(EstimationError, match="names no serial number"):
        by_camera([*_points("A"), *_points(None)])


def test_results_that_differ_in_two_settings_are_not_compared():
    """Oracle: by hand: integration times at gain low and at gain high are two series of the same camera."""
    (series,) = by_camera([*_points(gain_setting="low"), *_points(gain_setting="high")])
    assert [one.x.size for one in series.over if one.parameter == "trigger_delay"] == [4, 4]


def test_rigs_that_state_other_numbers_have_nothing_in_common():
    """Oracle: by hand: with another mask angle in rig.toml the covariance of two results is none."""
    one, other = (
        point(result_by_hand(400e-6, window_s=window_s, rig=rig), label=rig)
        for window_s, rig in ((100e-6, "first"), (200e-6, "second"))
    )
    (series,) = by_camera([one, other])
    assert series.over[0].covariance[0, 1] == 0
    assert series.over[0].covariance[0, 0] == pytest.approx((0.3e-6) ** 2 + (0.4e-6) ** 2)
