"""Features by their names, over registers in memory."""

import struct

import pytest

pytest.importorskip("genicam", reason="the extra irtiming[rig] is not installed")

from irtiming.errors import InstrumentRefused, InstrumentSilent
from irtiming.instruments.genicam.features import Features

HEAD = (
    '<RegisterDescription ModelName="M" VendorName="V" StandardNameSpace="None" SchemaMajorVersion="1" '
    'SchemaMinorVersion="1" SchemaSubMinorVersion="0" MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ToolTip="" '
    'ProductGuid="0" VersionGuid="0" xmlns="http://www.genicam.org/GenApi/Version_1_1">'
)


def _register(name, address, *, kind="IntReg", length=4, access="RW", more=""):
    """A register of its own; one that GenApi does not keep, so that each read asks the camera."""
    return (
        f'<{kind} Name="{name}"><Address>{address}</Address><Length>{length}</Length><AccessMode>{access}</AccessMode>'
        f"<pPort>Device</pPort><Cachable>NoCache</Cachable>{more}</{kind}>"
    )


INTEGER = "<Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>"
XML = (
    HEAD
    + '<Category Name="Root" NameSpace="Standard">'
    + "".join(
        f"<pFeature>{n}</pFeature>"
        for n in ("Width", "Serial", "Gain", "Source", "Reverse", "Start", "Name", "Secret", "Broken")
    )
    + '</Category><Port Name="Device"/>'
    + _register("WidthRegister", 0, more=INTEGER)
    + '<Integer Name="Width"><pValue>WidthRegister</pValue><Min>8</Min><Max>640</Max><Inc>8</Inc></Integer>'
    + _register("Serial", 4, access="RO", more=INTEGER)
    + _register("Gain", 8, kind="FloatReg", more="<Endianess>BigEndian</Endianess>")
    + _register("SourceRegister", 12, more=INTEGER)
    + '<Enumeration Name="Source"><EnumEntry Name="Software"><Value>0</Value></EnumEntry>'
    '<EnumEntry Name="Line1"><Value>1</Value></EnumEntry><EnumEntry Name="Line2"><pIsAvailable>Zero</pIsAvailable>'
    "<Value>2</Value></EnumEntry><pValue>SourceRegister</pValue></Enumeration>"
    + '<Integer Name="Zero"><Value>0</Value></Integer>'
    + _register("ReverseRegister", 16, more=INTEGER)
    + '<Boolean Name="Reverse"><pValue>ReverseRegister</pValue><OnValue>1</OnValue><OffValue>0</OffValue></Boolean>'
    + _register("StartRegister", 20, access="WO", more=INTEGER)
    + '<Command Name="Start"><pValue>StartRegister</pValue><CommandValue>7</CommandValue></Command>'
    + _register("Name", 32, kind="StringReg", length=16)
    + _register("Secret", 24, access="WO", more=INTEGER)
    + _register("Broken", 100, more=INTEGER)
    + "</RegisterDescription>"
)


class Memory:
    """Registers; there is none from 64 on, one at 8 rounds to quarters, and what is `stuck` keeps its value."""

    def __init__(self):
        self.content, self.stuck = bytearray(64), set()
        struct.pack_into(">I4xf", self.content, 0, 320, 1.5)

    def read(self, address, length):
        if address >= 64:
            raise InstrumentSilent("the line is cut")
        return bytes(self.content[address : address + length])

    def write(self, address, data):
        if address >= 64:
            raise InstrumentSilent("the line is cut")
        if address in self.stuck:
            return
        if address == 8:
            data = struct.pack(">f", round(struct.unpack(">f", data)[0] * 4096) / 4096)
        self.content[address : address + len(data)] = data


@pytest.fixture
def memory():
    return Memory()


@pytest.fixture
def features(memory):
    opened = Features(XML, registers=memory, name="camera x")
    yield opened
    opened.close()


@pytest.mark.parametrize(
    ("name", "value", "held", "address", "content"),
    [
        ("Width", "640", "640", 0, struct.pack(">I", 640)),
        ("Width", "0x80", "128", 0, struct.pack(">I", 128)),
        ("Gain", "2.25", "2.25", 8, struct.pack(">f", 2.25)),
        ("Source", "Line1", "Line1", 12, struct.pack(">I", 1)),
        ("Reverse", "true", "1", 16, struct.pack(">I", 1)),
        ("Reverse", "On", "1", 16, struct.pack(">I", 1)),
        ("Name", "north", "north", 32, b"north\0"),
    ],
)
def test_features_of_every_kind(features, memory, name, value, held, address, content):
    """Oracle: bytes in the register by hand, in the byte order of the description."""
    assert features.write(name, value=value) == held
    assert memory.content[address : address + len(content)] == content
    assert features.read(name) == held


