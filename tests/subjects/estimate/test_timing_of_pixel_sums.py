"""The generalised mean over edges, recordings and speeds against formulas written out element by element."""

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from geometry_by_hand import geometry_by_hand

from irtiming.estimate import joint, shared_numbers, timing
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit, Estimate
from irtiming.records.finding import Finding

TURN = 2 * np.pi
OMEGA = TURN * 3


KNOWN = Finding(code="known", severity="warning", what="told by the geometry")


def _with_opening(delays_s2):
    """Covariance of four delays and an opening angle that has no part in them."""
    whole = np.zeros((5, 5))
    whole[:4, :4], whole[4, 4] = delays_s2, 1e-8
    return whole


@pytest.fixture
def fits():
    """Edge delays with white noise; residuals of the recordings add up to zero, so that they share nothing."""

    def make(delays, *, omegas=None, nominal=None, u_s=1e-6, correlation=0.2):
        n = len(delays)
        part = np.resize([1.0, -1.0], n)
        if n % 2 and n > 1:
            part[-3:] = 1, 1, -2
        base = np.random.default_rng(0).normal(0, 1e-3, 600)
        made = []
        for k, delay in enumerate(delays):
            correlations = np.full((4, 4), correlation) + (1 - correlation) * np.eye(4)
            made.append(
                EdgeDelayFit(
                    name=f"run {k}",
                    trigger_delay_time_set_s=0.0 if nominal is None else nominal[k],
                    angular_frequency_rad_per_s=OMEGA if omegas is None else omegas[k],
                    estimate=Estimate(
                        names=(*EDGE_DELAYS, "opening_angle"),
                        units=("s",) * 4 + ("rad",),
                        values=np.append(np.broadcast_to(np.asarray(delay, float), 4), 1.3),
                        covariance=_with_opening((u_s * (1 + 0.3 * k)) ** 2 * correlations),
                    ),
                    edge_delay_s=np.broadcast_to(np.asarray(delay, float), 4).copy(),
                    start_delay_s=0.0,
                    wheel_angle_rad=TURN * (np.arange(600) + 0.5) / 600,
                    fraction=np.zeros(600),
                    residual=base * part[k],
                    degrees_of_freedom=588,
                    step=1.0,
                    noise=1e-3,
                    variance_inflation=1.0,
                    n_dropped=0,
                    kept=np.ones(600, bool),
                )
            )
        return made

    return make


@pytest.fixture
def geometry():
    """What is known of the angles: two common errors and, where told, that of a single edge."""
    return partial(geometry_by_hand, edges_from="ideal", findings=(KNOWN,))


def _combined(fits, geometry, *, integration_time_s, u_window_s=None):
    """The result of recordings of four edge delays alone, d_i = t + a_i / omega, to the middle of the window."""
    half_s = (integration_time_s or 0.0) / 2
    later = np.array([half_s] * 4 + [0.0])
    middles = [replace(fit.estimate, values=fit.estimate.values + later) for fit in fits]
    fits = [replace(fit, estimate=middle) for fit, middle in zip(fits, middles, strict=True)]
    own = [shared_numbers.same("opening_angle", fits, unit="rad", start=1.3)]
    if u_window_s is not None:
        own.append(shared_numbers.same("integration_time", fits, start=2 * half_s, u=u_window_s))
    return timing.of_pixel_fits(
        fits, geometry, models=[joint.parabola(middle) for middle in middles], own=own, stated_s=integration_time_s
    ).result


def _texts(result):
    return [one.sentence() for one in result.findings]


