"""Gain and offset that go with the temperature of a camera: smooth, of no particular shape, another one in each run."""

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from irtiming.records.arrays import Array
from irtiming.twin.noise import generator
from irtiming.twin.upkeep import Sway

_WAVES, _SHORTEST, _LONGEST = 4, 0.3, 3.0
"""A sway is so many waves; their periods in units of its time."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Swayed:
    """Relative gain, and offset in units of the contrast, shape (n_exposure,)."""

    gain: Array
    offset: Array


def swayed(sway: Sway, time_s: Array, *, seed: int) -> Swayed:
    """Gain and offset at some moments of a run.

    Parameters
    ----------
    sway
        How much they go up and down.
    time_s
        Shape (n_exposure,), s from the first trigger.
    seed
        Of the run.
    """
    gain, offset = (
        share * _shape(sway, time_s, generator(seed, "sway", index=index)) if share else np.zeros(time_s.shape)
        for index, share in enumerate((sway.gain_share, sway.offset_share))
    )
    return Swayed(gain=gain, offset=offset)


def _shape(sway: Sway, time_s: Array, random: np.random.Generator) -> Array:
    """Sum of random waves, from the lowest to the highest 1 within the sway's time, 0 at first."""
    period_s = sway.within_s * np.exp(random.uniform(math.log(_SHORTEST), math.log(_LONGEST), _WAVES))
    height = random.standard_normal(_WAVES) * period_s
    phase = random.uniform(0, 2 * math.pi, _WAVES)

    def at(moment_s: Array) -> Array:
        return np.asarray(np.sin(2 * math.pi * moment_s[:, None] / period_s + phase) @ height)

    whole = at(np.linspace(0, sway.within_s, 500))
    return (at(np.asarray(time_s)) - whole[0]) / np.ptp(whole)
