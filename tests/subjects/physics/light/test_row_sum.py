"""Rows of all four cameras against the scene stepped or integrated in time, and their derivatives against differences."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from irtiming.physics.camera import camera
from irtiming.physics.light.bent_rows import CUBIC, QUADRATIC, PixelPowers
from irtiming.physics.light.row_sum import BESIDE, BLADE, BLADES, EDGE_DELAYS, RowSum, harmonics, linearised
from irtiming.physics.wheel import wheel_model
from irtiming.physics.wheel_harmonics import at_angles, later, open_harmonics

TURN = 2 * np.pi
OMEGA = 5 * TURN
MODEL = wheel_model((0.0, 1.58, 3.15, 4.7), 0.27, opening_angle_rad=1.3, centre_angle_rad=float(np.radians(-91)))
KINDS = [(kind, mode) for kind in ("photon", "microbolometer") for mode in ("snapshot", "rolling")]
OWN = {
    "photon": {"integration_time": 9e-3, "pixel_memory": 0.0, BLADE: 0.0, BESIDE: 0.0},
    "microbolometer": {"time_constant": 6e-3, "recursive_filter": 0.0, BLADE: 0.0, BESIDE: 0.0},
}
M = 30


def _rows(kind, mode, *, apart=True):
    rng = np.random.default_rng(5)
    damped = np.exp(-0.02 * np.arange(M + 1) ** 2)
    return RowSum(
        camera=camera(kind, mode),
        open_harmonics=open_harmonics(MODEL, M) * damped,
        row_harmonics=rng.normal(size=(3, M + 1)) + 1j * rng.normal(size=(3, M + 1)),
        row_px=np.array([4.0, 90.0, 311.0]),
        angular_frequency_rad_per_s=OMEGA,
        step_rad=0.622,
        beside_harmonics=rng.normal(size=(3, M + 1)) + 1j * rng.normal(size=(3, M + 1)),
        blades_apart=apart,
    )


def _timing(kind, mode, **change):
    delays = dict(zip(EDGE_DELAYS, (2.31e-3, 2.29e-3, 2.33e-3, 2.3e-3), strict=True))
    return delays | OWN[kind] | ({"row_delay": 40e-6} if mode == "rolling" else {}) | change


@pytest.mark.parametrize(("kind", "mode"), KINDS)
def test_names_are_those_of_response_and_readout(kind, mode):
    """Oracle: eq. 1 has an integration time, eq. 2 a time constant, eq. 3 a row delay; frames remember, blades differ."""
    own = ("integration_time", "pixel_memory") if kind == "photon" else ("time_constant", "recursive_filter")
    assert _rows(kind, mode).names == (*EDGE_DELAYS, *own, *BLADES, *(("row_delay",) if mode == "rolling" else ()))


@pytest.mark.parametrize("apart", [True, False])
@pytest.mark.parametrize(("kind", "mode"), KINDS)
def test_derivatives_are_those_of_differences(kind, mode, apart):
    """Oracle: central differences in each parameter."""
    shares = {BLADE: 0.02, BESIDE: 0.01, ("pixel_memory" if kind == "photon" else "recursive_filter"): 0.07}
    rows, timing = _rows(kind, mode, apart=apart), _timing(kind, mode, **shares)
    assert (BESIDE in rows.names) == apart
    whole, found = linearised(rows, timing)
    np.testing.assert_array_equal(whole, harmonics(rows, timing))
    assert found.shape == (len(rows.names), 3, M + 1)
    for name, slope in zip(rows.names, found, strict=True):
        step = {"row_delay": 1e-9, "pixel_memory": 1e-6, "recursive_filter": 1e-6}.get(name, 1e-7)
        ahead, behind = (harmonics(rows, timing | {name: timing.get(name, 0.0) + sign * step}) for sign in (1, -1))
        numeric = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(slope, numeric, atol=1e-6 * np.abs(numeric).max(), err_msg=name)


@pytest.mark.parametrize("mode", ["snapshot", "rolling"])
def test_derivatives_of_a_bent_response_are_those_of_differences(mode):
    """Oracle: central differences in each parameter; without a bend the rows are those of a straight response."""
    plain, rng = _rows("microbolometer", mode), np.random.default_rng(6)
    powers = rng.normal(size=(3, 3, M + 1)) + 1j * rng.normal(size=(3, 3, M + 1))
    rows = replace(
        plain,
        powers=PixelPowers(squares=powers[0], cubes=powers[1], askew=powers[2], smear=np.array([0.99, 0.995, 0.999])),
    )
    straight = _timing("microbolometer", mode, **{BLADE: 0.02, BESIDE: 0.01, "recursive_filter": 0.07})
    np.testing.assert_array_equal(harmonics(rows, straight), harmonics(plain, straight))
    timing = straight | {QUADRATIC: 0.1, CUBIC: -0.05}
    whole, found = linearised(rows, timing)
    np.testing.assert_allclose(whole, harmonics(rows, timing), rtol=1e-12)
    assert rows.names[-2:] == (QUADRATIC, CUBIC)
    for name, slope in zip(rows.names, found, strict=True):
        step = {"row_delay": 1e-9, "recursive_filter": 1e-6, QUADRATIC: 1e-4, CUBIC: 1e-4}.get(name, 1e-7)
        ahead, behind = (harmonics(rows, timing | {name: timing[name] + sign * step}) for sign in (1, -1))
        numeric = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(slope, numeric, atol=1e-6 * np.abs(numeric).max(), err_msg=name)


@pytest.mark.parametrize("wide", [1.0, 3.0])
def test_a_warmer_second_blade_is_seen_between_its_edges(wide):
    """Oracle: by hand; a point sees 1 when open, 0 behind the first blade, the share behind the second one; up to a constant.

    Where three times the opening's light is seen of the blades, and all of it is as warm, it is three times as bright.
    """
    angle = np.linspace(0, TURN, 721)[:-1]
    sharp = RowSum(
        camera=camera("photon", "snapshot"), open_harmonics=open_harmonics(MODEL, 400), row_harmonics=np.ones((1, 401), complex),
        row_px=np.zeros(1), angular_frequency_rad_per_s=OMEGA, step_rad=0.622,
        beside_harmonics=np.full((1, 401), wide - 1, complex),
    )  # fmt: skip
    timing = dict.fromkeys(EDGE_DELAYS, 0.0) | {"integration_time": 0.0, "pixel_memory": 0.0, BLADE: 0.1}
    seen = at_angles(harmonics(sharp, timing)[0], angle)
    phase = np.mod(MODEL.opening_coordinate_rad + angle, TURN)
    edges = MODEL.cutout_edges_rad
    expected = np.where((phase > edges[1]) & (phase < edges[2]) | (phase > edges[3]), 1.0, 0.0)
    expected[(phase > edges[2]) & (phase < edges[3])] = 0.1 * wide
    away = np.min([np.abs(np.mod(phase - edge + np.pi, TURN) - np.pi) for edge in edges], axis=0) > 0.1
    np.testing.assert_allclose((seen - seen.mean())[away], (expected - expected.mean())[away], atol=0.02)


def _scene(rows, k, timing):
    """What row k would show with neither response nor readout, over the wheel angle at the trigger."""
    delays = OMEGA * np.array([timing[name] for name in EDGE_DELAYS])
    still = (rows.open_harmonics * later(delays, n_harmonics=M)).sum(axis=0) * rows.row_harmonics[k]
    return lambda time_s: at_angles(still, np.array([OMEGA * time_s]))[0]


@pytest.mark.parametrize("mode", ["snapshot", "rolling"])
def test_a_photon_camera_integrates_each_row_in_its_turn(mode):
    """Oracle: eq. 1 and 3 by numerical integration over each row's own window, half of it before the delay."""
    rows, timing = _rows("photon", mode), _timing("photon", mode)
    seen, window = harmonics(rows, timing), timing["integration_time"]
    for k, row in enumerate(rows.row_px):
        scene = _scene(rows, k, timing)
        for trigger in (0.01, 0.16):
            middle = trigger + row * timing.get("row_delay", 0.0)
            integral, _ = quad(scene, middle - window / 2, middle + window / 2, epsabs=1e-12)
            assert at_angles(seen[k], np.array([OMEGA * trigger]))[0] == pytest.approx(integral / window, abs=1e-8)


