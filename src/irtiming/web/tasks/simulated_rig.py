"""The simulated rig, served in a process of its own for as long as it is wanted."""

from dataclasses import replace
from typing import Any

from irtiming.errors import InstrumentError
from irtiming.session.served_rig import ServedOrder, served
from irtiming.web.work import LEAVE, Line

_ADDRESSES = tuple(f"127.0.0.{last}" for last in range(2, 30))
_POLL_S = 0.2


def serve_rig(line: Line, order: ServedOrder) -> dict[str, Any]:
    """Serve a rig at the first address that is free, until it is no longer wanted.

    Raises
    ------
    InstrumentError
        If no address is free.
    """
    for address in _ADDRESSES:
        try:
            _serve(line, replace(order, place=replace(order.place, camera_address=address)))
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
