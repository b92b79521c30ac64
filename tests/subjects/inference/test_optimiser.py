"""The one optimiser, on problems with known answers."""

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.inference import optimiser, variable_projection
from irtiming.inference.optimiser import Linearised

TIME = np.linspace(0, 4, 40)


def _decay(numbers):
    """Exponential with noise: residuals and derivatives to height and rate."""
    height, rate = numbers["height"], numbers["rate"]
    wave = np.exp(-rate * TIME)
    noise = 0.01 * np.sin(37 * TIME)
    data = 2 * np.exp(-0.7 * TIME) + noise
    return Linearised(residual=data - height * wave, jacobian=np.stack([-wave, height * TIME * wave], axis=1))


def test_the_minimum_is_that_of_another_program():
    """Oracle: MINPACK's Levenberg-Marquardt (scipy.optimize.curve_fit) from the true values."""
    from scipy.optimize import curve_fit

    data = 2 * np.exp(-0.7 * TIME) + 0.01 * np.sin(37 * TIME)
    best, covariance = curve_fit(
        lambda t, h, r: h * np.exp(-r * t), TIME, data, p0=(2, 0.7), sigma=np.ones(40), absolute_sigma=True
    )
    found = optimiser.minimise(_decay, start={"height": 1.0, "rate": 3.0})
    assert list(found.values.values()) == pytest.approx(best, abs=1e-5)
    assert np.linalg.inv(found.at.normal) == pytest.approx(covariance, rel=1e-3)
    assert found.is_settled
    assert found.start == {"height": 1.0, "rate": 3.0}


@pytest.mark.parametrize("n", [40, 40_000])
def test_a_search_ends_a_hundredth_of_a_standard_uncertainty_from_the_minimum(n):
    """Oracle: a law; the same search to the last digit. However many the residuals are, it ends as near, and sooner."""
    time, noise = np.linspace(0, 4, n), np.random.default_rng(5).standard_normal(n)

    def decay(numbers):
        wave = np.exp(-numbers["rate"] * time) * 100 / np.sqrt(n)
        data = 2 * np.exp(-0.7 * time) * 100 / np.sqrt(n) + noise
        # slopes that are a little wrong, with which a search comes near in many steps
        slopes = np.stack([-wave, 0.9 * numbers["height"] * time * wave], axis=1)
        return Linearised(residual=data - numbers["height"] * wave, jacobian=slopes)

    start = {"height": 1.0, "rate": 2.0}
    found, whole = optimiser.minimise(decay, start=start), optimiser.minimise(decay, start=start, gain=1e-15)
    u = np.sqrt(np.diag(np.linalg.inv(whole.at.normal)))
    off = np.array(list(found.values.values())) - list(whole.values.values())
    assert np.all(np.abs(off) < 0.02 * u)
    assert found.n_steps < whole.n_steps


def test_a_held_number_stays_and_the_other_finds_its_best():
    """Oracle: at a fixed rate the height is a linear problem, solved by its normal equation."""
    found = optimiser.minimise(_decay, start={"height": 1.0, "rate": 0.5}, held=("rate",))
    wave = np.exp(-0.5 * TIME)
    data = 2 * np.exp(-0.7 * TIME) + 0.01 * np.sin(37 * TIME)
    assert found.values == {"height": pytest.approx(wave @ data / (wave @ wave)), "rate": 0.5}
    assert found.free == ("height",)


def test_where_all_is_held_the_start_is_the_result():
    """Oracle: by hand; the residuals there, from one evaluation, and nothing that could still be gained."""
    start = {"height": 1.5, "rate": 0.5}
    found = optimiser.minimise(_decay, start=start, held=("height", "rate"))
    assert (found.values, found.free, found.n_steps, found.decrement) == (start, (), 1, 0.0)
    np.testing.assert_array_equal(found.at.residual, _decay(start).residual)


