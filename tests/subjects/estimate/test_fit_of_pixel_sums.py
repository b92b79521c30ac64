"""Delays of the four edges from pixel sums that a brute-force wheel made."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.errors import EstimationError
from irtiming.estimate import pixel_sums
from irtiming.estimate.pixel_sums import SHAPE
from irtiming.inference import optimiser
from irtiming.inference.optimiser import Linearised
from irtiming.physics.light.pixel_sum import Radii
from irtiming.physics.light.summed_region import SummedRegion
from irtiming.physics.wheel import wheel_model
from irtiming.records.estimate import EDGE_DELAYS

TURN = 2 * np.pi
CLOCK_HZ = 49_152_000
OMEGA = TURN * 3
START = 7_000_000
EDGES = (0.0, 1.5718, 3.1421, 4.7125)
GAMMA, GATE, CENTRE = float(np.radians(75)), 0.2682, float(np.radians(-90))
DELAY, WINDOW = 3.719e-4, 250e-6


def _model(edges=EDGES):
    return wheel_model(edges, GATE, opening_angle_rad=GAMMA, centre_angle_rad=CENTRE)


def _uniform(t):
    return OMEGA * t + 0.4


def _open_part(theta, edges):
    """Open share of the opening at each wheel angle: its overlap with both cutouts, turn by turn."""
    low = np.mod(np.pi / 2 + GATE + theta - CENTRE - GAMMA / 2, TURN)
    total = np.zeros_like(low)
    for turn in (-1, 0, 1):
        for a, b in ((edges[1], edges[2]), (edges[3], TURN + edges[0])):
            end = np.minimum(low + GAMMA, b + TURN * turn)
            total += np.maximum(0, end - np.maximum(low, a + TURN * turn))
    return total / GAMMA


def _triggers(n=1000):
    return START + 20_000_000 + 1_622_016 * np.arange(n, dtype=np.int64)


def _sums(*, theta=_uniform, edges=EDGES, delay=DELAY, window=WINDOW, n=1000, instants=300):
    """Open share of each frame: mean over many instants of its window."""
    t = (_triggers(n) - START) / CLOCK_HZ
    moments = t[:, None] + delay + window * (np.arange(instants) + 0.5) / instants
    return _open_part(theta(moments), edges).mean(axis=1)


@pytest.fixture
def recording(track_of, reduced_recording):
    """Reduced recording with the given open shares, on a step of 2e6 DN over 9e6."""

    def make(share, *, theta=_uniform, low=9e6, step=2e6, **fields):
        track = track_of(theta, start=START, duration_s=35.5)
        return reduced_recording(track, _triggers(len(share)), low + step * share, is_colder=step < 0, **fields)

    return make


@pytest.mark.parametrize("delay", [DELAY, 0.0, 5e-3, 40e-3, -30e-3])
@pytest.mark.parametrize("step", [2e6, -5e5])
def test_noise_free_delay_is_exact(recording, delay, step):
    """Oracle: delay and open shares that made the sums, before a hot and a cold blackbody: within a nanosecond for each edge."""
    share = _sums(delay=delay)
    fit = pixel_sums.fit(recording(share, step=step), _model())
    np.testing.assert_allclose(fit.edge_delay_s, delay, atol=1e-9)
    assert fit.estimate.value("opening_angle") == pytest.approx(GAMMA, abs=1e-7)
    assert fit.noise < 1e-6
    assert fit.n_dropped == 0
    np.testing.assert_allclose(np.sort(fit.fraction), np.sort(share), atol=1e-6)
    assert np.all(np.diff(fit.wheel_angle_rad) >= 0)


@pytest.mark.parametrize("window", [10e-6, 1e-3, 5e-3, 25e-3])
def test_any_integration_time_gives_the_start_of_the_window(recording, window):
    """Oracle: the window that made the sums, in 300 instants; its middle is half of it later."""
    fit = pixel_sums.fit(recording(_sums(window=window), integration_time_s=window), _model())
    np.testing.assert_allclose(fit.edge_delay_s, DELAY, atol=max(3e-9, 1.5e-6 * window))


@pytest.mark.parametrize("window", [WINDOW, 5e-3, 25e-3, 40e-3])
def test_unknown_integration_time_is_found_and_gives_the_middle(recording, window):
    """Oracle: start plus half the window that made the sums, which sweeps up to 43 degrees."""
    fit = pixel_sums.fit(recording(_sums(window=window), integration_time_s=None), _model())
    np.testing.assert_allclose(fit.edge_delay_s, DELAY + window / 2, atol=max(1e-8, 1.5e-6 * window))
    assert fit.estimate.value("opening_angle") == pytest.approx(GAMMA, abs=1e-5)


@pytest.mark.parametrize("seed", [10, 26])
def test_a_window_that_noise_hides_is_never_searched_beyond_a_turn(recording, monkeypatch, seed):
    """Oracle: the middle that made the sums.

    A window of 0.2 ms changes them by less than their noise does, so steps of the search come to hours, whose turns would be
    counted one by one.
    """
    modelled, projected = [], pixel_sums.PixelSums.projected

    def counted(self, numbers):
        modelled.append(abs(OMEGA * numbers["integration_time"]))
        return projected(self, numbers)

    monkeypatch.setattr(pixel_sums.PixelSums, "projected", counted)
    share = _sums(window=2e-4, n=250)
    noisy = share + np.random.default_rng(seed).normal(0, 4e-3, share.size)
    fit = pixel_sums.fit(recording(noisy, integration_time_s=None), _model())
    assert max(modelled) < TURN
    middle = np.mean(fit.edge_delay_s)
    assert middle == pytest.approx(DELAY + 1e-4, abs=4 * np.sqrt(fit.covariance_s2.mean()))


@pytest.mark.parametrize("share", [0.01, -0.002, 0.1])
def test_a_memory_of_the_pixels_is_found_and_its_delay_taken_off(recording, share):
    """Oracle: f_n = (1 - s) F_n + s F_{n-1} frame by frame; without the memory the delay would be off by s frames."""
    seen = _sums()
    given = (1 - share) * seen + share * np.concatenate([seen[:1], seen[:-1]])
    fit = pixel_sums.fit(recording(given + np.random.default_rng(6).normal(0, 1e-5, given.size)), _model())
    assert fit.estimate.value("pixel_memory") == pytest.approx(share, abs=5 * fit.estimate.u("pixel_memory"))
    assert fit.estimate.u("pixel_memory") < 5e-5
    np.testing.assert_allclose(fit.edge_delay_s, DELAY, atol=6 * np.sqrt(fit.covariance_s2[0, 0]))


def test_set_delay_is_taken_off(recording):
    """Oracle: the camera's own delay; 25 ms were set on top."""
    fit = pixel_sums.fit(recording(_sums(delay=DELAY + 0.025), trigger_delay_time_set_s=0.025), _model())
    np.testing.assert_allclose(fit.edge_delay_s, DELAY, atol=1e-9)
    assert fit.trigger_delay_time_set_s == 0.025


