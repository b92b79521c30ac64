"""The simulated rig, served in a process of its own for as long as it is wanted."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from irtiming.errors import InstrumentError
from irtiming.session.served_rig import ServedOrder, served
from irtiming.twin.devices.bench import Workplace
from irtiming.web.orders import RigOrder
from irtiming.web.work import LEAVE, Line

if TYPE_CHECKING:
    from irtiming.records.recording import CameraType, ReadoutMode

_ADDRESSES = tuple(f"127.0.0.{last}" for last in range(2, 30))
_POLL_S, _SETTLING_S = 0.2, 3.0


def serve_rig(line: Line, order: RigOrder) -> dict[str, Any]:
    """Serve a rig at the first address that is free, until it is no longer wanted.

    Raises
    ------
    InstrumentError
        If no address is free.
    """
    place = Workplace(speed=order.speed, seed=order.seed, settling_s=_SETTLING_S)
    wanted = ServedOrder(
        camera=cast("CameraType", order.camera), readout=cast("ReadoutMode", order.readout), rows=order.rows,
        columns=order.columns, folder=order.folder,
    )  # fmt: skip
    for address in _ADDRESSES:
        try:
            _serve(line, replace(wanted, place=replace(place, camera_address=address)))
        except InstrumentError as error:
            if "no other camera is served" not in str(error) or address == _ADDRESSES[-1]:
                raise
        else:
            break
    return {}


def _serve(line: Line, order: ServedOrder) -> None:
    with served(order) as found:
        line.fact("addresses", found.bench.addresses | {"console": str(found.console)})
        line.fact("folder", str(order.folder))
        while not line.hears(LEAVE):
            found.bench.serve(_POLL_S)
