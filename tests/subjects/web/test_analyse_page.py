"""Which recordings the page Analyse has chosen before a person does."""

from pathlib import Path

from irtiming.web.pages.analyse_page import of_one_series


def test_recordings_of_one_series_are_chosen_and_not_those_of_another_camera_beside_them():
    """Oracle: by hand, names as `irtiming simulate` and `irtiming record` give them; two cameras in a folder, and another one."""
    cooled = [Path("lab/cooled-3.00002Hz-0ms.nxs"), Path("lab/cooled-9.001Hz-25ms.nxs")]
    other = [Path("lab/bolo-3.00002Hz-0ms.nxs"), Path("old/cooled-3.00002Hz-0ms.nxs")]
    assert of_one_series([cooled[0], other[0], cooled[1], other[1]]) == cooled
    assert of_one_series([other[0], *cooled]) == other[:1]
    runs = [
        Path("photon/20261124T111702Z_Twin-photon-camera_3Hz_0ms_r01.nxs"),
        Path("photon/20261124T111715Z_Twin-photon-camera_9.001Hz_0ms_r02.nxs"),
    ]
    assert of_one_series([*runs, Path("photon/20261124T111702Z_Twin-microbolometer_3Hz_0ms_r01.nxs")]) == runs
    assert of_one_series([]) == []
