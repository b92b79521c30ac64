"""A short run by hand: its head, frames and timestamps."""

import numpy as np

from irtiming.archive.live.head import RecordingHead
from irtiming.archive.live.recording import LiveRecording
from irtiming.records.camera_frame import CameraFrame, CameraIdentity, CameraSetup
from irtiming.records.instrument_state import BlackbodyState, ChopperState
from irtiming.records.trigger_plan import PlannedRun, TriggerScheme

CLOCK_HZ, TURN, PERIOD, START = 49_152_000, 16_384_000, 1_622_016, 7_000_000
ROWS, COLUMNS = 12, 16


def head(**fields) -> RecordingHead:
    values = {
        "name": "by hand",
        "camera_type": "photon",
        "readout_mode": "snapshot",
        "clock_frequency_hz": CLOCK_HZ,
        "run": PlannedRun(
            scheme=TriggerScheme(turn_period_ticks=TURN, camera_period_ticks=PERIOD),
            trigger_delay_ticks=1_228_800,
            repeats=2,
            is_after_correction=True,
        ),
        "camera": CameraIdentity(
            vendor="Acme", model="IR-1", serial_number="0815", firmware="1.2", address="gige:192.168.0.7"
        ),
        "setup": CameraSetup(
            rows=ROWS,
            columns=COLUMNS,
            pixel_format="Mono14",
            bit_depth=14,
            trigger_source="Line1",
            trigger_activation="RisingEdge",
            timestamp_frequency_hz=1e9,
            integration_time_s=250e-6,
        ),
        "chopper": ChopperState(
            model="MC2000B-EC",
            blade="MC1F2",
            reference="external-inner",
            output="inner",
            harmonic_multiplier=1,
            harmonic_divider=1,
            is_enabled=True,
            input_hz=300.0,
        ),
        "blackbody": BlackbodyState(model="SR-800R", temperature_k=303.15, target_k=303.0, is_stable=True),
        "start_time": "2026-11-22T00:00:00+00:00",
    }
    return RecordingHead(**(values | fields))


def pixels(index: int) -> np.ndarray:
    return np.random.default_rng(index).integers(1000, 9000, (ROWS, COLUMNS), dtype=np.uint16)


def frame(index: int, *, missing: int = 0) -> CameraFrame:
    return CameraFrame(
        pixels=pixels(index),
        frame_id=index,
        device_timestamp_ticks=33_000_000 * index + 5,
        host_time_s=100.0 + 0.033 * index,
        packets_missing=missing,
    )


def append_edges(live: LiveRecording, n_turns: int = 3) -> None:
    """The wheel's edges, from half a turn before the first trigger."""
    slots = START - TURN // 2 + TURN // 100 * np.arange(100 * n_turns + 1)
    live.append_ticks("control_slot", slots)
    live.append_ticks("application_slot", slots[::50] + 5)


def append_frames(live: LiveRecording, indices) -> None:
    """Whole frames, each after its trigger."""
    for index in indices:
        live.append_ticks("camera_trigger", np.array([START + PERIOD * index]))
        live.append_frame(frame(index), frame_number=index)
