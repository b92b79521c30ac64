r"""The scene at one instant from frames whose rows were read one after the other by pixels that lag.

Two steps, each frame read once. What the response did is undone frame to frame (`apply.inverse_lag`); then each row, which was
read at its own moments, is interpolated to one instant of each frame by a cubic through its four readings around it (Lagrange,
for any times of the frames).

The inversion amplifies noise, so a tile of the image gets it only as far as it stands out: with the correction
:math:`c = s - y` of the pixels of a tile,

.. math:: g = \max\left(0,\; 1 - \frac{u^2(c) + u(c, y)}{\langle c^2 \rangle}\right), \qquad \hat s = y + g\,c

which is the Wiener gain, the one that makes the mean square of the error least. Where nothing moves it is 0 and the frame stays
as it came.
"""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, islice
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from irtiming.apply import inverse_lag, kernels
from irtiming.apply.inverse_lag import Response
from irtiming.apply.noise import noise_of
from irtiming.errors import EstimationError
from irtiming.records.arrays import Array

_POINTS = 4  # of the cubic
_KEPT = 5  # frames, of which each row takes four
_LATER = 2  # frames that an instant waits for
_LONGEST = 1.5  # frame intervals, beyond which frames are missing
_LOOKED_AT = 16  # frames that tell the noise
_EXACT_S = 1e-10


@final
@dataclass(frozen=True, kw_only=True)
class Readout:
    """How frames came about: what the pixels did, and when rows were read.

    ``row_delay_s`` is from the reading of a row to that of the row below it, 0 for a snapshot camera. ``instant_row`` is
    the row whose reading is the instant to which all others are brought; None: the middle of the image.
    """

    response: Response
    row_delay_s: float = 0.0
    instant_row: float | None = None

    def instant(self, n_rows: int) -> float:
        """The row to whose reading all others are brought."""
        return (n_rows - 1) / 2 if self.instant_row is None else self.instant_row

    def lateness_s(self, n_rows: int) -> Array:
        """By how much later than the instant each row is read, s, shape (row,)."""
        return (np.arange(n_rows, dtype=np.float64) - self.instant(n_rows)) * self.row_delay_s


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """The scene at the instant of one frame.

    Parameters
    ----------
    index
        Of the frame, as it was pushed.
    time_s
        The instant: when its instant row was read, in the scale of the times given; s.
    pixels
        Shape (row, column), float32, in the units of the frames; valid until the next scene is asked for.
    gain
        Shape (tile row, tile column): the Wiener gain of each tile of `kernels.TILE` pixels, in [0, 1].
    noise_gain
        Same shape: standard deviation of the noise of ``pixels`` over that of the frame's pixels.
    """

    index: int
    time_s: float
    pixels: NDArray[np.float32]
    gain: NDArray[np.float32]
    noise_gain: NDArray[np.float32]


@final
@dataclass(eq=False)
class _Frame:
    index: int
    time_s: float
    slot: int