def test_wandering_wheel_does_no_harm(recording):
    """Oracle: the delay that made the sums on a wheel that wanders by 20 mrad."""

    def theta(t):
        return OMEGA * t + 0.4 + 0.02 * np.sin(TURN * t / 11) + 0.001 * np.sin(TURN * t / 1.7)

    fit = pixel_sums.fit(recording(_sums(theta=theta), theta=theta), _model())
    np.testing.assert_allclose(fit.edge_delay_s, DELAY, atol=5e-8)


def test_edges_are_seen_one_by_one(recording):
    """Oracle: by hand; an edge that comes e rad later than the model says is seen in frames that seem e / omega earlier."""
    errors = np.array([3e-4, -2e-4, 5e-4, 1e-4])
    fit = pixel_sums.fit(recording(_sums(edges=tuple(EDGES + errors))), _model())
    np.testing.assert_allclose(fit.edge_delay_s, DELAY - errors / OMEGA, atol=2e-9)


def test_drift_is_absorbed(recording):
    """Oracle: the delay that made the sums; the level drifts by 2 % of the step over the run."""
    share = _sums()
    fit = pixel_sums.fit(recording(share + np.linspace(-0.01, 0.01, share.size)), _model())
    np.testing.assert_allclose(fit.edge_delay_s, DELAY, atol=1e-9)


