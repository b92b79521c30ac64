"""`irtiming gateware identify`, `record`, `combine` and `simulate`, as typed, with a simulated device behind the port."""

import json
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from irtiming.archive import reader
from irtiming.archive.plan_file import read_plan
from irtiming.archive.verify import verify
from irtiming.cli.gateware_command import app
from irtiming.errors import ArchiveError, InstrumentError, InstrumentRefused, PlanError, UnitError
from irtiming.gateware.model_device import Loop, ModelDevice
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.gateware.register_map import Channel
from irtiming.records.trigger_plan import PlannedRun, TriggerPlan, TriggerScheme
from irtiming.session.plan_json import plan_as_json
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.scene import paper_scene

CLOCK_HZ = 48_000_000
SCHEME = TriggerScheme(turn_period_ticks=4_000_000, camera_period_ticks=1_560_000)
PLAN = TriggerPlan(
    clock_frequency_hz=CLOCK_HZ,
    schemes=(SCHEME,),
    runs=tuple(
        PlannedRun(scheme=SCHEME, trigger_delay_ticks=delay, repeats=1, is_after_correction=False)
        for delay in (0, 240_000)
    ),
)


@pytest.fixture
def run():
    """Return a function that runs `irtiming gateware` with these words."""
    return lambda *words: CliRunner(env={"COLUMNS": "200"}).invoke(app, [str(word) for word in words])


@pytest.fixture
def plan_file(tmp_path):
    """The plan as `irtiming plan --json` writes it."""
    path = tmp_path / "plan.json"
    path.write_text(json.dumps({"clock_frequency_hz": CLOCK_HZ, "plan": plan_as_json(PLAN)}))
    return path


@pytest.fixture
def port():
    """Path of a simulated device with a wheel, ten times as fast as a real one."""
    wheel = DrivenWheel(paper_scene(64, 80), clock_frequency_hz=CLOCK_HZ, seed=1)
    with PseudoTerminal(ModelDevice(wheel), speed=10) as terminal:
        yield terminal.path


def test_a_plan_is_read_as_it_was_written(plan_file):
    """Oracle: the plan that was written."""
    assert read_plan(plan_file) == PLAN


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[1]", "holds no plan"),
        ("{", r"is not valid JSON \(.*; name a file that irtiming plan --json wrote"),
        ('{"clock_frequency_hz": 1}', "'plan' is missing"),
        ('{"clock_frequency_hz": 1, "plan": {"runs": []}}', "holds 0 runs"),
        ('{"clock_frequency_hz": 1, "plan": {"runs": [{"turn_period_ticks": 1.5}]}}', "is missing"),
    ],
)
def test_a_file_without_a_plan_is_refused(tmp_path, text, says):
    """Oracle: the words."""
    (tmp_path / "plan.json").write_text(text)
    with pytest.raises(PlanError, match=says):
        read_plan(tmp_path / "plan.json")


def test_identify_shows_every_register(run, port, tmp_path):
    """Oracle: the register map at 48 MHz, by hand."""
    done = run("identify", port, "--json", tmp_path / "registers.json")
    assert done.exit_code == 0, done.output
    assert "version 1.0, clock 48000000 Hz" in done.output
    assert [line.split() for line in done.output.splitlines() if line.startswith("CHOPPER_PERIOD")] == [
        ["CHOPPER_PERIOD", "160000", "cycles"]
    ]
    assert json.loads((tmp_path / "registers.json").read_text())["registers"]["QUEUE_DEPTH"] == 512