@pytest.mark.parametrize("mode", ["snapshot", "rolling"])
def test_a_lagging_camera_is_read_row_by_row_while_it_relaxes(mode):
    """Oracle: eq. 2 by scipy.integrate.solve_ivp over fifteen time constants, read as eq. 3 says."""
    rows, timing = _rows("microbolometer", mode), _timing("microbolometer", mode)
    seen, tau = harmonics(rows, timing), timing["time_constant"]
    for k, row in enumerate(rows.row_px):
        scene = _scene(rows, k, timing)
        read = np.array([0.1, 0.16]) + row * timing.get("row_delay", 0.0)
        run_in = 15 * tau
        found = solve_ivp(
            lambda t, x, s=scene: (s(t) - x) / tau, (read[0] - run_in, read[-1] + 1e-6), [0.0], t_eval=read,
            rtol=1e-9, atol=1e-11,
        )  # fmt: skip
        shown = at_angles(seen[k], OMEGA * np.array([0.1, 0.16]))
        np.testing.assert_allclose(shown, found.y[0], atol=1e-5)


@pytest.mark.parametrize(("kind", "mode", "order"), [
    ("photon", "rolling", 256), ("photon", "snapshot", 512), ("microbolometer", "rolling", 256),
    ("microbolometer", "snapshot", 512),
])  # fmt: skip
def test_a_snapshot_needs_orders_twice_as_high(kind, mode, order):
    """Oracle: by hand; what is beyond is alike in all rows of a snapshot."""
    assert camera(kind, mode).n_harmonics == order
