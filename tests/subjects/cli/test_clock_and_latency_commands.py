"""`irtiming clock` and `irtiming latency`, as typed, with timestamps of a made-up wheel of known latencies and clock."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from irtiming.archive.rig_file import read_rig
from irtiming.archive.timestamps_file import write_timestamps
from irtiming.cli.main import app
from irtiming.errors import UnitError
from irtiming.records.timestamps import Timestamps
from irtiming.records.trigger_plan import PlannedRun, TriggerScheme
from irtiming.session.latency import GatesOrder

CLOCK_HZ = 48_000_000
E, L_A, L_C, L_P = 12e-6, 5e-6, 3e-6, 0.05e-6
RIG = """[beams]   # by caliper
half_separation_mm = 13.0
height_difference_mm = 5.5
whole_slots_between = 9

[mask]
opening_angle_deg = 75.0
centre_angle_deg = -90.0
"""


def _ticks(times_s, late_s, rng):
    return np.floor((times_s + late_s + rng.normal(0, 40e-9, times_s.size)) * CLOCK_HZ * (1 + E)).astype(np.int64)


def _timestamps(speed_hz, seed, *, spare_s, exchanged=False):
    """Twenty turns of a wheel, and what comes at the spare input."""
    rng, wheel = np.random.default_rng(seed), np.random.default_rng(1)
    slot_turns = (np.arange(100) + wheel.normal(0, 0.006, 100) - 9.07) / 100
    turns = np.arange(60)[:, None]
    slots_s = ((turns + slot_turns).ravel() + 1) / speed_hz
    edges_s = ((turns + np.array([0.0, 0.5 + 5e-5])).ravel() + 1) / speed_hz
    late_a, late_c = (L_C, L_A) if exchanged else (L_A, L_C)
    trigger = np.arange(30) * 1_584_000 + CLOCK_HZ
    none = np.empty(0, np.int64)
    return Timestamps(
        clock_frequency_hz=CLOCK_HZ, camera_trigger_ticks=trigger, camera_trigger_delayed_ticks=trigger,
        control_slot_ticks=_ticks(slots_s, late_c, rng), application_slot_ticks=_ticks(edges_s, late_a, rng),
        application_edge_ticks=none, camera_input_ticks=trigger + 7,
        spare_ticks=_ticks(spare_s(edges_s, speed_hz), L_P, rng), lost_after_ticks=none,
    )  # fmt: skip


@pytest.fixture
def place(tmp_path):
    """A folder with timestamps at 3 and 9 Hz and a rig.toml; a function writes more."""

    def write(name, speed_hz, **options):
        scheme = TriggerScheme(turn_period_ticks=round(CLOCK_HZ / speed_hz / 100) * 100, camera_period_ticks=1_584_000)
        run = PlannedRun(scheme=scheme, trigger_delay_ticks=0, repeats=1, is_after_correction=False)
        path = tmp_path / name
        write_timestamps(_timestamps(speed_hz, len(name), **options), path, run=run)
        return path

    (tmp_path / "rig.toml").write_text(RIG)
    return tmp_path, write


def _run(*words):
    done = CliRunner(env={"COLUMNS": "120"}).invoke(app, [str(word) for word in words])
    assert done.exit_code == 0, f"{done.output} {done.exception}"
    return done.output


def _pulses(edges_s, speed_hz):
    return np.arange(1.5, edges_s[-1], 1.0)


def _diode(edges_s, speed_hz):
    return edges_s + 0.1 / (2 * np.pi * speed_hz)


def test_the_clock_goes_into_rig_toml(place):
    """Oracle: 12 ppm were put in; everything else in rig.toml stays as it was."""
    folder, write = place
    one, rig = write("a.nxs", 3.0, spare_s=_pulses), folder / "rig.toml"
    said = _run("clock", one, "--rig", rig, "--json", folder / "c.json", "--picture", folder / "c.svg")
    found = read_rig(rig).clock.relative_error
    assert found.value == pytest.approx(E, abs=4 * found.standard_uncertainty)
    assert found.standard_uncertainty < 1e-8
    assert rig.read_text().startswith(RIG)
    assert "[clock]\nrelative_error = " in said
    assert json.loads((folder / "c.json").read_text())["recordings"][0]["name"] == "a"
    assert "<svg" in (folder / "c.svg").read_text()


def test_a_photodiode_puts_both_latencies_into_rig_toml(place):
    """Oracle: 5 us and 3 us were put in, the diode is 50 ns late and 0.1 rad beside the gate."""
    folder, write = place
    files = [write("a.nxs", 3.0, spare_s=_diode), write("bb.nxs", 9.0, spare_s=_diode)]
    _run("latency", "gates", *files, "--photodiode", "50 ns", "--photodiode-u", "10 ns", "--rig", folder / "rig.toml")
    found = read_rig(folder / "rig.toml").latency
    for number, truth in ((found.application_gate_s, L_A), (found.control_gate_s, L_C)):
        assert number.value == pytest.approx(truth, abs=4 * number.standard_uncertainty)
        assert number.standard_uncertainty < 0.1e-6


def test_an_uncertainty_of_nothing_is_refused():
    """Oracle: by hand; it was given for a photodiode of which nobody told a latency."""
    with pytest.raises(
        UnitError, match=r"photodiode_u_s is the standard uncertainty of photodiode_s, which is not given"
    ):
        GatesOrder(recordings=(), photodiode_u_s=1e-8)


def test_without_a_photodiode_only_the_difference_is_told(place):
    """Oracle: 5 us - 3 us; with 5 us by an oscilloscope the control gate's latency follows."""
    folder, write = place
    files = [write("a.nxs", 3.0, spare_s=_pulses), write("bb.nxs", 9.0, spare_s=_pulses)]
    said = _run("latency", "gates", *files, "--json", folder / "l.json")
    assert "no latency is known, only the difference" in said
    content = json.loads((folder / "l.json").read_text())
    (difference,) = content["differences"]
    assert content["latency"] is None
    assert difference["difference_s"]["value"] == pytest.approx(L_A - L_C, abs=0.05e-6)
    _run(
        "latency",
        "gates",
        *files,
        "--application-gate",
        "5 us",
        "--application-gate-u",
        "300 ns",
        "--rig",
        folder / "rig.toml",
    )
    found = read_rig(folder / "rig.toml").latency.control_gate_s
    assert found.value == pytest.approx(L_C, abs=0.05e-6)
    assert found.standard_uncertainty == pytest.approx(0.3e-6, rel=0.05)


