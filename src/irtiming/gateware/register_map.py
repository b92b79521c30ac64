"""The registers of the trigger generator: one table, read by the circuit, its driver and the reference page.

Every register has 32 bits. Times are in cycles of the generator's clock, whose frequency it tells (`CLOCK_FREQUENCY`).
"""

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import Literal, final

IDENTITY = 0x49525447
"""What register 0 of every trigger generator holds: the letters IRTG."""

VERSION = (1, 0)
"""Of this map: a driver works with devices of the same first number and at least the same second one."""

QUEUE_DEPTH = 512
"""Records that wait for the line; 1.4 s of the paper's scheme."""

INPUT_LATENCY_CYCLES = 2
"""From the first clock edge at which a pin has changed to the counter value that is recorded, with the glitch filter at 0."""

OUTPUT_LATENCY_CYCLES = 1
"""From the counter value that is recorded for an edge of the generator's own to the clock edge at which the pin changes."""

BAUD = 1_000_000
"""Bits per second on the serial line, 8 data bits, no parity, 1 stop bit."""


class Channel(IntFlag):
    """What happened in a clock cycle: the channels of a record."""

    CAMERA_TRIGGER = 1 << 0  # nominal: t0 + k C
    CAMERA_TRIGGER_DELAYED = 1 << 1  # the edge that the camera gets: t0 + D + k C
    CAMERA_INPUT = 1 << 2  # what a camera sends back: its exposure output, or the trigger line at its end
    CONTROL_SLOT = 1 << 3  # cut out to solid
    APPLICATION_SLOT = 1 << 4  # cut out to solid: edges 0 and 2
    APPLICATION_OTHER_EDGE = 1 << 5  # solid to cut out: edges 1 and 3
    SPARE = 1 << 6  # a pulse per second, a second camera


LOSS = 1 << 7
"""In the place of an eighth channel: records were lost right before this one."""


class Command(IntEnum):
    """What may be written to COMMAND."""

    ARM = 1  # empty the queue, forget losses, number records from 0 and begin to record
    START = 2  # begin the train of camera triggers
    STOP = 3  # end the train after the pulse that runs, and recording at once


class Status(IntFlag):
    """Bits of STATUS."""

    ARMED = 1 << 0  # events are recorded
    TRIGGERING = 1 << 1  # the train of camera triggers runs, delayed pulses included
    FINISHED = 1 << 2  # the train has ended with its full count
    LOSS = 1 << 3  # a record was lost since ARM
    QUEUE_EMPTY = 1 << 4  # every record since ARM has been sent or is being sent


class Polarity(IntFlag):
    """Bits of POLARITY: set where the line's falling edge is the one that counts."""

    CHOPPER_OUTPUT = 1 << 0
    CAMERA_OUTPUT = 1 << 1
    CAMERA_INPUT = 1 << 2
    CONTROL_SLOT = 1 << 3
    APPLICATION_SLOT = 1 << 4
    SPARE = 1 << 6


class Refusal(IntEnum):
    """Why a command was not done."""

    NONE = 0
    UNKNOWN_REGISTER = 1
    READ_ONLY = 2
    BUSY = 3  # settings stay as they are while armed or triggering
    BAD_VALUE = 4
    NOT_ARMED = 5


Access = Literal["read", "setting", "command"]


@final
@dataclass(frozen=True, kw_only=True)
class Register:
    """One register: ``lowest`` .. ``highest`` are the values that it accepts, ``at_reset`` what it holds at first.

    An ``at_reset`` of None follows from the clock of the board (`at_reset`).
    """

    name: str
    address: int
    access: Access
    unit: str
    what: str
    lowest: int = 0
    highest: int = 2**32 - 1
    at_reset: int | None = 0


_ALL_CHANNELS = int(sum(Channel))

