"""Delay, lag and row delay from several fits against generalised least squares written out element by element."""

import re
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from geometry_by_hand import geometry_by_hand

from irtiming.estimate import doubts, shared_numbers, timing
from irtiming.estimate.rig_errors import RigErrors
from irtiming.estimate.row_light import SHAPE_NUMBERS
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import BLADES, timing_names
from irtiming.physics.response import integration_window
from irtiming.records.estimate import Estimate
from irtiming.records.finding import Finding
from irtiming.records.rig import Measured, WindowTail
from irtiming.records.row_timing import RowTimingFit

TURN = 2 * np.pi
OMEGA = TURN * 3
SIX_NAMES = tuple(
    name for name in timing_names(camera("microbolometer", "rolling")) if name not in ("recursive_filter", *BLADES)
)
NAMES = ("trigger_delay", "time_constant", "row_delay")
KNOWN = Finding(code="known", severity="warning", what="told by the geometry")
SIX = np.array([2.3e-3] * 4 + [6e-3, 60e-6])
IS_EDGE = np.array([1.0, 1, 1, 1, 0, 0])
U = np.array([5e-6] * 4 + [4e-6, 1e-7])


@pytest.fixture
def fits():
    """Fits with the given six numbers: delays and tau correlated, a sector that moves all of them."""

    def make(sixes, *, omegas=None, nominal=None, u=U, effect=1.0, variance_inflation=1.0):
        correlation = np.full((6, 6), 0.75) + 0.25 * np.eye(6)
        correlation[:4, 4] = correlation[4, :4] = -0.8
        correlation[5, :5] = correlation[:5, 5] = 0.1
        made = []
        for k, six in enumerate(sixes):
            size = u * (1 + 0.2 * k)
            drawn = np.random.default_rng(k).normal(size=(6, len(SHAPE_NUMBERS)))
            made.append(
                RowTimingFit(
                    name=f"run {k}",
                    trigger_delay_time_set_s=0.0 if nominal is None else nominal[k],
                    angular_frequency_rad_per_s=OMEGA if omegas is None else omegas[k],
                    estimate=Estimate(
                        names=SIX_NAMES,
                        units=("s",) * 6,
                        values=np.array(six, float),
                        covariance=correlation * np.outer(size, size),
                    ),
                    held={},
                    step_rad=0.622,
                    undone=0.0,
                    blades_apart=False,
                    kept=np.ones(4, bool),
                    start={},
                    shape_effect=effect * drawn * np.array([2e-4] * 4 + [1e-4, 1e-6])[:, None],
                    n_steps=5,
                    row_px=np.arange(3),
                    wheel_angle_rad=np.zeros(4),
                    fraction=np.zeros((4, 3)),
                    model=np.zeros((4, 3)),
                    residual=np.zeros((4, 3)),
                    noise=np.ones(3),
                    harmonics=np.zeros((3, 2), complex),
                    gain_dn=np.ones(3),
                    contrast_dn=np.ones(1),
                    variance_inflation=variance_inflation,
                )
            )
        return made

    return make


@pytest.fixture
def geometry():
    """What is known of the angles: two common errors and, where told, that of a single edge."""
    return partial(geometry_by_hand, findings=(KNOWN,))


@pytest.fixture
def sector(sector_of, brute_bolometer):
    """The opening in the image; its row delay agrees."""
    return sector_of(brute_bolometer())


def _estimate(fits, geometry, sector, **options):
    return timing.of_row_fits(fits, geometry, sectors=[sector] * len(fits), **({"n_rows": 36} | options)).result


def _texts(result):
    return [one.sentence() for one in result.findings]


