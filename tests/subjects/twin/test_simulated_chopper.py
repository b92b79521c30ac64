"""The simulated chopper controller: its dialect, its rules, and how its wheel takes up speed."""

import pytest

from irtiming.twin.devices.chopper import ChopperFaults, SimulatedChopper


def _say(device, *commands):
    """What stands on the line after each command, a tenth of a second apart."""
    said = []
    for command in commands:
        begins = device._cycle
        sent = device.exchange(command.encode(), until_cycle=begins) + device.exchange(
            b"", until_cycle=begins + 100_000
        )
        said.append(sent.decode("latin-1"))
    return said


def _started(**faults):
    device = SimulatedChopper(faults=ChopperFaults(**faults))
    device.reference_hz = 300.0
    _say(device, "ref=3\r", "output=2\r", "enable=1\r")
    return device


def test_it_speaks_as_the_manual_says():
    """Oracle: the dialect by hand: echo, answer, prompt; the errors of unknown commands and of values out of range."""
    assert _say(
        SimulatedChopper(), "id?\r", "BLADE?\r", "freq=200\r", "freq?\r", "\r", "nonsense\r", "output=3\r", "ref=x\r"
    ) == [
        "id?\rTHORLABS MC2000B Optical Chopper 1.10\r> ",
        "BLADE?\r0\r> ",
        "freq=200\r> ",
        "freq?\r200\r> ",
        "\r> ",
        "nonsense\rCommand error CMD_NOT_DEFINED\r> ",
        "output=3\rCommand error CMD_ARG_RANGE_ERR\r> ",
        "ref=x\rCommand error CMD_ARG_RANGE_ERR\r> ",
    ]


def test_what_may_change_only_at_rest_does_not_while_it_turns():
    """Oracle: the setting read back, and the rule that was broken by name."""
    device = _started()
    assert _say(device, "ref=0\r", "ref?\r", "phase=90\r", "phase?\r") == [
        "ref=0\r> ", "ref?\r3\r> ", "phase=90\r> ", "phase?\r90\r> ",
    ]  # fmt: skip
    assert device.broken_rules == ["ref while the wheel turns"]


def test_a_reply_is_lost_when_it_is_asked_too_soon():
    """Oracle: two commands at once, of which only the second is answered."""
    device = SimulatedChopper()
    assert _say(device, "blade?\rref?\r") == ["blade?ref?\r0\r> "]
    assert device.broken_rules == ["'ref?' before the prompt"]


def test_the_wheel_runs_up_in_a_line_and_locks():
    """Oracle: the straight line from 0 to 1 within 5 s; 300 Hz over 100 slots; locked? within 0.1 % of it."""
    device = SimulatedChopper()
    device.reference_hz = 300.0
    _say(device, "ref=3\r", "output=2\r")
    assert device.relative_speed == 0.0
    device.exchange(b"enable=1\r", until_cycle=200_000)
    assert [device.relative_speed_at(0.2 + time) for time in (0.0, 2.5, 5.0, 9.0)] == pytest.approx(
        [0.0, 0.5, 1.0, 1.0]
    )
    device.exchange(b"", until_cycle=2_700_000)
    assert device.rotation_hz == pytest.approx(1.5)
    assert _say(device, "locked?\r", "refoutfreq?\r", "input?\r") == [
        "locked?\r0\r> ", "refoutfreq?\r156\r> ", "input?\r300\r> ",
    ]  # fmt: skip
    device.exchange(b"", until_cycle=5_300_000)
    assert _say(device, "locked?\r", "refoutfreq?\r") == ["locked?\r1\r> ", "refoutfreq?\r300\r> "]
    assert device.rotation_hz == 3.0


def test_without_a_reference_the_wheel_stands_and_with_a_new_one_it_goes_on_as_it_was():
    """Oracle: 3 turns a second are half of the 6 that 600 Hz ask for; and none without a reference after the run-down."""
    device = _started()
    device.exchange(b"", until_cycle=10_000_000)
    device.reference_hz = 600.0
    assert device.relative_speed == pytest.approx(0.5)
    assert device.rotation_hz == pytest.approx(3.0)
    device.exchange(b"", until_cycle=12_500_000)
    assert device.rotation_hz == pytest.approx(6.0)
    device.reference_hz = 0.0
    device.exchange(b"", until_cycle=20_000_000)
    assert device.rotation_hz == 0.0


def test_lock_is_lost_and_may_be_denied():
    """Oracle: a speed 2 % off; refoutfreq? of the inner slots tells the truth, locked? only if it is to."""
    device = _started()
    device.exchange(b"", until_cycle=10_000_000)
    device.lose_lock(0.02)
    device.exchange(b"", until_cycle=11_000_000)
    assert device.relative_speed == pytest.approx(1.02)
    assert _say(device, "locked?\r", "refoutfreq?\r") == ["locked?\r0\r> ", "refoutfreq?\r306\r> "]
    device.lose_lock(0.02, admits=False)
    assert _say(device, "locked?\r") == ["locked?\r1\r> "]
    device.lose_lock(0.0)
    device.exchange(b"", until_cycle=13_000_000)
    assert device.relative_speed == 1.0


def test_the_target_output_repeats_what_was_set_and_proves_nothing():
    """Oracle: refoutfreq? of a wheel that stands, with output=target: the frequency asked for."""
    device = SimulatedChopper()
    assert _say(device, "output=0\r", "refoutfreq?\r")[1] == "refoutfreq?\r100\r> "
    assert device.rotation_hz == 0.0


def test_it_falls_silent_and_forgets_words():
    """Oracle: nothing, and the error of an unknown command."""
    assert _say(SimulatedChopper(faults=ChopperFaults(is_silent=True)), "id?\r") == [""]
    assert _say(SimulatedChopper(faults=ChopperFaults(knows_locked=False)), "locked?\r") == [
        "locked?\rCommand error CMD_NOT_DEFINED\r> "
    ]
    assert _say(SimulatedChopper(faults=ChopperFaults(lost=1.0)), "id?\r") == ["id?"]


def test_bytes_come_to_harm_at_the_rate_that_was_asked_for():
    """Oracle: the binomial law: of 30 000 bytes sent, 10 % +- 5 standard deviations differ (255 of 256 draws change one)."""
    clean, harmed = SimulatedChopper(), SimulatedChopper(seed=1, faults=ChopperFaults(garbled=0.1))
    pairs = zip(*("".join(_say(device, *["freq?\r"] * 2500)) for device in (clean, harmed)), strict=True)
    differ = [one != other for one, other in pairs]
    assert len(differ) == 30_000
    expected, sigma = 0.1 * 255 / 256 * len(differ), (0.09 * len(differ)) ** 0.5
    assert abs(sum(differ) - expected) < 5 * sigma
