"""The firmware's main loop on standard input and output, with scripted pins; for MicroPython on a computer.

Usage: micropython microcontroller_serve.py FOLDER_OF_FIRMWARE FOLDER_OF_THIS_FILE
"""

import sys

sys.path[:0] = sys.argv[1:3]


class NoChip:
    """In place of chip.py, which needs the real one."""

    Chip = None


sys.modules["chip"] = NoChip

import main  # noqa: E402
from generator import Generator  # noqa: E402
from lines import WATCHED, Line  # noqa: E402
from scripted_chip import ScriptedChip  # noqa: E402

SLOT_COUNTS, FIRST_SLOT, SLOTS = 10_000, 5_037, 1100


class TurningWheel(ScriptedChip):
    """A control slot every SLOT_COUNTS from the first trigger on."""

    def start_train(self, **settings):
        super().start_train(**settings)
        begin = self.first_trigger + FIRST_SLOT
        for k in range(SLOTS):
            self.edges += [(begin + k * SLOT_COUNTS, 2, 1), (begin + k * SLOT_COUNTS + 4000, 2, 0)]
        self.edges.sort()


main.serve(Generator(TurningWheel([Line(**settings) for _, _, _, settings in WATCHED], counts_per_look=400)))
