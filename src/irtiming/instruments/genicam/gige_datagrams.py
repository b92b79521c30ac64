"""Datagrams of one sender from a socket, many at a time: a packet costs far less, and a busy program holds none up."""

import ctypes
import os
import socket
import sys
import time
from typing import Protocol, final

import numpy as np
from numpy.typing import NDArray

_SLOTS = 2048  # with a busy interpreter a call comes every 10 ms
_WAIT_S = 0.02  # for the first datagram
_REST_S = 3e-3  # after a batch, so that the next one is worth a call
_ENOUGH_BYTES = 8 * 2**20  # of the system's queue, to take a rest: at 10 Gbit/s half of it fills meanwhile
_WISHED_BYTES = 16 * 2**20
_NAME_BYTES, _ADDRESS = 16, slice(4, 8)  # of an IPv4 sender
_SO_RCVBUFFORCE, _MSG_WAITFORONE = 33, 0x10000


class Datagrams(Protocol):
    """Datagrams of one sender, in ``packets`` of shape (slot, byte), and their ``lengths``; others' are let go."""

    packets: NDArray[np.uint8]
    lengths: NDArray[np.uint32]

    def receive(self) -> int:
        """Wait a little for datagrams; how many slots are filled now, 0 if none came."""
        ...


def enlarge_queue(opened: socket.socket) -> int:
    """Let the system hold as many datagrams of a socket as it will.

    Parameters
    ----------
    opened
        Of datagrams.

    Returns
    -------
    Bytes of its queue.
    """
    for option in (_SO_RCVBUFFORCE, socket.SO_RCVBUF) if sys.platform == "linux" else (socket.SO_RCVBUF,):
        try:
            opened.setsockopt(socket.SOL_SOCKET, option, _WISHED_BYTES)
            break
        except OSError:  # the first is for administrators only
            continue
    return opened.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)


def datagrams(opened: socket.socket, *, longest: int, sender: str) -> Datagrams:
    """Reader of a socket, in the way that is best on this system.

    Parameters
    ----------
    opened
        Of datagrams.
    longest
        Bytes of a datagram.
    sender
        Address, in numbers, from which they come; what anybody else sends is let go.
    """
    slot_bytes = -(-longest // 64) * 64
    if sys.platform == "linux":
        return ManyAtOnce(opened, slot_bytes=slot_bytes, sender=sender)
    return OneByOne(opened, slot_bytes=slot_bytes, sender=sender)


@final
class OneByOne:
    """For any system: datagrams of one length, up to the first of another."""

    def __init__(self, opened: socket.socket, *, slot_bytes: int, sender: str) -> None:
        opened.settimeout(_WAIT_S)
        self._sender = sender
        self._socket = opened
        self.packets = np.zeros((_SLOTS, slot_bytes), np.uint8)
        self.lengths = np.zeros(_SLOTS, np.uint32)
        self._slots = [slot.data for slot in self.packets]

    def receive(self) -> int:
        """Wait a little for datagrams; how many slots are filled now, 0 if none came."""
        usual = -1
        count = 0
        for _ in self._slots:
            try:
                length, address = self._socket.recvfrom_into(self._slots[count])
            except TimeoutError:
                break
            if address[0] != self._sender:
                continue
            self.lengths[count] = length
            count += 1
            if usual not in (-1, length):
                break
            usual = length
        return count


class _Vector(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("length", ctypes.c_size_t))


class _Message(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_void_p),
        ("name_length", ctypes.c_uint32),
        ("vectors", ctypes.c_void_p),
        ("n_vectors", ctypes.c_size_t),
        ("control", ctypes.c_void_p),
        ("control_length", ctypes.c_size_t),
        ("flags", ctypes.c_int),
    )


class _MessageOfMany(ctypes.Structure):
    _fields_ = (("message", _Message), ("length", ctypes.c_uint32))


@final
class ManyAtOnce:
    """For Linux: all datagrams that wait, by one call of recvmmsg."""

    def __init__(self, opened: socket.socket, *, slot_bytes: int, sender: str) -> None:
        opened.settimeout(None)
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, np.array([0, int(_WAIT_S * 1e6)], np.int_).tobytes())
        self._socket = opened
        self._rests = opened.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) >= _ENOUGH_BYTES
        self._was_short = False
        self.packets = np.zeros((_SLOTS, slot_bytes), np.uint8)
        self._vectors = (_Vector * _SLOTS)()
        self._messages = (_MessageOfMany * _SLOTS)()
        self._names = np.zeros((_SLOTS, _NAME_BYTES), np.uint8)  # family, port and address of each sender
        self._sender = np.frombuffer(socket.inet_aton(sender), np.uint8)
        for i, slot in enumerate(self.packets):
            self._messages[i].message.name = self._names[i].ctypes.data
            self._messages[i].message.name_length = _NAME_BYTES
            self._vectors[i] = _Vector(slot.ctypes.data, slot_bytes)
            self._messages[i].message.vectors = ctypes.addressof(self._vectors[i])
            self._messages[i].message.n_vectors = 1
        self.lengths = np.ndarray(
            _SLOTS,
            np.uint32,
            buffer=memoryview(self._messages).cast("B"),
            offset=_MessageOfMany.length.offset,
            strides=(ctypes.sizeof(_MessageOfMany),),
        )
        self._receive = ctypes.CDLL(None, use_errno=True).recvmmsg

    def receive(self) -> int:
        """Wait a little for datagrams; how many slots are filled now, 0 if none came."""
        if self._was_short and self._rests:
            time.sleep(_REST_S)
        count: int = self._receive(self._socket.fileno(), self._messages, _SLOTS, _MSG_WAITFORONE, None)
        self._was_short = 0 < count < _SLOTS
        if count >= 0:
            return self._of_sender(count)
        error = ctypes.get_errno()
        if error in (11, 4):  # none came in time, or a signal did
            return 0
        raise OSError(error, os.strerror(error))

    def _of_sender(self, count: int) -> int:
        """Keep what the sender sent, in front of the rest; how many slots that fills."""
        theirs = np.flatnonzero((self._names[:count, _ADDRESS] == self._sender).all(axis=1))
        if theirs.size < count:
            self.packets[: theirs.size] = self.packets[theirs]
            self.lengths[: theirs.size] = self.lengths[theirs]
        return int(theirs.size)
