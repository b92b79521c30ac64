"""Which GigE Vision cameras answer: all in the networks of this computer, and at addresses that are named."""

import socket
import struct
import time
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from select import select

from pyGigEVision import discover

from irtiming.instruments.genicam.gige_control import GVCP_PORT
from irtiming.records.camera_frame import CameraIdentity

_REQUEST = struct.pack(">BBHHH", 0x42, 0x11, 0x0002, 0, 0xFFFF)  # harmless: a camera answers and changes nothing
_ANSWER, _HEADER_BYTES, _ANSWER_BYTES = 0x0003, 8, 248
_VENDOR, _MODEL, _FIRMWARE, _SERIAL = slice(72, 104), slice(104, 136), slice(136, 168), slice(216, 232)


def answering(*, hosts: Sequence[str] = (), timeout_s: float = 1.0) -> list[CameraIdentity]:
    """Cameras that answer a broadcast on every network, or a request at their own address.

    Parameters
    ----------
    hosts
        Addresses to ask besides, such as of a camera behind a router, or of this computer itself.
    timeout_s
        For the answers.

    Returns
    -------
    Each camera once, in the order of the addresses.
    """
    found = {camera.address: camera for camera in _asked(hosts, timeout_s)}
    for entry in discover(timeout=timeout_s):
        camera = CameraIdentity(
            vendor=entry["manufacturer"],
            model=entry["model"],
            serial_number=entry["serial"],
            firmware=entry["device_version"],
            address=f"gige:{entry['ip']}",
        )
        found.setdefault(camera.address, camera)
    return [found[address] for address in sorted(found)]


def _asked(hosts: Sequence[str], timeout_s: float) -> list[CameraIdentity]:
    """Each from a socket of its own: an answer comes from the address that was asked."""
    cameras = []
    with ExitStack() as stack:
        asked = {}
        for host in hosts:
            opened = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            with suppress(OSError):
                opened.sendto(_REQUEST, (host, GVCP_PORT))
                asked[opened] = host
        until = time.monotonic() + timeout_s
        while asked and (left := until - time.monotonic()) > 0:
            for ready in select(list(asked), [], [], left)[0]:
                with suppress(OSError):
                    answer, (address, _) = ready.recvfrom(4096)
                    camera = _identity(answer, address)
                    if camera is not None:
                        cameras.append(camera)
                        del asked[ready]
    return cameras


def _identity(answer: bytes, address: str) -> CameraIdentity | None:
    if len(answer) < _HEADER_BYTES + _ANSWER_BYTES or int.from_bytes(answer[2:4], "big") != _ANSWER:
        return None
    content = answer[_HEADER_BYTES:]

    def text(place: slice) -> str:
        return content[place].split(b"\0")[0].decode("ascii", errors="replace").strip()

    return CameraIdentity(
        vendor=text(_VENDOR),
        model=text(_MODEL),
        serial_number=text(_SERIAL),
        firmware=text(_FIRMWARE),
        address=f"gige:{address}",
    )
