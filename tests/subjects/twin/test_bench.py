"""The simulated rig as a whole: the wheel follows its chopper, and words reach every device."""

import json
import socket

import numpy as np
import pytest

from irtiming.errors import InstrumentError
from irtiming.gateware.register_map import Channel
from irtiming.twin import rig as twin
from irtiming.twin.devices.bench import Bench, LineFaults, Workplace
from irtiming.twin.devices.chopped_wheel import ChoppedWheel
from irtiming.twin.devices.chopper import SimulatedChopper
from irtiming.twin.devices.console import WORDS, Console, say
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.scene import paper_scene

CLOCK_HZ, SLOT = 1_000_000, 2_000  # 5 turns a second


def _loopback(worker_id: str) -> str:
    return f"127.0.9.{10 + int(worker_id.removeprefix('gw') or 0)}" if worker_id != "master" else "127.0.9.9"


@pytest.fixture(scope="module")
def bench(worker_id):
    rig = twin.draw(paper_scene(16, 20), seed=1)
    place = Workplace(camera_address=_loopback(worker_id), speed=20.0, run_up_s=1.0, settling_s=1.0)
    with Bench(rig, place=place) as served:
        yield served


@pytest.fixture(scope="module")
def console(bench):
    with Console(bench) as listening:
        yield listening.port


def _chopped():
    chopper = SimulatedChopper(run_up_s=2.0)
    wheel = DrivenWheel(paper_scene(16, 20), clock_frequency_hz=CLOCK_HZ, seed=1)
    return chopper, ChoppedWheel(wheel, chopper, clock_frequency_hz=CLOCK_HZ)


def _obey(chopper, *commands):
    for k, command in enumerate(commands):
        chopper.exchange(command.encode() + b"\r", until_cycle=100_000 * (k + 1))


def _slots(wheel, chopper, *, since_s, until_s):
    """Cycles at which slots came while wheel and controller go on together, in steps of 10 ms."""
    found = []
    for step in range(round(100 * since_s), round(100 * until_s)):
        chopper.exchange(b"", until_cycle=10_000 * (step + 1))
        changes = wheel.turn(10_000 * (step + 1), slot_period_cycles=SLOT)[Channel.CONTROL_SLOT]
        found += changes.cycle[changes.level == 1].tolist()
    return np.array(found)


def test_a_wheel_that_nobody_started_stands():
    """Oracle: no slot passes, whatever reference comes."""
    chopper, wheel = _chopped()
    _obey(chopper, "ref=3", "output=2")
    assert _slots(wheel, chopper, since_s=0.3, until_s=2.0).size == 0


def test_it_runs_up_and_then_follows_its_reference():
    """Oracle: the reference's own period, within the wander of the wheel; slower before."""
    chopper, wheel = _chopped()
    _obey(chopper, "ref=3", "output=2", "enable=1")
    slots = _slots(wheel, chopper, since_s=0.4, until_s=6.0)
    early, late = np.diff(slots[slots < 1_200_000]), np.diff(slots[slots > 4_000_000])
    assert np.median(early) > 2 * SLOT
    assert np.median(late) == pytest.approx(SLOT, rel=0.003)
    assert (slots[-1] - slots[slots > 4_000_000][0]) / late.size == pytest.approx(SLOT, rel=0.001)


def test_it_runs_beside_its_reference_when_the_lock_is_lost():
    """Oracle: the share that was asked for."""
    chopper, wheel = _chopped()
    _obey(chopper, "ref=3", "output=2", "enable=1")
    _slots(wheel, chopper, since_s=0.4, until_s=4.0)
    chopper.lose_lock(0.03)
    late = np.diff(_slots(wheel, chopper, since_s=4.0, until_s=7.0)[400:])
    assert np.median(late) == pytest.approx(SLOT / 1.03, rel=0.003)


