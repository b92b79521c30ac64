"""Causes of structured residuals that the fit does not have: what each adds to the sums, per unit, frame by frame."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.polynomial import legendre

from irtiming.estimate.frame_residuals import FrameResiduals, harmonics
from irtiming.records.arrays import Array

Columns = Callable[[FrameResiduals], list[Array]]
"""What a cause adds, per unit of each of its numbers, shapes (n, n_band)."""

_TAILS_S = (0.3e-3, 1e-3, 3e-3)
_WINDOW_S = 0.2e-3  # root of the variance that a longer window adds in its middle: short, as such windows are
_HALOS_RAD = (0.02, 0.05, 0.15)
_JUMPS = (-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75)


@final
@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A cause by its name, what it adds, and what to do about it; ``of_rows``: only bands of rows show it."""

    name: str
    columns: Columns
    cure: str
    of_rows: bool = False


def _frame_before(frames: FrameResiduals) -> list[Array]:
    change = np.zeros_like(frames.fraction)
    follows = np.diff(frames.number) == 1
    change[1:][follows] = (frames.fraction[:-1] - frames.fraction[1:])[follows]
    return [change]


def _polynomials(frames: FrameResiduals, orders: range) -> Array:
    return np.stack([legendre.legval(frames.time, np.eye(max(orders) + 1)[k]) for k in orders])[:, :, None]


def _level_sways(frames: FrameResiduals) -> list[Array]:
    return [one * np.ones_like(frames.fraction) for one in _polynomials(frames, range(2, 6))]


def _gain_sways(frames: FrameResiduals) -> list[Array]:
    return [one * (frames.fraction - frames.fraction.mean(axis=0)) for one in _polynomials(frames, range(1, 5))]


def _level_jumps(frames: FrameResiduals) -> list[Array]:
    return [(frames.time > place)[:, None] * np.ones_like(frames.fraction) for place in _JUMPS]


def _half(frames: FrameResiduals, from_open_rad: float) -> Array:
    """1 in one half turn, -1 in the other; it begins this far before the middle of an open plateau."""
    return np.asarray(np.sign(np.sin(frames.angle_rad - frames.open_at_rad + from_open_rad)))[:, None]


def _blades(frames: FrameResiduals) -> list[Array]:
    return [(1 - frames.fraction) * _half(frames, 0.0)]


def _cutouts(frames: FrameResiduals) -> list[Array]:
    return [frames.fraction * _half(frames, np.pi / 2)]


def _once_a_turn(frames: FrameResiduals) -> list[Array]:
    ones = np.ones_like(frames.fraction)
    return [np.cos(frames.angle_rad)[:, None] * ones, np.sin(frames.angle_rad)[:, None] * ones]


def _not_linear(frames: FrameResiduals) -> list[Array]:
    return [frames.fraction * (1 - frames.fraction)]


def _bent_edge(frames: FrameResiduals) -> list[Array]:
    return [frames.fraction * (1 - frames.fraction) * np.sign(frames.slope)]


def _tails(frames: FrameResiduals) -> list[Array]:
    lag = [frames.omega_rad_per_s * tail_s for tail_s in _TAILS_S]
    return [frames.filtered(1 / (1 + 1j * harmonics() * one) - 1) for one in lag]


def _halo(frames: FrameResiduals) -> list[Array]:
    return [frames.filtered(np.exp(-((harmonics() * width) ** 2) / 2) - 1 + 0j) for width in _HALOS_RAD]


def _speed_once_a_turn(frames: FrameResiduals) -> list[Array]:
    slope = frames.slope / frames.omega_rad_per_s
    return [slope * np.cos(frames.angle_rad)[:, None], slope * np.sin(frames.angle_rad)[:, None]]


def _rows_bend(frames: FrameResiduals) -> list[Array]:
    slope, row = frames.slope / frames.omega_rad_per_s, frames.row[None, :]
    return [slope * row**2, np.abs(slope) * row, np.abs(slope) * row**2]


def _every_second(frames: FrameResiduals) -> list[Array]:
    sign = np.where(frames.number % 2 == 0, 1.0, -1.0)[:, None]
    return [sign * np.ones_like(frames.fraction), sign * frames.fraction]


CANDIDATES = (
    Candidate(
        name="each frame keeps a share of the one before", columns=_frame_before,
        cure="switch noise reduction and frame averaging in the camera off, and record again",
    ),
    Candidate(name="the level sways", columns=_level_sways, cure="let camera and blackbody settle longer, and record again"),
    Candidate(name="the gain sways", columns=_gain_sways, cure="let camera and blackbody settle longer, and record again"),
    Candidate(
        name="the level jumps", columns=_level_jumps,
        cure="switch the camera's own corrections off while recording, or record between them",
    ),
    Candidate(
        name="the two blades have unlike temperatures", columns=_blades,
        cure="let the wheel run before recording, shield it from the blackbody",
    ),
    Candidate(name="the two cutouts show unlike scenes", columns=_cutouts, cure="look for dirt and reflections on one of them"),
    Candidate(
        name="something goes round with the wheel once a turn", columns=_once_a_turn,
        cure="look for reflections off the wheel, and check that it is clean",
    ),
    Candidate(
        name="the detector is not linear", columns=_not_linear,
        cure="choose an integration time and temperatures with less contrast, and check for saturation",
    ),
    Candidate(name="a mask edge is bent", columns=_bent_edge, cure="look at the edges of the mask"),
    Candidate(
        name="the window or the lag has a tail", columns=_tails,
        cure="record another wheel speed; check the camera's integration time and mode",
    ),
    Candidate(
        name="light is spread over an angle (blur or glare)", columns=_halo,
        cure="clean the lens, and shade it from the blackbody",
    ),
    Candidate(
        name="the wheel's speed or its slots err once a turn", columns=_speed_once_a_turn,
        cure="calibrate the wheel at two speeds, and check its lock",
    ),
    Candidate(
        name="timing bends over the rows (tilt, lens, or mask off the axle)", columns=_rows_bend, of_rows=True,
        cure="set the camera square to the wheel, or give a calibration of its lens",
    ),
    Candidate(
        name="every second frame differs", columns=_every_second,
        cure="the camera reads through two channels or skips triggers: look at frames one by one",
    ),
)  # fmt: skip
"""All that are tried."""


def fitted(frames: FrameResiduals, *, lag_s: float | None) -> dict[str, Array]:
    """What the numbers that every fit has add to the sums, by name, shapes (n, n_band); levels of the bands apart.

    Parameters
    ----------
    frames
        Residuals of one recording.
    lag_s
        The camera's time constant, s; None for one that has a window instead.
    """
    slope = frames.slope
    half = _half(frames, 0.0) > 0
    columns = {f"edge {k}": slope * ((slope > 0) == bool(k % 2)) * (half == bool(k // 2)) for k in range(4)}
    if frames.row.size > 1:
        columns["row delay"] = slope * frames.row[None, :]
    order = 1j * harmonics() * frames.omega_rad_per_s
    if lag_s is not None:
        columns["time constant"] = frames.filtered(-order / (1 + order * lag_s))
    else:
        columns["window"] = frames.filtered(1 / (1 - (order * _WINDOW_S) ** 2) - 1)
    return columns
