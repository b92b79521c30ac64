"""`estimate.sector_weighed`: what images say of a warp and of the sector's other numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import sector_best, sector_fit, sector_images, sector_weighed
from irtiming.estimate.sector_search import BETWEEN, SCALES
from irtiming.inference.lens_knowledge import N_KNOWN
from irtiming.inference.weighed_lens import SLIGHT
from irtiming.physics.warp import WARP_NUMBERS

PRIORS = sector_images.N_PRIORS


@pytest.fixture(scope="module")
def seen(brute_bolometer, brute_rows, rig_with):
    """The image of a mask beside the axle, and where a search for its numbers ended."""
    camera = brute_bolometer(offset=(0.35, -0.25))
    rows, timing = brute_rows(camera, noise_dn=3.0, seed=4), camera.timing
    found = None
    for _ in range(3):
        found = sector_fit.fit([rows], camera.model, rig=rig_with(), timing=timing, start=found)
    images = sector_images.of([rows], camera.model, rig=rig_with(), timing=timing, known=found)
    return images, sector_best.searched(images, begin=sector_images.numbers_of(found), held=(), gain=BETWEEN)


def test_slopes_are_those_of_the_image(seen):
    """Oracle: differences of the image over other steps; those that a search ends with miss them by per cents.

    Along a valley of lenses the slopes of all numbers cancel but for a thousandth: rough ones make a wall of it.
    """
    images, best = seen
    word = sector_weighed._without_camera(images, best)
    names = [name for name in best.free if name not in SLIGHT]
    warped = word.jacobian[:, -len(WARP_NUMBERS) :].T
    of_image = slice(PRIORS - N_KNOWN, best.residual.size - N_KNOWN)
    for name, column in [*zip(names, word.jacobian.T, strict=False), *zip(WARP_NUMBERS, warped, strict=True)]:
        step = 0.03 * SCALES.get(name, 1.0)
        ahead, behind = (best.numbers | {name: best.numbers[name] + way * step} for way in (1, -1))
        apart = images.residuals(ahead, images.sharp(ahead)) - images.residuals(behind, images.sharp(behind))
        expected = apart[PRIORS:] / (2 * step)
        assert np.linalg.norm(column[of_image] - expected) < 4e-3 * np.linalg.norm(expected), name


def test_the_image_of_the_weighed_lens_is_nearly_what_slopes_foretell(seen):
    """Oracle: a law: so near the best an image is straight, and what is left beside its slopes is little of what noise leaves."""
    images, best = seen
    last = sector_weighed.weighed(images, best)
    there = images.residuals(last.numbers, images.sharp(last.numbers))
    assert np.linalg.norm(there[PRIORS:] - best.residual[PRIORS:]) > 0.1  # it did move
    assert 0 <= last.beside_linear < 0.01 * np.sum(best.residual**2)


@pytest.mark.parametrize("moved_px", [0.0, 0.5])
def test_how_far_an_image_is_from_what_slopes_foretell_is_a_sum_of_squares(seen, monkeypatch, moved_px):
    """Oracle: residuals of the image with one number moved, against a straight line through those beside the best."""
    images, best = seen
    names = [name for name in best.free if name not in SLIGHT]
    n = len(names) + len(sector_weighed.EXCHANGES) + len(WARP_NUMBERS)
    moved = np.zeros(n)
    moved[names.index("axle_row_px")] = moved_px
    settled = SimpleNamespace(moved=moved, covariance=np.eye(n), camera="camera")
    monkeypatch.setattr(sector_weighed.lens_and_tilt, "settled", lambda *_, **__: settled)
    last = sector_weighed.weighed(images, best)
    there, small = best.numbers | {"axle_row_px": best.numbers["axle_row_px"] + moved_px}, 0.01
    ends = [best.numbers | {"axle_row_px": best.numbers["axle_row_px"] + way * small} for way in (-1, 1)]
    behind, ahead = (images.residuals(one, images.sharp(one)) for one in ends)
    straight = best.residual + moved_px * (ahead - behind) / (2 * small)
    beside = (images.residuals(there, images.sharp(there)) - straight)[PRIORS:]
    assert last.numbers == pytest.approx(there)
    assert last.beside_linear == pytest.approx(np.sum(beside**2), rel=0.02, abs=1e-6)
    assert (last.beside_linear > 1) == (moved_px > 0)
