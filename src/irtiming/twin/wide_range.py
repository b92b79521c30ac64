"""Pixels that exchange heat with the substrate and, by Planck's law, with what they see: stepped in time, pixel by pixel.

The exchange with the scene is not linear, so the mean over a pixel's rays may not be taken afterwards (as in
`irtiming.twin.lag`). Radiances add within a pixel: the sum over its rays is stepped through turns of the wheel until it
repeats itself, with steps that end where a ray meets an edge, and looked up when a row is read. What the camera gives
is linear in the pixel's temperature. The wheel counts as even while pixels follow it, which is off by its wander
(1e-4) of the lag, to either side.
"""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from os import cpu_count
from typing import final

import numpy as np
from numba import njit

from irtiming.errors import PlanError
from irtiming.records.arrays import Array
from irtiming.twin.nodes import Nodes, trace_nodes
from irtiming.twin.noise import Values
from irtiming.twin.pixels import Weights, solid_wheel
from irtiming.twin.rays import Counts, Indices
from irtiming.twin.scene import BolometerTiming, RadiativeExchange, Scene
from irtiming.twin.spread import Offsets

_PLANCK, _LIGHT, _BOLTZMANN = 6.62607015e-34, 299792458.0, 1.380649e-23  # SI
_WAVELENGTHS = 2001
_TABLE, _BEYOND_K = 4096, 5.0
_HALVINGS = 60
_CELLS_PER_LAG = 16
_BINS_PER_LAG = 32
_MOST_TURNS = 200
_REPEATED_K = 1e-9
_LARGEST_TABLE = 2**30  # bytes
_CHUNK = 512  # pixels
_BASE_K = 288.15


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Pixel:
    """A pixel as it exchanges heat.

    ``radiance`` (n,) is what a black surface of ``first_k`` + i ``step_k`` sends, W m^-2 sr^-1. The pixel warms by
    ``per_radiance`` K/s for each of these units that it gets more than it gives, and goes to ``substrate_k`` in
    ``substrate_s``. It gives ``base_dn`` where it settles before a scene of 288.15 K, and ``dn_per_k`` per kelvin of
    its own.
    """

    radiance: Array
    first_k: float
    step_k: float
    substrate_k: float
    substrate_s: float
    per_radiance: float
    base_dn: float = 0.0
    dn_per_k: float = 1.0

    def radiance_of(self, temperature_k: Array) -> Array:
        """Of black surfaces, any shape."""
        place = (np.asarray(temperature_k, dtype=np.float64) - self.first_k) / self.step_k
        return np.interp(place, np.arange(self.radiance.size), self.radiance)

    def settled_k(self, radiance: Array) -> Array:
        """Where the pixel neither warms nor cools, any shape: found by halving."""
        seen = np.asarray(radiance, dtype=np.float64)
        low, high = np.full_like(seen, self.first_k), np.full_like(seen, self.first_k + self.step_k * (_TABLE - 1))
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            gain = (self.substrate_k - middle) / self.substrate_s
            warms = gain + self.per_radiance * (seen - self.radiance_of(middle)) > 0
            low, high = np.where(warms, middle, low), np.where(warms, high, middle)
        return (low + high) / 2

    def settled_dn(self, scene_k: Array) -> Array:
        """What it gives where it has looked at a temperature for long, any shape, DN."""
        base = self.settled_k(self.radiance_of(np.array(_BASE_K)))
        return self.base_dn + self.dn_per_k * (self.settled_k(self.radiance_of(scene_k)) - base)

    @property
    def shortest_lag_s(self) -> float:
        """Time constant where it is hottest."""
        steepest = float(np.max(np.diff(self.radiance))) / self.step_k
        return 1 / (1 / self.substrate_s + self.per_radiance * steepest)


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class WidePicture:
    """A scene ready to be read row by row.

    Shapes: level_dn (n_live, n_cell), what each live pixel gives at equally spaced phi_A + theta - phi of its centre;
    pixel and reference_rad (n_live,) as in `Nodes`; closed_dn (row, column), what pixels give behind solid wheel.
    """

    level_dn: Weights
    pixel: Indices
    reference_rad: Array
    closed_dn: Values
    gate_rad: float


