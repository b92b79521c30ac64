"""The driver of the chopper controller: against transcripts of its dialect, and against a simulated one at a serial port."""

import asyncio

import pytest
from pymeasure.test import expected_protocol

from irtiming.errors import InstrumentError, InstrumentRefused, InstrumentSilent
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.instruments.choppers import open_chopper
from irtiming.instruments.thorlabs_mc2000b import (
    BLADES,
    MC2000B,
    MC2000BChopper,
    UnknownCommand,
    connected,
    outputs,
    references,
)
from irtiming.instruments.visa_line import Speech, TextAdapter
from irtiming.records.instrument_state import ChopperState
from irtiming.twin.devices.chopper import ChopperFaults, SimulatedChopper

SPEED = 50
PREPARED = {"ref": 3, "output": 2, "nharmonic": 1, "dharmonic": 1}


def _transcript(*pairs):
    """The controller with what is said on its line; the prompt's end is the line's, its space leads the next answer."""
    return expected_protocol(MC2000B, list(pairs), gap_s=0.0)


def _with(device, work, *, options="", speed=SPEED):
    """Result of a coroutine with the driver of a device at a serial port."""

    async def within(path):
        async with connected(f"{path}?speed={speed}{options}") as chopper:
            return await work(chopper)

    with PseudoTerminal(device, speed=speed) as terminal:
        return asyncio.run(asyncio.wait_for(within(terminal.path), 15))


async def _nothing(chopper):
    return None


def test_settings_are_read_from_behind_their_echo():
    """Oracle: a transcript by hand of the manual's dialect: echo, carriage return, answer, carriage return, prompt."""
    with _transcript(
        ("id?", "id?\rTHORLABS MC2000B 1.10\r"),
        ("blade?", " blade?\r0\r"),
        ("ref?", " ref?\r3\r"),
        ("input?", " input?\r300\r"),
        ("enable?", " enable?\r0\r"),
        ("locked?", " locked?\r1\r"),
    ) as controller:
        assert controller.identity == "THORLABS MC2000B 1.10"
        assert controller.blade == "MC1F2"
        assert controller.reference == 3
        assert controller.input_hz == 300.0
        assert controller.is_enabled is False
        assert controller.says_locked is True


def test_settings_are_set_and_their_echo_checked():
    """Oracle: a transcript by hand; nothing is answered to a setting but its echo."""
    with _transcript(
        ("blade=6", "blade=6\r"), ("ref=3", " ref=3\r"), ("nharmonic=1", " nharmonic=1\r"), ("enable=1", " enable=1\r")
    ) as controller:
        controller.blade = "MC1F10HP"
        controller.reference = 3
        controller.harmonic_multiplier = 1
        controller.is_enabled = True


@pytest.mark.parametrize(
    ("name", "value"), [("harmonic_multiplier", 16), ("harmonic_divider", 0), ("blade", "MC9"), ("output", 5)]
)
def test_what_the_manual_does_not_have_is_never_sent(name, value):
    """Oracle: a transcript without a word."""
    with _transcript() as controller, pytest.raises(ValueError, match=str(value)):
        setattr(controller, name, value)


def test_the_table_of_blades_is_the_manuals():
    """Oracle: its section 8.2 to 8.4, for a blade of each kind."""
    assert [BLADES.index(name) for name in ("MC1F2", "MC1F100", "MC1F10HP", "MC1F2P10", "MC2F5360")] == [0, 5, 6, 7, 14]
    assert references("MC1F2")[3] == "external-inner"
    assert references("MC1F60") == ("internal", "external")
    assert outputs("MC1F2P10")[2] == "inner"
    assert outputs("MC1F60") == ("target", "actual")
    assert outputs("MC2F47")[3] == "sum"


def test_lines_that_answer_nothing_are_passed_over():
    """Oracle: a transcript with a late answer and a line of status before the echo of what was asked."""
    with _transcript(("ref?", " blade?\r0\r"), (None, " motor on\r\nref?\r2\r")) as controller:
        assert controller.reference == 2


def test_a_disturbed_echo_is_asked_for_again():
    """Oracle: a transcript in which the first echo is not that of the command: its answer is not believed."""
    strange = [(None, "")] * 19
    with _transcript(("ref?", "r\xc3f?\r1\r"), *strange, ("ref?", "ref?\r3\r")) as controller:
        assert controller.reference == 3


