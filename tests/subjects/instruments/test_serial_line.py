"""The driver at a real serial port, which is a pseudo-terminal here: everything that can happen to a cable."""

import asyncio
import subprocess
import sys
import time
from collections import deque

import numpy as np
import pytest

from irtiming.acquire.trigger_train import measure
from irtiming.errors import InstrumentError, InstrumentRefused, InstrumentSilent
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.instruments import serial_line
from irtiming.instruments.generator.register_link import Patience
from irtiming.instruments.generator.trigger_generator import connected
from irtiming.instruments.serial_line import open_line

CLOCK_HZ = 48_000_000
TELL_EXCLUSIVE = 0x80045440  # TIOCGEXCL of Linux, which Python does not name
QUICK = Patience(reply_s=0.1, tries=6, poll_s=0.01)


def _within(seconds, work):
    """Result of a coroutine that must end in time."""
    return asyncio.run(asyncio.wait_for(work, timeout=seconds))


async def _identity(path, patience=QUICK):
    async with connected(path, patience=patience) as generator:
        return generator.identity


def test_a_planned_run_through_a_serial_port(steady_wheel, short_run):
    """Oracle: the wheel in closed form; two turns around the triggers, and progress that ends at all of them."""
    told = []

    async def work(path):
        async with connected(path, patience=QUICK) as generator:
            return await measure(
                generator, short_run, clock_frequency_hz=CLOCK_HZ, poll_s=0.01, progress=lambda *done: told.append(done)
            )

    with PseudoTerminal(ModelDevice(steady_wheel()), speed=1.0) as terminal:
        found = _within(20, work(terminal.path))
    assert found.is_whole
    k = np.arange(found.control_slot_ticks[0] // 48_000, found.control_slot_ticks[-1] // 48_000 + 1)
    assert np.array_equal(found.control_slot_ticks, k * 48_000 + k * 7919 % 97 + 1)
    assert found.camera_trigger_ticks[0] - found.control_slot_ticks[0] > 2 * 480_000 - 48_000
    assert found.control_slot_ticks[-1] - found.camera_trigger_delayed_ticks[-1] > 2 * 480_000 - 48_000
    assert told[-1] == (16, 16)


def test_slow_replies_are_waited_for():
    """Oracle: the same identity as without the 0.05 s by which every byte is late."""
    late = deque()

    def slow(data):
        if data:
            late.append((time.monotonic() + 0.05, data))
        return late.popleft()[1] if late and late[0][0] <= time.monotonic() else b""

    with PseudoTerminal(ModelDevice(), to_computer=slow) as terminal:
        assert _within(10, _identity(terminal.path)).clock_frequency_hz == CLOCK_HZ


def test_replies_that_are_later_than_one_try_still_count():
    """Oracle: a reply 0.15 s late to tries of 0.1 s is that to the first of them."""
    late = deque()

    def slow(data):
        if data:
            late.append((time.monotonic() + 0.15, data))
        return late.popleft()[1] if late and late[0][0] <= time.monotonic() else b""

    with PseudoTerminal(ModelDevice(), to_computer=slow) as terminal:
        assert _within(10, _identity(terminal.path)).version == (1, 0)


def test_a_port_that_is_not_there_is_told_with_those_that_are(tmp_path):
    """Oracle: the words."""
    with pytest.raises(InstrumentError, match=r"ttyNOWHERE cannot be opened .*serial ports of this computer: "):
        _within(5, _identity(str(tmp_path / "ttyNOWHERE")))


def test_a_file_is_no_port(tmp_path):
    """Oracle: the words."""
    (tmp_path / "file").write_text("")
    with pytest.raises(InstrumentError, match="file cannot be opened"):
        _within(5, _identity(str(tmp_path / "file")))


def test_a_port_that_another_program_has_is_told():
    """Oracle: a second process that holds the port by the lock that all who use pyserial's exclusive mode take."""
    hold = "import serial, sys; port = serial.Serial(sys.argv[1], exclusive=True); print('has it', flush=True); sys.stdin.read()"
    with PseudoTerminal(ModelDevice()) as terminal:
        with subprocess.Popen(
            [sys.executable, "-c", hold, terminal.path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as other:
            assert other.stdout.readline().strip() == "has it"
            with pytest.raises(InstrumentError, match=r"is used by another program; end that program"):
                _within(5, _identity(terminal.path))
            other.communicate()
        assert _within(10, _identity(terminal.path)).queue_depth == 512


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for the flag")
@pytest.mark.parametrize(("simulated", "flags"), [("/dev/other", (1, 0)), ("/dev/pts/", (0, 0))])
def test_the_driver_keeps_others_out_and_lets_them_in_again(monkeypatch, simulated, flags):
    """Oracle: the flag that makes the system itself refuse a second program, read back; a simulated device's port has none."""
    from fcntl import ioctl
    from struct import unpack

    async def work(terminal):
        line = await open_line(terminal.path)
        is_alone = unpack("i", ioctl(terminal._theirs, TELL_EXCLUSIVE, bytes(4)))[0]
        with pytest.raises(InstrumentError, match="is used by another program"):
            await open_line(terminal.path)
        await line.close()
        await line.close()
        return is_alone, unpack("i", ioctl(terminal._theirs, TELL_EXCLUSIVE, bytes(4)))[0]

    with PseudoTerminal(ModelDevice()) as terminal:
        monkeypatch.setattr(serial_line, "_OF_SIMULATIONS", simulated)
        assert _within(5, work(terminal)) == flags


def test_another_version_is_told():
    """Oracle: the words; and the port is free again."""
    with PseudoTerminal(ModelDevice(registers={"VERSION": 3 << 16})) as terminal:
        for _ in range(2):
            with pytest.raises(InstrumentRefused, match=r"has version 3.0 of the registers.*update irtiming"):
                _within(10, _identity(terminal.path))


def test_a_port_without_a_device_is_told():
    """Oracle: the words, and one question six times, each with its own number."""
    heard = bytearray()

    def swallow(data):
        heard.extend(data)
        return b""

    with (
        PseudoTerminal(ModelDevice(), to_device=swallow) as terminal,
        pytest.raises(InstrumentSilent, match="does not answer: 6 times to read"),
    ):
        _within(10, _identity(terminal.path))
    size = len(heard) // 6
    questions = [bytes(heard[k : k + size]) for k in range(0, len(heard), size)]
    assert len({(one[:2], one[3:-2]) for one in questions}) == 1  # but for its number and its check
    assert len({one[2] for one in questions}) == len(questions) == 6


@pytest.mark.parametrize("end", ["unplugged", "silent"])
def test_a_line_that_fails_during_a_run_is_told_and_what_came_is_kept(steady_wheel, short_run, end):
    """Oracle: timestamps up to the failure that are the wheel's, marked as lossy; the words; and no waiting for ever."""
    is_silent = []
    run = type(short_run)(scheme=short_run.scheme, trigger_delay_ticks=0, repeats=50, is_after_correction=True)

    async def work(terminal):
        async with connected(terminal.path, patience=QUICK) as generator:
            await generator.load(run, clock_frequency_hz=CLOCK_HZ)
            await generator.arm()
            await generator.start()
            async for stamp in generator.stamps():
                if stamp.ticks > 20_000_000:
                    break
            if end == "unplugged":
                terminal.unplug()
            else:
                is_silent.append(True)
            error = None
            while error is None:
                try:
                    await generator.has_finished()
                except InstrumentError as failure:
                    error = failure
            with pytest.raises(InstrumentSilent):
                await generator.stop()
            return error, generator.captured()

    device = ModelDevice(steady_wheel())
    with PseudoTerminal(device, to_computer=lambda data: b"" if is_silent else data) as terminal:
        error, kept = _within(20, work(terminal))
    assert isinstance(error, InstrumentSilent)
    says = "is gone" if end == "unplugged" else "6 times to read STATUS got no reply"
    assert says in str(error)
    assert kept.lost_after_ticks.size == 1
    assert kept.lost_after_ticks[0] > 20_000_000
    k = kept.control_slot_ticks // 48_000
    assert np.array_equal(kept.control_slot_ticks, k * 48_000 + k * 7919 % 97 + 1)


def test_whoever_waits_for_timestamps_is_told_that_the_line_is_gone(steady_wheel, short_run):
    """Oracle: the words, instead of waiting for ever."""

    async def work(terminal):
        async with connected(terminal.path, patience=QUICK) as generator:
            await generator.load(short_run, clock_frequency_hz=CLOCK_HZ)
            await generator.arm()
            terminal.unplug()
            async for _ in generator.stamps():
                pass

    with PseudoTerminal(ModelDevice(steady_wheel())) as terminal, pytest.raises(InstrumentSilent, match="is gone"):
        _within(10, work(terminal))


def test_a_device_that_was_unplugged_is_used_again_when_it_is_back(steady_wheel, short_run):
    """Oracle: a whole run from the device that was left measuring when its line vanished."""
    device = ModelDevice(steady_wheel())

    async def vanish(terminal):
        async with connected(terminal.path, patience=QUICK) as generator:
            await generator.load(short_run, clock_frequency_hz=CLOCK_HZ)
            await generator.arm()
            await generator.start()
            terminal.unplug()

    async def again(path):
        async with connected(path, patience=QUICK) as generator:
            return await measure(generator, short_run, clock_frequency_hz=CLOCK_HZ, poll_s=0.01)

    with PseudoTerminal(device) as terminal:
        _within(10, vanish(terminal))

    class _Later:
        clock_frequency_hz = CLOCK_HZ

        def exchange(self, received, *, until_cycle):
            return device.exchange(received, until_cycle=until_cycle + 100_000_000)

    with PseudoTerminal(_Later()) as terminal:
        found = _within(20, again(terminal.path))
    assert found.is_whole
    assert found.camera_trigger_ticks.size == 16