REGISTERS: tuple[Register, ...] = (
    Register(name="IDENTITY", address=0x00, access="read", unit="", at_reset=IDENTITY, what="the letters IRTG"),
    Register(
        name="VERSION", address=0x01, access="read", unit="", at_reset=VERSION[0] << 16 | VERSION[1],
        what="first number in the upper 16 bits, second in the lower",
    ),
    Register(name="CLOCK_FREQUENCY", address=0x02, access="read", unit="Hz", at_reset=None, what="of the counter"),
    Register(
        name="QUEUE_DEPTH", address=0x03, access="read", unit="records", at_reset=QUEUE_DEPTH,
        what="records that can wait for the line",
    ),
    Register(
        name="INPUT_LATENCY", address=0x04, access="read", unit="cycles", at_reset=INPUT_LATENCY_CYCLES,
        what="a recorded input edge came so many cycles earlier, and FILTER cycles more",
    ),
    Register(
        name="OUTPUT_LATENCY", address=0x05, access="read", unit="cycles", at_reset=OUTPUT_LATENCY_CYCLES,
        what="an output pin changes so many cycles after the recorded time",
    ),
    Register(
        name="COMMAND", address=0x10, access="command", unit="", lowest=1, highest=3,
        what="1 arm: empty the queue and record; 2 start the camera triggers; 3 stop both",
    ),
    Register(
        name="STATUS", address=0x11, access="read", unit="", at_reset=int(Status.QUEUE_EMPTY),
        what="bit 0 armed, 1 triggering, 2 train finished with its full count, 3 records lost, 4 queue empty",
    ),
    Register(
        name="RECORDS_WRITTEN", address=0x12, access="read", unit="records",
        what="records since ARM, lost ones not counted; its lower 16 bits are the number of the next record",
    ),
    Register(
        name="RECORDS_LOST", address=0x13, access="read", unit="records", what="since ARM; stays at its largest value",
    ),
    Register(
        name="COUNTER_LOW", address=0x14, access="read", unit="cycles",
        what="lower 32 bits of the 48-bit counter; reading them keeps the upper 16 for COUNTER_HIGH",
    ),
    Register(name="COUNTER_HIGH", address=0x15, access="read", unit="2^32 cycles", what="upper 16 bits, as kept"),
    Register(
        name="GARBLED_COMMANDS", address=0x16, access="read", unit="commands",
        what="commands since power-on whose check sum was wrong, or that broke off; stays at its largest value",
    ),
    Register(
        name="CHOPPER_WIDTH", address=0x20, access="setting", unit="cycles", lowest=1, at_reset=None,
        what="length of a pulse of the chopper's reference; holds from the next CHOPPER_PERIOD on",
    ),
    Register(
        name="CHOPPER_PERIOD", address=0x21, access="setting", unit="cycles", lowest=2, at_reset=None,
        what="T'; must exceed CHOPPER_WIDTH; both hold from the end of the running period on; at first 300 pulses a second",
    ),
    Register(
        name="CAMERA_WIDTH", address=0x28, access="setting", unit="cycles", lowest=1, at_reset=None,
        what="length of a camera trigger; holds from the next CAMERA_PERIOD on",
    ),
    Register(
        name="CAMERA_PERIOD", address=0x29, access="setting", unit="cycles", lowest=2, at_reset=None,
        what="C; must exceed CAMERA_WIDTH; at first 30 triggers a second",
    ),
    Register(
        name="CAMERA_COUNT", address=0x2A, access="setting", unit="triggers", lowest=1, at_reset=1,
        what="triggers of a train",
    ),
    Register(
        name="CAMERA_DELAY", address=0x2B, access="setting", unit="cycles",
        what="D: from a nominal trigger to the edge that the camera gets; may exceed the period",
    ),
    Register(
        name="POLARITY", address=0x30, access="setting", unit="", highest=int(sum(Polarity)),
        what="bit 0 chopper output, 1 camera output, 2 camera input, 3 control slot, 4 application slot, 6 spare: "
        "set where the falling edge counts (an output then idles high)",
    ),
    Register(
        name="CHANNELS", address=0x31, access="setting", unit="", highest=_ALL_CHANNELS,
        at_reset=int(_ALL_CHANNELS & ~Channel.APPLICATION_OTHER_EDGE & ~Channel.CAMERA_INPUT & ~Channel.SPARE),
        what="channels that are recorded, a bit each as in a record; bit 5 adds the wheel's edges 1 and 3",
    ),
    Register(
        name="FILTER", address=0x32, access="setting", unit="cycles", highest=255,
        what="an input edge counts once the line has kept its new level for so many further cycles",
    ),
)  # fmt: skip
"""In the order of their addresses."""

ADDRESS: dict[str, int] = {register.name: register.address for register in REGISTERS}
"""Of each register by its name."""

_RATES_AT_RESET_HZ = {"CHOPPER": 300, "CAMERA": 30}


def at_reset(register: Register, clock_frequency_hz: int) -> int:
    """What a register holds after reset of a device whose clock is this.

    Parameters
    ----------
    register
        Of this map.
    clock_frequency_hz
        Of the board.

    Returns
    -------
    32 bits.
    """
    if register.at_reset is not None:
        return register.at_reset
    if register.name == "CLOCK_FREQUENCY":
        return clock_frequency_hz
    generator, quantity = register.name.split("_")
    period = clock_frequency_hz // _RATES_AT_RESET_HZ[generator]
    return period if quantity == "PERIOD" else period // 2
