"""`irtiming export-vcd` and `irtiming import-capture`, from a simulated recording to its result and back."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from irtiming.archive import reader, rig_writer, writer
from irtiming.cli.main import app
from irtiming.errors import IrTimingError
from irtiming.records.recording import Recording
from irtiming.twin.rig import draw, simulate
from irtiming.twin.scene import paper_scene, with_wheel_speed

STREAMS = ("camera_trigger", "control_slot", "application_slot", "application_edges")
MAP = ",".join(f"{name}={name}" for name in STREAMS)
ANALYSER_HZ = 24_000_000
TOO_FAST = 40e-6
"""How much the analyser's clock is faster than it says."""


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a recording of the twin, its rig and its timestamps as a dump."""
    folder = tmp_path_factory.mktemp("capture")
    drawn = draw(with_wheel_speed(paper_scene(48, 64), 3.0, samples=300), seed=7)
    writer.write(simulate(drawn.scene, seed=7, name="twin"), folder / "twin.nxs")
    rig_writer.write_rig(drawn.measured, folder / "rig.toml")
    _run("export-vcd", folder / "twin.nxs")
    return folder


@pytest.fixture(scope="module")
def own_delay(place: Path) -> dict[str, float]:
    """Trigger delay with the generator's own timestamps."""
    return _delay(place, place / "twin.nxs")


def _run(*arguments: object) -> str:
    done = CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "200"})
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.output


def _streams(recording: Recording) -> list[list[int]]:
    streams = (
        recording.camera_trigger_ticks, recording.control_slot_ticks, recording.application_slot_ticks,
        recording.application_edge_ticks,
    )  # fmt: skip
    return [ticks.tolist() for ticks in streams if ticks is not None]


def _delay(place: Path, recording: Path) -> dict[str, float]:
    _run("analyse", recording, "--rig", place / "rig.toml", "--json", place / "result.json")
    return json.loads((place / "result.json").read_text())["parameters"]["trigger_delay"]


def test_timestamps_go_out_and_come_back_and_the_result_is_the_same(place, own_delay, tmp_path):
    """Oracle: the recording itself; every stream is equal, and so is the result to the last digit."""
    out = tmp_path / "again.nxs"
    said = _run("import-capture", place / "twin.vcd", "--map", MAP, "--frames", place / "twin.nxs", "--out", out)
    assert "300 of camera_trigger" in said
    assert "49152000 Hz" in said
    old, new = reader.read(place / "twin.nxs"), reader.read(out)
    assert _streams(new) == _streams(old)
    assert (new.clock_frequency_hz, new.camera_period_ticks) == (old.clock_frequency_hz, old.camera_period_ticks)
    assert _delay(place, out) == own_delay


def test_an_analyser_with_a_clock_of_its_own_gives_the_same_delay(place, own_delay, tmp_path):
    """Oracle: the result with the generator's own ticks, to the 40 ppm of the analyser's clock and two of its samples.

    And to a hundredth of u, by which the search for the opening may end elsewhere.
    """
    recording = reader.read(place / "twin.nxs")
    rows = []
    for line, ticks in enumerate(_streams(recording)[:3]):
        at = np.ceil(ticks / np.float64(recording.clock_frequency_hz) * ANALYSER_HZ * (1 + TOO_FAST))
        width = 0.3 * np.diff(at).min()
        rows += [(sample, line, 1) for sample in at] + [(np.round(sample + width), line, 0) for sample in at]
    level, table = [1, 1, 0], ["Time [s],Trigger,D1,D2", "0.0,1,1,0"]  # the first two lines rest high
    for sample, line, active in sorted(rows):
        level[line] = active if line == 2 else 1 - active
        table.append(f"{sample / ANALYSER_HZ:.9f},{level[0]},{level[1]},{level[2]}")
    (tmp_path / "digital.csv").write_text("\n".join([*table, ""]))
    out = tmp_path / "analyser.nxs"
    _run(
        "import-capture", tmp_path / "digital.csv", "--map", "camera_trigger=!Trigger,control_slot=!1,application_slot=2",
        "--clock", "24 MHz", "--frames", place / "twin.nxs", "--out", out,
    )  # fmt: skip
    found = _delay(place, out)
    apart = 2 / ANALYSER_HZ + TOO_FAST * own_delay["value"] + own_delay["standard_uncertainty"] / 100
    assert found["value"] == pytest.approx(own_delay["value"], abs=apart)
    assert found["value"] != own_delay["value"]
    assert found["standard_uncertainty"] == pytest.approx(own_delay["standard_uncertainty"], rel=0.05)


def test_timestamps_alone_are_written_as_json(place, tmp_path):
    """Oracle: the ticks of the recording."""
    _run("import-capture", place / "twin.vcd", "--map", MAP, "--json", tmp_path / "ticks.json")
    found = json.loads((tmp_path / "ticks.json").read_text())
    assert found["clock_frequency"] == {"value": 49_152_000, "unit": "Hz"}
    assert [found["ticks"][name] for name in STREAMS] == _streams(reader.read(place / "twin.nxs"))