def test_a_kink_ends_no_search():
    """Oracle: |x - 1| + 3 (x - 1.2)^2 by hand: its minimum lies at the kink, x = 1.2 - 1/6 = 1.0333 from the right."""

    def kinked(numbers):
        x = numbers["x"]
        root = np.sqrt(abs(x - 1) + 1e-12)
        return Linearised(
            residual=np.array([root, np.sqrt(3) * (x - 1.2)]),
            jacobian=np.array([[np.sign(x - 1) / (2 * root)], [np.sqrt(3)]]),
        )

    found = optimiser.minimise(kinked, start={"x": 4.0}, gain=1e-9)
    assert found.values["x"] == pytest.approx(1.2 - 1 / 6, abs=1e-3)


def test_a_search_that_ends_early_tells_how_far_it_is_from_the_minimum():
    """Oracle: the deviance there less that of the minimum, whose root is the distance in standard uncertainties."""

    def weighed(numbers):
        there = _decay(numbers)
        return Linearised(residual=100 * there.residual, jacobian=100 * there.jacobian)

    early = optimiser.minimise(weighed, start={"height": 1.9, "rate": 0.8}, gain=0.999)
    whole = optimiser.minimise(weighed, start={"height": 1.9, "rate": 0.8})
    off = np.sqrt(early.at.deviance - whole.at.deviance)
    assert off > 0.1
    assert early.decrement == pytest.approx(off, rel=0.01)
    assert not early.is_settled


def test_a_minimum_in_a_kink_is_reached():
    """Oracle: by hand; nothing changes below 0, where the residual is 1: no step lowers it, though its derivative is 1 there."""

    def model(numbers):
        x = numbers["x"]
        return Linearised(residual=np.array([max(x, 0.0) + 1]), jacobian=np.array([[1.0 if x >= 0 else 0.0]]))

    found = optimiser.minimise(model, start={"x": 0.0}, gain=1e-9)
    assert np.linalg.norm(found.at.residual) == pytest.approx(1.0)
    assert found.decrement == pytest.approx(0.0, abs=1e-9)
    assert found.is_settled


def test_where_a_further_step_tells_nothing_its_length_counts():
    """Oracle: by hand; residual and derivative are 1 at 0, just below it the residual is 2, and farther there is none."""

    def model(numbers):
        x = numbers["x"]
        below = 2.0 if x > -0.05 else np.nan
        return Linearised(residual=np.array([x + 1 if x >= 0 else below]), jacobian=np.ones((1, 1)))

    found = optimiser.minimise(model, start={"x": 0.0})
    assert found.decrement == pytest.approx(1.0, abs=1e-6)
    assert not found.is_settled


def test_a_start_without_finite_residuals_is_refused():
    """Oracle: the message's contract: the value that the search began at, and what to do."""
    with pytest.raises(EstimationError, match=r"x = 1.*check rig.toml"):
        optimiser.minimise(
            lambda _: Linearised(residual=np.array([np.nan]), jacobian=np.ones((1, 1))), start={"x": 1.0}
        )


def test_projection_has_the_minimum_of_the_whole_problem():
    """Oracle: the same least squares with the height as a parameter like the rate."""
    data = 2 * np.exp(-0.7 * TIME) + 0.01 * np.sin(37 * TIME)

    def projected(numbers):
        wave = np.exp(-numbers["rate"] * TIME)
        return variable_projection.project(
            data, wave[:, None], slopes_of=lambda levels: (-levels[0] * TIME * wave)[:, None]
        ).at

    whole = optimiser.minimise(_decay, start={"height": 1.0, "rate": 3.0})
    alone = optimiser.minimise(projected, start={"rate": 3.0})
    assert alone.values["rate"] == pytest.approx(whole.values["rate"], abs=1e-6)
    assert alone.at.deviance == pytest.approx(whole.at.deviance)
    schur = 1 / np.linalg.inv(whole.at.normal)[1, 1]
    assert alone.at.normal[0, 0] == pytest.approx(schur, rel=1e-3)
