"""The compiled circuit as a device on a line, with a wheel that follows its chopper output."""

from typing import final

import numpy as np

from irtiming.gateware.compiled import CompiledCircuit
from irtiming.gateware.event_model import PinChanges
from irtiming.gateware.messages import BITS_PER_BYTE
from irtiming.gateware.model_device import Wheel


@final
class CompiledDevice:
    """Implements `SimulatedDevice`.

    Parameters
    ----------
    circuit
        Just after its reset.
    wheel
        What its inputs see; None: nothing.
    clock_frequency_hz
        That the circuit was made for.
    """

    def __init__(self, circuit: CompiledCircuit, wheel: Wheel | None = None, *, clock_frequency_hz: int) -> None:
        self._circuit = circuit
        self._wheel = wheel
        self._clock_frequency_hz = clock_frequency_hz
        self._line_free = 0
        self._last_pulse: int | None = None
        self._slot_period = 0

    @property
    def clock_frequency_hz(self) -> int:
        """Of the counter."""
        return self._clock_frequency_hz

    def exchange(self, received: bytes, *, until_cycle: int) -> bytes:
        """Take bytes of the computer, run until the counter is at least ``until_cycle``, and give the bytes sent."""
        now = self._circuit.cycle
        begin = max(now + 1, self._line_free)
        if received:
            self._line_free = begin + len(received) * BITS_PER_BYTE * self._circuit.bit_cycles
        until = max(until_cycle, self._line_free, now)
        inputs = {} if self._wheel is None else self._wheel.turn(until, slot_period_cycles=self._slot_period)
        outcome = self._circuit.run(until, inputs=inputs, commands={begin: received} if received else {})
        self._follow(outcome.chopper_out)
        return outcome.line

    def _follow(self, chopper: PinChanges) -> None:
        """Take the period of the reference from its pulses, as a chopper does."""
        pulses = chopper.cycle[chopper.level == 1]
        if self._last_pulse is not None:
            pulses = np.append(self._last_pulse, pulses)
        if pulses.size > 1:
            self._slot_period = int(pulses[-1] - pulses[-2])
        if pulses.size:
            self._last_pulse = int(pulses[-1])
