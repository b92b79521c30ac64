"""What a person sees of frames as they come: a small grey image, and where the mask's opening seems to be.

For the eye alone: the analysis finds the opening from all frames, by its own image model.
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import ndimage

from irtiming.records.arrays import Array, Pixels, read_only

WIDEST_PX = 320
_FEWEST_FRAMES, _HALF, _BRIGHT_PERCENT = 12, 0.5, 99.0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """A frame for the eye.

    ``grey`` has shape (row, column), uint8, every ``step`` th pixel of the frame. ``outline`` marks the border of what
    changes as the wheel turns, same shape, bool. ``lowest`` and ``highest`` are pixel values, DN.
    """

    grey: Array
    outline: Array
    step: int
    lowest: int
    highest: int


@final
class LiveView:
    """Remembers the lowest and highest value that each shown pixel had since `begin`."""

    def __init__(self) -> None:
        self._low: Pixels | None = None
        self._high: Pixels | None = None
        self._seen = 0

    def begin(self) -> None:
        """Forget what was shown before."""
        self._low = self._high = None
        self._seen = 0

    def look(self, pixels: Pixels) -> View:
        """A frame for the eye.

        Parameters
        ----------
        pixels
            Shape (row, column).
        """
        step = max(1, -(-pixels.shape[1] // WIDEST_PX))
        small = pixels[::step, ::step]
        if self._low is None or self._high is None or self._low.shape != small.shape:
            self._low, self._high, self._seen = small.copy(), small.copy(), 0
        np.minimum(self._low, small, out=self._low)
        np.maximum(self._high, small, out=self._high)
        self._seen += 1
        dark, bright = np.percentile(self._low, 1), np.percentile(self._high, _BRIGHT_PERCENT)
        grey = np.clip((small - dark) * (255 / max(1.0, bright - dark)), 0, 255).astype(np.uint8)
        return View(
            grey=read_only(grey),
            outline=read_only(self._outline()),
            step=step,
            lowest=int(pixels.min()),
            highest=int(pixels.max()),
        )

    def _outline(self) -> Array:
        """Border of the pixels that change by more than half of what the most lively do."""
        if self._low is None or self._high is None:
            return np.zeros((0, 0), bool)
        if self._seen < _FEWEST_FRAMES:
            return np.zeros(self._low.shape, bool)
        change = ndimage.median_filter(self._high.astype(np.int32) - self._low, 3)
        lively = change > _HALF * np.percentile(change, _BRIGHT_PERCENT)
        return np.asarray(lively & ~ndimage.binary_erosion(lively))