def test_an_unknown_command_and_a_value_out_of_range_are_told():
    """Oracle: the two errors of the manual."""
    with (
        _transcript(("locked?", "locked?\rCommand error CMD_NOT_DEFINED\r")) as controller,
        pytest.raises(UnknownCommand, match=r"refuses 'locked\?' \(CMD_NOT_DEFINED\)"),
    ):
        _ = controller.says_locked
    with (
        _transcript(("output=4", "output=4\rCommand error CMD_ARG_RANGE_ERR\r")) as controller,
        pytest.raises(InstrumentRefused, match=r"refuses 'output=4' \(CMD_ARG_RANGE_ERR\)"),
    ):
        controller.output = 4


def test_opening_only_reads():
    """Oracle: all settings of a turning chopper before and after."""
    device = SimulatedChopper(blade=5)
    device.exchange(b"enable=1\r", until_cycle=1_000_000)
    before = device.settings
    state = _with(device, lambda chopper: chopper.state())
    assert device.settings == before
    assert state == ChopperState(
        model="THORLABS MC2000B Optical Chopper 1.10", blade="MC1F100", reference="internal", output="target",
        harmonic_multiplier=1, harmonic_divider=1, is_enabled=True, input_hz=0.0, says_locked=state.says_locked,
    )  # fmt: skip


def test_it_is_prepared_started_and_stopped():
    """Oracle: section 8 of the manual for the settings; the wheel at 300 Hz over 100 slots; 5 s of run-up, told by locked?."""
    device = SimulatedChopper()
    device.reference_hz = 300.0

    async def work(chopper):
        prepared = await chopper.prepare()
        assert PREPARED.items() <= device.settings.items()
        await chopper.start()
        await chopper.start()
        early = await chopper.state()
        while not (await chopper.state()).says_locked:
            pass
        turning = device.rotation_hz
        await chopper.prepare()
        await chopper.stop()
        return prepared, early, turning

    prepared, early, turning = _with(device, work, speed=8)
    assert (prepared.reference, prepared.output, prepared.is_enabled) == ("external-inner", "inner", False)
    assert prepared.input_hz == 300.0
    assert early.is_enabled
    assert early.says_locked is False
    assert turning == 3.0
    assert not device.is_enabled
    assert device.broken_rules == []


def test_another_blade_is_refused_and_nothing_moves():
    """Oracle: the words, and the settings as they were; the blade that is there may be named."""
    device = SimulatedChopper(blade=6)
    before = device.settings
    with pytest.raises(InstrumentRefused, match=r"is set to blade MC1F10HP, the measurement needs MC1F2.*blade=6"):
        _with(device, lambda chopper: chopper.prepare())
    assert device.settings == before
    assert _with(device, lambda chopper: chopper.prepare(), options="&blade=6").blade == "MC1F10HP"
    with pytest.raises(InstrumentError, match="blade=99 is no blade"):
        _with(device, _nothing, options="&blade=99")


def test_a_turning_wheel_is_not_altered():
    """Oracle: the words, the settings as they were, and no command that the manual forbids."""
    device = SimulatedChopper()
    device.exchange(b"enable=1\r", until_cycle=1_000_000)
    before = device.settings
    with pytest.raises(InstrumentRefused, match="turns, but reference is internal-outer and must be external-inner"):
        _with(device, lambda chopper: chopper.prepare())
    assert device.settings == before
    assert device.broken_rules == []


def test_a_firmware_without_a_word_on_the_lock():
    """Oracle: None, which is what the record holds for a controller that does not say."""
    device = SimulatedChopper(faults=ChopperFaults(knows_locked=False))

    async def work(chopper):
        return [(await chopper.state()).says_locked for _ in range(2)]

    assert _with(device, work) == [None, None]


def test_another_device_of_the_same_dialect_is_refused():
    """Oracle: the words; the settings as they were."""
    device = SimulatedChopper(identity="THORLABS FW102C 1.06")
    with pytest.raises(InstrumentRefused, match="is 'THORLABS FW102C 1.06', no THORLABS MC2000B"):
        _with(device, lambda chopper: chopper.start())
    assert not device.is_enabled


