"""The covariance by residuals against the scatter of repeated fits of a straight line in k parameters."""

import numpy as np
import pytest

from irtiming.estimate.row_residuals import robust_covariance

N = 400


@pytest.fixture(scope="module")
def design():
    """Slopes of a model with three parameters in five rows, over the wheel angle; shape (n, row, 3)."""
    theta = 2 * np.pi * (np.arange(N) + 0.5) / N
    columns = np.stack([np.sin(theta), np.cos(2 * theta), np.sin(3 * theta + 0.4)], axis=1)
    return columns[:, None, :] * np.linspace(0.6, 1.4, 5)[None, :, None]


def _repeat(design, noise_of, *, n=600):
    """Estimates of many repetitions, and the covariances that each states; noise is taken to be white of size 1."""
    information = np.einsum("nrk,nrl->nkl", design, design)
    normal = information.sum(axis=0)
    estimates, stated, factors = [], [], []
    for _ in range(n):
        noise = noise_of()
        found = np.linalg.solve(normal, np.einsum("nrk,nr->k", design, noise))
        residual = noise - design @ found
        covariance, variance_inflation = robust_covariance(
            np.einsum("nrk,nr->nk", design, residual), normal, information=information
        )
        estimates.append(found)
        stated.append(covariance)
        factors.append(variance_inflation)
    return np.array(estimates), np.array(stated), np.array(factors), np.linalg.inv(normal)


def test_white_residuals_state_their_own_scatter(design):
    """Oracle: 600 repetitions with white noise; never less than the inverse of the normal matrix, little more."""
    rng = np.random.default_rng(1)
    estimates, stated, factors, white = _repeat(design, lambda: rng.normal(size=(N, 5)))
    scatter = estimates.std(axis=0)
    u = np.sqrt(np.mean([np.diag(c) for c in stated], axis=0))
    np.testing.assert_allclose(scatter, np.sqrt(np.diag(white)), rtol=0.1)
    assert np.all(u > 0.95 * scatter)
    assert np.all(u < 1.25 * scatter)
    assert all(np.all(np.diag(c) >= np.diag(white) * (1 - 1e-12)) for c in stated)
    assert np.all(factors >= 1)
    assert np.mean(factors) < 1.2


def test_noise_that_all_rows_of_a_frame_share_is_seen(design):
    """Oracle: 600 repetitions; half of the variance is common to the rows, so that white noise would state too little."""
    rng = np.random.default_rng(2)

    def noise():
        return np.sqrt(0.5) * (rng.normal(size=(N, 5)) + rng.normal(size=(N, 1)))

    estimates, stated, factors, white = _repeat(design, noise)
    scatter = estimates.std(axis=0)
    u = np.sqrt(np.mean([np.diag(c) for c in stated], axis=0))
    assert np.all(scatter > 1.5 * np.sqrt(np.diag(white)))
    np.testing.assert_allclose(u, scatter, rtol=0.15)
    assert np.mean(factors) == pytest.approx(np.mean(scatter**2 / np.diag(white)), rel=0.15)


@pytest.mark.parametrize("length", [2, 4])
def test_residuals_that_hang_together_along_the_angle_are_seen(design, length):
    """Oracle: 600 repetitions with a moving mean of 2 or 4 frames, which neighbours share, each row of its own."""
    rng = np.random.default_rng(3)

    def noise():
        white = rng.normal(size=(N, 5))
        return sum(np.roll(white, k, axis=0) for k in range(length)) / np.sqrt(length)

    estimates, stated, factors, white = _repeat(design, noise)
    scatter = estimates.std(axis=0)
    u = np.sqrt(np.mean([np.diag(c) for c in stated], axis=0))
    assert np.all(scatter > 1.3 * np.sqrt(np.diag(white)))
    assert np.all(u > 0.8 * scatter)  # the triangle over eight neighbours leaves some of it out
    assert np.all(u < 1.15 * scatter)
    assert np.mean(factors) > 1.5


def test_the_circle_is_closed(design):
    """Oracle: scores are sorted by the wheel angle, which has no end; where the list begins does not matter."""
    scores = np.random.default_rng(4).normal(size=(N, 3))
    information = np.einsum("nrk,nrl->nkl", design, design)
    normal = information.sum(axis=0)
    one, other = (
        robust_covariance(np.roll(scores, by, axis=0), normal, information=np.roll(information, by, axis=0))
        for by in (0, 137)
    )
    np.testing.assert_allclose(one[0], other[0], rtol=1e-10)
    assert one[1] == pytest.approx(other[1])


