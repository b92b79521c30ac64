"""What causes of structured residuals add to the sums: by brute force over a wave of the wheel."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import causes
from irtiming.estimate.frame_residuals import FrameResiduals

_OMEGA, TURN = 20.0, 2 * np.pi


@pytest.fixture
def frames():
    """Frames at 720 angles of a wheel whose light is a wave of the second and one of the sixth order."""
    angle = 2 * np.pi * np.arange(720) / 720
    return FrameResiduals(
        name="x", omega_rad_per_s=_OMEGA, angle_rad=angle, time=np.linspace(-1, 1, 720), number=np.arange(720),
        fraction=_light(angle)[:, None], residual=np.zeros((720, 1)), row=np.zeros(1), noise=np.ones(1),
    )  # fmt: skip


def _light(angle):
    return 0.5 + 0.3 * np.cos(2 * angle) - 0.1 * np.cos(6 * angle)


def _columns(words, frames):
    (found,) = [one for one in causes.CANDIDATES if words in one.name]
    return found.columns(frames)


def test_a_halo_is_a_mean_over_a_gaussian(frames):
    """Oracle: a sum over a dense normal distribution of the angle, of 0.02, 0.05 and 0.15 rad, less the light itself."""
    off = np.linspace(-6, 6, 601)
    weight = np.exp(-0.5 * off**2) / np.sum(np.exp(-0.5 * off**2))
    for found, width in zip(_columns("blur or glare", frames), (0.02, 0.05, 0.15), strict=True):
        expected = _light(frames.angle_rad[:, None] + width * off) @ weight - _light(frames.angle_rad)
        np.testing.assert_allclose(found[:, 0], expected, atol=0.02 * np.ptp(expected))


def test_tails_are_what_comes_later(frames):
    """Oracle: a sum over an exponential of times, of 0.3, 1 and 3 ms, of the light then, less the light itself."""
    places = -np.log1p(-(np.arange(20_000) + 0.5) / 20_000)
    for found, tail_s in zip(causes._tails(frames), (0.3e-3, 1e-3, 3e-3), strict=True):
        later = np.array([_light(angle - _OMEGA * tail_s * places).mean() for angle in frames.angle_rad[:60]])
        expected = later - _light(frames.angle_rad[:60])
        np.testing.assert_allclose(found[:60, 0], expected, atol=2e-3 * np.ptp(found))


def test_once_a_turn_is_a_wave_of_the_first_order_at_any_phase(frames):
    """Oracle: a sine of the wheel angle that is late by 0.7 rad, of which both columns together explain all."""
    columns = np.stack([one[:, 0] for one in causes._once_a_turn(frames)], axis=1)
    wave = np.sin(frames.angle_rad - 0.7)
    amounts = np.linalg.lstsq(columns, wave, rcond=None)[0]
    np.testing.assert_allclose(columns @ amounts, wave, atol=1e-12)


def test_a_longer_window_bends_the_light_over_time(frames):
    """Oracle: the light's own mean over a window that is longer by 0.4 ms at both ends, less that over the window: its shape."""
    found = causes.fitted(frames, lag_s=None)["window"][:, 0]
    long, short = (
        _light(frames.angle_rad[:, None] + _OMEGA * np.linspace(-half_s, half_s, 2001)).mean(axis=1)
        for half_s in (6e-4, 2e-4)
    )
    assert np.corrcoef(found, long - short)[0, 1] > 0.99


def test_blades_and_cutouts_change_where_neither_is_seen(frames):
    """Oracle: by hand; open at 0.4 rad and half a turn on: blades change there, cutouts a quarter turn later."""
    turned = replace(frames, fraction=_light(frames.angle_rad - 0.4)[:, None])
    share, after = turned.fraction[:, 0], np.mod(frames.angle_rad - 0.4, 2 * np.pi)
    (blades,), (cutouts,) = causes._blades(turned), causes._cutouts(turned)
    np.testing.assert_array_equal(blades[:, 0], (1 - share) * np.where(after < np.pi, 1, -1))
    np.testing.assert_array_equal(cutouts[:, 0], share * np.where(np.abs(after - np.pi) > np.pi / 2, 1, -1))


def test_a_response_that_is_not_linear_bends_most_in_the_middle(frames):
    """Oracle: by hand; nothing at both ends, a quarter where half of the opening is seen, of one sign on both edges."""
    steps = replace(frames, fraction=np.tile([0.0, 0.5, 1.0, 0.5], 180)[:, None])
    (found,) = causes._not_linear(steps)
    np.testing.assert_array_equal(found[:4, 0], [0.0, 0.25, 0.0, 0.25])


