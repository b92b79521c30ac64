r"""What the sum over one image row sees over the wheel angle, and its derivatives to all that times it.

Row y sees the opening through a weight over polar angle (`physics.blurred_sector`), the wheel covers and uncovers it, the pixels
respond (`physics.response`), frames keep a share of those before, and the row is read in its turn (`physics.readout`). All are
factors on the harmonics:

.. math:: F_{ym} = \left(\sum_i o_i K_y - \sum_{i = 2, 3} o_i (b K_y + b' B_y)\right)_m R_m\, G_m\, e^{i m \omega (d_i + t_y)}

with :math:`o_i` the step that wheel edge i makes, :math:`K_y` the row's light, :math:`b` the share by which the blade between
the edges 2 and 3 is warmer and :math:`b'` that by which it looks warmer before the mask plate, :math:`B_y` the summed pixels
there over which the cutouts sweep, :math:`R` the response, :math:`G` the memory over that part of it that was undone in the
data, :math:`t_y` the time by which the row is read after row 0, and one delay :math:`d_i` per wheel edge, because the cutout's
edges need not stand where the ring's do.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias, final

import numpy as np

from irtiming.physics.camera import Camera
from irtiming.physics.light import bent_rows
from irtiming.physics.light.bent_rows import NONLINEARITIES, PixelPowers
from irtiming.physics.wheel_harmonics import later
from irtiming.records.arrays import Array, ComplexArray

EDGE_DELAYS = tuple(f"edge_delay_{edge}" for edge in range(4))
"""Delays of row 0 as the passing of each wheel edge gives them."""

BLADE = "blade_share"
"""By how much the blade between edges 2 and 3 is warmer than the other one, over the contrast between that and the opening."""

BESIDE = "blade_share_beside"
"""The same where cutouts sweep beside the opening: a blade is not as warm at its rim, and a plate may mirror it."""

BLADES = (BLADE, BESIDE)

Timing: TypeAlias = Mapping[str, float]
"""Numbers of one camera by name: EDGE_DELAYS, the response's parameter, s; the memory's, 1; BLADES; those of the readout, s.

And NONLINEARITIES, 0 where they are left out.
"""


def completed(timing: Timing) -> dict[str, float]:
    """The same with numbers that rows need not hold: beside the opening the blade of the opening, and a straight response."""
    return {BESIDE: timing[BLADE]} | dict.fromkeys(NONLINEARITIES, 0.0) | dict(timing)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowSum:
    """Rows of a camera before the wheel: open_im, shape (4, M + 1), K_ym and B_ym, shape (n_row, M + 1), rows and omega.

    Without ``beside_harmonics``, B, the wheel shows where the opening is, and nowhere else; unless ``blades_apart``, b' is b.
    It turns by ``step_rad`` from trigger to trigger; ``undone`` is the share of the recursion that the data are rid of. With
    ``powers`` the response to light may be bent (`physics.light.bent_rows`).
    """

    camera: Camera
    open_harmonics: ComplexArray
    row_harmonics: ComplexArray
    row_px: Array
    angular_frequency_rad_per_s: float
    step_rad: float
    undone: float = 0.0
    beside_harmonics: ComplexArray | None = None
    blades_apart: bool = False
    powers: PixelPowers | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters, in the order of the derivatives: `timing_names`, without BESIDE where that is no number of its own.

        And NONLINEARITIES after them, where ``powers`` are given.
        """
        own = tuple(name for name in timing_names(self.camera) if name != BESIDE or self._is_apart)
        return own if self.powers is None else (*own, *NONLINEARITIES)

    @property
    def _is_apart(self) -> bool:
        return self.blades_apart and self.beside_harmonics is not None

    @property
    def n_harmonics(self) -> int:
        """Highest order M."""
        return int(self.row_harmonics.shape[1]) - 1

    def lowest(self, n_harmonics: int) -> "RowSum":
        """The same with fewer harmonics."""
        keep, beside = slice(n_harmonics + 1), self.beside_harmonics
        return replace(
            self, open_harmonics=self.open_harmonics[:, keep], row_harmonics=self.row_harmonics[:, keep],
            beside_harmonics=None if beside is None else beside[:, keep],
            powers=None if self.powers is None else self.powers.some(n_harmonics=n_harmonics),
        )  # fmt: skip

    def some_rows(self, rows: slice) -> "RowSum":
        """The same with fewer rows."""
        beside = self.beside_harmonics
        return replace(
            self, row_harmonics=self.row_harmonics[rows], row_px=self.row_px[rows],
            beside_harmonics=None if beside is None else beside[rows],
            powers=None if self.powers is None else self.powers.some(rows),
        )  # fmt: skip


def timing_names(camera: Camera) -> tuple[str, ...]:
    """Names of the parameters of a row sum: four edge delays, the response's, the memory's, the blades', those of the readout."""
    return (*EDGE_DELAYS, camera.response.PARAMETER, camera.memory.PARAMETER, *BLADES, *camera.readout.PARAMETERS)


def unit(parameter: str, camera: Camera) -> str:
    """Of a parameter of a row sum: a share has none, all others are times."""
    return "1" if parameter in (camera.memory.PARAMETER, *BLADES, *NONLINEARITIES) else "s"


def harmonics(rows: RowSum, timing: Timing) -> ComplexArray:
    """Harmonics F_ym of each row, shape (n_row, M + 1)."""
    passed, kept = _response(rows, timing), _memory(rows, timing)[0]
    edges = _edges(rows, timing)
    bare = _observed(rows, timing, edges=edges, lights=_lights(rows, timing))
    straight = np.asarray((bare * (passed * kept)).sum(axis=0))
    if rows.powers is None:
        return straight
    bends = bent_rows.bends(rows.powers, edges.sum(axis=0) * passed)
    return np.asarray(straight + kept * _read(rows, timing, _bent(bends, timing)))


