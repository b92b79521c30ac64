"""A measurement and many odd commands, the same on CPython and MicroPython: prints every byte that goes over the line.

Usage: micropython microcontroller_scenario.py FOLDER_OF_FIRMWARE FOLDER_OF_THIS_FILE
"""

import sys

sys.path[:0] = sys.argv[1:3]

from generator import Generator  # noqa: E402
from lines import WATCHED, Line  # noqa: E402
from scripted_chip import ScriptedChip  # noqa: E402
from serial_messages import check_sum  # noqa: E402


def draws(seed):
    """Numbers that look random and are the same everywhere."""
    while True:
        seed = (seed * 1103515245 + 12345) & 0x7FFFFFFF
        yield seed >> 8


def command(operation, tag, address, value):
    """Bytes of a command."""
    body = bytes([0xA5, operation, tag, address]) + value.to_bytes(4, "little")
    return body + check_sum(body).to_bytes(2, "little")


def main():
    """Print the replies and the records."""
    chip = ScriptedChip([Line(**settings) for _, _, _, settings in WATCHED])
    generator = Generator(chip)
    draw = draws(5)
    addresses = list(range(0x17)) + list(range(0x20, 0x33)) + [0x10] * 4
    for number in range(600):
        value = (0, 1, 2, 3, 8, 100, 116, 255, 0x7FFFFFFF, 0xFFFFFFFF)[next(draw) % 10]
        address = addresses[next(draw) % len(addresses)]
        if address in (0x10, 0x2A) and value > 1:
            value = 3 if address == 0x10 else 100
        data = command(next(draw) % 3, number & 255, address, value)
        if number % 7 == 0:
            data = data[: next(draw) % 10] + bytes([next(draw) & 0x7F])
        print(generator.receive(data, number * 30).hex())
    for address, value in (
        (0x10, 3),
        (0x20, 8),
        (0x21, 99),
        (0x28, 20),
        (0x29, 100),
        (0x2A, 700),
        (0x2B, 30),
        (0x30, 0),
        (0x31, 0x7F),
        (0x32, 3),
    ):
        print(generator.receive(command(1, 1, address, value), 10**6).hex())
    chip._count = 2**47 + 2**31 - 5000
    chip.edges = [(chip._count + 300 + 17 * k, 2 + next(draw) % 4, k >> 2 & 1) for k in range(400)]
    for value in (1, 2):
        print(generator.receive(command(1, 2, 0x10, value), 10**6 + 1).hex())
    for look in range(4000):
        generator.work()
        if look % 50 == 0:
            print(generator.next_record().hex())
    for address in (0x11, 0x12, 0x13, 0x14, 0x15, 0x16):
        print(generator.receive(command(0, 3, address, 0), 10**6 + 2).hex())
    print(generator.receive(command(1, 3, 0x10, 3), 10**6 + 2).hex())
    record = generator.next_record()
    while record:
        print(record.hex())
        record = generator.next_record()


main()