def _covariance(fits, geometry, sector):
    """Covariance of all numbers, written out: noise of each fit, edges, common angles, the sector in the image."""
    n = 6 * len(fits)
    total = np.zeros((n, n))
    for a in range(n):
        for b in range(n):
            f, g, i, j = fits[a // 6], fits[b // 6], a % 6, b % 6
            if a // 6 == b // 6:
                total[a, b] += f.estimate.covariance[i, j]
            per_rad2 = IS_EDGE[i] * IS_EDGE[j] / (f.angular_frequency_rad_per_s * g.angular_frequency_rad_per_s)
            total[a, b] += sum(u**2 for _, _, u in geometry.angle_budget) * per_rad2
            if i == j:
                total[a, b] += geometry.u_edge_rad**2 * per_rad2
            total[a, b] += f.shape_effect[i] @ sector.covariance @ g.shape_effect[j]
    return total


def _textbook(y, covariance, design):
    """Solution (X' C^-1 X)^-1 X' C^-1 y, and its covariance."""
    inverse = np.linalg.inv(covariance)
    found = np.linalg.inv(design.T @ inverse @ design)
    return found @ design.T @ inverse @ y, found


DESIGN = np.array([[1, 0, 0]] * 4 + [[0, 1, 0], [0, 0, 1]], float)
SPEEDS = [(OMEGA,), (OMEGA, OMEGA, OMEGA), (OMEGA, 2 * OMEGA), (OMEGA, 2 * OMEGA, 3.5 * OMEGA)]


@pytest.mark.parametrize("omegas", SPEEDS)
def test_estimate_is_that_of_the_textbook(fits, geometry, sector, omegas):
    """Oracle: generalised least squares with the covariance written out element by element."""
    rng = np.random.default_rng(len(omegas))
    noise = fits([SIX])[0].estimate.covariance
    made, rig = fits([rng.multivariate_normal(SIX, noise) for _ in omegas], omegas=omegas), geometry()
    result = _estimate(made, rig, sector)
    y = np.concatenate([fit.estimate.values for fit in made])
    values, covariance = _textbook(y, _covariance(made, rig, sector), np.tile(DESIGN, (len(made), 1)))
    assert result.method == "row-sum"
    assert result.estimate.names == NAMES
    np.testing.assert_allclose(result.estimate.values, values, rtol=1e-6)
    np.testing.assert_allclose(result.estimate.covariance, covariance, rtol=1e-5)
    assert result.bounds == ()
    assert result.findings == (KNOWN,)
    np.testing.assert_allclose(result.edge_delay_s, np.mean([fit.edge_delay_s for fit in made], axis=0))
    noise = [np.diag(fit.estimate.covariance)[:4] for fit in made]
    np.testing.assert_allclose(result.u_edge_delay_s, np.sqrt(np.sum(noise, axis=0)) / len(made))


@pytest.mark.parametrize("omegas", SPEEDS)
def test_budget_adds_up(fits, geometry, sector, omegas):
    """Oracle: the squares of the lines add up to the squares of the three uncertainties, line by line non-negative."""
    result = _estimate(fits([SIX] * len(omegas), omegas=omegas), geometry(), sector)
    for name, u in zip(NAMES, result.estimate.standard_uncertainties, strict=True):
        lines = [line.standard_uncertainty[name] for line in result.budget]
        assert np.sqrt(np.sum(np.square(lines))) == pytest.approx(u, rel=1e-9)
    sources = [(line.source, line.kind) for line in result.budget]
    assert sources == [
        ("noise of the frames", "A"), ("axle, mask and blur in the image", "A"), ("tilt of the camera, and its lens", "A"),
        ("cutout edges", "B"), ("angle 0", "B"), ("angle 1", "B"),
    ]  # fmt: skip


def test_one_speed_cannot_beat_its_angle_error(fits, geometry, sector):
    """Oracle: by hand; 5e-4 rad are 26.5 us at 3 Hz however many recordings there are."""
    rig = geometry(common=(5e-4,), u_edge=1e-6)
    u = [_estimate(fits([SIX] * n, effect=0.0), rig, sector).estimate.standard_uncertainties for n in (1, 12)]
    assert u[1][0] == pytest.approx(5e-4 / OMEGA, rel=0.02)
    assert u[0][0] > u[1][0]
    assert u[1][1] < u[0][1] / 2  # the time constant knows no angle


def test_two_speeds_tell_an_angle_error_from_a_delay(fits, geometry, sector):
    """Oracle: by hand; d_f = t + e / omega_f has t = (omega_2 d_2 - omega_1 d_1) / (omega_2 - omega_1)."""
    e, rig = 8e-4, geometry(common=(5e-3,), u_edge=1e-7)
    omegas = (OMEGA, 3 * OMEGA)
    exact = U / 100
    result = _estimate(
        fits([SIX + IS_EDGE * e / omega for omega in omegas], omegas=omegas, u=exact, effect=0), rig, sector
    )
    assert result.estimate.values[0] == pytest.approx(SIX[0], abs=1e-8)
    assert result.estimate.standard_uncertainties[0] < 1e-6
    alone = _estimate(fits([SIX + IS_EDGE * e / OMEGA], u=exact, effect=0), rig, sector)
    assert alone.estimate.values[0] == pytest.approx(SIX[0] + e / OMEGA, abs=1e-8)
    assert alone.estimate.standard_uncertainties[0] == pytest.approx(5e-3 / OMEGA, rel=1e-3)


def _each_delay(y, fits, rig, sector, setting):
    """Delay of each recording, written out: all else from one delay per setting, then its own edges with all else held."""
    n_set = max(setting) + 1
    root = np.linalg.cholesky(sector.covariance)
    parts = []
    for k, fit in enumerate(fits):
        angles = np.outer(IS_EDGE, [u for _, _, u in rig.angle_budget]) / fit.angular_frequency_rad_per_s
        edges = rig.u_edge_rad * np.eye(6)[:, :4] / fit.angular_frequency_rad_per_s
        delays = np.outer(IS_EDGE, np.eye(n_set)[setting[k]])
        parts.append(np.hstack([delays, np.eye(6)[:, 4:], angles, edges, fit.shape_effect @ root]))
    weights = [np.linalg.inv(fit.estimate.covariance) for fit in fits]
    known = np.diag([0.0] * (n_set + 2) + [1.0] * (parts[0].shape[1] - n_set - 2))
    normal = known + sum(a.T @ w @ a for a, w in zip(parts, weights, strict=True))
    best = np.linalg.solve(
        normal, sum(a.T @ w @ y[6 * k : 6 * k + 6] for k, (a, w) in enumerate(zip(parts, weights, strict=True)))
    )
    best[:n_set] = 0
    own = [y[6 * k : 6 * k + 6] - a @ best for k, a in enumerate(parts)]
    return np.array([IS_EDGE @ w @ left / (IS_EDGE @ w @ IS_EDGE) for w, left in zip(weights, own, strict=True)])


@pytest.mark.parametrize(("early_rad", "is_doubted"), [(1e-3, False), (20e-3, True)])
def test_speeds_that_contradict_the_angles_are_a_doubt(fits, geometry, sector, early_rad, is_doubted):
    """Oracle: by hand; edges that come early by an angle, which rig.toml knows to 0.5 mrad, and two speeds that tell it."""
    omegas = np.array([OMEGA, 3 * OMEGA])
    sixes = [SIX + early_rad / omega * IS_EDGE for omega in omegas]
    found = _estimate(fits(sixes, omegas=omegas, u=U / 20, effect=0.0), geometry(), sector).findings
    assert ("speeds-contradict-rig" in [one.code for one in found]) == is_doubted


def test_relative_delays_are_those_of_the_textbook(fits, geometry, sector):
    """Oracle: the two steps written out with each error a parameter; their uncertainty by the law of propagation, y by y."""
    nominal = [0.0, 0.0, 0.025, 0.05]
    rng = np.random.default_rng(9)
    base, rig = fits([SIX])[0].estimate.covariance, geometry()
    drawn = rng.multivariate_normal(np.zeros(6), base / 4, 4)  # little enough for no Birge ratio above 1
    made = [replace(fit, estimate=replace(fit.estimate, covariance=base)) for fit in fits(SIX + drawn, nominal=nominal)]
    y, setting = np.concatenate([fit.estimate.values for fit in made]), [0, 0, 1, 2]
    values = _each_delay(y, made, rig, sector, setting)
    follows = np.array([_each_delay(one, made, rig, sector, setting) for one in np.eye(24)]).T
    covariance = follows @ _covariance(made, rig, sector) @ follows.T
    apart = np.eye(4) - np.array([0.5, 0.5, 0, 0])
    told = _estimate(made, rig, sector).relative_delays
    assert [one.file for one in told] == [f"run {k}" for k in range(4)]
    assert [one.nominal_s for one in told] == nominal
    np.testing.assert_allclose([o.value_s for o in told], apart @ values + np.array(nominal), atol=2e-11)
    np.testing.assert_allclose(
        [o.standard_uncertainty_s for o in told], np.sqrt(np.diag(apart @ covariance @ apart.T)), rtol=1e-4
    )


def test_angles_do_not_touch_relative_delays(fits, geometry, sector):
    """Oracle: the same with angles known a thousand times better; the sector moves both recordings alike."""
    made = fits([SIX, SIX + 2e-6 * IS_EDGE], nominal=[0.0, 0.025])
    made = [replace(fit, shape_effect=made[0].shape_effect) for fit in made]
    good, bad = (_estimate(made, geometry(common=(u,), u_edge=u), sector).relative_delays[1] for u in (1e-6, 1e-3))
    assert good.value_s == pytest.approx(0.025 + 2e-6, abs=2e-8)
    assert bad.value_s == pytest.approx(good.value_s, abs=1e-8)
    assert bad.standard_uncertainty_s == pytest.approx(good.standard_uncertainty_s, rel=0.02)
    assert bad.standard_uncertainty_s < 10e-6


def test_a_recording_given_twice_is_no_trouble(fits, geometry, sector):
    """Oracle: once; the same numbers, and no delay between the two."""
    once = fits([SIX])
    twice = _estimate([once[0], replace(once[0], name="again")], geometry(), sector)
    np.testing.assert_allclose(twice.estimate.values, _estimate(once, geometry(), sector).estimate.values, rtol=1e-7)
    assert twice.relative_delays[1].value_s == pytest.approx(0, abs=1e-12)
    assert twice.relative_delays[0].standard_uncertainty_s < 5e-6


def test_hardly_any_noise_is_no_trouble(fits, geometry, sector):
    """Oracle: the six numbers; errors that are nearly all common leave a covariance that is hard to invert."""
    made = fits([SIX, SIX], u=U * 1e-3, effect=0.0)
    result = _estimate(made, geometry(), sector)
    np.testing.assert_allclose(result.estimate.values, SIX[3:], rtol=1e-5)
    assert np.all(np.isfinite(result.estimate.covariance))


def test_edges_that_nobody_measured_are_judged_by_their_scatter(fits, geometry, sector):
    """Oracle: by hand; variance of the four angles times 3, as four values of a normal distribution have it (JCGM 101)."""
    off = np.array([3e-6, -1e-6, 4e-6, -6e-6])
    result = _estimate(
        fits([SIX + np.append(off, [0, 0])], u=U * 1e-3, effect=0), geometry(common=(), u_edge=None), sector
    )
    edge = np.sqrt(3 * np.var(off, ddof=1))
    line = next(line for line in result.budget if line.source == "cutout edges")
    assert line.kind == "A"
    assert line.standard_uncertainty["trigger_delay"] == pytest.approx(edge / 2, rel=1e-3)  # the mean of four
    assert result.estimate.values[0] == pytest.approx(SIX[0], abs=1e-8)


def test_an_undetermined_time_constant_is_no_number(fits, geometry, sector):
    """Oracle: by hand; u = 3 ms of 6 ms: bounds of 2 u, a warning, and the row delay alone in the estimate."""
    u = np.array([2e-3] * 4 + [3e-3, 1e-7])
    result = _estimate(fits([SIX], u=u, effect=0), geometry(), sector)
    assert result.estimate.names == ("row_delay",)
    assert result.estimate.values == pytest.approx([60e-6], rel=1e-2)
    tau, delay = result.bounds
    assert (tau.name, delay.name) == ("time_constant", "trigger_delay")
    assert tau.lower == pytest.approx(0, abs=1e-12)
    assert tau.upper == pytest.approx(12e-3, rel=0.05)
    assert delay.lower < 2.3e-3 < delay.upper
    assert (delay.lower + delay.upper) / 2 == pytest.approx(2.3e-3, rel=0.01)
    assert any("the time constant is not determined (u = 3 ms, k = 1)" in text for text in _texts(result))
    assert len(result.budget) == 6


@pytest.mark.parametrize(("relative", "known"), [(0.24, True), (0.26, False)])
def test_a_quarter_is_where_the_time_constant_ends(fits, geometry, sector, relative, known):
    """Oracle: the limit; a relative standard uncertainty of a quarter."""
    result = _estimate(fits([SIX], u=np.array([1e-5] * 4 + [relative * 6e-3, 1e-7]), effect=0), geometry(), sector)
    assert ("time_constant" in result.estimate.names) == known
    assert (result.bounds == ()) == known


def test_recordings_that_scatter_widen_each_other(fits, geometry, sector):
    """Oracle: by hand; numbers that scatter by three of their uncertainties have a Birge ratio of 3, and u grows by it."""
    rng = np.random.default_rng(11)
    base = fits([SIX])[0].estimate.covariance
    drawn = rng.multivariate_normal(np.zeros(6), base, 12)
    results = []
    for size in (1.0, 3.0):
        made = [
            replace(fit, estimate=replace(fit.estimate, covariance=base))
            for fit in fits([SIX + size * d for d in drawn], effect=0)
        ]
        results.append(_estimate(made, geometry(common=(), u_edge=1e-9), sector))
    ratio = (
        results[1].budget[0].standard_uncertainty["time_constant"]
        / results[0].budget[0].standard_uncertainty["time_constant"]
    )
    assert 2.4 < ratio < 3.3
    assert not any("Birge" in text for text in _texts(results[0]))
    assert any("12 recordings at 3 Hz scatter" in text and "(Birge ratio)" in text for text in _texts(results[1]))


def test_two_recordings_that_disagree_are_told(fits, geometry, sector):
    """Oracle: ten uncertainties between two recordings; too few to widen, enough to say so."""
    result = _estimate(fits([SIX, SIX + 10 * U * np.array([0, 0, 0, 0, 1, 0])]), geometry(), sector)
    assert any(text.startswith("2 recordings at 3 Hz scatter") for text in _texts(result))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"six": SIX - 9e-3 * IS_EDGE}, "rows would be read before the trigger, row 0 at -6.700 ms"),
        ({"variance_inflation": 9.0}, "residuals of 1 of 1 recording are correlated.*widened by up to 3.0"),
        (
            {"row_delay": 61e-6},
            r"row delay by the row sums 60.000 µs, by the phases of the pixels 61.000 µs: they differ by 7.1 u",
        ),
        (
            {"u_edge": None, "six": SIX + 2e-4 * np.array([1, -1, 1, -1, 0, 0])},
            "the four wheel edges disagree by 7.5 mrad",
        ),
    ],
)
def test_doubts_are_told(fits, geometry, sector, change, says):
    """Oracle: by hand; one doubt at a time."""
    made = fits([change.get("six", SIX)], variance_inflation=change.get("variance_inflation", 1.0))
    image = replace(sector, row_delay_s=change.get("row_delay", 60e-6))
    options = {"u_edge": change["u_edge"]} if "u_edge" in change else {}
    warnings = _texts(_estimate(made, geometry(**options), image, n_rows=36))
    assert len(warnings) == 2
    assert re.search(says if ".*" in says else re.escape(says.replace("\\", "")), warnings[1])


