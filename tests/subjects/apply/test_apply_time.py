"""`irtiming apply time` from files to files: numbers by hand, copies of recordings, and what is refused."""

import csv
import io
import json
import subprocess
import sys

import h5py
import numpy as np
import pytest
from made_up_result import BOLOMETER, COOLED, made_up_result
from pyarrow import parquet

from irtiming.apply.stamps import Generator, Latency
from irtiming.archive import layout, reader
from irtiming.archive.result_file import write_result
from irtiming.session.apply_time import camera_of
from irtiming.session.frame_stamps import StampsWanted, read

CLOCK_HZ = 49_152_000


def _result(tmp_path, *camera, **fields):
    path = tmp_path / "result.json"
    content = made_up_result(*camera, **fields).model_dump(mode="json")
    write_result({key: value for key, value in content.items() if key not in ("format", "version")}, path)
    return path


def _lines(path):
    with io.StringIO(path) if isinstance(path, str) else path.open() as file:
        text = [line for line in file if not line.startswith("#")]
    return [{name: float(value) for name, value in line.items()} for line in csv.DictReader(text)]


def test_times_of_a_recording_are_trigger_plus_set_delay_plus_delay(tmp_path, hand_made, told):
    """Oracle: by hand; frame n of the recording was triggered at 7 000 000 + one turn + n periods, and 25 ms were set."""
    result = _result(tmp_path, "photon", "snapshot", COOLED, rows=4, window_s=2.5e-4)
    content = json.loads(result.read_text())
    content["inputs"][0]["image"] = {"rows": 4, "columns": 6}
    result.write_text(json.dumps(content))
    recording = hand_made()
    status, said, _ = told("apply", "time", result, recording, "--out", tmp_path / "times.csv")
    assert status == 0
    assert "times of 20 frames, 1 row each" in said
    found = _lines(tmp_path / "times.csv")
    for n, line in enumerate(found):
        trigger_s = (7_000_000 + 16_384_000 + 1_622_016 * n) / CLOCK_HZ + 0.025
        assert line["frame"] == n
        assert line["start_s"] == pytest.approx(trigger_s + 4e-4, abs=2e-9)
        assert line["end_s"] == pytest.approx(trigger_s + 6.5e-4, abs=2e-9)
    head = (tmp_path / "times.csv").read_text()
    assert "# reference event: the trigger edge that the camera accepts" in head
    assert "# middle: middle of integration" in head

    status, _, _ = told("apply", "time", result, recording, "--out", tmp_path / "with.nxs")
    assert status == 0
    with h5py.File(tmp_path / "with.nxs") as file:
        times = file["entry/frame_times"]
        assert times["start_time"][3, 0] == pytest.approx(found[3]["start_s"], abs=2e-9)
        assert times["start_time"].attrs["units"] == "s"
        assert times["start_time_errors"][0] == pytest.approx(found[0]["u_start_s"], rel=1e-3)
    assert np.array_equal(reader.read(tmp_path / "with.nxs").frame_number, np.arange(20))

    status, _, error = told("apply", "time", result, recording, "--out", tmp_path / "times.parquet")
    assert status == 0, error
    table = parquet.read_table(tmp_path / "times.parquet")
    assert b"positive after it" in table.schema.metadata[b"irtiming"]
    assert table["frame"].to_pylist() == list(range(20))
    assert table["start_ns"][7].as_py() == pytest.approx(1e9 * found[7]["start_s"], abs=1)
    assert table["u_end_s"][7].as_py() == pytest.approx(found[7]["u_end_s"], rel=1e-3)


def test_stamps_of_arrival_are_denoised_and_their_latency_is_taken_off(tmp_path, told):
    """Oracle: by hand; frames every 33 ms that arrive 12 ms late, every tenth 5 ms later still."""
    stamps = tmp_path / "stamps.csv"
    rng = np.random.default_rng(4)
    arrival = 0.033 * np.arange(200) + 0.012 + rng.normal(0, 2e-5, 200) + 5e-3 * (np.arange(200) % 10 == 7)
    nanos = 1_700_000_000 * 10**9 + np.rint(arrival * 1e9).astype(np.int64)
    stamps.write_text("stamp_ns\n" + "\n".join(map(str, nanos.tolist())) + "\n")
    result = _result(tmp_path, "microbolometer", "rolling", BOLOMETER)
    status, said, _ = told(
        "apply", "time", result, stamps, "--out", tmp_path / "times.csv", "--kind", "arrival", "--rows", "0,100",
        "--latency", "12 ms", "--latency-u", "100 us",
    )  # fmt: skip
    assert status == 0
    assert "10.0 % are later by five times as much" in said
    text = next(line for line in (tmp_path / "times.csv").read_text().splitlines() if line.startswith("7,100,"))
    whole, nano = text.split(",")[2].split(".")
    since_s = int(whole) - 1_700_000_000 + int(nano) * 1e-9
    assert since_s == pytest.approx(0.033 * 7 + 4e-3 + 100 * 4e-5, abs=2e-5)
    assert float(text.split(",")[3]) == pytest.approx(np.sqrt(1e-4**2 + 3e-5**2 + (100 * 2e-7) ** 2), rel=0.05)


