"""Cameras of every kind before the paper's experiment: what their pixels do with light, and how their rows are read."""

from dataclasses import replace

from irtiming.records.recording import CameraType, ReadoutMode
from irtiming.twin.scene import CameraTiming, Scene, microbolometer_scene, paper_scene

_PHOTON_ROW_DELAY_S = 20e-6
_ROLLING_SUBSTEPS = 64


def camera_scene(
    camera_type: CameraType, readout_mode: ReadoutMode | None = None, *, rows: int | None = None, columns: int = 640
) -> Scene:
    """Experiment of the paper with a camera of this kind; a rolling photon camera is not cold, so nothing mirrors it.

    Parameters
    ----------
    camera_type
        What its pixels do.
    readout_mode
        How it reads them: as the paper's camera of that type, if not given.
    rows, columns
        Size of the image; rows of the paper's camera, if not given.

    Raises
    ------
    GeometryError
        If the image is smaller than 16 rows or columns.
    """
    scene = paper_scene(rows or 512, columns) if camera_type == "photon" else microbolometer_scene(rows or 480, columns)
    timing = scene.timing
    if readout_mode == "snapshot":
        return replace(scene, timing=replace(timing, row_delay_s=None))
    if readout_mode == "rolling" and isinstance(timing, CameraTiming):
        rolling = replace(timing, row_delay_s=_PHOTON_ROW_DELAY_S, substeps=_ROLLING_SUBSTEPS)
        return replace(scene, timing=rolling, radiance=replace(scene.radiance, narcissus_dn=0.0))
    return scene
