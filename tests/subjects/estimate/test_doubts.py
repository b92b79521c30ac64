"""From where on a result is doubted, and in which words: every bound by hand, from both of its sides."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import doubts
from irtiming.physics.light.row_sum import BLADE
from irtiming.records.estimate import Estimate
from irtiming.records.finding import Finding
from irtiming.records.result import EffectiveTimeConstants


def _estimate(values, u):
    return Estimate(
        names=tuple(values), units=("s",) * len(values), values=np.array(list(values.values()), float),
        covariance=np.diag(np.square(u)),
    )  # fmt: skip


def _codes(found):
    return [(one.code, one.severity) for one in found]


@pytest.mark.parametrize(("u_rad", "is_said"), [(5.0e-3, False), (5.1e-3, True)])
def test_edges_that_disagree_by_more_than_five_milliradians(u_rad, is_said):
    """Oracle: the bound, which itself is no warning."""
    found = doubts.of_edges(u_rad)
    assert _codes(found) == [("edges-disagree", "warning")] * is_said
    assert all("disagree by 5.1 mrad" in one.what for one in found)


@pytest.mark.parametrize(
    ("delay_s", "codes"),
    [
        (0.0, []), (-1e-6, [("delay-negative", "warning")]), (-3.9e-5, [("delay-negative", "warning")]),
        (-4.1e-5, [("delay-negative", "doubt")]),
    ],
)  # fmt: skip
def test_a_window_before_its_trigger(delay_s, codes):
    """Oracle: by hand; u is 10 us, of which four are no chance. The first number counts."""
    found = doubts.of_window(_estimate({"trigger_delay": delay_s, "integration_time": 1e-4}, (1e-5, 1e-7)))
    assert _codes(found) == codes
    assert all(f"({1e3 * delay_s:.3f} ms)" in one.what for one in found)


@pytest.mark.parametrize("delay_s", [0.0, 1e-3])
def test_a_row_that_is_read_with_its_trigger_or_after_it(delay_s):
    """Oracle: by hand; none is early, and what says nothing of a trigger is not asked."""
    assert doubts.of_reading(_estimate({"trigger_delay": delay_s}, (1e-6,)), n_rows=80) == ()
    assert doubts.of_reading(_estimate({"readout_delay": -delay_s}, (1e-6,)), n_rows=80) == ()


def test_a_camera_without_a_row_delay_reads_all_rows_at_once():
    """Oracle: by hand; 3 u early is a warning, of row 0."""
    (found,) = doubts.of_reading(_estimate({"trigger_delay": -3e-6}, (1e-6,)), n_rows=80)
    assert (found.code, found.severity) == ("rows-read-before-trigger", "warning")
    assert "row 0 at -0.003 ms (u = 0.001 ms)" in found.what


def test_a_camera_that_runs_free_may_expose_before_its_strobe():
    """Oracle: by hand; what is said of triggers goes, the rest stays."""
    findings = [
        Finding(code=code, severity="doubt", what="w", cure="c")
        for code in ("rows-read-before-trigger", "other", "delay-negative")
    ]
    assert doubts.of_events(findings, [SimpleNamespace(events=None)]) == tuple(findings)
    assert doubts.of_events(findings, [SimpleNamespace(events="strobe")]) == (findings[1],)


def _angles(found_mrad):
    names = [f"edge_angle_{k}" for k in range(4)]
    prior = _estimate({"delay": 0.0} | dict.fromkeys(names, 0.0), (1.0, *[1e-3] * 4))
    parameters = _estimate({"delay": 5.0} | dict(zip(names, 1e-3 * np.array(found_mrad), strict=True)), (1.0,) * 5)
    return SimpleNamespace(prior=prior, parameters=parameters)


@pytest.mark.parametrize(
    ("found_mrad", "is_said"),
    [((1.9,) * 4, False), ((2.1,) * 4, True), ((-2.1,) * 4, True), ((9.0, -9.0, 9.0, -9.0), False)],
)
def test_edges_that_come_early_by_more_than_rig_toml_allows(found_mrad, is_said):
    """Oracle: by hand; of four edges of 1 mrad each, which err apart, the mean has 0.5 mrad: four of these are 2."""
    found = doubts.of_angles(_angles(found_mrad))
    assert _codes(found) == [("speeds-contradict-rig", "doubt")] * is_said
    assert all(f"{found_mrad[0]:+.2f} mrad early, rig.toml allows u = 0.50 mrad" in one.what for one in found)


@pytest.mark.parametrize(("start", "is_said"), [(1e-3, True), (1.1e-3, False)])
def test_a_fit_that_stayed_where_it_began(start, is_said):
    """Oracle: by hand; to the last digit."""
    joint = SimpleNamespace(parameters=_estimate({"delay": 1e-3}, (1e-6,)), start={"delay": start})
    assert _codes(doubts.of_start(joint)) == [("start-not-left", "warning")] * is_said


def _pixel_fit(*, inflation=1.0, n_dropped=0, levels=None, blades=0.0, u_blades=1e-4):
    return SimpleNamespace(
        name="run", variance_inflation=inflation, n_dropped=n_dropped, levels=levels, blades=blades, u_blades=u_blades
    )


def test_frames_that_were_left_out_are_counted():
    """Oracle: by hand; a recording without any says nothing."""
    (found,) = doubts.of_pixel_fits([_pixel_fit(), _pixel_fit(n_dropped=3)])
    assert (found.code, found.severity, found.recording) == ("frames-wild", "warning", "run")
    assert found.what.startswith("3 frames left out")


def test_correlated_residuals_of_pixel_sums_are_said_with_the_largest_widening():
    """Oracle: by hand; from a variance of twice what is white on: 2 is none, of 9 and 4 the uncertainty was tripled."""
    assert doubts.of_pixel_fits([_pixel_fit(inflation=2.0)]) == ()
    (found,) = doubts.of_pixel_fits([_pixel_fit(inflation=9.0), _pixel_fit(), _pixel_fit(inflation=4.0)])
    assert (found.code, found.severity) == ("residuals-correlated", "warning")
    assert found.what.startswith("residuals of 2 of 3 recordings")
    assert found.cure == "their uncertainty was widened by up to 3.0"


def _levels(*, jumps=(), sway=0.0):
    return SimpleNamespace(jumps=jumps, sway=sway, n_numbers=7)


@pytest.mark.parametrize(
    ("levels", "codes"),
    [
        (None, []), (_levels(sway=0.0049), []), (_levels(sway=0.0051), ["levels-sway"]),
        (_levels(jumps=(30, 70)), ["levels-jump"]), (_levels(jumps=(30,), sway=0.1), ["levels-jump"]),
    ],
)  # fmt: skip
def test_levels_that_jump_or_sway(levels, codes):
    """Oracle: by hand; from half a per cent of the contrast on, and jumps before all."""
    found = doubts.of_levels([_pixel_fit(levels=levels)])
    assert [one.code for one in found] == codes
    assert all(one.severity == "info" and one.recording == "run" for one in found)
    if codes == ["levels-sway"]:
        assert "by 0.5% of the contrast; 7 numbers" in found[0].what


@pytest.mark.parametrize(
    ("blades", "u", "is_said"),
    [(0.0019, 1e-4, False), (0.0021, 1e-4, True), (-0.0021, 1e-4, True), (0.0039, 1e-3, False), (0.0041, 1e-3, True)],
)
def test_blades_that_differ_beyond_doubt(blades, u, is_said):
    """Oracle: by hand; by more than two thousandths of the contrast, and more than four of its uncertainties."""
    assert _codes(doubts.of_levels([_pixel_fit(blades=blades, u_blades=u)])) == [("blades-differ", "info")] * is_said
    rows = SimpleNamespace(name="run", variance_inflation=1.0, estimate=_estimate({BLADE: blades}, (u,)))
    assert _codes(doubts.of_row_fits([rows])) == [("blades-differ", "info")] * is_said


def test_correlated_residuals_of_rows_are_said_later_than_those_of_sums():
    """Oracle: by hand; from a variance of four times what is white on. A fit without blades has nothing to say of them."""
    fits = [
        SimpleNamespace(name="run", variance_inflation=inflation, estimate=_estimate({"delay": 0.0}, (1.0,)))
        for inflation in (4.0, 16.0, 6.25)
    ]
    assert doubts.of_row_fits(fits[:1]) == ()
    (found,) = doubts.of_row_fits(fits)
    assert found.code == "row-residuals-correlated"
    assert found.what.startswith("residuals of 2 of 3 recordings")
    assert found.cure == "their uncertainty was widened by up to 4.0"


def _effective(tau_ms, u_ms):
    return EffectiveTimeConstants(
        blackbody_temperature_k=np.array([300.0, 340.0, 380.0])[: len(tau_ms)], time_constant_s=1e-3 * np.array(tau_ms),
        covariance_s2=np.diag(np.square(1e-3 * np.array(u_ms))), contrast_dn=np.ones(len(tau_ms)),
    )  # fmt: skip


@pytest.mark.parametrize(("apart", "is_said"), [(2.9, False), (3.0, True)])
def test_time_constants_that_differ_with_the_blackbody(apart, is_said):
    """Oracle: the normal distribution; two that differ by 2.97 of their difference's uncertainties do so in 3 of 1000 cases."""
    found = doubts.of_mixture(_effective([10.0, 10.0 + apart * 0.05], [0.03, 0.04]))
    assert _codes(found) == [("lag-depends-on-blackbody", "warning")] * is_said
    assert all("from 10.0000 ms at 300.0 K to 10.1500 ms at 340.0 K" in one.what for one in found)


def test_of_three_the_weighted_mean_counts():
    """Oracle: by hand; 10.0 and 10.2 of u 0.1 about 10.1 are 2 squares, 9 of u 2 is 0.3: that is chance with two to spare."""
    assert doubts.of_mixture(_effective([10.0, 10.2, 9.0], [0.1, 0.1, 2.0])) == ()
    assert doubts.of_mixture(_effective([10.0], [0.1])) == doubts.of_mixture(None) == ()
    (found,) = doubts.of_mixture(_effective([10.0, 10.5, 9.0], [0.1, 0.1, 2.0]))
    assert found.what.startswith("the time constant changes with the blackbody, from 10.0000 ms")
