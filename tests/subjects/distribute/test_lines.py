"""Lines of a campaign: several results as one value, held against limits."""

import math

import pytest

from irtiming.archive.limits_file import LimitsFile
from irtiming.distribute import lines
from irtiming.records.campaign import CampaignPoint
from irtiming.records.setting_point import CameraKey, PointParameter, SettingPoint

_CAMERA = CameraKey(manufacturer="m", model="k", serial_number="1", camera_type="photon", readout_mode="snapshot")
_LIMITS = LimitsFile.model_validate({"limit": [{"parameter": "trigger_delay", "lower": "395 us", "upper": "405 us"}]})


def _point(delay_us, *, u_us=1.0, freedom=math.inf, start=""):
    delay = PointParameter(value=delay_us * 1e-6, standard_uncertainty=u_us * 1e-6, unit="s",
                           expanded_uncertainty=2e-6 * u_us, degrees_of_freedom=freedom)  # fmt: skip
    point = SettingPoint(
        label=f"{delay_us}", camera=_CAMERA, settings={}, parameters={"trigger_delay": delay}, start_time=start
    )
    return CampaignPoint(point=point)


def test_the_probability_of_conformity_is_by_the_degrees_of_freedom_of_u():
    """Oracle: Student's t in closed form: 1/2 + atan(t) / pi for one degree of freedom, and that for three.

    Two results 4 us apart have u = 2 us of one degree of freedom about 402 us; a single one has the three that it states.
    """
    (line,) = lines.of([_point(400.0), _point(404.0)], _LIMITS)
    inside = (math.atan(3 / 2) + math.atan(7 / 2)) / math.pi
    assert line.values["trigger_delay"].probability == pytest.approx(inside, rel=1e-6)

    def below(t):
        x = t / 3**0.5
        return 0.5 + (x / (1 + x**2) + math.atan(x)) / math.pi

    (line,) = lines.of([_point(401.0, u_us=2.0, freedom=3.0)], _LIMITS)
    assert line.values["trigger_delay"].probability == pytest.approx(below(2.0) - below(-3.0), rel=1e-6)


def test_the_first_measured_is_the_first_whatever_zone_its_time_is_told_in():
    """Oracle: by hand; 23:00 at five hours behind UTC is 04:00 of the next day, after 01:00 UTC."""
    early, late = "2026-01-02T01:00:00+00:00", "2026-01-01T23:00:00-05:00"
    (line,) = lines.of([_point(400.0, start=late), _point(401.0, start=early)], LimitsFile())
    assert line.first_measured == early
