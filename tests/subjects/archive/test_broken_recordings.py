"""`verify` on a small simulated recording that was broken on purpose, one fault at a time."""

import shutil

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from irtiming.archive.rig_file import read_rig
from irtiming.archive.verify import verify
from irtiming.cli.main import app
from irtiming.session.simulation import CameraOrder, SimulationOrder, simulate

CAMERA = "entry/instrument/camera"
LINES = "entry/instrument/trigger_generator"


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    """A recording of 150 frames of 48 x 64 pixels, and its rig.toml."""
    folder = tmp_path_factory.mktemp("sound")
    found = simulate(SimulationOrder(folder=folder, camera=CameraOrder(rows=48, columns=64), frames=150))
    return found.recordings[0], found.rig


@pytest.fixture
def broken(sound, tmp_path):
    """Return a function that copies the sound recording, breaks it and gives what verify finds beside the summary."""

    def verified(change, rig=None):
        path = tmp_path / "broken.nxs"
        shutil.copy(sound[0], path)
        with h5py.File(path, "r+") as file:
            change(file)
        return {one.code: one for one in verify(path, rig=rig) if one.severity != "ok"}

    return verified


def _put(file, path, values):
    attributes = dict(file[path].attrs)
    del file[path]
    file[path] = values
    file[path].attrs.update(attributes)


def _exchange(file):
    slots, edges = file[f"{LINES}/control_slot"][()], file[f"{LINES}/application_slot"][()]
    _put(file, f"{LINES}/control_slot", edges)
    _put(file, f"{LINES}/application_slot", slots)


def test_the_recording_itself_is_sound(sound):
    """Oracle: nothing was broken."""
    assert [one.severity for one in verify(sound[0], rig=read_rig(sound[1]))] == ["ok"]


def test_exchanged_lines(broken):
    """Oracle: two edges a turn where a hundred should be, and the other way round: 50 times as far apart."""
    found = broken(_exchange)
    assert found["lines-exchanged"].severity == "error"
    assert "50 times as far apart" in found["lines-exchanged"].what
    assert "rotation-speed-contradicted" not in found


def test_triggers_that_far_outnumber_frames(broken):
    """Oracle: every second frame taken out; without frame_number the rest may have wrong triggers, with it not."""

    def halve(file, *, keep):
        numbers = np.arange(0, 150, 2)
        _put(file, f"{CAMERA}/data", file[f"{CAMERA}/data"][()][::2])
        _put(file, f"{CAMERA}/frame_number", numbers)
        if not keep:
            del file[f"{CAMERA}/frame_number"]

    found = broken(lambda file: halve(file, keep=False))["triggers-outnumber-frames"]
    assert (found.severity, found.what.split(",")[0]) == ("doubt", "has 150 triggers for 75 frames")
    assert broken(lambda file: halve(file, keep=True))["triggers-outnumber-frames"].severity == "warning"


@pytest.mark.parametrize(("n_frames", "is_enough"), [(3, False), (99, False), (100, True)])
def test_too_few_frames_to_analyse(broken, n_frames, is_enough):
    """Oracle: the reduction asks for a hundred frames; nothing that is said of fewer promises an analysis."""

    def cut(file):
        _put(file, f"{CAMERA}/data", file[f"{CAMERA}/data"][()][:n_frames])
        _put(file, f"{CAMERA}/frame_number", np.arange(n_frames))

    found = broken(cut)
    assert ("frames-few" in found) == (not is_enough)
    assert is_enough or found["frames-few"].what == (
        f"has {n_frames} frames, at least 100 are needed: analyse refuses the recording"
    )
    assert "goes on" not in found["frames-lost"].cure


def test_frames_without_signal(broken):
    """Oracle: frames of noise and a slow drift alone, as of a blackbody at the wheel's temperature."""

    def blind(file):
        rng, shape = np.random.default_rng(3), file[f"{CAMERA}/data"].shape
        drift = np.linspace(0, 40, shape[0])[:, None, None]
        _put(file, f"{CAMERA}/data", (5000 + drift + rng.normal(0, 6, shape)).astype(np.uint16))

    assert broken(blind)["frames-without-signal"].severity == "warning"


@pytest.mark.parametrize("flip", ["none", "left to right", "rotation"])
def test_a_rotation_that_the_image_contradicts(broken, sound, tmp_path, flip):
    """Oracle: a mirrored image, or the other rotation in rig.toml; as it was simulated nothing is said."""

    def change(file):
        if flip == "left to right":
            _put(file, f"{CAMERA}/data", file[f"{CAMERA}/data"][()][:, :, ::-1])

    text, other = sound[1].read_text(), tmp_path / "rig.toml"
    other.write_text(text.replace('"clockwise"', '"counterclockwise"') if flip == "rotation" else text)
    assert ("rotation-contradicted" in broken(change, read_rig(other))) == (flip != "none")


@pytest.mark.parametrize("line", ["control_slot", "application_slot"])
def test_edges_that_bounce(broken, line):
    """Oracle: three edges stamped once more 8 us later, by hand."""

    def bounce(file):
        clock_hz, ticks = float(file[f"{LINES}/clock_frequency"][()]), file[f"{LINES}/{line}"][()]
        _put(file, f"{LINES}/{line}", np.sort(np.append(ticks, ticks[[4, 9, 12]] + round(8e-6 * clock_hz))))

    found = broken(bounce)["edges-bounce"]
    assert "has 3 bouncing edges: within 8 µs of the one before, the first after entry 4" in found.what
    assert "glitch_filter to more than 8 µs" in found.cure


@pytest.mark.parametrize(("ppm", "severity"), [(30.0, "info"), (900.0, "doubt")])
def test_the_cameras_clock_against_the_triggers(broken, ppm, severity):
    """Oracle: the rate that was put in; crystals disagree by less than 200 ppm."""

    def stamp(file):
        triggers, clock_hz = file[f"{LINES}/camera_trigger"][()], float(file[f"{LINES}/clock_frequency"][()])
        file[f"{CAMERA}/frame_timestamp"] = np.rint((triggers / clock_hz * (1 + 1e-6 * ppm) + 3) * 1e9).astype(np.int64)
        file[f"{CAMERA}/timestamp_frequency"] = 1e9

    found = broken(stamp)["camera-clock-rate"]
    assert found.severity == severity
    assert f"runs {ppm:+.1f}" in found.what


def test_the_command_takes_a_rig(sound):
    """Oracle: the sound recording and the rig that it was simulated on."""
    done = CliRunner().invoke(app, ["verify", str(sound[0]), "--rig", str(sound[1])])
    assert (done.exit_code, done.stdout.count("\n")) == (0, 1)