def test_record_and_combine_make_a_recording(run, port, plan_file, tmp_path):
    """Oracle: the plan's second run: N triggers C apart, 5 ms of delay; frames as they were given; a file without complaint."""
    stamps, out = tmp_path / "stamps.nxs", tmp_path / "run.nxs"
    done = run("record", port, "--plan", plan_file, "--run", 2, "--out", stamps)
    assert done.exit_code == 0, done.output
    assert "nothing was lost" in done.output
    frames = np.random.default_rng(1).integers(1000, 9000, (SCHEME.samples_per_turn, 4, 6), dtype=np.uint16)
    np.save(tmp_path / "frames.npy", frames)
    words = ["--camera", "photon", "--integration-time", "250 us", "--bit-depth", 14]
    done = run("combine", stamps, tmp_path / "frames.npy", "--out", out, *words)
    assert done.exit_code == 0, done.output
    assert [finding.severity for finding in verify(out) if finding.severity not in ("warning", "info")] == ["ok"]
    made = reader.read(out)
    assert np.array_equal(made.frames.pick([0, 5]), frames[[0, 5]])
    assert made.camera_trigger_ticks.size == SCHEME.samples_per_turn
    assert set(np.diff(made.camera_trigger_ticks)) == {SCHEME.camera_period_ticks}
    assert made.trigger_delay_time_set_s == pytest.approx(0.005, abs=1e-12)
    assert (made.clock_frequency_hz, made.rotation_speed_hz) == (CLOCK_HZ, 12)
    assert made.lost_after_ticks.size == 0
    with h5py.File(stamps) as file:
        beside = file["entry/instrument/trigger_generator/camera_trigger_delayed"][()]
    assert np.array_equal(beside, made.camera_trigger_ticks + 240_000)


def test_a_recording_keeps_the_mark_of_a_loss(run, plan_file, tmp_path):
    """Oracle: every 2000th byte changed on its way: exit with the place and time of a loss, in the file and from verify."""
    seen = [0]

    def harm(data):
        hurt = bytearray(data)
        for at in range(len(hurt)):
            seen[0] += 1
            hurt[at] ^= 0xFF * (seen[0] % 2000 == 0)
        return bytes(hurt)

    stamps, out = tmp_path / "stamps.nxs", tmp_path / "run.nxs"
    wheel = DrivenWheel(paper_scene(64, 80), clock_frequency_hz=CLOCK_HZ, seed=1)
    with PseudoTerminal(ModelDevice(wheel), speed=10, to_computer=harm) as terminal:
        done = run("record", terminal.path, "--plan", plan_file, "--out", stamps)
    assert isinstance(done.exception, InstrumentError)
    assert "timestamps were lost at" in str(done.exception)
    with h5py.File(stamps) as file:
        assert file["entry/instrument/trigger_generator/lost_after"].size > 0
        n_triggers = file["entry/instrument/trigger_generator/camera_trigger"].size
    np.save(tmp_path / "frames.npy", np.arange(n_triggers * 6, dtype=np.uint16).reshape(-1, 2, 3))
    done = run("combine", stamps, tmp_path / "frames.npy", "--out", out, "--camera", "microbolometer")
    assert done.exit_code == 0, done.output
    assert "warning: " in done.output
    assert "timestamps were lost at" in done.output
    assert any("lost_after" in finding.where and finding.severity == "error" for finding in verify(out))
    assert reader.read(out).lost_after_ticks.size > 0


def test_what_was_captured_before_the_line_vanished_is_kept(run, plan_file, tmp_path):
    """Oracle: a port that goes when the first triggers have come: an error that names the file, and triggers in it."""
    terminals, seen = [], []

    def vanish(data):
        seen.append(data.count(b"\xc3\x03"))  # records with both trigger channels: no delay in this run
        if sum(seen) > 10:
            terminals[0]._is_unplugged.set()
        return data

    stamps = tmp_path / "stamps.nxs"
    wheel = DrivenWheel(paper_scene(64, 80), clock_frequency_hz=CLOCK_HZ, seed=1)
    with PseudoTerminal(ModelDevice(wheel), speed=10, to_computer=vanish) as terminal:
        terminals.append(terminal)
        done = run("record", terminal.path, "--plan", plan_file, "--out", stamps)
    assert isinstance(done.exception, InstrumentError)
    assert "is gone" in str(done.exception)
    assert str(stamps) in done.exception.__notes__[0]
    with h5py.File(stamps) as file:
        assert file["entry/instrument/trigger_generator/camera_trigger"].size > 0
        assert file["entry/instrument/trigger_generator/lost_after"].size == 1