def test_a_camera_that_reads_its_last_row_first_is_not_doubted(fits, geometry, sector):
    """Oracle: by hand; row 0 at 2 ms, row 35 at 2.3 - 35 * 0.06 = 0.2 ms: after the trigger."""
    six = np.array([2.3e-3] * 4 + [6e-3, -60e-6])
    assert _estimate(fits([six]), geometry(), replace(sector, row_delay_s=-60e-6)).findings == (KNOWN,)


@pytest.mark.parametrize(("delay_s", "t_row_s"), [(-1e-3, 60e-6), (1.1e-3, -60e-6)])
def test_a_row_that_is_read_before_the_trigger_is_a_doubt(fits, geometry, sector, delay_s, t_row_s):
    """Oracle: by hand; row 0 at -1 ms, or row 35 at 1.1 - 35 * 0.06 = -1 ms: no camera knows of a trigger that is to come."""
    six = np.array([delay_s] * 4 + [6e-3, t_row_s])
    found = _estimate(fits([six]), geometry(), replace(sector, row_delay_s=t_row_s), n_rows=36).findings
    assert [(one.code, one.severity) for one in found[1:]] == [("rows-read-before-trigger", "doubt")]


@pytest.mark.parametrize(("of_rows", "worst"), [([-0.7, -0.0001], 0), ([0.0, -0.022], 79), ([0.5, -0.001], None)])
def test_that_row_counts_which_is_surest_to_come_too_early(of_rows, worst):
    """Oracle: by hand; row 0 at -0.7 ms, 7 u early, is a doubt, though row 79, at -0.708 ms, has a u of 0.41 ms: 1.7 u."""
    estimate = Estimate(
        names=("trigger_delay", "row_delay"), units=("s", "s"), values=1e-3 * np.array(of_rows),
        covariance=np.diag([1e-4, 5e-6]) ** 2,
    )  # fmt: skip
    found = doubts.of_reading(estimate, n_rows=80)
    if worst is None:
        assert found == ()
    else:
        early_ms, u_ms = of_rows[0] + worst * of_rows[1], np.hypot(0.1, worst * 0.005)
        assert found[0].what.startswith(
            f"rows would be read before the trigger, row {worst} at {early_ms:.3f} ms (u = {u_ms:.3f} ms)"
        )
        assert found[0].severity == "doubt"


