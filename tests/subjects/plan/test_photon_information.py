"""What a run of a photon camera can tell, against brute force."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from irtiming.physics.light.bright_ends import bright_ends
from irtiming.physics.wheel import exposed_fraction, wheel_model
from irtiming.plan import information, photon_information
from irtiming.plan.photon_information import KNOWN_WINDOW, OWN_SHAPE, SHARED_SHAPE, FrameNoise, Sampling
from irtiming.records.camera_description import PhotonCamera
from irtiming.records.prediction import AngleErrors

TURN = 2 * np.pi
GAMMA = float(np.radians(75))
MODEL = wheel_model((0.0, 1.5718, 3.1421, 4.7125), 0.2682, opening_angle_rad=GAMMA, centre_angle_rad=-np.pi / 2)
NOISE = FrameNoise(share=2e-4, jitter_s=0.4e-6, integration_time_s=250e-6, border_rad=0.1)
EXACT = AngleErrors(common=(), edge_rad=0.0)
ANGLES = AngleErrors(common=(("mask", 5e-4), ("gates", 2e-4)), edge_rad=1e-4)
STEPS = {
    "trigger_delay": 1e-8, "integration_time": 1e-8, "opening_angle": 1e-6, "skew": 1e-3, "bow": 1e-3, "plate": 1e-3,
    "blades": 1e-3, "beside": 1e-3,
    "pixel_memory": 1e-3, "covered": 1e-3, "step": 1e-3, "drift": 1e-3,
    "edge_0": 1e-6, "edge_1": 1e-6, "edge_2": 1e-6, "edge_3": 1e-6,
}  # fmt: skip


def _sampling(wheel_hz=12.0, n=1000, per_frame=99):
    return Sampling(
        wheel_angle_rad=TURN / n * (np.arange(n) * per_frame % n + 0.3),
        time=(np.arange(n) + 0.5) / n - 0.5,
        angular_frequency_rad_per_s=TURN * wheel_hz,
        step_rad=TURN * per_frame / n,
    )


def _second_blade(angle, width, sweep):
    """What the second blade covers less what the first does, halved: points of an opening at instants of the window."""
    place = (np.arange(800) + 0.5) / 800 - 0.5
    instants = sweep * (np.arange(6) + 0.5) / 6
    behind = np.zeros(angle.size)
    for then in instants:
        at = np.mod(MODEL.opening_coordinate_rad + angle[:, None] + then + width * place, TURN)
        edges = MODEL.cutout_edges_rad
        second, first = (((at >= edges[k]) & (at < edges[k + 1])).mean(axis=1) for k in (2, 0))
        behind += (second - first) / 2 / instants.size
    return behind


def _bow(angle, sweep):
    """What light that is stronger at both ends adds: points of an opening, weighed with (3 u^2 - 1) / 2, at instants."""
    return _bow_at(tuple(angle.tolist()), sweep)


@cache
def _bow_at(angles, sweep):
    angle, added = np.array(angles), np.zeros(len(angles))
    for share in (np.arange(48) + 0.5) / 48:  # of the window; rows of points are shifted by the golden section
        u = (np.arange(8_000) + 48 * share * 0.618 % 1) / 4_000 - 1
        at = np.mod(MODEL.opening_coordinate_rad + angle[:, None] + sweep * share + GAMMA / 2 * u, TURN)
        edges = MODEL.cutout_edges_rad
        is_open = ((at >= edges[1]) & (at < edges[2])) | (at >= edges[3])
        added += np.mean(is_open * (3 * u**2 - 1) / 2, axis=1) / 48
    return added


def _frame_sums(sampling, noise, *, off):
    """The sums of all frames for parameters that are off by this much: the whole model, written out."""
    omega = sampling.angular_frequency_rad_per_s
    window = noise.integration_time_s + off.get("integration_time", 0.0)
    angle = sampling.wheel_angle_rad + omega * off.get("trigger_delay", 0.0)
    edges = tuple(edge - off.get(f"edge_{k}", 0.0) for k, edge in enumerate(MODEL.cutout_edges_rad))
    model = replace(MODEL, cutout_edges_rad=edges, opening_angle_rad=GAMMA + off.get("opening_angle", 0.0))
    fraction = exposed_fraction(angle, model, sweep_rad=omega * window)
    wider = replace(model, opening_angle_rad=model.opening_angle_rad + 2 * noise.border_rad)
    plate = exposed_fraction(angle, wider, sweep_rad=omega * window) - fraction
    light = fraction + off.get("skew", 0.0) * bright_ends(angle, model, sweep_rad=omega * window).skew
    if "bow" in off:
        light += off["bow"] * _bow(angle, omega * window)
    for name, width in (("blades", GAMMA), ("beside", GAMMA + 2 * noise.border_rad)):
        if name in off:
            inner = _second_blade(angle, GAMMA, omega * window) if name == "beside" else 0.0
            light += off[name] * (_second_blade(angle, width, omega * window) - inner)
    light += off.get("plate", 0.0) * plate + off.get("drift", 0.0) * sampling.time
    light += off.get("pixel_memory", 0.0) * (np.roll(fraction, 1) - fraction)  # of the frame before
    return off.get("covered", 0.0) + (1 + off.get("step", 0.0)) * light


def _column(name, sampling, noise):
    ahead, behind = (_frame_sums(sampling, noise, off={name: sign * STEPS[name]}) for sign in (1, -1))
    return (ahead - behind) / (2 * STEPS[name])


@pytest.mark.parametrize("name", [name for name in STEPS if not name.startswith("edge")])
@pytest.mark.parametrize("wheel_hz", [2.0, 12.0, 50.0])
def test_each_derivative_is_that_of_the_model(name, wheel_hz):
    """Oracle: central differences of the whole model."""
    sampling = _sampling(wheel_hz, n=200, per_frame=19)
    found = photon_information.derivatives(sampling, NOISE, model=MODEL)[name]
    expected = _column(name, sampling, NOISE)
    coarse = {"blades": 1e-3, "beside": 2e-2}.get(name, 2e-4)  # counted points
    np.testing.assert_allclose(found, expected, atol=coarse * np.abs(expected).max())


@pytest.fixture(scope="module")
def runs():
    """Two runs at two speeds, and each one's columns by central differences, made once: (sampling, column of a name)."""
    samplings = (_sampling(5.0, n=400, per_frame=39), _sampling(20.0, n=400, per_frame=161))
    column = cache(lambda name, k: _column(name, samplings[k], NOISE))
    return [(sampling, lambda name, k=k: column(name, k)) for k, sampling in enumerate(samplings)]


