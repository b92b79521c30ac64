"""A small GigE Vision camera that does what a test tells it, and the Aravis project's fake camera as another program.

Written from the layout of the protocol's packets alone; it shares nothing with the package.
"""

import fcntl
import io
import os
import shutil
import socket
import struct
import subprocess
import tempfile
import threading
import time
import zipfile
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

ROWS, COLUMNS = 24, 40
XML_AT, FEATURES_AT = 0x10000, 0x40000
CONTROL, HOST_PORT, PACKET_SIZE, DESTINATION = 0x0A00, 0x0D00, 0x0D04, 0x0D18
CHOICES = {
    "PixelFormat": ("Mono8", "Mono12", "Mono16"),
    "TriggerSelector": ("FrameStart", "AcquisitionStart"),
    "TriggerMode": ("Off", "On"),
    "TriggerSource": ("Software", "Line0", "Line1"),
    "TriggerActivation": ("RisingEdge", "FallingEdge", "LevelHigh"),
    "AcquisitionMode": ("SingleFrame", "Continuous"),
}
NUMBERS = {"Width": COLUMNS, "Height": ROWS, "PayloadSize": 2 * ROWS * COLUMNS}
COMMANDS = ("AcquisitionStart", "AcquisitionStop")


def description(without=(), choices=CHOICES):
    """XML of the features, and the address of each one's register; each selector has a trigger mode of its own."""
    at = {name: FEATURES_AT + 4 * i for i, name in enumerate((*choices, *NUMBERS, *COMMANDS))}
    at |= {"TriggerMode": FEATURES_AT + 0x100}
    parts = []
    for name in (n for n in (*choices, *NUMBERS, *COMMANDS) if n not in without):
        register = f"<pValue>{name}Register</pValue>"
        if name in choices:
            entries = "".join(
                f'<EnumEntry Name="{c}"><Value>{i}</Value></EnumEntry>' for i, c in enumerate(choices[name])
            )
            parts.append(f'<Enumeration Name="{name}">{entries}{register}</Enumeration>')
        elif name in NUMBERS:
            parts.append(f'<Integer Name="{name}">{register}</Integer>')
        else:
            parts.append(f'<Command Name="{name}">{register}<CommandValue>1</CommandValue></Command>')
        access = "RO" if name in NUMBERS else "RW"
        index = '<pIndex Offset="4">TriggerSelectorRegister</pIndex>' if name == "TriggerMode" else ""
        index = "" if "TriggerSelector" in without else index
        parts.append(
            f'<IntReg Name="{name}Register"><Address>{at[name]:#x}</Address>{index}<Length>4</Length><AccessMode>{access}'
            "</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable><Sign>Unsigned</Sign>"
            "<Endianess>BigEndian</Endianess></IntReg>"
        )
    listed = "".join(f"<pFeature>{n}</pFeature>" for n in (*choices, *NUMBERS, *COMMANDS) if n not in without)
    head = (
        '<RegisterDescription ModelName="Small" VendorName="Test" StandardNameSpace="None" SchemaMajorVersion="1" '
        'SchemaMinorVersion="1" SchemaSubMinorVersion="0" MajorVersion="1" MinorVersion="0" SubMinorVersion="0" '
        'ToolTip="" ProductGuid="0" VersionGuid="0" xmlns="http://www.genicam.org/GenApi/Version_1_1">'
    )
    root = f'<Category Name="Root" NameSpace="Standard">{listed}</Category><Port Name="Device"/>'
    return f"{head}{root}{''.join(parts)}</RegisterDescription>", at