def test_each_blackbody_has_a_time_constant_of_its_own(fits, geometry, sector):
    """Oracle: the numbers that went in: two taus come back as they are, delay and row delay as one, and their mean as tau."""
    warmer = SIX - np.array([0, 0, 0, 0, 100e-6, 0])
    made = [
        replace(fit, blackbody_temperature_k=kelvin)
        for fit, kelvin in zip(fits([warmer, SIX, SIX]), (318.0, 288.0, 288.1), strict=True)
    ]
    found = _estimate(made, geometry(), sector)
    effective = found.effective
    assert effective.blackbody_temperature_k == pytest.approx([288.05, 318.0])
    assert effective.time_constant_s == pytest.approx([SIX[4], warmer[4]], abs=1e-12)
    values = dict(zip(found.estimate.names, found.estimate.values, strict=True))
    assert values["trigger_delay"] == pytest.approx(SIX[0], abs=1e-9)
    assert values["row_delay"] == pytest.approx(SIX[5], abs=1e-11)
    assert warmer[4] < values["time_constant"] < SIX[4]
    assert any("is an effective one" in text for text in _texts(found))
    same = _estimate([replace(fit, blackbody_temperature_k=300.0) for fit in fits([SIX, SIX])], geometry(), sector)
    assert same.effective.time_constant_s.size == 1
    assert not any("is an effective one" in text for text in _texts(same))