def test_a_wheel_whose_slots_err_once_a_turn_is_seen_elsewhere(frames):
    """Oracle: the light itself a little further along and behind, by a cosine and by a sine of the wheel angle."""
    small = 1e-4
    for found, wave in zip(causes._speed_once_a_turn(frames), (np.cos, np.sin), strict=True):
        off = small * wave(frames.angle_rad)
        expected = (_light(frames.angle_rad + off) - _light(frames.angle_rad - off)) / (2 * small)
        np.testing.assert_allclose(found[:, 0], expected, atol=0.01 * np.ptp(expected))


def test_a_row_delay_shows_bands_of_rows_later_the_lower_they_are(frames):
    """Oracle: the light itself a little later and earlier, by the place of each band; the middle one stays as it is."""
    bands, small_s = replace(frames, fraction=np.tile(frames.fraction, 3), row=np.array([-1.0, 0.0, 0.5])), 1e-6
    angle, later = frames.angle_rad[:, None], _OMEGA * small_s * bands.row
    expected = (_light(angle + later) - _light(angle - later)) / (2 * small_s)
    found = causes.fitted(bands, lag_s=8e-3)["row delay"]
    np.testing.assert_allclose(found, expected, atol=0.01 * np.ptp(expected))


def test_what_sways_does_so_in_each_band_of_rows(frames):
    """Oracle: by hand; the polynomials of Legendre of the orders 2 to 5 at the end, 1, and of order 2 in the middle, -1/2."""
    bands = replace(frames, fraction=np.tile(frames.fraction, 3), time=np.append(np.linspace(-1, 1, 719), 0.0))
    found = causes._level_sways(bands)
    assert [one.shape for one in found] == [(720, 3)] * 4
    np.testing.assert_allclose([one[-2] for one in found], 1.0)
    np.testing.assert_allclose(found[0][-1], -0.5)


def test_a_gain_sways_about_its_mean_by_orders_one_to_four(frames):
    """Oracle: by hand; at the end Legendre's polynomials are 1, so that the light's own swing is left, at the beginning +-1."""
    found, swing = causes._gain_sways(frames), frames.fraction - frames.fraction.mean()
    assert len(found) == 4
    np.testing.assert_allclose([one[-1] for one in found], [swing[-1]] * 4)
    np.testing.assert_allclose([one[0] for one in found], [-swing[0], swing[0]] * 2)


def test_on_the_border_of_both_halves_of_a_turn_neither_counts():
    """Oracle: by hand; an eighth of a turn before the middle of the plateau, at it, and a quarter before, between both."""
    frames = SimpleNamespace(
        fraction=np.full((3, 1), 0.6), angle_rad=np.array([TURN / 8, TURN / 4, 0.0]), open_at_rad=TURN / 4
    )
    np.testing.assert_array_equal(causes._cutouts(frames)[0][:, 0], [0.6, 0.6, 0.0])


def test_levels_that_jump_stand_higher_after_each_place(frames):
    """Oracle: by hand; nothing before each eighth of the recording, one after it, in each band of rows."""
    two_bands = replace(frames, fraction=np.repeat(frames.fraction, 2, axis=1))
    found = _columns("jump", two_bands)
    assert len(found) == len(causes._JUMPS)
    for column, place in zip(found, causes._JUMPS, strict=True):
        n_before = np.count_nonzero(frames.time <= place)
        assert 0 < n_before < 720
        assert column.tolist() == [[0.0, 0.0]] * n_before + [[1.0, 1.0]] * (720 - n_before)


def test_rows_that_are_not_evenly_late_are_so_with_the_square_of_the_row(frames):
    """Oracle: by hand: a row that is read d late shows d times its slope over time, as does one whose falling sides lag."""
    rows = np.array([-1.0, 0.5, 2.0])
    three = replace(frames, fraction=np.tile(frames.fraction, 3), row=rows)
    slope = np.gradient(frames.fraction[:, 0], frames.angle_rad)[5:-5, None]
    for found, expected in zip(
        causes._rows_bend(three), (slope * rows**2, np.abs(slope) * rows, np.abs(slope) * rows**2), strict=True
    ):
        np.testing.assert_allclose(found[5:-5], expected, atol=5e-3 * np.ptp(expected))
