"""Each parameter of a camera over each setting in which its results differ: level, line, and a step where there is one.

Inputs that results have in common stand in their covariance (`inference.common_inputs`), so a slope is known better than the
value at any setting. Only results that agree in all other settings are compared; the FPA temperature, which sways, is no such
other setting.
"""

from collections.abc import Sequence

import numpy as np

from irtiming.errors import EstimationError
from irtiming.inference import common_inputs, weighted_line
from irtiming.records.setting_point import SETTINGS, CameraKey, SettingName, SettingPoint, groups, is_same_setting
from irtiming.records.setting_series import CameraSeries, OverSetting

_CLEAR_STEP = 0.01


def by_camera(points: Sequence[SettingPoint]) -> tuple[CameraSeries, ...]:
    """Each camera by itself, in order of serial number.

    Parameters
    ----------
    points
        Of any cameras.

    Raises
    ------
    EstimationError
        If there is none, or one names no serial number while there are several cameras.
    """
    if not points:
        raise EstimationError("no result is given; name at least two of one camera at different settings")
    cameras = sorted({one.camera for one in points}, key=lambda key: (key.serial_number, str(key)))
    if len(cameras) > 1:
        nameless = next((one for one in points if not one.camera.serial_number), None)
        if nameless is not None:
            raise EstimationError(
                f"names no serial number, and there are {len(cameras)} cameras: which one made it is unknown, and two cameras "
                "are never taken together; leave it out, or record it with its serial_number",
                where=nameless.label,
            )
    return tuple(_series(key, [one for one in points if one.camera == key]) for key in cameras)


def _series(camera: CameraKey, points: list[SettingPoint]) -> CameraSeries:
    found = [
        one for setting in SETTINGS for group in _alike_besides(points, setting)
        for name in group[0].parameters for one in _over(group, setting, name=name)
    ]  # fmt: skip
    return CameraSeries(camera=camera, points=tuple(points), over=tuple(found))


def _alike_besides(points: list[SettingPoint], setting: SettingName) -> list[list[SettingPoint]]:
    """Groups of points that differ in one setting alone; a setting that is a word has no axis."""
    numbers = [one for one in points if isinstance(one.settings.get(setting), float | int)]
    varying = [sorted(group, key=lambda one: _x(one, setting)) for group in groups(numbers, besides=setting)]
    return [group for group in varying if not is_same_setting(_x(group[0], setting), _x(group[-1], setting))]


def _x(one: SettingPoint, setting: SettingName) -> float:
    return float(one.settings[setting])


def _over(group: list[SettingPoint], setting: SettingName, *, name: str) -> list[OverSetting]:
    """One parameter, where at least two different settings have it."""
    points = [one for one in group if name in one.parameters]
    if len(points) < 2 or is_same_setting(_x(points[0], setting), _x(points[-1], setting)):
        return []
    given = [one.parameters[name] for one in points]
    x, y = np.array([_x(one, setting) for one in points]), np.array([one.value for one in given])
    u = np.array([one.standard_uncertainty for one in given])
    covariance = common_inputs.covariance(u, [one.common for one in given])
    step = weighted_line.step(x, y, covariance=covariance)
    return [
        OverSetting(
            parameter=name, unit=given[0].unit, event=given[0].event, setting=setting, points=tuple(points), x=x, values=y,
            covariance=covariance, level=weighted_line.level(y, covariance=covariance),
            line=weighted_line.line(x, y, covariance=covariance),
            step=step if step is not None and step.p_value < _CLEAR_STEP else None,
        )
    ]  # fmt: skip
