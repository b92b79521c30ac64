"""A simulated chopper controller: the dialect of the MC2000B on its line, and a wheel that takes time to lock."""

import random
from dataclasses import dataclass
from typing import final

from irtiming.units import plain_integer

CLOCK_HZ = 1_000_000
IDENTITY = "THORLABS MC2000B Optical Chopper 1.10"
_LATENCY_CYCLES = 10_000
_LOCKED = 1e-3
_MOST_OF_A_COMMAND = 64
_TWO_TRACKS = {0: (2, 100), 6: (2, 100), 7: (2, 10)}  # slots of the outer and the inner track
_ONE_TRACK = {1: 10, 2: 15, 3: 30, 4: 60, 5: 100, 8: 6, 9: 10}
_HIGHEST = {
    "freq": 10_000, "blade": 14, "ref": 3, "output": 4, "nharmonic": 15, "dharmonic": 15, "phase": 360, "enable": 1,
    "oncycle": 50, "intensity": 10, "verbose": 1,
}  # fmt: skip
_LOWEST = {"freq": 1, "nharmonic": 1, "dharmonic": 1, "oncycle": 1, "intensity": 1}
_AT_REST_ONLY = ("blade", "ref", "output", "nharmonic", "dharmonic")


@final
@dataclass(kw_only=True)
class ChopperFaults:
    """What may go wrong on the line, and may be changed while it is served.

    ``garbled`` is the share of the bytes sent that come to harm, ``lost`` that of the replies that never come.
    """

    garbled: float = 0.0
    lost: float = 0.0
    is_silent: bool = False
    knows_locked: bool = True