class _Talker:
    """Says the same to whatever it hears."""

    clock_frequency_hz = 1_000_000

    def __init__(self, answer):
        self.answer, self.heard = answer, b""

    def exchange(self, received, *, until_cycle):
        self.heard += received
        return self.answer if received else b""


@pytest.mark.parametrize("answer", [b"InvalidCommand\r", b"\xaa\x01>ERROR> "])
def test_another_device_is_told_by_its_answer_and_only_asked(answer):
    """Oracle: the words; and the one question is all that was sent."""
    device = _Talker(answer)
    with pytest.raises(InstrumentError, match="which no MC2000B does: another device is at this port"):
        _with(device, lambda chopper: chopper.start())
    assert device.heard == b"id?\r" * 3


def test_silence_is_told():
    """Oracle: the words, and three times the one question."""
    device = _Talker(b"")
    with pytest.raises(InstrumentSilent, match=r"does not answer 'id\?'; see that it is on"):
        _with(device, _nothing)
    assert device.heard == b"id?\r" * 3


def test_a_setting_that_does_not_hold_is_told():
    """Oracle: a controller whose reference stays as it is, which only reading it back reveals."""
    device = SimulatedChopper()
    real = device._set
    device._set = lambda word, number: "" if word == "ref" else real(word, number)
    with pytest.raises(InstrumentRefused, match="was set to reference = 3, but holds 0"):
        _with(device, lambda chopper: chopper.prepare())


def test_lost_replies_are_asked_for_again():
    """Oracle: the settings, with every tenth reply lost."""
    device = SimulatedChopper(seed=3, faults=ChopperFaults(lost=0.1))
    with _in_memory(device) as controller:
        MC2000BChopper(controller)._prepare()
    assert PREPARED.items() <= device.settings.items()


def test_a_number_that_came_to_harm_shows_when_it_is_read_again():
    """Oracle: the words, where the reference reads as prepared once, and is not."""
    device = SimulatedChopper()
    real, lies = device._answer, iter(["3", "2", "1", "1"])
    device._answer = lambda command: next(lies, real(command)) if command in ("ref?", "output?") else real(command)
    with (
        _in_memory(device) as controller,
        pytest.raises(InstrumentError, match="check its cable, and leave its knobs alone"),
    ):
        MC2000BChopper(controller)._prepare()


@pytest.mark.parametrize("block", range(4))
def test_over_a_disturbed_line_it_is_prepared_or_refused(block):
    """Oracle: the settings that the device truly has, over 100 lines of which up to 3 % of the bytes come to harm."""
    prepared = 0
    for seed in range(25 * block, 25 * block + 25):
        device = SimulatedChopper(seed=seed, faults=ChopperFaults(garbled=0.03 * (seed % 5 + 1) / 5))
        try:
            with _in_memory(device) as controller:
                state = MC2000BChopper(controller)._prepare()
        except InstrumentError:
            continue
        prepared += 1
        assert PREPARED.items() <= device.settings.items()
        assert (state.blade, state.reference, state.output) == ("MC1F2", "external-inner", "inner")
        assert not device.is_enabled
    assert prepared >= 5


class _Memory:
    """A device right behind the driver, whose time goes on with every look."""

    def __init__(self, device):
        self.device, self.cycle, self.sent = device, 0, b""

    def send(self, data):
        self.sent += self.device.exchange(data, until_cycle=self.cycle)

    def receive(self, timeout_s):
        self.cycle += 50_000
        found, self.sent = self.sent + self.device.exchange(b"", until_cycle=self.cycle), b""
        return found

    def close(self):
        pass


def _in_memory(device):
    speech = Speech(baud=1, ends=">", reply_s=0.005)
    return MC2000B(TextAdapter(_Memory(device), speech, line="memory"), gap_s=0.0)


def test_it_is_found_by_its_address():
    """Oracle: the state through the table of drivers."""

    async def work(path):
        async with open_chopper(f"mc2000b:{path}?speed={SPEED}") as chopper:
            return (await chopper.state()).blade

    with PseudoTerminal(SimulatedChopper(), speed=SPEED) as terminal:
        assert asyncio.run(work(terminal.path)) == "MC1F2"