def wide_pixel(scene: Scene) -> Pixel:
    """Pixel of a scene whose timing has a radiative exchange.

    Raises
    ------
    PlanError
        If the scene's pixels are linear.
    """
    timing = scene.timing
    if not isinstance(timing, BolometerTiming) or timing.radiative is None:
        raise PlanError("no radiative exchange in the scene's timing; give BolometerTiming(radiative=...)")
    exchange, radiance = timing.radiative, scene.radiance
    there = (radiance.blackbody_k, radiance.wheel_k, radiance.mask_k, scene.correction.surface_k)
    mirrored = abs(radiance.narcissus_dn / radiance.dn_per_k)
    coldest = min(*there, exchange.substrate_k, exchange.reference_k, _BASE_K) - mirrored - _BEYOND_K
    hottest = max(*there, exchange.substrate_k, exchange.reference_k, _BASE_K) + mirrored + _BEYOND_K
    temperature = np.linspace(coldest, hottest, _TABLE)
    sent = _radiance(temperature, exchange)
    slope = np.interp(exchange.reference_k, temperature, np.gradient(sent, temperature))
    bare = Pixel(
        radiance=sent,
        first_k=coldest,
        step_k=float(temperature[1] - temperature[0]),
        substrate_k=exchange.substrate_k,
        substrate_s=timing.time_constant_s,
        per_radiance=1 / (float(slope) * exchange.scene_time_constant_s),
    )
    per_scene_k = np.diff(bare.settled_dn(np.array([_BASE_K - 0.5, _BASE_K + 0.5])))[0]
    return replace(bare, base_dn=radiance.base_dn, dn_per_k=radiance.dn_per_k / float(per_scene_k))


def wide_picture(scene: Scene, rad_per_s: float) -> WidePicture:
    """Trace the scene, and step every pixel that the wheel concerns through turns until they repeat.

    Parameters
    ----------
    scene
        The rig as it truly is.
    rad_per_s
        Of the wheel.

    Raises
    ------
    PlanError
        If the pixels would take too much memory.
    """
    pixel, radiance = wide_pixel(scene), scene.radiance
    lag_rad = pixel.shortest_lag_s * rad_per_s
    cells = math.ceil(2 * math.pi * _CELLS_PER_LAG / lag_rad)
    nodes = trace_nodes(scene, lag_rad / _BINS_PER_LAG)
    if nodes.pixel.size * cells * 4 > _LARGEST_TABLE:
        raise PlanError(
            f"{nodes.pixel.size} pixels with {cells} values for each turn take more than {_LARGEST_TABLE // 2**20} MiB with "
            "a scene time constant; take fewer rows and columns or a faster wheel"
        )
    apparent_k = _BASE_K + (solid_wheel(scene).astype(np.float64) - radiance.base_dn) / radiance.dn_per_k
    closed = pixel.radiance_of(apparent_k)
    behind = pixel.radiance_of(np.array([radiance.blackbody_k, radiance.mask_k]))
    warmer = _above_substrate(scene, nodes, (pixel, behind, closed.ravel()[nodes.pixel]), (cells, rad_per_s))
    base = float(pixel.settled_k(pixel.radiance_of(np.array(_BASE_K))))
    warmer *= np.float32(pixel.dn_per_k)
    warmer += np.float32(pixel.base_dn + pixel.dn_per_k * (pixel.substrate_k - base))
    return WidePicture(
        level_dn=warmer,
        pixel=nodes.pixel,
        reference_rad=nodes.reference_rad,
        closed_dn=np.asarray(pixel.settled_dn(apparent_k), dtype=np.float32),
        gate_rad=math.pi / 2 + scene.beams.beta_1_rad,
    )


def read_wide_rows(shot: WidePicture, wheel_angle_rad: Array, *, out: Values) -> None:
    """Signal of one frame, written into ``out``, shape (row, column), DN; wheel angle when each row is read, shape (row,)."""
    out[...] = shot.closed_dn
    angle = np.asarray(wheel_angle_rad, dtype=np.float64) + shot.gate_rad
    _look_up(out.reshape(-1), angle, (shot.pixel, shot.reference_rad, shot.level_dn), out.shape[1])


def _radiance(temperature_k: Array, exchange: RadiativeExchange) -> Array:
    """Planck's law, trapezium after trapezium over the band."""
    wavelength = np.linspace(*exchange.band_m, _WAVELENGTHS)
    total = np.zeros_like(temperature_k)
    width = wavelength[1] - wavelength[0]
    for index, one in enumerate(wavelength):
        energy = _PLANCK * _LIGHT / (one * _BOLTZMANN * temperature_k)
        share = 0.5 if index in (0, _WAVELENGTHS - 1) else 1.0
        total += share * width * 2 * _PLANCK * _LIGHT**2 / one**5 / np.expm1(energy)
    return total


def _above_substrate(
    scene: Scene, nodes: Nodes, light: tuple[Pixel, Array, Array], grid: tuple[int, float]
) -> Weights:  # fmt: skip
    """Temperature of each live pixel above the substrate's at the border of each cell, shape (n_live, n_cell), K."""
    pixel, behind, closed = light
    cells, rad_per_s = grid
    edges = np.array(scene.wheel.cutout_edges_rad)
    found = np.empty((nodes.pixel.size, cells), np.float32)
    heat = np.array(
        [pixel.first_k, pixel.step_k, pixel.substrate_k, pixel.substrate_s, pixel.per_radiance, rad_per_s],
        dtype=np.float64,
    )

    def chunk(first: int) -> None:
        end = min(first + _CHUNK, nodes.pixel.size)
        table = (nodes.first_node[first : end + 1], nodes.offset_rad, nodes.share, nodes.behind)
        _step_pixels(found[first:end], edges, table, (behind, closed[first:end]), (heat, pixel.radiance))

    with ThreadPoolExecutor(cpu_count()) as pool:
        list(pool.map(chunk, range(0, nodes.pixel.size, _CHUNK)))
    return found


