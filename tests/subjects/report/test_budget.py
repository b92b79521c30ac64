"""Budgets by the GUM."""

from dataclasses import replace
from math import inf, isclose, sqrt

import numpy as np
import pytest
from scipy import stats

from irtiming.records.estimate import Estimate
from irtiming.records.result import Contribution, Result
from irtiming.report import budget, result
from irtiming.report.sections import parameters

ALL_EDGES = ("trigger_delay", "trigger_delay_falling", "trigger_delay_rising")


def _line(source: str, u: float, freedom: float = inf) -> budget.Line:
    return budget.Line(source=source, kind="A", standard_uncertainty=u, degrees_of_freedom=freedom)


def _at_one_speed(edges_s: float, common_s: float) -> Result:
    """Four edges with independent errors that give the delay ``edges_s``, and an error in common."""
    weights = np.array([[0.25] * 4, [0.5, 0, 0.5, 0], [0, 0.5, 0, 0.5]])
    covariance = weights @ (4 * edges_s**2 * np.eye(4) + common_s**2) @ weights.T
    edges = dict(zip(ALL_EDGES, (edges_s, sqrt(2) * edges_s, sqrt(2) * edges_s), strict=True))
    return Result(
        method="pixel-sum",
        estimate=Estimate(names=ALL_EDGES, units=("s",) * len(ALL_EDGES), values=np.zeros(3), covariance=covariance),
        relative_delays=(),
        budget=(
            Contribution(
                source="mask centre angle phi_M", kind="B", standard_uncertainty=dict.fromkeys(ALL_EDGES, common_s)
            ),
            Contribution(source="cutout edges", kind="A", standard_uncertainty=edges, degrees_of_freedom=3.0),
        ),
        edge_delay_s=np.zeros(4),
        u_edge_delay_s=np.zeros(4),
    )


@pytest.mark.parametrize(
    ("freedom", "k"), [(3, 3.31), (1, 13.97), (10, 2.28), (50, 2.05), (inf, 2.00)], ids=lambda value: str(value)
)
def test_coverage_factors_are_those_of_the_tables(freedom, k):
    """Oracle: GUM, table G.2, column 95.45 %."""
    assert round(budget.coverage_factor(freedom), 2) == k


def test_coverage_factors_follow_students_t():
    """Oracle: scipy's t, which covers 95.45 % within k."""
    for freedom in (1.0, 3.0, 7.5, 40.0):
        inside = stats.t.cdf(budget.coverage_factor(freedom), freedom) - stats.t.cdf(
            -budget.coverage_factor(freedom), freedom
        )
        assert inside == pytest.approx(0.9545, abs=1e-9)


def test_the_sum_is_the_root_of_the_sum_of_squares():
    """Oracle: numbers by hand; 3, 4 and 12 us make 13 us; GUM (G.2b) for the degrees of freedom."""
    found = budget.add([_line("a", 3e-6, 3.0), _line("b", 4e-6), _line("c", 12e-6, 50.0), _line("none", 0.0, 5.0)])
    assert found.standard_uncertainty == pytest.approx(13e-6, rel=1e-12)
    assert found.degrees_of_freedom == pytest.approx(13**4 / (3**4 / 3 + 12**4 / 50), rel=1e-9)
    assert [line.source for line in found.lines] == ["c", "b", "a", "none"]
    assert [line.share for line in found.lines] == pytest.approx([144 / 169, 16 / 169, 9 / 169, 0])


def test_a_single_contribution_keeps_its_degrees_of_freedom():
    """Oracle: Welch and Satterthwaite with one term; nothing known has no uncertainty and no share."""
    assert budget.add([_line("edges", 1e-6, 3.0)]).degrees_of_freedom == pytest.approx(3)
    nothing = budget.add([])
    assert (nothing.standard_uncertainty, nothing.lines) == (0.0, ())


def test_the_budget_meets_the_covariance_of_the_estimate(analysis):
    """Oracle: the covariance, which the estimation makes without a budget."""
    assert budget.of(analysis.best, "trigger_delay").standard_uncertainty == pytest.approx(
        float(analysis.best.estimate.standard_uncertainties[0]), rel=1e-9
    )


def test_half_of_the_edges_double_what_edges_give_to_the_variance():
    """Oracle: by hand: the delay has 2 and 4 us, one half sqrt(2) 2 and 4 us; the split 4 us from the edges alone."""
    told = _at_one_speed(edges_s=2e-6, common_s=4e-6)
    whole, half = 20**2 / (2**4 / 3), 24**2 / (8**2 / 3)
    assert budget.of(told, "trigger_delay").degrees_of_freedom == pytest.approx(whole)
    assert budget.of(told, "trigger_delay_falling").degrees_of_freedom == pytest.approx(half)
    assert budget.of(told, "integration_time").degrees_of_freedom == inf
    split = budget.falling_minus_rising(told)
    assert split.standard_uncertainty_s == pytest.approx(4e-6)
    assert split.degrees_of_freedom == pytest.approx(3)


