"""`irtiming apply frames` from file to file: films of a moving scene in recordings, and what is refused."""

import csv
import json
import os

import h5py
import numpy as np
import pytest
from made_up_result import made_up_result
from moving_scene import COLUMNS, EDGE_COLUMNS, HIGH, LOW, ROWS, FilmedBy, film

from irtiming.archive.result_file import write_result
from irtiming.web.orders import ApplyOrder
from irtiming.web.tasks import applying

CAMERA = FilmedBy(row_delay_s=7e-4, tau_s=5e-3)
NUMBERS = {"trigger_delay": (4e-3, 2e-5), "time_constant": (5e-3, 5e-6), "row_delay": (7e-4, 1e-7)}
CLOCK_HZ = 50_000_000


@pytest.fixture(scope="module")
def filmed():
    """A film in whole counts: 10 DN of noise's tenth beside a step of 900."""
    return film(CAMERA, noise=0.9)


@pytest.fixture
def recording(hand_made, filmed):
    """The film as a recording; frame 20 is lost."""
    kept = np.delete(np.arange(len(filmed.frames)), 20)

    def fill(file):
        camera = file["entry/instrument/camera"]
        for name in ("data", "frame_number", "type", "readout_mode", "count_time"):
            del camera[name]
        del file["entry/nonuniformity_reference"]
        camera["type"], camera["readout_mode"] = "microbolometer", "rolling"
        camera["data"] = np.rint(filmed.frames[kept]).astype(np.uint16)
        camera["frame_number"] = kept
        camera["trigger_delay_time_set"][()] = 0.0
        generator = file["entry/instrument/trigger_generator"]
        for name in ("camera_trigger", "clock_frequency", "camera_period", "wheel_period"):
            del generator[name]
        generator["clock_frequency"] = CLOCK_HZ
        generator["camera_trigger"] = np.rint(filmed.trigger_s * CLOCK_HZ).astype(np.int64)

    return hand_made(fill)


def _result(tmp_path, numbers=NUMBERS):
    content = made_up_result("microbolometer", "rolling", numbers, rows=ROWS).model_dump(mode="json")
    content["inputs"][0]["image"]["columns"] = COLUMNS
    write_result(
        {key: value for key, value in content.items() if key not in ("format", "version")}, tmp_path / "result.json"
    )
    return tmp_path / "result.json"


def _edge_errors(filmed, frames, times_s):
    edge = ((frames[:, :, :EDGE_COLUMNS].astype(float) - LOW) / (HIGH - LOW)).sum(axis=2)
    return np.sqrt(np.mean((edge - filmed.edge_px(times_s)[:, None]) ** 2, axis=1))


