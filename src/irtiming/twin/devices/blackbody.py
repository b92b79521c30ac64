"""A simulated blackbody: the texts of the SR-800R on its line, and a temperature that settles."""

import math
import random
from dataclasses import dataclass
from typing import final

CLOCK_HZ = 1_000_000
_LATENCY_CYCLES = 30_000
_GAP_CYCLES = 290_000  # nearer messages are not heard; its manual asks for 300 ms
_ICE_K = 273.15
_LOWEST_DEGC, _HIGHEST_DEGC = -40.0, 175.0
_NEAR_K = 0.02
_STEADY_S = 5.0
"""It says that it is stable when it was near its target for so long."""


@final
@dataclass(kw_only=True)
class BlackbodyFaults:
    """What may go wrong, and may be changed while it is served.

    ``garbled`` is the share of the bytes sent that come to harm, ``lost`` that of the replies that never come.
    ``bit_error`` is what its self-test reports in place of OK. ``is_binary`` makes it an SR-800N.
    """

    garbled: float = 0.0
    lost: float = 0.0
    is_silent: bool = False
    is_never_stable: bool = False
    is_binary: bool = False
    bit_error: str = ""


@final
class SimulatedBlackbody:
    """Blackbody that rests at a temperature. A port of `network_port` or a pseudo-terminal may serve it.

    Parameters
    ----------
    temperature_k
        At first, and its target then.
    time_constant_s
        With which it settles.
    seed
        Of the faults that happen by chance.
    faults
        Of the line and the unit.
    """

    def __init__(
        self, *, temperature_k: float = 298.15, time_constant_s: float = 60.0, seed: int = 0,
        faults: BlackbodyFaults | None = None,
    ) -> None:  # fmt: skip
        self.faults = faults or BlackbodyFaults()
        self.too_early = 0
        self._time_constant_s = time_constant_s
        self._random = random.Random(seed)
        self._target_k = temperature_k
        self._course = (-math.inf, 0.0)
        self._cycle = 0
        self._heard = bytearray()
        self._heard_at = -_GAP_CYCLES
        self._due: list[tuple[int, bytes]] = []

    @property
    def clock_frequency_hz(self) -> int:
        """Of the time in which it lives."""
        return CLOCK_HZ

    @property
    def target_k(self) -> float:
        """Temperature that it goes to, K."""
        return self._target_k

    @property
    def temperature_k(self) -> float:
        """Temperature now, K."""
        begun_s, distance_k = self._course
        return self._target_k + distance_k * math.exp(-(self._now_s() - begun_s) / self._time_constant_s)

    @property
    def is_stable(self) -> bool:
        """Whether it was near its target for some seconds."""
        begun_s, distance_k = self._course
        far = abs(distance_k) / _NEAR_K
        near_s = begun_s + (self._time_constant_s * math.log(far) if far > 1 else 0.0)
        return not self.faults.is_never_stable and self._now_s() >= near_s + _STEADY_S

    def exchange(self, received: bytes, *, until_cycle: int) -> bytes:
        """Take bytes of the computer at this cycle, run to another one, and give the bytes sent meanwhile.

        Parameters
        ----------
        received
            Any number of bytes.
        until_cycle
            Where to stop; a cycle in the past changes nothing.
        """
        self._heard += received
        while b"\r" in self._heard:
            message, _, self._heard = self._heard.partition(b"\r")
            self._hear(message.decode("latin-1").strip())
        self._cycle = max(self._cycle, until_cycle)
        sent = b"".join(data for cycle, data in self._due if cycle <= self._cycle)
        self._due = [(cycle, data) for cycle, data in self._due if cycle > self._cycle]
        return b"" if self.faults.is_silent else self._harmed(sent)

    def _now_s(self) -> float:
        return self._cycle / CLOCK_HZ

    def _hear(self, message: str) -> None:
        is_early, self._heard_at = self._cycle - self._heard_at < _GAP_CYCLES, self._cycle
        if is_early:
            self.too_early += 1
            return
        if self.faults.is_binary:
            reply = binary_message(b"\x06\x07\xf1\x00\x04\x42\xc8\x00\x00")
        else:
            answer = self._answer(message)
            reply = f"{answer}\r".encode("latin-1") if answer else b""
        if reply and self._random.random() >= self.faults.lost:
            self._due.append((self._cycle + _LATENCY_CYCLES, reply))

    def _answer(self, message: str) -> str:
        """Reply to a message; none to a setting that was taken."""
        word, _, operands = message.partition(" ")
        word = word.upper()
        told = {
            "ECHO": operands,
            "GETTEMPERATURE": f"{self.temperature_k - _ICE_K:.3f}",
            "GETTARGETTEMPERATURE": f"{self._target_k - _ICE_K:.3f}",
            "ISTEMPERATURESTABLE": str(int(self.is_stable)),
            "GETBITERROR": self.faults.bit_error or "OK",
        }
        if word in told:
            return told[word]
        if word == "SETMODE":
            return "" if operands in ("0", "1") else "InvalidOperand"
        return self._set(operands) if word == "SETTEMPERATURE" else "InvalidCommand"

    def _set(self, operand: str) -> str:
        try:
            degc = float(operand)
        except ValueError:
            return "InvalidOperand"
        if not _LOWEST_DEGC <= degc <= _HIGHEST_DEGC:
            return "InvalidOperand"
        temperature_k = self.temperature_k
        self._target_k = degc + _ICE_K
        self._course = (self._now_s(), temperature_k - self._target_k)
        return ""

    def _harmed(self, data: bytes) -> bytes:
        share = self.faults.garbled
        if not share:
            return data
        return bytes(self._random.randrange(256) if self._random.random() < share else byte for byte in data)


def binary_message(content: bytes) -> bytes:
    """Message of an SR-800N: start, length with checksum, content, and a checksum that makes the sum of all zero.

    Parameters
    ----------
    content
        Service and data.
    """
    message = b"\xaa\x01" + (len(content) + 1).to_bytes(2, "big") + content
    return message + bytes([-sum(message) % 256])
