"""What is linear in a contrast image, against one large matrix that is written out."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.estimate import sector_linear
from irtiming.estimate.sector_linear import Linear
from irtiming.physics.smooth_field import SmoothField

ROWS, COLUMNS, N_LEVELS, PRIOR = 12, 15, 3, 0.3


@pytest.fixture
def linear():
    """Light in the middle, a plate about it and a sway, before a field; two pixels are dead, and each has its own noise."""
    rng = np.random.default_rng(5)
    row, column = np.mgrid[:ROWS, :COLUMNS]
    light = 1 / (1 + np.exp(np.hypot(row - 5.5, column - 7) - 4))
    levels = np.array([light, 1 - light, 0.2 * light]) * np.exp(0.1j * rng.standard_normal((N_LEVELS, ROWS, COLUMNS)))
    good = np.ones((ROWS, COLUMNS), bool)
    good[3, 4] = good[7, 9] = False
    return Linear(
        levels=levels,
        cover=(0.5 + 0.5 * light) * np.exp(0.2j * (column - 7) / 7),
        basis=SmoothField.over(np.arange(ROWS, dtype=float), np.arange(COLUMNS, dtype=float), steps=2),
        good=good,
        u_dn=rng.uniform(0.5, 2.0, (2, ROWS, COLUMNS))[0] + 1j * rng.uniform(0.5, 2.0, (ROWS, COLUMNS)),
    )


def _written_out(one):
    """Terms of all good pixels along and across their phase over their uncertainties, shape (2 n_good, n)."""
    light = one.levels[0].real
    bases = [np.outer(a, b) for a in one.basis.along_rows for b in one.basis.along_columns]
    fields = [one.cover * (base - np.sum(light * base) / light.sum()) for base in bases]
    terms = [*one.levels, *fields]
    return np.array([
        np.concatenate([(term.real / one.u_dn.real)[one.good], (term.imag / one.u_dn.imag)[one.good]]) for term in terms
    ]).T  # fmt: skip


def _image(one, seed):
    rng = np.random.default_rng(seed)
    along, across = rng.standard_normal((2, ROWS, COLUMNS))
    return 100 * one.levels[0] + 7 * one.levels[1] + one.u_dn.real * along + 1j * one.u_dn.imag * across


def test_amounts_are_those_of_a_matrix_that_is_written_out(linear):
    """Oracle: NumPy's least squares with a row for each pixel and each amount that is known beforehand."""
    image = _image(linear, 1)
    found = sector_linear.solved(linear, image, field_prior=PRIOR)
    design = _written_out(linear)
    seen = np.concatenate([(image.real / linear.u_dn.real)[linear.good], (image.imag / linear.u_dn.imag)[linear.good]])
    contrast = abs(seen @ design[:, 0] / (design[:, 0] @ design[:, 0]))
    known = np.array([0, 0, 1 / contrast, *[1 / (PRIOR * contrast)] * linear.basis.size])
    rows = np.concatenate([design, np.diag(known)[2:]])
    expected = np.linalg.lstsq(rows, np.concatenate([seen, np.zeros(known.size - 2)]))[0]
    assert found.found == pytest.approx(expected, rel=1e-8, abs=1e-8)
    assert found.misfit == pytest.approx(rows @ expected - np.concatenate([seen, np.zeros(known.size - 2)]), abs=1e-7)


def _solved_for(one, image, prior):
    """Misfit of the amounts that NumPy finds, their prior given."""
    seen = np.concatenate([(image.real / one.u_dn.real)[one.good], (image.imag / one.u_dn.imag)[one.good]])
    rows, sought = np.concatenate([_written_out(one), np.diag(prior)[2:]]), np.append(seen, np.zeros(prior.size - 2))
    return rows @ np.linalg.lstsq(rows, sought)[0] - sought


def test_the_change_beside_a_place_is_that_of_a_second_solution(linear):
    """Oracle: NumPy's least squares with light that lies elsewhere; what is left out goes as the square of the step."""
    image = _image(linear, 1)
    here = sector_linear.solved(linear, image, field_prior=PRIOR)
    step = 1e-4 * np.roll(linear.levels[0], 1, axis=0)
    moved = replace(linear, levels=linear.levels + np.array([step, -step, 0.2 * step]), cover=linear.cover + 1e-5)
    exact = _solved_for(moved, image, here.prior) - here.misfit
    assert np.linalg.norm(exact) > 1e-3
    assert np.linalg.norm(here.change(moved, image) - exact) < 3e-4 * np.linalg.norm(exact)
    turned = here.change(linear, image * np.exp(1e-5j))
    again = _solved_for(linear, image * np.exp(1e-5j), here.prior) - here.misfit
    assert np.linalg.norm(turned - again) < 3e-4 * np.linalg.norm(again)


def test_a_fields_height_is_as_likely_as_the_image_that_it_makes(linear):
    """Oracle: the normal density of the pixels beside free levels, its covariance written out; differences of its logarithm."""
    image = _image(linear, 1) + 3 * linear.cover * np.cos(np.arange(COLUMNS) / 3)
    found = sector_linear.solved(linear, image, field_prior=PRIOR)
    seen = np.concatenate([(image.real / linear.u_dn.real)[linear.good], (image.imag / linear.u_dn.imag)[linear.good]])
    design = _written_out(linear)
    beside = np.linalg.qr(design[:, :2], mode="complete")[0][:, 2:].T
    sway, fields, left = beside @ design[:, 2] / found.prior[2], beside @ design[:, 3:] * found.found[0], beside @ seen
    heights, expected = np.array([1e-4, 0.01, 0.03, 0.2]), []
    for height in heights:
        covariance = np.eye(left.size) + np.outer(sway, sway) + height**2 * fields @ fields.T
        expected.append(-(np.linalg.slogdet(covariance)[1] + left @ np.linalg.solve(covariance, left)) / 2)
    likely = found.log_evidence(heights)
    assert likely - likely[0] == pytest.approx(np.array(expected) - expected[0], abs=1e-6)
    assert np.argmax(likely) in (1, 2)
