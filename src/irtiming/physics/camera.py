"""A camera is a response times a memory times a readout; nothing but its type and its readout mode chooses them.

================  ==========================================  ==============================================
                  snapshot (all rows at once)                 rolling (eq. 3)
================  ==========================================  ==============================================
photon            integration window (eq. 1)                  a CMOS camera: each row has its window later
microbolometer    first-order lag (eq. 2), all rows at once   first-order lag, rows one after the other
================  ==========================================  ==============================================
"""

from dataclasses import dataclass
from typing import Protocol, final

from irtiming.physics.readout import rolling, snapshot
from irtiming.physics.response import first_order_lag, in_camera_filter, integration_window, pixel_memory
from irtiming.records.arrays import Array, ComplexArray
from irtiming.records.recording import CameraType, ReadoutMode


class Response(Protocol):
    """How a pixel follows what it sees: a factor on each harmonic of the wheel angle, with one parameter, s.

    ``HARMONICS`` is the highest order that a fit of rows needs that are read one after the other.
    """

    PARAMETER: str
    HARMONICS: int

    def transfer(self, omega: float, parameter_s: float | Array, /, *, n_harmonics: int) -> ComplexArray:
        """Factors, shape (M + 1,); of parameters of shape (p, 1), (p, M + 1)."""
        ...

    def transfer_slope(self, omega: float, parameter_s: float | Array, /, *, n_harmonics: int) -> ComplexArray:
        """Their derivatives to the parameter, shape (M + 1,) or (p, M + 1), per second."""
        ...


class Memory(Protocol):
    """What frames keep of those before: a factor on each harmonic of the wheel angle, with one share as parameter.

    ``LOOKED_AT`` are shares from which a search begins, ``U_SHARE`` is the standard uncertainty of one that nobody states, which
    is 0 as far as anyone knows.
    """

    PARAMETER: str
    LOOKED_AT: tuple[float, ...]
    U_SHARE: float

    def transfer(self, step_rad: float, share: float, /, *, n_harmonics: int) -> ComplexArray:
        """Factors, shape (M + 1,), where the wheel turns by ``step_rad`` from frame to frame."""
        ...

    def transfer_slope(self, step_rad: float, share: float, /, *, n_harmonics: int) -> ComplexArray:
        """Their derivatives to the share, shape (M + 1,)."""
        ...


class Readout(Protocol):
    """When each row is read: a delay that is linear in its parameters, s."""

    PARAMETERS: tuple[str, ...]

    def read_later(self, row_px: Array, /) -> Array:
        """By how much later each row is read than row 0, per unit of each parameter; shape (n_parameter, n_row)."""
        ...


@final
@dataclass(frozen=True, kw_only=True)
class Camera:
    """How it responds, what its frames keep of those before, and how it is read."""

    response: Response
    memory: Memory
    readout: Readout

    @property
    def lags(self) -> bool:
        """Whether pixels follow what they see for long, and so are seldom wholly covered or open."""
        return self.response is first_order_lag

    @property
    def n_harmonics(self) -> int:
        """Highest order that a fit of rows needs: twice as high in a snapshot, for what is beyond adds up over all rows."""
        return self.response.HARMONICS * (1 if self.readout.PARAMETERS else 2)


EXACT_SHARE = 1e-7
"""Standard uncertainty of a share of the frame before that is stated without one: thousands of times less than frames tell."""

_RESPONSES: dict[CameraType, Response] = {"photon": integration_window, "microbolometer": first_order_lag}
_MEMORIES: dict[CameraType, Memory] = {"photon": pixel_memory, "microbolometer": in_camera_filter}
_READOUTS: dict[ReadoutMode, Readout] = {"snapshot": snapshot, "rolling": rolling}


def camera(camera_type: CameraType, readout_mode: ReadoutMode) -> Camera:
    """The camera of this type and readout mode."""
    return Camera(response=_RESPONSES[camera_type], memory=_MEMORIES[camera_type], readout=_READOUTS[readout_mode])