@final
class SimulatedChopper:
    """Controller as it comes out of its box: internal reference, at rest. `gateware.pseudo_terminal` may serve it.

    Parameters
    ----------
    blade
        Number of the blade that is set.
    identity
        What it says of itself.
    run_up_s
        Time from rest to lock.
    seed
        Of the faults that happen by chance.
    faults
        Of the line.
    """

    def __init__(
        self, *, blade: int = 0, identity: str = IDENTITY, run_up_s: float = 5.0, seed: int = 0,
        faults: ChopperFaults | None = None,
    ) -> None:  # fmt: skip
        self.faults = faults or ChopperFaults()
        self.broken_rules: list[str] = []
        self._identity = identity
        self._run_up_cycles = max(1.0, run_up_s * CLOCK_HZ)
        self._random = random.Random(seed)
        self._values = dict.fromkeys(_HIGHEST, 0) | {"freq": 100, "blade": blade, "nharmonic": 1, "dharmonic": 1}
        self._values |= {"oncycle": 50, "intensity": 10}
        self._reference_hz = 0.0
        self._off, self._admits = 0.0, True
        self._ramp = (0, 0.0, 0.0)
        self._cycle = 0
        self._heard = bytearray()
        self._due: list[tuple[int, bytes]] = []

    @property
    def clock_frequency_hz(self) -> int:
        """Of the time in which it lives."""
        return CLOCK_HZ

    @property
    def reference_hz(self) -> float:
        """Frequency at its reference input, Hz; 0 where nothing is plugged in. It is set by whoever drives the line."""
        return self._reference_hz

    @reference_hz.setter
    def reference_hz(self, frequency_hz: float) -> None:
        """The wheel goes on as fast as it was and makes for the new frequency."""
        before, self._reference_hz = self._asked_hz(), frequency_hz
        now = self._asked_hz()
        if before > 0 and now > 0:
            self._ramp = (self._cycle, self.relative_speed * before / now, self._ramp[2])
        self._steer()

    @property
    def is_enabled(self) -> bool:
        """Whether the wheel was switched on."""
        return bool(self._values["enable"])

    @property
    def settings(self) -> dict[str, int]:
        """All that can be set, by its word in the manual."""
        return dict(self._values)

    @property
    def relative_speed(self) -> float:
        """Speed of the wheel over that which its reference asks for, now: 0 at rest, 1 when locked."""
        return self._speed_at(self._cycle)

    @property
    def rotation_hz(self) -> float:
        """Turns of the wheel in a second, now."""
        slots = self._followed_slots()
        return self.relative_speed * self._asked_hz() / slots if slots else 0.0

    def relative_speed_at(self, time_s: float) -> float:
        """Speed of the wheel over that which its reference asks for.

        Parameters
        ----------
        time_s
            Of the device, not before its last command or fault.
        """
        return self._speed_at(round(time_s * CLOCK_HZ))

    def lose_lock(self, off: float, *, admits: bool = True) -> None:
        """Let the wheel run beside its reference.

        Parameters
        ----------
        off
            By which part of the speed; 0 brings the lock back.
        admits
            Whether ``locked?`` tells.
        """
        self._off, self._admits = off, admits
        self._steer()

    def exchange(self, received: bytes, *, until_cycle: int) -> bytes:
        """Take bytes of the computer at this cycle, run to another one, and give the bytes sent meanwhile.

        Parameters
        ----------
        received
            Any number of bytes.
        until_cycle
            Where to stop; a cycle in the past changes nothing.
        """
        for byte in received:
            self._hear(byte)
        self._cycle = max(self._cycle, until_cycle)
        sent = b"".join(data for cycle, data in self._due if cycle <= self._cycle)
        self._due = [(cycle, data) for cycle, data in self._due if cycle > self._cycle]
        return b"" if self.faults.is_silent else self._harmed(sent)

    def _hear(self, byte: int) -> None:
        """Echo a byte; at a carriage return, obey. A reply that was not yet sent is lost: it was asked too soon."""
        if byte != ord("\r"):
            self._heard = (self._heard + bytes([byte]))[-_MOST_OF_A_COMMAND:]
            self._due.append((self._cycle, bytes([byte])))
            return
        command = self._heard.decode("latin-1").strip().lower()
        self._heard.clear()
        is_lost = self._random.random() < self.faults.lost
        if any(cycle > self._cycle for cycle, _ in self._due):
            self.broken_rules.append(f"{command!r} before the prompt")
            self._due = [(cycle, data) for cycle, data in self._due if cycle <= self._cycle]
        answer = self._answer(command)
        reply = "\r" + (answer + "\r" if answer else "") + "> "
        if not is_lost:
            self._due.append((self._cycle + _LATENCY_CYCLES, reply.encode()))

    def _answer(self, command: str) -> str:
        measured = {
            "id": self._identity,
            "input": f"{round(self._reference_hz, 2):g}",
            "refoutfreq": f"{round(self._output_hz(), 2):g}",
            "locked": str(int(self._says_locked())),
        }
        if not command:
            return ""
        if command.endswith("?"):
            word = command[:-1]
            if word == "locked" and not self.faults.knows_locked:
                return "Command error CMD_NOT_DEFINED"
            if word in measured:
                return measured[word]
            return str(self._values[word]) if word in self._values else "Command error CMD_NOT_DEFINED"
        word, sign, number = command.partition("=")
        if word not in self._values or not sign:
            return "Command error CMD_NOT_DEFINED"
        return self._set(word, number)

    def _set(self, word: str, number: str) -> str:
        wanted = plain_integer(number)
        if wanted is None or not _LOWEST.get(word, 0) <= wanted <= self._highest(word):
            return "Command error CMD_ARG_RANGE_ERR"
        if word in _AT_REST_ONLY and self.is_enabled:
            self.broken_rules.append(f"{word} while the wheel turns")
            return ""  # not taken, which only reading it back reveals
        self._values[word] = wanted
        if word == "blade":
            self._values |= {"ref": 0, "output": 0}
        self._steer()
        return ""

    def _highest(self, word: str) -> int:
        if word == "ref":
            return 3 if self._values["blade"] in _TWO_TRACKS else 1
        if word == "output" and self._values["blade"] < 10:
            return 2 if self._values["blade"] in _TWO_TRACKS else 1
        return _HIGHEST[word]

    def _followed_slots(self) -> int:
        """Slots of the track that follows the reference."""
        tracks = _TWO_TRACKS.get(self._values["blade"])
        return tracks[self._values["ref"] % 2] if tracks else _ONE_TRACK.get(self._values["blade"], 0)

    def _asked_hz(self) -> float:
        """Frequency of slots that the wheel must come to."""
        external = 2 if self._values["blade"] in _TWO_TRACKS else 1
        if self._values["ref"] < external:
            return float(self._values["freq"])
        return self._reference_hz * self._values["nharmonic"] / self._values["dharmonic"]

    def _output_hz(self) -> float:
        if self._values["output"] == 0:
            return self._asked_hz()
        tracks = _TWO_TRACKS.get(self._values["blade"])
        return self.rotation_hz * (tracks[self._values["output"] - 1] if tracks else self._followed_slots())

    def _says_locked(self) -> bool:
        is_near = abs(self.relative_speed - 1.0) < _LOCKED
        return self.is_enabled and (is_near or not self._admits)

    def _speed_at(self, cycle: int) -> float:
        begun, speed, target = self._ramp
        step = max(0, cycle - begun) / self._run_up_cycles
        return target if abs(target - speed) <= step else speed + (step if target > speed else -step)

    def _steer(self) -> None:
        """Make for the speed that settings, reference and faults ask for, from the one that the wheel has."""
        target = 1.0 + self._off if self.is_enabled and self._asked_hz() > 0 else 0.0
        if target != self._ramp[2]:
            self._ramp = (self._cycle, self.relative_speed, target)

    def _harmed(self, data: bytes) -> bytes:
        share = self.faults.garbled
        if not share:
            return data
        return bytes(self._random.randrange(256) if self._random.random() < share else byte for byte in data)
