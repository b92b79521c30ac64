"""Row sums of a camera whose levels sway, against the sway that was put in."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import row_sway
from irtiming.records.row_timing import Sway

N = 500
TICKS = 1_000_000 * np.arange(N)
TIME = np.arange(N) / N
PIXELS = np.linspace(1.2, 2.0, 8)


def _centred(curve):
    return curve - curve.mean(axis=0)


def _curve(size, phase=0.0):
    return _centred(size * (np.sin(2 * np.pi * 1.3 * TIME + phase) + 0.4 * np.cos(2 * np.pi * 3.1 * TIME)))


def _sway(gain, offset, *, n_looks=2):
    """Each as one curve."""
    return Sway(
        gains=gain[:, None],
        gain_amounts=np.ones(1),
        offsets=offset[:, None],
        offset_amounts=np.ones(1),
        covariance=np.zeros((2, 2)),
        n_looks=n_looks,
    )


def _fit(gain, offset, *, noise=2e-3, kept=None, before=None):
    """An earlier fit that knows the wheel and nothing of the sway, or that is rid of some of it."""
    random = np.random.default_rng(1)
    model = np.clip(0.5 + np.sin(0.622 * np.arange(N)[:, None] + np.linspace(0, 0.3, 8)), 0, 1)
    kept = np.ones(N, bool) if kept is None else kept
    left = ((1 + gain)[:, None] * model + offset[:, None] * PIXELS + noise * random.normal(size=model.shape))[kept]
    if before is not None:
        left -= ((before.relative_gain - 1)[:, None] * model + before.offset_change[:, None] * PIXELS)[kept]
    return SimpleNamespace(kept=kept, model=model[kept], noise=np.full(8, noise), sway=before, fraction=left)


def test_a_sway_is_found_to_the_noise():
    """Oracle: gain and offset that made the sums; eight rows of 450 frames know them to a twentieth of 2 %."""
    kept = np.random.default_rng(3).random(N) > 0.1
    found = row_sway.chosen(
        _fit(_curve(0.02), _curve(0.01, 1.0), kept=kept), trigger_ticks=TICKS, segment=np.zeros(N, int), pixels=PIXELS
    )
    assert np.sqrt(np.mean((found.relative_gain - 1 - _curve(0.02)) ** 2)) < 1e-3
    assert np.sqrt(np.mean((found.offset_change - _curve(0.01, 1.0)) ** 2)) < 1e-3
    assert found.n_looks == 1


def test_a_sway_that_is_fast_for_a_short_stretch_is_followed_where_noise_is_small():
    """Oracle: the gain that made the sums, 1 % up and down in 70 of 240 frames; a thirtieth of it is left."""
    stretch = np.arange(N) < 240
    gain = 0.01 * np.sin(2 * np.pi * np.arange(N) / 70 + 0.4) * stretch
    fit = _fit(gain, np.zeros(N), noise=3e-4, kept=stretch)
    found = row_sway.chosen(fit, trigger_ticks=TICKS, segment=np.where(stretch, 0, 1), pixels=PIXELS)
    left = _centred(found.relative_gain[stretch] - gain[stretch])
    assert np.sqrt(np.mean(left**2)) < 3e-4


def test_each_stretch_between_shutter_events_has_its_own():
    """Oracle: as above; the mean of a stretch is the fit's affair, and a stretch of few frames is left alone."""
    segment = np.repeat([0, 1, 2], [240, 240, 20])
    gain = _curve(0.02)
    for number in (0, 1, 2):
        gain[segment == number] -= gain[segment == number].mean()
    found = row_sway.chosen(_fit(gain, np.zeros(N)), trigger_ticks=TICKS, segment=segment, pixels=PIXELS)
    assert np.sqrt(np.mean((found.relative_gain - 1 - gain)[segment < 2] ** 2)) < 1e-3
    assert np.all(found.relative_gain[segment == 2] == 1)
    assert np.all(found.offset_change[segment == 2] == 0)


def test_the_second_look_sees_what_the_first_took_out():
    """Oracle: sums rid of half of a sway show the whole of it again; those looked at twice keep what they have."""
    half = _sway(_curve(0.01), _curve(0.005, 1.0), n_looks=1)
    fit = _fit(_curve(0.02), _curve(0.01, 1.0), before=half)
    found = row_sway.chosen(fit, trigger_ticks=TICKS, segment=np.zeros(N, int), pixels=PIXELS)
    assert np.sqrt(np.mean((found.relative_gain - 1 - _curve(0.02)) ** 2)) < 1e-3
    assert np.sqrt(np.mean((found.offset_change - _curve(0.01, 1.0)) ** 2)) < 1e-3
    fit.sway = found
    assert found.n_looks == 2
    assert row_sway.chosen(fit, trigger_ticks=TICKS, segment=np.zeros(N, int), pixels=PIXELS) is found


@pytest.mark.parametrize("contrast", [-700.0, 700.0])
def test_steadied_row_sums_are_those_of_steady_levels(contrast):
    """Oracle: the sums that steady levels would have made; levels and gains are the rows' own, in each stretch others."""
    model = _fit(np.zeros(N), np.zeros(N)).model
    stretches = [np.arange(N) < 230, np.arange(N) >= 230]
    step = np.where(stretches[0], 1.0, 1.3)[:, None]
    own, level = contrast * np.linspace(1, 2, 8) * step, (9e4 + 100 * np.arange(8)) * step
    gain, offset = _curve(0.03), _curve(0.02, 1.0)
    for part in stretches:
        gain[part], offset[part] = _centred(gain[part]), _centred(offset[part])
    steady = level + own * model
    sums = steady + own * (gain[:, None] * model + PIXELS * offset[:, None])
    found = row_sway.steadied(sums, model, sway=_sway(gain, offset), pixels=PIXELS, stretches=stretches)
    np.testing.assert_allclose(found, steady, atol=1e-6 * abs(contrast))
    assert np.max(np.abs(sums - found)) > 0.03 * abs(contrast)  # something was taken out


