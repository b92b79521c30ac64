"""Cameras by their addresses, and which ones there are."""

from collections.abc import Sequence
from contextlib import AbstractAsyncContextManager

from irtiming.errors import InstrumentError
from irtiming.instruments.device_address import CAMERAS, connect
from irtiming.instruments.protocols import Camera
from irtiming.records.camera_frame import CameraIdentity


def open_camera(address: str) -> AbstractAsyncContextManager[Camera]:
    """Camera at an address, for the length of an ``async with`` block.

    Parameters
    ----------
    address
        Such as ``"gige:192.168.0.7"`` or ``"aravis:192.168.0.7"``.

    Raises
    ------
    InstrumentError
        If the scheme is unknown; on entry, what the driver finds wrong.
    """
    return connect(CAMERAS, address)


def find(*, hosts: Sequence[str] = (), timeout_s: float = 1.0) -> tuple[list[CameraIdentity], list[str]]:
    """Cameras that answer, and why a kind of camera could not be looked for.

    Only requests that ask who is there are sent; no camera is opened.

    Parameters
    ----------
    hosts
        Addresses to ask besides the broadcast in every network.
    timeout_s
        For the answers.

    Returns
    -------
    cameras
        Each with the address for a plan; one of GigE Vision is listed under ``gige:``.
    complaints
        One line each.
    """
    cameras: list[CameraIdentity] = []
    complaints: list[str] = []
    network_is_known = False
    try:
        from irtiming.instruments.genicam.gige_discovery import answering

        cameras += answering(hosts=hosts, timeout_s=timeout_s)
        network_is_known = True
    except ImportError as error:
        complaints.append(f"GigE Vision cameras were not looked for: {error}; pip install 'irtiming[rig]'")
    try:
        from irtiming.instruments.genicam.aravis_camera import listed

        cameras += [camera for protocol, camera in listed() if protocol != "GigEVision" or not network_is_known]
    except (ImportError, InstrumentError) as error:
        complaints.append(f"USB3 Vision cameras were not looked for: {error}")
    return cameras, complaints
