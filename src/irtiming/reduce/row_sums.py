"""The single pass over the frames of a rolling camera: row sums, quiet level, shutter events, projections of each pixel.

Frames are judged as they stream by. Since an event shows only some frames later, the frames of the last half second are held
back and enter the projections when they are known to be good: nothing ever has to be taken out again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np

from irtiming.records.arrays import Array, ComplexArray, Mask, Pixels, Ticks
from irtiming.records.recording import Recording
from irtiming.reduce import dead_pixels, kernels
from irtiming.reduce.rolling_opening import Sighting
from irtiming.reduce.shutter import FrameLevels, Watch

_MOSTLY = 0.5  # of the pixels at a limit: a dead frame
_SOME_ROWS = 4  # every fourth row tells whether a frame is dead
_ALL_BITS = 0xFFFF

SHORTEST = 60
"""Frames between two events that are worth offsets of their own; fewer are dropped."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Harvest:
    """What the pass gathers.

    Parameters
    ----------
    row_px, row_sum, mask_row_sum
        Image rows (n_row,), and sums of each frame over the summed pixels and over the mask (n_frame, n_row), DN.
    levels
        Of each frame.
    suspicious, event, zone
        Judgement of each frame, shape (n_frame,).
    segment
        Shape (n_frame,); number of the stretch, -1 for frames that are not kept.
    projection_dn
        Shape (roi rows, roi columns); sum over the kept frames of exp(-2 i theta), less its mean in each segment, times
        the value, DN.
    short
        First and end frame, excluded, of each stretch that was too short to keep.
    hopeless_row_px
        Rows whose dead pixels nobody can stand in for.
    """

    row_px: Ticks
    row_sum: Array
    mask_row_sum: Array
    levels: FrameLevels
    suspicious: Mask
    event: Mask
    zone: Mask
    segment: Ticks
    projection_dn: ComplexArray
    short: tuple[tuple[int, int], ...]
    hopeless_row_px: Ticks


def gather(
    recording: Recording, sighting: Sighting, *, angle: Array, watch: Watch, progress: Callable[[int], None]
) -> Harvest:
    """Read all frames once.

    Parameters
    ----------
    recording, sighting
        The opening that was found in it.
    angle
        Shape (n_frame,); wheel angle of each frame, nan where unknown.
    watch
        How frames are judged.
    progress
        Told the number of frames done so far.
    """
    opening = sighting.opening
    rows, columns = slice(*opening.roi[:2]), slice(*opening.roi[2:])
    summing = _Summing(sighting)
    n_frames = recording.frames.shape[0]
    sums = np.zeros((2, n_frames, summing.row_px.size))
    levels = FrameLevels(
        beside_dn=np.full(n_frames, np.nan),
        quiet_dn=np.zeros(n_frames),
        repeated=np.zeros(n_frames, bool),
        dead=np.zeros(n_frames, bool),
    )
    known = np.isfinite(angle)
    judged = _Judged(watch, levels, known)
    stream = _Stream(judged, np.exp(-2j * angle), (rows.stop - rows.start, columns.stop - columns.start))
    expected = sighting.expected.at(np.where(known, angle, 0.0), np.arange(n_frames) / n_frames)
    expected[~known] = np.nan
    last = None
    for first, block in recording.frames.blocks():
        part, now = np.ascontiguousarray(block[:, rows, columns]), slice(first, first + len(block))
        sums[0, now], sums[1, now] = summing.rows(part)
        levels.quiet_dn[now] = summing.quiet(block)
        levels.beside_dn[now] = sums[1, now].sum(axis=1) / summing.n_mask - levels.quiet_dn[now] - expected[now]
        levels.dead[now] = _dead(part, 2**recording.bit_depth - 1)
        if sighting.noise_dn > 0:
            levels.repeated[now] = kernels.repeats(part, ~part[0] if last is None else last)
        last = part[-1].copy()
        stream.add(first, part, at_end=first + len(block) == n_frames)
        progress(first + len(block))
    stream.close()
    return Harvest(
        row_px=summing.row_px,
        row_sum=sums[0],
        mask_row_sum=sums[1],
        levels=levels,
        suspicious=judged.suspicious,
        event=judged.event,
        zone=judged.zone,
        segment=stream.segment,
        projection_dn=stream.projection,
        short=tuple(stream.short),
        hopeless_row_px=summing.hopeless_row_px,
    )


def _dead(part: Pixels, full_scale: int) -> Mask:
    """Which frames have most of their pixels at zero or at full scale."""
    some = part[:, ::_SOME_ROWS].reshape(len(part), -1)
    return np.asarray(np.maximum((some == 0).mean(axis=1), (some >= full_scale).mean(axis=1)) > _MOSTLY)


