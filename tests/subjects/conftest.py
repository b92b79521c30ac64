"""Reduced recordings made up in memory: what the reduction hands to the estimation."""

from collections.abc import Callable

import numpy as np
import pytest

from irtiming.records.reduced import Opening, PixelSums, ReducedRecording
from irtiming.records.wheel_track import WheelTrack

TURN = 2 * np.pi
CLOCK_HZ = 49_152_000


@pytest.fixture(scope="session")
def track_of() -> Callable[..., WheelTrack]:
    """Track of a wheel with known theta(t): its angle every three hundredth of a second, as from a perfect slot ring."""

    def make(theta=None, *, rate_hz=3.0, start=7_000_000, duration_s=34.5, **fields):
        t = np.arange(0, duration_s, 1 / (100 * rate_hz))
        ticks = start + np.rint(t * CLOCK_HZ).astype(np.int64)
        t = (ticks - start) / CLOCK_HZ
        angle = (TURN * rate_hz * t + 0.4) if theta is None else theta(t)
        values = {
            "edge_ticks": ticks,
            "edge_angle_rad": angle,
            "clock_frequency_hz": float(CLOCK_HZ),
            "angular_frequency_rad_per_s": float((angle[-1] - angle[0]) / (t[-1] - t[0])),
            "gate_separation_rad": 0.5697,
            "u_gate_separation_rad": 1e-4,
            "slot_deviation_rad": np.zeros(100),
            "u_slot_deviation_rad": np.zeros(100),
        }
        return WheelTrack(**(values | fields))

    return make


@pytest.fixture(scope="session")
def reduced_recording() -> Callable[..., ReducedRecording]:
    """Reduced recording with the given triggers and values; ``is_colder`` is for a cold blackbody."""

    def make(track, triggers, value, *, is_colder=False, **fields):
        opening = Opening(
            roi=(0, 1, 0, 1),
            open_frame_dn=np.zeros((1, 1)),
            covered_frame_dn=np.zeros((1, 1)),
            mask=np.ones((1, 1), bool),
            summed=np.ones((1, 1), bool),
            weight=np.ones((1, 1)),
            border_px=1,
            bad=np.zeros((1, 1), bool),
            blackbody_is_colder=is_colder,
        )
        values = {
            "name": "made up",
            "source": "",
            "sha256": "",
            "n_frames": len(triggers),
            "trigger_ticks": np.asarray(triggers, np.int64),
            "frame_index": np.arange(len(triggers)),
            "segment": np.zeros(len(triggers), np.int64),
            "camera_type": "photon",
            "readout_mode": "snapshot",
            "pixels": PixelSums(pixel_sum=np.asarray(value, float), pixel_count=np.asarray(value, float)),
            "samples_per_turn": 1000,
            "track": track,
            "equal_track": track,
            "opening": opening,
            "axle": None,
            "integration_time_s": 250e-6,
            "trigger_delay_time_set_s": 0.0,
            "rotation_speed_hz": 3.0,
        }
        return ReducedRecording(**(values | fields))

    return make
