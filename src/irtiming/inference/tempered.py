"""Draws from a posterior that may be bent or have several summits, of few numbers and a likelihood that is quickly computed.

A crowd of draws from the prior is led to the posterior by letting the likelihood in little by little (Del Moral, Doucet and Jasra
2006): at each step draws are multiplied or dropped by what the likelihood gained, then moved along differences of other draws
(ter Braak 2006), which fit any scale and direction by themselves.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.errors import EstimationError
from irtiming.records.arrays import Array

_SEED = 2023
_KEPT = 0.5  # of the draws: how many, in effect, a step may leave apart
_MOVES, _LAST_MOVES, _EVERY = 6, 48, 6
_JUMP = 2.38  # over the root of twice the dimensions: the best length of a difference where all is normal
_JUMPS = (0.2, 1.1)  # of it: shorter and longer in turn
_FULL_JUMPS = 0.1  # share of moves by whole differences, which lead from one summit to another


def draws(log_likelihood: Callable[[Array], Array], *, n_numbers: int, n_draws: int = 1000) -> Array:
    """Draws of numbers whose priors are independent standard normal ones.

    Parameters
    ----------
    log_likelihood
        Of draws of shape (n, n_numbers), shape (n,); minus infinity where numbers are impossible.
    n_numbers
        How many they are, one at least.
    n_draws
        How many go together, an even number; the same every time it is called.

    Returns
    -------
    Shape (n, n_numbers), n some times ``n_draws``: the crowd at several times.

    Raises
    ------
    EstimationError
        If none of the first draws is possible: no share of the likelihood, however small, could be let in.
    """
    rng = np.random.default_rng(_SEED)
    at = rng.standard_normal((n_draws, n_numbers))
    crowd = _Crowd(likelihood=log_likelihood, rng=rng, at=at, log_density=log_likelihood(at))
    if not np.isfinite(crowd.log_density.max()):
        raise EstimationError(
            f"none of {n_draws} draws of what is known beforehand is possible; check what rig.toml states of the lens"
        )
    share = 0.0
    while share < 1.0:
        rise = _rise(crowd.log_density, 1.0 - share)
        crowd.pick(np.exp(rise * (crowd.log_density - crowd.log_density.max())))
        share += rise  # just 1 in the end: s + (1 - s) is 1 however 1 - s was rounded
        for _ in range(_MOVES):
            crowd.move(share)
    found = []
    for k in range(_LAST_MOVES):
        crowd.move(1.0)
        if k % _EVERY == _EVERY - 1:
            found.append(crowd.at.copy())
    return np.concatenate(found)


def _rise(log_density: Array, most: float) -> float:
    """How much more of the likelihood leaves the wanted number of draws in effect; at most ``most``."""

    def left(rise: float) -> float:
        weight = np.exp(rise * (log_density - log_density.max()))
        return float(weight.sum() ** 2 / (weight @ weight) / weight.size)

    if left(most) >= _KEPT:
        return most
    low, high = 0.0, most
    while high - low > 1e-3 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if left(middle) >= _KEPT else (low, middle)
    return high


@final
@dataclass(kw_only=True, eq=False)
class _Crowd:
    """Draws (n, n_numbers) and their log-likelihood (n,)."""

    likelihood: Callable[[Array], Array]
    rng: np.random.Generator
    at: Array
    log_density: Array

    def pick(self, weight: Array) -> None:
        """Each as often as its weight says, in a new order."""
        ends = np.cumsum(weight) / weight.sum()
        places = (self.rng.random() + np.arange(weight.size)) / weight.size
        chosen = self.rng.permutation(np.minimum(np.searchsorted(ends, places), weight.size - 1))
        self.at, self.log_density = self.at[chosen], self.log_density[chosen]

    def move(self, share: float) -> None:
        """Each half once, by differences of the other half, which leaves the tempered posterior as it is."""
        half, n_numbers = len(self.at) // 2, self.at.shape[1]
        halves = slice(0, half), slice(half, 2 * half)
        for own, other in (halves, halves[::-1]):
            first, second = self.rng.integers(0, half, (2, half))
            length = _JUMP / np.sqrt(2 * n_numbers) * self.rng.uniform(*_JUMPS, half)
            length[self.rng.random(half) < _FULL_JUMPS] = 1.0
            new = self.at[own] + length[:, None] * (self.at[other][first] - self.at[other][second])
            log_density = self.likelihood(new)
            gain = share * (log_density - self.log_density[own]) - 0.5 * np.sum(new**2 - self.at[own] ** 2, axis=1)
            taken = np.log(self.rng.random(half)) < gain
            self.at[own][taken], self.log_density[own][taken] = new[taken], log_density[taken]