def _second_blade(theta):
    """Share of the opening that the blade between edges 2 and 3 covers: its overlap, turn by turn."""
    low = np.mod(np.pi / 2 + GATE + theta - CENTRE - GAMMA / 2, TURN)
    total = np.zeros_like(low)
    for turn in (-TURN, 0, TURN):
        total += np.maximum(0, np.minimum(low + GAMMA, EDGES[3] + turn) - np.maximum(low, EDGES[2] + turn))
    return total / GAMMA


def test_a_warmer_blade_and_levels_that_sway_and_jump_leave_the_delay(recording):
    """Oracle: the delay that made the sums; a blade 1.2 % of the step warmer, offset and gain that sway by 3 % and jump once.

    In units of its uncertainty, which is that of the noise alone and a third more for the numbers of the curves.
    """
    t = (_triggers() - START) / CLOCK_HZ
    moments = t[:, None] + DELAY + WINDOW * (np.arange(300) + 0.5) / 300
    scene = _open_part(_uniform(moments), EDGES).mean(axis=1) + 0.012 * _second_blade(_uniform(moments)).mean(axis=1)
    place = np.arange(t.size) / t.size
    swaying = 0.03 * np.sin(2 * np.pi * 1.3 * place) + (1 + 0.02 * np.cos(5 * place)) * scene + 0.01 * (place > 0.6)
    noise = np.random.default_rng(1).normal(0, 1e-4, t.size)
    plain, fit = (pixel_sums.fit(recording(share + noise), _model()) for share in (_sums(), swaying))
    u = np.sqrt(np.diag(fit.covariance_s2))
    assert np.all(np.abs(fit.edge_delay_s - DELAY) < 3 * u)
    of_noise = np.sqrt(np.diag(plain.covariance_s2))
    assert np.all((of_noise < u) & (u < 1.4 * of_noise))
    assert np.abs(np.array(fit.levels.jumps) - 600).min() < 3
    assert fit.blades == pytest.approx(0.012 / 0.994, abs=4 * fit.u_blades)
    assert fit.u_blades < 3e-5
    assert plain.levels.n_numbers == 1
    assert abs(plain.blades) < 4 * plain.u_blades


def test_wild_frames_are_dropped_and_told(recording):
    """Oracle: the delay that made the sums; 20 frames are wrong by a tenth of the step or more."""
    rng = np.random.default_rng(2)
    share = _sums() + rng.normal(0, 1e-4, 1000)
    wild = rng.choice(1000, 20, replace=False)
    share[wild] += rng.choice([-1, 1], 20) * rng.uniform(0.1, 0.9, 20)
    fit = pixel_sums.fit(recording(share), _model())
    assert not np.any(fit.kept[wild])
    assert fit.n_dropped == 1000 - fit.residual.size <= 21  # at most one beside them
    np.testing.assert_allclose(fit.edge_delay_s, DELAY, atol=6 * np.sqrt(fit.covariance_s2[0, 0]))
    assert np.sqrt(fit.covariance_s2[0, 0]) < 3e-6


def test_analytic_derivatives_are_those_of_the_model(recording):
    """Oracle: central differences of the projected residual in all eleven local numbers, at a point away from the solution.

    Kaufman's derivative leaves out what the levels change where the residual is not zero: of noise-free sums, little.
    """
    given = pixel_sums.pixel_sums(recording(_sums()), _model())
    lost = SummedRegion(ends_rad=np.array([-0.6, -0.3, 0.4, 0.6]), share=np.array([0.1, 0.05, 0.08]))
    given = replace(given, radii=Radii(share=np.array([0.4, 0.6]), place=np.array([0.3, -0.2])), lost=lost)
    early = np.array([1e-4, -2e-4, 3e-4, 0.0]) / OMEGA
    point = dict(zip(EDGE_DELAYS, DELAY + WINDOW / 2 + 1e-7 + early * 1e-2, strict=True))
    point |= dict(zip(SHAPE, (GAMMA, 1.05 * WINDOW, 4e-3, -6e-3, 0.03, 0.01, 5e-3), strict=True))
    steps = dict.fromkeys(EDGE_DELAYS, 1e-8) | dict(zip(SHAPE, (1e-6, 1e-7, 1e-6, 1e-6, 1e-4, 1e-5, 1e-4), strict=True))
    analytic = given.at(point).jacobian
    for k, (name, step) in enumerate(steps.items()):
        ahead, behind = (given.at(point | {name: point[name] + sign * step}).residual for sign in (1, -1))
        numeric = (ahead - behind) / (2 * step)
        assert np.abs(numeric).max() > 0
        apart = np.abs(analytic[:, k] - numeric) / np.abs(numeric).max()
        assert np.quantile(apart, 0.98) < 2e-2, name


