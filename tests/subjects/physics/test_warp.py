"""`physics.warp`: displacements of the image, alone and on top of a projection."""

import numpy as np
import pytest

from irtiming.physics import projection
from irtiming.physics.warp import WARP_NUMBERS, Warp, displacements
from irtiming.records.row_timing import LensTerms, SectorShape

UNIT = 100.0
AMOUNTS = (0.3, -0.2, 0.5, -0.4, 0.1, 0.2, 0.6, -0.3, 0.7)


def _shape(**fields):
    return SectorShape(
        axle_row_px=64.0, axle_column_px=73.5, offset_row_px=0.0, offset_column_px=0.0, inner_radius_px=17.0,
        outer_radius_px=52.0, bisector_rad=-1.57, opening_angle_rad=1.3, blur_px=0.7, image_rows=120, image_columns=160,
        **fields,
    )  # fmt: skip


def test_a_place_is_moved_as_by_hand():
    """Oracle: the formula by hand at d = 1, r = 2 half diagonals, the amounts being 1 to 9 px."""
    below, beside = Warp(amounts_px=tuple(range(1, 10)), unit_px=UNIT).moved(100.0, 200.0)
    assert below == pytest.approx(1 + 2 * 2 + 3 + 4 * 2 + 5 * 4 + 9 * 5)
    assert beside == pytest.approx(2 - 1 * 2 + 6 + 7 * 2 + 8 * 4 + 9 * 2 * 5)


def test_each_number_alone_adds_up():
    """Oracle: a warp is linear in its numbers."""
    down, right = np.random.default_rng(3).uniform(-60, 60, (2, 8))
    together = Warp(amounts_px=AMOUNTS, unit_px=UNIT).moved(down, right)
    np.testing.assert_allclose(np.tensordot(AMOUNTS, displacements(down, right, unit_px=UNIT), 1), together)


@pytest.mark.parametrize("bent", [{}, {"distortion": -0.06, "keystone_row": 0.01, "log_focal_length": 1.0}])
def test_a_warped_image_comes_back_and_its_areas_are_its_slopes(bent):
    """Oracle: there and back, and central differences of where points appear."""
    seen = projection.projection_of(_shape(**dict(zip(WARP_NUMBERS, AMOUNTS, strict=True)), **bent))
    down, right = np.random.default_rng(4).uniform(-50, 50, (2, 20))
    np.testing.assert_allclose(seen.flat(*seen.seen(down, right)), (down, right), atol=1e-5)
    by_down, by_right = (
        np.subtract(seen.seen(down + y, right + x), seen.seen(down - y, right - x)) / 2e-4
        for y, x in ((1e-4, 0), (0, 1e-4))
    )
    area = by_down[0] * by_right[1] - by_down[1] * by_right[0]
    np.testing.assert_allclose(seen.magnification(down, right)[1], area, rtol=1e-6)


@pytest.mark.parametrize("warped", [False, True])
@pytest.mark.parametrize(
    "bent",
    [
        {},
        {"distortion": -0.06, "keystone_row": 0.01, "log_focal_length": 1.0, "lens_column_px": 4.0},
        {"distortion": 0.05, "lens_terms": LensTerms(quartic=-0.02, tangential_row=3e-3, row_stretch=1.02)},
    ],
)
def test_compiled_code_sees_the_same(bent, warped):
    """Oracle: the same formulas uncompiled, for whole arrays, which are tried against a pinhole and against differences above."""
    amounts = dict(zip(WARP_NUMBERS, AMOUNTS, strict=True)) if warped else {}
    camera = projection.projection_of(_shape(**amounts, **bent))
    down, right = np.random.default_rng(6).uniform(-50, 50, (2, 12))
    one_by_one = np.array([projection.seen_by(camera.eye, place) for place in zip(down, right, strict=True)]).T
    at_once = np.array(np.broadcast_arrays(*camera.seen(down, right), *camera.magnification(down, right)))
    np.testing.assert_allclose(one_by_one, at_once, rtol=1e-12)


def test_many_cameras_at_once_are_each_of_them():
    """Oracle: one by one."""
    cameras = [
        {"distortion": k, "keystone_row": h, "keystone_column": -h / 2, "log_focal_length": f, "lens_row_px": c}
        for k, h, f, c in ((-0.1, 0.01, 0.5, 3.0), (0.0, 0.0, 2.0, 0.0), (0.08, -0.02, 1.0, -5.0))
    ]
    down, right = np.random.default_rng(5).uniform(-50, 50, (2, 6))
    alone = [projection.projection_of(_shape(**one)) for one in cameras]
    columns = {name: np.array([[one[name]] for one in cameras]) for name in cameras[0]}
    together = projection.Projection(
        axle_px=(64.0, 73.5),
        keystone_per_px=(columns["keystone_row"] / UNIT, columns["keystone_column"] / UNIT),
        focal_length_px=UNIT * np.exp(columns["log_focal_length"]),
        lens=projection.Lens(
            distortion=columns["distortion"], rows=120, columns=160, off_row_px=columns["lens_row_px"]
        ),
    ).seen(down, right)
    for k, one in enumerate(alone):
        np.testing.assert_allclose([part[k] for part in together], one.seen(down, right), atol=1e-9)
