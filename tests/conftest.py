"""Fixtures that several folders of tests share."""

import gc
import os
import signal
from collections.abc import Callable, Generator, Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import settings

from irtiming.records.exposed import ExposedRows

settings.register_profile("compiled", deadline=None)  # what is compiled takes its time at the first call
settings.load_profile("compiled")

_OBJECTS_PER_SEARCH = 10_000, 20, 50  # a search after every 700, as usual, takes a seventh of the time
_ROOT = Path(__file__).resolve().parent.parent


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Garbage is not looked for among thousands of collected tests, all of which stay, and seldom among what tests keep."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.collect()
        gc.freeze()
        gc.set_threshold(*_OBJECTS_PER_SEARCH)
        gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What runs whole programs comes first: at the end the small ones keep all processes busy."""
    items.sort(key=lambda item: "round_trip" not in item.path.parts)


@pytest.fixture(scope="session")
def shared_recordings() -> Path:
    """Folder with example recordings of two cameras (cooled/, bolo/); tests skip where it is absent."""
    folder = Path(os.environ.get("IRTIMING_SHARED", _ROOT.parent / "shared")) / "recordings"
    if not folder.is_dir():
        pytest.skip(f"no example recordings in {folder}; set IRTIMING_SHARED to the folder that holds them")
    return folder


@pytest.fixture
def signals_as_before() -> Iterator[None]:
    """Handlers of Ctrl-C and SIGTERM are set back: a command that was run in this process leaves them ignored."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], signals_as_before: None
) -> Callable[..., tuple[object, str, str]]:
    """The command line in this process: told("apply", ...) gives exit status, output and error."""
    from irtiming.cli.main import run

    def words(*arguments: object) -> tuple[object, str, str]:
        monkeypatch.setattr("sys.argv", ["irtiming", *map(str, arguments)])
        with pytest.raises(SystemExit) as ending:
            run()
        shown = capsys.readouterr()
        return ending.value.code or 0, shown.out, shown.err

    return words


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


@pytest.fixture(scope="session")
def lagging_rows() -> Callable[..., ExposedRows]:
    """Data of a rolling microbolometer camera in closed form: each harmonic of a row's opening, divided by 1 + i k omega tau.

    The opening of a row is the share of the mask's pixel centres that the wheel leaves uncovered; no step is integrated.
    """
    n_fine = 16_384
    fine = 2 * np.pi * np.arange(n_fine) / n_fine
    k = np.arange(n_fine // 2 + 1)

    def rows(mask, wheel_centre_px, *, timing_s, gate_rad, edges_rad, **fields) -> ExposedRows:
        delay_s, row_delay_s, tau_s = timing_s
        options = {"n": 1000, "rate_hz": 3.0, "set_delay_s": 0.0, "noise": 0.0, "lost": 0} | fields
        omega = 2 * np.pi * options["rate_hz"]
        angle = 2 * np.pi * np.delete((np.arange(options["n"]) + 0.3) / options["n"], np.arange(options["lost"]) * 7)
        row_px, pixels = np.unique(np.nonzero(mask)[0], return_counts=True)
        curves = []
        for y in row_px:
            column = np.flatnonzero(mask[y])
            phi = np.arctan2(y - wheel_centre_px[0], column - wheel_centre_px[1])
            steps = np.zeros(n_fine)  # derivative of the opening, each crossing shared between its two neighbours
            for sign, edge in zip((-1, 1, -1, 1), edges_rad, strict=True):
                place = np.mod(phi - gate_rad + edge, 2 * np.pi) / (2 * np.pi) * n_fine
                below = place.astype(int)
                np.add.at(steps, below % n_fine, sign * (1 - place % 1) / column.size)
                np.add.at(steps, (below + 1) % n_fine, sign * (place % 1) / column.size)
            late = omega * (delay_s + options["set_delay_s"] + y * row_delay_s)
            wave = np.fft.rfft(steps) * np.exp(1j * k * late) / (1 + 1j * k * omega * tau_s)
            wave[1:] *= n_fine / (2j * np.pi * k[1:])
            curves.append(np.interp(angle, fine, np.fft.irfft(wave), period=2 * np.pi))
        exact = np.array(curves)
        noise = np.random.default_rng(1).standard_normal(exact.shape) * options["noise"] / np.sqrt(pixels)[:, None]
        curves = exact + noise
        return ExposedRows(
            trigger_delay_time_set_s=options["set_delay_s"],
            rotation_speed_hz=options["rate_hz"],
            angular_frequency_rad_per_s=omega,
            names=("closed form",),
            files=(),
            wheel_angle_rad=angle,
            fraction=_between_plateaus(pixels @ curves / pixels.sum(), pixels @ exact / pixels.sum()),
            u_fraction=None,
            row_px=row_px,
            row_fraction=np.array([_between_plateaus(c, e) for c, e in zip(curves, exact, strict=True)]),
            u_row_fraction=None,
            mask=mask,
        )

    return rows


def _between_plateaus(curve: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """The curve scaled by the averages of the extrema, without noise, of its two upper and two lower plateaus."""
    place = (exact - exact.min()) / np.ptp(exact)
    clear = np.flatnonzero((place < 0.25) | (place > 0.75))  # some rows rest half way
    upper = place[clear] > 0.5
    starts = np.flatnonzero(upper != np.roll(upper, 1))
    parts = np.split(np.roll(clear, -starts[0]), starts[1:] - starts[0])
    parts = [exact[part] for part in parts]
    highs, lows = (parts[::2], parts[1::2]) if upper[starts[0]] else (parts[1::2], parts[::2])
    low, high = np.mean([part.min() for part in lows]), np.mean([part.max() for part in highs])
    return (curve - low) / (high - low)
