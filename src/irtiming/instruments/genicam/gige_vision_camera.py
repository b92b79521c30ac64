"""Camera at the network by GigE Vision: registers by pyGigEVision, features by EMVA's GenApi, frames by `gige_stream`."""

from contextlib import AbstractAsyncContextManager
from typing import final

from irtiming.instruments.frame_queue import FrameQueue
from irtiming.instruments.genicam.camera import GenicamCamera, connected_by
from irtiming.instruments.genicam.features import Features
from irtiming.instruments.genicam.frame_numbers import FrameNumbers
from irtiming.instruments.genicam.gige_control import GigeControl
from irtiming.instruments.genicam.gige_stream import GigeStream
from irtiming.records.camera_frame import CameraSetup


def connected(address: str) -> AbstractAsyncContextManager[GenicamCamera]:
    """Camera at an address of the network, for the length of an ``async with`` block.

    Parameters
    ----------
    address
        Such as ``"192.168.0.7"``, or a name.

    Raises
    ------
    InstrumentError
        On entry, if nothing answers there, another program controls the camera, or it is no GigE Vision camera.
    """
    return connected_by(lambda: GigeLink(address))


@final
class GigeLink:
    """Control and stream channel of one camera."""

    first_number = 1

    def __init__(self, host: str) -> None:
        self._control = GigeControl(host)
        self._stream: GigeStream | None = None
        self.name = self._control.name
        self._control.open()
        try:
            self.identity = self._control.identity()
            self.features = Features(self._control.description(), registers=self._control, name=self.name)
            self.tick_frequency_hz = self._control.tick_frequency_hz()
            self.heartbeat_s = self._control.heartbeat_s()
        except BaseException:
            self._control.close()
            raise

    def require_control(self) -> None:
        """Nothing, if the camera answers and this program still controls it.

        Raises
        ------
        InstrumentSilent
            If not.
        """
        self._control.require_control()

    def start_stream(self, setup: CameraSetup, *, queue: FrameQueue, numbers: FrameNumbers) -> None:
        """Receive frames into the queue from now on.

        Parameters
        ----------
        setup
            Of the armed camera.
        queue
            Ended if the stream fails.
        numbers
            Of this acquisition.

        Raises
        ------
        InstrumentError
            If the camera does not take this computer's address or the size of packets.
        """
        self._stream = GigeStream(self._control)
        self._stream.open()
        self._stream.start((setup.rows, setup.columns), queue=queue, numbers=numbers)

    def stop_stream(self) -> None:
        """Receive what is on its way and end the queue; again does no harm."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def release(self) -> None:
        """Give up control; again does no harm."""
        self.stop_stream()
        self.features.close()
        self._control.close()
