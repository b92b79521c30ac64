"""From the edges of one line to events: polarity, glitch filter, channels. Runs on MicroPython and on CPython."""

WATCHED = (  # pin, PIO and state machine that time it, and what Line takes; an RP2040 has no PIO 2
    ("camera_nominal", 0, 0, {"channel": 1, "is_filtered": False}),
    ("camera", 0, 1, {"channel": 2, "polarity": 2, "is_filtered": False}),
    ("control", 0, 2, {"channel": 8, "polarity": 8}),
    ("application", 0, 3, {"channel": 16, "other_channel": 32, "polarity": 16}),
    ("camera_input", 2, 0, {"channel": 4, "polarity": 4}),
    ("spare", 2, 1, {"channel": 64, "polarity": 64}),
)


class Line:
    """One watched pin.

    ``channel`` is its bit in a record, ``other_channel`` that of its opposite edge (0: none), ``polarity`` its bit of
    POLARITY (0: never inverted); ``is_filtered`` says if the register FILTER is for this line. ``events`` takes what has
    become certain, as (time, channels).
    """

    def __init__(self, *, channel: int, other_channel: int = 0, polarity: int = 0, is_filtered: bool = True):
        self.channel = channel
        self.is_filtered = is_filtered
        self.events = []
        self._channels = (channel, other_channel)
        self._polarity = polarity
        self._level = 0
        self._since = -1  # when the line took the level that it has not kept long enough yet; -1: it is at rest
        self.set_up(channels=0, polarity=0, filter_counts=0, shift=0)

    def set_up(self, *, channels: int, polarity: int, filter_counts: int, shift: int) -> None:
        """Take the settings: masks of the registers CHANNELS and POLARITY, length of the filter, what to add to times."""
        the_edge, other = self._channels
        rising, falling = (other, the_edge) if polarity & self._polarity else (the_edge, other)
        self._masks = (falling & channels, rising & channels)
        self._filter = filter_counts if self.is_filtered else 0
        self._shift = shift + self._filter

    @property
    def is_recorded(self) -> bool:
        """Whether any of its edges is asked for."""
        return self._masks != (0, 0)

    def edge(self, time: int, level: int) -> None:
        """Take an edge of the pin, and the level after it."""
        if self._since >= 0:
            if time - self._since > self._filter:
                self._accept()
            else:
                self._since = -1
        if level != self._level:
            self._since = time

    def settle(self, until: int) -> None:
        """Take it that the pin kept its level up to the count ``until``."""
        if 0 <= self._since < until - self._filter:
            self._accept()

    def _accept(self):
        self._level = 1 - self._level
        mask = self._masks[self._level]
        if mask:
            self.events.append((self._since + self._shift, mask))
        self._since = -1
