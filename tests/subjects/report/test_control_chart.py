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
