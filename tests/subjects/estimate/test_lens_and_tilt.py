"""`estimate.lens_and_tilt`: the displacement that image and prior knowledge allow together."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.estimate import lens_and_tilt
from irtiming.estimate.lens_and_tilt import ImageWord
from irtiming.inference import lens_knowledge, weighed_lens
from irtiming.physics import sector_points
from irtiming.physics.projection import projection_of
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.records.rig import CameraOptics
from irtiming.records.row_timing import SectorShape

SHAPE = SectorShape(
    axle_row_px=61.0, axle_column_px=82.0, offset_row_px=0.2, offset_column_px=-0.1, inner_radius_px=17.0,
    outer_radius_px=52.0, bisector_rad=-1.55, opening_angle_rad=1.3, blur_px=0.7, image_rows=120, image_columns=160,
)  # fmt: skip
KNOWN = lens_knowledge.knowledge(CameraOptics(), image=(120, 160))


def _word(rng, *, warp, own):
    """What an image would say whose residuals are linear in three numbers and the warp, some of it told well."""
    told = np.concatenate([rng.normal(size=(60, 9)) * np.geomspace(0.05, 40, 9), rng.normal(size=(60, 9))])
    jacobian = np.column_stack([rng.normal(size=(120, 3)) * 20, told])
    residual = jacobian @ -np.concatenate([own, warp]) + rng.normal(size=120)
    return ImageWord(residual=residual, jacobian=jacobian, clusters=np.arange(120), n_warp=9)


def test_truth_lies_as_far_off_as_it_says():
    """Oracle: lenses and tilts drawn from the prior, their displacements fitted by brute force; pulls of all twelve numbers."""
    cameras, pulls = weighed_lens._Cameras(SHAPE, known=KNOWN), []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        warp = cameras.warp(0.8 * rng.standard_normal((1, cameras.n_free)))[0] + 0.03 * rng.standard_normal(9)
        own = rng.normal(size=3)
        found = lens_and_tilt.settled(_word(rng, warp=warp, own=own), SHAPE, known=KNOWN)
        pulls.append((found.moved - np.concatenate([own, warp])) / np.sqrt(np.diag(found.covariance)))
    assert 0.7 < np.sqrt(np.mean(np.square(pulls))) < 1.25
    assert np.abs(pulls).max() < 4.5


def test_a_displacement_is_that_of_the_projection():
    """Oracle: places through two projections; all that nine numbers, a shift, a turn and a scale leave is a few hundredths."""
    cameras = weighed_lens._Cameras(SHAPE, known=KNOWN)
    units = np.zeros((1, cameras.n_free))
    units[0, :6] = [-0.8, 0.3, 1.0, -0.7, 0.9, -0.6]
    numbers = {name: float(one[0]) for name, one in cameras._numbers(units).items()}
    other = replace(SHAPE, **{name: numbers[name] for name in weighed_lens.SLIGHT})
    warped = replace(SHAPE, **dict(zip(WARP_NUMBERS, cameras.warp(units)[0].tolist(), strict=True)))
    down, right, _ = sector_points.places(SHAPE, n_radial=5, n_around=7)
    off = np.subtract(projection_of(other).seen(down, right), projection_of(warped).seen(down, right))
    z, seen = down + 1j * right, off[0] + 1j * off[1]
    basis = np.column_stack([np.ones(z.size), z])
    left = seen - basis @ np.linalg.lstsq(basis, seen, rcond=None)[0]
    before = np.subtract(projection_of(other).seen(down, right), projection_of(SHAPE).seen(down, right))
    assert np.abs(left).max() < 0.03
    assert np.hypot(*before).max() > 0.5


def test_an_image_that_says_nothing_leaves_what_is_known():
    """Oracle: the prior itself, drawn; lens and tilt are those of rig.toml and of what no camera exceeds."""
    word = ImageWord(
        residual=np.zeros(12), jacobian=np.eye(12) * ([1.0] * 3 + [1e-6] * 9), clusters=np.full(12, -1), n_warp=9
    )
    found = lens_and_tilt.settled(word, SHAPE, known=KNOWN)
    assert found.camera.value("distortion") == pytest.approx(0.0, abs=0.01)
    assert found.camera.u("distortion") == pytest.approx(0.05, rel=0.15)
    assert found.camera.u("lens_column_px") == pytest.approx(3.2, rel=0.15)
    np.testing.assert_allclose(found.moved[:3], 0.0, atol=1e-9)


def test_a_keystone_is_a_tilt_over_the_focal_length():
    """Oracle: by hand, h = t / f in half diagonals, for a camera that is tilted about both axes and has a long lens."""
    cameras = weighed_lens._Cameras(SHAPE, known=KNOWN)
    free = [name for name in weighed_lens.CAMERA_NUMBERS if KNOWN.prior(name).standard_uncertainty > 0]
    units = np.zeros((1, cameras.n_free))
    amounts = {"tilt_row": 1.5, "tilt_column": -0.7, "log_focal_length": 1.2}
    units[0, [free.index(name) for name in amounts]] = list(amounts.values())
    tilt_row, tilt_column, log_length = (
        KNOWN.prior(name).value + by * KNOWN.prior(name).standard_uncertainty for name, by in amounts.items()
    )
    numbers = cameras._numbers(units)
    assert numbers["keystone_row"][0] == pytest.approx(tilt_row / np.exp(log_length))
    assert numbers["keystone_column"][0] == pytest.approx(tilt_column / np.exp(log_length))
    assert np.exp(log_length) > 2
