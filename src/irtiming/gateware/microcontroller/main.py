"""Runs when the board is switched on: the trigger generator of irtiming on the USB serial port.

Control-C ends it, so that programs which copy files to the board work as usual.
"""

import gc
import select
import sys
from time import ticks_ms

import micropython
from chip import Chip
from generator import Generator

PINS = {  # GPIO numbers; all between 0 and 29
    "chopper": 2,  # reference for the chopper's controller
    "camera": 3,  # trigger for the camera
    "camera_nominal": 4,  # nominal trigger: leave open, or look at it; its edges are what is recorded
    "control": 6,
    "application": 7,
    "camera_input": 8,  # RP2350 only
    "spare": 9,  # RP2350 only
}
RECORDS_AT_ONCE = 5  # as many as a packet of USB holds


def serve(generator: Generator) -> None:
    """Answer on the serial port for ever. Replies go before records; what the computer does not take waits."""
    source, sink = sys.stdin.buffer, sys.stdout.buffer
    readable, writable = select.poll(), select.poll()
    readable.register(sys.stdin, select.POLLIN)
    writable.register(sys.stdout, select.POLLOUT)
    unsent = b""
    while True:
        data = b""
        while len(data) < 64 and readable.poll(0):
            data += source.read(1)
        unsent += generator.receive(data, ticks_ms())
        generator.work()
        if not unsent:
            for _ in range(RECORDS_AT_ONCE):
                unsent += generator.next_record()
        if unsent and writable.poll(0):
            unsent = unsent[sink.write(unsent) or 0 :]


def main() -> None:
    """Set up the chip and serve; bytes of a command must not stop it as Control-C would."""
    generator = Generator(Chip(PINS))
    gc.collect()
    micropython.kbd_intr(-1)
    try:
        serve(generator)
    finally:
        micropython.kbd_intr(3)


if __name__ == "__main__":
    main()