def test_edges_that_part_with_the_blackbody_do_not_move_the_time_constant(fits, geometry, sector):
    """Oracle: the taus that went in; uncovering edges are 40 us early and covering ones late where it is warm."""
    warmer = SIX - np.array([-40e-6, 40e-6, -40e-6, 40e-6, 100e-6, 0])
    made = [
        replace(fit, blackbody_temperature_k=kelvin)
        for fit, kelvin in zip(fits([SIX, warmer]), (288.0, 318.0), strict=True)
    ]
    found = _estimate(made, geometry(), sector)
    assert found.effective.time_constant_s == pytest.approx([SIX[4], warmer[4]], abs=1e-12)
    assert found.estimate.values[0] == pytest.approx(SIX[0], abs=1e-9)


def test_a_window_of_which_the_frames_tell_no_sign_is_as_long_as_it_is():
    """Oracle: by hand; light depends on the square of the length, so that 6 ms and -6 ms are one window, and one effect."""
    tail = WindowTail(share=Measured(0.0, 0.02), time_constant_s=0.1e-3)
    fits = [
        SimpleNamespace(estimate={"integration_time": None}, timing={"integration_time": length_s})
        for length_s in (6e-3, -6e-3)
    ]
    part = integration_window.tails(tail)
    for one in part.values():
        there, back = (shared_numbers._longer(fit, one, None) for fit in fits)
        assert there == back
        assert there["integration_time"] > 0


