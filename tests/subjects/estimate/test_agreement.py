"""Whether recordings and what is known beforehand agree: by hand, and over many draws."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import agreement, joint
from irtiming.estimate.joint import LocalModel
from irtiming.estimate.shared_numbers import SharedNumber
from irtiming.records.estimate import Estimate


def _told(values, covariance, names=("x",)):
    return joint.parabola(
        Estimate(names=names, units=("s",) * len(names), values=np.array(values), covariance=np.array(covariance))
    )


X = SharedNumber(name="x", effects=[{"x": 1.0}] * 2)
ERROR = SharedNumber(name="error", unit="1", effects=[{}, {"x": 0.1}], u=1.0)


def test_two_recordings_of_one_number_by_hand():
    """Oracle: by hand; 1 and 1.8 with u of 0.1 and 0.2 have the mean 1.16, 1.6 u and 3.2 u away: 12.8 with one degree."""
    fitted = joint.fit([_told([1.0], [[0.01]]), _told([1.8], [[0.04]])], [X])
    found = agreement.agreement(fitted, names=("a", "b"))
    assert found.distances == pytest.approx({"recording a": 1.6, "recording b": 3.2}, rel=1e-6)
    assert found.chi_square == pytest.approx(12.8, rel=1e-6)
    assert found.degrees_of_freedom == 1
    assert found.p_value == pytest.approx(3.47e-4, rel=2e-3)  # of a normal deviate of 3.578, both sides
    assert agreement.findings(fitted, [SimpleNamespace(name=name) for name in "ab"]) == ()


def test_what_is_known_beforehand_counts_and_is_named():
    """Oracle: by hand; a difference of 2.4 whose variance is 0.01 + 0.04 + 0.1^2: 96, of which the error is 4 u off."""
    fitted = joint.fit([_told([1.0], [[0.01]]), _told([3.4], [[0.04]])], [X, ERROR])
    found = agreement.agreement(fitted, names=("a", "b"))
    assert found.chi_square == pytest.approx(2.4**2 / 0.06, rel=1e-6)
    assert found.degrees_of_freedom == 1
    assert found.distances["error"] == pytest.approx(2.4 * 0.1 / 0.06, rel=1e-6)
    (doubt,) = agreement.findings(fitted, [SimpleNamespace(name=name) for name in "ab"])
    assert (doubt.code, doubt.severity) == ("statements-contradict", "doubt")
    assert "chi-square 96 with 1 degree of freedom" in doubt.what
    assert doubt.what.endswith("farthest off are recording b (8.0 u), recording a (4.0 u)")


def test_axes_of_which_a_recording_says_nothing_do_not_count():
    """Oracle: by hand; one recording knows x + y alone, the other both: three statements of two numbers."""

    def at(numbers):
        apart = np.array([(numbers["x"] + numbers["y"] - 3.0) / 0.1])
        return joint.Linearised(residual=apart, jacobian=np.array([[10.0, 10.0]]))

    shared = [replace(X, name=name, effects=[{name: 1.0}] * 2) for name in ("x", "y")]
    models = [LocalModel(names=("x", "y"), at=at), _told([1.0, 1.0], np.diag([0.01, 0.02]), names=("x", "y"))]
    found = agreement.agreement(joint.fit(models, shared), names=("a", "b"))
    assert found.degrees_of_freedom == 1
    assert found.chi_square == pytest.approx(1 / 0.04, rel=1e-6)


def test_recordings_that_agree_have_a_chi_square_of_their_degrees_of_freedom():
    """Oracle: a law; mean nu and variance 2 nu over 400 draws of three recordings with an error that two of them share."""
    random, covariance = np.random.default_rng(3), np.array([[0.02, 0.01], [0.01, 0.03]])
    shared = [
        replace(X, effects=[{"x": 1.0}] * 3),
        replace(X, name="y", effects=[{"y": 1.0}] * 3),
        replace(ERROR, effects=[{}, {"x": 0.1, "y": -0.2}, {"x": 0.1}]),
    ]
    half, found = np.linalg.cholesky(covariance), []
    for _ in range(400):
        error = random.normal()
        moved = np.array([[0.0, 0.0], [0.1, -0.2], [0.1, 0.0]]) * error
        values = [half @ random.normal(size=2) + move for move in moved]
        models = [_told(value, covariance, names=("x", "y")) for value in values]
        found.append(agreement.agreement(joint.fit(models, shared), names="abc"))
    assert {one.degrees_of_freedom for one in found} == {4}
    squares = np.array([one.chi_square for one in found])
    assert squares.mean() == pytest.approx(4, abs=4 * np.sqrt(8 / 400))
    assert np.mean([one.p_value < 0.1 for one in found]) == pytest.approx(0.1, abs=4 * np.sqrt(0.09 / 400))