@final
class _Summing:
    """Which pixels of a frame are added up, and who stands in for the dead ones among them."""

    def __init__(self, sighting: Sighting) -> None:
        opening = sighting.opening
        first_row, _, first_column, _ = opening.roi
        box = np.s_[slice(*opening.roi[:2]), slice(*opening.roi[2:])]
        stand_ins, hopeless = dead_pixels.stand_ins(opening.bad, opening.summed)
        self.hopeless_row_px = np.flatnonzero(hopeless)
        self.row_px = np.flatnonzero(opening.summed.any(axis=1) & ~hopeless)
        self.n_mask = float(opening.mask[self.row_px].sum())
        self._rows = self.row_px - first_row
        self._taken = [_bits((area & ~opening.bad)[box]) for area in (opening.summed, opening.mask)]
        self._stand_ins = []
        for area in (opening.summed, opening.mask):
            wanted = stand_ins[area[stand_ins[:, 0], stand_ins[:, 1]]]
            self._stand_ins.append(wanted[:, [0, 2, 3]] - [first_row, first_column, first_column])
        step = max(1, int(np.gcd.reduce(np.flatnonzero(sighting.quiet.any(axis=1)))))
        self._quiet_rows = slice(None, None, step)
        self._quiet = _bits(sighting.quiet[self._quiet_rows])
        self._n_quiet = int(sighting.quiet.sum())

    def rows(self, part: Pixels) -> tuple[Array, Array]:
        """Row sums over the summed pixels and over the mask, shape (frame, row)."""
        found = []
        for taken, stand_ins in zip(self._taken, self._stand_ins, strict=True):
            sums = kernels.sum_within(part, taken).astype(float)
            for row, left, right in stand_ins:
                sums[:, row] += 0.5 * (part[:, row, left].astype(float) + part[:, row, right])
            found.append(sums[:, self._rows])
        return found[0], found[1]

    def quiet(self, block: Pixels) -> Array:
        """Mean of the quiet pixels, shape (frame,); 0 where there are none."""
        if not self._n_quiet:
            return np.zeros(len(block))
        return np.asarray(
            kernels.sum_within(np.ascontiguousarray(block[:, self._quiet_rows]), self._quiet).sum(axis=1)
            / self._n_quiet
        )


def _bits(area: Mask) -> Pixels:
    return np.where(area, _ALL_BITS, 0).astype(np.uint16)


@final
class _Judged:
    """Judgement of the frames so far; that of a frame is final when enough frames after it are known."""

    def __init__(self, watch: Watch, levels: FrameLevels, known: Mask) -> None:
        self.reach = watch.reach
        self._watch, self._levels, self._known = watch, levels, known
        self.suspicious, self.event, self.zone = (np.zeros(known.size, bool) for _ in range(3))

    def decide(self, first: int, end: int, *, seen: int) -> Mask:
        """Judge frames ``first`` to ``end``, of which ``seen`` have been read; true for the good ones."""
        window = slice(max(0, first - self.reach), min(seen, end + self.reach))
        inside = slice(first - window.start, end - window.start)
        levels = FrameLevels(
            beside_dn=self._levels.beside_dn[window],
            quiet_dn=self._levels.quiet_dn[window],
            repeated=self._levels.repeated[window],
            dead=self._levels.dead[window],
        )
        judged = self._watch.judge(levels, at_start=window.start == 0, at_end=window.stop == self._known.size)
        for mine, found in zip((self.suspicious, self.event, self.zone), judged, strict=True):
            mine[first:end] = found[inside]
        return np.asarray(self._known[first:end] & ~self.suspicious[first:end] & ~self.zone[first:end])


@final
class _Stream:
    """Projection of the good frames, stretch by stretch, with the frames that are not yet judged held back."""

    def __init__(self, judged: _Judged, wave: ComplexArray, shape: tuple[int, int]) -> None:
        self.segment = np.full(wave.size, -1)
        self.short: list[tuple[int, int]] = []
        self.projection = np.zeros(shape, complex)
        self._judged, self._wave = judged, wave
        self._sums = np.zeros((3, *shape))
        self._held = np.zeros((0, *shape), np.uint16)
        self._held_first = 0
        self._stretch: list[Ticks] = []
        self._n_segments = 0

    def add(self, first: int, part: Pixels, *, at_end: bool) -> None:
        """Take a block in: judge what can be judged, hold back the rest."""
        seen = first + len(part)
        end = seen if at_end else max(self._held_first, seen - self._judged.reach)
        good = self._judged.decide(self._held_first, end, seen=seen)
        zone = self._judged.zone[self._held_first : end]
        n_held = len(self._held)
        starts = [0, *(np.flatnonzero(np.diff(zone)) + 1), zone.size]
        for start, stop in pairwise(starts):
            if stop > start and zone[start]:
                self.close()
            elif stop > start:
                self._take(self._held[start:stop], self._held_first + start, good[start:stop])
                own = slice(max(start - n_held, 0), max(stop - n_held, 0))
                self._take(part[own], first + own.start, good[max(start, n_held) : max(stop, n_held)])
        kept_back = [self._held[zone.size :], part[max(zone.size - n_held, 0) :]]
        self._held, self._held_first = np.concatenate(kept_back), end

    def _take(self, frames: Pixels, first: int, good: Mask) -> None:
        good = good[: len(frames)]
        index = first + np.flatnonzero(good)
        if not index.size:
            return
        frames = frames if good.all() else frames[good]
        wave = self._wave[index]
        kernels.add_projection(frames, np.ascontiguousarray(wave.real), np.ascontiguousarray(wave.imag), self._sums)
        self._stretch.append(index)

    def close(self) -> None:
        """End the stretch: its mean weight is taken off, so that its own offsets drop out; a short one is dropped."""
        if not self._stretch:
            return
        index = np.concatenate(self._stretch)
        if index.size < SHORTEST:
            self.short.append((int(index[0]), int(index[-1]) + 1))
        else:
            self.segment[index] = self._n_segments
            self._n_segments += 1
            self.projection += self._sums[0] + 1j * self._sums[1] - self._wave[index].mean() * self._sums[2]
        self._sums[:] = 0
        self._stretch = []
