"""The algebra of information against multivariate normal distributions written out."""

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.inference.information import Information, combine, prior, without_own


def _piece(seed, names, *, source="noise", scale=1.0):
    random = np.random.default_rng(seed)
    half = random.normal(size=(len(names), len(names))) + 2 * np.eye(len(names))
    return Information(
        source=source, names=names, matrix=scale * half @ half.T, gradient=random.normal(size=len(names)) * scale
    )


def test_pieces_add_whatever_numbers_they_speak_of():
    """Oracle: matrices and gradients placed by hand over a, b, c; the step solves the normal equations."""
    one, other = _piece(1, ("a", "b")), _piece(2, ("c", "b"), source="image")
    whole = combine([one, other, prior("a", 0.5, source="rig.toml", gap=0.2)])
    assert whole.names == ("a", "b", "c")
    matrix, gradient = np.zeros((3, 3)), np.zeros(3)
    matrix[:2, :2] += one.matrix
    matrix[np.ix_([2, 1], [2, 1])] += other.matrix
    matrix[0, 0] += 4
    gradient[:2] += one.gradient
    gradient[[2, 1]] += other.gradient
    gradient[0] += 0.8
    np.testing.assert_allclose(whole.covariance, np.linalg.inv(matrix), rtol=1e-9)
    np.testing.assert_allclose(whole.step, np.linalg.solve(matrix, gradient), rtol=1e-9)
    weights = {"c": 2.0, "a": -1.0}
    row = np.array([-1.0, 0, 2])
    assert whole.variance(weights) == pytest.approx(row @ np.linalg.inv(matrix) @ row)
    shares = whole.shares(weights)
    assert list(shares) == ["noise", "image", "rig.toml"]
    follows = row @ np.linalg.inv(matrix)
    assert shares["rig.toml"] == pytest.approx(4 * follows[0] ** 2)
    assert sum(shares.values()) == pytest.approx(whole.variance(weights))


def test_the_best_estimate_of_many_draws_has_the_covariance():
    """Oracle: 4000 draws of two measurements of two numbers; means weighted by the matrices."""
    random = np.random.default_rng(3)
    covariances = [np.array([[4.0, 1.0], [1.0, 1.0]]), np.array([[1.0, -0.5], [-0.5, 2.0]])]
    steps = []
    for _ in range(4000):
        drawn = [random.multivariate_normal([0.3, -0.7], one) for one in covariances]
        pieces = [
            Information(source="", names=("a", "b"), matrix=np.linalg.inv(c), gradient=np.linalg.solve(c, d))
            for c, d in zip(covariances, drawn, strict=True)
        ]
        whole = combine(pieces)
        steps.append(whole.step)
    np.testing.assert_allclose(np.cov(np.array(steps).T), whole.covariance, atol=0.05)
    np.testing.assert_allclose(np.mean(steps, axis=0), [0.3, -0.7], atol=0.05)


def test_what_is_forgotten_may_be_anything():
    """Oracle: the distribution of the others alone: rows and columns of the covariance taken out, and its mean."""
    piece = _piece(4, ("a", "b", "c"))
    left = piece.without("b")
    covariance, mean = np.linalg.inv(piece.matrix), np.linalg.solve(piece.matrix, piece.gradient)
    keep = [0, 2]
    np.testing.assert_allclose(
        left.matrix[np.ix_(keep, keep)], np.linalg.inv(covariance[np.ix_(keep, keep)]), rtol=1e-9
    )
    np.testing.assert_allclose(left.matrix[1], 0, atol=1e-12)
    np.testing.assert_allclose(
        left.gradient[keep], np.linalg.solve(covariance[np.ix_(keep, keep)], mean[keep]), rtol=1e-9
    )
    np.testing.assert_allclose(left.gradient[1], 0, atol=1e-12)
    assert piece.without() is piece


def test_other_numbers_and_repetitions():
    """Oracle: by hand; a = x + 2 y, b = 3 y, and four times the same."""
    piece = _piece(5, ("a", "b"))
    design = np.array([[1.0, 2.0], [0.0, 3.0]])
    found = piece.of(("x", "y"), design)
    for at in np.random.default_rng(6).normal(size=(3, 2)):
        there = design @ at
        deviance = there @ piece.matrix @ there - 2 * piece.gradient @ there
        assert at @ found.matrix @ at - 2 * found.gradient @ at == pytest.approx(deviance)
    np.testing.assert_array_equal(piece.times(4).matrix, 4 * piece.matrix)
    np.testing.assert_array_equal(piece.times(4).gradient, 4 * piece.gradient)


def test_a_number_of_which_nothing_is_said_is_named():
    """Oracle: the words."""
    silent = Information(source="", names=("a", "b"), matrix=np.diag([1.0, 0.0]), gradient=np.zeros(2))
    with pytest.raises(EstimationError, match="nothing determines b"):
        combine([silent])
    with pytest.raises(EstimationError, match="nothing is said of c; the numbers are a"):
        combine([prior("a", 1.0, source="")]).row({"c": 1.0})


def test_columns_without_a_runs_own_numbers():
    """Oracle: least squares; the same information as with these numbers fitted beside."""
    random = np.random.default_rng(7)
    columns, own = random.normal(size=(50, 3)), np.stack([np.ones(50), np.arange(50.0)], axis=1)
    left = without_own(columns, own)
    both = np.concatenate([columns, own], axis=1)
    np.testing.assert_allclose(np.linalg.inv(left.T @ left), np.linalg.inv(both.T @ both)[:3, :3], rtol=1e-9)
