"""Which results are of one camera at one setting: by hand."""

from irtiming.records.setting_point import CameraKey, SettingPoint, groups


def _point(label, *, serial="1", readout="snapshot", window_us=250.0, period_ms=10.0):
    camera = CameraKey(manufacturer="m", model="k", serial_number=serial, camera_type="photon", readout_mode=readout)
    settings = {"integration_time": window_us * 1e-6, "frame_period": period_ms * 1e-3, "sensor_temperature": 80.0}
    return SettingPoint(label=label, camera=camera, settings=settings, parameters={})


def test_results_of_one_camera_at_one_setting_are_one_group():
    """Oracle: by hand; 250.49 and 250.51 us are one setting, another serial number or readout is another camera."""
    points = [
        _point("a", window_us=250.49),
        _point("b", serial="2", window_us=250.5),
        _point("c", window_us=250.51),
        _point("d", readout="rolling"),
        _point("e", window_us=260.0),
        _point("f", window_us=260.0, period_ms=20.0),
    ]

    def labels(**more):
        return ["".join(one.label for one in group) for group in groups(points, **more)]

    assert labels() == ["ac", "e", "f", "b", "d"]
    assert labels(besides="integration_time") == ["ace", "f", "b", "d"]
    assert labels(of_kind=True) == ["abc", "e", "f", "d"]