def test_a_window_that_is_not_stated_looks_longer_by_what_comes_after_it(fits, geometry, sector):
    """Oracle: by hand; an even window has T^2 / 12, so that dT = 6 / T of the added variance; half of the share in each part.

    The start is half of that length before the centre, which the tail makes later: of T nothing is left, some 2 tau are.
    """
    (fit,) = fits([SIX], effect=0.0)
    names = ("integration_time" if name == "time_constant" else name for name in SIX_NAMES)
    fit = replace(fit, estimate=replace(fit.estimate, names=tuple(names)))
    tail = WindowTail(share=Measured(0.0, 0.02), time_constant_s=0.1e-3)
    plain, tailed = (
        _estimate([fit], geometry(), sector, rig=RigErrors(window_tail=one)).estimate for one in (None, tail)
    )
    length_s, fades_s = 6e-3, np.array([0.1e-3 / 3, 0.5e-3 / 3])
    longer_s = 6 / length_s * ((length_s / 2 + fades_s) ** 2 + fades_s**2 - length_s**2 / 12)
    for name, effect_s in (("integration_time", longer_s), ("trigger_delay", longer_s / 2 - length_s / 2 - fades_s)):
        assert tailed.value(name) == pytest.approx(plain.value(name))
        beside = np.sqrt(tailed.u(name) ** 2 - plain.u(name) ** 2)
        assert beside == pytest.approx(0.02 / np.sqrt(2) * np.hypot(*effect_s), rel=1e-3)
    assert tailed.u("exposure_midpoint_delay") == pytest.approx(plain.u("exposure_midpoint_delay"))


def test_unknown_blackbodies_are_one(fits, geometry, sector):
    """Oracle: no temperature, so nothing by temperature and no other result than before there were any."""
    assert _estimate(fits([SIX, SIX]), geometry(), sector).effective is None
