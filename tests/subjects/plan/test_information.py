"""Information of runs, added up and turned into uncertainties."""

import numpy as np
import pytest

from irtiming.errors import PlanError
from irtiming.inference.information import NOISE
from irtiming.physics.camera import camera
from irtiming.plan import information
from irtiming.plan.information import run_information

PER_S = 1e6
"""One over the uncertainty of a delay by one run, 1 us."""


def _delay(u_angle_s):
    """A run that tells its delay plus an angle error of this size, s, to 1 us."""
    column = np.array([1.0, u_angle_s]) * PER_S
    return run_information(("trigger_delay",), ("angle",), matrix=np.outer(column, column))


def _u(one, **weights):
    (found,) = information.uncertainties(one, {"asked": weights})
    return found


def test_an_angle_error_at_one_speed_adds_to_the_noise_and_stays():
    """Oracle: by hand; 1 us of noise over the root of 4 runs, and 3 us of angle whatever their number."""
    found = _u(_delay(3e-6).times(4), trigger_delay=1.0)
    parts = {part.source: part.standard_uncertainty_s for part in found.parts}
    assert parts[NOISE] == pytest.approx(0.5e-6)
    assert parts["angle"] == pytest.approx(3e-6)
    assert found.standard_uncertainty_s == pytest.approx(np.hypot(0.5e-6, 3e-6))
    assert found.largest_part.source == "angle"


def test_two_speeds_tell_a_delay_from_an_angle():
    """Oracle: by hand; t from d_1 = t + e and d_2 = t + e / 4, each to 1 us, is (4 d_2 - d_1) / 3 where e is any."""
    both = information.total([_delay(1.0), _delay(0.25)])
    assert _u(both, trigger_delay=1.0).standard_uncertainty_s == pytest.approx(1e-6 * np.sqrt(17) / 3, rel=1e-6)


def test_a_difference_of_two_delays_knows_no_angles():
    """Oracle: by hand; the angle error is the same in both, noise is that of two runs."""
    found = _u(information.apart(_delay(3e-6), _delay(3e-6)), relative_delay=1.0)
    assert found.standard_uncertainty_s == pytest.approx(1e-6 * np.sqrt(2))
    assert found.largest_part.source == NOISE


def test_variances_are_the_squares_of_the_uncertainties():
    """Oracle: the other function, which splits them into parts."""
    both = information.total([_delay(2e-6), _delay(1e-6).times(3)])
    (square,) = information.variances(both, {"asked": {"trigger_delay": 1.0}})
    assert square == pytest.approx(_u(both, trigger_delay=1.0).standard_uncertainty_s ** 2)


def test_runs_that_differ_in_their_parameters_are_not_added():
    """Oracle: their matrices would not mean the same."""
    other = run_information(("row_delay",), ("angle",), matrix=np.eye(2))
    with pytest.raises(PlanError, match="same parameters"):
        information.total([_delay(1e-6), other])


def test_what_no_run_tells_is_refused_by_name():
    """Oracle: a parameter without information has no uncertainty."""
    blind = run_information(("trigger_delay", "skew"), (), matrix=np.diag([PER_S**2, 0.0]))
    with pytest.raises(PlanError, match="skew"):
        information.combined(blind)


@pytest.mark.parametrize(
    ("camera_type", "stated", "u"),
    [
        ("photon", None, 0.05),
        ("photon", 0.002, 0.002),
        ("microbolometer", None, 0.5),
        ("microbolometer", 0.002, 0.002),
    ],
)
def test_a_memory_that_nobody_states_is_small_and_a_filter_may_be_strong(camera_type, stated, u):
    """Oracle: by hand; what is stated counts alone."""
    (known,) = information.stated_memory(camera(camera_type, "rolling"), stated)
    assert known.matrix.item() ** -0.5 == pytest.approx(u)
