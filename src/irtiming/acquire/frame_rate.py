"""Whether a camera can follow its triggers, by what it says of itself as it is set."""

from collections.abc import Mapping

from irtiming.errors import InstrumentError
from irtiming.instruments.protocols import Camera
from irtiming.records.trigger_plan import TriggerPlan

_READOUT_FEATURES = ("ResultingFrameRate", "AcquisitionResultingFrameRate")


async def complaint(camera: Camera, triggers: TriggerPlan) -> str | None:
    """What stands against the triggers; None where nothing does, or the camera does not say how fast it can be."""
    fastest_hz, shortest_s = await _fastest_hz(camera), triggers.shortest_period_s
    if fastest_hz is None or shortest_s * fastest_hz >= 1 - 1e-9:
        return None
    return (
        f"{camera.name} makes {fastest_hz:.6g} frames per second at most as it is set, the plan asks for {1 / shortest_s:.6g}; "
        "plan a lower frame rate, or a smaller window"
    )


async def is_set(camera: Camera, features: Mapping[str, str]) -> bool:
    """Whether the camera's features have these values already, so that what it says of itself holds for them."""
    try:
        return all([_is_same(await camera.feature(name), value) for name, value in features.items()])
    except InstrumentError:
        return False


def _is_same(one: str, other: str) -> bool:
    try:
        return float(one) == float(other)
    except ValueError:
        return one == other


async def _fastest_hz(camera: Camera) -> float | None:
    for name in _READOUT_FEATURES:
        try:
            return float(await camera.feature(name))
        except (InstrumentError, ValueError):
            continue
    return None
