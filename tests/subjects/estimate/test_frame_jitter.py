"""Delays that scatter from frame to frame: frames that are moved one by one, and a simulated camera whose delay scatters."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import frame_jitter, frame_residuals
from irtiming.measurement import analyse
from irtiming.physics.wheel import TURN
from irtiming.records.result import DelayScatter
from irtiming.report.result import result as as_data
from irtiming.report.sections.parameters import parameters
from irtiming.twin.rig import draw, simulate
from irtiming.twin.scene import microbolometer_scene, with_wheel_speed

JITTER_S = 300e-6
OMEGA = TURN * 5.0
ORDERS = np.arange(4)
HARMONICS = np.array(
    [[0.5, 0.0, 0.4, 0.1j], [0.5, 0.02j, 0.35 + 0.1j, 0.0], [0.5, 0.0, 0.3 + 0.2j, 0.05]]
)  # of three rows
NOISE = np.array([0.004, 0.005, 0.008])


def _frames(seed, *, n=1500, jitter_s=JITTER_S, misfit=0.02):
    """Angles, residuals and slopes of frames that are late by normal amounts, beside a model that is wrong by ``misfit``."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, TURN, n))
    late_s = jitter_s * rng.standard_normal(n)

    def light(theta):
        return np.real(np.exp(1j * theta[:, None] * ORDERS) @ HARMONICS.T)

    moved = light(angle - OMEGA * late_s) - light(angle) + misfit * np.sin(2 * angle)[:, None]
    slope = np.real(np.exp(1j * angle[:, None] * ORDERS) @ (1j * ORDERS * HARMONICS).T) * OMEGA
    shuffled = rng.permutation(n)
    return angle[shuffled], (moved + NOISE * rng.standard_normal((n, 3)))[shuffled], slope[shuffled]


def _scatter(monkeypatch, seed, *, scale=1.0, **made):
    angle, residual, slope = _frames(seed, **made)
    frames = SimpleNamespace(angle_rad=angle, residual=residual, slope=slope, noise=scale * NOISE)
    monkeypatch.setattr(frame_residuals, "of_fit", lambda reduced, fit: frames)
    return frame_jitter.scatter(None, None)


@pytest.mark.parametrize("jitter_s", [0.0, JITTER_S])
def test_the_variance_of_the_delay_is_found_with_its_uncertainty(monkeypatch, jitter_s):
    """Oracle: the amounts by which frames were moved, 150 draws; noise that is stated twice too large changes nothing."""
    found = [_scatter(monkeypatch, seed, jitter_s=jitter_s, scale=2.0) for seed in range(150)]
    pulls = np.array([(one.variance_s2 - jitter_s**2) / one.u_s2 for one in found])
    assert abs(pulls.mean()) < 0.35
    assert 0.85 < pulls.std() < 1.2
    assert found[0].u_s2 < 0.2 * JITTER_S**2


def test_frames_err_together_by_so_much_more_than_their_pixels():
    """Oracle: the variance of sums s r / sigma^2 over 20000 frames, over that of frames that are not late; half the noise."""
    made = [_frames(3, n=20000, jitter_s=jitter_s, misfit=0.0) for jitter_s in (JITTER_S, 0.0)]
    late, still = (np.sum(residual * slope / NOISE**2, axis=1) for _, residual, slope in made)
    fit = SimpleNamespace(wheel_angle_rad=made[0][0], harmonics=HARMONICS, angular_frequency_rad_per_s=OMEGA)
    found = DelayScatter(variance_s2=JITTER_S**2, u_s2=0.1 * JITTER_S**2)
    assert frame_jitter.excess(found, fit, noise=NOISE) == pytest.approx(np.var(late) / np.var(still), rel=0.04)
    assert frame_jitter.excess(found, fit, noise=NOISE / 2) - 1 == pytest.approx(
        4 * (frame_jitter.excess(found, fit, noise=NOISE) - 1), rel=1e-9
    )
    assert frame_jitter.excess(replace(found, u_s2=0.2 * JITTER_S**2), fit, noise=NOISE) == 1.0


@pytest.fixture(scope="module")
def scattering():
    """Analysis of a camera whose delay scatters by 200 us, and its scene."""
    drawn = draw(microbolometer_scene(60, 80), seed=12)
    scene = with_wheel_speed(drawn.scene, 8.0, samples=300)
    scene = replace(scene, timing=replace(scene.timing, jitter_s=200e-6))
    return analyse([simulate(scene, seed=120)], drawn.measured), scene


def test_a_camera_whose_delay_scatters_is_told_so_and_its_result_holds(scattering):
    """Oracle: what the simulated camera was given. Its row delay was off by 4.9 u before the image knew of the scatter."""
    analysis, scene = scattering
    found = frame_jitter.scatter(analysis.recordings[0], analysis.fits[0])
    assert abs(found.variance_s2 - scene.timing.jitter_s**2) < 4 * found.u_s2
    told = next(one for one in analysis.best.findings if one.code == "delay-scatters")
    assert told.severity == "warning"
    assert f"{1e6 * found.variance_s2**0.5:.3g} µs" in told.what
    estimate = analysis.best.estimate
    off_s = estimate.value("row_delay") - scene.timing.row_delay_s
    assert abs(off_s) < 3 * estimate.u("row_delay")


def test_a_report_and_a_file_have_the_scatter(scattering):
    """Oracle: the result's own number, to the places of its uncertainty."""
    analysis, _ = scattering
    found = analysis.best.delay_scatter
    (row,) = [row for row in parameters(analysis).rows if row[0] == "scatter of the delay"]
    value, _, rest = row[1].partition(" ± ")
    assert float(value) == pytest.approx(1e6 * found.standard_deviation_s, abs=0.5 * 1e6 * found.u_s)
    assert rest.endswith("µs")
    stated = as_data(analysis)["delay_scatter"]
    assert stated["standard_deviation"] == pytest.approx(found.standard_deviation_s)
    assert stated["upper_limit"] > stated["standard_deviation"]


def test_recordings_are_weighed_and_chance_is_no_scatter(monkeypatch):
    """Oracle: by hand; (9e-10 / 1 + 1e-10 / 4) / (1 + 1/4) s^2 of 1e-10 / sqrt(1.25) is 8.3 u, and 4.44e-10 s^2 are 5.0 u."""
    one, other = (DelayScatter(variance_s2=v, u_s2=u) for v, u in ((9e-10, 1e-10), (1e-10, 2e-10)))
    given = iter([one, other, replace(one, variance_s2=5.4e-10), replace(other, variance_s2=0.6e-10)])
    monkeypatch.setattr(frame_jitter, "scatter", lambda recording, fit: next(given))
    sure = frame_jitter.of_all([None] * 2, [None] * 2)
    (told,) = frame_jitter.findings(sure)
    assert "27.2 µs (u = 1.6 µs)" in told.what
    unsure = frame_jitter.of_all([None] * 2, [None] * 2)
    assert frame_jitter.findings(unsure) == ()
    assert (unsure.standard_deviation_s, unsure.u_s) == (0.0, 0.0)
    assert unsure.upper_limit_s == pytest.approx((4.44e-10 + 1.645 * 0.8944e-10) ** 0.5, rel=1e-3)
    noise = DelayScatter(variance_s2=-2e-10, u_s2=1e-10)
    assert noise.upper_limit_s == pytest.approx(1.645e-10**0.5)