@pytest.mark.parametrize(
    ("words", "error", "says"),
    [
        (["--run", 3], PlanError, "--run 3 was asked for, but .* has 2 runs"),
        (["--falling", "foo"], UnitError, "'foo' is no line; name one of chopper_output"),
        (["--glitch-filter", "1 ms"], InstrumentRefused, "FILTER = 48000 cannot be set"),
        (["--out", "/nowhere/at/all.nxs"], ArchiveError, "no folder"),
    ],
)
def test_what_cannot_be_recorded_is_told(run, port, plan_file, tmp_path, words, error, says):
    """Oracle: the words; and no file is left."""
    out = tmp_path / "stamps.nxs"
    done = run("record", port, "--plan", plan_file, "--out", out, *words)
    assert isinstance(done.exception, error), done.output
    with pytest.raises(error, match=says):
        raise done.exception
    assert not out.exists()


def test_a_plan_for_another_clock_is_told_with_what_to_type(run, port, plan_file, tmp_path):
    """Oracle: the words."""
    content = json.loads(plan_file.read_text())
    plan_file.write_text(json.dumps(content | {"clock_frequency_hz": 49_152_000}))
    done = run("record", port, "--plan", plan_file, "--out", tmp_path / "stamps.nxs")
    assert isinstance(done.exception, InstrumentRefused)
    assert "irtiming plan --clock-hz 48000000" in str(done.exception)


def test_options_of_arrays_belong_to_arrays(run, tmp_path):
    """Oracle: the words."""
    done = run("combine", "a.nxs", "b.nxs", "--out", tmp_path / "c.nxs", "--bit-depth", 14)
    assert isinstance(done.exception, ArchiveError)
    assert "go with --camera" in str(done.exception)


def test_simulate_prints_its_port_and_serves_it(run):
    """Oracle: a driver in this process finds the model's registers there; the process ends by itself."""
    words = ["gateware", "simulate", "--model", "--clock-hz", "24000000", "--duration", "3 s"]
    call = [sys.executable, "-c", "from irtiming.cli.main import run; run()", *words]
    begun = time.monotonic()
    with subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as served:
        path = served.stdout.readline().strip()
        done = run("identify", path)
        served.terminate() if done.exit_code else None
        _, notes = served.communicate(timeout=60)
    assert "clock 24000000 Hz" in done.output
    assert served.returncode == 0
    assert "integer model, clock 24000000 Hz; ends after 3 s" in notes
    assert time.monotonic() - begun > 3


@pytest.mark.parametrize("cycles", [0, 3])
def test_a_trigger_that_is_led_back_is_stamped_as_much_later_as_the_wire_takes(run, tmp_path, cycles):
    """Oracle: by hand; an input is stamped with the first clock cycle after its edge, so a wire of n cycles gives n + 1."""
    device = ModelDevice(
        DrivenWheel(paper_scene(64, 80), clock_frequency_hz=CLOCK_HZ, seed=1),
        loop=Loop(channel=Channel.SPARE, cycles=cycles),
    )
    with PseudoTerminal(device, speed=10) as terminal:
        done = run("loopback", terminal.path, "--json", tmp_path / "out.json")
    assert done.exit_code == 0, done.output
    (loop,) = json.loads((tmp_path / "out.json").read_text())["loops"]
    assert loop["counts"] == [[cycles + 1, 300]]
    assert (loop["n_triggers"], loop["n_missing"], loop["spread_s"]) == (300, 0, 0.0)
    assert f"trigger_us = {1e6 * (cycles + 1) / CLOCK_HZ / 2:.4f}" in done.output


def test_a_trigger_that_is_not_led_back_is_told(run, port):
    """Oracle: nothing is connected to the spare input of this device."""
    done = run("loopback", port)
    assert "no trigger came back at spare" in str(done.exception)
