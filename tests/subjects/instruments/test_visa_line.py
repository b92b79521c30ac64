"""Lines to instruments: what opens them, what keeps others out, and what is said when they cannot be opened."""

import asyncio
import socket
import subprocess
import sys

import pytest
import serial

from irtiming.errors import InstrumentError, InstrumentSilent
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.instruments import serial_line
from irtiming.instruments.visa_line import (
    Pace,
    Speech,
    TextAdapter,
    Unanswered,
    VisaChannel,
    Worker,
    open_text_line,
    speed_of,
    split_options,
)
from irtiming.twin.devices.blackbody import SimulatedBlackbody
from irtiming.twin.devices.network_port import TcpPort, UdpPort

SPEECH = Speech(baud=9600, reply_s=0.3, quiet_s=0.05)


class _Scripted:
    """Gives the pieces one by one, then silence."""

    def __init__(self, *pieces):
        self.pieces, self.sent = list(pieces), b""

    def send(self, data):
        self.sent += data

    def receive(self, timeout_s):
        return self.pieces.pop(0) if self.pieces else b""

    def close(self):
        pass


def _text(*pieces, **speech):
    return TextAdapter(_Scripted(*pieces), Speech(**{"baud": 1, "reply_s": 0.05} | speech), line="memory").read()


@pytest.mark.parametrize(
    ("pieces", "speech", "text"),
    [
        ((b"25.0", b"00\r"), {}, "25.000"),
        ((b"id?\rTHORLABS MC2000B\r>", b" "), {"ends": ">"}, "id?\rTHORLABS MC2000B\r"),
        ((b"25.000",), {"quiet_s": 0.01}, "25.000"),
        ((b"\xff\xfe\n",), {}, "\xff\xfe"),
    ],
)
def test_an_answer_ends_at_its_end_or_in_silence(pieces, speech, text):
    """Oracle: the texts, written by hand; the prompt of three characters is never taken for three ends."""
    assert _text(*pieces, **speech) == text


def test_half_an_answer_is_none_where_silence_does_not_end_it():
    """Oracle: what came of it, and that nothing of it is left for the next answer."""
    adapter = TextAdapter(_Scripted(b"half"), Speech(baud=1, ends=">", reply_s=0.02), line="memory")
    with pytest.raises(Unanswered) as failure:
        adapter.read()
    assert failure.value.arrived == "half"
    adapter.connection.pieces = [b"whole>"]
    assert adapter.read() == "whole"


@pytest.mark.parametrize("kind", ["tcp", "visa socket", "udp", "serial", "visa serial", "pyvisa"])
def test_every_kind_of_line_carries_question_and_answer(kind):
    """Oracle: ECHO of the blackbody gives back its text, by every line that the address may name."""
    with (
        TcpPort(SimulatedBlackbody()) as tcp,
        UdpPort(SimulatedBlackbody(), reply_port=0) as udp,
        PseudoTerminal(SimulatedBlackbody()) as terminal,
    ):
        name = {
            "tcp": f"tcp:127.0.0.1:{tcp.port}",
            "visa socket": f"TCPIP0::127.0.0.1::{tcp.port}::SOCKET",
            "udp": f"udp:localhost:{udp.port}",
            "serial": terminal.path,
            "visa serial": f"ASRL{terminal.path}::INSTR",
            "pyvisa": f"TCPIP0::127.0.0.1::{tcp.port}::SOCKET",
        }[kind]
        adapter = (
            TextAdapter(VisaChannel(name), SPEECH, line=name) if kind == "pyvisa" else open_text_line(name, SPEECH)
        )
        adapter.write("ECHO hello")
        assert adapter.read() == "hello"
        adapter.close()
        adapter.close()


def test_answers_over_udp_come_to_the_port_that_the_unit_knows():
    """Oracle: a port of ours that is told to both, and the words when another program has it."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("", 0))
        taken = other.getsockname()[1]
        with pytest.raises(
            InstrumentError, match=f"come to UDP port {taken} of this computer, which another program uses"
        ):
            open_text_line("udp:127.0.0.1:5200", SPEECH, reply_port=taken)
    with UdpPort(SimulatedBlackbody(), reply_port=taken) as port:
        adapter = open_text_line(f"udp:127.0.0.1:{port.port}", SPEECH, reply_port=taken)
        adapter.write("ECHO here")
        assert adapter.read() == "here"
        adapter.close()


def test_answers_over_udp_are_heard_from_the_units_network_alone():
    """Oracle: the address that the system says the socket is bound to; by the loopback no other network is reached."""
    adapter = open_text_line("udp:127.0.0.1:9", SPEECH)
    assert adapter.connection._socket.getsockname()[0] == "127.0.0.1"
    adapter.close()


def test_datagrams_of_others_are_no_answer():
    """Oracle: a datagram from another address, which must not be read."""
    adapter = open_text_line("udp:127.0.0.1:9", SPEECH)
    port = adapter.connection._socket.getsockname()[1]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.bind(("127.9.9.9", 0))
        stranger.sendto(b"25.000\r", ("127.0.0.1", port))
        with pytest.raises(Unanswered):
            adapter.read()
    adapter.close()


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("/dev/ttyNOWHERE", "/dev/ttyNOWHERE cannot be opened .*serial ports of this computer: "),
        ("ASRL/dev/ttyNOWHERE::INSTR", "/dev/ttyNOWHERE cannot be opened"),
        ("tcp:127.0.0.1:1", "tcp:127.0.0.1:1 refuses the connection; see that the device is on"),
        ("TCPIP::127.0.0.1::1::SOCKET", "refuses the connection"),
        ("tcp:no.such.host.invalid:5200", "no host is called 'no.such.host.invalid'; write its IP address"),
        ("udp:no.such.host.invalid:5200", "no host is called"),
        ("tcp:127.0.0.1", "is no line; write a serial port such as .* with a port from 1 to 65535"),
        ("tcp:127.0.0.1:99999", "is no line"),
        ("GPIB0::7::NONSENSE", "cannot be opened by PyVISA"),
    ],
)
def test_what_cannot_be_opened_is_told_in_one_line(line, says):
    """Oracle: the words."""
    with pytest.raises(InstrumentError, match=says) as failure:
        open_text_line(line, SPEECH)
    assert "\n" not in str(failure.value)


def test_a_port_that_may_not_be_opened_is_told(monkeypatch):
    """Oracle: the words for the error that the system gives; the tests' user may be one who may open everything."""

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(serial, "Serial", refuse)
    with pytest.raises(InstrumentError, match="may not be opened by this user.*dialout"):
        open_text_line("/dev/ttyUSB0", SPEECH)


