"""Opening fractions of rows, against noise-free frames and against curves written by hand."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.errors import ReductionError
from irtiming.physics.wheel_angle import wheel_angle_rad
from irtiming.records.choices import Choices
from irtiming.reduce import recipes
from irtiming.reduce.published import row_averages

TURN = 2 * np.pi


@pytest.fixture(scope="module")
def runs(rig, rolled, turning, paper_bolometer):
    """Three runs of one scene with their own noise."""
    camera = paper_bolometer()
    recordings = [rolled(camera.noisy(turning, seed=seed), name=f"run {seed}") for seed in range(3)]
    first = recipes.reduce(recordings[0], rig, choices=Choices())
    later = [recipes.reduce(one, rig, choices=Choices(), before=first.opening) for one in recordings[1:]]
    return [first, *later]


def _by_hand(run, curve_of, *, n_passes=1):
    """The run with all rows following one curve of the wheel angle, which is 1 where the opening is open."""
    angle = wheel_angle_rad(0.0, run.equal_track, at_ticks=run.trigger_ticks)
    pixels = run.opening.mask[run.rows.row_px].sum(axis=1)
    sums = np.outer(4950 - 950 * curve_of(angle), pixels)
    return replace(run, rows=replace(run.rows, mask_row_sum_dn=sums))


def _rounded(angle, *, high=1.0, low=0.0):
    """Twice a turn up and down with parabolic plateaus, the second ones a little higher."""
    wave = np.cos(2 * angle)
    return 0.5 + (wave + 0.1 * np.cos(4 * angle) + 0.02 * np.cos(angle)) / 2.2 * (high - low)


def test_fractions_are_those_of_the_noise_free_frames(runs, turning):
    """Oracle: sums over the noise-free frames, from their lowest to their highest value in each half turn, reversed."""
    data = row_averages.average(runs)
    theta = 1.0 + TURN * 3 * (0.35 + 0.033 * np.arange(1000))
    order = np.argsort(np.mod(theta, TURN))
    for rows, fraction in [(None, data.fraction), *zip(data.row_px, data.row_fraction, strict=True)]:
        mask = runs[0].opening.mask
        sums = (turning * mask).sum(axis=(1, 2)) if rows is None else (turning[:, rows] * mask[rows]).sum(axis=1)
        halves = [np.mod(theta, TURN) < np.pi, np.mod(theta, TURN) >= np.pi]
        low, high = (np.mean([extreme(sums[half]) for half in halves]) for extreme in (np.min, np.max))
        true = 1 - (sums[order] - low) / (high - low)
        found = np.interp(np.sort(np.mod(theta, TURN)), data.wheel_angle_rad, fraction, period=TURN)
        assert np.sqrt(np.mean((found - true) ** 2)) < (2e-3 if rows is None else 8e-3)


def test_rows_with_fewer_than_four_pixels_are_left_out(runs):
    """Oracle: the mask, row by row."""
    data = row_averages.average(runs)
    mask = runs[0].opening.mask
    assert data.row_px.tolist() == np.flatnonzero(mask.sum(axis=1) >= 4).tolist()
    assert np.array_equal(data.mask, mask)
    assert data.row_fraction.shape == (data.row_px.size, data.wheel_angle_rad.size)


def test_uncertainties_are_the_scatter_over_runs(runs, turning):
    """Oracle: noise of 5 DN over the pixels of a row and three runs, against what the row swings without noise."""
    data = row_averages.average(runs)
    mask = runs[0].opening.mask
    sums = (turning[:, data.row_px] * mask[data.row_px]).sum(axis=2)
    expected = 5.0 * np.sqrt(mask[data.row_px].sum(axis=1) / 3) / np.ptp(sums, axis=0)
    np.testing.assert_allclose(np.median(data.u_row_fraction, axis=1), expected, rtol=0.12)
    whole = 5.0 * np.sqrt(mask.sum() / 3) / np.ptp((turning * mask).sum(axis=(1, 2)))
    assert np.median(data.u_fraction) == pytest.approx(whole, rel=0.12)
    assert data.u_fraction.shape == data.fraction.shape
    single = row_averages.average(runs[:1])
    assert single.u_fraction is None
    assert single.u_row_fraction is None
    assert data.names == ("run 0", "run 1", "run 2")
    assert data.angular_frequency_rad_per_s == pytest.approx(TURN * 3, rel=1e-4)


@pytest.mark.parametrize("colder", [True, False])
def test_plateaus_are_normalised_to_zero_and_one_on_average(runs, colder):
    """Oracle: a curve written by hand, its two upper extrema averaging to 1, its two lower ones to 0; 1 is open."""
    run = _by_hand(runs[0], _rounded)
    if not colder:
        run = replace(
            run,
            rows=replace(run.rows, mask_row_sum_dn=-run.rows.mask_row_sum_dn),
            opening=replace(run.opening, blackbody_is_colder=False),
        )
    data = row_averages.average([run])
    grid = TURN * np.arange(20000) / 20000
    curve = _rounded(grid)
    quarter = np.mod(np.floor((grid + np.pi / 4) / (np.pi / 2)), 4)
    high = np.mean([curve[quarter == k].max() for k in (0, 2)])
    low = np.mean([curve[quarter == k].min() for k in (1, 3)])
    np.testing.assert_allclose(data.fraction, (_rounded(data.wheel_angle_rad) - low) / (high - low), atol=2e-4)
    np.testing.assert_allclose(data.row_fraction, np.tile(data.fraction, (data.row_px.size, 1)), atol=1e-9)


def test_noise_moves_the_extrema_by_less_than_itself(runs):
    """Oracle: the curve without noise; the highest of fifty noisy points would lie two standard deviations too high."""
    rng, noise = np.random.default_rng(4), 0.01
    clean = row_averages.average([_by_hand(runs[0], _rounded)])
    bias = []
    for _ in range(10):
        noisy = _by_hand(runs[0], lambda angle: _rounded(angle) + rng.normal(0, noise, angle.size))
        data = row_averages.average([noisy])
        bias.append(np.ptp(clean.fraction) / np.polyfit(clean.fraction, data.fraction, 1)[0] - np.ptp(clean.fraction))
    assert np.mean(bias) < 2 * noise


def test_angles_are_those_at_the_trigger_with_equal_slots(runs):
    """Oracle: the equal track itself, without the set delay."""
    run = replace(runs[0], trigger_delay_time_set_s=0.02)
    data = row_averages.average([run])
    angle = np.sort(np.mod(wheel_angle_rad(0.0, run.equal_track, at_ticks=run.trigger_ticks), TURN))
    np.testing.assert_allclose(data.wheel_angle_rad, angle, atol=1e-9)
    assert data.trigger_delay_time_set_s == 0.02
    assert data.angular_frequency_rad_per_s == pytest.approx(TURN * 3, rel=1e-6)


def test_a_row_without_plateaus_is_left_out_and_a_whole_without_is_refused(runs):
    """Oracle: by hand; one row that stands still, then all of them turning once a turn."""
    run = _by_hand(runs[0], _rounded)
    sums = run.rows.mask_row_sum_dn.copy()
    dull = int(np.flatnonzero(run.rows.row_px == row_averages.average([run]).row_px[5])[0])
    sums[:, dull] = np.random.default_rng(0).normal(0, 1, len(sums))
    data = row_averages.average([replace(run, rows=replace(run.rows, mask_row_sum_dn=sums))])
    assert run.rows.row_px[dull] not in data.row_px
    with pytest.raises(ReductionError, match="has not two upper and two lower plateaus"):
        row_averages.average([_by_hand(runs[0], np.cos)])


def test_runs_without_a_common_row_are_refused(runs):
    """Oracle: by hand; the second run's rows renumbered away."""
    few = runs[1].rows
    few = replace(few, row_px=few.row_px[:2], mask_row_sum_dn=few.mask_row_sum_dn[:, :2])
    moved = replace(runs[1], rows=few)
    with pytest.raises(ReductionError, match="no image row holds 4 pixels"):
        row_averages.average([runs[0], moved])