def test_frames_from_arrays_become_a_recording(place, tmp_path):
    """Oracle: the recording from which arrays and timestamps were taken."""
    old = reader.read(place / "twin.nxs")
    assert old.nonuniformity is not None
    assert old.nonuniformity.low_frames is not None
    assert old.nonuniformity.high_frames is not None
    stacks = {"frames": old.frames, "low": old.nonuniformity.low_frames, "high": old.nonuniformity.high_frames}
    arrays = {name: stack.pick(list(range(stack.shape[0]))) for name, stack in stacks.items()}
    np.savez(tmp_path / "frames.npz", **arrays)
    _run(
        "import-capture", place / "twin.vcd", "--map", MAP, "--frames", tmp_path / "frames.npz",
        "--out", tmp_path / "made.nxs", "--camera", "photon", "--wheel-hz", 3, "--integration-time", "250 us",
        "--bit-depth", old.bit_depth,
    )  # fmt: skip
    new = reader.read(tmp_path / "made.nxs")
    assert _streams(new) == _streams(old)
    for name in ("camera_type", "readout_mode", "integration_time_s", "bit_depth"):
        assert getattr(new, name) == getattr(old, name)
    assert new.rotation_speed_hz == 3
    assert np.array_equal(new.frames.pick([0, 150, 299]), arrays["frames"][[0, 150, 299]])
    assert new.nonuniformity is not None
    assert np.array_equal(new.nonuniformity.high_dn, old.nonuniformity.high_dn)


def test_a_trigger_that_the_capture_lacks_is_told(place, tmp_path):
    """Oracle: a dump without its last trigger is refused with 300 numbered frames, and one without camera_period is odd."""
    dump = (place / "twin.vcd").read_text().splitlines(keepends=True)
    last = max(i for i, line in enumerate(dump) if line == "1!\n")
    (tmp_path / "short.vcd").write_text("".join([*dump[:last], *dump[last + 1 :]]))
    with pytest.raises(IrTimingError, match="runs from 0 to 299 for 299 triggers"):
        _run(
            "import-capture", tmp_path / "short.vcd", "--map", MAP, "--frames", place / "twin.nxs",
            "--out", tmp_path / "a.nxs",
        )  # fmt: skip
    assert not (tmp_path / "a.nxs").exists()


def test_what_is_odd_is_told(place, tmp_path):
    """Oracle: an analyser whose clock is 40 ppm off sees other intervals than the scheme's."""
    dump = (place / "twin.vcd").read_text()
    times = [
        f"#{round(int(line[1:]) * (1 + TOO_FAST))}" if line.startswith("#") else line for line in dump.splitlines()
    ]
    (tmp_path / "off.vcd").write_text("\n".join([*times, ""]))
    said = _run(
        "import-capture", tmp_path / "off.vcd", "--map", MAP, "--frames", place / "twin.nxs", "--out", tmp_path / "b.nxs"
    )  # fmt: skip
    assert (
        "warning: /entry/instrument/trigger_generator/camera_trigger has 299 intervals other than camera_period" in said
    )


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--frames", "twin.nxs"), "--frames and --out belong together"),
        (("--out", "new.nxs"), "--frames and --out belong together"),
        ((), "nothing to write"),
        (("--frames", "twin.nxs", "--out", "twin.nxs"), "is another file of this command"),
        (("--frames", "twin.nxs", "--out", "rig.toml"), "ends in .toml, but a recording is to be written there"),
        (("--json", "twin.vcd"), "is another file of this command"),
        (("--json", "ticks.json", "--clock", "fast"), "--clock 'fast' is no clock"),
        (("--json", "ticks.json", "--clock", "2000 GHz"), "is no clock; write whole hertz from 1 kHz to 1 THz"),
        (("--json", "ticks.json", "--shortest", "1 kg"), "is not a time"),
        (("--json", "ticks.json", "--camera", "photon"), "--camera and --wheel-hz belong together"),
        (("--frames", "twin.nxs", "--out", "new.nxs", "--camera", "photon", "--wheel-hz", "3"), "leave out --camera"),
        (("--frames", "rig.toml", "--out", "new.nxs"), "is not an HDF5 file"),
    ],
)
def test_options_that_cannot_be_are_refused_in_one_line(place, options, says, monkeypatch):
    """Oracle: the message for each mistake; no file is written."""
    monkeypatch.chdir(place)
    before = {path: path.stat().st_mtime_ns for path in place.iterdir()}
    with pytest.raises(IrTimingError, match=says) as refused:
        _run("import-capture", "twin.vcd", "--map", MAP, *options)
    assert "\n" not in str(refused.value)
    assert {path: path.stat().st_mtime_ns for path in place.iterdir()} == before


def test_a_dump_is_not_written_over_its_recording(place):
    """Oracle: the message, and the recording as it was."""
    with pytest.raises(IrTimingError, match="is another file of this command"):
        _run("export-vcd", place / "twin.nxs", "-o", place / "twin.nxs")
    assert reader.read(place / "twin.nxs").camera_trigger_ticks.size == 300