def test_what_a_delay_does_not_hold_gives_it_no_degrees_of_freedom():
    """Oracle: by hand: the length of the window is in the budget of the start, and not in the variance of the middle."""
    told = _at_one_speed(edges_s=2e-6, common_s=0.0)
    window = Contribution(source="length of the window", kind="A", standard_uncertainty={"trigger_delay": 9e-6})
    longer = replace(told, budget=(*told.budget, window))
    assert budget.of(longer, "trigger_delay_falling").degrees_of_freedom == pytest.approx(3)
    assert budget.of(longer, "trigger_delay").degrees_of_freedom == pytest.approx((2**2 + 9**2) ** 2 / (2**4 / 3))


def test_few_degrees_of_freedom_widen_the_interval():
    """Oracle: k = 3.31 for edges alone; a factor of 2 would have been too small by a third."""
    told = _at_one_speed(edges_s=1e-6, common_s=0.0)
    assert budget.expanded_text(1e-6, budget.of(told, "trigger_delay").degrees_of_freedom) == ("3.3 µs", "3.31")


def test_the_result_carries_k_and_degrees_of_freedom(analysis):
    """Oracle: k is that of the degrees of freedom, U is k u; null stands for infinite."""
    few = tuple(replace(part, degrees_of_freedom=5.0) for part in analysis.best.budget)
    delay = result.result(replace(analysis, best=replace(analysis.best, budget=few)))["parameters"]["trigger_delay"]
    freedom = 30**4 / (24**4 / 5 + 18**4 / 5)
    assert delay["effective_degrees_of_freedom"] == pytest.approx(freedom)
    assert delay["coverage_factor"] == pytest.approx(stats.t.ppf(0.5 + 0.9545 / 2, freedom), rel=1e-6)
    assert delay["expanded_uncertainty"] == pytest.approx(delay["coverage_factor"] * 30e-6)
    many = tuple(replace(part, degrees_of_freedom=inf) for part in analysis.best.budget)
    known = result.result(replace(analysis, best=replace(analysis.best, budget=many)))["parameters"]["trigger_delay"]
    assert known["effective_degrees_of_freedom"] is None
    assert round(known["coverage_factor"], 4) == 2.0


def test_lines_of_the_result_say_how_well_they_are_known(analysis):
    """Oracle: the hand-made budget; shares add up to 100 %."""
    lines = result.result(analysis)["budget"]
    assert [line["degrees_of_freedom"] for line in lines] == [None, 400.0]
    assert [line["share_percent"] for line in lines] == pytest.approx([64, 36])


def test_each_parameter_of_a_rolling_camera_has_its_own_k(rolling):
    """Oracle: edges touch the trigger delay alone: 3 degrees of freedom there, infinite elsewhere."""
    edges = Contribution(
        source="cutout edges", kind="A", standard_uncertainty={"trigger_delay": 30e-6}, degrees_of_freedom=3.0
    )  # fmt: skip
    noise = replace(rolling.best.budget[1], standard_uncertainty={"time_constant": 4e-6, "row_delay": 0.2e-6})
    told = replace(rolling, best=replace(rolling.best, budget=(edges, noise)))
    found = result.result(told)["parameters"]
    assert round(found["trigger_delay"]["coverage_factor"], 2) == 3.31
    assert found["trigger_delay"]["effective_degrees_of_freedom"] == pytest.approx(3)
    assert found["time_constant"]["effective_degrees_of_freedom"] is None
    lines = result.result(told)["budget"]
    assert lines[0]["share_percent"] == pytest.approx({"trigger_delay": 100, "time_constant": 0, "row_delay": 0})


def test_a_length_has_no_sign(analysis):
    """Oracle: the window's length comes neither before nor after anything."""
    estimate = analysis.best.estimate
    names = (*estimate.names, "integration_time")
    wide = np.zeros((5, 5))
    wide[:4, :4], wide[4, 4] = estimate.covariance, 10e-6**2
    longer = Estimate(
        names=names, units=("s",) * len(names), values=np.append(estimate.values, 250e-6), covariance=wide
    )
    told = replace(analysis, best=replace(analysis.best, estimate=longer))
    found = result.result(told)["parameters"]["integration_time"]
    assert found["reference_event"] == "length of the integration window"
    assert found["sign"] is None
    assert isclose(found["expanded_uncertainty"], 20e-6, rel_tol=1e-5)
    assert parameters.parameters(told).rows[4] == (
        "integration_time", "250 ± 10 µs", "20 µs", "2.00", "length of the integration window",
    )  # fmt: skip
    assert sqrt(longer.covariance[4, 4]) == found["standard_uncertainty"]