def test_what_the_fit_has_taken_from_the_scores_is_given_back():
    """Oracle: 600 repetitions of 240 frames, each all in error by a number of its own, and four edges that 40 of them show.

    Each edge has a delay and a length, which change its light evenly and by a straight line. By the scores as the fit leaves them
    u is three quarters of the scatter.
    """
    rng, n = np.random.default_rng(9), 240
    slopes = np.zeros((n, 8))
    for edge in range(4):
        shown = slice(60 * edge + 10, 60 * edge + 50)
        slopes[shown, 2 * edge], slopes[shown, 2 * edge + 1] = 3.0, np.linspace(-4, 4, 40)
    information = slopes[:, :, None] * slopes[:, None, :]
    normal, scatter, stated = information.sum(axis=0), [], []
    for _ in range(600):
        noise = 2 * rng.normal(size=n)
        found = np.linalg.solve(normal, slopes.T @ noise)
        residual = noise - slopes @ found
        covariance, _ = robust_covariance(slopes * residual[:, None], normal, information=information)
        scatter.append(found)
        stated.append(np.diag(covariance))
    u = np.sqrt(np.mean(stated, axis=0))
    np.testing.assert_allclose(u / np.std(scatter, axis=0), 1, atol=0.1)
    assert np.mean(u / np.std(scatter, axis=0)) == pytest.approx(1.0, abs=0.04)


def test_recordings_are_combined_with_the_scatter_that_they_state():
    """Oracle: 300 repetitions of four recordings of 250 frames and nine numbers; the mean by their covariances has pulls of 1.

    With covariances as those frames alone estimate them the root mean square of the pulls is 1.22.
    """
    rng, n, k = np.random.default_rng(8), 250, 9
    theta = 2 * np.pi * np.arange(n) / n
    slopes = np.stack([np.cos(m * theta + 0.3 * m) for m in range(1, k + 1)], axis=1)
    information, pulls = slopes[:, :, None] * slopes[:, None, :], []
    normal = information.sum(axis=0)
    for _ in range(300):
        weights, weighted = np.zeros((k, k)), np.zeros(k)
        for _ in range(4):
            noise = rng.normal(size=n)
            found = np.linalg.solve(normal, slopes.T @ noise)
            residual = noise - slopes @ found
            covariance, _ = robust_covariance(slopes * residual[:, None], normal, information=information)
            weight = np.linalg.inv(covariance)
            weights, weighted = weights + weight, weighted + weight @ found
        pulls.append(np.linalg.solve(weights, weighted) / np.sqrt(np.diag(np.linalg.inv(weights))))
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("repeats", [4, 12])
def test_what_is_missed_in_each_repeat_of_a_turn_is_seen(repeats):
    """Oracle: 100 repetitions; a smooth error along the angle, two samples wide, is the same in all turns of a recording.

    Were 8 frames the neighbours, u would be two thirds and a third of the scatter: then they are all of a sample or less.
    """
    rng, n = np.random.default_rng(7), 1000
    theta = 2 * np.pi * np.arange(n) / n
    slopes = np.stack([np.sin(theta), np.cos(2 * theta)], axis=1)
    scatter, stated = [], []
    for _ in range(100):
        missed = np.convolve(np.tile(rng.normal(size=n), 3), np.exp(-0.5 * (np.arange(-8, 9) / 2) ** 2), "same")[
            n : 2 * n
        ]
        noise = np.repeat(missed, repeats) + 0.3 * rng.normal(size=n * repeats)
        design = np.repeat(slopes, repeats, axis=0)
        information = design[:, :, None] * design[:, None, :]
        normal = information.sum(axis=0)
        found = np.linalg.solve(normal, design.T @ noise)
        scatter.append(found)
        covariance, _ = robust_covariance(design * (noise - design @ found)[:, None], normal, information=information)
        stated.append(np.diag(covariance))
    u = np.sqrt(np.mean(stated, axis=0))
    np.testing.assert_array_less(0.7 * np.std(scatter, axis=0), u)
    np.testing.assert_array_less(u, 1.2 * np.std(scatter, axis=0))


def test_a_smaller_scatter_than_white_is_not_believed():
    """Oracle: the inverse of the normal matrix; scores of a tenth of the size that white noise would give."""
    scores, information = 0.1 * np.random.default_rng(6).normal(size=(N, 2)), np.tile(np.eye(2), (N, 1, 1))
    found, variance_inflation = robust_covariance(scores, N * np.eye(2), information=information)
    np.testing.assert_allclose(np.diag(found), 1 / 400)
    assert variance_inflation == 1.0
    assert abs(found[0, 1]) < found[0, 0]