def test_derivatives_of_frames_that_hold_much_of_the_one_before_are_those_of_the_model(recording):
    """Oracle: central differences of the projected residual in delay, opening and share, of noise-free sums near the truth."""
    light = _sums()
    given = pixel_sums.pixel_sums(recording(0.6 * light + 0.4 * np.append(light[:1], light[:-1])), _model())
    steps = dict.fromkeys(EDGE_DELAYS, 1e-8) | {"opening_angle": 1e-6, pixel_sums.MEMORY: 1e-6}
    point = dict.fromkeys(SHAPE, 0.0) | dict.fromkeys(EDGE_DELAYS, DELAY + WINDOW / 2 + 1e-7)
    point |= {"opening_angle": GAMMA, "integration_time": WINDOW, pixel_sums.MEMORY: 0.4}
    analytic = given.at(point).jacobian
    for name, step in steps.items():
        ahead, behind = (given.at(point | {name: point[name] + sign * step}).residual for sign in (1, -1))
        numeric = (ahead - behind) / (2 * step)
        apart = np.abs(analytic[:, list(point).index(name)] - numeric) / np.abs(numeric).max()
        assert np.quantile(apart, 0.98) < 2e-2, name


def test_the_frame_before_the_wheel_was_recorded_is_that_of_a_wheel_that_turned_evenly(track_of, reduced_recording):
    """Oracle: by hand; the record begins at 0.4 rad, 1 ms before the first trigger and 32 ms after the one before that."""
    made = reduced_recording(
        track_of(start=START, duration_s=2.0), START + 49_152 + 1_622_016 * np.arange(30), np.zeros(30)
    )
    given = pixel_sums.PixelSums(
        reduced=made, wheel=_model(), kept=np.ones(30, bool), levels=None, unit_dn=1.0, border_rad=0.0
    )
    expected = 0.4 + OMEGA * (1e-3 + DELAY + 0.033 * (np.arange(30) - 1))
    np.testing.assert_allclose(given.angle(DELAY, is_before=True), expected, atol=1e-6)


def test_pulls_of_40_noisy_repetitions_are_standard(recording):
    """Oracle: the delay that made the sums; (estimate - truth) / u of each edge and of the mean has mean 0, spread 1.

    The spread of 40 means is within 0.28 of 1 with a probability of 99 %, and their mean within four of its own spreads.
    """
    share = _sums(n=400, instants=30)
    rng = np.random.default_rng(6)
    pulls, means = [], []
    for _ in range(40):
        fit = pixel_sums.fit(recording(share + rng.normal(0, 1e-3, share.size)), _model())
        pulls.append((fit.edge_delay_s - DELAY) / np.sqrt(np.diag(fit.covariance_s2)))
        means.append((fit.edge_delay_s.mean() - DELAY) / np.sqrt(fit.covariance_s2.mean()))
    assert np.all(np.abs(np.mean(pulls, axis=0)) < 4 / np.sqrt(40))
    assert abs(np.mean(means)) < 4 / np.sqrt(40)
    assert np.std(pulls) == pytest.approx(1, abs=0.21)
    assert np.std(means) == pytest.approx(1, abs=0.28)


def test_degrees_of_freedom_are_frames_less_every_number_of_the_fit(recording):
    """Oracle: by hand; 4 delays, angle, memory, bow, covered level, step, skew, plate, blades, beside, one straight drift."""
    share = _sums() + np.random.default_rng(3).normal(0, 1e-3, 1000)
    fit = pixel_sums.fit(recording(share), _model())
    assert fit.levels.n_numbers == 1
    assert fit.degrees_of_freedom == fit.kept.sum() - 7 - 2 - 4 - 1
    assert fit.noise**2 * fit.degrees_of_freedom == pytest.approx(float(fit.residual @ fit.residual))