@njit(cache=True, nogil=True)
def _warming(temperature: float, seen: float, heat: Array, radiance: Array) -> float:
    """Kelvin per second of a pixel that gets this radiance."""
    place = (temperature - heat[0]) / heat[1]
    cell = min(max(int(place), 0), radiance.size - 2)
    sent = radiance[cell] + (place - cell) * (radiance[cell + 1] - radiance[cell])
    return (heat[2] - temperature) / heat[3] + heat[4] * (seen - sent)


@njit(cache=True, nogil=True)
def _follow(temperature: float, seen: float, span_s: float, physics: tuple[Array, Array]) -> float:
    """Temperature after ``span_s`` of the same radiance: one classical Runge-Kutta step."""
    heat, radiance = physics
    first = _warming(temperature, seen, heat, radiance)
    second = _warming(temperature + 0.5 * span_s * first, seen, heat, radiance)
    third = _warming(temperature + 0.5 * span_s * second, seen, heat, radiance)
    fourth = _warming(temperature + span_s * third, seen, heat, radiance)
    return temperature + span_s * (first + 2 * second + 2 * third + fourth) / 6


@njit(cache=True, nogil=True)
def _step_pixels(
    out: Weights,
    edges: Array,
    table: tuple[Counts, Offsets, Offsets, Indices],
    light: tuple[Array, Array],
    physics: tuple[Array, Array],
) -> None:
    """Every pixel through turns of the wheel until the last is as the one before."""
    first_node, offset, share, behind = table
    levels, closed = light
    for live in range(out.shape[0]):
        begin, end = first_node[live], first_node[live + 1]
        place, change = np.empty(4 * (end - begin)), np.empty(4 * (end - begin))
        seen = closed[live]
        for node in range(begin, end):
            gain = share[node] * (levels[behind[node]] - closed[live])
            turned = -offset[node] - edges[0]
            turned -= 2 * math.pi * math.floor(turned / (2 * math.pi)) - edges[0]  # of the wheel, from edge 0 on
            if edges[1] <= turned < edges[2] or turned >= edges[3]:
                seen += gain
            for edge in range(4):
                at = offset[node] + edges[edge]
                place[4 * (node - begin) + edge] = at - 2 * math.pi * math.floor(at / (2 * math.pi))
                change[4 * (node - begin) + edge] = gain if edge % 2 else -gain
        order = np.argsort(place)
        _step_one(out[live], (place[order], change[order]), seen, physics)


@njit(cache=True, nogil=True)
def _step_one(out: Weights, events: tuple[Array, Array], seen: float, physics: tuple[Array, Array]) -> None:
    """One pixel; ``events`` are the places where its radiance changes, in order, and by how much; ``seen`` at place 0."""
    place, change = events
    heat, cells = physics[0], out.size
    width, rad_per_s = 2 * math.pi / cells, heat[5]
    temperature = heat[2]
    for _ in range(_MOST_TURNS):
        before, now, following = temperature, 0.0, 0
        radiance = seen
        for cell in range(cells):
            out[cell] = temperature - heat[2]
            end = (cell + 1) * width
            while following < place.size and place[following] < end:
                temperature = _follow(temperature, radiance, (place[following] - now) / rad_per_s, physics)
                now = place[following]
                radiance += change[following]
                following += 1
            temperature = _follow(temperature, radiance, (end - now) / rad_per_s, physics)
            now = end
        if abs(temperature - before) < _REPEATED_K:
            break


@njit(cache=True, nogil=True)
def _look_up(flat: Weights, angle: Array, table: tuple[Indices, Array, Weights], columns: int) -> None:
    """Level of each live pixel at the angle of its row, on the cubic through the four cells around it."""
    pixel, reference, level = table
    cells = level.shape[1]
    per_rad = cells / (2 * math.pi)
    for live in range(pixel.size):
        place = (angle[pixel[live] // columns] - reference[live]) * per_rad
        place -= math.floor(place / cells) * cells
        cell = min(int(place), cells - 1)
        x = place - cell
        a, b = level[live, (cell - 1) % cells], level[live, cell]
        c, d = level[live, (cell + 1) % cells], level[live, (cell + 2) % cells]
        flat[pixel[live]] = (
            -x * (x - 1) * (x - 2) / 6 * a
            + (x + 1) * (x - 1) * (x - 2) / 2 * b
            - (x + 1) * x * (x - 2) / 2 * c
            + (x + 1) * x * (x - 1) / 6 * d
        )