def test_a_port_that_another_program_has_is_told():
    """Oracle: a second process that holds the port; and one of ours keeps others out until it is closed."""
    hold = "import serial, sys; port = serial.Serial(sys.argv[1], exclusive=True); print('has it', flush=True); sys.stdin.read()"
    with PseudoTerminal(SimulatedBlackbody()) as terminal:
        with subprocess.Popen(
            [sys.executable, "-c", hold, terminal.path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as other:
            assert other.stdout.readline().strip() == "has it"
            with pytest.raises(InstrumentError, match="is used by another program; end that program"):
                open_text_line(terminal.path, SPEECH)
            other.communicate()
        ours = open_text_line(terminal.path, SPEECH)
        with pytest.raises(InstrumentError, match="is used by another program"):
            open_text_line(terminal.path, SPEECH)
        ours.close()
        open_text_line(terminal.path, SPEECH).close()


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for the flag")
def test_programs_that_know_no_locks_are_kept_out_too(monkeypatch):
    """Oracle: the flag that makes the system itself refuse a second program, read back from the terminal."""
    monkeypatch.setattr(serial_line, "_OF_SIMULATIONS", "/dev/other")
    from fcntl import ioctl
    from struct import unpack

    tell_exclusive = 0x80045440  # TIOCGEXCL of Linux, which Python does not name
    with PseudoTerminal(SimulatedBlackbody()) as terminal:
        adapter = open_text_line(terminal.path, SPEECH)
        assert unpack("i", ioctl(terminal._theirs, tell_exclusive, bytes(4))) == (1,)
        adapter.close()
        assert unpack("i", ioctl(terminal._theirs, tell_exclusive, bytes(4))) == (0,)


def test_a_line_that_goes_away_is_told():
    """Oracle: the words, by cable and by network."""
    with PseudoTerminal(SimulatedBlackbody()) as terminal:
        adapter = open_text_line(terminal.path, SPEECH)
        terminal.unplug()
        with pytest.raises(InstrumentSilent, match="is gone; plug the device in again"):
            adapter.read()
        adapter.close()
    with TcpPort(SimulatedBlackbody()) as port:
        adapter = open_text_line(f"tcp:127.0.0.1:{port.port}", SPEECH)
        adapter.write("ECHO x")
        assert adapter.read() == "x"
    with pytest.raises(InstrumentSilent, match="has closed the connection"):
        adapter.read()
    adapter.close()


def test_options_stand_behind_a_question_mark():
    """Oracle: the parts of the address, and the words for what is none."""
    assert split_options("/dev/ttyUSB0?blade=0&speed=20", ("blade", "speed")) == (
        "/dev/ttyUSB0",
        {"blade": "0", "speed": "20"},
    )
    assert split_options("tcp:host:5200", ("speed",)) == ("tcp:host:5200", {})
    assert speed_of({"speed": "20"}) == 20
    assert speed_of({}) == 1
    with pytest.raises(InstrumentError, match=r"option baud=3 of address .* cannot be used; there are blade"):
        split_options("x?baud=3", ("blade",))
    with pytest.raises(InstrumentError, match="options that cannot be read"):
        split_options("x?", ("blade",))
    for text in ("0", "-1", "fast", "inf", "nan"):
        with pytest.raises(InstrumentError, match="is no speed of a simulated rig"):
            speed_of({"speed": text})


def test_messages_keep_their_distance(monkeypatch):
    """Oracle: a clock of our own; the second of two messages waits for what is left of the gap, the third for nothing."""
    now, slept = [10.0], []
    monkeypatch.setattr("irtiming.instruments.visa_line.monotonic", lambda: now[0])
    monkeypatch.setattr("irtiming.instruments.visa_line.sleep", slept.append)
    pace = Pace(0.3)
    for time in (10.0, 10.1, 11.0):
        now[0] = time
        pace.wait()
    assert slept == pytest.approx([0.2, 0.0])


def test_calls_are_made_one_after_the_other_and_waited_for_at_the_end():
    """Oracle: the order of the calls, one of which was given up by its caller."""
    done = []

    def slow():
        import time

        time.sleep(0.1)
        done.append("first")

    async def work():
        worker = Worker("test")
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(worker.do(slow), 0.02)
        await worker.do(lambda: done.append("second"))
        await worker.close()
        await worker.close()

    asyncio.run(work())
    assert done == ["first", "second"]
