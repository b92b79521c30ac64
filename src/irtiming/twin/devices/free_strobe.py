"""A camera that runs free on the bench: it makes frames as the wheel turns, and its strobe drives the camera input."""

from collections import deque
from collections.abc import Mapping
from typing import Protocol, final

import numpy as np

from irtiming.gateware.event_model import PinChanges
from irtiming.gateware.register_map import Channel
from irtiming.twin.free_running import FreeRunning
from irtiming.twin.live_camera import LiveCamera
from irtiming.twin.noise import generator

_PULSE_S = 1e-3


class _Turned(Protocol):
    """What turns before the camera."""

    def turn(self, until_cycle: int, *, slot_period_cycles: int) -> Mapping[Channel, PinChanges]:
        """Changes of the pins of the light gates."""
        ...


@final
class FreeStrobe:
    """Wheel and strobe between the trigger generator's reference and its inputs; implements `gateware.model_device.Wheel`.

    Parameters
    ----------
    wheel
        With its light gates.
    camera
        That makes frames of its own accord while it is not set to wait for triggers.
    free
        How late its strobe is, and by how much it jitters.
    clock_frequency_hz
        Of the generator.
    seed
        Fixes the jitter.
    """

    def __init__(
        self, wheel: _Turned, camera: LiveCamera, *, free: FreeRunning, clock_frequency_hz: int, seed: int
    ) -> None:
        self._wheel, self._camera, self._free, self._clock_hz = wheel, camera, free, clock_frequency_hz
        self._random = generator(seed, "free camera")
        self._to_come: deque[tuple[int, int]] = deque()  # cycle and level
        camera.is_paced = True

    def turn(self, until_cycle: int, *, slot_period_cycles: int) -> Mapping[Channel, PinChanges]:
        """Changes of light gates and strobe from where the last call ended to before ``until_cycle``.

        Parameters
        ----------
        until_cycle, slot_period_cycles
            As for the wheel.
        """
        begun = self._camera.run_until(until_cycle)
        pins = self._wheel.turn(until_cycle, slot_period_cycles=slot_period_cycles)
        late_s = self._free.strobe_after_s + self._free.strobe_jitter_s * self._random.standard_normal(begun.size)
        for cycle in (begun + np.rint(late_s * self._clock_hz).astype(np.int64)).tolist():
            self._to_come.extend(((cycle, 1), (cycle + round(_PULSE_S * self._clock_hz), 0)))
        due = []
        while self._to_come and self._to_come[0][0] < until_cycle:
            due.append(self._to_come.popleft())
        cycles, levels = np.array(due, dtype=np.int64).reshape(-1, 2).T
        return {**pins, Channel.CAMERA_INPUT: PinChanges(cycle=cycles, level=levels)}
