"""Settings of a triggered camera, set and read back; the same for every GenICam camera, whatever the driver."""

from dataclasses import dataclass
from typing import Protocol, final

from irtiming.errors import InstrumentRefused
from irtiming.records.camera_frame import CameraSetup
from irtiming.records.camera_settings import EXPOSURES, CameraSettings

_FORMATS = ("Mono16", "Mono14", "Mono12", "Mono10")  # one pixel in 16 bits; the first is taken if none of them is set
_FRAME_START = "FrameStart"
_LINES = ("Line1", "Line0")
_GAINS = ("SensorGainMode", "GainMode", "Gain")
_ZERO_CELSIUS_K = 273.15
_EDGES = ("RisingEdge", "FallingEdge")


class FeatureAccess(Protocol):
    """Features by their names of GenICam SFNC; all errors are `InstrumentError`."""

    def has(self, name: str) -> bool:
        """Whether it is there and can be used now."""
        ...

    def choices(self, name: str) -> list[str]:
        """Values that a choice may take; empty for what is no choice."""
        ...

    def read(self, name: str) -> str:
        """Its value."""
        ...

    def number(self, name: str) -> float:
        """Its value as a number."""
        ...

    def write(self, name: str, *, value: str) -> str:
        """Set it and read it back."""
        ...


@final
@dataclass(frozen=True, kw_only=True)
class FoundTriggers:
    """Modes of a camera's triggers before it was armed, by selector; a camera with a single trigger has selector ``""``."""

    selected: str
    modes: dict[str, str]


def found_triggers(features: FeatureAccess) -> FoundTriggers:
    """Which triggers of a camera are on; the selector goes back to where it was.

    Parameters
    ----------
    features
        Of the camera.
    """
    if not features.has("TriggerSelector"):
        return FoundTriggers(
            selected="", modes={"": features.read("TriggerMode")} if features.has("TriggerMode") else {}
        )
    selected = features.read("TriggerSelector")
    modes = {}
    for selector in features.choices("TriggerSelector"):
        features.write("TriggerSelector", value=selector)
        if features.has("TriggerMode"):
            modes[selector] = features.read("TriggerMode")
    features.write("TriggerSelector", value=selected)
    return FoundTriggers(selected=selected, modes=modes)


def restore_triggers(features: FeatureAccess, *, found: FoundTriggers) -> None:
    """Set the modes of all triggers as they were.

    Parameters
    ----------
    features
        Of the camera.
    found
        By `found_triggers`.
    """
    for selector, mode in found.modes.items():
        if selector:
            features.write("TriggerSelector", value=selector)
        if features.read("TriggerMode") != mode:
            features.write("TriggerMode", value=mode)
    if found.selected:
        features.write("TriggerSelector", value=found.selected)


def prepare_trigger(features: FeatureAccess, *, name: str, timestamp_frequency_hz: float) -> CameraSetup:
    """One frame per edge at a hardware input, 16 bits per pixel; everything read back.

    A line and an edge that are set already are kept. Of what a camera lacks, only what it has no choice about is done without.

    Parameters
    ----------
    features
        Of the camera.
    name
        Of the camera, for messages.
    timestamp_frequency_hz
        Of the camera's clock; 0 where it has none.

    Raises
    ------
    InstrumentError
        If the camera has no hardware trigger or no such pixels, or does not hold what it was set to.
    """
    if not features.has("TriggerMode"):
        raise InstrumentRefused(
            f"{name} has no feature TriggerMode: it cannot be triggered; use another camera or driver"
        )
    pixel_format = _set_format(features, name)
    _only_frame_start(features, name)
    source, activation = _set_source(features, name), _set_activation(features)
    features.write("TriggerMode", value="On")
    return _setup(
        features, pixel_format, source=source, activation=activation, timestamp_frequency_hz=timestamp_frequency_hz
    )


def prepare_free(
    features: FeatureAccess, *, name: str, timestamp_frequency_hz: float, frame_rate_hz: float
) -> CameraSetup:
    """Frames by the camera's own clock, 16 bits per pixel; everything read back.

    Parameters
    ----------
    features, name, timestamp_frequency_hz
        As for `prepare_trigger`.
    frame_rate_hz
        Set where the camera has the feature AcquisitionFrameRate; else it keeps its own.

    Raises
    ------
    InstrumentError
        If the camera has no such pixels, or does not hold what it was set to.
    """
    pixel_format = _set_format(features, name)
    if features.has("TriggerMode"):
        _all_off(features)
    if features.has("AcquisitionFrameRateEnable"):
        features.write("AcquisitionFrameRateEnable", value="true")
    if features.has("AcquisitionFrameRate"):
        features.write("AcquisitionFrameRate", value=f"{frame_rate_hz:.10g}")
    return _setup(features, pixel_format, source="", activation="", timestamp_frequency_hz=timestamp_frequency_hz)


