"""Settings of a camera on which its timing may depend, as it was recorded."""

from dataclasses import dataclass
from typing import final

EXPOSURES = ("ExposureTime", "ExposureTimeAbs", "IntegrationTime")
"""GenICam features that set the integration time, all in us."""


@final
@dataclass(frozen=True, kw_only=True)
class CameraSettings:
    """What a camera was set to beside its integration time and frame rate; None or empty where not stated.

    ``gain_setting`` is in the camera's own words. ``internal_delay_set_s`` is the delay set in the camera itself between the edge
    that it accepts and its start (GenICam SFNC ``TriggerDelay``); it is part of the trigger delay that is measured.
    ``sensor_temperature_k`` is that of the focal plane array (FPA). ``region_first_row`` and ``region_first_column`` are the
    sensor's row and column that are row and column 0 of the image, px.
    """

    gain_setting: str = ""
    internal_delay_set_s: float | None = None
    sensor_temperature_k: float | None = None
    region_first_row: int | None = None
    region_first_column: int | None = None