def test_correlated_residuals_widen_the_uncertainty(recording):
    """Oracle: white noise of the same size; a ripple along the wheel angle has far fewer independent values."""
    share = _sums()
    angle = np.mod(_uniform((_triggers() - START) / CLOCK_HZ), TURN)
    rng = np.random.default_rng(8)
    white = pixel_sums.fit(recording(share + rng.normal(0, 1e-3, 1000)), _model())
    ripple = share + np.sqrt(2) * 1e-3 * np.sin(20 * angle) + rng.normal(0, 1e-5, 1000)
    widened = pixel_sums.fit(recording(ripple), _model())
    assert white.variance_inflation < 1.5
    assert widened.variance_inflation > 4
    ratio = np.diag(widened.covariance_s2) / np.diag(white.covariance_s2)
    np.testing.assert_allclose(ratio, widened.variance_inflation / white.variance_inflation, rtol=0.3)


def test_frames_at_the_ends_of_the_track_are_left_out(recording):
    """Oracle: by hand; the delay is sought over a quarter turn either way, 83 ms, so three frames at an end go."""
    reduced = recording(_sums())
    short = reduced.track.edge_ticks < _triggers()[-1] + 0.02 * CLOCK_HZ
    track = replace(
        reduced.track, edge_ticks=reduced.track.edge_ticks[short], edge_angle_rad=reduced.track.edge_angle_rad[short]
    )
    fit = pixel_sums.fit(replace(reduced, track=track), _model())
    assert fit.n_dropped == 2
    np.testing.assert_allclose(fit.edge_delay_s, DELAY, atol=1e-9)


def test_frames_of_another_wheel_are_refused(recording):
    """Oracle: by hand; sums of a wheel at 2.9 Hz do not follow the timestamps of one at 3 Hz."""
    other = _sums(theta=lambda t: TURN * 2.9 * t)
    with pytest.raises(EstimationError, match="do not follow the wheel|differ from the model|no opening"):
        pixel_sums.fit(recording(other), _model())


def test_an_opening_that_is_far_wider_than_stated_is_refused(recording):
    """Oracle: by hand; sums of an opening of 75 deg, of which rig.toml says a seventh: by so much no fit is off."""
    narrow = wheel_model(EDGES, GATE, opening_angle_rad=GAMMA / 7, centre_angle_rad=CENTRE)
    with pytest.raises(EstimationError, match=r"fitted opening angle 6\d.* deg, rig.toml says 10.71 deg"):
        pixel_sums.fit(recording(_sums(n=400, instants=30)), narrow)


def test_too_many_wild_frames_are_refused(recording):
    """Oracle: the limit of 5 %; a tenth of the frames is wrong."""
    share = _sums() + np.random.default_rng(1).normal(0, 1e-4, 1000)
    share[::10] += 0.3
    with pytest.raises(EstimationError, match=r"10\d of 1000 frames differ from their neighbours .* check rig.toml"):
        pixel_sums.fit(recording(share), _model())


def test_too_short_recording_is_refused(recording):
    """Oracle: by hand; 90 frames are fewer than 100."""
    with pytest.raises(EstimationError, match="90 frames lie a quarter turn inside the recorded wheel, at least 100"):
        pixel_sums.fit(recording(_sums(n=90)), _model())


def test_levels_that_sway_are_shares_of_the_step_whatever_it_was_taken_for(recording):
    """Oracle: the curve that was put in, 3 % of the step; the step is first taken for half of what it is."""
    share = _sums(n=400)
    offset = 0.03 * np.cos(2 * np.pi * np.arange(400) / 400)
    reduced = recording(share + offset + np.random.default_rng(2).normal(0, 1e-4, 400))
    given = replace(pixel_sums.pixel_sums(reduced, _model()), unit_dn=1e6)
    numbers = dict.fromkeys(EDGE_DELAYS, DELAY + WINDOW / 2) | dict.fromkeys(SHAPE, 0.0)
    found, _ = pixel_sums._levelled(given, numbers | {"opening_angle": GAMMA, "integration_time": WINDOW})
    np.testing.assert_allclose(found.levels.relative_offset, offset - offset.mean(), atol=3e-4)
    assert found.levels.step_dn == pytest.approx(2e6, rel=1e-3)
    assert found.levels.sway == pytest.approx(0.06, rel=0.02)


