"""The driver against the model of the device, over a line in memory: what it sets, what it refuses, what it gives."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import InstrumentError, InstrumentRefused, InstrumentSilent
from irtiming.gateware.messages import Operation, pack_reply, unpack_command
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.register_map import ADDRESS, Channel, Command, Polarity, Status
from irtiming.instruments.generator.register_link import Patience
from irtiming.instruments.generator.trigger_generator import SerialTriggerGenerator, Wiring
from irtiming.records.trigger_plan import TriggerScheme

CLOCK_HZ = 48_000_000
QUICK = Patience(reply_s=0.05, tries=3, poll_s=0.001)


def _with_generator(line, work, *, wiring=None, patience=QUICK):
    """What ``work`` gives of an identified driver on this line."""

    async def session():
        generator = SerialTriggerGenerator(line, wiring=wiring, patience=patience)
        try:
            await generator.identify()
            return await work(generator)
        finally:
            await generator.close()

    return asyncio.run(asyncio.wait_for(session(), timeout=20))


async def _measured(generator, run):
    await generator.load(run, clock_frequency_hz=CLOCK_HZ)
    await generator.arm()
    begun = await generator.counter_ticks()
    while await generator.counter_ticks() < begun + 1_000_000:
        await asyncio.sleep(0)
    await generator.start()
    while not await generator.has_finished():
        await asyncio.sleep(0)
    return await generator.stop()


def test_a_run_gives_every_edge_of_the_wheel_and_every_trigger(memory_line, steady_wheel, short_run):
    """Oracle: the wheel's edges in closed form, and C, D and N of the plan, all with ``==``."""
    line = memory_line(ModelDevice(steady_wheel()))
    found = _with_generator(line, lambda generator: _measured(generator, short_run))
    assert found.is_whole
    assert found.camera_trigger_ticks.size == 16
    assert set(np.diff(found.camera_trigger_ticks)) == {510_000}
    assert np.array_equal(found.camera_trigger_delayed_ticks, found.camera_trigger_ticks + 867_001)
    k = np.arange(found.control_slot_ticks[0] // 48_000, found.control_slot_ticks[-1] // 48_000 + 1)
    assert np.array_equal(found.control_slot_ticks, k * 48_000 + k * 7919 % 97 + 1)
    q = np.arange(found.application_edge_ticks[0] // 120_000, found.application_edge_ticks[-1] // 120_000 + 1)
    edges = q * 120_000 + q * 104729 % 89 + 1
    assert np.array_equal(found.application_edge_ticks, edges)
    assert np.array_equal(found.application_slot_ticks, edges[q % 2 == 0])
    assert found.control_slot_ticks[0] < found.camera_trigger_ticks[0] - 900_000
    assert found.control_slot_ticks[-1] > found.camera_trigger_delayed_ticks[-1] - 48_000
    assert found.camera_input_ticks.size == found.spare_ticks.size == 0


def test_what_the_rig_is_wired_like_is_set(memory_line, steady_wheel, short_run):
    """Oracle: the register map, by hand: half of the chopper's period, 10 us of 48 MHz, the polarity bits, the channels."""
    wiring = Wiring(
        falling_edges=Polarity.CONTROL_SLOT | Polarity.CAMERA_OUTPUT, filter_cycles=48, camera_pulse_s=10e-6,
        also_recorded=Channel.CAMERA_INPUT,
    )  # fmt: skip

    async def work(generator):
        await generator.load(short_run, clock_frequency_hz=CLOCK_HZ)
        return {name: await generator.register(name) for name in ADDRESS if ADDRESS[name] >= 0x20}

    assert _with_generator(memory_line(ModelDevice()), work, wiring=wiring) == {
        "CHOPPER_WIDTH": 24_000, "CHOPPER_PERIOD": 48_000, "CAMERA_WIDTH": 480, "CAMERA_PERIOD": 510_000, "CAMERA_COUNT": 16,
        "CAMERA_DELAY": 867_001, "POLARITY": 0b1010, "CHANNELS": 0b111111, "FILTER": 48,
    }  # fmt: skip


def test_falling_edges_and_filter_come_off_as_they_went_on(memory_line, steady_wheel, short_run):
    """Oracle: the wheel's falling control edges in closed form, half a period after the rising ones."""
    wiring = Wiring(falling_edges=Polarity.CONTROL_SLOT, filter_cycles=200)
    line = memory_line(ModelDevice(steady_wheel()))
    found = _with_generator(line, lambda generator: _measured(generator, short_run), wiring=wiring)
    k = (found.control_slot_ticks - 24_000) // 48_000
    assert np.array_equal(found.control_slot_ticks, k * 48_000 + k * 7919 % 97 + 24_000 + 1)
    assert np.array_equal(np.diff(k), np.ones(k.size - 1))


def test_timestamps_arrive_while_the_run_goes_on(memory_line, steady_wheel, short_run):
    """Oracle: the timestamps at the end; those that were streamed are the same, latencies included."""

    async def work(generator):
        early = []

        async def watch():
            seen = []
            async for stamp in generator.stamps():
                seen += [stamp]
                if not early:
                    early.append(not await generator.has_finished())
            return seen

        await generator.load(short_run, clock_frequency_hz=CLOCK_HZ)
        await generator.arm()
        watching = asyncio.create_task(watch())
        await generator.start()
        while not await generator.has_finished():
            await asyncio.sleep(0)
        assert early == [True]
        whole = await generator.stop()
        return await watching, whole

    seen, whole = _with_generator(memory_line(ModelDevice(steady_wheel())), work)
    nominal = [stamp.ticks + 1 for stamp in seen if stamp.channels & Channel.CAMERA_TRIGGER]
    slots = [stamp.ticks - 2 for stamp in seen if stamp.channels & Channel.CONTROL_SLOT]
    assert nominal == whole.camera_trigger_ticks.tolist()
    assert slots == whole.control_slot_ticks.tolist()


def test_two_runs_one_after_the_other_do_not_mix(memory_line, steady_wheel, short_run):
    """Oracle: the second run's own number of triggers, after the first one's last."""

    async def work(generator):
        return await _measured(generator, short_run), await _measured(generator, replace(short_run, repeats=2))

    first, second = _with_generator(memory_line(ModelDevice(steady_wheel())), work)
    assert first.is_whole
    assert second.is_whole
    assert (first.camera_trigger_ticks.size, second.camera_trigger_ticks.size) == (16, 32)
    assert second.control_slot_ticks[0] > first.control_slot_ticks[-1]


def test_a_device_that_was_left_measuring_is_taken_over(memory_line, steady_wheel, short_run):
    """Oracle: a run as if nothing had been; the earlier program's train and records are gone."""
    line = memory_line(ModelDevice(steady_wheel()))

    async def leave(generator):
        await generator.load(replace(short_run, repeats=100), clock_frequency_hz=CLOCK_HZ)
        await generator.arm()
        await generator.start()
        generator._is_recording = False  # as if the program had been killed: close sends no STOP

    _with_generator(line, leave)
    found = _with_generator(line, lambda generator: _measured(generator, short_run))
    assert found.is_whole
    assert found.camera_trigger_ticks.size == 16


@pytest.mark.parametrize(
    ("registers", "says"),
    [
        ({"IDENTITY": 0x12345678}, "register 0 holds 0x12345678, not 0x49525447 (IRTG): it is no trigger generator"),
        (
            {"VERSION": 2 << 16},
            "has version 2.0 of the registers, this program needs 1.0 or a later 1.x; update irtiming",
        ),
        ({"VERSION": 7}, "has version 0.7 of the registers, this program needs 1.0 or a later 1.x; update the device"),
    ],
)
def test_another_device_is_refused(memory_line, registers, says):
    """Oracle: the rule of the register map: the same first number, at least the same second one."""
    with pytest.raises(InstrumentRefused, match="memory") as error:
        _with_generator(memory_line(ModelDevice(registers=registers)), lambda generator: generator.counter_ticks())
    assert says in str(error.value)


def test_a_later_second_number_of_the_version_will_do(memory_line):
    """Oracle: the same rule."""

    async def work(generator):
        return generator.identity

    identity = _with_generator(memory_line(ModelDevice(registers={"VERSION": 1 << 16 | 9})), work)
    assert identity.version == (1, 9)
    assert (identity.clock_frequency_hz, identity.queue_depth) == (CLOCK_HZ, 512)


def test_a_plan_for_another_clock_is_refused_with_the_clock_that_would_do(memory_line, short_run):
    """Oracle: the promise; both clocks and what to type."""
    with pytest.raises(InstrumentRefused) as error:
        _with_generator(memory_line(ModelDevice()), lambda g: g.load(short_run, clock_frequency_hz=49_152_000))
    assert "for a clock of 49152000 Hz" in str(error.value)
    assert "irtiming plan --clock-hz 48000000" in str(error.value)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"trigger_delay_ticks": 2**32}, "CAMERA_DELAY = 4294967296 cannot be set; it must lie between 0 and 4294967295 cycles"),
        ({"repeats": 2**29}, "CAMERA_COUNT = 8589934592 cannot be set"),
        ({"scheme": TriggerScheme(turn_period_ticks=10, camera_period_ticks=7, control_slots=10)}, "CHOPPER_PERIOD = 1 cannot"),
    ],
)  # fmt: skip
def test_a_run_that_does_not_fit_the_registers_is_refused(memory_line, short_run, change, says):
    """Oracle: 32 bits, and the lowest value in the register map."""
    with pytest.raises(InstrumentRefused) as error:
        _with_generator(
            memory_line(ModelDevice()), lambda g: g.load(replace(short_run, **change), clock_frequency_hz=CLOCK_HZ)
        )
    assert says in str(error.value)


