"""What is said of a response that is no straight line: by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import nonlinearity
from irtiming.physics.light.bent_rows import CUBIC, QUADRATIC
from irtiming.records.estimate import Estimate


@pytest.mark.parametrize(
    ("cubic", "severity"), [(0.041, "doubt"), (-0.041, "doubt"), (0.039, "warning"), (-0.039, "warning")]
)
def test_a_cubic_part_beyond_four_u_is_a_doubt(cubic, severity):
    """Oracle: by hand; of u = 0.01 four are 0.04, to either side; a quarter of 0.2 is 5 % off the straight line."""
    names = (f"{QUADRATIC}_a", f"{CUBIC}_a")
    known = Estimate(names=names, units=("1", "1"), values=np.array([0.2, cubic]), covariance=np.diag([1e-4, 1e-4]))
    joint = SimpleNamespace(
        names=("opening_angle", *names), estimate=lambda asked: known.pick(*(one.name for one in asked))
    )
    (found,) = nonlinearity.of_joint(joint)
    assert (found.code, found.severity) == ("response-not-linear", severity)
    assert "lies +5 % of the contrast off a straight line" in found.what
