"""Row sums compressed to what a periodic model can say about them: exact, and hundreds of times smaller.

A periodic model is f_n = Re sum_m F_m exp(i m theta_n), that is F . B with the real basis B (1, cos, sin of the wheel angles).
The sum of squares of d - F . B is d.d - 2 F . (B d) + F . (B B^T) . F. So B d of each row, and B B^T for all rows together,
hold all that the frames say; frames may be missing or uneven as they like. Gain and offset of each row are eliminated
within: the offset by taking the mean off, the gain by projection.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from irtiming.records.arrays import Array, ComplexArray

_RANK = 1e-12  # of the largest eigenvalue: what is below, frames do not tell apart
_ROUNDING = 1e-12  # of the sum of squares


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WhiteData:
    """Sum of squares of a row's residuals from a model F: |root F - target|^2 + rest.

    Shapes: ``root`` (k, p) with k at most p, ``target`` (n_row, k), ``rest`` (n_row,), what no periodic model explains, and the
    rounding at least.
    """

    root: Array
    target: Array
    rest: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class HarmonicData:
    """One stretch of frames with offsets of its own.

    Shapes: ``gram`` (p, p) is B B^T less its mean, ``moment`` (n_row, p) is B d less its mean, ``power`` (n_row,) the sum of
    squares about the mean; p = 2 M + 1. ``n_frames`` is their number; ``frames`` are they themselves, where they are no more
    than p.
    """

    gram: Array
    moment: Array
    power: Array
    n_frames: int
    frames: WhiteData | None = None

    @cached_property
    def white(self) -> WhiteData:
        """The same, as plain least squares."""
        if self.frames is not None:
            return self.frames
        sizes, axes = np.linalg.eigh(self.gram)
        kept = sizes > _RANK * sizes[-1]
        root = np.sqrt(sizes[kept])
        target = self.moment @ axes[:, kept] / root
        rest = self.power - np.einsum("rk,rk->r", target, target)
        return WhiteData(
            root=root[:, None] * axes[:, kept].T, target=target, rest=np.maximum(rest, _ROUNDING * self.power)
        )

    def lowest(self, n_harmonics: int) -> "HarmonicData":
        """The same with fewer harmonics."""
        most = (self.gram.shape[0] - 1) // 2
        keep = np.concatenate([np.arange(n_harmonics + 1), most + 1 + np.arange(n_harmonics)])
        frames = self.frames and replace(self.frames, root=self.frames.root[:, keep])
        return replace(self, gram=self.gram[np.ix_(keep, keep)], moment=self.moment[:, keep], frames=frames)

    def some_rows(self, rows: slice) -> "HarmonicData":
        """The same with fewer rows."""
        whole = self.frames
        frames = whole and replace(whole, target=whole.target[rows], rest=whole.rest[rows])
        return replace(self, moment=self.moment[rows], power=self.power[rows], frames=frames)


def compress(wheel_angle_rad: Array, values: Array, *, n_harmonics: int) -> HarmonicData:
    """Moments of the values.

    Parameters
    ----------
    wheel_angle_rad
        Shape (n,).
    values
        Shape (n, n_row).
    n_harmonics
        Highest order M.
    """
    waves = basis(wheel_angle_rad, n_harmonics=n_harmonics)
    centred = values - values.mean(axis=0)
    waves_mean = waves.mean(axis=1, keepdims=True)
    power = np.einsum("nr,nr->r", centred, centred)
    few = wheel_angle_rad.size <= len(waves)
    return HarmonicData(
        gram=_gram(wheel_angle_rad, n_harmonics) - wheel_angle_rad.size * (waves_mean @ waves_mean.T),
        moment=(waves @ centred).T,
        power=power,
        n_frames=wheel_angle_rad.size,
        frames=WhiteData(root=(waves - waves_mean).T, target=centred.T, rest=_ROUNDING * power) if few else None,
    )


def basis(wheel_angle_rad: Array, *, n_harmonics: int) -> Array:
    """1, cos(m theta), sin(m theta); shape (2 M + 1, n)."""
    wave = np.exp(1j * wheel_angle_rad)
    powers = np.empty((n_harmonics + 1, wheel_angle_rad.size), complex)
    powers[0] = 1.0
    done = 1
    while done <= n_harmonics:  # powers by doubling: each row is one multiplication from an earlier one
        more = min(done, n_harmonics + 1 - done)
        powers[done : done + more] = powers[:more] * wave**done
        done += more
    return np.concatenate([powers.real, powers.imag[1:]])


def packed(harmonics: ComplexArray) -> Array:
    """Coefficients in the basis of `basis`, shape (..., 2 M + 1), of harmonics of shape (..., M + 1)."""
    return np.concatenate([harmonics.real, -harmonics.imag[..., 1:]], axis=-1)


def _gram(wheel_angle_rad: Array, n_harmonics: int) -> Array:
    """B B^T from the sums of exp(i k theta), k to 2 M: products of waves are waves of sums and differences."""
    waves = basis(wheel_angle_rad, n_harmonics=2 * n_harmonics).sum(axis=1)
    cosine, sine = np.split(waves, [2 * n_harmonics + 1])
    sine = np.concatenate([[0.0], sine])
    first, second = np.arange(n_harmonics + 1)[:, None], np.arange(n_harmonics + 1)[None, :]
    total, apart = first + second, np.abs(first - second)
    sign = np.sign(first - second)
    cc = (cosine[apart] + cosine[total]) / 2
    ss = (cosine[apart] - cosine[total]) / 2
    sc = (sine[total] + sign * sine[apart]) / 2  # sin(first) cos(second)
    return np.block([[cc, sc.T[:, 1:]], [sc[1:, :], ss[1:, 1:]]])