class _Between:
    """A device that answers some commands otherwise than it should."""

    def __init__(self, device, answer):
        self.device, self.answer = device, answer
        self.clock_frequency_hz = device.clock_frequency_hz

    def exchange(self, received, *, until_cycle):
        command = unpack_command(received)
        reply = None if command is None else self.answer(command, self.device)
        return self.device.exchange(received if reply is None else b"", until_cycle=until_cycle) + (reply or b"")


def _answering(command, value, refusal=0):
    from irtiming.gateware.messages import ReplyMessage

    return pack_reply(ReplyMessage(refusal=refusal, tag=command.tag, address=command.address, value=value))


def test_a_register_that_keeps_another_value_is_found_when_written(memory_line, short_run):
    """Oracle: by hand; the reply to the write holds what the register holds."""

    def answer(command, _):
        wrong = command.address == ADDRESS["CAMERA_PERIOD"] and command.operation == Operation.WRITE
        return _answering(command, 5) if wrong else None

    with pytest.raises(InstrumentRefused, match="holds CAMERA_PERIOD = 5 after 510000 was written"):
        _with_generator(
            memory_line(_Between(ModelDevice(), answer)), lambda g: g.load(short_run, clock_frequency_hz=CLOCK_HZ)
        )


def test_a_register_that_changed_since_is_found_before_arming(memory_line, short_run):
    """Oracle: a device that was switched off between load and arm holds what it holds at reset."""
    device = ModelDevice()

    async def work(generator):
        await generator.load(short_run, clock_frequency_hz=CLOCK_HZ)
        generator._link._line.device = ModelDevice()
        await generator.arm()

    with pytest.raises(
        InstrumentRefused, match="holds CHOPPER_WIDTH = 80000, but 24000 was loaded; was it switched off"
    ):
        _with_generator(memory_line(device), work)