def test_a_recording_becomes_the_scene_at_one_instant(tmp_path, told, filmed, recording):
    """Oracle: the scene that was filmed; a frame was lost, so the runs 0..19 and 21..39 give what lies between their ends."""
    status, said, _ = told("apply", "frames", _result(tmp_path), recording, tmp_path / "scene.nxs")
    assert status == 0
    assert "35 of 39 frames" in said
    with h5py.File(tmp_path / "scene.nxs") as file:
        scene, frames = file["entry/scene"], file["entry/instrument/camera/data"][()]
        number, time_s = scene["frame_number"][()], scene["time"][()]
        assert number.tolist() == [*range(1, 19), *range(22, 39)]
        assert scene["noise_gain"].shape == (35, ROWS // 8, COLUMNS // 8)
        assert scene["gain"][()].max() <= 1
        assert scene["time_errors"][()] == pytest.approx(2e-5, rel=0.02)
    index = number
    instants = filmed.trigger_s[index] + 4e-3 + 7e-4 * (ROWS - 1) / 2
    assert np.allclose(time_s, instants, atol=1e-7)
    settled = (index > 4) & ((index < 19) | (index > 24))
    before = _edge_errors(filmed, np.rint(filmed.frames[index]), instants)[settled]
    after = _edge_errors(filmed, frames, instants)[settled]
    assert np.sqrt(np.mean(after**2)) < np.sqrt(np.mean(before**2)) / 10
    assert np.mean(after) < np.mean(before)


def test_an_instant_is_as_uncertain_as_the_time_of_its_row(tmp_path, told, recording):
    """Oracle: irtiming apply time of the same moment of the same row, to 10 ns; the clock, which nothing states, tells most."""
    result = _result(tmp_path, {**NUMBERS, "trigger_delay": (4e-3, 1e-8), "row_delay": (7e-4, 1e-9)})
    told("apply", "frames", result, recording, tmp_path / "scene.nxs", "--instant-row", "9")
    told("apply", "time", result, recording, "--out", tmp_path / "times.csv", "--rows", "9")
    lines = [line for line in (tmp_path / "times.csv").read_text().splitlines() if not line.startswith("#")]
    row = next(csv.DictReader(lines))
    with h5py.File(tmp_path / "scene.nxs") as file:
        assert file["entry/scene/time_errors"][()] == pytest.approx(float(row["u_reading_s"]), abs=6e-9)


def test_frames_without_times_take_their_period(tmp_path, told, filmed):
    """Oracle: the same frames in a NumPy file of floats, 30 ms apart, are found as close."""
    np.save(tmp_path / "film.npy", filmed.frames.astype(np.float32))
    status, said, error = told(
        "apply", "frames", _result(tmp_path), tmp_path / "film.npy", tmp_path / "scene.nxs", "--period", "30 ms", "--noise", "0.9"
    )  # fmt: skip
    assert status == 0, error
    with h5py.File(tmp_path / "scene.nxs") as file:
        frames, number = file["entry/instrument/camera/data"][()], file["entry/scene/frame_number"][()]
    assert frames.dtype == np.float32
    instants = filmed.trigger_s[number] + 4e-3 + 7e-4 * (ROWS - 1) / 2
    assert np.sqrt(np.mean(_edge_errors(filmed, frames, instants)[5:] ** 2)) < 0.04
    assert "noise of 0.9 DN" in said


@pytest.mark.parametrize(
    ("kind", "added", "written"),
    [("u2", 3000, "u2"), ("i2", -3000, "f4"), ("u4", 70_000, "f4"), ("i4", 100_000, "f4")],
)
def test_pixels_keep_their_values_whatever_type_they_came_as(tmp_path, told, filmed, kind, added, written):
    """Oracle: a law; numbers added to all pixels are in the scene too, whether a count of 16 bits can be that or not."""
    np.save(tmp_path / "film.npy", np.rint(filmed.frames + added).astype(kind))
    np.save(tmp_path / "plain.npy", np.rint(filmed.frames).astype("f4"))
    frames = {}
    for name in ("film", "plain"):
        told("apply", "frames", _result(tmp_path), tmp_path / f"{name}.npy", tmp_path / f"{name}.nxs", "--period", "30 ms",
             "--noise", "0.9")  # fmt: skip
        with h5py.File(tmp_path / f"{name}.nxs") as file:
            frames[name] = file["entry/instrument/camera/data"][()]
    assert frames["film"].dtype == written
    assert np.abs(frames["film"] - (frames["plain"].astype(float) + added)).max() < 0.6


def test_two_time_constants_need_to_know_what_a_count_stands_for(tmp_path, told, recording):
    """Oracle: words of what was undone; with a scene that exchanges nothing the two are the one, and so are the frames."""
    content = json.loads(_result(tmp_path).read_text())
    tau = content["parameters"]["time_constant"]
    content["parameters"]["substrate_time_constant"] = tau | {"value": 5e-3}
    content["parameters"]["scene_time_constant"] = tau | {"value": 1e6}
    content["two_constants"] = {"substrate_temperature": {"value": 300.0, "unit": "K"}}
    (tmp_path / "two.json").write_text(json.dumps(content))
    kelvin = ("--kelvin-at-zero", "280", "--kelvin-per-count", "0.05")
    found = []
    for name, words in (("result", ()), ("two", ()), ("two", kelvin)):
        status, said, error = told(
            "apply", "frames", tmp_path / f"{name}.json", recording, tmp_path / "scene.nxs", *words
        )
        assert status == 0, error
        with h5py.File(tmp_path / "scene.nxs") as file:
            found.append((said, file["entry/instrument/camera/data"][()].astype(int)))
        (tmp_path / "scene.nxs").unlink()
    assert "two time constants; counts do not give temperatures" in found[1][0]
    assert "time constants of substrate and scene undone" in found[2][0]
    assert np.array_equal(found[0][1], found[1][1])
    assert np.abs(found[0][1] - found[2][1]).max() <= 1
    status, _, error = told(
        "apply", "frames", tmp_path / "two.json", recording, tmp_path / "scene.nxs", *kelvin[:3], "-1"
    )  # fmt: skip
    assert status == 2
    assert "a count stands for -1.0 K, must be more than 0" in error


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("scene.npy",), "the scene is written as .nxs"),
        (("scene.nxs", "--period", "1 ms"), "tells when its frames were, every 30 ms, and a period of 1 ms is given"),
        (("scene.nxs", "--period", "1 ms", "--stamps", "result.json"), "stamps and a period are given"),
        (("missing/scene.nxs",), "there is no folder"),
    ],
)
def test_what_cannot_be_made_ends_in_one_line(tmp_path, told, recording, words, said):
    """Oracle: exit status 2, one line, its words, no file."""
    status, _, error = told("apply", "frames", _result(tmp_path), recording, tmp_path / words[0], *words[1:])
    assert status == 2
    assert error.count("\n") == 1
    assert said in error
    assert not (tmp_path / words[0]).exists()
    assert not list(tmp_path.glob("*.part"))