def test_every_device_has_an_address(bench):
    """Oracle: the forms that plan.toml knows."""
    found = bench.addresses
    assert sorted(found) == ["blackbody", "camera", "chopper", "trigger_generator"]
    assert found["camera"] == f"gige:{bench.place.camera_address}"
    assert found["chopper"].startswith("mc2000b:/dev/")
    assert found["blackbody"].startswith("sr800r:tcp:127.0.0.1:")
    assert found["blackbody"].endswith("?speed=20")


def test_a_taken_address_is_told_in_one_line(bench):
    """Oracle: the address that the bench itself uses."""
    rig = twin.draw(paper_scene(16, 20), seed=1)
    with (
        pytest.raises(InstrumentError, match=bench.place.camera_address) as raised,
        Bench(rig, place=bench.place),
    ):
        pass
    assert "\n" not in str(raised.value)


def test_words_take_the_wheel_away_and_break_things(bench, console):
    """Oracle: the devices themselves."""
    assert "out of the way" in say("remove", port=console)
    assert bench.view.bare_blackbody
    assert "in their place" in say("insert", port=console)
    assert not bench.view.bare_blackbody
    assert say("fault camera.packets_lost_per_mille=2", port=console) == "camera.packets_lost_per_mille = 2.0"
    assert bench.camera.faults.packets_lost_per_mille == 2.0
    say("fault camera.triggers_missed=3, 5", port=console)
    assert bench.camera.faults.triggers_missed == frozenset({3, 5})
    say("fault chopper.is_silent=true", port=console)
    assert bench.chopper.faults.is_silent
    say("fault chopper.is_silent=false", port=console)
    assert "0.02 of its speed" in say("lose-lock 0.02", port=console)
    assert "follows" in say("lose-lock 0", port=console)
    state = json.loads(say("state", port=console))
    assert state["faults"]["camera"]["triggers_missed"] == [3, 5]
    assert state["addresses"] == bench.addresses
    bench.camera.faults.packets_lost_per_mille, bench.camera.faults.triggers_missed = 0.0, frozenset()


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ("dance", "say one of: remove; insert; fault"),
        ("fault camera.packets_lost_per_mille=nan", "packets_lost_per_mille = 'nan' cannot be; it is now"),
        ("fault camera.packets_lost_per_mille=1e999", "packets_lost_per_mille = '1e999' cannot be; it is now"),
        ("lose-lock nan", "lose-lock nan is too much"),
        ("fault camera.rust=1", "no fault 'rust'; it has packets_lost_per_mille"),
        ("fault teapot.hot=1", "devices camera, chopper, blackbody, generator"),
        ("fault chopper.is_silent=perhaps", "is now False: write one like it"),
        ("lose-lock much", "is no number"),
        ("lose-lock 3", "between -1 and 1"),
        ("remove everything", "nothing that this rig understands"),
    ],
)
def test_what_it_does_not_understand_is_told_in_one_line(console, said, words):
    """Oracle: one odd sentence each."""
    with pytest.raises(InstrumentError, match=words) as raised:
        say(said, port=console)
    assert "\n" not in str(raised.value)


def test_nobody_at_the_port_is_told():
    """Oracle: a port that was free a moment ago."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
    with pytest.raises(InstrumentError, match=f"no simulated rig listens at port {port}"):
        say("state", port=port)


def test_every_word_is_told():
    """Oracle: the words that are tried above."""
    assert [line.split()[0] for line in WORDS] == ["remove", "insert", "fault", "lose-lock", "unplug", "state"]


def test_bytes_come_to_harm_as_asked_for():
    """Oracle: shares of many bytes; none without a fault, all in silence."""
    line, data = LineFaults(seed=3), bytes(range(256)) * 40
    assert line.harmed(data) == data
    line.lost = 0.1
    assert len(line.harmed(data)) == pytest.approx(0.9 * len(data), rel=0.02)
    line.lost, line.garbled = 0.0, 0.05
    differ = sum(a != b for a, b in zip(line.harmed(data), data, strict=True))
    assert differ == pytest.approx(0.05 * len(data), rel=0.2)
    line.is_silent = True
    assert line.harmed(data) == b""