def test_a_device_that_was_reset_during_the_run_is_noticed(memory_line, steady_wheel, short_run):
    """Oracle: the status of a fresh device; what was captured is kept, and its end counts as lost."""

    async def work(generator):
        await generator.load(short_run, clock_frequency_hz=CLOCK_HZ)
        await generator.arm()
        await generator.start()
        while not generator.captured().camera_trigger_ticks.size:
            await generator.counter_ticks()
        generator._link._line.device = ModelDevice()
        with pytest.raises(InstrumentRefused, match=r"stopped recording by itself .* it was reset"):
            await generator.has_finished()
        return generator.captured()

    kept = _with_generator(memory_line(ModelDevice(steady_wheel()), step_cycles=20_000), work)
    assert kept.camera_trigger_ticks.size > 0
    assert not kept.is_whole


def test_what_is_out_of_order_is_refused(memory_line, short_run):
    """Oracle: load, arm, start, stop, in this order."""

    async def work(generator):
        with pytest.raises(InstrumentRefused, match="nothing was loaded"):
            await generator.arm()
        with pytest.raises(InstrumentRefused, match=r"refuses to start \(not_armed\)"):
            await generator.start()
        with pytest.raises(InstrumentRefused, match="was not armed"):
            await generator.stop()
        await generator.load(short_run, clock_frequency_hz=CLOCK_HZ)
        await generator.arm()
        with pytest.raises(InstrumentRefused, match="CAMERA_COUNT = 3: it is measuring; stop it first"):
            await generator._link.write("CAMERA_COUNT", 3)

    _with_generator(memory_line(ModelDevice()), work)