def test_a_stretch_of_a_single_frame_stays():
    """Oracle: by hand; one frame shows neither gain nor level."""
    sums, model = np.full((N, 8), 9e4), _fit(np.zeros(N), np.zeros(N)).model
    stretches = [np.arange(N) < N - 1, np.arange(N) == N - 1]
    found = row_sway.steadied(sums, model, sway=_sway(np.zeros(N), np.zeros(N)), pixels=PIXELS, stretches=stretches)
    assert np.array_equal(found, sums)


def test_columns_are_what_an_amount_does_beside_gain_and_offset_of_a_row():
    """Oracle: residuals of a regression on one and the model, row by row and stretch by stretch."""
    model = _fit(np.zeros(N), np.zeros(N)).model
    sway, stretches = _sway(_curve(1.0), _curve(1.0, 1.0)), [np.arange(N) < 230, np.arange(N) >= 230]
    found = row_sway.columns(sway, model, pixels=PIXELS, stretches=stretches)
    effects = (sway.offsets[:, 0][:, None] * PIXELS, sway.gains[:, 0][:, None] * model)
    for column, effect in zip(found, effects, strict=True):
        for part in stretches:
            for row in range(8):
                beside = np.stack([np.ones(part.sum()), model[part, row]], axis=1)
                left = effect[part, row] - beside @ np.linalg.lstsq(beside, effect[part, row], rcond=None)[0]
                np.testing.assert_allclose(column[part, row], left, atol=1e-10)


def test_a_short_stretch_sways_as_well():
    """Oracle: gain that made the sums, a straight line over 60 frames; eight rows know its ends to a tenth of 2 %."""
    segment = np.repeat([0, 1], [440, 60])
    gain = np.zeros(N)
    gain[segment == 1] = np.linspace(-0.02, 0.02, 60)
    found = row_sway.chosen(_fit(gain, np.zeros(N)), trigger_ticks=TICKS, segment=segment, pixels=PIXELS)
    assert np.sqrt(np.mean((found.relative_gain - 1 - gain)[segment == 1] ** 2)) < 2e-3


def test_an_offset_that_goes_as_the_gain_is_the_rows_own():
    """Oracle: by hand; pixels times the gain's curve lie in the span of light, level and the gain's curve of each row."""
    model = _fit(np.zeros(N), np.zeros(N)).model
    curve, stretches = _curve(0.02), [np.ones(N, bool)]
    same, other = _sway(curve, 3 * curve), _sway(curve, _curve(0.02, 1.0))
    for sway, is_spanned in ((same, True), (other, False)):
        own = row_sway.own_columns(sway, model, stretches=stretches)
        shared = row_sway.columns(sway, model, pixels=PIXELS, stretches=stretches)
        left = row_sway.beside_own(own, shared, stretches=stretches)
        assert np.all(left[0] == 0) == is_spanned  # the offset's column
        assert np.any(left[1] != 0)  # the gain's own light stays


@pytest.mark.parametrize("follows", [1.0, 2.0, 3.5])
def test_amounts_that_go_to_and_fro_come_to_rest(follows):
    """Oracle: amounts to be found, 1 and -2; a step is ``follows`` times what it should be, since all else follows the sway.

    With 0.7 of each step, as at first, a step that is 3.5 times too large would make the next one 1.45 times as large.
    """
    sway, wanted = _sway(_curve(0.02), _curve(0.01)), np.array([1.0, -2.0])
    covariance = np.diag([1.0, 4.0])
    for _ in range(30):
        amounts = np.concatenate([sway.offset_amounts, sway.gain_amounts])
        sway = row_sway.improved(sway, follows * (wanted - amounts), covariance=covariance)
    np.testing.assert_allclose([*sway.offset_amounts, *sway.gain_amounts], wanted, atol=1e-6)
    assert np.array_equal(sway.covariance, covariance)


@pytest.mark.parametrize(("variances", "damping"), [((1.0, 100.0), 0.35), ((1.0, 1.0), 0.7), ((100.0, 1.0), 0.7)])
def test_what_turns_back_counts_by_its_uncertainty(variances, damping):
    """Oracle: by hand: after (1, 1) a step of (-1, 0.9) goes back where the first amount is the well known one."""
    sway = replace(_sway(_curve(0.02), _curve(0.01)), step=np.array([1.0, 1.0]))
    found = row_sway.improved(sway, np.array([-1.0, 0.9]), covariance=np.diag(variances))
    assert found.damping == pytest.approx(damping)
    assert [*found.offset_amounts, *found.gain_amounts] == pytest.approx([1 - damping, 1 + 0.9 * damping])


def test_what_is_not_known_of_a_sway_begins_at_nothing_for_all_its_amounts():
    """Oracle: by hand; one number for each pair of amounts, those of the offset and those of the gain."""
    found = row_sway.chosen(
        _fit(_curve(0.02), _curve(0.01, 1.0)), trigger_ticks=TICKS, segment=np.zeros(N, int), pixels=PIXELS
    )
    assert found.offset_amounts.size > 0 < found.gain_amounts.size
    n = found.offsets.shape[1] + found.gains.shape[1]
    assert found.covariance.tolist() == np.zeros((n, n)).tolist()
