"""How much recordings differ over what their noise explains: by hand and by many draws."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import scatter
from irtiming.records.estimate import EDGE_DELAYS, Estimate

TURN = 2 * np.pi
LAGGING = (*EDGE_DELAYS, "time_constant", "row_delay")


def _fit(values, covariance, *, hz=3.0, names=EDGE_DELAYS):
    estimate = Estimate(names=names, units=("s",) * len(names), values=np.asarray(values), covariance=covariance)
    return SimpleNamespace(estimate=estimate, angular_frequency_rad_per_s=TURN * hz)


def test_birge_ratio_of_two_runs_by_hand():
    """Oracle: by hand; means of four edges at 2 us each are known to 1 us: 3 us apart are 9 / 2 of chi-square for one degree."""
    fits = [_fit(np.full(4, 1e-3 + d), 4e-12 * np.eye(4)) for d in (0.0, 3e-6)]
    assert scatter.birge_ratio(fits) == pytest.approx(np.sqrt(9 / 2))


def test_runs_of_unequal_weight_by_hand():
    """Oracle: by hand; u of 1, 1 and 2 us, at 0, 2 and 4 us: mean 12 / 9 us, chi-square 16 / 9 + 4 / 9 + 16 / 9, two degrees."""
    fits = [_fit(np.full(4, d), 4 * u**2 * np.eye(4)) for d, u in ((0.0, 1e-6), (2e-6, 1e-6), (4e-6, 2e-6))]
    assert scatter.birge_ratio(fits) == pytest.approx(np.sqrt((16 + 4 + 16) / 9 / 2))


@pytest.mark.parametrize("names", [EDGE_DELAYS, LAGGING])
def test_birge_ratio_of_noise_alone_is_one(names):
    """Oracle: 600 draws of four runs, whose numbers hang together; the mean square of the ratio is 1."""
    random, n = np.random.default_rng(1), len(names)
    half = random.normal(size=(n, n)) + 2 * np.eye(n)
    root, covariance = 1e-6 * half, 1e-12 * half @ half.T
    ratios = [
        scatter.birge_ratio([_fit(5e-3 + root @ random.normal(size=n), covariance, names=names) for _ in range(4)])
        for _ in range(600)
    ]
    freedom = 3 * (1 if names == EDGE_DELAYS else 3)
    assert np.mean(np.square(ratios)) == pytest.approx(1, abs=4 * np.sqrt(2 / freedom / 600))


def test_no_finite_scatter_is_refused():
    """Oracle: a delay that is not a number."""
    fits = [_fit(np.full(4, d), np.eye(4)) for d in (np.nan, 0.0)]
    with pytest.raises(EstimationError, match="the delays of 2 recordings have no finite scatter"):
        scatter.birge_ratio(fits)


def test_edges_by_their_scatter_or_as_stated():
    """Oracle: by hand; angles -3, -1, 1, 3 units have the variance 20 / 3, and three degrees of freedom treble it."""
    omega = TURN * 3
    fits = [_fit(1e-3 + 1e-4 * np.array([-3, -1, 1, 3]) / omega + s, np.eye(4)) for s in (0.0, 5e-6)]
    seen = scatter.edge_uncertainty(fits, SimpleNamespace(u_edge_rad=None))
    assert seen == pytest.approx(1e-4 * np.sqrt(3 * 20 / 3))
    assert scatter.edge_uncertainty(fits, SimpleNamespace(u_edge_rad=2e-4)) == 2e-4


def test_edges_uncertainty_covers_a_mean_of_four_as_students_t_says():
    """Oracle: 4000 wheels with four edges each; errors of the mean over u / 2: three times the variance of t_3, which is 3."""
    random = np.random.default_rng(2)
    edges = random.normal(size=(4000, 4))
    u = np.array(
        [
            scatter.edge_uncertainty([_fit(row / (TURN * 3), np.eye(4))], SimpleNamespace(u_edge_rad=None))
            for row in edges
        ]
    )
    assert np.mean(np.abs(edges.mean(axis=1)) < 2 * u / 2) > 0.95
    assert np.sqrt(np.mean(u**2)) == pytest.approx(np.sqrt(3), rel=0.03)


def test_recordings_that_should_agree_have_speed_and_blackbody_in_common():
    """Oracle: by hand; 3.001 Hz counts as 3 Hz, 3.02 Hz does not; two blackbodies."""
    fits = [_fit(np.zeros(4), np.eye(4), hz=hz) for hz in (3.0, 8.0, 3.001, 3.0, 3.02)]
    found = [(one.speed_hz, list(one.members)) for one in scatter.alike(fits, [[0, 1, 2, 4], [3]])]
    assert found == [(3.0, [0, 2]), (3.0, [3]), (3.02, [4]), (8.0, [1])]


@pytest.mark.parametrize(("n", "apart_us", "factor"), [(3, 9.0, 1.0), (4, 9.0, 36.0), (4, 0.5, 1.0)])
def test_four_runs_tell_that_runs_scatter(n, apart_us, factor):
    """Oracle: by hand; at -d, d, -d, d: d^2 4 / 3 over 1 us^2 of the mean where it exceeds 1; three runs say too little."""
    d = 1e-6 * apart_us / np.sqrt(3)
    fits = [_fit(np.full(4, d * (-1) ** k), 4e-12 * np.eye(4)) for k in range(n)]
    found = scatter.run_to_run(fits, scatter.alike(fits, [range(n)]))
    assert found == pytest.approx(np.full(n, factor))


@pytest.mark.parametrize(("ratio", "is_told"), [(1.95, False), (2.05, True)])
def test_recordings_that_disagree_are_told(ratio, is_told):
    """Oracle: the limit of two standard deviations: 1 + 2 / sqrt(2) over three runs of a number with two degrees is 2."""
    d = np.array([-1.0, 0.0, 1.0]) * ratio * 1e-6
    fits = [_fit(np.full(4, one), 4e-12 * np.eye(4)) for one in d]
    assert scatter.birge_ratio(fits) == pytest.approx(ratio)
    found = scatter.birge_findings(fits, scatter.alike(fits, [range(3)]))
    assert [one.code for one in found] == ["recordings-disagree"] * is_told
    assert scatter.birge_findings(fits[:1], [scatter.Alike(speed_hz=3.0, members=[0])]) == []


def _recording(name, *, period_s=0.033):
    return SimpleNamespace(
        name=name, trigger_ticks=np.arange(100) * round(period_s * 1e6), track=SimpleNamespace(clock_frequency_hz=1e6)
    )


@pytest.mark.parametrize(("apart_s", "is_told"), [(0.016, False), (0.017, True), (-0.033, True)])
@pytest.mark.parametrize("hz", [3.0, 5.0])
def test_recordings_half_a_trigger_apart_are_of_other_triggers(apart_s, is_told, hz):
    """Oracle: by hand; triggers come every 33 ms, and half of that is 16.5 ms, at one wheel speed or at two."""
    fits = [_fit(np.full(4, 1e-3), np.eye(4)), _fit(np.full(4, 1e-3 + apart_s), np.eye(4), hz=hz)]
    found = scatter.of_triggers(fits, [_recording("first"), _recording("second")])
    assert [(one.code, one.severity) for one in found] == [("recordings-of-other-triggers", "doubt")] * is_told
    if is_told:
        longer, shorter = ("second", "first") if apart_s > 0 else ("first", "second")
        assert f"longer in {longer} than in {shorter}" in found[0].what
    assert scatter.of_triggers(fits[:1], [_recording("first")]) == ()


@pytest.mark.parametrize(
    ("triggers_ms", "is_told"), [((0.0, 33.0, 38.0), True), ((0.0, 33.0), False), ((0.0, 5.0), True), ((0.0,), False)]
)
def test_the_shortest_time_between_triggers_counts_where_there_are_two(triggers_ms, is_told):
    """Oracle: by hand; recordings are 3 ms apart, more than half of 5 ms and less than half of 33."""
    fits = [_fit(np.full(4, 1e-3), np.eye(4)), _fit(np.full(4, 4e-3), np.eye(4))]
    track = SimpleNamespace(clock_frequency_hz=1e6)
    ticks = (1e3 * np.array(triggers_ms)).astype(np.int64)
    one = SimpleNamespace(name="run", trigger_ticks=ticks, track=track)
    found = scatter.of_triggers(fits, [one, one])
    assert len(found) == is_told
    assert all("triggers come every 5.000 ms" in finding.what for finding in found)


@pytest.mark.parametrize(("n", "severity"), [(2, "doubt"), (3, "doubt"), (4, "warning")])
def test_few_recordings_that_disagree_beyond_chance_are_a_doubt(n, severity):
    """Oracle: by hand; ten standard uncertainties are no chance, and from four runs on the uncertainty is widened by as much."""
    fits = [_fit(np.full(4, 1e-5 * (-1) ** k), 4e-12 * np.eye(4)) for k in range(n)]
    (found,) = scatter.birge_findings(fits, scatter.alike(fits, [range(n)]))
    assert found.severity == severity
