"""Control charts: which results are charted, and in which order."""

from irtiming.records.setting_point import CameraKey, PointParameter, SettingPoint
from irtiming.report.sections.control_chart import charts

_CAMERA = CameraKey(manufacturer="m", model="k", serial_number="1", camera_type="photon", readout_mode="snapshot")


def _point(value_s, *, window_us=250.0, start=""):
    delay = PointParameter(value=value_s, standard_uncertainty=1e-6, unit="s", expanded_uncertainty=2e-6)
    return SettingPoint(
        label="a", camera=_CAMERA, settings={"integration_time": window_us * 1e-6}, start_time=start,
        parameters={"trigger_delay": delay},
    )  # fmt: skip


def test_settings_that_agree_are_on_one_chart():
    """Oracle: by hand; 250.49 and 250.51 us are one setting to 1e-3, though they round to 250 and 251."""
    (chart,) = charts([_point(4e-4, window_us=us) for us in (250.49, 250.51, 250.49, 250.51)])
    assert chart.values.shape == (4,)


def test_results_stand_in_order_of_time_whatever_zone_their_times_are_told_in():
    """Oracle: by hand; 01:00, 23:00 the day before at -05:00 (04:00 UTC), 07:00 at +02:00 (05:00 UTC), 06:00 without a zone."""
    starts = ["2026-01-02T06:00:00", "2026-01-01T23:00:00-05:00", "2026-01-02T07:00:00+02:00", "2026-01-02T01:00:00Z"]
    (chart,) = charts([_point(hour * 1e-6, start=start) for hour, start in zip((6, 4, 5, 1), starts, strict=True)])
    assert (chart.values / 1e-6).round().tolist() == [1, 4, 5, 6]