def test_rows_must_be_read_within_a_frame(tmp_path, told, filmed):
    """Oracle: by hand; 31 row delays of 0.7 ms are 21.7 ms."""
    np.save(tmp_path / "film.npy", filmed.frames.astype(np.float32))
    words = ("apply", "frames", _result(tmp_path), tmp_path / "film.npy", tmp_path / "scene.nxs", "--period", "1 ms")
    status, _, error = told(*words)
    assert status == 2
    assert "rows are read over 21.700 ms, a frame lasts 1.000 ms" in error


def test_a_file_that_tells_no_times_is_refused(tmp_path, told, filmed):
    """Oracle: exit status 2 and the cure."""
    np.save(tmp_path / "film.npy", filmed.frames.astype(np.float32))
    status, _, error = told("apply", "frames", _result(tmp_path), tmp_path / "film.npy", tmp_path / "scene.nxs")
    assert status == 2
    assert "has no times of its frames; give its stamps as CSV" in error


def test_a_scene_is_no_recording(tmp_path, told, recording):
    """Oracle: what was corrected once is refused as input of another correction or analysis."""
    told("apply", "frames", _result(tmp_path), recording, tmp_path / "scene.nxs")
    status, _, error = told("apply", "frames", _result(tmp_path), tmp_path / "scene.nxs", tmp_path / "twice.nxs")
    assert status == 2
    assert "is missing" in error


class _Quiet:
    """The page's line to a task, unheard."""

    def says(self, text):
        pass

    def step(self, part, *, done, total):
        pass


def test_the_page_makes_what_the_commands_make(tmp_path, recording, told, monkeypatch):
    """Oracle: the files of `irtiming apply frames` and `irtiming apply time`, with results at two frame rates."""
    results = []
    for number, period_s in enumerate((20e-3, 50e-3)):
        content = made_up_result("microbolometer", "rolling", NUMBERS, rows=ROWS).model_dump(mode="json")
        content["inputs"][0] |= {"frame_period": period_s, "image": {"rows": ROWS, "columns": COLUMNS}}
        results.append(tmp_path / f"result{number}.json")
        write_result({key: value for key, value in content.items() if key not in ("format", "version")}, results[-1])
    first, other = results
    for words in (
        ("frames", first, recording, tmp_path / "a.nxs"),
        ("time", first, recording, "--out", tmp_path / "a.csv"),
    ):
        assert told("apply", *words, "--series", other)[0] == 0
    order = ApplyOrder(
        result=first, source=recording, out=tmp_path / "b.nxs", series=(other,), times=tmp_path / "b.csv"
    )
    monkeypatch.setattr(os, "nice", lambda _: 0)  # the tests after this one share the process
    done = applying.apply(_Quiet(), order)
    assert done["n_written"] < done["n_frames"]
    with h5py.File(tmp_path / "a.nxs") as made, h5py.File(tmp_path / "b.nxs") as again:
        assert np.array_equal(made["entry/scene/gain"], again["entry/scene/gain"])
    assert (tmp_path / "a.csv").read_text() == (tmp_path / "b.csv").read_text()
