"""Which frames a person wants to look at; plain, so that a server which only asks for them loads no array."""

from dataclasses import dataclass
from pathlib import Path
from typing import final


@final
@dataclass(frozen=True, kw_only=True)
class ViewOrder:
    """What a person wants to see: a frame of a file (-1: the middle one), no wider than so many pixels.

    ``levels`` are the values for black and white, such as those of a view to compare with; None: the frame's own.
    """

    path: Path
    index: int = -1
    widest_px: int = 640
    levels: tuple[float, float] | None = None


@final
@dataclass(frozen=True, kw_only=True)
class PairOrder:
    """What a person wants to compare: frames, the scene made of them, and the index of a frame of the scene (-1: the middle)."""

    before: Path
    after: Path
    index: int = -1
    widest_px: int = 640