@pytest.mark.parametrize(("column", "is_doubted"), [("stamp_ms", False), ("stamp_s", True), ("stamp_us", True)])
def test_a_unit_that_cannot_be_right_is_told(tmp_path, told, column, is_doubted):
    """Oracle: by hand; milliseconds of frames 33 ms apart, as they were measured, under the names of three units."""
    stamps = tmp_path / "stamps.csv"
    stamps.write_text(f"{column}\n" + "".join(f"{33 * n}\n" for n in range(10)))
    result = _result(tmp_path, "photon", "snapshot", COOLED, window_s=2.5e-4)
    status, said, _ = told("apply", "time", result, stamps, "--out", tmp_path / "times.csv")
    assert status == 0
    doubt = "apart by their stamps (median), those that were measured 33 ms: is the unit of the stamps right?"
    assert (doubt in said) == is_doubted
    assert (f"note: frames are {'33 s' if column == 'stamp_s' else '33 µs'} {doubt}" in said) == is_doubted
    assert (doubt in (tmp_path / "times.csv").read_text()) == is_doubted


@pytest.mark.parametrize(
    ("text", "rows", "said"),
    [
        ("stamp_s\n1.0\n0.9\n", "0", "stamps.csv: stamp 1 is not later than the one before"),
        ("stamp_s\n1.0\n1.1\n", "0,500", "result.json: rows must be from 0 to 119; [0.0, 500.0] are asked for"),
    ],
)
def test_an_error_names_its_file(tmp_path, told, text, rows, said):
    """Oracle: by hand; stamps are those of the CSV, rows those of the result."""
    (tmp_path / "stamps.csv").write_text(text)
    result = _result(tmp_path, "microbolometer", "rolling", BOLOMETER)
    out = ("--out", tmp_path / "times.csv", "--kind", "trigger", "--rows", rows)
    status, _, error = told("apply", "time", result, tmp_path / "stamps.csv", *out)
    assert (status, error.count("\n")) == (2, 1)
    assert f"irtiming: {tmp_path}/{said}" in error


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"correlation": {"names": ["trigger_delay", "row_delay"], "matrix": [[1.0]]}},
            "is no matrix of 2 rows and columns",
        ),
        (
            {
                "parameters": {},
                "bounds": {name: {"lower": 0.0, "upper": None, "unit": "s"} for name in BOLOMETER},
                "correlation": {"names": [], "matrix": []},
            },
            "the result has no trigger delay that can be applied (it has none)",
        ),
    ],
)
def test_a_result_that_cannot_be_applied_is_named(tmp_path, told, change, said):
    """Oracle: by hand; a file that somebody changed, its name and what is wrong in one line."""
    result = _result(tmp_path, "microbolometer", "rolling", BOLOMETER)
    result.write_text(json.dumps(json.loads(result.read_text()) | change))
    (tmp_path / "stamps.csv").write_text("stamp_s\n1.0\n1.1\n")
    for command in (("time", result, tmp_path / "stamps.csv"), ("export", result, "--to", "vins")):
        status, _, error = told("apply", *command, "--out", tmp_path / "out")
        assert (status, error.count("\n")) == (2, 1)
        assert error.startswith(f"irtiming: {result}: ")
        assert said in error


def test_what_was_not_compared_is_said(tmp_path, hand_made, told):
    """Oracle: by hand; a CSV says nothing of its camera, a TIFF made of a recording all that the recording did."""
    result = _result(tmp_path, "photon", "snapshot", COOLED, rows=4, window_s=2.5e-4)
    content = json.loads(result.read_text())
    content["inputs"][0]["image"] = {"rows": 4, "columns": 6}
    result.write_text(json.dumps(content))
    (tmp_path / "stamps.csv").write_text("stamp_s\n1.0\n1.033\n")
    for ending in ("tif", "npy"):
        assert told("convert", hand_made(), tmp_path / f"run.{ending}")[0] == 0
    all_of_it = "note: detector, readout mode, serial number, image size and integration time were not compared"
    for name, says in (
        ("stamps.csv", all_of_it),
        ("run.tif", "note: serial number was not compared"),
        ("run.npy", "note: serial number was not compared"),
        ("by-hand.nxs", "note: serial number was not compared"),
    ):
        status, said, error = told("apply", "time", result, tmp_path / name, "--out", tmp_path / f"{name}.csv")
        assert status == 0, error
        assert [line for line in said.splitlines() if line.startswith("note: ")][-1:] == [says]