def test_reading_asks_the_camera_each_time(features, memory):
    """Oracle: the register, changed behind the description's back."""
    assert features.number("Width") == 320
    struct.pack_into(">I", memory.content, 0, 96)
    assert features.read("Width") == "96"
    assert features.choices("Source") == ["Software", "Line1"]  # Line2 is not to be had
    assert features.choices("Width") == []


def test_commands(features, memory):
    """Oracle: the command's value in its register."""
    features.execute("Start")
    assert struct.unpack_from(">I", memory.content, 20) == (7,)
    assert features.has("Start")
    assert not features.has("Stop")
    assert "Start" in features.names()
    assert "WidthRegister" not in features.names()


def test_float_may_be_rounded_by_the_camera(features):
    """Oracle: the nearest of steps of 1/4096 to 0.3: 1229/4096, wrong by 2e-4 of itself."""
    assert float(features.write("Gain", value="0.3")) == pytest.approx(1229 / 4096)
    with pytest.raises(InstrumentRefused, match="Gain of camera x was set to 0.0002, but the camera holds"):
        features.write("Gain", value="0.0002")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("Widht", "8", "camera x has no feature 'Widht'; nearest names: Width"),
        ("Zzz", "8", "has no feature 'Zzz'; its manual"),
        ("Source", "Line9", "Source of camera x cannot be 'Line9'; it may be Software, Line1$"),
        ("Source", "Line2", "it may be Software, Line1$"),
        ("Serial", "8", "Serial of camera x cannot be set"),
        ("Width", "9999", "cannot be '9999': Value = 9999 must be equal or smaller than Max = 640"),
        ("Width", "9", "cannot be '9': "),
        ("Width", "wide", "cannot be 'wide'"),
        ("Reverse", "maybe", "cannot be 'maybe'"),
        ("Start", "1", "is a command"),
        ("Root", "1", "cannot be set"),
    ],
)
def test_what_cannot_be_set(features, memory, name, value, words):
    """Oracle: what is wrong with each, in one line; nothing is written."""
    before = bytes(memory.content)
    with pytest.raises(InstrumentRefused, match=words) as told:
        features.write(name, value=value)
    assert "\n" not in str(told.value)
    assert memory.content == before


def test_what_cannot_be_read(features):
    """Oracle: a command, a register that takes and never gives, text where a number must be, and no command."""
    for name, words in (("Start", "no value"), ("Secret", "cannot be read"), ("Root", "no value")):
        with pytest.raises(InstrumentRefused, match=words):
            features.read(name)
    with pytest.raises(InstrumentRefused, match="'Software', not a number"):
        features.number("Source")
    with pytest.raises(InstrumentRefused, match="is no command"):
        features.execute("Width")


def test_value_that_the_camera_does_not_keep(features, memory):
    """Oracle: registers that take a value and keep their own."""
    memory.stuck |= {0, 12, 16}
    for name, value, held in (("Width", "640", "320"), ("Source", "Line1", "Software"), ("Reverse", "1", "0")):
        with pytest.raises(
            InstrumentRefused, match=f"{name} of camera x was set to {value}, but the camera holds {held}"
        ):
            features.write(name, value=value)


def test_error_of_the_line_comes_through_as_it_was(features):
    """Oracle: the registers' own error, not GenApi's words for it."""
    with pytest.raises(InstrumentSilent, match="^the line is cut$"):
        features.read("Broken")
    with pytest.raises(InstrumentSilent, match="^the line is cut$"):
        features.write("Broken", value="3")


@pytest.mark.parametrize("text", ["", "no XML", XML[:500], XML.replace("</Category>", "")])
def test_description_that_cannot_be_read(text, memory):
    """Oracle: texts that are no description."""
    with pytest.raises(InstrumentRefused, match="describes itself in a way that cannot be read") as told:
        Features(text, registers=memory, name="camera x")
    assert "\n" not in str(told.value)
