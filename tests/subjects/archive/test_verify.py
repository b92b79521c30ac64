"""`archive.verify` and the command `irtiming verify`: every complaint at once, each with its cure."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from irtiming.archive.verify import verify
from irtiming.cli import verify_command
from irtiming.records.finding import Finding

CAMERA = "entry/instrument/camera"
CLOCK = "entry/instrument/trigger_generator"
REFERENCE = "entry/nonuniformity_reference"


def _set(path: str, value: object) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file[path][...] = value

    return change


def _replace(path: str, edit: Callable[[np.ndarray], object]) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        value = edit(file[path][()])
        del file[path]
        file[path] = value

    return change


def _saturate(file: h5py.File) -> None:
    file[f"{CAMERA}/data"][:, 0, :3] = 2**14 - 1


CASES = {
    "dead frame": (
        lambda file: file[f"{CAMERA}/data"].__setitem__(7, 0),
        "error",
        ["camera/data has 1 dead frame, the first is frame 7: all pixels are 0", "record again"],
    ),
    "repeated frame": (
        lambda file: file[f"{CAMERA}/data"].__setitem__(9, file[f"{CAMERA}/data"][8]),
        "error",
        ["camera/data has 1 frame equal to the one before, the first is frame 9", "missed triggers"],
    ),
    "saturated": (_saturate, "error", ["has 12.50% of its values saturated (16383)", "integration time"]),
    "more than its bits": (
        lambda file: file[f"{CAMERA}/data"].__setitem__((3, 0, 0), 20000),
        "error",
        ["reaches 20000, which does not fit into bit_depth_readout = 14 bits", "correct bit_depth_readout"],
    ),
    "lost frames": (
        lambda file: (
            _replace(f"{CAMERA}/data", lambda frames: np.delete(frames, [4, 5], axis=0))(file),
            _replace(f"{CAMERA}/frame_number", lambda numbers: np.delete(numbers, [4, 5]))(file),
        ),
        "warning",
        ["frame_number leaves out 2 of 20 triggers, the first is 4: lost frames"],
    ),
    "wrong speed": (
        _set("entry/instrument/chopper/rotation_speed", 5.0),
        "error",
        ["rotation_speed = 5 Hz, but the application slots pass at 3 turns per second", "two edges"],
    ),
    "wrong wheel period": (
        _set(f"{CLOCK}/wheel_period", 8_192_000),
        "warning",
        ["wheel_period = 8192000 ticks is 6 Hz, rotation_speed is 3 Hz"],
    ),
    "uneven triggers": (
        _replace(f"{CLOCK}/camera_trigger", lambda ticks: np.where(np.arange(20) > 11, ticks + 90, ticks)),
        "warning",
        ["has 1 interval other than camera_period = 1622016 ticks", "1622106 ticks after trigger 11"],
    ),
    "triggers outside": (
        _replace(f"{CLOCK}/control_slot", lambda ticks: ticks[:250]),
        "warning",
        [
            "camera_trigger has 4 of 20 triggers outside the ticks of",
            "control_slot",
            "stop the timestamps after the last trigger",
        ],
    ),
    "missing control slot": (
        _replace(f"{CLOCK}/control_slot", lambda ticks: np.delete(ticks, 130)),
        "warning",
        ["control_slot has 1 of 4 turns without the usual 100 slots, the first is turn 1 with 99"],
    ),
    "control slots of another clock": (
        _replace(f"{CLOCK}/control_slot", lambda ticks: ticks + 10**12),
        "error",
        ["control_slot has no ticks between the application slots", "one counter"],
    ),
    "missing application edge": (
        _replace(f"{CLOCK}/application_slot", lambda ticks: np.delete(ticks, 3)),
        "warning",
        ["application_slot has 1 missing edge, the first after entry 2"],
    ),
    "spurious application edge": (
        _replace(f"{CLOCK}/application_slot", lambda ticks: np.insert(ticks, 4, ticks[3] + 1000)),
        "warning",
        ["application_slot has 1 doubled or spurious edge, the first after entry 3"],
    ),
    "edges of another circuit": (
        _replace(f"{CLOCK}/application_edges", lambda ticks: ticks + 3),
        "warning",
        ["application_edges lacks 8 ticks of application_slot"],
    ),
    "no integration time": (
        lambda file: file.__delitem__(f"{CAMERA}/count_time"),
        "warning",
        ["count_time is absent or unreadable in a photon recording: analyse can then give the middle"],
    ),
    "no reference": (
        lambda file: file.__delitem__(REFERENCE),
        "warning",
        ["low is absent or unreadable in a photon recording", "cannot be corrected"],
    ),
    "reference without a step": (
        _replace(f"{REFERENCE}/low", lambda low: low + np.uint16(6500)),
        "warning",
        ["nonuniformity_reference rises by", "from low to high at a noise of", "clearly brighter"],
    ),
    "references exchanged": (
        _replace(f"{REFERENCE}/low", lambda low: low + np.uint16(13000)),
        "error",
        ["nonuniformity_reference has low and high exchanged: high is", "DN darker than low", "exchange the two"],
    ),
    "partial chunks": (
        lambda file: (
            file.__delitem__(f"{CAMERA}/data"),
            file.create_dataset(
                f"{CAMERA}/data",
                data=np.arange(480, dtype="u2").reshape(20, 4, 6),
                chunks=(2, 2, 6),
            ),
        ),
        "warning",
        ["has chunks of (2, 2, 6) that are not whole frames", "one frame per chunk"],
    ),
    "unknown field": (
        lambda file: file.__setitem__(f"{CAMERA}/lens", "X1"),
        "info",
        ["camera/lens is not read by irtiming"],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_fault_is_found_with_its_severity_and_cure(hand_made: Callable[..., Path], case: str) -> None:
    """Oracle: one fault made by hand in a sound file."""
    change, severity, fragments = CASES[case]
    found = verify(hand_made(change))
    fitting = [finding for finding in found if all(words in finding.sentence() for words in fragments)]
    assert [finding.severity for finding in fitting] == [severity], [f.sentence() for f in found]
    assert (found[0].severity == "ok") == (severity != "error")


def test_a_sound_file_has_a_line_that_says_what_it_holds(hand_made: Callable[..., Path]) -> None:
    """Oracle: 19 camera periods at 30.303 Hz; 9 edges are 4 turns; 20 frames are too few to analyse."""
    seen = []
    finding, few = verify(hand_made(), progress=lambda done, total: seen.append((done, total)))
    assert finding == Finding(
        code="recording-sound",
        severity="ok",
        where="",
        what="photon, snapshot: 20 frames of 4 x 6 for 20 triggers in 627 ms, 4 turns",
    )
    assert few.code == "frames-few"
    assert seen == [(20, 20)]


def test_every_complaint_comes_at_once(hand_made: Callable[..., Path]) -> None:
    """Oracle: five faults in one file, five errors."""

    def spoil(file: h5py.File) -> None:
        del file[f"{CAMERA}/type"]
        file["entry/instrument/chopper/rotation_speed"].attrs["units"] = "rpm"
        file[f"{REFERENCE}/low"].attrs["temperature"] = -5.0
        _replace(f"{CLOCK}/control_slot", lambda ticks: ticks.astype(float))(file)
        file[f"{CAMERA}/data"][3] = 5

    found = verify(hand_made(spoil))
    wrong = [finding.where for finding in found if finding.severity == "error"]
    assert sorted(wrong) == [
        "/entry/instrument/camera/data",
        "/entry/instrument/camera/type",
        "/entry/instrument/chopper/rotation_speed",
        "/entry/instrument/trigger_generator/control_slot",
        "/entry/nonuniformity_reference/low@temperature",
    ]
    assert all(finding.cure for finding in found if finding.severity == "error")


def test_damage_in_the_middle_is_told_with_its_frame(hand_made: Callable[..., Path]) -> None:
    """Oracle: frame 13's compressed bytes, overwritten in the file."""
    path = hand_made()
    with h5py.File(path) as file:
        chunk = file[f"{CAMERA}/data"].id.get_chunk_info(13)
    with path.open("r+b") as raw:
        raw.seek(chunk.byte_offset)
        raw.write(b"\xff" * chunk.size)
    finding, _ = verify(path)
    assert finding.severity == "error"
    assert "cannot be read at frame 13 of 20" in finding.what