def test_a_converted_recording_of_another_detector_is_refused(tmp_path, hand_made, told):
    """Oracle: by hand; the TIFF says photon as the recording did, the result is of a microbolometer."""
    assert told("convert", hand_made(), tmp_path / "run.tif")[0] == 0
    result = _result(tmp_path, "microbolometer", "rolling", BOLOMETER)
    status, _, error = told("apply", "time", result, tmp_path / "run.tif", "--out", tmp_path / "times.csv")
    assert status == 2
    assert "its detector is photon, the result was measured with microbolometer" in error


@pytest.mark.parametrize("ending", ["csv", "parquet", "nxs"])
def test_a_frame_keeps_the_number_that_its_file_gives_it(tmp_path, hand_made, told, ending):
    """Oracle: by hand; the camera lost frames 5 and 6, so the frame at place 5 was made by trigger 7."""
    result = _result(tmp_path, "photon", "snapshot", COOLED, rows=4, window_s=2.5e-4)
    content = json.loads(result.read_text())
    content["inputs"][0]["image"] = {"rows": 4, "columns": 6}
    result.write_text(json.dumps(content))
    kept = np.delete(np.arange(20), [5, 6])

    def lost(file):
        for field in (layout.FRAMES, layout.FRAME_NUMBER):
            values = file[field.path][()][kept]
            del file[field.path]
            file[field.path] = values

    out = tmp_path / f"times.{ending}"
    status, _, error = told("apply", "time", result, hand_made(lost), "--out", out)
    assert status == 0, error
    start_s = (7_000_000 + 16_384_000 + 1_622_016 * 7) / CLOCK_HZ + 0.025 + 4e-4
    if ending == "csv":
        found = _lines(out)
        numbers, at_s = [line["frame"] for line in found], found[5]["start_s"]
    elif ending == "parquet":
        table = parquet.read_table(out)
        numbers, at_s = table["frame"].to_pylist(), 1e-9 * table["start_ns"][5].as_py()
    else:
        with h5py.File(out) as file:
            numbers, at_s = file["entry/frame_times/frame"][()].tolist(), file["entry/frame_times/start_time"][5, 0]
    assert numbers == kept.tolist()
    assert at_s == pytest.approx(start_s, abs=2e-9)


def test_a_frame_keeps_the_number_of_a_csv_and_of_a_file_of_frames(tmp_path, told):
    """Oracle: by hand; the camera counted from 12 and lost 14 to 20."""
    result = _result(tmp_path, "photon", "snapshot", COOLED, rows=4, window_s=2.5e-4)
    (tmp_path / "stamps.csv").write_text("frame,stamp_s\n12,1.0\n13,1.033\n21,1.297\n")
    np.save(tmp_path / "a.npy", np.zeros((3, 4, 160), np.uint16))
    facts = {"trigger_times_s": [1.0, 1.033, 1.297], "frame_id": [12, 13, 21]}
    (tmp_path / "a.npy.json").write_text(json.dumps(facts))
    for source in ("stamps.csv", "a.npy"):
        out = tmp_path / f"times-of-{source}.csv"
        status, _, error = told("apply", "time", result, tmp_path / source, "--out", out)
        assert status == 0, error
        assert [line["frame"] for line in _lines(out)] == [12, 13, 21]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--out", "times.csv"), "its detector is photon, the result was measured with microbolometer"),
        (("--out", "times.csv", "--rows", "a"), "--rows a are no image rows"),
        (("--out", "recording"), "would be overwritten"),
        (("--out", "times.csv", "--latency", "3"), "'3' has no unit"),
        (
            ("--out", "times.csv", "--latency-u", "1 ms"),
            "--latency-u is the standard uncertainty of --latency, which is not",
        ),
        (("--out", "times.csv", "--latency", "0", "--latency-u", "-1ms"), "--latency-u is -0.001, must be 0 or more"),
    ],
)
def test_what_cannot_be_applied_ends_in_one_line(tmp_path, hand_made, told, arguments, said):
    """Oracle: exit status 2, one line, its words."""
    result, recording = _result(tmp_path, "microbolometer", "rolling", BOLOMETER), hand_made()
    words = [
        recording if word == "recording" else tmp_path / word if word.endswith("csv") else word for word in arguments
    ]
    status, _, error = told("apply", "time", result, recording, *words)
    assert status == 2
    assert error.count("\n") == 1
    assert said in error
    assert not (tmp_path / "times.csv").exists()