@pytest.mark.parametrize("command", list(Command))
@pytest.mark.parametrize("is_lost", ["command", "reply"])
def test_a_command_whose_reply_is_lost_is_done_once(memory_line, steady_wheel, short_run, command, is_lost):
    """Oracle: a whole run, whether ARM, START or STOP itself or its reply was lost on the line."""
    lost = []

    def answer(asked, device):
        if asked.address != ADDRESS["COMMAND"] or asked.value != command or lost:
            return None
        lost.append(asked)
        if is_lost == "reply":
            device._answer(asked)
            device._out.clear()
        return b""

    class _Losing(_Between):
        def exchange(self, received, *, until_cycle):
            asked = unpack_command(received)
            swallowed = asked is not None and self.answer(asked, self.device) == b""
            return self.device.exchange(b"" if swallowed else received, until_cycle=until_cycle)

    line = memory_line(_Losing(ModelDevice(steady_wheel()), answer))
    found = _with_generator(line, lambda generator: _measured(generator, short_run))
    assert len(lost) == 1
    assert found.is_whole
    assert found.camera_trigger_ticks.size == 16


def test_triggers_that_are_not_those_of_the_plan_are_a_defect(memory_line, steady_wheel, short_run):
    """Oracle: a device that makes them 1 cycle too far apart, and tells 510 000 when asked."""
    device = ModelDevice(steady_wheel())

    def answer(command, device):
        if command.address == ADDRESS["CAMERA_PERIOD"]:
            if command.operation == Operation.WRITE:
                device._write(_register("CAMERA_PERIOD"), 510_001)
            return _answering(command, 510_000)
        return None

    def _register(name):
        from irtiming.gateware.register_map import REGISTERS

        return next(register for register in REGISTERS if register.name == name)

    with pytest.raises(InstrumentError, match="it is defective"):
        _with_generator(memory_line(_Between(device, answer)), lambda generator: _measured(generator, short_run))


def test_a_full_queue_is_a_loss_with_its_time(memory_line, steady_wheel, short_run):
    """Oracle: a wheel of 24 000 slots a second makes twice the records that 1 Mbaud carries; the queue of 512 fills."""
    scheme = TriggerScheme(turn_period_ticks=2000 * 100, camera_period_ticks=300_000, control_slots=100)
    run = replace(short_run, scheme=scheme, repeats=4)
    line = memory_line(ModelDevice(steady_wheel(slot_period=2000, slots=100)))
    found = _with_generator(line, lambda generator: _measured(generator, run))
    assert not found.is_whole
    held = np.flatnonzero(np.diff(found.control_slot_ticks) > 2 * 2000)
    assert held.size > 0
    assert np.all(np.isin(found.control_slot_ticks[held] + 2, found.lost_after_ticks))


def test_silence_is_told_and_bounded(memory_line):
    """Oracle: 3 tries of 0.05 s, by the clock; and the words."""
    line = memory_line(ModelDevice(), to_computer=lambda data: b"")
    with pytest.raises(InstrumentSilent, match=r"3 times to read IDENTITY got no reply within 0.05 s; check"):
        _with_generator(line, lambda generator: generator.counter_ticks())
    assert not line.is_open


def test_noise_is_told(memory_line):
    """Oracle: every byte from the device replaced by another one."""
    line = memory_line(ModelDevice(), to_computer=lambda data: bytes(byte ^ 0x11 for byte in data))
    with pytest.raises(InstrumentSilent, match="bytes came that are no message, which suggests noise"):
        _with_generator(line, lambda generator: generator.counter_ticks())


def test_a_device_that_does_not_come_to_rest_is_told(memory_line, short_run):
    """Oracle: a status that stays ARMED for two seconds of the device's own time."""

    def answer(command, _):
        return _answering(command, int(Status.ARMED)) if command.address == ADDRESS["STATUS"] else None

    with pytest.raises(InstrumentRefused, match="does not come to rest"):
        _with_generator(
            memory_line(_Between(ModelDevice(), answer), step_cycles=10**7),
            lambda g: g.load(short_run, clock_frequency_hz=CLOCK_HZ),
        )
