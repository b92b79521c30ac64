"""The wheel on its motor: it follows the chopper's reference as fast and as well as its controller lets it."""

from collections.abc import Mapping
from typing import final

from irtiming.gateware.event_model import PinChanges
from irtiming.gateware.register_map import Channel
from irtiming.twin.devices.chopper import SimulatedChopper
from irtiming.twin.driven_wheel import DrivenWheel

_STEPS = 20
"""Speeds that a wheel takes on its way from rest to lock."""

_EXACT = 1e-9


@final
class ChoppedWheel:
    """Wheel between the trigger generator's reference and its inputs; implements `gateware.model_device.Wheel`.

    Parameters
    ----------
    wheel
        With its slots and edges.
    chopper
        Controller whose reference input the generator drives.
    clock_frequency_hz
        Of the generator.
    control_slots
        Of the inner track.
    """

    def __init__(
        self, wheel: DrivenWheel, chopper: SimulatedChopper, *, clock_frequency_hz: int, control_slots: int = 100
    ) -> None:
        self._wheel, self._chopper = wheel, chopper
        self._clock_hz, self._control_slots = clock_frequency_hz, control_slots
        self._reference_cycles = 0

    def turn(self, until_cycle: int, *, slot_period_cycles: int) -> Mapping[Channel, PinChanges]:
        """Changes of the two light gates from where the last call ended to before ``until_cycle``.

        Parameters
        ----------
        until_cycle
            Where to stop.
        slot_period_cycles
            Of the reference that the generator gives.
        """
        if slot_period_cycles != self._reference_cycles:
            self._reference_cycles = slot_period_cycles
            self._chopper.reference_hz = self._clock_hz / slot_period_cycles if slot_period_cycles else 0.0
        return self._wheel.turn(until_cycle, slot_period_cycles=self._slot_period_cycles())

    def _slot_period_cycles(self) -> int:
        """As the wheel turns now: exactly the reference's once it is locked, 0 at rest."""
        slots_hz = self._chopper.rotation_hz * self._control_slots
        if slots_hz <= 0 or not self._reference_cycles:
            return 0
        relative = slots_hz * self._reference_cycles / self._clock_hz
        if abs(relative - 1) < _EXACT:
            return self._reference_cycles
        if self._chopper.relative_speed < 1 - 1 / _STEPS:
            relative = max(1, round(relative * _STEPS)) / _STEPS
        return round(self._reference_cycles / relative)
