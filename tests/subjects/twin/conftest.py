"""Scenes that the twin's tests share."""

import math
from dataclasses import replace

import pytest

from irtiming.twin.optics import Optics
from irtiming.twin.scene import Scene, paper_scene


@pytest.fixture(scope="session")
def small_scene() -> Scene:
    """80 x 64 pixels, wheel with uneven edges, no narcissus: what is seen depends on the opening alone."""
    scene = paper_scene(64, 80)
    return replace(
        scene,
        wheel=replace(
            scene.wheel,
            ring_edges_rad=(0.0, math.pi / 2 + 4e-4, math.pi + 5e-4, 1.5 * math.pi - 3e-4),
            cutout_errors_rad=(2e-4, -1e-4, 0.0, 3e-4),
        ),
        optics=Optics(pixel_pitch_m=1.6e-3, wheel_centre_row_px=31.2, wheel_centre_column_px=40.1, rays_along_pixel=16),
        radiance=replace(scene.radiance, narcissus_dn=0.0, mask_k=scene.radiance.wheel_k),
    )