def _all_off(features: FeatureAccess) -> None:
    selectors = features.choices("TriggerSelector") if features.has("TriggerSelector") else [""]
    for selector in selectors:
        if selector:
            features.write("TriggerSelector", value=selector)
        if features.has("TriggerMode") and features.read("TriggerMode") == "On":
            features.write("TriggerMode", value="Off")


def _setup(
    features: FeatureAccess, pixel_format: str, *, source: str, activation: str, timestamp_frequency_hz: float
) -> CameraSetup:
    """What the camera says of its settings, in continuous acquisition."""
    if features.has("AcquisitionMode"):
        features.write("AcquisitionMode", value="Continuous")
    exposures = [exposure for exposure in EXPOSURES if features.has(exposure)]
    return CameraSetup(
        rows=int(features.number("Height")),
        columns=int(features.number("Width")),
        pixel_format=pixel_format,
        bit_depth=int(pixel_format.removeprefix("Mono")),
        trigger_source=source,
        trigger_activation=activation,
        timestamp_frequency_hz=timestamp_frequency_hz,
        integration_time_s=features.number(exposures[0]) * 1e-6 if exposures else None,
        settings=_settings(features),
    )


def _settings(features: FeatureAccess) -> CameraSettings:
    """What the camera's timing may depend on besides, as far as it has features for it (SFNC 2.7)."""
    gains = [features.read(name) for name in _GAINS if features.has(name)]
    values = {name: features.number(name) for name in ("TriggerDelay", "DeviceTemperature", "OffsetY", "OffsetX")
            if features.has(name)}  # fmt: skip
    delay_us, celsius = values.get("TriggerDelay"), values.get("DeviceTemperature")
    return CameraSettings(
        gain_setting=gains[0] if gains else "",
        internal_delay_set_s=None if delay_us is None else delay_us * 1e-6,
        sensor_temperature_k=None if celsius is None else celsius + _ZERO_CELSIUS_K,
        region_first_row=int(values["OffsetY"]) if "OffsetY" in values else None,
        region_first_column=int(values["OffsetX"]) if "OffsetX" in values else None,
    )


def _set_format(features: FeatureAccess, name: str) -> str:
    held, offered = features.read("PixelFormat"), features.choices("PixelFormat")
    if held in _FORMATS:
        return held
    usable = [pixel_format for pixel_format in _FORMATS if pixel_format in offered]
    if not usable:
        raise InstrumentRefused(
            f"{name} has no PixelFormat of 16 bits ({', '.join(_FORMATS)}), only {', '.join(offered)}"
        )
    return features.write("PixelFormat", value=usable[0])


def _only_frame_start(features: FeatureAccess, name: str) -> None:
    """A second trigger, such as of the start of the acquisition, would hold back the frames."""
    if not features.has("TriggerSelector"):
        return
    selectors = features.choices("TriggerSelector")
    if _FRAME_START not in selectors:
        raise InstrumentRefused(f"{name} has no trigger for the start of a frame, only for {', '.join(selectors)}")
    for selector in selectors:
        if selector != _FRAME_START and selector.endswith("Start"):
            features.write("TriggerSelector", value=selector)
            if features.has("TriggerMode") and features.read("TriggerMode") == "On":
                features.write("TriggerMode", value="Off")
    features.write("TriggerSelector", value=_FRAME_START)


def _set_source(features: FeatureAccess, name: str) -> str:
    """Empty for a camera with a single input."""
    if not features.has("TriggerSource"):
        return ""
    held, offered = features.read("TriggerSource"), features.choices("TriggerSource")
    if held.startswith("Line"):
        return held
    lines = [line for line in (*_LINES, *offered) if line in offered and line.startswith("Line")]
    if not lines:
        raise InstrumentRefused(f"{name} has no hardware input for its trigger, only {', '.join(offered)}")
    return features.write("TriggerSource", value=lines[0])


def _set_activation(features: FeatureAccess) -> str:
    """Empty for a camera that does not say."""
    if not features.has("TriggerActivation"):
        return ""
    held = features.read("TriggerActivation")
    return held if held in _EDGES else features.write("TriggerActivation", value=_EDGES[0])
