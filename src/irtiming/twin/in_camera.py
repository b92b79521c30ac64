"""What a camera does with its frames before it gives them out, as a record."""

from dataclasses import dataclass
from typing import final

from irtiming.errors import PlanError


@final
@dataclass(frozen=True, kw_only=True)
class InCamera:
    """What each frame has of those before it, in this order; x_n is what the detector gives for trigger n.

    Memory of the pixels: m_n = (1 - ``memory_share``) x_n + ``memory_share`` x_{n-1}. Recursive filter:
    y_n = (1 - ``filter_share``) m_n + ``filter_share`` y_{n-1}. Mean of the last ``averaged_frames`` of y. What comes out is
    rounded, once. The camera has looked at its first frame for long when the first trigger comes. Frames that are lost afterwards
    take part.
    """

    memory_share: float = 0.0
    filter_share: float = 0.0
    averaged_frames: int = 1

    def __post_init__(self) -> None:
        """Refuse what is no mean of frames."""
        if not (0 <= self.memory_share < 1 and 0 <= self.filter_share < 1 and self.averaged_frames >= 1):
            raise PlanError(
                f"a memory of {self.memory_share}, a filter of {self.filter_share} and a mean of {self.averaged_frames} frames; "
                "shares must be at least 0 and below 1, frames at least 1"
            )

    @property
    def is_plain(self) -> bool:
        """Whether frames are given out as they are."""
        return self == InCamera()
