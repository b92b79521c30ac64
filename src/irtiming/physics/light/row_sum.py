r"""What the sum over one image row sees over the wheel angle, and its derivatives to all that times it.

Row y sees the opening through a weight over polar angle (`physics.blurred_sector`), the wheel covers and uncovers it, the pixels
respond (`physics.response`), frames keep a share of those before, and the row is read in its turn (`physics.readout`). All are
factors on the harmonics:

.. math:: F_{ym} = \sum_i o_{im}\, K_{ym}\, R_m\, G_m\, e^{i m \omega (d_i + t_y)}

with :math:`o_i` the step that wheel edge i makes (by the share b less for the two edges of a second blade that is warmer),
:math:`K_y` the row's light, :math:`R` the response, :math:`G` the memory over that part of it that was undone in the data,
:math:`t_y` the time by which the row is read after row 0, and one delay :math:`d_i` per wheel edge, because the cutout's edges
need not stand where the ring's do.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias, final

import numpy as np

from irtiming.physics.camera import Camera
from irtiming.physics.wheel_harmonics import later
from irtiming.records.arrays import Array, ComplexArray

EDGE_DELAYS = tuple(f"edge_delay_{edge}" for edge in range(4))
"""Delays of row 0 as the passing of each wheel edge gives them."""

BLADE = "blade_share"
"""By how much the blade between edges 2 and 3 is warmer than the other one, over the contrast between that and the opening."""

Timing: TypeAlias = Mapping[str, float]
"""Numbers of one camera by name: EDGE_DELAYS, the response's parameter, s; the memory's, 1; BLADE; those of the readout, s."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class RowSum:
    """Rows of a camera before the wheel: open_im, shape (4, M + 1), K_ym, shape (n_row, M + 1), rows and omega.

    The wheel turns by ``step_rad`` from trigger to trigger; ``undone`` is the share of the recursion that the data are rid of.
    """

    camera: Camera
    open_harmonics: ComplexArray
    row_harmonics: ComplexArray
    row_px: Array
    angular_frequency_rad_per_s: float
    step_rad: float
    undone: float = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters, in the order of the derivatives."""
        return timing_names(self.camera)

    @property
    def n_harmonics(self) -> int:
        """Highest order M."""
        return int(self.row_harmonics.shape[1]) - 1

    def lowest(self, n_harmonics: int) -> "RowSum":
        """The same with fewer harmonics."""
        keep = slice(n_harmonics + 1)
        return replace(
            self, open_harmonics=self.open_harmonics[:, keep], row_harmonics=self.row_harmonics[:, keep]
        )  # fmt: skip

    def some_rows(self, rows: slice) -> "RowSum":
        """The same with fewer rows."""
        return replace(self, row_harmonics=self.row_harmonics[rows], row_px=self.row_px[rows])


def timing_names(camera: Camera) -> tuple[str, ...]:
    """Names of the parameters of a row sum: four edge delays, the response's, the memory's, the blade's, those of the readout."""
    return (*EDGE_DELAYS, camera.response.PARAMETER, camera.memory.PARAMETER, BLADE, *camera.readout.PARAMETERS)


def unit(parameter: str, camera: Camera) -> str:
    """Of a parameter of a row sum: a share has none, all others are times."""
    return "1" if parameter in (camera.memory.PARAMETER, BLADE) else "s"


def harmonics(rows: RowSum, timing: Timing) -> ComplexArray:
    """Harmonics F_ym of each row, shape (n_row, M + 1)."""
    edges, turned = _factors(rows, timing)
    return np.asarray(edges.sum(axis=0) * turned)


def linearised(rows: RowSum, timing: Timing) -> tuple[ComplexArray, ComplexArray]:
    """`harmonics`, shape (n_row, M + 1), and their derivatives to each of ``rows.names``, (k, n_row, M + 1), per unit."""
    omega, n, response = rows.angular_frequency_rad_per_s, rows.n_harmonics, rows.camera.response
    edges, turned = _factors(rows, timing)
    by_edge = (edges * (1j * np.arange(n + 1) * omega))[:, None, :] * turned
    bare = _edges(rows, timing).sum(axis=0)
    slope = response.transfer_slope(omega, timing[response.PARAMETER], n_harmonics=n)
    kept, kept_slope = _memory(rows, timing)
    by_response = bare * slope * kept * turned
    by_memory = bare * response.transfer(omega, timing[response.PARAMETER], n_harmonics=n) * kept_slope * turned
    by_blade = -_even_edges(rows, timing)[2:].sum(axis=0) * response.transfer(
        omega, timing[response.PARAMETER], n_harmonics=n
    )
    by_readout = rows.camera.readout.read_later(rows.row_px)[:, :, None] * by_edge.sum(axis=0)
    return np.asarray(edges.sum(axis=0) * turned), np.concatenate(
        [by_edge, by_response[None], by_memory[None], (by_blade * kept * turned)[None], by_readout]
    )


def _edges(rows: RowSum, timing: Timing) -> ComplexArray:
    """Steps of the wheel's edges as row 0 is read, without response; shape (4, M + 1)."""
    second = 1 - timing.get(BLADE, 0.0)
    return _even_edges(rows, timing) * np.array([1.0, 1.0, second, second])[:, None]


def _even_edges(rows: RowSum, timing: Timing) -> ComplexArray:
    """The same were both blades alike."""
    delays = np.array([timing[name] for name in EDGE_DELAYS])
    return rows.open_harmonics * later(rows.angular_frequency_rad_per_s * delays, n_harmonics=rows.n_harmonics)


def _factors(rows: RowSum, timing: Timing) -> tuple[ComplexArray, ComplexArray]:
    """Edges with response and memory, shape (4, M + 1), and light of the rows as they are read, shape (n_row, M + 1)."""
    omega, n, response, readout = (
        rows.angular_frequency_rad_per_s,
        rows.n_harmonics,
        rows.camera.response,
        rows.camera.readout,
    )
    edges = _edges(rows, timing) * response.transfer(omega, timing[response.PARAMETER], n_harmonics=n)
    edges = edges * _memory(rows, timing)[0]
    read_s = np.array([timing[name] for name in readout.PARAMETERS]) @ readout.read_later(rows.row_px)
    return edges, rows.row_harmonics * later(omega * read_s, n_harmonics=n)


def _memory(rows: RowSum, timing: Timing) -> tuple[ComplexArray, ComplexArray]:
    """What the frames keep of those before, over what was undone, and its derivative to the share; shapes (M + 1,)."""
    memory, step, n = rows.camera.memory, rows.step_rad, rows.n_harmonics
    share, before = timing.get(memory.PARAMETER, 0.0), memory.transfer(step, rows.undone, n_harmonics=n)
    return (
        np.asarray(memory.transfer(step, share, n_harmonics=n) / before),
        np.asarray(memory.transfer_slope(step, share, n_harmonics=n) / before),
    )