@pytest.mark.parametrize("structure", [SHARED_SHAPE, OWN_SHAPE, KNOWN_WINDOW])
def test_uncertainties_are_those_of_the_whole_fisher_matrix(runs, structure):
    """Oracle: the matrix of all parameters of two runs at two speeds by central differences, priors added, inverted at once."""
    errors = [*ANGLES.common, *[("edge", ANGLES.edge_rad)] * 4]
    n_own, n_shared = len(structure.own), len(structure.shared)
    whole = np.zeros((n_shared + len(errors) + 2 * n_own,) * 2)
    for k, (sampling, column) in enumerate(runs):
        edges = [column(f"edge_{edge}") for edge in range(4)]
        columns = [column(name) for name in structure.shared]
        columns += [u * np.sum(edges, axis=0) for _, u in ANGLES.common] + [ANGLES.edge_rad * edge for edge in edges]
        own = [column(name) for name in structure.own]
        nothing = [np.zeros(400)] * n_own
        columns += [*own, *nothing] if k == 0 else [*nothing, *own]
        slope = sampling.angular_frequency_rad_per_s * np.sum(edges, axis=0)
        weighted = np.array(columns) / np.hypot(NOISE.share, NOISE.jitter_s * slope)
        whole += weighted @ weighted.T
    known = np.zeros(len(whole))
    known[n_shared : n_shared + len(errors)] = 1.0
    scale = 1 / np.sqrt(np.diag(whole) + known)
    inverse = np.linalg.inv((whole + np.diag(known)) * np.outer(scale, scale)) * np.outer(scale, scale)
    told = information.total(
        [photon_information.one_run(one, NOISE, model=MODEL, angles=ANGLES, structure=structure) for one, _ in runs]
    )
    found = information.uncertainties(told, {name: {name: 1.0} for name in structure.shared})
    for k, each in enumerate(found):
        assert each.standard_uncertainty_s == pytest.approx(np.sqrt(inverse[k, k]), rel=2e-3), each.name


