"""What went into a result, as plain data: which camera it is of, its recordings, and what rig.toml says."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from irtiming.records.camera_frame import CameraIdentity
from irtiming.records.camera_settings import CameraSettings
from irtiming.records.frame_events import FrameEvents
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Measured, Rig

_UNITS = ("m", "rad", "s", "px")
JITTER_QUANTILES = (0.05, 0.5, 0.95, 0.99)
_BINS = 40


def item(camera: CameraIdentity) -> dict[str, str | None]:
    """The camera; None for each word that its recordings lack."""
    return {
        "manufacturer": camera.vendor or None,
        "model": camera.model or None,
        "serial_number": camera.serial_number or None,
        "firmware": camera.firmware or None,
    }


def of_recording(recording: ReducedRecording) -> dict[str, Any]:
    """One recording, the camera that it names, and what its reduction took."""
    opening, view = recording.opening, recording.axle
    return {
        "file": recording.file,
        "sha256": recording.sha256,
        "frames": recording.n_frames,
        "frames_used": int(recording.frame_index.size),
        "trigger_delay_time_set": recording.trigger_delay_time_set_s,
        "integration_time": recording.integration_time_s,
        "rotation_speed": recording.rotation_speed_hz,
        "blackbody_temperature": recording.blackbody_temperature_k,
        "roi": list(opening.roi),
        "threshold": None if opening.histogram is None else float(opening.histogram.threshold_dn),
        "border_px": opening.border_px,
        "bad_pixels": opening.n_bad_pixels,
        "blackbody_is_colder": bool(opening.blackbody_is_colder),
        "shutter_events": [
            {"first_frame": int(event.first_frame), "end_frame": int(event.end_frame), "kind": event.kind}
            for event in recording.shutter_events
        ],
        "axle_row_column_px": None if view is None else [view.row_px, view.column_px],
        "image": {"rows": opening.mask.shape[0], "columns": opening.mask.shape[1]},
        "frame_period": recording.frame_period_s,
        "bit_depth": recording.bit_depth,
        "start_time": recording.start_time or None,
        "item": None if recording.camera is None else item(recording.camera),
        "simulated": recording.is_simulated,
        "settings": settings(recording.settings),
        "event": None if recording.events is None else event(recording.events),
    }


def settings(given: CameraSettings) -> dict[str, Any]:
    """What the camera was set to; None where its recording does not say."""
    return {
        "gain_setting": given.gain_setting or None,
        "internal_delay_set": given.internal_delay_set_s,
        "sensor_temperature": given.sensor_temperature_k,
        "region_first_row": given.region_first_row,
        "region_first_column": given.region_first_column,
    }


def event(found: FrameEvents) -> dict[str, Any]:
    """Events of a recording whose camera runs free: period, clock, and how they scatter about their grid."""
    counts, edges_s = np.histogram(found.deviation_s, bins=_BINS)
    return {
        "kind": found.kind,
        "period": found.period_s,
        "clock_rate": found.relative_rate,
        "clock_rate_standard_uncertainty": found.u_relative_rate,
        "clock_offset": found.offset_s,
        "clock_standard_uncertainty": found.u_clock_s,
        "grid_standard_uncertainty": found.u_grid_s,
        "jitter": {
            "standard_deviation": float(found.deviation_s.std(ddof=1)),
            "quantiles": {f"{share:g}": float(np.quantile(found.deviation_s, share)) for share in JITTER_QUANTILES},
            "histogram": {"edges": [float(one) for one in edges_s], "counts": [int(one) for one in counts]},
        },
        "unit": "s",
    }


def rig(measured: Rig) -> dict[str, Any]:
    """The file, and each number or word in it by section and key of rig.toml, in SI units."""
    sections = {
        "wheel": measured.wheel,
        "beams": measured.light_gates,
        "mask": measured.mask_opening,
        "latency": measured.latency,
        "clock": measured.clock,
        "camera": measured.camera,
    }
    values = [entry for name, section in sections.items() for entry in _values(section, name)]
    return {"file": measured.source, "sha256": measured.sha256, "values": values}


def _values(said: Any, name: str) -> Iterator[dict[str, Any]]:
    """Entries of a section, a number or a list of numbers; none of what is not stated."""
    if isinstance(said, Measured):
        yield _entry(name, said.value, u=said.standard_uncertainty or None)
    elif isinstance(said, tuple):
        for place, one in enumerate(said):
            yield from _values(one, f"{name}[{place}]")
    elif is_dataclass(said):
        for field in fields(said):
            yield from _values(getattr(said, field.name), f"{name}.{field.name}")
    elif said is not None:
        yield _entry(name, said if isinstance(said, str) else float(said), u=None)


def _entry(name: str, value: float | str, *, u: float | None) -> dict[str, Any]:
    """The unit that the name ends in, before an index, stands beside it."""
    stem, _, index = name.partition("[")
    words, _, last = stem.rpartition("_")
    unit = last if last in _UNITS else ""
    short = f"{words if unit else stem}{'[' if index else ''}{index}"
    return {"name": short, "value": value, "standard_uncertainty": u, "unit": unit}