def test_exchanged_gates(place):
    """Oracle: 5 us and 3 us exchanged, half of the change is their difference; u is that of the beams' place at 3 Hz."""
    folder, write = place
    usual, other = write("a.nxs", 3.0, spare_s=_pulses), write("bb.nxs", 3.0, spare_s=_pulses, exchanged=True)
    _run("latency", "gates", usual, "--exchanged", other, "--place-u-mrad", 0.02, "--json", folder / "l.json")
    (found,) = json.loads((folder / "l.json").read_text())["differences"]
    assert found["difference_s"]["value"] == pytest.approx(L_A - L_C, abs=0.1e-6)
    assert found["difference_s"]["standard_uncertainty"] == pytest.approx(20e-6 / (12 * np.pi), rel=0.05)


def test_a_trigger_led_back_in_a_recording(place):
    """Oracle: seven ticks of 48 MHz were put in; half of them, with a rectangular distribution, is the way out."""
    folder, write = place
    one = write("a.nxs", 3.0, spare_s=_pulses)
    _run("latency", "loopback", one, "--line", "camera_input", "--rig", folder / "rig.toml")
    found = read_rig(folder / "rig.toml").latency.trigger_s
    assert found.value == pytest.approx(3.5 / CLOCK_HZ, abs=1e-10)
    assert found.standard_uncertainty == pytest.approx(3.5 / CLOCK_HZ / np.sqrt(3), abs=1e-10)
