"""Numbers of frames on the wire, of 16 or 64 bits, as frame ids that count from 0 and never wrap."""

from typing import final

_LOST_AT_START = 16
_NARROW = 2**16


@final
class FrameNumbers:
    """Numbers of one acquisition.

    The first is 1 by the standard, so that a first frame that is lost leaves a gap; a camera that counts on from the
    acquisition before continues after ``last_number``; any other first number is taken for the first frame.
    """

    def __init__(self, *, last_number: int = 0, first_number: int = 1) -> None:
        self._starts = (first_number, last_number + 1)
        self._period = _NARROW - 1  # from 65535 to 1: 0 means no frame
        self._newest: tuple[int, int] | None = None

    @property
    def last_number(self) -> int:
        """Number of the newest frame; 0 before the first."""
        return self._newest[0] if self._newest is not None else 0

    @property
    def newest_id(self) -> int:
        """Frame id of the newest frame; -1 before the first."""
        return self._newest[1] if self._newest is not None else -1

    def frame_id(self, number: int, *, is_wide: bool) -> int:
        """Frame id that belongs to a number.

        Parameters
        ----------
        number
            As on the wire.
        is_wide
            Whether it has 64 bits and never wraps.
        """
        if number == 0 and not is_wide:
            self._period = _NARROW  # a camera that counts to 0 all the same
        if self._newest is None:
            return number - max(
                (start for start in self._starts if 0 <= number - start < _LOST_AT_START), default=number
            )
        newest, frame_id = self._newest
        if is_wide:
            return frame_id + number - newest
        step = (number - newest) % self._period
        return frame_id + step - (self._period if step > self._period // 2 else 0)

    def number_of(self, frame_id: int, *, is_wide: bool) -> int:
        """Number on the wire of a frame before the newest.

        Parameters
        ----------
        frame_id
            At most `newest_id`, and not before the first frame of the acquisition.
        is_wide
            Whether it has 64 bits and never wraps.
        """
        number = self.last_number - (self.newest_id - frame_id)
        if is_wide:
            return number
        lowest = _NARROW - self._period
        return (number - lowest) % self._period + lowest

    def saw(self, number: int, *, frame_id: int) -> None:
        """A frame of this number came.

        Parameters
        ----------
        number
            As on the wire.
        frame_id
            By `frame_id`.
        """
        if frame_id > self.newest_id:
            self._newest = (number, frame_id)