def _trigger_delay(told):
    (found,) = information.uncertainties(told, {"trigger_delay": {"trigger_delay": 1.0}})
    return found.standard_uncertainty_s


@pytest.mark.parametrize("wheel_hz", [3.0, 50.0])
def test_at_one_speed_the_angles_are_the_limit(wheel_hz):
    """Oracle: the budget by hand; the common angles and a quarter of the edges' variance, over omega."""
    told = photon_information.one_run(
        _sampling(wheel_hz), NOISE, model=MODEL, angles=ANGLES, structure=KNOWN_WINDOW
    ).times(1e4)
    by_hand = np.sqrt(5e-4**2 + 2e-4**2 + 1e-4**2 / 4) / (TURN * wheel_hz)
    assert _trigger_delay(told) == pytest.approx(by_hand, rel=1e-4)


def test_noise_falls_with_the_root_of_the_runs_and_grows_with_that_of_a_frame():
    """Oracle: the law of means, and proportion."""
    one = photon_information.one_run(_sampling(), NOISE, model=MODEL, angles=EXACT)
    noisy = replace(NOISE, share=3 * NOISE.share, jitter_s=3 * NOISE.jitter_s)
    worse = photon_information.one_run(_sampling(), noisy, model=MODEL, angles=EXACT)
    assert _trigger_delay(one.times(16)) == pytest.approx(_trigger_delay(one) / 4)
    assert _trigger_delay(worse) == pytest.approx(3 * _trigger_delay(one))


def test_without_a_window_the_slopes_alone_tell_the_delay():
    """Oracle: by hand; 4 gamma of a turn lie on slopes of omega / gamma, all other shapes are even to them."""
    sharp = replace(NOISE, integration_time_s=0.0, jitter_s=0.0)
    plain = replace(KNOWN_WINDOW, shared=tuple(name for name in KNOWN_WINDOW.shared if name != "pixel_memory"))
    told = photon_information.one_run(_sampling(3.0), sharp, model=MODEL, angles=EXACT, structure=plain)
    by_hand = NOISE.share * GAMMA / (TURN * 3.0) / np.sqrt(1000 * 4 * GAMMA / TURN)
    assert _trigger_delay(told) == pytest.approx(by_hand, rel=0.02)


def test_noise_of_a_frame_is_that_of_its_summed_pixels():
    """Oracle: by hand; an opening of 1200 pixels with its border of 6 is summed over 2046, contrast comes from 1200."""
    found = photon_information.frame_noise(PhotonCamera(noise_to_contrast=0.01, opening_pixels=1200.0))
    assert found.share == pytest.approx(0.01 * np.sqrt(2046) / 1200, rel=1e-3)
    assert found.jitter_s == pytest.approx(0.25e-6, rel=0.01)


@pytest.mark.parametrize("wheel_hz", [3.0, 12.0])
def test_fits_scatter_as_predicted(wheel_hz):
    """Oracle: 60 least-squares fits of the whole model to sums with white noise; their scatter is known to a tenth (k = 1)."""
    structure = replace(  # equal blades and an even opening: faster to count
        KNOWN_WINDOW,
        own=("covered", "step", "drift", "skew", "plate"),
        shared=tuple(name for name in KNOWN_WINDOW.shared if name != "bow"),
    )
    names = (*structure.shared, *structure.own)
    white, sampling, random = replace(NOISE, jitter_s=0.0), _sampling(wheel_hz, n=500), np.random.default_rng(7)
    columns = np.stack([_column(name, sampling, white) for name in names], axis=1)
    clean = _frame_sums(sampling, white, off={})
    delays = []
    for _ in range(60):
        sums, numbers = clean + random.normal(0, white.share, clean.size), np.zeros(len(names))
        for _ in range(3):  # Newton's steps with the slopes at the truth
            left = sums - _frame_sums(sampling, white, off=dict(zip(names, numbers, strict=True)))
            numbers = numbers + np.linalg.lstsq(columns, left, rcond=None)[0]
        delays.append(numbers[0])
    told = photon_information.one_run(sampling, white, model=MODEL, angles=EXACT, structure=structure)
    assert np.std(delays) == pytest.approx(_trigger_delay(told), rel=0.3)