def test_a_file_damaged_anywhere_is_never_a_traceback(hand_made: Callable[..., Path]) -> None:
    """Oracle: any run of 64 bytes overwritten gives findings, never an exception."""
    path = hand_made(text=bytes)
    content = path.read_bytes()
    rng = np.random.default_rng(12)
    for start in rng.integers(0, len(content) - 64, 40):
        path.write_bytes(content[:start] + rng.bytes(64) + content[start + 64 :])
        assert verify(path)


def test_the_command_exits_2_only_for_errors_and_writes_json(hand_made: Callable[..., Path], tmp_path: Path) -> None:
    """Oracle: a sound file, one with a warning, one with an error, one that is not there."""
    app = typer.Typer()
    app.command()(verify_command.verify)
    sound = str(hand_made(name="sound.nxs"))
    odd = str(hand_made(CASES["lost frames"][0], name="odd.nxs"))
    dead = str(hand_made(CASES["dead frame"][0], name="dead.nxs"))
    out = tmp_path / "out.json"
    good = CliRunner().invoke(app, [sound, odd, "--json", str(out)])
    assert good.exit_code == 0
    assert f"ok: {sound}: photon, snapshot: 20 frames" in good.stdout
    assert f"warning: {odd}: /entry/instrument/camera/frame_number leaves out 2" in good.stdout
    assert "sound.nxs: 20 of 20 frames" in good.stderr
    assert [(entry["file"], entry["ok"]) for entry in json.loads(out.read_text())["files"]] == [
        (sound, True),
        (odd, True),
    ]
    bad = CliRunner().invoke(app, [sound, dead, str(tmp_path / "none.nxs"), "--json", str(out)])
    assert bad.exit_code == 2
    assert f"error: {tmp_path / 'none.nxs'}: does not exist; check the name" in bad.stdout
    files = json.loads(out.read_text())["files"]
    assert [entry["ok"] for entry in files] == [True, False, False]
    assert files[1]["findings"][0]["where"] == "/entry/instrument/camera/data"


