"""The table of results at several settings: which recordings make one."""

from irtiming.records.setting_point import CameraKey, PointParameter, SettingPoint
from irtiming.records.setting_series import CameraSeries
from irtiming.report.sections import over_settings

CAMERA = CameraKey(
    manufacturer="Maker", model="M1", serial_number="7", camera_type="photon", readout_mode="snapshot", event="trigger"
)


def _series(*labels):
    delay = PointParameter(
        value=4e-4, standard_uncertainty=1e-6, unit="s", degrees_of_freedom=100.0, expanded_uncertainty=2e-6, event="start",
        common={},
    )  # fmt: skip
    points = tuple(
        SettingPoint(label=label, camera=CAMERA, settings={"rows": 96.0}, parameters={"trigger_delay": delay})
        for label in labels
    )
    return CameraSeries(camera=CAMERA, points=points, over=())


def test_recordings_that_make_one_result_are_named():
    """Oracle: by hand; the first of three with how many more in its line, all of them in the note."""
    table = over_settings.points(_series("a/run-3Hz.nxs", "a/run-5Hz.nxs, b/run-8Hz.nxs, b/run-9Hz.nxs"))
    assert [row[0] for row in table.rows] == ["run-3Hz.nxs", "run-5Hz.nxs and 2 more"]
    assert table.note.endswith("Together: run-5Hz.nxs + run-8Hz.nxs + run-9Hz.nxs.")


def test_recordings_that_make_a_result_each_need_no_words():
    """Oracle: by hand."""
    assert over_settings.points(_series("a/run-3Hz.nxs", "result.json")).note == ""