def _covariance(fits, geometry):
    """Covariance of all edge delays, written out: frame noise, edge by edge, and angles common to all."""
    n = 4 * len(fits)
    total = np.zeros((n, n))
    for a in range(n):
        for b in range(n):
            f, g = fits[a // 4], fits[b // 4]
            per_rad2 = 1 / (f.angular_frequency_rad_per_s * g.angular_frequency_rad_per_s)
            if a // 4 == b // 4:
                total[a, b] += f.estimate.covariance[a % 4, b % 4]
            if a % 4 == b % 4:
                total[a, b] += geometry.u_edge_rad**2 * per_rad2
            total[a, b] += sum(u**2 for _, _, u in geometry.angle_budget) * per_rad2
    return total


@pytest.mark.parametrize("omegas", [(OMEGA,), (OMEGA, OMEGA, OMEGA), (OMEGA, 2 * OMEGA), (OMEGA, 2 * OMEGA, 3 * OMEGA)])
def test_generalised_mean_is_that_of_the_textbook(fits, geometry, omegas):
    """Oracle: x = (1' C^-1 y) / (1' C^-1 1), u^2 = 1 / (1' C^-1 1) with C written out element by element."""
    rng = np.random.default_rng(len(omegas))
    made = fits([4e-4 + rng.normal(0, 3e-6, 4) for _ in omegas], omegas=omegas)
    rig = geometry()
    result = _combined(made, rig, integration_time_s=250e-6)
    inverse = np.linalg.inv(_covariance(made, rig))
    y = np.concatenate([fit.edge_delay_s for fit in made])
    assert result.estimate.names == (
        "trigger_delay", "exposure_midpoint_delay", "trigger_delay_falling", "trigger_delay_rising",
    )  # fmt: skip
    values, u = result.estimate.values, result.estimate.standard_uncertainties
    assert values[0] == pytest.approx((inverse @ y).sum() / inverse.sum(), rel=1e-9)
    assert u[0] == pytest.approx(inverse.sum() ** -0.5, rel=1e-7)
    for k, edges in ((2, (0, 2)), (3, (1, 3))):
        used = [a for a in range(y.size) if a % 4 in edges]
        part = np.linalg.inv(_covariance(made, rig)[np.ix_(used, used)])
        assert values[k] == pytest.approx((part @ y[used]).sum() / part.sum(), rel=1e-9)
        assert u[k] == pytest.approx(part.sum() ** -0.5, rel=1e-7)
    assert values[1] - values[0] == pytest.approx(125e-6, abs=1e-15)
    assert u[1] == pytest.approx(u[0])
    assert result.estimate.correlation[0, 1] == pytest.approx(1)
    assert np.all(np.linalg.eigvalsh(result.estimate.covariance) > -1e-12 * u[0] ** 2)


def test_one_speed_cannot_beat_its_angle_error(fits, geometry):
    """Oracle: by hand; ten recordings shrink the noise, the angles' 0.54 mrad stay: 29 us at 3 Hz."""
    result = _combined(fits([4e-4] * 10), geometry(u_edge=0.0), integration_time_s=None)
    expected = np.hypot(5e-4, 2e-4) / OMEGA
    assert result.estimate.standard_uncertainties[0] == pytest.approx(expected, rel=1e-3)


def test_two_speeds_remove_a_common_angle_error(fits, geometry):
    """Oracle: closed form; t = (w1 y1 - w2 y2) / (w1 - w2) for y = t + e / w, whatever e, with its propagated noise."""
    true, omegas = 3.7e-4, (OMEGA, 2.5 * OMEGA)
    made = fits([true + 4e-3 / w for w in omegas], omegas=omegas, correlation=0.0)
    result = _combined(made, geometry(common=(0.1,)), integration_time_s=0.0)
    assert result.estimate.values[0] == pytest.approx(true, abs=1e-9)
    u1, u2 = 1e-6 / 2, 1.3e-6 / 2
    expected = np.hypot(omegas[0] * u1, omegas[1] * u2) / (omegas[1] - omegas[0])
    assert result.estimate.standard_uncertainties[0] == pytest.approx(expected, rel=1e-3)


def test_two_speeds_remove_the_errors_of_single_edges(fits, geometry):
    """Oracle: closed form as above, edge by edge."""
    true, omegas, errors = 3.7e-4, (OMEGA, 2 * OMEGA), np.array([1e-3, -2e-3, 3e-3, 0.0])
    made = fits([true + errors / w for w in omegas], omegas=omegas, correlation=0.0)
    result = _combined(made, geometry(common=(0.1,), u_edge=0.1), integration_time_s=0.0)
    np.testing.assert_allclose(result.estimate.values, true, atol=2e-9)


def test_unknown_integration_time_reports_the_middle_only(fits, geometry):
    """Oracle: the docstring; the fits gave the middle, no start can be told."""
    result = _combined(fits([4e-4]), geometry(), integration_time_s=None)
    assert result.estimate.names == ("exposure_midpoint_delay",)
    assert result.estimate.values.tolist() == pytest.approx([4e-4])


def test_a_window_that_was_held_is_not_reported(fits, geometry):
    """Oracle: a number that the fit did not move says nothing; at two speeds a window found to 10 us is told."""
    made = fits([4e-4] * 2, omegas=(OMEGA, 3 * OMEGA))
    told, held = (
        _combined(made, geometry(), integration_time_s=250e-6, u_window_s=u).estimate.names for u in (10e-6, None)
    )
    assert told == (*held, "integration_time")


def test_budget_adds_in_quadrature(fits, geometry):
    """Oracle: the law of propagation; independent contributions add in quadrature to the stated uncertainty."""
    made = fits([4e-4, 4.1e-4, 4e-4], omegas=(OMEGA, OMEGA, 2 * OMEGA))
    result = _combined(made, geometry(), integration_time_s=250e-6)
    parts = [c.standard_uncertainty["trigger_delay"] for c in result.budget]
    assert np.sqrt(np.sum(np.square(parts))) == pytest.approx(result.estimate.standard_uncertainties[0])
    sources = [c.source for c in result.budget]
    assert len(set(sources)) == len(sources)
    assert {"noise of the frames", "cutout edges", "angle 0", "angle 1"} <= set(sources)


def test_edges_without_statement_are_judged_by_their_scatter(fits, geometry):
    """Oracle: by hand; standard deviation of the four edges times sqrt(3), over sqrt(4) for their mean."""
    edges = np.array([1e-5, -1e-5, 2e-5, -2e-5])
    result = _combined(fits([4e-4 + edges], u_s=1e-9), geometry(common=(), u_edge=None), integration_time_s=0.0)
    expected = np.sqrt(3) * np.std(edges, ddof=1) / 2
    assert result.estimate.standard_uncertainties[0] == pytest.approx(expected, rel=1e-3)
    assert {c.kind for c in result.budget} == {"A"}


def test_relative_delay_of_a_single_reference_is_zero(fits, geometry):
    """Oracle: by hand; 25 ms set, 24.9985 ms found; the angles cancel, the noise of both recordings stays."""
    made = fits([4e-4, 4e-4 - 1.5e-6], nominal=[0.0, 0.025], correlation=0.0)
    relative = _combined(made, geometry(), integration_time_s=250e-6).relative_delays
    assert [r.file for r in relative] == ["run 0", "run 1"]
    assert (relative[0].value_s, relative[0].standard_uncertainty_s, relative[0].nominal_s) == (0, 0, 0)
    assert relative[1].nominal_s == 0.025
    assert relative[1].value_s == pytest.approx(0.025 - 1.5e-6, abs=1e-15)
    assert relative[1].standard_uncertainty_s == pytest.approx(np.hypot(1e-6, 1.3e-6) / 2, rel=1e-6)


def test_several_references_are_averaged(fits, geometry):
    """Oracle: by hand; three references r, one other d: d - mean(r); a reference keeps its own deviation.

    Four recordings that scatter more than their noise widen it by their Birge ratio.
    """
    delays, nominal = [4.00e-4, 4.03e-4, 3.97e-4, 4.10e-4], [0.01, 0.01, 0.01, 0.06]
    made = fits(delays, nominal=nominal, correlation=0.0)
    relative = _combined(made, geometry(), integration_time_s=250e-6).relative_delays
    assert [r.value_s for r in relative] == pytest.approx([0, 3e-6, -3e-6, 0.05 + 1e-5], abs=1e-15)
    u = 0.5e-6 * (1 + 0.3 * np.arange(4))
    mean = np.sum(np.array(delays) / u**2) / np.sum(1 / u**2)
    u *= np.sqrt(np.sum(((np.array(delays) - mean) / u) ** 2) / 3)
    assert relative[3].standard_uncertainty_s == pytest.approx(np.sqrt(u[3] ** 2 + np.sum(u[:3] ** 2) / 9), rel=1e-6)
    expected = np.sqrt((2 / 3 * u[0]) ** 2 + (u[1] ** 2 + u[2] ** 2) / 9)
    assert relative[0].standard_uncertainty_s == pytest.approx(expected, rel=1e-6)
    assert [r.nominal_s for r in relative] == pytest.approx([0, 0, 0, 0.05])


def test_relative_delay_between_speeds_holds_the_angle_error(fits, geometry):
    """Oracle: by hand; an angle e is e (1/w2 - 1/w1) of relative delay between two speeds."""
    made = fits([4e-4, 4e-4], omegas=(OMEGA, 2 * OMEGA), nominal=[0.0, 0.025], u_s=1e-9)
    relative = _combined(made, geometry(common=(5e-4,), u_edge=0.0), integration_time_s=0.0)
    assert relative.relative_delays[1].standard_uncertainty_s == pytest.approx(5e-4 / (2 * OMEGA), rel=1e-3)


def test_few_frames_split_without_complaint(fits, geometry):
    """Oracle: none of the 200 bins of the angle needs a frame; 120 frames in a recording are allowed."""
    few = [
        replace(fit, wheel_angle_rad=fit.wheel_angle_rad[::5], residual=fit.residual[::5]) for fit in fits([4e-4, 4e-4])
    ]
    result = _combined(few, geometry(), integration_time_s=250e-6)
    assert np.all(np.isfinite(result.estimate.covariance))


def test_recordings_that_disagree_are_told(fits, geometry):
    """Oracle: by hand; two delays 100 times their noise apart have a Birge ratio of about 70, three that agree none."""
    apart = _combined(fits([4e-4, 4.5e-4]), geometry(), integration_time_s=250e-6)
    assert any("Birge ratio" in text and "at 3 Hz" in text for text in _texts(apart))
    agreed = _combined(fits([4e-4, 4.002e-4, 3.999e-4]), geometry(), integration_time_s=250e-6)
    assert [one.code for one in agreed.findings] == ["known", "integration-time-on-trust"]


def test_outliers_and_correlation_are_told(fits, geometry):
    """Oracle: the numbers that the fits hold."""
    fit = replace(fits([4e-4])[0], n_dropped=7, variance_inflation=9.0)
    texts = _texts(_combined([fit], geometry(), integration_time_s=250e-6))
    assert "run 0: 7 frames left out: outlying, or at the ends of the recording" in texts
    one = _texts(_combined([replace(fit, n_dropped=1)], geometry(), integration_time_s=250e-6))
    assert "run 0: 1 frame left out: outlying, or at the ends of the recording" in one
    assert any("widened by up to 3.0" in text for text in texts)


def test_impossible_results_are_doubted(fits, geometry):
    """Oracle: by hand; a window before its trigger, and edges that scatter by 0.3 ms, 5.6 mrad at 3 Hz."""
    early = _combined(fits([-4e-4]), geometry(), integration_time_s=250e-6)
    assert any("the trigger delay is negative (-0.400 ms)" in text for text in _texts(early))
    rough = _combined(fits([4e-4 + 3e-4 * np.array([1, -1, 1, -1])]), geometry(u_edge=None), integration_time_s=250e-6)
    assert any("the four wheel edges disagree by" in text for text in _texts(rough))


def test_more_recordings_never_hurt(fits, geometry):
    """Oracle: a generalised mean's uncertainty falls with every datum."""
    u = [
        _combined(fits([4e-4] * n, omegas=[OMEGA * (1 + k % 3) for k in range(n)]), geometry(),
                               integration_time_s=0.0).estimate.standard_uncertainties[0]
        for n in (1, 2, 4, 6)
    ]  # fmt: skip
    assert all(a > b for a, b in pairwise(u))
