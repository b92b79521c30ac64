"""What is used of the Aravis library (0.8), declared for ctypes."""

import ctypes
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_uint64, c_void_p
from functools import cache
from typing import Any, final

from irtiming.errors import InstrumentError, InstrumentRefused, InstrumentSilent

_NAMES = ("libaravis-0.8.so.0", "libaravis-0.8.0.dylib", "libaravis-0.8-0.dll")
_NOT_CONNECTED, _TIMEOUT, _NOT_FOUND, _NOT_CONTROLLER = 2, 5, 6, 10
_DEVICE_ERRORS = b"arv-device-error-quark"
SUCCESS, CLEARED, TIMED_OUT, MISSING_PACKETS, WRONG_PACKET, SIZE_MISMATCH, FILLING, ABORTED, UNKNOWN_PAYLOAD = range(9)


@final
class GlibError(ctypes.Structure):
    """Error of GLib."""

    _fields_ = (("domain", ctypes.c_uint32), ("code", c_int), ("message", c_char_p))


_ERROR = POINTER(POINTER(GlibError))
_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "arv_update_device_list": (None, ()),
    "arv_get_n_devices": (c_uint, ()),
    "arv_get_device_id": (c_char_p, (c_uint,)),
    "arv_get_device_address": (c_char_p, (c_uint,)),
    "arv_get_device_protocol": (c_char_p, (c_uint,)),
    "arv_get_device_vendor": (c_char_p, (c_uint,)),
    "arv_get_device_model": (c_char_p, (c_uint,)),
    "arv_get_device_serial_nbr": (c_char_p, (c_uint,)),
    "arv_camera_new": (c_void_p, (c_char_p, _ERROR)),
    "arv_camera_get_device": (c_void_p, (c_void_p,)),
    "arv_camera_is_gv_device": (c_int, (c_void_p,)),
    "arv_camera_get_payload": (c_uint, (c_void_p, _ERROR)),
    "arv_camera_create_stream": (c_void_p, (c_void_p, c_void_p, c_void_p, _ERROR)),
    "arv_gv_device_is_controller": (c_int, (c_void_p,)),
    "arv_gv_device_take_control": (c_int, (c_void_p, _ERROR)),
    "arv_gv_device_set_stream_options": (None, (c_void_p, c_int)),
    "arv_device_get_genicam_xml": (c_void_p, (c_void_p, POINTER(c_size_t))),
    "arv_device_read_register": (c_int, (c_void_p, c_uint64, POINTER(ctypes.c_uint32), _ERROR)),
    "arv_device_write_register": (c_int, (c_void_p, c_uint64, ctypes.c_uint32, _ERROR)),
    "arv_device_read_memory": (c_int, (c_void_p, c_uint64, ctypes.c_uint32, c_void_p, _ERROR)),
    "arv_device_write_memory": (c_int, (c_void_p, c_uint64, ctypes.c_uint32, c_void_p, _ERROR)),
    "arv_stream_push_buffer": (None, (c_void_p, c_void_p)),
    "arv_stream_timeout_pop_buffer": (c_void_p, (c_void_p, c_uint64)),
    "arv_stream_get_info_uint64_by_name": (c_uint64, (c_void_p, c_char_p)),
    "arv_buffer_new_allocate": (c_void_p, (c_size_t,)),
    "arv_buffer_get_status": (c_int, (c_void_p,)),
    "arv_buffer_get_frame_id": (c_uint64, (c_void_p,)),
    "arv_buffer_get_timestamp": (c_uint64, (c_void_p,)),
    "arv_buffer_get_data": (c_void_p, (c_void_p, POINTER(c_size_t))),
    "arv_buffer_get_image_width": (c_int, (c_void_p,)),
    "arv_buffer_get_image_height": (c_int, (c_void_p,)),
    "g_object_unref": (None, (c_void_p,)),
    "g_error_free": (None, (POINTER(GlibError),)),
    "g_quark_to_string": (c_char_p, (ctypes.c_uint32,)),
}


ONLY_ORDINARY_SOCKETS = 1
_FIXED_SOCKET_BUFFER = 0
_SOCKET_BUFFER_BYTES = 16 * 2**20
_MOST_RESENT, _FRAME_RETENTION_US = 1.0, 400_000
"""Of a frame's packets, and how long the library waits for them."""


@cache
def library() -> Any:
    """The library with its functions declared.

    Raises
    ------
    InstrumentError
        If it is not installed.
    """
    for name in _NAMES:
        try:
            found = ctypes.CDLL(name)
        except OSError:
            continue
        for function, (result, arguments) in _FUNCTIONS.items():
            declared = getattr(found, function)
            declared.restype, declared.argtypes = result, arguments
        return found
    raise InstrumentError("the Aravis library 0.8 is not installed; install it (Debian: apt install libaravis-0.8-0)")


def call(function: str, *arguments: Any, camera: str) -> Any:
    """Result of a function that reports errors by its last argument.

    Parameters
    ----------
    function
        Its name.
    arguments
        All but the last.
    camera
        For messages.

    Raises
    ------
    InstrumentError
        If it reports one.
    """
    error = POINTER(GlibError)()
    result = getattr(library(), function)(*arguments, byref(error))
    if not error:
        return result
    domain = library().g_quark_to_string(error.contents.domain)
    code, text = error.contents.code, (error.contents.message or b"").decode(errors="replace")
    library().g_error_free(error)
    raise _explained(code if domain == _DEVICE_ERRORS else None, " ".join(text.split()), camera)


def make_patient(stream: Any) -> None:
    """Let the system hold more packets of a network stream than one frame, and any part of a frame be asked for again.

    The receiving thread may have to wait, and answers too.

    Parameters
    ----------
    stream
        Of the library, before it starts.
    """
    buffer = (b"socket-buffer", c_int(_FIXED_SOCKET_BUFFER), b"socket-buffer-size", c_int(_SOCKET_BUFFER_BYTES))
    resends = (b"packet-request-ratio", c_double(_MOST_RESENT), b"frame-retention", c_uint(_FRAME_RETENTION_US))
    library().g_object_set(c_void_p(stream), *buffer, *resends, c_void_p())


def text(value: bytes | None) -> str:
    """Text of a C string; empty for none.

    Parameters
    ----------
    value
        As ctypes gives it.
    """
    return (value or b"").decode(errors="replace").strip()


def _explained(code: int | None, text: str, camera: str) -> InstrumentError:
    if code in (_NOT_FOUND, _TIMEOUT, _NOT_CONNECTED):
        return InstrumentSilent(
            f"{camera} does not answer ({text}); check its cable and power, and that its address is in a network of this computer"
        )
    if code == _NOT_CONTROLLER:
        return InstrumentRefused(f"{camera} is controlled by another program; end that program")
    return InstrumentRefused(f"{camera} denies it ({text})")