def linearised(rows: RowSum, timing: Timing) -> tuple[ComplexArray, ComplexArray]:
    """`harmonics`, shape (n_row, M + 1), and their derivatives to each of ``rows.names``, (k, n_row, M + 1), per unit."""
    straight, slopes = _straight(rows, timing)
    if rows.powers is None:
        return straight, slopes
    omega, n, response = rows.angular_frequency_rad_per_s, rows.n_harmonics, rows.camera.response
    turning, edges, passed = 1j * np.arange(n + 1) * omega, _edges(rows, timing), _response(rows, timing)
    (kept, kept_slope), wave = _memory(rows, timing), edges.sum(axis=0)
    passed_slope = response.transfer_slope(omega, timing[response.PARAMETER], n_harmonics=n)
    moves = np.concatenate([edges * turning * passed, (wave * passed_slope)[None]])
    moved = bent_rows.bends_slopes(rows.powers, wave * passed, slopes=moves)
    bends = _read(rows, timing, bent_rows.bends(rows.powers, wave * passed))
    bent, later_rows = _bent(bends, timing), rows.camera.readout.read_later(rows.row_px)[:, :, None]
    slopes[: len(moves)] += kept * _read(rows, timing, _bent(moved, timing))
    slopes[len(moves)] += kept_slope * bent
    slopes[len(slopes) - len(later_rows) :] += later_rows * (kept * bent * turning)
    return straight + kept * bent, np.concatenate([slopes, kept * bends])


def _bent(bends: ComplexArray, timing: Timing) -> ComplexArray:
    """What the response's curve adds, of what it does per unit of its numbers, (2, ...)."""
    return np.asarray(np.tensordot([timing.get(name, 0.0) for name in NONLINEARITIES], bends, 1))


def _straight(rows: RowSum, timing: Timing) -> tuple[ComplexArray, ComplexArray]:
    """The same of a detector whose response is a straight line, and without the derivatives to what bends it."""
    omega, n, response = rows.angular_frequency_rad_per_s, rows.n_harmonics, rows.camera.response
    kept, kept_slope = _memory(rows, timing)
    passed = _response(rows, timing)
    slope = response.transfer_slope(omega, timing[response.PARAMETER], n_harmonics=n)
    edges, lights = _edges(rows, timing), _lights(rows, timing)
    bare = _observed(rows, timing, edges=edges, lights=lights)
    observed = bare * (passed * kept)
    by_edge = observed * (1j * np.arange(n + 1) * omega)
    by_blades = -edges[2:].sum(axis=0) * passed * kept * lights
    by_blades = by_blades if rows.blades_apart else by_blades.sum(axis=0)[None]
    by_readout = rows.camera.readout.read_later(rows.row_px)[:, :, None] * by_edge.sum(axis=0)
    return np.asarray(observed.sum(axis=0)), np.concatenate([
        by_edge, bare.sum(axis=0)[None] * slope * kept, bare.sum(axis=0)[None] * passed * kept_slope, by_blades, by_readout
    ])  # fmt: skip


def _edges(rows: RowSum, timing: Timing) -> ComplexArray:
    """Steps of the wheel's edges as row 0 is read, without response; shape (4, M + 1)."""
    delays = np.array([timing[name] for name in EDGE_DELAYS])
    return rows.open_harmonics * later(rows.angular_frequency_rad_per_s * delays, n_harmonics=rows.n_harmonics)


def _lights(rows: RowSum, timing: Timing) -> ComplexArray:
    """Light of the rows as they are read, and what shows beside it where that is known; shape (1 or 2, n_row, M + 1)."""
    known = [light for light in (rows.row_harmonics, rows.beside_harmonics) if light is not None]
    return _read(rows, timing, np.array(known))


def _observed(rows: RowSum, timing: Timing, *, edges: ComplexArray, lights: ComplexArray) -> ComplexArray:
    """What each edge adds to the rows as they are read, without response and memory; shape (4, n_row, M + 1)."""
    lit = edges[:, None, :] * lights[0]
    lit[2:] *= 1 - timing.get(BLADE, 0.0)
    for beside in lights[1:]:
        lit[2:] -= timing.get(BESIDE if rows._is_apart else BLADE, 0.0) * edges[2:, None, :] * beside
    return lit


def _read(rows: RowSum, timing: Timing, light: ComplexArray) -> ComplexArray:
    """Light of the rows as they are read, shape (..., n_row, M + 1)."""
    readout = rows.camera.readout
    read_s = np.array([timing[name] for name in readout.PARAMETERS]) @ readout.read_later(rows.row_px)
    return np.asarray(light * later(rows.angular_frequency_rad_per_s * read_s, n_harmonics=rows.n_harmonics))


def _response(rows: RowSum, timing: Timing) -> ComplexArray:
    """R_m, shape (M + 1,)."""
    response = rows.camera.response
    return response.transfer(rows.angular_frequency_rad_per_s, timing[response.PARAMETER], n_harmonics=rows.n_harmonics)


def _memory(rows: RowSum, timing: Timing) -> tuple[ComplexArray, ComplexArray]:
    """What the frames keep of those before, over what was undone, and its derivative to the share; shapes (M + 1,)."""
    memory, step, n = rows.camera.memory, rows.step_rad, rows.n_harmonics
    share, before = timing.get(memory.PARAMETER, 0.0), memory.transfer(step, rows.undone, n_harmonics=n)
    return (
        np.asarray(memory.transfer(step, share, n_harmonics=n) / before),
        np.asarray(memory.transfer_slope(step, share, n_harmonics=n) / before),
    )
