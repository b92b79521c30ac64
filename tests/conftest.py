"""Fixtures that several folders of tests share."""

import os
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

_ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def shared_recordings() -> Path:
    """Folder with example recordings of two cameras (cooled/, bolo/); tests skip where it is absent."""
    folder = Path(os.environ.get("IRTIMING_SHARED", _ROOT.parent / "shared")) / "recordings"
    if not folder.is_dir():
        pytest.skip(f"no example recordings in {folder}; set IRTIMING_SHARED to the folder that holds them")
    return folder


@pytest.fixture
def hand_made(tmp_path: Path) -> Callable[..., Path]:
    """Writer of a small sound recording in plain h5py, sharing nothing with the package.

    ``hand_made(change, name=...)`` calls ``change(file)`` on the open file before it is closed. ``text=bytes`` stores
    text in fixed length: a damaged length of a variable one makes HDF5 ask for gigabytes.
    """

    def write(
        change: Callable[[h5py.File], object] | None = None, *, name: str = "by-hand.nxs", text: type = str
    ) -> Path:
        path = tmp_path / name
        with h5py.File(path, "w") as file:
            _fill(file, np.bytes_ if text is bytes else str)
            if change is not None:
                change(file)
        return path

    return write


def _fill(file: h5py.File, text: type) -> None:
    turn, period, n_frames = 16_384_000, 1_622_016, 20
    rng = np.random.default_rng(1)
    camera = file.create_group("entry/instrument/camera")
    camera["type"] = text("photon")
    camera["readout_mode"] = text("snapshot")
    frames = rng.integers(1000, 9000, (n_frames, 4, 6), dtype=np.uint16)
    camera.create_dataset("data", data=frames, chunks=(1, 4, 6), compression="gzip")
    camera["count_time"] = 250e-6
    camera["count_time"].attrs["units"] = text("s")
    camera["trigger_delay_time_set"] = 0.025
    camera["bit_depth_readout"] = 14
    camera["frame_number"] = np.arange(n_frames)
    file["entry/instrument/chopper/rotation_speed"] = 3.0
    file["entry/instrument/chopper/rotation_speed"].attrs["units"] = text("Hz")
    generator = file.create_group("entry/instrument/trigger_generator")
    generator["clock_frequency"] = 49_152_000
    generator["clock_frequency"].attrs["units"] = text("Hz")
    start = 7_000_000
    generator["camera_trigger"] = start + turn + period * np.arange(n_frames)
    generator["control_slot"] = start + turn // 100 * np.arange(401)
    generator["application_slot"] = start + 5 + turn // 2 * np.arange(9)
    generator["application_edges"] = start + 5 + turn // 4 * np.arange(17)
    generator["camera_period"] = period
    generator["wheel_period"] = turn
    file["entry/instrument/blackbody/temperature"] = 303.15
    reference = file.create_group("entry/nonuniformity_reference")
    for stack, level in (("low", 1500), ("high", 8000)):
        reference[stack] = rng.integers(level - 20, level + 20, (10, 4, 6), dtype=np.uint16)
        reference[stack].attrs["temperature"] = 288.15 if stack == "low" else 303.15
