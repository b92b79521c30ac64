"""The simulated blackbody, and the network ports that serve it."""

import math
import socket

import pytest

from irtiming.errors import InstrumentError
from irtiming.twin.devices.blackbody import BlackbodyFaults, SimulatedBlackbody, binary_message
from irtiming.twin.devices.network_port import TcpPort, UdpPort


def _say(device, *messages, gap_s=0.4):
    """What it answers to each message."""
    said = []
    for message in messages:
        begins = device._cycle
        sent = device.exchange(message.encode() + b"\r", until_cycle=begins)
        said.append((sent + device.exchange(b"", until_cycle=begins + round(1e6 * gap_s))).decode("latin-1"))
    return said


def test_it_speaks_as_the_manual_says():
    """Oracle: chapter 6 by hand: any case, a space before operands, no answer to a setting, two kinds of refusal."""
    assert _say(
        SimulatedBlackbody(), "echo Hello, you", "GetTemperature", "SETTEMPERATURE 26.5", "GETTARGETTEMPERATURE", "SETMODE 1",
        "SETMODE 7", "ISTEMPERATURESTABLE", "GETBITERROR", "SETTEMPERATURE 1000", "SETTEMPERATURE warm", "NONSENSE",
    ) == [
        "Hello, you\r", "25.000\r", "", "26.500\r", "", "InvalidOperand\r", "0\r", "OK\r", "InvalidOperand\r",
        "InvalidOperand\r", "InvalidCommand\r",
    ]  # fmt: skip


def test_it_settles_with_one_time_constant():
    """Oracle: the closed form of a first-order step, and of the time at which it is within 0.02 K, plus 5 s."""
    device = SimulatedBlackbody(time_constant_s=60.0)
    assert device.is_stable
    _say(device, "SETTEMPERATURE 35", gap_s=60.0)
    assert device.temperature_k == pytest.approx(308.15 - 10 * math.exp(-1))
    stable_s = 60 * math.log(10 / 0.02) + 5
    device.exchange(b"", until_cycle=round(1e6 * (stable_s - 0.1)))
    assert not device.is_stable
    device.exchange(b"", until_cycle=round(1e6 * (stable_s + 0.1)))
    assert device.is_stable
    assert device.temperature_k == pytest.approx(308.15, abs=0.02)


def test_a_target_in_between_starts_from_the_temperature_that_it_has():
    """Oracle: the temperature does not jump."""
    device = SimulatedBlackbody(time_constant_s=10.0)
    _say(device, "SETTEMPERATURE 35", gap_s=5.0)
    before = device.temperature_k
    device.exchange(b"SETTEMPERATURE 20\r", until_cycle=0)
    assert device.temperature_k == pytest.approx(before)


def test_messages_that_come_too_soon_are_not_heard():
    """Oracle: the 300 ms of the manual."""
    device = SimulatedBlackbody()
    assert _say(device, "ECHO a", "ECHO b", "ECHO c", gap_s=0.2) == ["a\r", "", ""]
    assert device.too_early == 2


def test_faults():
    """Oracle: what each is to do."""
    assert _say(SimulatedBlackbody(faults=BlackbodyFaults(is_silent=True)), "ECHO a") == [""]
    assert _say(SimulatedBlackbody(faults=BlackbodyFaults(lost=1.0)), "ECHO a") == [""]
    assert _say(SimulatedBlackbody(faults=BlackbodyFaults(is_never_stable=True)), "ISTEMPERATURESTABLE") == ["0\r"]
    assert _say(SimulatedBlackbody(faults=BlackbodyFaults(bit_error="Fan")), "GETBITERROR") == ["Fan\r"]
    assert _say(SimulatedBlackbody(faults=BlackbodyFaults(is_binary=True)), "ECHO a")[0].startswith("\xaa\x01")
    assert _say(SimulatedBlackbody(seed=2, faults=BlackbodyFaults(garbled=1.0)), "ECHO hello") != ["hello\r"]


def test_messages_of_an_sr800n_have_the_documented_form():
    """Oracle: the documented vector that sets 100 degrees Celsius."""
    vector = bytes.fromhex("AA 01 00 0A 06 07 F1 00 04 42 C8 00 00 3F")
    assert binary_message(bytes.fromhex("06 07 F1 00 04 42 C8 00 00")) == vector


def test_a_tcp_port_serves_one_user_after_the_other():
    """Oracle: ECHO by plain sockets; the second user is heard when the first has gone."""
    with TcpPort(SimulatedBlackbody(), speed=50) as port:
        for word in (b"one", b"two"):
            with socket.create_connection((port.host, port.port), timeout=2) as user:
                user.sendall(b"ECHO " + word + b"\r")
                assert user.recv(100) == word + b"\r"
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection((port.host, port.port), timeout=2)


def test_a_udp_port_answers_to_the_port_that_it_knows():
    """Oracle: ECHO by plain sockets, without an end of the message; one socket asks, another hears."""
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asks,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as hears,
    ):
        hears.bind(("127.0.0.1", 0))
        hears.settimeout(2)
        with UdpPort(SimulatedBlackbody(), reply_port=hears.getsockname()[1]) as port:
            asks.sendto(b"ECHO there", (port.host, port.port))
            assert hears.recv(100) == b"there"


def test_a_port_that_is_taken_is_told():
    """Oracle: the words."""
    with (
        TcpPort(SimulatedBlackbody()) as port,
        pytest.raises(InstrumentError, match=f"127.0.0.1:{port.port} cannot be served"),
    ):
        TcpPort(SimulatedBlackbody(), port=port.port)


def test_a_device_that_breaks_is_told_at_the_end():
    """Oracle: its own error."""

    class Broken:
        clock_frequency_hz = 1

        def exchange(self, received, *, until_cycle):
            raise ZeroDivisionError("broken")

    with pytest.raises(ZeroDivisionError, match="broken"), TcpPort(Broken()) as port:
        port._thread.join(2)
