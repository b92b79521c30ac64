"""The whole simulated rig at its ports: trigger generator, chopper, blackbody and camera, each over its own protocol."""

import random
from contextlib import ExitStack
from dataclasses import dataclass, replace
from threading import Event
from types import TracebackType
from typing import Literal, Self, final

from irtiming.gateware.model_device import ModelDevice
from irtiming.gateware.pseudo_terminal import PseudoTerminal
from irtiming.twin.devices.blackbody import BlackbodyFaults, SimulatedBlackbody
from irtiming.twin.devices.camera_faults import CameraFaults
from irtiming.twin.devices.chopped_wheel import ChoppedWheel
from irtiming.twin.devices.chopper import ChopperFaults, SimulatedChopper
from irtiming.twin.devices.free_strobe import FreeStrobe
from irtiming.twin.devices.gige_camera import CameraTraits, GigeCamera
from irtiming.twin.devices.network_port import TcpPort, UdpPort
from irtiming.twin.driven_wheel import DrivenWheel
from irtiming.twin.live_camera import LiveCamera
from irtiming.twin.rig import SimulatedRig

BlackbodyPort = Literal["tcp", "udp", "serial"]


@final
@dataclass(frozen=True, kw_only=True)
class Workplace:
    """Where a simulated rig stands, and how it behaves.

    ``speed`` is seconds of the rig in one of the user's. ``run_up_s`` is what the chopper needs from rest to lock,
    ``settling_s`` the blackbody's time constant, both in seconds of the rig.
    """

    camera_address: str = "127.0.0.2"
    blackbody_port: BlackbodyPort = "tcp"
    clock_frequency_hz: int = 48_000_000
    speed: float = 1.0
    run_up_s: float = 5.0
    settling_s: float = 60.0
    seed: int = 1


@final
@dataclass(kw_only=True)
class LineFaults:
    """What happens to bytes on the trigger generator's line, both ways; may be changed while it is served."""

    garbled: float = 0.0
    lost: float = 0.0
    is_silent: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        """Chance of its own."""
        self._random = random.Random(self.seed)

    def harmed(self, data: bytes) -> bytes:
        """What arrives of bytes.

        Parameters
        ----------
        data
            As they were sent.
        """
        if self.is_silent:
            return b""
        if not (self.garbled or self.lost):
            return data
        kept = (byte for byte in data if self._random.random() >= self.lost)
        return bytes(self._random.randrange(256) if self._random.random() < self.garbled else byte for byte in kept)


@final
class Bench:
    """All devices of a rig, served while its ``with`` block runs.

    Parameters
    ----------
    rig
        With its defects; its kind of camera is the one that is served. If that may run free, its strobe drives the generator's
        camera input, and its stamps are as late as its scene says.
    place
        Where, and how fast.

    Raises
    ------
    InstrumentError
        If the camera's address is in use.
    GatewareError
        On a system without pseudo-terminals.
    """

    def __init__(self, rig: SimulatedRig, *, place: Workplace | None = None) -> None:
        self.place = place or Workplace()
        place, scene = self.place, rig.scene
        self.chopper = SimulatedChopper(run_up_s=place.run_up_s, seed=place.seed)
        self.blackbody = SimulatedBlackbody(
            temperature_k=scene.radiance.blackbody_k, time_constant_s=place.settling_s, seed=place.seed
        )
        self.line = LineFaults(seed=place.seed)
        clock = place.clock_frequency_hz
        wheel = DrivenWheel(scene, clock_frequency_hz=clock, seed=place.seed)
        self.view = LiveCamera(
            scene,
            wheel,
            clock_frequency_hz=clock,
            seed=place.seed,
            blackbody_k=lambda cycle: self.blackbody.temperature_k,
        )
        slots = len(scene.wheel.control_slot_errors_rad)
        chopped = ChoppedWheel(wheel, self.chopper, clock_frequency_hz=clock, control_slots=slots)
        free, self._traits = scene.free, CameraTraits(speed=place.speed)
        if free is not None:
            self._traits = replace(self._traits, stamp_after_s=free.stamp_after_s, stamp_jitter_s=free.stamp_jitter_s)
        self.generator = ModelDevice(
            chopped
            if free is None
            else FreeStrobe(chopped, self.view, free=free, clock_frequency_hz=clock, seed=place.seed),
            camera=self.view,
            clock_frequency_hz=clock,
        )
        self._stack, self._is_over = ExitStack(), Event()
        self._addresses: dict[str, str] = {}
        self._generator_port: PseudoTerminal | None = None
        self._camera: GigeCamera | None = None

    @property
    def addresses(self) -> dict[str, str]:
        """Address of each device as plan.toml names it in its section ``devices``, with the speed."""
        return dict(self._addresses)

    @property
    def camera(self) -> GigeCamera:
        """At its address; only inside the ``with`` block."""
        if self._camera is None:
            raise RuntimeError("the bench is not served yet; use it inside its with block")
        return self._camera

    @property
    def faults(self) -> dict[str, CameraFaults | ChopperFaults | BlackbodyFaults | LineFaults]:
        """What goes wrong, by device; to be changed at any time."""
        return {
            "camera": self.camera.faults,
            "chopper": self.chopper.faults,
            "blackbody": self.blackbody.faults,
            "generator": self.line,
        }

    def serve(self, duration_s: float | None = None) -> None:
        """Go on serving for so long, or for ever.

        Parameters
        ----------
        duration_s
            In this computer's time.
        """
        self._is_over.wait(duration_s)

    def end(self) -> None:
        """Let `serve` return."""
        self._is_over.set()

    def unplug_generator(self) -> None:
        """Take the trigger generator's port away under its user's hands."""
        if self._generator_port is not None:
            self._generator_port.unplug()

    def __enter__(self) -> Self:
        speed, enter = self.place.speed, self._stack.enter_context
        try:
            enter(self.view)
            self._camera = enter(GigeCamera(self.view, self.place.camera_address, traits=self._traits))
            chopper = enter(PseudoTerminal(self.chopper, speed=speed))
            self._generator_port = enter(
                PseudoTerminal(self.generator, speed=speed, to_device=self.line.harmed, to_computer=self.line.harmed)
            )
            blackbody = self._serve_blackbody()
        except BaseException:
            self._stack.close()
            raise
        self._addresses = {
            "camera": f"gige:{self.place.camera_address}",
            "trigger_generator": self._generator_port.path,
            "chopper": f"mc2000b:{chopper.path}?speed={speed:g}",
            "blackbody": f"sr800r:{blackbody}&speed={speed:g}"
            if "?" in blackbody
            else f"sr800r:{blackbody}?speed={speed:g}",
        }
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)

    def _serve_blackbody(self) -> str:
        """Port as its driver wants it."""
        speed = self.place.speed
        if self.place.blackbody_port == "serial":
            return self._stack.enter_context(PseudoTerminal(self.blackbody, speed=speed)).path
        if self.place.blackbody_port == "udp":
            udp = self._stack.enter_context(UdpPort(self.blackbody, speed=speed, reply_port=0))
            return f"udp:{udp.host}:{udp.port}?reply_port=0"
        tcp = self._stack.enter_context(TcpPort(self.blackbody, speed=speed))
        return f"tcp:{tcp.host}:{tcp.port}"
