r"""The harmonics of every pixel's signal over the wheel angle, and the noise of every pixel, from sums with waves.

Of a recording whose frames visit all wheel angles alike, the sums with two waves know nothing of each other. Else

.. math:: p = X f + l(C, \delta) + \mathrm{noise}, \qquad \mathrm{cov} = \sigma^2 W W^T

with f the harmonics of the signal orders, X the waves W times what those show in each frame, and l what leaks into the sums from
all other orders, and from all where the gain of the frames sways. The leak is what the wheel would show of them with the pixel's
own contrast and delay, so it is small twice over: a few missing frames, or a gain that hardly differs, times the orders that are
left out. The sums with quiet orders, rid of the leak and of what they share with the others, are noise alone; there are enough
of them for a standard deviation of each pixel's own.
"""

from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.physics import wheel_waves
from irtiming.physics.wheel import TURN
from irtiming.records.arrays import Array, ComplexArray
from irtiming.records.pixel_waves import PixelWaves

_TABLE = 4096  # of the leak, over the turn
_CLASSES = 12  # of pixels, by how much of the turn each sees at once
_WORST = 1e-3  # least eigenvalue of the waves' products over their mean: below, frames do not tell the orders apart


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Leak:
    """What all orders but the signal ones, and a gain that sways, would add to the sums, of pixels with a contrast of 1.

    ``spectrum`` (k, M + 1) is what each order of a point's light adds to each of the k sums.
    """

    spectrum: ComplexArray

    def of(self, angle_rad: Array, reach_rad: Array) -> Array:
        """Of pixels about these angles, smeared by so much, shapes (p,); shape (k, p)."""
        ends = np.quantile(reach_rad, np.linspace(0, 1, _CLASSES + 1)[1:-1])
        kind = np.searchsorted(ends, reach_rad)
        place = np.mod(angle_rad, TURN) * (_TABLE / TURN)
        below = np.floor(place).astype(int)
        part, below = place - below, below % _TABLE
        out = np.zeros((len(self.spectrum), angle_rad.size))
        order = np.arange(self.spectrum.shape[1])
        for k in np.unique(kind):
            these = kind == k
            smear = np.exp(-0.5 * (order * reach_rad[these].mean()) ** 2)
            table = np.fft.fft(self.spectrum * smear, n=_TABLE, axis=1).real
            low, high = table[:, below[these]], table[:, (below[these] + 1) % _TABLE]
            out[:, these] = low + part[these] * (high - low)
        return out


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class SumsWithWaves:
    """Sums of a recording, and the algebra of its waves.

    Shapes, with s signal and q quiet orders: ``signal`` (2 s, p) and ``quiet`` (2 q, p) are the sums; ``shown`` (2 s, 2 s) is X,
    ``shared`` (2 q, 2 s) takes from the quiet sums what they share with the signal ones, ``quiet_root`` makes them white.
    ``root`` (2 s, 2 s) makes harmonics white with the standard deviation of a pixel's noise.
    """

    signal: Array
    quiet: Array
    shown: Array
    shared: Array
    quiet_root: Array
    root: Array
    leak: Leak

    def harmonics(self, leak: Array) -> Array:
        """Real parts of the signal harmonics, then minus their imaginary parts; shape (2 s, p); ``leak`` as of `Leak.of`."""
        return np.asarray(np.linalg.solve(self.shown, self.signal - leak[: len(self.signal)]), float)

    def noise(self, leak: Array) -> Array:
        """Standard deviation of each pixel from frame to frame, shape (p,), by 2 q degrees of freedom."""
        own = self.quiet - leak[len(self.signal) :] - self.shared @ (self.signal - leak[: len(self.signal)])
        return np.asarray(np.sqrt(np.mean((self.quiet_root @ own) ** 2, axis=0)))


def sums_with_waves(
    waves: PixelWaves, wheel_angle_rad: Array, *, relative_gain: Array, point: ComplexArray, name: str
) -> SumsWithWaves:
    """What a recording's sums say.

    Parameters
    ----------
    waves
        As the reduction made them.
    wheel_angle_rad
        Shape (n,); of the same frames, as known by now.
    relative_gain
        Shape (n,); of the same frames, over its mean.
    point
        Shape (M + 1,); harmonics of a point of light at the bisector, as its pixel gives them.
    name
        Of the recording.

    Raises
    ------
    EstimationError
        If the frames leave so much of the turn out that they do not tell the orders apart.
    """
    n_signal, orders = waves.signal_orders.size, waves.orders
    weight = wheel_waves.waves(waves.wheel_angle_rad, orders, segment=waves.segment)
    signal_at = np.r_[:n_signal, orders.size : orders.size + n_signal]
    quiet_at = np.setdiff1d(np.arange(2 * orders.size), signal_at)
    gram = weight @ weight.T
    sizes = np.linalg.eigvalsh(gram[np.ix_(signal_at, signal_at)])
    if not sizes[0] > _WORST * sizes.mean():
        raise EstimationError(
            f"{name}: its {wheel_angle_rad.size} frames leave parts of the turn out, so that they do not separate the wheel's "
            f"orders {waves.signal_orders[0]} to {waves.signal_orders[-1]} in each pixel; record frames at all wheel angles, or "
            "ask for no maps"
        )
    phase = np.multiply.outer(waves.signal_orders, wheel_angle_rad)
    shown = weight[signal_at] @ np.concatenate([np.cos(phase), np.sin(phase)]).T
    between = np.linalg.solve(gram[np.ix_(signal_at, signal_at)], gram[np.ix_(signal_at, quiet_at)])
    left = gram[np.ix_(quiet_at, quiet_at)] - gram[np.ix_(quiet_at, signal_at)] @ between
    information = shown.T @ np.linalg.solve(gram[np.ix_(signal_at, signal_at)], shown)
    every = np.exp(1j * np.multiply.outer(np.arange(point.size), wheel_angle_rad))
    spectrum = ((weight * relative_gain) @ every.T) * point
    spectrum[:, waves.signal_orders] -= (weight @ every[waves.signal_orders].T) * point[waves.signal_orders]
    spectrum[:, 0] = 0
    picked = np.concatenate([signal_at, quiet_at])
    return SumsWithWaves(
        signal=waves.sums_dn[signal_at],
        quiet=waves.sums_dn[quiet_at],
        shown=shown,
        shared=between.T,
        quiet_root=np.linalg.inv(np.linalg.cholesky(left)),
        root=np.linalg.cholesky(information).T,
        leak=Leak(spectrum=spectrum[picked]),
    )
