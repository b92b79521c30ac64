"""A device behind a pseudo-terminal: its bytes, its time, and the end of its line."""

import errno
import os
import select
import time
from itertools import pairwise

import pytest

from irtiming.gateware.messages import CommandMessage, pack_command, unpack_reply
from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.gateware.register_map import ADDRESS


class _Echo:
    """Gives back what it gets, and many bytes at once when asked for; keeps how far it was told to run."""

    clock_frequency_hz = 1_000_000

    def __init__(self):
        self.until = []

    def exchange(self, received, *, until_cycle):
        self.until.append(until_cycle)
        return bytes(range(256)) * 256 if received == b"many" else received


def _read(port, count, *, within=5.0):
    got, end = b"", time.monotonic() + within
    while len(got) < count and time.monotonic() < end:
        if select.select([port], [], [], 0.1)[0]:
            got += os.read(port, 4096)
    return got


def _is_gone(port):
    try:
        return os.read(port, 1) == b""
    except OSError as error:
        return error.errno == errno.EIO


def test_every_byte_passes_in_both_directions():
    """Oracle: all 256 of them; none is taken for a control character."""
    everything = bytes(range(256))
    with PseudoTerminal(_Echo()) as terminal:
        port = os.open(terminal.path, os.O_RDWR | os.O_NOCTTY)
        os.write(port, everything)
        assert _read(port, 256) == everything
        os.close(port)


def test_more_bytes_than_the_terminal_holds_wait_and_none_is_lost():
    """Oracle: 65 536 bytes for a reader who comes a little late, where Linux keeps 4096."""
    with PseudoTerminal(_Echo()) as terminal:
        port = os.open(terminal.path, os.O_RDWR | os.O_NOCTTY)
        os.write(port, b"many")
        time.sleep(0.05)
        assert _read(port, 65_536) == bytes(range(256)) * 256
        os.close(port)


def test_a_command_is_heard_when_it_comes_and_not_in_the_past():
    """Oracle: the device has been run to the cycle at which it is given bytes, so its counter is not behind the clock."""
    device = _Echo()
    heard = []
    exchange = device.exchange

    def watched(received, *, until_cycle):
        if received:
            heard.append((device.until[-1], until_cycle))
        return exchange(received, until_cycle=until_cycle)

    device.exchange = watched
    with PseudoTerminal(device) as terminal:
        port = os.open(terminal.path, os.O_RDWR | os.O_NOCTTY)
        for _ in range(5):
            os.write(port, b"a")
            assert _read(port, 1) == b"a"
            time.sleep(0.003)
        os.close(port)
    assert len(heard) == 5
    assert all(run_to == told for run_to, told in heard)


def test_time_goes_on_at_the_speed_that_is_asked_for():
    """Oracle: the clock of this computer: 1 MHz at a tenth of the speed, never faster, and never backwards."""
    device = _Echo()
    with PseudoTerminal(device, speed=0.1) as terminal:
        begun = time.monotonic()
        terminal.wait(0.3)
        lasted = time.monotonic() - begun
    assert device.until == sorted(device.until)
    assert 0.005 * 100_000 < device.until[-1] <= (lasted + 0.1) * 100_000


def test_a_port_can_be_left_and_opened_again():
    """Oracle: the same device; its counter has gone on."""
    command = pack_command(CommandMessage(operation=0, tag=1, address=ADDRESS["COUNTER_LOW"]))
    counts = []
    with PseudoTerminal(ModelDevice()) as terminal:
        for _ in range(2):
            port = os.open(terminal.path, os.O_RDWR | os.O_NOCTTY)
            os.write(port, command)
            counts.append(unpack_reply(_read(port, 10)).value)
            os.close(port)
    assert counts[1] > counts[0]


def test_an_unplugged_port_is_gone():
    """Oracle: the operating system: an open port has no more bytes."""
    with PseudoTerminal(_Echo()) as terminal:
        port = os.open(terminal.path, os.O_RDWR | os.O_NOCTTY)
        terminal.unplug()
        terminal.unplug()
        assert _is_gone(port)
        os.close(port)


def test_a_device_that_breaks_says_why():
    """Oracle: the exception of the device itself, raised where it was served."""

    class _Broken(_Echo):
        def exchange(self, received, *, until_cycle):
            raise ZeroDivisionError("inside the device")

    with pytest.raises(ZeroDivisionError, match="inside the device"), PseudoTerminal(_Broken()) as terminal:
        terminal.wait(5)


def test_a_slow_device_is_asked_for_less_at_a_time():
    """Oracle: by hand; 10 ms of the device at ten times the speed are 100 000 cycles, for which this one needs 0.2 s."""

    class _Slow(_Echo):
        def exchange(self, received, *, until_cycle):
            time.sleep(2e-6 * (until_cycle - (self.until[-1] if self.until else 0)))
            return super().exchange(received, until_cycle=until_cycle)

    device = _Slow()
    with PseudoTerminal(device, speed=10) as terminal:
        port = os.open(terminal.path, os.O_RDWR | os.O_NOCTTY)
        terminal.wait(0.6)
        os.write(port, b"x")
        assert _read(port, 1) == b"x"
        os.close(port)
    steps = [after - before for before, after in pairwise(device.until)]
    assert max(steps[-5:]) <= 20_000 < max(steps) <= 100_000
