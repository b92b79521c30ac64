"""Which of two minima of a recording counts, and what is said where nothing decides: by hand."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from irtiming.estimate import rivals
from irtiming.records.estimate import Estimate
from irtiming.records.rig import Measured
from irtiming.records.row_timing import Rival

NAMES = ("edge_delay_0", "time_constant", "recursive_filter")
SHORT = {"edge_delay_0": 3e-3, "time_constant": 3e-3, "recursive_filter": 0.3}
LONG = {"edge_delay_0": 6e-3, "time_constant": 12e-3, "recursive_filter": -0.06}


@dataclass(frozen=True, kw_only=True)
class _Fit:
    """What rivals ask of a fit."""

    estimate: Estimate
    rival: Rival | None = None
    name: str = "run"
    held: dict[str, float] = field(default_factory=dict)

    @property
    def timing(self):
        return dict(zip(self.estimate.names, self.estimate.values.tolist(), strict=True))


def _fit(timing, *, u=(1e-4, 5e-4, 0.02), other=None, higher=0.0):
    estimate = Estimate(
        names=NAMES, units=("s", "s", "1"), values=np.array(list(timing.values())), covariance=np.diag(np.square(u))
    )
    return _Fit(estimate=estimate, rival=None if other is None else Rival(timing=other, higher=higher))


def test_a_recording_goes_with_the_surest_one():
    """Oracle: by hand; 9 ms and 0.36 apart at u of 0.71 ms and 0.028: 326 of deviance, against 5 by which the other is higher."""
    astray, sure = _fit(LONG, other=SHORT, higher=5.0), _fit(SHORT)
    first, second = rivals.consistent([astray, sure], frame_memory=None)
    assert first.timing == SHORT
    assert first.rival.timing == LONG
    assert first.rival.higher == pytest.approx(9**2 / 0.5 + 0.36**2 / 8e-4 - 5)
    assert second is sure


@pytest.mark.parametrize(("higher", "is_left"), [(323.0, True), (325.0, False)])
def test_a_minimum_that_is_lower_by_more_than_the_others_are_apart_stays(higher, is_left):
    """Oracle: by hand; 162 + 162 of deviance apart."""
    astray, sure = _fit(LONG, other=SHORT, higher=higher), _fit(SHORT)
    assert (rivals.consistent([astray, sure], frame_memory=None)[0].timing == SHORT) is is_left


@pytest.mark.parametrize(("stated", "filter_share"), [(0.0, -0.06), (0.3, 0.3)])
def test_what_is_stated_of_the_filter_decides(stated, filter_share):
    """Oracle: by hand; 0.36 over 0.02 and 0.01 is far more than the 2 by which one minimum is higher."""
    for fit in (_fit(LONG, other=SHORT, higher=2.0), _fit(SHORT, other=LONG, higher=2.0)):
        (found,) = rivals.consistent([fit], frame_memory=Measured(stated, 0.01))
        assert found.timing["recursive_filter"] == filter_share
        assert rivals.findings([found]) == ()


def test_where_nothing_decides_both_answers_are_said():
    """Oracle: by hand; 2 + 3 of deviance are within 3 u, 2 + 8 are not, and a recording without another minimum decides."""
    near, far = _fit(SHORT, other=LONG, higher=2.0), _fit(SHORT, other=LONG, higher=8.0)
    (doubt,) = rivals.findings([near, _fit(SHORT, other=LONG, higher=3.0)])
    assert (doubt.code, doubt.severity) == ("two-minima", "doubt")
    assert "time constant 3.000 ms with recursive filter 30.00 %, which is the result" in doubt.what
    assert (
        "or time constant 12.000 ms with recursive filter -6.00 %, whose deviance is higher by no more than 5.0"
        in doubt.what
    )
    assert rivals.findings([near, far]) == rivals.findings([near, _fit(SHORT)]) == rivals.findings([]) == ()