@pytest.mark.parametrize("endless", [{pixel_sums.MEMORY}, {pixel_sums.BOW}, {pixel_sums.MEMORY, pixel_sums.BOW}])
def test_what_would_grow_beyond_all_of_the_light_is_held_at_none(endless):
    """Oracle: by hand: residuals that fall as a number grows, exp(-x); all others have their least where they were put."""
    target = dict.fromkeys(EDGE_DELAYS, 0.3) | {"opening_angle": 1.2, pixel_sums.MEMORY: 0.1, pixel_sums.BOW: -0.2}
    start = dict.fromkeys(EDGE_DELAYS, 0.0) | dict.fromkeys(SHAPE, 0.0)

    def at(numbers):
        fall = {
            name: np.exp(-numbers[name]) if name in endless else numbers[name] - target.get(name, 0.0)
            for name in numbers
        }
        slopes = [-fall[name] if name in endless else 1.0 for name in numbers]
        return Linearised(residual=np.array([*fall.values(), 1.0]), jacobian=np.diag([*slopes, 0.0])[:, :-1])

    given = SimpleNamespace(at=at, reduced=SimpleNamespace(integration_time_s=1e-3))
    found = pixel_sums._solved_from(given, start)
    expected = start | {name: 0.0 if name in endless else value for name, value in target.items()}
    assert found == pytest.approx(expected, abs=1e-6)


def test_frames_that_show_mostly_the_one_before_are_those_of_the_trigger_before(recording):
    """Oracle: delay that made the sums, of which a share of -3 % is of the frame before.

    Such frames are nearly those of a camera that is a trigger later and keeps 97 %: a search that begins there would stay.
    """
    period_s = (_triggers()[1] - _triggers()[0]) / CLOCK_HZ
    share = 1.03 * _sums() - 0.03 * _sums(delay=DELAY - period_s)
    given = pixel_sums.pixel_sums(recording(share, integration_time_s=WINDOW), _model())
    start = dict.fromkeys(EDGE_DELAYS, DELAY + WINDOW / 2) | dict.fromkeys(SHAPE, 0.0)
    start = start | {"opening_angle": GAMMA, "integration_time": WINDOW}
    later = start | dict.fromkeys(EDGE_DELAYS, DELAY + WINDOW / 2 + period_s) | {pixel_sums.MEMORY: 0.97}
    stays = optimiser.minimise(given.at, start=later, held=[n for n in SHAPE if n not in pixel_sums._OWN_SHAPE]).values
    assert stays[pixel_sums.MEMORY] > 0.9
    found = pixel_sums._solved_from(given, later)
    assert found[pixel_sums.MEMORY] == pytest.approx(-0.03, abs=1e-4)
    np.testing.assert_allclose([found[name] for name in EDGE_DELAYS], DELAY + WINDOW / 2, atol=1e-8)


@pytest.mark.parametrize("mirrored_first", [False, True])
def test_a_narrow_opening_behind_a_long_window_is_not_taken_for_a_wide_one_behind_a_short(recording, mirrored_first):
    """Oracle: opening and window that made the sums; with both angles swapped, the sums are the same."""
    given = pixel_sums.pixel_sums(recording(_sums(), integration_time_s=None), _model())
    middle = dict.fromkeys(EDGE_DELAYS, DELAY + WINDOW / 2) | dict.fromkeys(SHAPE, 0.0)
    true = middle | {"opening_angle": 1.02 * GAMMA, "integration_time": 1.1 * WINDOW}
    swapped = middle | {"opening_angle": 1.02 * OMEGA * WINDOW, "integration_time": GAMMA / OMEGA}
    found = pixel_sums._solved(given, *((swapped, true) if mirrored_first else (true, swapped)))
    assert found["opening_angle"] == pytest.approx(GAMMA, rel=1e-4)
    assert found["integration_time"] == pytest.approx(WINDOW, rel=1e-2)
    with pytest.raises(EstimationError, match="do not follow the wheel: fitted opening angle"):
        pixel_sums._solved(given, swapped)
