"""Frames that are made when somebody asks for them: a recording needs the memory of a few frames."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import cpu_count
from typing import Protocol, TypeVar, final

import numpy as np
import numpy.typing as npt

from irtiming.errors import ReductionError
from irtiming.records.arrays import Array, Pixels
from irtiming.records.recording import NonuniformityReference
from irtiming.twin.noise import FixedPattern, Purpose, Values, digitise, generator
from irtiming.twin.scene import Radiance

_BLOCK_BYTES = 16e6
Number = TypeVar("Number", np.uint16, np.float32)


class FrameMaker(Protocol):
    """Makes any frame of a stack by itself, the same one every time."""

    def __call__(self, index: int, *, signal_dn: Values, out: Pixels | Values) -> None:
        """Write frame ``index``, shape (row, column), to ``out``; ``signal_dn`` is room for the work."""
        ...


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BlackbodyShots:
    """Frames of the bare blackbody, which a mean pixel shows as ``level_dn``."""

    level_dn: float
    pattern: FixedPattern
    purpose: Purpose
    seed: int

    def __call__(self, index: int, *, signal_dn: Values, out: Pixels | Values) -> None:
        """Read the frame out."""
        signal_dn.fill(self.level_dn)
        digitise(signal_dn, self.pattern, random=generator(self.seed, self.purpose, index=index), out=out)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedFrames:
    """Stack of frames, each made when it is asked for; ``shape`` is frames, rows and columns."""

    shape: tuple[int, int, int]
    make: FrameMaker

    def blocks(self) -> Iterator[tuple[int, Pixels]]:
        """Index of the first frame and values (frame, row, column), block after block, in order.

        A block is valid until the next one is asked for.
        """
        return self._blocks(self._room(np.uint16))

    def unrounded_blocks(self) -> Iterator[tuple[int, Values]]:
        """The same before they are rounded."""
        return self._blocks(self._room(np.float32))

    def _room(self, kind: type[Number]) -> npt.NDArray[Number]:
        n_frame, rows, columns = self.shape
        return np.empty((max(1, min(n_frame, int(_BLOCK_BYTES / (2 * rows * columns)))), rows, columns), kind)

    def _blocks(self, block: npt.NDArray[Number]) -> Iterator[tuple[int, npt.NDArray[Number]]]:
        n_frame, length = self.shape[0], len(block)
        with ThreadPoolExecutor(cpu_count()) as pool:
            for first in range(0, n_frame, length):
                indices = list(range(first, min(first + length, n_frame)))
                shares = _shares(len(indices))
                list(pool.map(self._fill, [indices[s] for s in shares], [block[s] for s in shares]))
                yield first, block[: len(indices)]

    def pick(self, indices: list[int]) -> Pixels:
        """The named frames, shape (len(indices), row, column).

        Raises
        ------
        ReductionError
            If there is no such frame.
        """
        n_frame, rows, columns = self.shape
        for index in indices:
            if not 0 <= index < n_frame:
                raise ReductionError(f"frame {index} of {n_frame} asked for; ask for 0 to {n_frame - 1}")
        frames = np.empty((len(indices), rows, columns), np.uint16)
        self._fill(indices, frames)
        return frames

    def _fill(self, indices: list[int], out: npt.NDArray[Number]) -> None:
        """Make some frames, one after the other."""
        signal = np.empty(self.shape[1:], np.float32)
        for index, frame in zip(indices, out, strict=True):
            self.make(index, signal_dn=signal, out=frame)


def _shares(n: int) -> list[slice]:
    """Split n frames into one run of neighbours per processor."""
    workers = min(n, cpu_count() or 1)
    return [slice(n * part // workers, n * (part + 1) // workers) for part in range(workers)]


def nonuniformity_reference(radiance: Radiance, pattern: FixedPattern, *, seed: int) -> NonuniformityReference:
    """Bare blackbody at the two reference temperatures: frames as the camera gives them, and their mean."""
    shape = (radiance.reference_frames, *pattern.gain.shape)
    low_dn = radiance.level_dn(radiance.reference_low_k)
    high_dn = radiance.level_dn(radiance.reference_high_k)
    low = BlackbodyShots(level_dn=low_dn, pattern=pattern, purpose="reference_low", seed=seed)
    high = BlackbodyShots(level_dn=high_dn, pattern=pattern, purpose="reference_high", seed=seed)
    low_frames = SimulatedFrames(shape=shape, make=low)
    high_frames = SimulatedFrames(shape=shape, make=high)
    low_mean, low_noise = _mean_frame(low_frames)
    high_mean, high_noise = _mean_frame(high_frames)
    return NonuniformityReference(
        low_dn=low_mean,
        high_dn=high_mean,
        low_noise_dn=low_noise,
        high_noise_dn=high_noise,
        n_frames=radiance.reference_frames,
        low_temperature_k=radiance.reference_low_k,
        high_temperature_k=radiance.reference_high_k,
        low_frames=low_frames,
        high_frames=high_frames,
    )


def _mean_frame(frames: SimulatedFrames) -> tuple[Array, Array]:
    """Mean and standard deviation over the frames, shape (row, column), DN."""
    n, *size = frames.shape
    total, squares = np.zeros(size, np.int64), np.zeros(size, np.int64)
    for _, block in frames.blocks():
        total += block.sum(axis=0, dtype=np.int64)
        squares += np.square(block, dtype=np.int64).sum(axis=0)
    mean = total / n
    variance = np.maximum(squares - mean * total, 0) / max(n - 1, 1)
    return mean, np.sqrt(variance)