def test_the_table_keeps_brackets_in_messages(hand_made: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> None:
    """Oracle: a folder called [bold] must not become markup."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "200")
    app = typer.Typer()
    app.command()(verify_command.verify)
    shown = CliRunner().invoke(app, [str(hand_made(CASES["dead frame"][0], name="[bold].nxs"))])
    assert shown.exit_code == 2
    assert "[bold].nxs" in shown.stdout
    assert "what to do" in shown.stdout


def test_the_example_recordings_are_sound(shared_recordings: Path) -> None:
    """Oracle: they were made as good recordings."""
    for path in sorted(shared_recordings.glob("*/*.nxs")):
        assert [finding.severity for finding in verify(path)] == ["ok"]


def test_memory_does_not_grow_with_the_recording(tmp_path: Path) -> None:
    """Oracle: the kernel's high-water mark, reading and verifying 330 MB in a process of its own."""
    path = tmp_path / "long.nxs"
    program = f"""
import numpy as np
from irtiming.archive import layout, reader, verify, writer
from irtiming.records.recording import Recording

class Scene:
    shape = (500, 512, 640)
    base = np.random.default_rng(0).integers(3000, 4000, (1, 512, 640), dtype=np.uint16)
    def blocks(self):
        for n in range(500):
            yield n, self.base + np.uint16(n)
ticks = np.arange(500) * 1622016
edges = np.arange(100) * 8192000
recording = Recording(
    name="long", camera_type="microbolometer", readout_mode="rolling", frames=Scene(), frame_number=np.arange(500),
    clock_frequency_hz=49152000.0, camera_trigger_ticks=ticks, control_slot_ticks=np.arange(5000) * 163840,
    application_slot_ticks=edges, rotation_speed_hz=3.0)
writer.write(recording, {str(path)!r})
assert [f.code for f in verify.verify({str(path)!r})] == ["recording-sound", "frames-without-signal"]
assert sum(len(block) for _, block in reader.read({str(path)!r}).frames.blocks()) == 500
print([line for line in open("/proc/self/status") if "VmHWM" in line][0].split()[1])
"""
    if not Path("/proc/self/status").exists():
        pytest.skip("the high-water mark of memory is read from /proc")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) < 300_000
