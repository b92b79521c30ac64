"""In place of the microcontroller's chip.py: pins that follow a script, and a clock that goes on with every look.

Runs on CPython and on MicroPython, as the firmware does.
"""


class ScriptedChip:
    """``edges`` are (count, index of the line, level) in rising order; ``calls`` is what was asked of the chip.

    The clock that the chip tells is ``behind`` counts late, as the real one's is.
    """

    def __init__(self, lines, *, counts_per_look=40, behind=7):
        self.counts_per_second = 60_000_000
        self.channels = 0x7F
        self.lines = lines
        self.edges = []
        self.lost = {}
        self.calls = []
        self.first_trigger = None
        self._count = 0
        self._per_look = counts_per_look
        self._behind = behind
        self._train_ends = 0
        self._pulses = []

    def now(self):
        self._count += self._per_look
        return self._count

    def read_edges(self):
        true_count = self._count + self._behind
        while self.edges and self.edges[0][0] <= true_count:
            count, index, level = self.edges.pop(0)
            self.lines[index].edge(count, level)
        lost, self.lost = self.lost, {}
        return [(line, lost.get(index, 0)) for index, line in enumerate(self.lines)]

    def set_chopper(self, *, width, period):
        self.calls.append(("chopper", width, period))

    def set_polarity(self, polarity):
        self.calls.append(("polarity", polarity))

    def start_train(self, *, width, period, count, delay):
        self.calls.append(("train", width, period, count, delay))
        self.first_trigger = self._count + self._behind + 10
        self._pulses = []
        for index, begin in ((0, self.first_trigger), (1, self.first_trigger + delay)):
            for k in range(count):
                self._pulses.append((begin + k * period, begin + k * period + width, index))
        self._train_ends = max(end for _, end, _ in self._pulses)
        self._add(self._pulses)

    def stop_train(self):
        now = self._count + self._behind
        coming = [pulse for pulse in self._pulses if pulse[0] > now]
        gone = [(begin + 1, index, 1) for begin, _, index in coming] + [(end + 1, index, 0) for _, end, index in coming]
        self.edges = [edge for edge in self.edges if edge not in gone]
        self._train_ends = max([end for begin, end, _ in self._pulses if begin <= now] + [0])

    def is_train_over(self):
        return self._count + self._behind >= self._train_ends

    def _add(self, pulses):
        """Edges of own pulses as the chip sees them: one count after the pin."""
        for begin, end, index in pulses:
            self.edges += [(begin + 1, index, 1), (end + 1, index, 0)]
        self.edges.sort()