def test_recordings_whose_camera_calls_another_number_are_refused(tmp_path, hand_made, told):
    """Oracle: serial numbers 7 and 8."""
    result = _result(tmp_path, "photon", "snapshot", COOLED)

    def other(file):
        for name in ("vendor", "model", "serial_number", "firmware", "address"):
            file[f"entry/instrument/camera/{name}"] = "8"

    status, _, error = told("apply", "time", result, hand_made(other), "--out", tmp_path / "times.csv")
    assert status == 2
    assert "its serial number is 8, the result was measured with 7" in error


def test_stamps_of_the_camera_go_onto_the_counter_by_a_calibration(tmp_path, hand_made, told):
    """Oracle: by hand; the camera's clock runs 40 ppm fast and 3 s ahead, with 20 us of jitter; triggers as recorded.

    The trigger's latency of 1 ms is part of the calibration, and the generator's clock is as known as rig.toml says.
    """
    result = _result(tmp_path, "photon", "snapshot", COOLED)
    content = json.loads(result.read_text())
    content["inputs"][0]["image"] = {"rows": 4, "columns": 6}
    result.write_text(json.dumps(content))
    trigger_s = (7_000_000 + 16_384_000 + 1_622_016 * np.arange(20)) / CLOCK_HZ + 0.025
    jitter = np.random.default_rng(3).normal(0, 2e-5, 20)

    def stamped(file):
        file["entry/instrument/camera/frame_timestamp"] = np.rint(1e6 * (3 + (1 + 4e-5) * trigger_s + jitter)).astype(
            np.int64
        )
        file["entry/instrument/camera/timestamp_frequency"] = 1e6

    measured = hand_made(stamped, name="measured.nxs")
    later_s = trigger_s[-1] + 0.033 * np.arange(1, 9)
    stamps = tmp_path / "later.csv"
    stamps.write_text("stamp_us\n" + "\n".join(f"{1e6 * (3 + (1 + 4e-5) * one):.0f}" for one in later_s) + "\n")
    status, said, error = told(
        "apply", "time", result, stamps, "--kind", "camera", "--calibrated-by", measured, "--out", tmp_path / "times.csv"
    )  # fmt: skip
    assert status == 0, error
    assert "neither clock was switched off since" in said
    found = _lines(tmp_path / "times.csv")
    for line, true_s in zip(found, later_s, strict=True):
        assert line["start_s"] == pytest.approx(true_s + 4e-4, abs=4 * line["u_start_s"])
        assert 1.5e-5 < line["u_start_s"] < 6e-5

    wanted = StampsWanted(source=stamps, kind="camera", calibrated_by=measured)
    known = Generator(relative_error=1e-5, u_relative_error=1e-7, way=Latency(value_s=1e-3, u_s=2e-4))
    without, better = (read(wanted, camera_of(result), generator=one).events for one in (None, known))
    assert np.allclose(better.time_s, without.time_s + 1e-3, rtol=0, atol=1e-9)
    assert (better.relative_rate, better.u_rate, better.u_cancelled_s) == (1e-5, 1e-7, 2e-4)


def test_times_on_the_standard_output_are_csv_alone(tmp_path):
    """Oracle: a CSV parser; words go to standard error, and no file is made, for the file - or what no text is."""
    stamps = tmp_path / "stamps.csv"
    stamps.write_text("stamp_s\n1.0\n1.033\n")
    result = _result(tmp_path, "photon", "snapshot", COOLED, window_s=2.5e-4)
    before = sorted(tmp_path.iterdir())
    words = [sys.executable, "-m", "irtiming", "apply", "time", str(result), str(stamps), "--out"]
    done = subprocess.run([*words, "-"], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, [line["frame"] for line in _lines(done.stdout)]) == (0, [0, 1]), done.stderr
    assert "times of 2 frames" in done.stderr
    words = [sys.executable, "-m", "irtiming", "apply", "frames", str(result), str(stamps), "-"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert "is the standard output, which takes text alone" in done.stderr
    assert sorted(tmp_path.iterdir()) == before