@final
class SceneStream:
    """Turns frames into the scene one after the other; memory does not grow.

    Parameters
    ----------
    readout
        Of the camera.
    size
        Rows and columns.
    interval_s
        Usual time between frames; where more than one and a half of it passes, frames are missing, and it begins anew.
    noise
        Standard deviation of a pixel's noise in the units of the frames; 0: there is none, everything is inverted wholly.
    """

    def __init__(self, readout: Readout, *, size: tuple[int, int], interval_s: float, noise: float) -> None:
        if not interval_s > 0 or not np.isfinite(interval_s):
            raise EstimationError(f"the time between frames is {interval_s} s, must be more than 0: check their times")
        if not 0 <= noise < np.inf:
            raise EstimationError(f"the noise of a pixel is {noise}, must be 0 or more")
        n_rows, n_columns = size
        self._readout, self._interval_s, self._noise = readout, interval_s, noise
        self._late_s = readout.lateness_s(n_rows)
        self._is_rolling = bool(np.ptp(self._late_s) > 0)
        if np.ptp(self._late_s) > interval_s:
            raise EstimationError(
                f"rows are read over {1e3 * np.ptp(self._late_s):.3f} ms, a frame lasts {1e3 * interval_s:.3f} ms; the readout "
                "must be the shorter one: check row delay, size and times of the frames"
            )
        self._memory = np.zeros((3, n_rows, n_columns), np.float32)
        self._knots = np.zeros((_KEPT, n_rows, n_columns), np.float32)
        tiles = tuple(-(-n // kernels.TILE) for n in size)
        self._gains = np.zeros((_KEPT, *tiles), np.float32)
        self._scene = np.zeros(size, np.float32)
        self._kept: deque[_Frame] = deque(maxlen=_KEPT)
        self._step: tuple[float, NDArray[np.float32], inverse_lag.NoiseResponses] | None = None
        self._weights: dict[tuple[float, ...], _Weights] = {}

    def push(self, frame: NDArray[Any], *, index: int, time_s: float) -> Iterator[Scene]:
        """Take a frame and give the scenes that are complete by it.

        Parameters
        ----------
        frame
            Shape (row, column), counts or temperatures.
        index
            Of the frame, or another number by which it is known.
        time_s
            When its instant row was read; s.

        Raises
        ------
        EstimationError
            If it has another size, or is not later than the one before.
        """
        if frame.shape != self._scene.shape:
            raise EstimationError(
                f"frame {index} has {frame.shape[0]} x {frame.shape[1]} pixels, those before had "
                f"{self._scene.shape[0]} x {self._scene.shape[1]}; all must have one size"
            )
        interval_s = time_s - self._kept[-1].time_s if self._kept else np.inf
        if not interval_s > 0:
            raise EstimationError(f"frame {index} is {interval_s:.6f} s later than the one before; times must rise")
        if interval_s > _LONGEST * self._interval_s:
            yield from self.end()
        self._take(frame, index=index, time_s=time_s)
        if not self._is_rolling:
            if len(self._kept) > 1:
                yield self._at(len(self._kept) - 1)
        elif len(self._kept) > _LATER + 1:
            yield self._at(len(self._kept) - 1 - _LATER)

    def end(self) -> Iterator[Scene]:
        """The scenes that wait for frames to come which will not; the next frame begins anew."""
        n = len(self._kept)
        for place in range(max(1, n - _LATER), n - 1) if self._is_rolling else ():
            yield self._at(place)
        self._kept.clear()

    def _take(self, frame: NDArray[Any], *, index: int, time_s: float) -> None:
        slot = (self._kept[-1].slot + 1) % _KEPT if self._kept else 0
        if not self._kept or self._readout.response.is_none:
            self._knots[slot] = frame
            if not self._readout.response.is_none:
                self._memory[:] = self._knots[slot]
            self._gains[slot] = 0
        else:
            numbers, noise = self._stepped(time_s - self._kept[-1].time_s)
            power = self._noise**2 * noise.correction_power
            frame = frame if frame.dtype == np.uint16 else frame.astype(np.float32)  # each type is compiled anew
            kernels.correct(frame, self._memory, numbers, power, self._gains[slot], self._knots[slot])
        self._kept.append(_Frame(index=index, time_s=time_s, slot=slot))

    def _stepped(self, interval_s: float) -> tuple[NDArray[np.float32], inverse_lag.NoiseResponses]:
        if self._step is None or abs(self._step[0] - interval_s) > _EXACT_S:
            response = self._readout.response
            noise = inverse_lag.responses(inverse_lag.step(response, interval_s))
            self._step = (interval_s, inverse_lag.numbers(response, interval_s), noise)
        return self._step[1], self._step[2]

    def _at(self, place: int) -> Scene:
        """The scene at the instant of a frame that is kept."""
        one = self._kept[place]
        order = np.array([kept.slot for kept in self._kept])
        noise = None if self._step is None else self._step[2]
        weights = self._weights_at(place)
        pixels = self._knots[one.slot]
        if self._is_rolling:
            kernels.interpolate(self._knots, order, weights.starts, weights.weights, self._scene)
            pixels = self._scene
        gain = self._gains[one.slot]
        return Scene(
            index=one.index, time_s=one.time_s, pixels=pixels, gain=gain, noise_gain=weights.noise_gain(gain, noise)
        )

    def _weights_at(self, place: int) -> "_Weights":
        since_s = tuple(round(kept.time_s - self._kept[place].time_s, 9) for kept in self._kept)
        if since_s not in self._weights:
            if len(self._weights) > 64:
                self._weights.clear()
            self._weights[since_s] = _Weights(np.array(since_s), self._late_s)
        return self._weights[since_s]


@final
class _Weights:
    """Weights of each row's readings at the instant, and what they do to the noise."""

    def __init__(self, since_s: Array, late_s: Array) -> None:
        used = min(_POINTS, since_s.size)
        before = np.searchsorted(since_s, -late_s, side="right") - 1  # the reading before the instant
        self.starts = np.clip(before - 1, 0, since_s.size - used).astype(np.int64)
        times = since_s[self.starts[:, None] + np.arange(used)] + late_s[:, None]
        found = np.ones_like(times)
        for k in range(used):
            for other in range(used):
                if other != k:
                    found[:, k] *= -times[:, other] / (times[:, k] - times[:, other])
        self.weights = np.zeros((late_s.size, _POINTS), np.float32)
        self.weights[:, :used] = found
        self._noise: tuple[inverse_lag.NoiseResponses, tuple[Array, ...]] | None = None

    def noise_gain(self, gain: NDArray[np.float32], noise: inverse_lag.NoiseResponses | None) -> NDArray[np.float32]:
        """Noise of the scene over that of a frame, for the gain of each tile."""
        if self._noise is None or (noise is not None and self._noise[0] is not noise):
            known = noise if noise is not None else inverse_lag.responses(inverse_lag.step(Response(), 1.0))
            rows = _noise_of_rows(self.weights, known)
            self._noise = (known, tuple(_over_tiles(values, gain.shape[0])[:, None] for values in rows))
        frame, both, added = self._noise[1]
        return np.sqrt(np.maximum(frame + 2 * gain * both + gain**2 * added, 0)).astype(np.float32)


def _noise_of_rows(weights: NDArray[np.float32], noise: inverse_lag.NoiseResponses) -> tuple[Array, ...]:
    """Variances per row of the frame's part, of both together, and of the correction; over that of a frame."""
    own = float(noise.as_it_came @ noise.as_it_came)
    length = weights.shape[1] + noise.added.size - 1
    came, added = np.zeros((weights.shape[0], length)), np.zeros((weights.shape[0], length))
    for k in range(weights.shape[1]):  # the latest reading has the most noise: taps run backwards in time
        at = slice(weights.shape[1] - 1 - k, weights.shape[1] - 1 - k + noise.added.size)
        came[:, at] += weights[:, k : k + 1] * noise.as_it_came
        added[:, at] += weights[:, k : k + 1] * noise.added
    return tuple(np.sum(one * other, axis=1) / own for one, other in ((came, came), (came, added), (added, added)))


def _over_tiles(values: Array, n_tiles: int) -> Array:
    """Mean over the rows of each tile, shape (tile row,)."""
    first = np.arange(n_tiles) * kernels.TILE
    return np.add.reduceat(values, first) / np.diff(np.append(first, values.size))


def scenes(
    frames: Iterable[NDArray[Any]], times_s: Array, *, readout: Readout, noise: float | None = None
) -> Iterator[Scene]:
    """The scene at one instant of each frame of a series, streamed.

    Parameters
    ----------
    frames
        Each of shape (row, column); counts or temperatures that are linear in what the pixels see.
    times_s
        Shape (n_frame,), rising: when its instant row was read, of a photon camera the middle of its integration; s.
    readout
        Of the camera.
    noise
        Standard deviation of a pixel's noise in the units of the frames; None: from the first frames.

    Yields
    ------
    One `Scene` for each frame between others: the first of a run of frames without gap, and of a rolling camera the last, have
    nothing to be found from.

    Raises
    ------
    EstimationError
        If there are less than two frames, times do not rise, or sizes differ.

    Examples
    --------
    >>> import numpy as np
    >>> ramp = np.arange(8.0)[:, None, None] * np.ones((8, 16, 16))
    >>> readout = Readout(response=Response(), row_delay_s=1e-3)
    >>> found = [scene.pixels.mean() for scene in scenes(ramp, 0.03 * np.arange(8), readout=readout, noise=0.0)]
    >>> np.allclose(found, [1, 2, 3, 4, 5, 6])
    True
    """
    times_s = np.asarray(times_s, dtype=np.float64)
    if times_s.size < 2 or not np.all(np.diff(times_s) > 0):
        raise EstimationError("the times of the frames must be at least two, each later than the one before")
    given = iter(frames)
    first = [np.array(frame) for frame in islice(given, _LOOKED_AT)]
    if not first:
        raise EstimationError("there are no frames")
    found = noise_of(np.array(first)) if noise is None else noise
    size = (first[0].shape[0], first[0].shape[1])
    stream = SceneStream(readout, size=size, interval_s=float(np.median(np.diff(times_s))), noise=found)
    for index, frame in enumerate(chain(first, given)):
        if index >= times_s.size:
            raise EstimationError(f"there are more frames than the {times_s.size} times; each frame must have one")
        yield from stream.push(frame, index=index, time_s=float(times_s[index]))
    yield from stream.end()
