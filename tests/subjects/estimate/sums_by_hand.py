"""Pixel sums of recordings whose wheel, mask and window are known: counted over many instants and radii."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from geometry_by_hand import GATES

from irtiming.physics.wheel import wheel_model
from irtiming.records.reduced import AxleView
from irtiming.records.wheel_geometry import WheelGeometry

TURN = 2 * np.pi
CLOCK_HZ, START = 49_152_000, 7_000_000
EDGES = (0.0, 1.5718, 3.1421, 4.7125)
GAMMA, GATE, CENTRE = float(np.radians(75)), 0.2682, float(np.radians(-90))
MIDDLE, WINDOW = 4.969e-4, 250e-6
EARLY = np.array([3e-4, -2e-4, 5e-4, 1e-4])
LEANS = (6e-3, -4e-3)
RADII = (15.0, 39.5)
U_ANGLE, U_EDGE = 5e-4, 2e-4


@cache
def _sums(rate_hz, *, n=500, instants=24, n_radii=60):
    """Open share of each frame, counted over many instants and radii; mask edges miss the axle, edges come early."""
    t = 20_000_000 / CLOCK_HZ + 1_622_016 * np.arange(n) / CLOCK_HZ
    moments = t[:, None] + MIDDLE + WINDOW * ((np.arange(instants) + 0.5) / instants - 0.5)
    theta = TURN * rate_hz * moments + 0.4
    node, weight = np.polynomial.legendre.leggauss(n_radii)
    radius = np.mean(RADII) + np.diff(RADII)[0] / 2 * node
    share = weight * radius / np.sum(weight * radius)
    place = np.mean(RADII) / radius
    place = place - share @ place
    edges = np.array(EDGES) - EARLY
    total = np.zeros(n)
    for w, x in zip(share, place, strict=True):
        low = np.mod(np.pi / 2 + GATE + theta - CENTRE - GAMMA / 2, TURN) + LEANS[0] * x
        high = low - LEANS[0] * x + GAMMA + LEANS[1] * x
        for turn in (-1, 0, 1):
            for a, b in ((edges[1], edges[2]), (edges[3], TURN + edges[0])):
                over = np.minimum(high, b + TURN * turn) - np.maximum(low, a + TURN * turn)
                total += w * np.maximum(0, over).mean(axis=1)
    return total / GAMMA


def _ring_of_pixels():
    """A mask whose pixels lie at the radii of the sums, and the axle among them."""
    rows, columns = np.mgrid[0:80, 0:80]
    radius = np.hypot(rows - 40, columns - 40)
    inside = (radius >= RADII[0]) & (radius <= RADII[1])
    axle = AxleView(
        row_px=40.0, column_px=40.0, u_centre_px=1e-3, bisector_rad=CENTRE, u_bisector_rad=1e-4, mean_angle_rad=CENTRE,
        u_off_axle_rad=1e-4, edge_miss_px=(0.0, 0.0), u_edge_miss_px=0.3,
    )  # fmt: skip
    return inside, axle


GEOMETRY = WheelGeometry(
    model=wheel_model(EDGES, GATE, opening_angle_rad=GAMMA, centre_angle_rad=CENTRE),
    gates=replace(GATES, application_rad=GATE),
    angle_budget=(("mask centre angle phi_M", "B", U_ANGLE),),
    u_edge_rad=U_EDGE,
    edges_from="rig.toml",
    camera_roll_rad=None,
    findings=(),
)
"""What rig.toml says of the wheel."""


def recordings_by_hand(track_of: Callable, reduced_recording: Callable) -> Callable:
    """Maker of recordings, one per wheel rate, with the given noise: ``make(rates_hz, noise=0.0, seed=0)``."""
    mask, axle = _ring_of_pixels()

    def make(rates_hz, *, noise=0.0, seed=0):
        random = np.random.default_rng(seed)
        made = []
        for k, rate in enumerate(rates_hz):
            share = _sums(rate) + noise * random.normal(size=500)
            track = track_of(rate_hz=rate, start=START, duration_s=18.5)
            triggers = START + 20_000_000 + 1_622_016 * np.arange(500, dtype=np.int64)
            one = reduced_recording(
                track, triggers, 9e6 + 2e6 * share, rotation_speed_hz=rate, name=f"run {k}", axle=axle
            )
            made.append(replace(one, opening=replace(one.opening, mask=mask, border_px=2)))
        return made

    return make
