"""How many numbers drifting levels need: values that were made with known curves and jumps."""

import numpy as np
import pytest

from irtiming.inference import drifting_levels

N = 1000
ANGLE = 2 * np.pi * 0.099 * np.arange(N)
MOVING = np.clip(0.5 + 0.8 * np.cos(2 * ANGLE), 0, 1)
BLADES = np.sin(ANGLE)
PLACE = np.arange(N) / (N - 1)
WAVE = np.sin(2 * np.pi * 1.3 * PLACE)
NOISE = 1e-4


def _chosen(offset, gain, seed=0):
    values = offset + gain * MOVING + 0.01 * BLADES + np.random.default_rng(seed).normal(0, NOISE, N)
    return drifting_levels.choose(values, MOVING, shapes=BLADES[:, None], place=PLACE)


def test_levels_along_a_straight_line_ask_for_no_more():
    """Oracle: by hand: one number, the slope, in 20 of 20 draws of noise; no jump."""
    found = [_chosen(0.01 * PLACE, np.ones(N), seed=seed) for seed in range(20)]
    assert all(one.n_numbers == 1 and one.jumps == () for one in found)


@pytest.mark.parametrize(("offset", "gain"), [(0.03, 0.0), (0.0, 0.03), (0.03, -0.03)])
def test_smooth_curves_are_followed_to_the_noise(offset, gain):
    """Oracle: the curves that made the values, less their means; a spline of k numbers has the noise times root k / n."""
    found = _chosen(offset * WAVE, 1 + gain * WAVE)
    wave = WAVE - WAVE.mean()
    assert found.jumps == ()
    assert np.std(found.offset_change - offset * wave) < 3 * NOISE * np.sqrt(found.n_numbers / N) + 1e-5
    assert np.std(found.relative_gain * (1 + gain * WAVE.mean()) - 1 - gain * WAVE) < 1e-4
    assert found.drift.shape[1] > 5 if offset else found.drift.shape[1] == 1
    assert found.gain.shape[1] > 5 if gain else found.gain.shape[1] == 0


def test_jumps_of_offset_and_gain_are_found_where_they_are():
    """Oracle: the frames at which the levels jump, by ten times the noise."""
    later = (np.arange(N) >= 610).astype(float)
    found = _chosen(1e-3 * later, 1 + 1e-3 * (np.arange(N) >= 300))
    np.testing.assert_allclose(sorted(found.jumps), [300, 610], atol=8)


def test_a_jump_in_a_smooth_drift_is_no_bend():
    """Oracle: the frame at which the level jumps by 1 % while it sways by 3 %."""
    found = _chosen(0.03 * WAVE + 0.01 * (np.arange(N) >= 427), np.ones(N))
    assert found.jumps == (427,)


def test_a_jump_of_the_offset_beside_a_gain_that_drifts_asks_for_no_spline():
    """Oracle: by hand; the frame of the jump, and a straight line and a step each of offset and gain."""
    found = _chosen(0.01 * (np.arange(N) >= 427), 1 + 0.01 * PLACE)
    assert (found.jumps, found.n_offset, found.n_gain, found.n_numbers) == ((427,), 0, 0, 4)


def test_wild_values_bend_nothing():
    """Oracle: the same numbers as without the ten values that lie a third of the range off."""
    values = MOVING + np.random.default_rng(3).normal(0, NOISE, N)
    values[np.arange(50, N, 97)] += 0.3
    found = drifting_levels.choose(values, MOVING, shapes=BLADES[:, None], place=PLACE)
    assert (found.n_numbers, found.jumps) == (1, ())
    assert np.abs(found.offset_change).max() < 3e-5


def test_the_covariance_of_the_amounts_is_their_scatter():
    """Oracle: 800 draws of the noise about a line of the offset and a parabola of the gain, cubics both."""
    line = PLACE - PLACE.mean()
    random, found = np.random.default_rng(5), []
    for _ in range(800):
        values = (
            0.2 + 3 * (0.01 * line + (1 + 0.02 * (line**2 - np.mean(line**2))) * MOVING) + random.normal(0, NOISE, N)
        )
        given = drifting_levels._Fixed(values=values, moving=MOVING, shapes=np.zeros((N, 0)), place=PLACE)
        found.append(given.fitted(1, 1, jumps=()))
    columns = found[0].drift
    offsets, gains = (
        np.array([np.linalg.lstsq(columns, one, rcond=None)[0] for one in curves])
        for curves in ([one.offset_change / one.contrast for one in found], [one.relative_gain - 1 for one in found])
    )
    scatter = np.cov(np.concatenate([offsets, gains], axis=1).T)
    stated = np.mean([one.covariance for one in found], axis=0)
    np.testing.assert_allclose(np.sqrt(np.diag(stated)), np.sqrt(np.diag(scatter)), rtol=0.12)
    u = np.sqrt(np.diag(scatter))
    np.testing.assert_allclose(stated / np.outer(u, u), scatter / np.outer(u, u), atol=0.15)


def test_curves_that_stand_beside_a_result_leave_it_its_uncertainty():
    """Oracle: a law: were the curves of the levels true, errors of what looks like a drift, over their u, would scatter by 1.

    Levels are four random waves of 1 % at a noise of 0.03 %. With the curves that the criterion takes errors scatter by 2 u.
    """
    place = np.arange(400) / 400
    moving = (np.sin(2 * np.pi * 41.3 * place) > 0).astype(float)
    sought = np.cos(2 * np.pi * 2.6 * place + 1) * moving

    def error_over_u(seed, *, beside):
        random = np.random.default_rng(seed)
        periods, heights = 0.3 * 10 ** random.uniform(0, 1, 4), random.standard_normal(4)
        offset, gain = np.sin(2 * np.pi * (place[:, None] / periods + random.random((2, 1, 4)))) @ (periods * heights)
        values = (
            (1 + 0.01 * gain / np.ptp(gain)) * moving + 0.01 * offset / np.ptp(offset) + random.normal(0, 3e-4, 400)
        )
        found = drifting_levels.choose(values, moving, shapes=np.zeros((400, 0)), place=place, beside=beside)
        design = np.column_stack([sought, np.ones(400), moving, found.drift, found.gain * moving[:, None]])
        amounts = np.linalg.lstsq(design, values, rcond=None)[0]
        variance = np.sum((values - design @ amounts) ** 2) / (400 - design.shape[1])
        return amounts[0] / np.sqrt(np.linalg.pinv(design.T @ design)[0, 0] * variance)

    beside, best = (
        np.sqrt(np.mean([error_over_u(seed, beside=one) ** 2 for seed in range(n)]))
        for one, n in ((True, 24), (False, 12))
    )
    assert 0.68 < beside < 1.32  # 24 draws: 2.2 standard deviations
    assert best > 1.5
