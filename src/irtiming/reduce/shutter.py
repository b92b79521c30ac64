"""Tell frames that show the scene from those of a closed shutter, a frozen camera, or none at all.

Each frame is judged by itself and its near neighbours only, so that it can be judged while the frames stream by.
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import ndimage

from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.reduced import ShutterEvent

_SCATTERS, _LEAST_PART, _MOST_PART = 8.0, 0.08, 0.3  # of the scatter; of the contrast
_SURE = 7.0  # standard deviations of noise: by chance never
_SETTLING_S = 0.12  # kept away from each event, for the lag
_LEAST_MARGIN = 3  # frames
_NEAR = 2  # frames: two bad ones this near are an event, a lone one is not
_HALF_WINDOW = 8  # frames, of the running median of the quiet level


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class FrameLevels:
    """What is known of each frame of a stretch, shape (n,).

    ``beside_dn`` is the opening's level less the expected one, nan where the wheel angle is unknown; ``quiet_dn`` the level
    of the quiet pixels, ``band_dn`` (n, n_band) that of bands of rows of them; ``repeated`` is true for a frame equal to the one
    before, ``dead`` for one with most pixels at a limit.
    """

    beside_dn: Array
    quiet_dn: Array
    band_dn: Array
    repeated: Mask
    dead: Mask

    def of(self, part: slice) -> "FrameLevels":
        """Those of some frames."""
        return FrameLevels(
            beside_dn=self.beside_dn[part],
            quiet_dn=self.quiet_dn[part],
            band_dn=self.band_dn[part],
            repeated=self.repeated[part],
            dead=self.dead[part],
        )


@final
@dataclass(frozen=True, kw_only=True)
class Watch:
    """How frames are judged.

    A frame is suspicious beyond ``tolerance_dn``; ``margin`` frames on both sides of an event are not trusted either.
    """

    tolerance_dn: float
    margin: int

    @property
    def reach(self) -> int:
        """By how many frames a frame's judgement looks ahead and back."""
        return _HALF_WINDOW + _NEAR + self.margin + 1

    def judge(self, levels: FrameLevels, *, at_start: bool, at_end: bool) -> tuple[Mask, Mask, Mask]:
        """Judge each frame: suspicious; suspicious and part of an event; too near to an event. Shapes (n,).

        A lone bad frame is no event, but at the start or the end of the recording it may be the rest of one.
        """
        suspicious = levels.repeated | levels.dead
        suspicious |= np.abs(np.nan_to_num(levels.beside_dn)) > self.tolerance_dn
        quiet = np.column_stack([levels.quiet_dn, levels.band_dn])
        usual = ndimage.median_filter(quiet, (2 * _HALF_WINDOW + 1, 1), mode="nearest")
        suspicious |= np.any(np.abs(quiet - usual) > self.tolerance_dn, axis=1)
        around = ndimage.convolve1d(suspicious.astype(float), np.ones(2 * _NEAR + 1), mode="constant")
        around[:_NEAR] += float(at_start) * ~levels.dead[:_NEAR]
        around[-_NEAR:] += float(at_end) * ~levels.dead[-_NEAR:]
        event = suspicious & (around > 1.5)
        zone = ndimage.binary_dilation(event, np.ones(2 * self.margin + 1, bool))
        return suspicious, event, np.asarray(zone)


def tolerance_dn(*, contrast_dn: float, scatter_dn: float) -> float:
    """How far a frame may stray from the expected level, DN.

    Parameters
    ----------
    contrast_dn, scatter_dn
        By how much the opening's level swings, and how far good frames stray from the expected level.
    """
    return float(np.clip(_SCATTERS * scatter_dn, _LEAST_PART * contrast_dn, _MOST_PART * contrast_dn))


def fewest_pixels(tolerance_dn: float, *, noise_dn: float) -> int:
    """How many pixels there must be for the noise of their mean not to exceed the tolerance by chance.

    Parameters
    ----------
    tolerance_dn, noise_dn
        How far the mean may stray, and standard deviation of one pixel from frame to frame, DN.
    """
    return max(1, int(np.ceil((_SURE * noise_dn / tolerance_dn) ** 2)))


def watch(tolerance_dn: float, *, longest_level_s: float, frame_period_s: float) -> Watch:
    """How to judge the frames of one recording.

    Parameters
    ----------
    tolerance_dn
        How far a frame may stray from the expected level.
    longest_level_s
        How long the expected level stays about the same: for so long a closed shutter can look as if it were open.
    frame_period_s
        Time between frames.
    """
    margin = int(np.ceil(max(_SETTLING_S, longest_level_s) / frame_period_s))
    return Watch(tolerance_dn=tolerance_dn, margin=max(_LEAST_MARGIN, margin))


def events(event: Mask, zone: Mask, *, levels: FrameLevels) -> tuple[ShutterEvent, ...]:
    """The events of a recording from the judgement of all its frames.

    A closed shutter may have the very level that is expected of the opening, for a frame. Frames next to an event whose quiet
    level is that of the event rather than that before or after it belong to it.

    Parameters
    ----------
    event, zone, levels
        Of all frames, shape (n_frame,).
    """
    labels, n = ndimage.label(zone)
    found = []
    for k in range(1, n + 1):
        within = np.flatnonzero(labels == k)
        frames = within[event[within]]
        first, end = int(frames[0]), int(frames[-1]) + 1
        frozen = bool(levels.repeated[frames].mean() > 0.5)
        if not frozen:
            first, end = _with_closed_looks(levels.quiet_dn, within, first, end)
        found.append(ShutterEvent(first_frame=first, end_frame=end, kind="frozen" if frozen else "closed"))
    return tuple(found)


def _with_closed_looks(quiet: Array, within: Ticks, first: int, end: int) -> tuple[int, int]:
    """First and end frame of an event, widened over frames nearer to the closed shutter's level than to the open one's."""
    outside = [int(frame) for frame in (within[0] - 1, within[-1] + 1) if 0 <= frame < quiet.size]
    if not outside:
        return first, end
    closed = float(np.median(quiet[first:end]))
    before, after = float(quiet[outside[0]]), float(quiet[outside[-1]])
    while first > within[0] and abs(quiet[first - 1] - closed) < 0.5 * abs(before - closed):
        first -= 1
    while end <= within[-1] and abs(quiet[end] - closed) < 0.5 * abs(after - closed):
        end += 1
    return first, end