class Responder:
    """The camera; ``say`` makes it send, the attributes make it misbehave."""

    def __init__(self, *, without=(), zipped=False, largest_packet=1500, resends=True, choices=CHOICES, kind="Local"):
        pid = os.getpid()
        self.host = f"127.{pid >> 14 & 63 | 64}.{pid >> 7 & 127}.{pid & 127 | 128}"
        xml, self.at = description(without, choices)
        content = xml.encode()
        if zipped:
            packed = io.BytesIO()
            with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
                archive.writestr("small.xml", content)
            content = packed.getvalue()
        place = f"{kind}:small.{'zip' if zipped else 'xml'};{XML_AT:x};{len(content):x}?SchemaVersion=1.1.0".encode()
        self.memory = bytearray(0x50000)
        for address, data in ((0x200, place), (XML_AT, content), (0x48, b"Test"), (0x68, b"Small"), (0xD8, b"T7")):
            self.memory[address : address + len(data)] = data
        for address, value in (
            (0x904, 1),
            (0xD1C, 3956),
            (0x938, 600),
            (0x934, 4 * resends),
            (0x940, 1_000_000),
            (PACKET_SIZE, 576),
        ):
            self.set(address, value)
        for name, value in NUMBERS.items():
            self.set(self.at[name], value)
        self.choices, self.largest_packet = choices, largest_packet
        self.controller, self.is_silent = None, False
        self.stuck: set[int] = set()  # registers that take a value and keep their own
        self.sent: dict[tuple[int, int], bytes] = {}
        self.asked: list[tuple[int, int, int]] = []
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((self.host, 3956))
        self._socket.settimeout(0.02)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *args):
        self._stop.set()
        self._thread.join()
        self._socket.close()

    def get(self, address):
        return struct.unpack_from(">I", self.memory, address)[0]

    def set(self, address, value):
        struct.pack_into(">I", self.memory, address, value)

    def choose(self, name, choice):
        self.set(self.at[name], self.choices[name].index(choice))

    def chosen(self, name):
        return self.choices[name][self.get(self.at[name])]

    def say(self, number, pixels, *, lose=(), ticks=0, wide=False, spoil=()):
        """Send one frame without the packets ``lose`` (0 is the leader), and ``spoil`` with an error as status."""
        data = np.ascontiguousarray(pixels, "<u2").tobytes()
        share = (self.get(PACKET_SIZE) & 0xFFFF) - 28 - (20 if wide else 8)
        leader = struct.pack(">HHQIIIIIHH", 0, 1, ticks, 0x01100007, pixels.shape[1], pixels.shape[0], 0, 0, 0, 0)
        pieces = [(1, leader)] + [(3, data[i : i + share]) for i in range(0, len(data), share)]
        pieces.append((2, struct.pack(">HHI", 0, 1, pixels.shape[0])))
        for i, (kind, content) in enumerate(pieces):
            if wide:
                head = struct.pack(">HHIQI", 0, 0, (0x80 | kind) << 24, number, i)
            else:
                head = struct.pack(">HHI", 0, number, kind << 24 | i)
            self.sent[number, i] = head + content
            if i in spoil:
                self._stream(struct.pack(">H", 0x800C) + head[2:])
            elif i not in lose:
                self._stream(head + content)
        return len(pieces)

    def _stream(self, packet):
        where = socket.inet_ntoa(struct.pack(">I", self.get(DESTINATION)))
        if port := self.get(HOST_PORT):
            self._socket.sendto(packet, (where, port))

    def _serve(self):
        while not self._stop.is_set():
            with suppress(TimeoutError, ConnectionError):
                data, sender = self._socket.recvfrom(2048)
                if not self.is_silent:
                    self._answer(data, sender)

    def _answer(self, data, sender):
        _, flags, command, _, request = struct.unpack_from(">BBHHH", data)
        content, status, reply = data[8:], 0, b""
        if command == 0x0002:
            reply = bytes(self.memory[:0x48]) + bytes(self.memory[0x48:0xF8])
        elif command == 0x0080:
            reply = struct.pack(">I", self.get(struct.unpack(">I", content)[0]))
        elif command == 0x0084:
            address, _, length = struct.unpack(">IHH", content)
            reply = content[:4] + bytes(self.memory[address : address + length])
        elif command == 0x0082:
            status = self._write(*struct.unpack(">II", content), sender)
            reply = struct.pack(">HH", 0, 1)
        elif command == 0x0086:
            address, *values = struct.unpack(f">{len(content) // 4}I", content)
            status = max(self._write(address + 4 * i, value, sender) for i, value in enumerate(values))
            reply = struct.pack(">HH", 0, len(values))
        elif command == 0x0040:
            self._send_again(content, wide=bool(flags & 0x10))
            return
        self._socket.sendto(struct.pack(">HHHH", status, command + 1, len(reply), request) + reply, sender)

    def _write(self, address, value, sender):
        if self.controller not in (None, sender):
            return 0x8006
        if address == CONTROL:
            self.controller = sender if value & 2 else None
        if address not in self.stuck:
            self.set(address, value & 0xFFFF if address == PACKET_SIZE else value)
        if address == PACKET_SIZE and value >> 31 and value & 0xFFFF <= self.largest_packet:
            self._stream(bytes((value & 0xFFFF) - 28))
        return 0

    def _send_again(self, content, *, wide):
        first, last = struct.unpack_from(">II", content, 4)
        number = struct.unpack_from(">Q", content, 12)[0] if wide else struct.unpack_from(">H", content, 2)[0]
        self.asked.append((number, first, last))
        for i in range(first, last + 1):
            if (number, i) in self.sent:
                self._stream(self.sent[number, i])


def image(seed):
    """Random pixels, so that a piece at a wrong place shows."""
    return np.random.default_rng(seed).integers(1, 2**16, (ROWS, COLUMNS), dtype=np.uint16)


@contextmanager
def aravis_fake(*options):
    """The fake camera of the Aravis project at 127.0.0.1; one at a time on this computer, since it knows no other address."""
    program = shutil.which("arv-fake-gv-camera-0.8")
    if program is None:
        pytest.skip("arv-fake-gv-camera-0.8 is not installed (Debian: aravis-tools)")
    with Path(tempfile.gettempdir(), "aravis-fake-camera.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        command = [program, "-i", "127.0.0.1", "-s", "SIM01", *options]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            try:
                _wait_for_answer()
                yield process
            finally:
                process.kill()


def _wait_for_answer():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.settimeout(0.1)
        until = time.monotonic() + 5
        while time.monotonic() < until:
            with suppress(OSError):
                probe.sendto(struct.pack(">BBHHH", 0x42, 1, 0x0080, 4, 1) + bytes([0, 0, 0x0A, 0]), ("127.0.0.1", 3956))
                if probe.recv(100):
                    return
    pytest.fail("the fake camera does not answer")
