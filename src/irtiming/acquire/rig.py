"""The devices of a rig while they are connected, and how fast its time goes."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from typing import final

from irtiming.errors import InstrumentError, UnitError
from irtiming.gateware.register_map import Channel, Polarity
from irtiming.instruments.device_address import BLACKBODIES, CAMERAS, CHOPPERS, connect
from irtiming.instruments.generator.register_link import Patience
from irtiming.instruments.generator.trigger_generator import Wiring, connected
from irtiming.instruments.protocols import Blackbody, Camera, Chopper, TriggerGenerator
from irtiming.records.series_plan import DeviceAddresses, SeriesPlan, WiringWishes

_POLL_S = 0.2
_REPLY_OF_A_PROGRAM_S = 2.0  # a simulated generator shares a computer that may be busy


@final
@dataclass(frozen=True, kw_only=True)
class Rig:
    """Connected devices. ``speed`` is seconds of the rig per second of this computer: other than 1 for a simulated one."""

    generator: TriggerGenerator
    camera: Camera
    chopper: Chopper | None = None
    blackbody: Blackbody | None = None
    speed: float = 1.0

    @property
    def poll_s(self) -> float:
        """How often, in this computer's time, the devices are asked how far they are."""
        return _POLL_S / max(self.speed, 1.0)

    def host_s(self, rig_s: float) -> float:
        """Time of this computer that a time of the rig takes."""
        return rig_s / self.speed


@final
class RigNotReady(InstrumentError):  # noqa: N818 - says what the rig is
    """A rig that cannot begin, its devices not connected or not as they must be: ``complaints`` has one line for each."""

    def __init__(self, complaints: list[str]) -> None:
        super().__init__("; ".join(complaints))
        self.complaints = complaints


@asynccontextmanager
async def connected_rig(plan: SeriesPlan) -> AsyncIterator[Rig]:
    """All devices of a plan, for the length of an ``async with`` block; connecting moves and heats nothing.

    Raises
    ------
    RigNotReady
        If any cannot be connected; every one is tried, and each complaint reported.
    """
    places, complaints, found = plan.devices, [], {}
    async with AsyncExitStack() as stack:
        for name, address in _addresses(places):
            try:
                if name == "generator":
                    device: object = await stack.enter_async_context(_generator(address, plan))
                else:
                    device = await stack.enter_async_context(connect(_GROUPS[name], address))
            except InstrumentError as error:
                complaints.append(str(error))
            else:
                found[name] = device
        if complaints:
            raise RigNotReady(complaints)
        yield Rig(**found, speed=places.speed)  # type: ignore[arg-type]


@asynccontextmanager
async def _generator(address: str, plan: SeriesPlan) -> AsyncIterator[TriggerGenerator]:
    """The trigger generator with the wiring of the plan; a filter is set in cycles, so the clock must be known first."""
    reply_s = Patience.reply_s if plan.devices.speed == 1 else _REPLY_OF_A_PROGRAM_S
    patience = Patience(poll_s=_POLL_S / max(plan.devices.speed, 1.0), reply_s=reply_s)
    clock_hz = 1
    if plan.wiring.glitch_filter_s > 0:
        async with connected(address, patience=patience) as unwired:
            clock_hz = unwired.clock_frequency_hz
    async with connected(
        address, wiring=wiring_of(plan.wiring, clock_frequency_hz=clock_hz), patience=patience
    ) as wired:
        yield wired


def wiring_of(wishes: WiringWishes, *, clock_frequency_hz: int) -> Wiring:
    """Wiring for the trigger generator's driver.

    Raises
    ------
    UnitError
        If a line is named that there is not.
    """
    edges = Polarity(0)
    for name in wishes.falling:
        if name.upper() not in Polarity.__members__:
            lines = ", ".join(Polarity.__members__).lower()
            raise UnitError(f"{{falling}} '{name}' is no line; name one of {lines}", "falling")
        edges |= Polarity[name.upper()]
    return Wiring(
        falling_edges=edges,
        filter_cycles=round(wishes.glitch_filter_s * clock_frequency_hz),
        camera_pulse_s=wishes.camera_pulse_s,
        also_recorded=(Channel.CAMERA_INPUT if wishes.camera_input else Channel(0))
        | (Channel.SPARE if wishes.spare else Channel(0)),
    )


_GROUPS = {"camera": CAMERAS, "chopper": CHOPPERS, "blackbody": BLACKBODIES}


def _addresses(places: DeviceAddresses) -> list[tuple[str, str]]:
    """Devices in the order in which they are connected."""
    wanted = [
        ("generator", places.trigger_generator),
        ("camera", places.camera),
        ("chopper", places.chopper),
        ("blackbody", places.blackbody),
    ]
    return [(name, address) for name, address in wanted if address is not None]
