"""Choppers by their address: drivers of this package and of others, under the entry points ``irtiming.choppers``."""

from contextlib import AbstractAsyncContextManager

from irtiming.instruments.device_address import CHOPPERS, connect
from irtiming.instruments.protocols import Chopper


def open_chopper(address: str) -> AbstractAsyncContextManager[Chopper]:
    """Chopper at an address, for the length of an ``async with`` block.

    Parameters
    ----------
    address
        Such as ``"mc2000b:/dev/ttyUSB0"``.

    Raises
    ------
    InstrumentError
        If no driver has its scheme.
    """
    return connect(CHOPPERS, address)
