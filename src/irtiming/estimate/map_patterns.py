"""What a map says of the readout: row delay, means over rows and columns, and parts of the image that are read later than others.

What an error of the opening's shape in the image does to the delays looks much like a readout that is slow along some direction:
the shape was fitted to the phases of the same frames. So each pattern is sought beside all numbers of the shape, which are free
to move a hundred of their standard uncertainties; what they could explain is not called a pattern.
"""

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.special import chdtrc

from irtiming.estimate.row_light import slopes
from irtiming.physics import blurred_sector, robust
from irtiming.records.arrays import Array, Mask, Ticks
from irtiming.records.pixel_maps import ReadoutPattern
from irtiming.records.row_timing import SectorFit, SectorShape

_FREE = 100.0  # standard uncertainties of the shape's numbers
_FAR, _FEW = 8.0, 0.01  # standard uncertainties, and share of the pixels that may be as far as that by themselves
PATTERNS = ("odd columns", "odd rows", "right half", "lower half", "middle rows")
"""Which pixels are asked whether they are read later than the others; of middle rows how far they stand above the chord."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class MappedDelays:
    """Delays of pixels and what is known of them.

    Shapes (p,): places, delay and u by noise. ``shape_s`` (p, n) is the change of the delays by independent standard
    uncertainties of the opening's shape; ``image_rows`` and ``image_columns`` are the size of the image.
    """

    row_px: Ticks
    column_px: Ticks
    delay_s: Array
    u_s: Array
    shape_s: Array
    image_rows: int
    image_columns: int

    @property
    def line(self) -> Array:
        """A common delay and a row delay, shape (p, 2)."""
        return np.stack([np.ones(self.row_px.size), self.row_px / self.image_rows], axis=1)

    def some(self, these: Mask) -> "MappedDelays":
        """Of some of the pixels, (p,)."""
        return replace(
            self, row_px=self.row_px[these], column_px=self.column_px[these], delay_s=self.delay_s[these],
            u_s=self.u_s[these], shape_s=self.shape_s[these],
        )  # fmt: skip


def u_shape_s(sound: MappedDelays, every: MappedDelays) -> Array:
    """What errors of the shape add to the delays of pixels beyond a common delay and a row delay, shape (p,), s.

    Parameters
    ----------
    sound, every
        Pixels that tell the common delay and the row delay, and those that are asked for.
    """
    unit = sound.u_s[:, None]
    slope, *_ = np.linalg.lstsq(sound.line / unit, sound.shape_s / unit, rcond=None)
    return np.asarray(np.sqrt(np.sum((every.shape_s - every.line @ slope) ** 2, axis=1)))


def shape_effect_s(sector: SectorFit, *, row_px: Ticks, column_px: Ticks, omega: float) -> Array:
    """Change of the pixels' delays by independent standard uncertainties of the shape's numbers, s, shape (p, n).

    Parameters
    ----------
    sector
        The opening in the image, with the covariance of its numbers.
    row_px, column_px
        Shape (p,).
    omega
        Angular frequency of the wheel, rad/s.
    """

    def angle(shape: SectorShape) -> Array:
        place, _ = blurred_sector.pixel_places(shape, roi=sector.roi)
        return np.asarray(place[row_px - sector.roi[0], column_px - sector.roi[2]])

    sizes, axes = np.linalg.eigh(sector.covariance)
    return np.asarray(slopes(angle, sector).T @ (axes * np.sqrt(np.maximum(sizes, 0.0))) / omega)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowClock:
    """Delay over rows, as a straight line.

    ``row_delay_s`` is its slope, ``left_s`` (p,) what is left of each pixel, ``scatter`` how much more that scatters than noise.
    """

    row_delay_s: float
    u_row_delay_s: float
    left_s: Array
    scatter: float


def row_clock(delays: MappedDelays) -> RowClock:
    """Straight line over rows, beside errors of the shape as large as they may be.

    Parameters
    ----------
    delays
        Of pixels in two rows or more.
    """
    _, _, left = _beside(delays, [delays.row_px.astype(float)], freedom=_FREE)
    pulls = left / delays.u_s
    scatter = max(1.0, robust.spread(pulls - np.median(pulls)))
    noisy = replace(delays, u_s=delays.u_s * scatter)
    found, covariance, _ = _beside(noisy, [delays.row_px.astype(float)], freedom=1.0)
    return RowClock(
        row_delay_s=float(found[1]),
        u_row_delay_s=float(np.sqrt(covariance[1, 1])),
        left_s=left,
        scatter=scatter,
    )


def near(delays: MappedDelays, clock: RowClock) -> MappedDelays:
    """The pixels without those that stray far by themselves; all of them where so many do that it is a part of the readout.

    Parameters
    ----------
    delays, clock
        Of the same pixels.
    """
    these = np.abs(clock.left_s) < _FAR * clock.scatter * delays.u_s
    return delays.some(these) if these.mean() > 1 - _FEW else delays


def patterns(delays: MappedDelays, clock: RowClock) -> tuple[ReadoutPattern, ...]:
    """How much later each of PATTERNS is read, one after the other, beside a row delay and the shape.

    Parameters
    ----------
    delays, clock
        Of the same pixels.
    """
    found = []
    for name in PATTERNS:
        column = _pattern(name, delays)
        if column is None:
            continue
        value, covariance, _ = _beside(delays, [delays.row_px.astype(float), column], freedom=_FREE)
        u = float(np.sqrt(covariance[2, 2])) * clock.scatter
        found.append(ReadoutPattern(name=name, later_s=float(value[2]), u_later_s=u))
    return tuple(found)


def p_value_of_straight_rows(delays: MappedDelays, clock: RowClock) -> tuple[float, int, float]:
    """Chance that rows of a straight clock scatter as these do; the row that strays most, and by how much, s.

    Parameters
    ----------
    delays, clock
        Of the same pixels.
    """
    rows, place = np.unique(delays.row_px, return_inverse=True)
    weight = np.bincount(place, 1 / delays.u_s**2)
    mean = np.bincount(place, clock.left_s / delays.u_s**2) / weight
    pulls = mean * np.sqrt(weight) / clock.scatter
    worst = int(np.argmax(np.abs(pulls)))
    return float(chdtrc(max(rows.size - 2, 1), np.sum(pulls**2))), int(rows[worst]), float(mean[worst])


def _pattern(name: str, delays: MappedDelays) -> Array | None:
    """1 where a pixel is of it, 0 elsewhere, (p,); None where the map holds one kind of pixel alone."""
    row, column = delays.row_px, delays.column_px
    if name == "middle rows":
        place = 2 * (row - row.min()) / max(np.ptp(row), 1) - 1
        return np.asarray(1 - place**2)
    one: Mask = {
        "odd columns": column % 2 == 1,
        "odd rows": row % 2 == 1,
        "right half": column >= delays.image_columns / 2,
        "lower half": row >= delays.image_rows / 2,
    }[name]
    return one.astype(float) if 0.02 < one.mean() < 0.98 else None


def _beside(delays: MappedDelays, columns: list[Array], *, freedom: float) -> tuple[Array, Array, Array]:
    """Least squares in a constant, these columns and the shape, known to ``freedom`` times its u: numbers, covariance, rest."""
    scale = np.array([1.0] + [1 / max(np.abs(one).max(), 1e-300) for one in columns] + [1.0] * delays.shape_s.shape[1])
    design = np.column_stack([np.ones(delays.row_px.size), *columns, freedom * delays.shape_s]) * scale
    unit = delays.u_s[:, None]
    n_own = 1 + len(columns)
    prior = np.diag([0.0] * n_own + [1.0] * delays.shape_s.shape[1])
    size = float(np.median(delays.u_s))
    design[:, :n_own] *= size
    white = design / unit
    normal = white.T @ white + prior
    found = np.linalg.solve(normal, white.T @ (delays.delay_s / delays.u_s))
    back = np.concatenate([scale[:n_own] * size, np.ones(delays.shape_s.shape[1])])
    covariance = np.linalg.inv(normal) * np.outer(back, back)
    return found * back, covariance, delays.delay_s - design @ found
