"""Blackbodies by their address: drivers of this package and of others, under the entry points ``irtiming.blackbodies``."""

from contextlib import AbstractAsyncContextManager

from irtiming.instruments.device_address import BLACKBODIES, connect
from irtiming.instruments.protocols import Blackbody


def open_blackbody(address: str) -> AbstractAsyncContextManager[Blackbody]:
    """Blackbody at an address, for the length of an ``async with`` block.

    Parameters
    ----------
    address
        Such as ``"sr800r:/dev/ttyS0"`` or ``"sr800r:tcp:192.168.0.5:5200"``.

    Raises
    ------
    InstrumentError
        If no driver has its scheme.
    """
    return connect(BLACKBODIES, address)
